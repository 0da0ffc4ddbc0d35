//! Frames of WebSockets (RFC 6455), taken apart as they come and made.
//!
//! In: bytes of a client, in pieces of any size. Out: the carried bytes, unmasked where they lie, and what control
//! frames ask for. Invariants: nothing is kept of a message but where in its frame we are, however long it says it is;
//! a frame that breaks the rules is refused by name. Must not know: sockets, what is carried.

use thiserror::Error;

/// Bytes in a control frame at the most.
const LONGEST_CONTROL: usize = 125;

/// Bytes in the head of a frame at the most: two, eight of length, four of mask.
const LONGEST_HEAD: usize = 14;

/// Set in the first byte of a message's last frame.
const LAST: u8 = 0x80;

/// What frames are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Goes on with a message.
    Continuation = 0,
    /// Begins a message of bytes.
    Binary = 2,
    /// Nothing more comes.
    Close = 8,
    /// Asks for a pong.
    Ping = 9,
    /// Answers a ping.
    Pong = 10,
}

/// Why a connection cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FramingError {
    /// Text was sent.
    #[error("a WebSocket message of text: send binary ones")]
    Text,
    /// An opcode without a meaning.
    #[error("a WebSocket frame of the unknown kind {0}")]
    Kind(u8),
    /// Bits that only an extension would set, and none was agreed upon.
    #[error("a WebSocket frame with reserved bits set")]
    Reserved,
    /// Browsers always mask.
    #[error("a WebSocket frame that is not masked")]
    Unmasked,
    /// A control frame in pieces, or too long.
    #[error("a WebSocket control frame in pieces or of more than {LONGEST_CONTROL} bytes")]
    Control,
    /// More than 63 bits.
    #[error("a WebSocket frame whose length has more than 63 bits")]
    Length,
    /// A message began within another, or went on without having begun.
    #[error("a WebSocket message out of order")]
    Order,
}

impl FramingError {
    /// The number that tells the client.
    pub fn code(self) -> u16 {
        if self == Self::Text { 1003 } else { 1002 }
    }
}

/// What a client has asked for in control frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// To be answered by a pong with the same bytes; only the newest counts.
    pub ping: Option<Vec<u8>>,
    /// Nothing more comes.
    pub is_closed: bool,
}

/// Takes frames of a client apart.
#[derive(Debug, Default)]
pub struct Unframer {
    /// What has come of a head.
    head: Vec<u8>,
    within: Option<Within>,
    /// The message has not ended yet.
    is_message_open: bool,
    /// What has come of a control frame.
    control: Vec<u8>,
}

/// Within the payload of a frame.
#[derive(Clone, Copy, Debug)]
struct Within {
    kind: Kind,
    mask: [u8; 4],
    /// Bytes that are still to come.
    left: u64,
}

impl Unframer {
    /// Takes what has come; the carried bytes are left at the front of it. How many these are.
    ///
    /// # Errors
    /// [`FramingError`]; what comes then cannot be understood.
    pub fn take(&mut self, bytes: &mut [u8], asked: &mut Asked) -> Result<usize, FramingError> {
        let (mut at, mut carried) = (0, 0);
        while at < bytes.len() && !asked.is_closed {
            let Some(mut within) = self.within else {
                self.head.push(bytes[at]);
                at += 1;
                self.within = self.begin()?;
                // One without a payload ends where it begins.
                self.end_if_whole(asked);
                continue;
            };
            let length = (bytes.len() - at).min(usize::try_from(within.left).unwrap_or(usize::MAX));
            let piece = &mut bytes[at..at + length];
            piece.iter_mut().zip(within.mask.iter().cycle()).for_each(|(byte, mask)| *byte ^= mask);
            if matches!(within.kind, Kind::Binary | Kind::Continuation) {
                bytes.copy_within(at..at + length, carried);
                carried += length;
            } else {
                self.control.extend_from_slice(piece);
            }
            at += length;
            within.left -= length as u64;
            within.mask.rotate_left(length % 4);
            self.within = Some(within);
            self.end_if_whole(asked);
        }
        Ok(carried)
    }

    /// The frame whose head has come, if it has as a whole.
    fn begin(&mut self) -> Result<Option<Within>, FramingError> {
        let &[first, second, ref rest @ ..] = &self.head[..] else { return Ok(None) };
        let kind = check(first, second)?;
        let extra = match second & 0x7f {
            126 => 2,
            127 => 8,
            _ => 0,
        };
        let Some((length, mask)) = rest.split_at_checked(extra) else { return Ok(None) };
        let Ok(mask) = <[u8; 4]>::try_from(mask) else { return Ok(None) };
        let long = length.iter().fold(0, |length, &byte| length << 8 | u64::from(byte));
        let left = if extra == 0 { u64::from(second & 0x7f) } else { long };
        if left >> 63 != 0 {
            return Err(FramingError::Length);
        }
        if matches!(kind, Kind::Binary | Kind::Continuation) {
            if self.is_message_open != (kind == Kind::Continuation) {
                return Err(FramingError::Order);
            }
            self.is_message_open = first & LAST == 0;
        }
        self.head.clear();
        Ok(Some(Within { kind, mask, left }))
    }

    fn end_if_whole(&mut self, asked: &mut Asked) {
        let Some(within) = self.within.filter(|within| within.left == 0) else { return };
        self.within = None;
        let control = std::mem::take(&mut self.control);
        match within.kind {
            Kind::Close => asked.is_closed = true,
            Kind::Ping => asked.ping = Some(control),
            Kind::Pong | Kind::Binary | Kind::Continuation => {}
        }
    }
}

/// What the first two bytes of a head say.
fn check(first: u8, second: u8) -> Result<Kind, FramingError> {
    let kind = match first & 0x0f {
        0 => Kind::Continuation,
        1 => return Err(FramingError::Text),
        2 => Kind::Binary,
        8 => Kind::Close,
        9 => Kind::Ping,
        10 => Kind::Pong,
        other => return Err(FramingError::Kind(other)),
    };
    let is_control = matches!(kind, Kind::Close | Kind::Ping | Kind::Pong);
    let is_short_and_whole = first & LAST != 0 && usize::from(second & 0x7f) <= LONGEST_CONTROL;
    if first & 0x70 != 0 {
        Err(FramingError::Reserved)
    } else if second & 0x80 == 0 {
        Err(FramingError::Unmasked)
    } else if is_control && !is_short_and_whole {
        Err(FramingError::Control)
    } else {
        Ok(kind)
    }
}

/// The head of a whole frame of a server.
pub fn head(kind: Kind, length: usize) -> Vec<u8> {
    let mut head = Vec::with_capacity(LONGEST_HEAD);
    head.push(LAST | kind as u8);
    match (u8::try_from(length), u16::try_from(length)) {
        (Ok(short @ ..126), _) => head.push(short),
        (_, Ok(middle)) => {
            head.push(126);
            head.extend(middle.to_be_bytes());
        }
        _ => {
            head.push(127);
            head.extend((length as u64).to_be_bytes());
        }
    }
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame as a browser sends it.
    fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
        let mask = [7, 1, 200, 99];
        let mut frame = head(Kind::Binary, payload.len());
        (frame[0], frame[1]) = (first, frame[1] | 0x80);
        frame.extend(mask);
        frame.extend(payload.iter().zip(mask.iter().cycle()).map(|(byte, mask)| byte ^ mask));
        frame
    }

    fn taken(pieces: &[&[u8]]) -> Result<(Vec<u8>, Asked), FramingError> {
        let (mut unframer, mut asked, mut all) = (Unframer::default(), Asked::default(), Vec::new());
        for piece in pieces {
            let mut bytes = piece.to_vec();
            let length = unframer.take(&mut bytes, &mut asked)?;
            all.extend_from_slice(&bytes[..length]);
        }
        Ok((all, asked))
    }

    #[test]
    fn what_is_carried_comes_out_however_it_is_cut() {
        for length in [0, 1, 3, 125, 126, 127, 65_535, 65_536, 70_000] {
            let payload: Vec<u8> = (0..length).map(|index| (index * 31 % 251) as u8).collect();
            let (first, second) = payload.split_at(length / 3);
            let sent = [frame(0x02, first), frame(0x89, b"there?"), frame(0x80, second), frame(0x82, b"next")].concat();
            for cut in [1, 2, 5, 13, 4096, sent.len()] {
                let (got, asked) = taken(&sent.chunks(cut).collect::<Vec<_>>()).unwrap();
                assert_eq!(got, [&payload[..], b"next"].concat(), "{length} bytes in pieces of {cut}");
                assert_eq!(asked, Asked { ping: Some(b"there?".to_vec()), is_closed: false });
            }
        }
    }

    #[test]
    fn nothing_is_taken_after_the_end() {
        let sent = [frame(0x82, b"a"), frame(0x88, &[3, 232]), frame(0x82, b"b")].concat();
        assert_eq!(taken(&[&sent]).unwrap(), (b"a".to_vec(), Asked { ping: None, is_closed: true }));
    }

    #[test]
    fn what_breaks_the_rules_is_refused() {
        let mut unmasked = frame(0x82, b"a");
        unmasked[1] &= 0x7f;
        for (sent, error) in [
            (frame(0x81, b"text"), FramingError::Text),
            (frame(0x83, b""), FramingError::Kind(3)),
            (frame(0xc2, b""), FramingError::Reserved),
            (unmasked, FramingError::Unmasked),
            (frame(0x09, b""), FramingError::Control),
            (frame(0x89, &[0; 126]), FramingError::Control),
            (frame(0x80, b""), FramingError::Order),
            ([frame(0x02, b""), frame(0x82, b"")].concat(), FramingError::Order),
            ([&[0x82, 0xff][..], &[0x80; 12]].concat(), FramingError::Length),
        ] {
            assert_eq!(taken(&[&sent]).unwrap_err(), error);
            assert_eq!(taken(&sent.chunks(1).collect::<Vec<_>>()).unwrap_err(), error);
        }
    }
}
