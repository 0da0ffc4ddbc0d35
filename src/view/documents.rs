//! Snapshots as documents, made once for all clients that request the same.
//!
//! In: a snapshot, a format. Out: the bytes of the document, shared.
//!
//! Invariants: a document is held as long as a client is sent it, and charged as long. Of those that are being sent,
//! some are known; they are found by the identity of their snapshot.
//!
//! Must not know: clients, how long sending takes.

use std::collections::VecDeque;
use std::sync::{Arc, Weak};

use hopes_protocol::Message;

use super::flat::laid_out;
use super::snapshot::{Format, FormatError};
use crate::daemon::{Account, Charged, Level, Lock};

/// Documents that are known at one time at the most.
const MOST: usize = 16;

/// Documents that clients are being sent.
#[derive(Debug)]
pub struct Documents {
    known: Lock<VecDeque<Known>>,
    account: Arc<Account>,
}

#[derive(Debug)]
struct Known {
    /// Held weakly, so that no other snapshot has its address.
    snapshot: Weak<Charged<Message>>,
    format: Format,
    document: Weak<Charged<Vec<u8>>>,
}

impl Documents {
    /// No documents. Those to come are charged to an account.
    pub fn new(account: Arc<Account>) -> Self {
        Self { known: Lock::new(Level::Leaf, VecDeque::new()), account }
    }

    /// The document of a snapshot of a stream.
    ///
    /// # Errors
    /// [`FormatError`].
    pub fn get(
        &self,
        name: &str,
        snapshot: Arc<Charged<Message>>,
        format: Format,
    ) -> Result<Arc<Charged<Vec<u8>>>, FormatError> {
        if let Some(document) = self.find(&snapshot, format) {
            return Ok(document);
        }
        let bytes = match &**snapshot {
            // A picture of a space shows its principal components.
            Message::SpaceSnapshot(space) if format == Format::Svg => format.write(name, &laid_out(space).into())?,
            snapshot => format.write(name, snapshot)?,
        };
        let length = bytes.capacity();
        let document = Arc::new(Charged::new(bytes, length, &self.account));
        let mut known = self.known.lock();
        known.retain(|known| known.document.strong_count() > 0);
        known.truncate(MOST - 1);
        let (of_snapshot, of_document) = (Arc::downgrade(&snapshot), Arc::downgrade(&document));
        known.push_front(Known { snapshot: of_snapshot, format, document: of_document });
        Ok(document)
    }

    fn find(&self, snapshot: &Arc<Charged<Message>>, format: Format) -> Option<Arc<Charged<Vec<u8>>>> {
        let known = self.known.lock();
        let is_same = |known: &&Known| known.format == format && known.snapshot.as_ptr() == Arc::as_ptr(snapshot);
        known.iter().filter(is_same).find_map(|known| known.document.upgrade())
    }
}
