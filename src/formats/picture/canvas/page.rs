//! A page of SVG under construction.
//!
//! In: shapes with their attributes, texts, groups.
//! Out: one well-formed document, as a string.
//! Invariants: texts are escaped and free of characters that XML forbids; coordinates have at most two decimals;
//! what is opened is closed by the same call.
//! Must not know: what is drawn.

use std::fmt::{self, Display, Write};

pub use super::colors::{FRAME, GRID, GROUND, INK, MUTED, PANEL};
use super::layout::Rect;

/// The size of most texts.
pub const TEXT_SIZE: f64 = 12.0;

/// A length in pixels, written with at most two decimals.
#[derive(Clone, Copy)]
pub struct Px(pub f64);

impl Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

/// Which end of a text its place is.
#[derive(Clone, Copy)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Clone, Copy)]
pub struct Type<'a> {
    pub size: f64,
    pub anchor: Anchor,
    pub fill: &'a str,
}

impl<'a> Type<'a> {
    pub fn new(anchor: Anchor, fill: &'a str) -> Self {
        Self { size: TEXT_SIZE, anchor, fill }
    }

    pub fn sized(self, size: f64) -> Self {
        Self { size, ..self }
    }
}

/// The document so far.
pub struct Page {
    text: String,
}

impl Page {
    /// Opens a document; `title` and `description` are for screen readers.
    pub fn new([width, height]: [f64; 2], title: &str, description: &str) -> Self {
        let mut page = Self { text: String::new() };
        page.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" \
             font-family=\"Ubuntu,'Segoe UI','Helvetica Neue',Arial,sans-serif\" font-size=\"{TEXT_SIZE}\">\n"
        ));
        page.put(format_args!("<title>{}</title>\n<desc>{}</desc>\n", Escaped(title), Escaped(description)));
        page.put(format_args!("<rect width=\"{width}\" height=\"{height}\" fill=\"{PANEL}\"/>\n"));
        page
    }

    /// The finished document.
    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    /// Adds markup as it is.
    pub fn put(&mut self, markup: fmt::Arguments<'_>) {
        self.text.write_fmt(markup).expect("writing to a string cannot fail");
    }

    /// Adds a panel with coordinates of its own, whose origin is the corner of `rect` and beyond which nothing shows.
    pub fn panel(&mut self, rect: Rect, draw: impl FnOnce(&mut Self)) {
        let [x, y, width, height] = [rect.x, rect.y, rect.width, rect.height].map(Px);
        self.put(format_args!("<svg x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\">\n"));
        draw(self);
        self.put(format_args!("</svg>\n"));
    }

    /// Adds a group with attributes in common.
    pub fn group(&mut self, attributes: impl Display, draw: impl FnOnce(&mut Self)) {
        self.put(format_args!("<g {attributes}>\n"));
        draw(self);
        self.put(format_args!("</g>\n"));
    }

    /// Adds what shows where the pointer rests on the group in hand.
    pub fn hint(&mut self, hint: &str) {
        self.put(format_args!("<title>{}</title>\n", Escaped(hint)));
    }

    /// Adds a path, unless it is empty.
    pub fn path(&mut self, data: &str, attributes: impl Display) {
        if !data.is_empty() {
            self.put(format_args!("<path d=\"{data}\" {attributes}/>\n"));
        }
    }

    /// Adds a rectangle.
    pub fn rect(&mut self, rect: Rect, attributes: impl Display) {
        let [x, y, width, height] = [rect.x, rect.y, rect.width, rect.height].map(Px);
        self.put(format_args!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {attributes}/>\n"));
    }

    /// Adds a straight line.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], attributes: impl Display) {
        let ([x1, y1], [x2, y2]) = (from.map(Px), to.map(Px));
        self.put(format_args!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {attributes}/>\n"));
    }

    /// Adds a circle; a hint, if there is one, shows where the pointer rests on it.
    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, attributes: impl Display, hint: Option<&str>) {
        let [x, y, r] = [x, y, radius].map(Px);
        self.put(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {attributes}"));
        match hint {
            Some(hint) => self.put(format_args!("><title>{}</title></circle>\n", Escaped(hint))),
            None => self.put(format_args!("/>\n")),
        }
    }

    /// Adds a filled polygon.
    pub fn polygon(&mut self, corners: &[[f64; 2]], attributes: impl Display) {
        self.put(format_args!("<polygon points=\""));
        for (index, &[x, y]) in corners.iter().enumerate() {
            let space = if index > 0 { " " } else { "" };
            self.put(format_args!("{space}{},{}", Px(x), Px(y)));
        }
        self.put(format_args!("\" {attributes}/>\n"));
    }

    /// Adds a text.
    pub fn text(&mut self, at: [f64; 2], set: Type<'_>, text: &str) {
        let [x, y] = at.map(Px);
        self.put(format_args!("<text x=\"{x}\" y=\"{y}\" {set}>{}</text>\n", Escaped(text)));
    }

    /// Adds a text that reads upwards.
    pub fn upward_text(&mut self, at: [f64; 2], set: Type<'_>, text: &str) {
        let [x, y] = at.map(Px);
        let turned = format_args!("transform=\"translate({x} {y}) rotate(-90)\"");
        self.put(format_args!("<text {turned} {set}>{}</text>\n", Escaped(text)));
    }
}

impl Display for Type<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fill=\"{}\"", self.fill)?;
        if self.size != TEXT_SIZE {
            write!(f, " font-size=\"{}\"", Px(self.size))?;
        }
        match self.anchor {
            Anchor::Start => Ok(()),
            Anchor::Middle => f.write_str(" text-anchor=\"middle\""),
            Anchor::End => f.write_str(" text-anchor=\"end\""),
        }
    }
}

/// About how wide a text of the usual size is. Fonts differ: leave room.
pub fn text_width(text: &str) -> f64 {
    0.56 * TEXT_SIZE * text.chars().count() as f64
}

/// A text as XML wants it.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{FFFE}' | '\u{FFFF}') => f.write_char(' '),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_short() {
        let written = [1.0, -0.001, 0.125, 12.3456, 1e3].map(|v| Px(v).to_string());
        assert_eq!(written, ["1", "0", "0.13", "12.35", "1000"]);
    }

    #[test]
    fn texts_are_escaped() {
        let mut page = Page::new([10.0, 10.0], "a < b & \"c\"", "\u{0}\u{FFFF}>");
        page.text([0.0, 0.0], Type::new(Anchor::Start, INK), "<&>");
        let text = page.finish();
        assert!(text.contains("<title>a &lt; b &amp; &quot;c&quot;</title>"), "{text}");
        assert!(text.contains("<desc>  &gt;</desc>"), "{text}");
        assert!(roxmltree::Document::parse(&text).is_ok());
    }

    #[test]
    fn groups_are_closed() {
        let mut page = Page::new([10.0, 10.0], "", "");
        let rect = Rect { x: 1.0, y: 2.0, width: 3.0, height: 4.0 };
        page.panel(rect, |page| {
            page.group(format_args!("fill=\"none\""), |page| page.path("M0 0h1", format_args!("")))
        });
        page.path("", format_args!(""));
        let text = page.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.descendants().filter(|node| node.has_tag_name("path")).count(), 1);
    }
}
