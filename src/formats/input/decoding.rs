//! Encodings of a whole source: gzip and UTF-16, to the bytes that were encoded.
//!
//! In: any [`Read`] whose first bytes said how it is encoded.
//! Out: a [`Read`] of what it holds, UTF-8 for UTF-16.
//! Invariants: what can be decoded is handed on as soon as its bytes have arrived. Memory does not grow with the
//! source. Where encoded data are damaged or cut short, a [`Damage`] is returned once, after all before it; then the
//! source has ended.
//! Must not know: what the bytes mean.

use std::fmt;
use std::io::{self, BufReader, ErrorKind, Read};

use flate2::bufread::MultiGzDecoder;

/// How many bytes are decoded at once.
const PIECE: usize = 8 * 1024;

/// The encoded data end too early, or are wrong.
#[derive(Debug)]
pub(super) struct Damage(String);

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Damage {}

impl Damage {
    /// What an error of a source says of damage, if it is of that kind.
    pub(super) fn of(error: &io::Error) -> Option<&Self> {
        error.get_ref()?.downcast_ref()
    }

    fn at(place: impl fmt::Display) -> io::Error {
        io::Error::new(ErrorKind::InvalidData, Self(place.to_string()))
    }
}

/// What gzip has compressed, of one member or several. Where the data are damaged, what came in the same piece is lost
/// with them.
pub(super) struct Gzip<R> {
    members: MultiGzDecoder<BufReader<Counted<R>>>,
    has_ended: bool,
}

/// Counts the bytes that were read.
struct Counted<R> {
    source: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        let length = self.source.read(room)?;
        self.bytes += length as u64;
        Ok(length)
    }
}

impl<R: Read> Gzip<R> {
    pub(super) fn new(source: R) -> Self {
        Self { members: MultiGzDecoder::new(BufReader::new(Counted { source, bytes: 0 })), has_ended: false }
    }

    /// How many compressed bytes were used.
    fn used(&self) -> u64 {
        let buffered = self.members.get_ref();
        buffered.get_ref().bytes - buffered.buffer().len() as u64
    }
}

impl<R: Read> Read for Gzip<R> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        if self.has_ended {
            return Ok(0);
        }
        let length = room.len().min(PIECE);
        let error = match self.members.read(&mut room[..length]) {
            Ok(length) => return Ok(length),
            Err(error) => error,
        };
        let place = self.used();
        let damage = match error.kind() {
            ErrorKind::UnexpectedEof => {
                Damage::at(format_args!("the gzip data end in the middle, at byte {place}: all before it was read"))
            }
            ErrorKind::InvalidInput | ErrorKind::InvalidData => Damage::at(format_args!(
                "the gzip data are damaged near byte {place} ({error}): nothing after it was read"
            )),
            _ => return Err(error),
        };
        self.has_ended = true;
        Err(damage)
    }
}

/// Text in UTF-16, as UTF-8. A half of a pair that stands alone becomes U+FFFD.
pub(super) struct Utf16<R> {
    source: R,
    is_big_endian: bool,
    /// Bytes that are no whole character yet.
    pending: Vec<u8>,
    text: String,
    /// How much of the text was handed out.
    given: usize,
    bytes: u64,
    has_ended: bool,
}

impl<R: Read> Utf16<R> {
    pub(super) fn new(source: R, is_big_endian: bool) -> Self {
        let (pending, text) = (Vec::new(), String::new());
        Self { source, is_big_endian, pending, text, given: 0, bytes: 0, has_ended: false }
    }

    /// Reads once, and decodes the characters that are whole.
    fn fill(&mut self) -> io::Result<()> {
        let mut piece = [0; PIECE];
        let length = self.source.read(&mut piece)?;
        self.bytes += length as u64;
        self.has_ended = length == 0;
        self.pending.extend_from_slice(&piece[..length]);
        let mut units: Vec<u16> = self.pending.chunks_exact(2).map(|pair| self.unit([pair[0], pair[1]])).collect();
        // The second half of a pair may be still to come.
        if !self.has_ended && units.last().is_some_and(|unit| (0xd800..0xdc00).contains(unit)) {
            units.pop();
        }
        self.pending.drain(..2 * units.len());
        self.text.clear();
        self.given = 0;
        let characters = char::decode_utf16(units).map(|decoded| decoded.unwrap_or(char::REPLACEMENT_CHARACTER));
        self.text.extend(characters);
        Ok(())
    }

    fn unit(&self, pair: [u8; 2]) -> u16 {
        if self.is_big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        while self.given == self.text.len() && !room.is_empty() {
            if self.has_ended {
                let place = self.bytes;
                return match std::mem::take(&mut self.pending).is_empty() {
                    true => Ok(0),
                    false => Err(Damage::at(format_args!("the UTF-16 text ends within a character, at byte {place}"))),
                };
            }
            self.fill()?;
        }
        let rest = &self.text.as_bytes()[self.given..];
        let length = rest.len().min(room.len());
        room[..length].copy_from_slice(&rest[..length]);
        self.given += length;
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::super::testing::compressed;
    use super::*;

    /// What comes out, and what is said of damage. After that, nothing comes.
    fn read(mut source: impl Read) -> (String, String) {
        let (mut text, mut said) = (Vec::new(), String::new());
        if let Err(error) = source.read_to_end(&mut text) {
            said = Damage::of(&error).unwrap().to_string();
            assert_eq!(source.read(&mut [0; 9]).unwrap(), 0);
        }
        (String::from_utf8(text).unwrap(), said)
    }

    #[test]
    fn members_follow_each_other_and_damage_is_told_after_what_was_good() {
        let good = [compressed(b"1,2\n"), compressed(b"3,4\n")].concat();
        let all = "1,2\n3,4\n".to_owned();
        assert_eq!(read(Gzip::new(&good[..])), (all.clone(), String::new()));
        let (text, said) = read(Gzip::new(&good[..good.len() - 3]));
        let end = good.len() - 3;
        assert_eq!(
            (text, said),
            (all.clone(), format!("the gzip data end in the middle, at byte {end}: all before it was read"))
        );
        let (text, said) = read(Gzip::new(&[&good[..], b"and then this"].concat()[..]));
        assert!(text == all && said.starts_with("the gzip data are damaged near byte "), "{said}");
        let mut wrong = good.clone();
        *wrong.last_mut().unwrap() ^= 1;
        assert!(read(Gzip::new(&wrong[..])).1.contains("damaged"));
        assert!(!read(Gzip::new(&good[..5])).1.is_empty());
    }

    #[test]
    fn what_was_compressed_comes_as_soon_as_it_can() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(b"1,2\n").unwrap();
        encoder.flush().unwrap();
        let begun = encoder.get_ref().clone();
        let mut live = Gzip::new(begun.chain(Waiting));
        let mut room = [0; 100];
        assert_eq!(live.read(&mut room).unwrap(), 4);
    }

    /// A source from which nothing more has arrived.
    struct Waiting;

    impl Read for Waiting {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            panic!("it would have to be waited for")
        }
    }

    #[test]
    fn utf_16_becomes_utf_8_however_it_is_cut() {
        let text = "\u{feff}1,2\nå😀\n";
        for is_big_endian in [false, true] {
            let encode = |unit: u16| if is_big_endian { unit.to_be_bytes() } else { unit.to_le_bytes() };
            let bytes: Vec<u8> = text.encode_utf16().flat_map(encode).collect();
            let decoded = |bytes: &[u8]| read(Utf16::new(Slowly(bytes), is_big_endian));
            assert_eq!(decoded(&bytes), (text.to_owned(), String::new()));
            let half = decoded(&bytes[..3]);
            assert_eq!(half, ("\u{feff}".to_owned(), "the UTF-16 text ends within a character, at byte 3".to_owned()));
            let alone: Vec<u8> = [0xd83d, 0x31].into_iter().flat_map(encode).collect();
            assert_eq!(decoded(&alone).0, "\u{fffd}1");
            assert_eq!(decoded(&alone[..2]).0, "\u{fffd}");
        }
    }

    struct Slowly<'a>(&'a [u8]);

    impl Read for Slowly<'_> {
        fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
            self.0.read(&mut room[..1])
        }
    }
}
