//! SVG to PNG, the same on every machine.
//!
//! In: an SVG document, a scale. Out: the bytes of a PNG file. Invariants: no file and no font of the system is read, texts are set in one
//! built-in font; documents without a size, and sizes that would fill the memory, are refused. Must not know: what the picture shows.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, Options, Tree, fontdb};
use thiserror::Error;

/// The longest side of a PNG, in pixels.
const LONGEST: f32 = 16_384.0;

/// The built-in font is thin: lines of this width around the letters make it regular.
const EMBOLDEN: &str = "text { stroke-width: 0.3; stroke: #1b2432; stroke-opacity: 0.6 }";

/// Why a picture has no PNG.
#[derive(Debug, Error)]
pub enum PictureError {
    /// The document is not SVG.
    #[error("the picture is not valid SVG: {0}")]
    Svg(#[from] usvg::Error),
    /// No pixel, or too many.
    #[error("a picture of {width} x {height} pixels cannot be made: its sides must be from 1 to 16384")]
    Size {
        /// Width asked for.
        width: f32,
        /// Height asked for.
        height: f32,
    },
    /// The encoder failed.
    #[error("the picture cannot be encoded as PNG: {0}")]
    Encode(String),
}

/// Rasterises an SVG document, `scale` pixels for each of its units.
///
/// # Errors
/// [`PictureError`].
pub fn png(svg: &str, scale: f32) -> Result<Vec<u8>, PictureError> {
    let tree = Tree::from_str(svg, &options())?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| (side * scale).round());
    let fits = |side: f32| (1.0..=LONGEST).contains(&side);
    let refusal = PictureError::Size { width, height };
    if !fits(width) || !fits(height) {
        return Err(refusal);
    }
    let mut pixmap = Pixmap::new(width as u32, height as u32).ok_or(refusal)?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|error| PictureError::Encode(error.to_string()))
}

fn options() -> Options<'static> {
    Options { fontdb: Arc::clone(&FONTS), style_sheet: Some(EMBOLDEN.to_owned()), ..Options::default() }
}

/// One font, for every family that a document may ask for.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().find_map(|face| face.families.first()).map(|(name, _)| name.clone());
    if let Some(family) = family {
        fonts.set_serif_family(&family);
        fonts.set_sans_serif_family(&family);
        fonts.set_monospace_family(&family);
    }
    Arc::new(fonts)
});
