//! What pictures are drawn with: a page of SVG, and the arithmetic of places, numbers and colours.
//!
//! In: values of any magnitude, the size of a page.
//! Out: places in pixels, labels, colours, shapes as text.
//! Invariants: the same input gives the same bytes; the size of a document is bounded by its pixels.
//! Must not know: skeletons, tracks.

pub mod axis;
pub mod camera;
pub mod colors;
pub mod labels;
pub mod layout;
pub mod marks;
pub mod numbers;
pub mod page;
pub mod ramp;
