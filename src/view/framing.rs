//! WebSocket frames (RFC 6455): decoding of a client's frames, and headers of the server's.
//!
//! In: bytes of a client, in pieces of any size.
//! Out: the payload, unmasked in place; what control frames request.
//! Invariants: of a message, only the position in its current frame is kept, so an announced length allocates nothing.
//! A frame that breaks the rules is refused with the reason.
//! Must not know: sockets, what the payload means.
//!
//! `tungstenite` parses and formats headers, opcodes and close codes. Its own reader is not used: it owns the stream,
//! which a reader and a writer thread share here, and it holds a whole message before it hands it on. So unmasking and
//! the order of frames are checked here.

use std::io::Cursor;

use thiserror::Error;
use tungstenite::protocol::frame::FrameHeader;
use tungstenite::protocol::frame::coding::{CloseCode, Control, Data, OpCode};

/// Bytes in the payload of a control frame at the most.
const MAX_CONTROL: u64 = 125;

/// Why a connection cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FramingError {
    /// Text was sent.
    #[error("a WebSocket message of text: send binary ones")]
    Text,
    /// The opcode has no meaning.
    #[error("a WebSocket frame of the unknown opcode {0}")]
    Opcode(u8),
    /// Bits are set that only an extension sets, and none was negotiated.
    #[error("a WebSocket frame with reserved bits set")]
    Reserved,
    /// Clients must mask.
    #[error("a WebSocket frame that is not masked")]
    Unmasked,
    /// A control frame is fragmented or too long.
    #[error("a WebSocket control frame that is fragmented or longer than {MAX_CONTROL} bytes")]
    Control,
    /// The length has more than 63 bits.
    #[error("a WebSocket frame whose length has more than 63 bits")]
    Length,
    /// A message began within another, or a continuation came without a beginning.
    #[error("a WebSocket message out of order")]
    Order,
}

impl FramingError {
    /// The close code for the client.
    pub fn code(self) -> CloseCode {
        if self == Self::Text { CloseCode::Unsupported } else { CloseCode::Protocol }
    }
}

/// What a client has requested by control frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ControlRequests {
    /// The payload of the newest ping, which a pong has to repeat.
    pub ping: Option<Vec<u8>>,
    /// The client closes the connection.
    pub is_closed: bool,
}

/// Decodes the frames of a client.
#[derive(Debug, Default)]
pub struct FrameDecoder {
    /// The bytes of a header that is not complete.
    header: Vec<u8>,
    payload: Option<Payload>,
    /// The last data frame was not the final one of its message.
    is_message_open: bool,
    /// The received part of a control frame's payload.
    control: Vec<u8>,
}

/// The position in the payload of a frame.
#[derive(Clone, Copy, Debug)]
struct Payload {
    opcode: OpCode,
    mask: [u8; 4],
    /// Bytes that are still to come.
    left: u64,
}

impl FrameDecoder {
    /// Decodes received bytes in place: moves the payload of data frames to their front, and returns its length.
    ///
    /// # Errors
    /// [`FramingError`]; nothing can be decoded after it.
    pub fn decode(&mut self, bytes: &mut [u8], requests: &mut ControlRequests) -> Result<usize, FramingError> {
        let (mut at, mut decoded) = (0, 0);
        while at < bytes.len() && !requests.is_closed {
            let Some(mut payload) = self.payload else {
                self.header.push(bytes[at]);
                at += 1;
                self.payload = self.parse_header()?;
                // A frame without a payload ends with its header.
                self.end_if_complete(requests);
                continue;
            };
            let length = (bytes.len() - at).min(usize::try_from(payload.left).unwrap_or(usize::MAX));
            let piece = &mut bytes[at..at + length];
            piece.iter_mut().zip(payload.mask.iter().cycle()).for_each(|(byte, mask)| *byte ^= mask);
            if matches!(payload.opcode, OpCode::Data(_)) {
                bytes.copy_within(at..at + length, decoded);
                decoded += length;
            } else {
                self.control.extend_from_slice(piece);
            }
            at += length;
            payload.left -= length as u64;
            payload.mask.rotate_left(length % 4);
            self.payload = Some(payload);
            self.end_if_complete(requests);
        }
        Ok(decoded)
    }

    /// The payload that follows the header, once the header is complete.
    fn parse_header(&mut self) -> Result<Option<Payload>, FramingError> {
        // A header in memory cannot be parsed for one reason only.
        let parsed = FrameHeader::parse(&mut Cursor::new(&self.header))
            .map_err(|_| FramingError::Opcode(self.header[0] & 0x0f))?;
        let Some((header, left)) = parsed else { return Ok(None) };
        let mask = check(&header, left)?;
        if let OpCode::Data(data) = header.opcode {
            if self.is_message_open != (data == Data::Continue) {
                return Err(FramingError::Order);
            }
            self.is_message_open = !header.is_final;
        }
        self.header.clear();
        Ok(Some(Payload { opcode: header.opcode, mask, left }))
    }

    fn end_if_complete(&mut self, requests: &mut ControlRequests) {
        let Some(payload) = self.payload.filter(|payload| payload.left == 0) else { return };
        self.payload = None;
        let control = std::mem::take(&mut self.control);
        match payload.opcode {
            OpCode::Control(Control::Close) => requests.is_closed = true,
            OpCode::Control(Control::Ping) => requests.ping = Some(control),
            OpCode::Control(_) | OpCode::Data(_) => {}
        }
    }
}

/// Checks a header by itself. Returns its mask.
fn check(header: &FrameHeader, length: u64) -> Result<[u8; 4], FramingError> {
    if header.opcode == OpCode::Data(Data::Text) {
        return Err(FramingError::Text);
    }
    if header.rsv1 || header.rsv2 || header.rsv3 {
        return Err(FramingError::Reserved);
    }
    let mask = header.mask.ok_or(FramingError::Unmasked)?;
    let is_control = matches!(header.opcode, OpCode::Control(_));
    if is_control && !(header.is_final && length <= MAX_CONTROL) {
        return Err(FramingError::Control);
    }
    if length >> 63 != 0 { Err(FramingError::Length) } else { Ok(mask) }
}

/// The header of a server's frame, which is final and not masked.
pub fn header(opcode: OpCode, length: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let header = FrameHeader { opcode, ..FrameHeader::default() };
    header.format(length as u64, &mut bytes).expect("writing into a vector does not fail");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of a client.
    fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
        let mask = [7, 1, 200, 99];
        let mut frame = header(OpCode::Data(Data::Binary), payload.len());
        (frame[0], frame[1]) = (first, frame[1] | 0x80);
        frame.extend(mask);
        frame.extend(payload.iter().zip(mask.iter().cycle()).map(|(byte, mask)| byte ^ mask));
        frame
    }

    fn decoded(pieces: &[&[u8]]) -> Result<(Vec<u8>, ControlRequests), FramingError> {
        let (mut decoder, mut requests, mut all) = (FrameDecoder::default(), ControlRequests::default(), Vec::new());
        for piece in pieces {
            let mut bytes = piece.to_vec();
            let length = decoder.decode(&mut bytes, &mut requests)?;
            all.extend_from_slice(&bytes[..length]);
        }
        Ok((all, requests))
    }

    #[test]
    fn the_payload_is_decoded_whatever_the_size_of_pieces() {
        for length in [0, 1, 3, 125, 126, 127, 65_535, 65_536, 70_000] {
            let payload: Vec<u8> = (0..length).map(|index| (index * 31 % 251) as u8).collect();
            let (first, second) = payload.split_at(length / 3);
            let sent = [frame(0x02, first), frame(0x89, b"there?"), frame(0x80, second), frame(0x82, b"next")].concat();
            for cut in [1, 2, 5, 13, 4096, sent.len()] {
                let (got, requests) = decoded(&sent.chunks(cut).collect::<Vec<_>>()).unwrap();
                assert_eq!(got, [&payload[..], b"next"].concat(), "{length} bytes in pieces of {cut}");
                assert_eq!(requests, ControlRequests { ping: Some(b"there?".to_vec()), is_closed: false });
            }
        }
    }

    #[test]
    fn nothing_is_decoded_after_a_close() {
        let sent = [frame(0x82, b"a"), frame(0x88, &[3, 232]), frame(0x82, b"b")].concat();
        assert_eq!(decoded(&[&sent]).unwrap(), (b"a".to_vec(), ControlRequests { ping: None, is_closed: true }));
    }

    #[test]
    fn frames_that_break_the_rules_are_refused() {
        let mut unmasked = frame(0x82, b"a");
        unmasked[1] &= 0x7f;
        for (sent, error) in [
            (frame(0x81, b"text"), FramingError::Text),
            (frame(0x83, b""), FramingError::Opcode(3)),
            (frame(0xc2, b""), FramingError::Reserved),
            (unmasked, FramingError::Unmasked),
            (frame(0x09, b""), FramingError::Control),
            (frame(0x89, &[0; 126]), FramingError::Control),
            (frame(0x80, b""), FramingError::Order),
            ([frame(0x02, b""), frame(0x82, b"")].concat(), FramingError::Order),
            ([&[0x82, 0xff][..], &[0x80; 12]].concat(), FramingError::Length),
        ] {
            assert_eq!(decoded(&[&sent]).unwrap_err(), error);
            assert_eq!(decoded(&sent.chunks(1).collect::<Vec<_>>()).unwrap_err(), error);
        }
    }
}
