//! Colours of pictures.
//!
//! In: nothing. Out: constants.
//! Invariants: what is drawn has a contrast of at least 3 to its ground. The live page has the same colours (light
//! scheme of its style sheet, by the same names); a test compares them, so whoever changes one changes the other.
//! Must not know: shapes.

/// Text, and what must stand out.
pub const INK: &str = "#1b2432";
/// What explains.
pub const MUTED: &str = "#566072";
/// The ground of a picture.
pub const PANEL: &str = "#ffffff";
/// Points.
pub const POINT: &str = "#3c4a5e";
/// Tree edges.
pub const EDGE: &str = "#707d90";
/// The diagonal gaps of a diagram.
pub const DIAGONAL: &str = "#0b7d62";
/// The vertical gaps of a diagram.
pub const VERTICAL: &str = "#2563c9";
/// The scale of a reduced view.
pub const SCALE: &str = "#9a3412";
/// Dots that are not chosen.
pub const OTHER: &str = "#7f8a9b";
/// Frames.
pub const FRAME: &str = "#c9d0da";
/// The ground of panels.
pub const GROUND: &str = "#fbfcfd";
/// Grid lines.
pub const GRID: &str = "#e9edf2";
