//! The protocol's messages about one stream as server-sent events.
//!
//! In: the protocol's bytes from the daemon. Out: the head of a response, then events; answers to the daemon.
//! Invariants: the data of a frame is the JSON line of `hopes watch`; as a whole frame, the line of a change from
//! frame 0. A frame is proved by its checksum before it is written as a whole. A gap is always told (`lagged`), and so
//! is the end. A client that cannot be served gets a response that says why.
//! Must not know: sockets.

use std::io::{self, Write};
use std::sync::Arc;

use hopes_protocol::{
    AnyMirror, Banner, Decoder, ErrorCode, LARGEST_FRAME, Lagged, Message, Pong, Report, Resume, Snapshot,
    SpaceSnapshot, StreamClosed,
};
use serde::Serialize;

use super::speaker::{Answers, encoded};
use super::{FramesRequest, LastId, MEDIA_TYPE};
use crate::daemon::{Account, Charge};
use crate::formats::messages::as_json;
use crate::view::http::{Refusal, Response, endless};

/// Bytes that a mirror takes for a vertex of the plane, an edge and a critical edge, about.
const OF_MIRROR: [usize; 3] = [48, 32, 64];

/// What is sent of the response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    Nothing,
    /// The head: events may follow.
    Head,
    /// The stream's end.
    End,
    /// The last words.
    All,
}

/// Writes events.
#[derive(Debug)]
pub struct Translator {
    name: String,
    decoder: Decoder,
    has_banner: bool,
    epoch: u64,
    sent: Sent,
    /// What a whole frame is made of, if these are wanted.
    whole: Option<AnyMirror>,
    /// What the client has of before, until the first frame.
    last: Option<Resume>,
    goodbye: Option<String>,
    charge: Charge,
}

/// Why nothing more comes.
#[derive(Serialize)]
struct EndLine<'a> {
    stream: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<u64>,
    reason: &'a str,
}

impl Translator {
    /// Nothing is written yet. What is held is charged to an account.
    pub fn new(request: FramesRequest, account: &Arc<Account>) -> Self {
        let FramesRequest { name, changes, last, .. } = request;
        Self {
            name,
            decoder: Decoder::new(LARGEST_FRAME),
            has_banner: false,
            epoch: 0,
            sent: Sent::Nothing,
            whole: (!changes).then(AnyMirror::default),
            last,
            goodbye: None,
            charge: account.charge(0),
        }
    }

    /// Takes bytes of the daemon, and writes what they say.
    ///
    /// # Errors
    /// Those of the output; or the daemon has broken its own protocol.
    pub fn take(&mut self, bytes: &[u8], output: &mut impl Write) -> io::Result<Answers> {
        self.decoder.push(bytes);
        self.hold(0);
        let mut answers = Answers::default();
        if !self.has_banner {
            let Some(theirs) = self.decoder.banner().map_err(io::Error::other)? else { return Ok(answers) };
            self.has_banner = true;
            // The same program is on both sides. It may still refuse in the lowest version, so none is set.
            Banner::OURS.agree(theirs).map_err(io::Error::other)?;
        }
        while let Some(frame) = self.decoder.frame().map_err(io::Error::other)? {
            // The frame, and the message in memory.
            self.hold(3 * frame.body.len());
            let message = frame.message().map_err(io::Error::other)?;
            drop(frame);
            self.translate(message, &mut answers, output)?;
        }
        self.hold(0);
        Ok(answers)
    }

    /// Charges what is held, and so many bytes besides.
    fn hold(&mut self, besides: usize) {
        let mirror = self.whole.as_ref().map_or(0, |mirror| {
            let (counts, dimension) = mirror.sizes();
            let of_coordinates = counts[0] * size_of::<f64>() * dimension.saturating_sub(2);
            of_coordinates + counts.iter().zip(OF_MIRROR).map(|(count, bytes)| count * bytes).sum::<usize>()
        });
        self.charge.set((self.decoder.capacity() + mirror + besides) as u64);
    }

    fn translate(&mut self, message: Message, answers: &mut Answers, output: &mut impl Write) -> io::Result<()> {
        match message {
            Message::StreamOpened(opened) => {
                self.epoch = opened.epoch;
                self.begin(output)
            }
            message if message.frame().is_some() && self.sent == Sent::Head => self.frame(message, output),
            Message::Lagged(lagged) if self.sent == Sent::Head => self.event("lagged", &lagged.into(), output),
            Message::Heartbeat(_) => self.comment(output),
            Message::Ping(ping) => {
                answers.bytes.extend(encoded(0, Pong { token: ping.token }.into()));
                self.comment(output)
            }
            Message::StreamClosed(StreamClosed { frame, reason, .. }) if self.sent == Sent::Head => {
                answers.is_over = true;
                self.sent = Sent::End;
                self.end("end", Some(frame), &reason, output)
            }
            Message::Error(report) => {
                answers.is_over = true;
                self.fail(&report, output)
            }
            Message::Goodbye(goodbye) => {
                self.goodbye = Some(goodbye.reason);
                Ok(())
            }
            // A client that resumes is sent what follows; all else was not asked for.
            _ => Ok(()),
        }
    }

    /// Writes the head of the response.
    fn begin(&mut self, output: &mut impl Write) -> io::Result<()> {
        if self.sent == Sent::Nothing {
            self.sent = Sent::Head;
            output.write_all(&endless(MEDIA_TYPE))?;
        }
        Ok(())
    }

    fn frame(&mut self, message: Message, output: &mut impl Write) -> io::Result<()> {
        let Some(mut mirror) = self.whole.take() else {
            self.last = None;
            return self.event("frame", &message, output);
        };
        let stream = message.stream().unwrap_or_default();
        mirror.apply(&message).map_err(io::Error::other)?;
        let whole = if is_snapshot(&message) { Some(message) } else { mirror.snapshot(stream) };
        let first = whole.ok_or_else(|| io::Error::other("a mirror has lost its frame"))?;
        let number = mirror.number();
        self.whole = Some(mirror);
        self.hold(bytes_of(&first));
        let last = self.last.take().filter(|last| last.epoch == self.epoch && last.frame <= number);
        if let Some(last) = last {
            let missed = Lagged { stream, first: last.frame + 1, last: number - 1 };
            if last.frame == number {
                return Ok(());
            } else if missed.first <= missed.last {
                self.event("lagged", &missed.into(), output)?;
            }
        }
        self.event("frame", &first, output)
    }

    /// Writes an event whose data is a message's JSON line.
    fn event(&self, event: &str, message: &Message, output: &mut impl Write) -> io::Result<()> {
        let frame = message.frame().map(|frame| frame.number);
        writeln!(output, "event: {event}")?;
        if let Some(frame) = frame {
            writeln!(output, "id: {}", LastId::new(frame, self.epoch))?;
        }
        output.write_all(b"data: ")?;
        as_json(output, &self.name, message)?;
        output.write_all(b"\n")
    }

    /// Writes an event that says that nothing more comes.
    fn end(&self, event: &str, frame: Option<u64>, reason: &str, output: &mut impl Write) -> io::Result<()> {
        let line = serde_json::to_string(&EndLine { stream: &self.name, frame, reason })?;
        write!(output, "event: {event}\ndata: {line}\n\n")
    }

    /// Writes something that clients skip, so that they, and proxies, know that the daemon is there.
    fn comment(&mut self, output: &mut impl Write) -> io::Result<()> {
        self.begin(output)?;
        if self.sent == Sent::Head { output.write_all(b":\n\n") } else { Ok(()) }
    }

    /// The daemon refuses, or cannot go on.
    fn fail(&mut self, report: &Report, output: &mut impl Write) -> io::Result<()> {
        let before = std::mem::replace(&mut self.sent, Sent::All);
        match before {
            Sent::Nothing => {
                let status = if report.code == ErrorCode::BadOptions as u16 { 400 } else { 503 };
                refuse(status, &report.text, output)
            }
            Sent::Head => self.end("goodbye", None, &report.text, output),
            Sent::End | Sent::All => Ok(()),
        }
    }

    /// Writes the last words: the daemon's goodbye, unless the stream's end has said that nothing more comes.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(&mut self, is_daemons_end: bool, output: &mut impl Write) -> io::Result<()> {
        let before = std::mem::replace(&mut self.sent, Sent::All);
        let reason = self.goodbye.take().unwrap_or_else(|| "the connection has ended".to_owned());
        match before {
            Sent::Nothing => refuse(503, &reason, output),
            Sent::End if !is_daemons_end => Ok(()),
            Sent::Head | Sent::End => self.end("goodbye", None, &reason, output),
            Sent::All => Ok(()),
        }
    }
}

/// Writes a response that says why there are no events.
fn refuse(status: u16, text: &str, output: &mut impl Write) -> io::Result<()> {
    let (head, body) = Response::from(Refusal::new(status, text)).encode(false);
    output.write_all(&head)?;
    output.write_all(&body)
}

fn is_snapshot(message: &Message) -> bool {
    matches!(message, Message::Snapshot(_) | Message::SpaceSnapshot(_))
}

fn bytes_of(snapshot: &Message) -> usize {
    match snapshot {
        Message::Snapshot(Snapshot { vertices, edges, critical, .. }) => {
            size_of_val(&vertices[..]) + size_of_val(&edges[..]) + size_of_val(&critical[..])
        }
        Message::SpaceSnapshot(SpaceSnapshot { ids, coordinates, edges, critical, .. }) => {
            let of_vertices = size_of_val(&ids[..]) + size_of_val(&coordinates[..]);
            of_vertices + size_of_val(&edges[..]) + size_of_val(&critical[..])
        }
        _ => 0,
    }
}
