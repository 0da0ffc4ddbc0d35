//! SVG to PNG, the same on every machine.
//!
//! In: an SVG document, a scale.
//! Out: the bytes of a PNG file.
//! Invariants: no file and no font of the system is read, texts are set in one built-in font; documents without a
//! size, and sizes that would fill the memory, are refused.
//! Must not know: what the picture shows.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, Options, Tree, fontdb};
use thiserror::Error;

/// The most pixels of a PNG: 400 MB in memory.
const MOST: f32 = 1e8;

/// The built-in font is thin: lines of this width around the letters make it regular.
const EMBOLDEN: &str = "text { stroke-width: 0.3; stroke: #1b2432; stroke-opacity: 0.6 }";

/// Why a picture has no PNG.
#[derive(Debug, Error)]
pub enum PictureError {
    /// The document is not SVG.
    #[error("the picture is not valid SVG: {0}")]
    Svg(#[from] usvg::Error),
    /// No pixel, or too many.
    #[error("a picture of {width} x {height} pixels cannot be made: a side needs 1, all of it at most 100 million")]
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
    let fits = width >= 1.0 && height >= 1.0 && width * height <= MOST;
    let pixmap = if fits { Pixmap::new(width as u32, height as u32) } else { None };
    let mut pixmap = pixmap.ok_or(PictureError::Size { width, height })?;
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

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\">\
                          <rect width=\"40\" height=\"20\" fill=\"#fff\"/>";

    fn pixels(body: &str, scale: f32) -> Pixmap {
        let bytes = png(&format!("{SQUARE}{body}</svg>"), scale).unwrap();
        Pixmap::decode_png(&bytes).unwrap()
    }

    fn dark(pixmap: &Pixmap) -> usize {
        pixmap.pixels().iter().filter(|pixel| pixel.green() < 128).count()
    }

    #[test]
    fn the_size_is_scaled() {
        for (scale, size) in [(1.0, (40, 20)), (2.5, (100, 50)), (0.1, (4, 2))] {
            let pixmap = pixels("", scale);
            assert_eq!((pixmap.width(), pixmap.height()), size);
            assert_eq!(dark(&pixmap), 0);
        }
    }

    #[test]
    fn texts_show_whatever_their_family() {
        for family in ["Ubuntu", "no such font,sans-serif", "monospace"] {
            let text = format!("<text x=\"2\" y=\"16\" font-size=\"16\" font-family=\"{family}\">HoPeS</text>");
            assert!(dark(&pixels(&text, 1.0)) > 40, "{family}");
        }
    }

    #[test]
    fn the_font_has_all_signs_of_a_picture() {
        for sign in ["\u{221e}", "\u{b7}", "\u{d7}", "\u{3b1}", "\u{2026}"] {
            let text = |sign| pixels(&format!("<text x=\"2\" y=\"16\" font-family=\"Ubuntu\">{sign}</text>"), 4.0);
            let (known, unknown) = (text(sign), text("\u{e123}"));
            assert!(known.data() != unknown.data() && known.data() != text(" ").data(), "{sign}");
        }
    }

    #[test]
    fn dots_of_no_length_show() {
        let dot = "<path d=\"M10 10h0m9 0h0\" stroke=\"#000\" stroke-width=\"6\" stroke-linecap=\"round\"/>";
        let dark = dark(&pixels(dot, 1.0));
        assert!((40..=72).contains(&dark), "two discs of radius 3 have about 56 pixels, not {dark}");
    }

    #[test]
    fn refusals_say_why() {
        let refusal = |svg: &str, scale| png(svg, scale).unwrap_err().to_string();
        assert!(refusal("<svg", 1.0).starts_with("the picture is not valid SVG"));
        for scale in [0.0, -1.0, 1e-3, 1e9, f32::NAN, f32::INFINITY] {
            assert!(refusal(&format!("{SQUARE}</svg>"), scale).contains("cannot be made"), "{scale}");
        }
    }
}
