//! Pictures in files: PNG and JPEG, to gray.
//!
//! In: the bytes of a file.
//! Out: a [`GrayImage`], as `cv2.imread(file, IMREAD_GRAYSCALE)` has it: weights of colours, transparency left out,
//! turned as its Exif says.
//! Invariants: a picture has at most [`MOST_PIXELS`] and a file at most [`MOST_BYTES`], and memory is bounded by
//! them; one that is cut off or damaged is refused as a whole.
//! Must not know: what is looked for in pictures.

use std::io::{self, Cursor, Read};

use hopes::edges::{MOST_PIXELS, gray};
use png::{BitDepth, ColorType, Transformations};
use thiserror::Error;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::image::GrayImage;
use super::orientation::{self, Orientation};

/// A file of a picture has at most so many bytes.
pub const MOST_BYTES: u64 = 1 << 28;

/// Rows of a picture, and pixels in a row.
const LONGEST_SIDE: usize = 65_535;

/// What the decoder of PNG may use beside pixels, for such as colour profiles.
const MARGINALIA: usize = 1 << 24;

/// The exponent of pictures that say that they are sRGB.
const SRGB: f64 = 0.45455;

/// The first bytes of a PNG.
pub const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// The first bytes of a JPEG.
pub const JPEG: &[u8] = b"\xff\xd8\xff";

/// Why there is no picture.
#[derive(Debug, Error)]
pub enum DecodeError {
    /// The source failed.
    #[error("cannot read it: {0}")]
    Io(#[source] io::Error),
    /// Too many bytes.
    #[error("it has more than {MOST_BYTES} bytes: too large a file for a picture")]
    LongFile,
    /// Neither of what we know.
    #[error("it is neither PNG nor JPEG")]
    Unknown,
    /// The size that it announces.
    #[error("its size, {width} x {height}, is too large: {MOST_PIXELS} pixels are the most")]
    TooLarge {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The rest of it.
    #[error("damaged PNG: {0}")]
    Png(#[from] png::DecodingError),
    /// The rest of it.
    #[error("damaged JPEG: {0}")]
    Jpeg(String),
}

/// Reads a picture to its end.
pub fn read(source: impl Read) -> Result<GrayImage, DecodeError> {
    let mut bytes = Vec::new();
    source.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(DecodeError::Io)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(DecodeError::LongFile);
    }
    decode(&bytes)
}

fn decode(bytes: &[u8]) -> Result<GrayImage, DecodeError> {
    let (image, orientation) = match bytes {
        _ if bytes.starts_with(PNG) => png(bytes)?,
        _ if bytes.starts_with(JPEG) => jpeg(bytes)?,
        _ => return Err(DecodeError::Unknown),
    };
    Ok(orientation.turned(image))
}

fn check_size(width: usize, height: usize) -> Result<(), DecodeError> {
    let is_fitting = width <= LONGEST_SIDE && height <= LONGEST_SIDE && (width * height) as u64 <= MOST_PIXELS;
    if is_fitting { Ok(()) } else { Err(DecodeError::TooLarge { width, height }) }
}

fn png(bytes: &[u8]) -> Result<(GrayImage, Orientation), DecodeError> {
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: MARGINALIA });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let (width, height) = {
        let info = decoder.read_header_info()?;
        (info.width, info.height)
    };
    check_size(width as usize, height as usize)?;
    let room = (width as usize * height as usize * 8).saturating_add(MARGINALIA);
    decoder.set_limits(png::Limits { bytes: room });
    let mut reader = decoder.read_info()?;
    let info = reader.info();
    let exponent =
        if info.srgb.is_some() { SRGB } else { info.gama_chunk.map_or(1.0, |gamma| gamma.into_value().into()) };
    let is_interlaced = info.interlaced;
    let gray = Gray::new(reader.output_color_type(), exponent);
    let mut pixels = Vec::new();
    if is_interlaced {
        let size = reader
            .output_buffer_size()
            .ok_or(DecodeError::TooLarge { width: width as usize, height: height as usize })?;
        let mut samples = vec![0; size];
        reader.next_frame(&mut samples)?;
        gray.append(&samples, &mut pixels);
    } else {
        while let Some(row) = reader.next_row()? {
            gray.append(row.data(), &mut pixels);
        }
    }
    // All pixels are there. Chunks after them may have the orientation, and are not needed otherwise.
    drop(reader.finish());
    let exif = reader.info().exif_metadata.as_deref();
    Ok((GrayImage { width, height, pixels }, exif.map(orientation::of).unwrap_or_default()))
}

/// How samples of a PNG become gray.
struct Gray {
    /// In each pixel.
    channels: usize,
    is_deep: bool,
    gamma: Option<gray::Gamma>,
}

impl Gray {
    fn new((color, depth): (ColorType, BitDepth), exponent: f64) -> Self {
        let is_deep = depth == BitDepth::Sixteen;
        // Gray stays as it is.
        let gamma = match (color.samples() >= 3, is_deep) {
            (false, _) => None,
            (true, false) => gray::Gamma::new(exponent),
            (true, true) => gray::Gamma::deep(exponent),
        };
        Self { channels: color.samples(), is_deep, gamma }
    }

    fn append(&self, samples: &[u8], pixels: &mut Vec<u8>) {
        let pixel = samples.chunks_exact(self.channels * if self.is_deep { 2 } else { 1 });
        match (self.is_deep, self.channels >= 3) {
            (_, false) => pixels.extend(pixel.map(|pixel| pixel[0])),
            (false, true) => pixels.extend(pixel.map(|pixel| self.of([pixel[0], pixel[1], pixel[2]]))),
            (true, true) => pixels.extend(
                pixel.map(|pixel| self.of_deep([0, 2, 4].map(|at| u16::from_be_bytes([pixel[at], pixel[at + 1]])))),
            ),
        }
    }

    fn of(&self, samples: [u8; 3]) -> u8 {
        match &self.gamma {
            None => gray::from_rgb(samples),
            Some(gamma) => gamma.gray(samples.map(u16::from)) as u8,
        }
    }

    fn of_deep(&self, samples: [u16; 3]) -> u8 {
        match &self.gamma {
            None => gray::from_deep_rgb(samples),
            Some(gamma) => (gamma.gray(samples) >> 8) as u8,
        }
    }
}

/// The decoder's reason, in words. Texts of its own it quotes as Rust does.
fn jpeg_reason(error: &zune_jpeg::errors::DecodeErrors) -> String {
    use zune_jpeg::errors::DecodeErrors;
    match error {
        DecodeErrors::Format(reason) => reason.clone(),
        DecodeErrors::FormatStatic(reason) => (*reason).to_owned(),
        DecodeErrors::ExhaustedData => "its data end too early".to_owned(),
        other => other.to_string(),
    }
}

fn jpeg(bytes: &[u8]) -> Result<(GrayImage, Orientation), DecodeError> {
    let damaged = |error: zune_jpeg::errors::DecodeErrors| DecodeError::Jpeg(jpeg_reason(&error));
    let options = DecoderOptions::default()
        .set_max_width(LONGEST_SIDE)
        .set_max_height(LONGEST_SIDE)
        // Without it, what is missing of a picture would be gray.
        .set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size(width, height)?;
    // Luma is gray already; other colours are mixed.
    let has_luma = matches!(decoder.input_colorspace(), Some(ColorSpace::YCbCr | ColorSpace::Luma));
    let wanted = if has_luma { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(wanted));
    let samples = decoder.decode().map_err(damaged)?;
    let pixels = match has_luma {
        true => samples,
        false => samples.chunks_exact(3).map(|pixel| gray::from_rgb_rounded([pixel[0], pixel[1], pixel[2]])).collect(),
    };
    let orientation = decoder.exif().map(|exif| orientation::of(exif)).unwrap_or_default();
    Ok((GrayImage { width: width as u32, height: height as u32, pixels }, orientation))
}
