//! A gray image in memory.
//!
//! Must not know: files, formats, what is looked for in images.

/// A gray image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GrayImage {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row.
    pub pixels: Vec<u8>,
}
