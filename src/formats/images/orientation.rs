//! How a camera was held, and pictures turned accordingly.
//!
//! In: Exif, which is a TIFF without a picture.
//! Out: an [`Orientation`]; pictures turned by it.
//! Invariants: Exif that makes no sense turns nothing.
//! Must not know: where Exif stands in files.
//!
//! The one entry is read here, in twenty lines, and not by the crate `kamadak-exif`: that one parses all entries of
//! all directories into values, and refuses them for one that is damaged; here one number of one type is needed,
//! and other entries need not make sense.

use super::image::GrayImage;

/// How pixels stand in a file: mirrored left to right or not, then turned clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation {
    is_mirrored: bool,
    /// By so many right angles.
    turns: u8,
}

/// The entry of the orientation.
const ENTRY: u16 = 0x0112;

/// The type of a number of 16 bits.
const SHORT: u16 = 3;

/// What Exif says.
pub fn of(exif: &[u8]) -> Orientation {
    find(exif).map(Orientation::from_number).unwrap_or_default()
}

fn find(exif: &[u8]) -> Option<u16> {
    let is_little = match exif.get(..4)? {
        b"II*\0" => true,
        b"MM\0*" => false,
        _ => return None,
    };
    let short = |at: usize| {
        let bytes: [u8; 2] = exif.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let long = |at: usize| {
        let bytes: [u8; 4] = exif.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    };
    let directory = long(4)? as usize;
    let entries = usize::from(short(directory)?);
    // An entry has twelve bytes: which, of what type, how many, and the value.
    let entry = (0..entries).map(|index| directory + 2 + 12 * index).find(|&at| short(at) == Some(ENTRY))?;
    (short(entry + 2)? == SHORT).then(|| short(entry + 8))?
}

impl Orientation {
    fn from_number(number: u16) -> Self {
        let (is_mirrored, turns) = match number {
            2 => (true, 0),
            3 => (false, 2),
            4 => (true, 2),
            5 => (true, 3),
            6 => (false, 1),
            7 => (true, 1),
            8 => (false, 3),
            _ => (false, 0),
        };
        Self { is_mirrored, turns }
    }

    /// A picture as the camera saw it.
    pub fn turned(self, picture: GrayImage) -> GrayImage {
        if self == Self::default() {
            return picture;
        }
        let GrayImage { width, height, pixels } = picture;
        let (columns, rows) = (width as usize, height as usize);
        let (new_columns, new_rows) = if self.turns.is_multiple_of(2) { (columns, rows) } else { (rows, columns) };
        let source = |x: usize, y: usize| {
            let (x, y) = match self.turns {
                0 => (x, y),
                1 => (y, rows - 1 - x),
                2 => (columns - 1 - x, rows - 1 - y),
                _ => (columns - 1 - y, x),
            };
            y * columns + if self.is_mirrored { columns - 1 - x } else { x }
        };
        let places = (0..new_rows).flat_map(|y| (0..new_columns).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| pixels[source(x, y)]).collect();
        GrayImage { width: new_columns as u32, height: new_rows as u32, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exif(is_little: bool, number: u16) -> Vec<u8> {
        let short = |value: u16| if is_little { value.to_le_bytes() } else { value.to_be_bytes() };
        let long = |value: u32| if is_little { value.to_le_bytes() } else { value.to_be_bytes() };
        let mut bytes = if is_little { b"II*\0".to_vec() } else { b"MM\0*".to_vec() };
        bytes.extend(long(10));
        bytes.extend(short(0));
        bytes.extend(short(2));
        for (which, value) in [(0x0100, 7), (ENTRY, number)] {
            bytes.extend(short(which));
            bytes.extend(short(SHORT));
            bytes.extend(long(1));
            bytes.extend(short(value));
            bytes.extend(short(0));
        }
        bytes
    }

    #[test]
    fn every_way_to_hold_a_camera() {
        // As the Exif standard has it: where the first row and the first column of the file belong.
        for (number, rows) in [
            (1, "abc def"),
            (2, "cba fed"),
            (3, "fed cba"),
            (4, "def abc"),
            (5, "ad be cf"),
            (6, "da eb fc"),
            (7, "fc eb da"),
            (8, "cf be ad"),
            (9, "abc def"),
        ] {
            let picture = GrayImage { width: 3, height: 2, pixels: b"abcdef".to_vec() };
            let rows: Vec<&str> = rows.split(' ').collect();
            let expected = GrayImage {
                width: rows[0].len() as u32,
                height: rows.len() as u32,
                pixels: rows.concat().into_bytes(),
            };
            for is_little in [true, false] {
                assert_eq!(of(&exif(is_little, number)).turned(picture.clone()), expected, "{number}");
            }
        }
    }

    #[test]
    fn exif_that_makes_no_sense_turns_nothing() {
        let good = exif(true, 6);
        assert_ne!(of(&good), Orientation::default());
        for length in 0..good.len() - 4 {
            assert_eq!(of(&good[..length]), Orientation::default(), "{length}");
        }
        for (at, byte) in [(0, b'X'), (4, 0xff), (7, 0xff), (26, 9)] {
            let mut bad = good.clone();
            bad[at] = byte;
            assert_eq!(of(&bad), Orientation::default(), "{at}");
        }
    }
}
