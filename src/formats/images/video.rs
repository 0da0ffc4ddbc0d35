//! Video without compression: YUV4MPEG2, or bare frames of gray pixels.
//!
//! In: bytes.
//! Out: gray frames, one after the other.
//! Invariants: memory grows with the bytes that have come, never with a size that is announced. A frame has at most
//! [`MOST_PIXELS`]. Luma from 16 to 235 is stretched to 0 to 255, as OpenCV does when it
//! reads video. A frame that is cut off is refused.
//! Must not know: what is looked for in frames.
//!
//! It is ours, not the crate `y4m`: that one allocates a frame of the announced size before a byte of it has come,
//! keeps the planes of colours that are skipped here, reads fewer colour spaces, and leaves the range of luma
//! (`XCOLORRANGE`) to its caller. Bare frames need the same code without headers.

use std::io::{self, BufRead, Read};
use std::str::FromStr;

use hopes::edges::{MOST_PIXELS, gray};
use thiserror::Error;

use super::image::GrayImage;

/// The first bytes of YUV4MPEG2.
pub const MAGIC: &[u8] = b"YUV4MPEG2";

/// What every frame begins with.
const FRAME: &[u8] = b"FRAME";

/// A header has at most so many bytes.
const LONGEST_HEADER: u64 = 4096;

/// The first and the last levels of luma.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// 0 to 255.
    Full,
    /// 16 to 235.
    Limited,
}

/// Pixels in a row, and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// Why video does not begin, or does not go on.
#[derive(Debug, Error)]
pub enum VideoError {
    /// The source failed.
    #[error("cannot read it: {0}")]
    Io(#[source] io::Error),
    /// It begins with something else.
    #[error("it is no YUV4MPEG2")]
    Unknown,
    /// A line without an end.
    #[error("the header of {of} does not end within {LONGEST_HEADER} bytes")]
    LongHeader {
        /// The video, or a frame.
        of: String,
    },
    /// A word that says nothing.
    #[error("{word:?} in its header makes no sense")]
    Word {
        /// The word.
        word: String,
    },
    /// It has no size.
    #[error("its header does not say how wide and how high it is (W and H)")]
    NoSize,
    /// A size that is no use.
    #[error("its size, {width} x {height}, is no use: it must have 1 to {MOST_PIXELS} pixels")]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Colours that we do not know.
    #[error("its colours are {0:?}: convert it to 4:2:0, 4:2:2, 4:4:4 or gray, as by ffmpeg's -pix_fmt yuv420p")]
    Colours(String),
    /// Where a frame should begin there is something else.
    #[error("frame {number} does not begin where it should: the rest of the video is lost")]
    Lost {
        /// From 1.
        number: u64,
    },
    /// The end came too soon.
    #[error("frame {number} is cut off after {found} of {wanted} bytes")]
    CutOff {
        /// From 1.
        number: u64,
        /// Bytes that are there.
        found: u64,
        /// Bytes that there should be.
        wanted: u64,
    },
}

/// Frames of a video.
pub struct Video<R> {
    source: R,
    layout: Layout,
    /// The gray of each luma; none if it is the same.
    levels: Option<[u8; 256]>,
    /// Frames a second.
    rate: Option<f64>,
    /// Whether frames have headers.
    has_headers: bool,
    /// Of the last frame, from 1.
    number: u64,
    /// Luma as it comes.
    samples: Vec<u8>,
}

/// Where the gray is in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layout {
    size: Size,
    /// Bits of a sample; more than 8 come in two bytes.
    depth: u32,
    /// Bytes of colours after the luma.
    colours: u64,
}

impl<R: BufRead> Video<R> {
    /// Bare frames of gray pixels.
    pub fn raw(source: R, size: Size, range: Option<Range>) -> Result<Self, VideoError> {
        let layout = Layout { size: checked(size)?, depth: 8, colours: 0 };
        Ok(Self::new(source, layout, range.unwrap_or(Range::Full), None, false))
    }

    /// YUV4MPEG2. A given range of luma counts more than that of its header.
    pub fn yuv4mpeg(mut source: R, range: Option<Range>) -> Result<Self, VideoError> {
        let header = line(&mut source, || "the video".to_owned())?;
        let words = header.strip_prefix(MAGIC).filter(|rest| rest.is_empty() || rest[0] == b' ');
        let words = String::from_utf8_lossy(words.ok_or(VideoError::Unknown)?).into_owned();
        let header = Header::read(&words)?;
        let layout = header.layout()?;
        // Gray video comes from gray pictures, and other video from cameras and films.
        let usual = if header.is_gray() { Range::Full } else { Range::Limited };
        let range = range.or(header.range).unwrap_or(usual);
        Ok(Self::new(source, layout, range, header.rate, true))
    }

    fn new(source: R, layout: Layout, range: Range, rate: Option<f64>, has_headers: bool) -> Self {
        let levels = (range == Range::Limited).then(gray::of_limited_luma);
        Self { source, layout, levels, rate, has_headers, number: 0, samples: Vec::new() }
    }

    /// Frames a second, if it says so.
    pub fn rate(&self) -> Option<f64> {
        self.rate
    }

    /// The next frame, into a picture; whether there was one.
    pub fn next(&mut self, frame: &mut GrayImage) -> Result<bool, VideoError> {
        self.number += 1;
        let number = self.number;
        if self.source.fill_buf().map_err(VideoError::Io)?.is_empty() {
            return Ok(false);
        }
        if self.has_headers {
            let header = line(&mut self.source, || format!("frame {number}"))?;
            let rest = header.strip_prefix(FRAME).ok_or(VideoError::Lost { number })?;
            if !(rest.is_empty() || rest[0] == b' ') {
                return Err(VideoError::Lost { number });
            }
        }
        self.luma()?;
        let Size { width, height } = self.layout.size;
        (frame.width, frame.height) = (width, height);
        self.gray(&mut frame.pixels);
        Ok(true)
    }

    /// Reads a frame, and passes over its colours.
    fn luma(&mut self) -> Result<(), VideoError> {
        let Layout { colours, .. } = self.layout;
        let luma = self.layout.luma();
        self.samples.clear();
        let read = self.source.by_ref().take(luma).read_to_end(&mut self.samples).map_err(VideoError::Io)? as u64;
        let skipped = match read == luma {
            true => io::copy(&mut self.source.by_ref().take(colours), &mut io::sink()).map_err(VideoError::Io)?,
            false => 0,
        };
        if read + skipped == luma + colours {
            return Ok(());
        }
        Err(VideoError::CutOff { number: self.number, found: read + skipped, wanted: luma + colours })
    }

    fn gray(&mut self, pixels: &mut Vec<u8>) {
        if self.layout.depth == 8 {
            std::mem::swap(pixels, &mut self.samples);
        } else {
            let shift = self.layout.depth - 8;
            let deep = self.samples.chunks_exact(2).map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]) >> shift);
            pixels.clear();
            pixels.extend(deep.map(|sample| sample.min(255) as u8));
        }
        if let Some(levels) = &self.levels {
            pixels.iter_mut().for_each(|pixel| *pixel = levels[usize::from(*pixel)]);
        }
    }
}

impl Layout {
    /// Bytes of luma.
    fn luma(self) -> u64 {
        u64::from(self.size.width) * u64::from(self.size.height) * bytes(self.depth)
    }
}

fn bytes(depth: u32) -> u64 {
    if depth > 8 { 2 } else { 1 }
}

fn checked(size: Size) -> Result<Size, VideoError> {
    let Size { width, height } = size;
    match u64::from(width) * u64::from(height) {
        1..=MOST_PIXELS => Ok(size),
        _ => Err(VideoError::Size { width, height }),
    }
}

/// A line without its end; all of the header of something.
fn line(source: &mut impl BufRead, of: impl Fn() -> String) -> Result<Vec<u8>, VideoError> {
    let mut line = Vec::new();
    source.take(LONGEST_HEADER).read_until(b'\n', &mut line).map_err(VideoError::Io)?;
    match line.pop() {
        Some(b'\n') => Ok(line),
        _ => Err(VideoError::LongHeader { of: of() }),
    }
}

/// What the header of a video says.
#[derive(Debug, Default)]
struct Header {
    width: Option<u32>,
    height: Option<u32>,
    rate: Option<f64>,
    range: Option<Range>,
    colours: Option<String>,
}

impl Header {
    fn read(words: &str) -> Result<Self, VideoError> {
        let mut header = Self::default();
        for word in words.split(' ').filter(|word| !word.is_empty()) {
            let senseless = || VideoError::Word { word: word.to_owned() };
            let kind = word.chars().next().map_or(0, char::len_utf8);
            let value = &word[kind..];
            match &word[..kind] {
                "W" => header.width = Some(value.parse().map_err(|_| senseless())?),
                "H" => header.height = Some(value.parse().map_err(|_| senseless())?),
                "F" => header.rate = rate(value).ok_or_else(senseless)?,
                "C" => header.colours = Some(value.to_owned()),
                "X" if value == "COLORRANGE=FULL" => header.range = Some(Range::Full),
                "X" if value == "COLORRANGE=LIMITED" => header.range = Some(Range::Limited),
                // Interlacing, the shape of pixels, comments, and what may come one day.
                _ => {}
            }
        }
        Ok(header)
    }

    fn layout(&self) -> Result<Layout, VideoError> {
        let (Some(width), Some(height)) = (self.width, self.height) else { return Err(VideoError::NoSize) };
        let size = checked(Size { width, height })?;
        let colours = self.colours.as_deref().unwrap_or("420");
        let (planes, depth) = colours_of(colours).ok_or_else(|| VideoError::Colours(colours.to_owned()))?;
        let [width, height] = [width, height].map(u64::from);
        let samples = match planes {
            Planes::Gray => 0,
            Planes::Each { across, down } => 2 * width.div_ceil(across) * height.div_ceil(down),
            Planes::Transparent => 3 * width * height,
        };
        Ok(Layout { size, depth, colours: samples * bytes(depth) })
    }

    fn is_gray(&self) -> bool {
        self.colours.as_deref().is_some_and(|colours| colours.starts_with("mono"))
    }
}

/// What comes after the luma.
enum Planes {
    Gray,
    /// Two planes, with a sample for so many pixels.
    Each {
        across: u64,
        down: u64,
    },
    /// Two planes of colours and one of transparency, all as large as the luma.
    Transparent,
}

/// Planes and bits of a sample, out of a word such as `420mpeg2`, `422p10` or `mono12`.
fn colours_of(word: &str) -> Option<(Planes, u32)> {
    let depth = |word: &str| match word.parse() {
        Ok(depth @ 8..=16) => Some(depth),
        _ => None,
    };
    if let Some(rest) = word.strip_prefix("mono") {
        return Some((Planes::Gray, if rest.is_empty() { 8 } else { depth(rest)? }));
    }
    if word == "444alpha" {
        return Some((Planes::Transparent, 8));
    }
    let (across, down) = match word.get(..3)? {
        "420" => (2, 2),
        "422" => (2, 1),
        "444" => (1, 1),
        "440" => (1, 2),
        "411" => (4, 1),
        "410" => (4, 4),
        _ => return None,
    };
    // Where samples of colours sit does not matter here.
    let depth = match &word[3..] {
        "" | "jpeg" | "mpeg2" | "paldv" => 8,
        rest => depth(rest.strip_prefix('p')?)?,
    };
    Some((Planes::Each { across, down }, depth))
}

/// Frames a second, such as `30000:1001`; 0 stands for an unknown rate. None if it makes no sense.
#[expect(clippy::option_option, reason = "unknown is something else than senseless")]
fn rate(word: &str) -> Option<Option<f64>> {
    let (frames, seconds) = word.split_once(':')?;
    let (frames, seconds): (u32, u32) = (frames.parse().ok()?, seconds.parse().ok()?);
    Some((frames > 0 && seconds > 0).then(|| f64::from(frames) / f64::from(seconds)))
}

impl FromStr for Size {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let refused = || format!("{word:?} is no size: write WxH, such as 1280x720");
        let (width, height) = word.split_once(['x', 'X']).ok_or_else(refused)?;
        let size =
            Self { width: width.parse().map_err(|_| refused())?, height: height.parse().map_err(|_| refused())? };
        checked(size).map_err(|_| format!("{word} is no use: it must have 1 to {MOST_PIXELS} pixels"))
    }
}
