//! Lives as bars: when things were there, how strong they were, which came of which.
//!
//! In: bars from top to bottom, links between them.
//! Out: an SVG document.
//! Invariants: the same input gives the same bytes. The size of the document is bounded by bars, stretches and
//! links. It needs no other file, and has a ground of its own, so it shows on light and dark pages alike.
//! Must not know: tracks, streams, why bars stand as they do.

use super::canvas::axis::Axis;
use super::canvas::colors::{DIAGONAL, VERTICAL};
use super::canvas::layout::Rect;
use super::canvas::page::{Anchor, FRAME, GRID, GROUND, INK, MUTED, Page, Type, text_width};
use super::canvas::ramp::{Ramp, STOPS};
use super::legend;

/// What is to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Barcode {
    pub title: String,
    /// Numbers about the picture, on one line.
    pub facts: String,
    /// What the axis shows; `frame` has whole numbers only.
    pub axis: &'static str,
    /// The ends of the axis; their difference is finite.
    pub range: [f64; 2],
    /// From top to bottom.
    pub bars: Vec<Bar>,
    pub links: Vec<Link>,
}

/// A life.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    pub from: f64,
    pub to: f64,
    /// Stretches that are paler.
    pub pale: Vec<[f64; 2]>,
    /// The value that its colour stands for.
    pub strength: f64,
    /// Whether it does not end at its end.
    pub goes_on: bool,
    /// What stands beside it.
    pub name: String,
    /// What shows where the pointer rests on it.
    pub hint: String,
}

/// Two bars that have to do with each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    pub at: f64,
    /// Indices of bars: the one that goes on, the one that begins or ends.
    pub bars: [usize; 2],
    pub kind: LinkKind,
}

/// What a link stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkKind {
    /// The second came of the first.
    Split,
    /// The second became a part of the first.
    Merger,
}

impl LinkKind {
    fn color(self) -> &'static str {
        match self {
            Self::Split => DIAGONAL,
            Self::Merger => VERTICAL,
        }
    }

    fn class(self) -> &'static str {
        match self {
            Self::Split => "split",
            Self::Merger => "merger",
        }
    }
}

const WIDTH: f64 = 1200.0;
const MARGIN: f64 = 24.0;
/// Title and facts.
const HEADER: f64 = 80.0;
/// Numbers and name of the axis, samples.
const FOOTER: f64 = 84.0;
/// The colour bar and its numbers.
const BAR: f64 = 104.0;
/// Longest name that is shown whole, in characters.
const NAME: usize = 20;
/// Room for a bar, where there are few and where there are many.
const ROWS: [f64; 2] = [16.0, 5.0];
/// The panel becomes no higher than that as long as rows can be made thinner.
const TALL: f64 = 1600.0;
/// The least height of the panel.
const LOW: f64 = 120.0;
/// Rows lower than this have no names.
const NAMED: f64 = 11.0;
/// The least width of a bar.
const LEAST: f64 = 2.0;
const PALE: &str = "fill-opacity=\".3\"";

/// Draws lives as bars.
///
/// # Panics
/// When a link names a bar that is not there.
pub fn barcode(barcode: &Barcode) -> String {
    let chart = Chart::new(barcode);
    let mut page = Page::new(chart.size, &barcode.title, &description(barcode));
    page.text([MARGIN, 36.0], Type::new(Anchor::Start, INK).sized(20.0), &barcode.title);
    page.text([MARGIN, 58.0], Type::new(Anchor::Start, MUTED).sized(14.0), &barcode.facts);
    chart.draw(&mut page);
    let bar = Rect { x: chart.panel.right() + 40.0, width: 12.0, height: chart.panel.height.min(420.0), ..chart.panel };
    legend::draw_bar(&mut page, bar, chart.ramp);
    page.finish()
}

fn description(barcode: &Barcode) -> String {
    let kinds = |kind| barcode.links.iter().filter(|link| link.kind == kind).count();
    format!(
        "Bars from left to right, one for each life, over the {}: {} bars, {} splits and {} mergers between them.",
        barcode.axis,
        barcode.bars.len(),
        kinds(LinkKind::Split),
        kinds(LinkKind::Merger),
    )
}

struct Chart<'a> {
    barcode: &'a Barcode,
    size: [f64; 2],
    panel: Rect,
    row: f64,
    axis: Axis,
    ramp: Ramp,
}

impl<'a> Chart<'a> {
    fn new(barcode: &'a Barcode) -> Self {
        let count = barcode.bars.len().max(1) as f64;
        let row = (TALL / count).clamp(ROWS[1], ROWS[0]);
        let names = barcode.bars.iter().map(|bar| text_width(&tail(&bar.name)));
        let gutter = if row >= NAMED { names.fold(0.0, f64::max) + 10.0 } else { 4.0 };
        let height = (row * count + 16.0).max(LOW);
        let x = MARGIN + gutter;
        let panel = Rect { x, y: HEADER, width: WIDTH - MARGIN - BAR - x, height };
        let strengths = barcode.bars.iter().map(|bar| bar.strength);
        // Room for the marks at both ends.
        let axis = Axis::new(barcode.range, panel.width - 20.0, barcode.axis == "frame");
        let ramp = Ramp::new(strengths.fold(0.0, f64::max));
        Self { barcode, size: [WIDTH, HEADER + height + FOOTER], panel, row, axis, ramp }
    }

    fn x(&self, value: f64) -> f64 {
        self.panel.x + 10.0 + self.axis.place(value)
    }

    /// The middle of a row.
    fn y(&self, row: usize) -> f64 {
        self.panel.y + 8.0 + self.row * (row as f64 + 0.5)
    }

    fn thickness(&self) -> f64 {
        0.6 * self.row
    }

    fn draw(&self, page: &mut Page) {
        page.rect(self.panel.grown(0.5), format_args!("fill=\"{GROUND}\" stroke=\"{FRAME}\""));
        self.draw_axis(page);
        if self.barcode.bars.is_empty() {
            let middle = [self.panel.x + self.panel.width / 2.0, self.panel.y + self.panel.height / 2.0];
            page.text(middle, Type::new(Anchor::Middle, MUTED), "no tracks");
        }
        for (row, bar) in self.barcode.bars.iter().enumerate() {
            self.draw_bar(page, self.y(row), bar);
        }
        for link in &self.barcode.links {
            self.draw_link(page, link);
        }
        self.draw_samples(page);
    }

    fn draw_axis(&self, page: &mut Page) {
        let bottom = self.panel.bottom();
        for (value, label) in self.axis.ticks() {
            let x = self.x(value);
            page.line([x, self.panel.y], [x, bottom], format_args!("stroke=\"{GRID}\""));
            page.line([x, bottom], [x, bottom + 5.0], format_args!("stroke=\"{FRAME}\""));
            page.text([x, bottom + 18.0], Type::new(Anchor::Middle, MUTED), &label);
        }
        let name = Type::new(Anchor::Middle, INK).sized(13.0);
        page.text([self.panel.x + self.panel.width / 2.0, bottom + 38.0], name, self.barcode.axis);
    }

    /// All of a life in pale, then over it in full what is not.
    fn draw_bar(&self, page: &mut Page, y: f64, bar: &Bar) {
        let color = self.ramp.bucket(bar.strength).color();
        if self.row >= NAMED {
            page.text([self.panel.x - 6.0, y + 4.0], Type::new(Anchor::End, MUTED), &tail(&bar.name));
        }
        page.group(format_args!("class=\"bar\" fill=\"{color}\""), |page| {
            page.hint(&bar.hint);
            page.rect(self.stretch(y, bar.from, bar.to), PALE);
            let mut from = bar.from;
            for &[pale_from, pale_to] in &bar.pale {
                self.draw_full(page, y, from, pale_from);
                from = pale_to;
            }
            // A life of one frame shows too.
            if bar.pale.is_empty() {
                page.rect(self.stretch(y, from, bar.to), "class=\"full\"");
            } else {
                self.draw_full(page, y, from, bar.to);
            }
            if bar.goes_on {
                let (x, half) = (self.x(bar.to).max(self.x(bar.from) + LEAST), self.thickness() / 2.0);
                page.polygon(&[[x, y - half], [x + half, y], [x, y + half]], "class=\"on\"");
            }
        });
    }

    fn draw_full(&self, page: &mut Page, y: f64, from: f64, to: f64) {
        if from < to {
            page.rect(self.stretch(y, from, to), "class=\"full\"");
        }
    }

    fn stretch(&self, y: f64, from: f64, to: f64) -> Rect {
        let [left, right] = [from, to].map(|at| self.x(at));
        let height = self.thickness();
        Rect { x: left, y: y - height / 2.0, width: (right - left).max(LEAST), height }
    }

    fn draw_link(&self, page: &mut Page, link: &Link) {
        let x = self.x(link.at);
        let [on, other] = link.bars.map(|row| {
            assert!(row < self.barcode.bars.len(), "a link to bar {row} of {}", self.barcode.bars.len());
            [x, self.y(row)]
        });
        let (class, color) = (link.kind.class(), link.kind.color());
        page.line(on, other, format_args!("class=\"{class}\" stroke=\"{color}\" stroke-width=\"1.5\""));
        page.circle(on, 2.5, format_args!("fill=\"{color}\""), None);
    }

    /// What marks mean, below the axis; only what is there.
    fn draw_samples(&self, page: &mut Page) {
        let Barcode { bars, links, .. } = self.barcode;
        let y = self.panel.bottom() + 62.0;
        let mut x = self.panel.x;
        let mut name = |page: &mut Page, text: &str| {
            page.text([x + 32.0, y + 4.0], Type::new(Anchor::Start, MUTED), text);
            let at = x;
            x += 32.0 + text_width(text) + 18.0;
            at
        };
        let dark = STOPS[STOPS.len() - 2];
        let sample = |x: f64| Rect { x, y: y - 5.0, width: 24.0, height: 10.0 };
        if !bars.is_empty() {
            let x = name(page, "a track, coloured by its greatest persistence");
            page.rect(sample(x), format_args!("fill=\"{dark}\""));
        }
        if bars.iter().any(|bar| !bar.pale.is_empty()) {
            let x = name(page, "not selected by the view");
            page.rect(sample(x), format_args!("fill=\"{dark}\" {PALE}"));
        }
        for (kind, text) in [(LinkKind::Split, "split"), (LinkKind::Merger, "merger")] {
            if links.iter().any(|link| link.kind == kind) {
                let (x, color) = (name(page, text) + 12.0, kind.color());
                page.line([x, y - 8.0], [x, y + 8.0], format_args!("stroke=\"{color}\" stroke-width=\"1.5\""));
                page.circle([x, y - 8.0], 2.5, format_args!("fill=\"{color}\""), None);
            }
        }
        if bars.iter().any(|bar| bar.goes_on) {
            let x = name(page, "alive at the end") + 10.0;
            page.polygon(&[[x, y - 5.0], [x + 5.0, y], [x, y + 5.0]], format_args!("fill=\"{dark}\""));
        }
    }
}

/// A name of bounded length: its end tells one bar from another.
fn tail(name: &str) -> String {
    let count = name.chars().count();
    if count <= NAME {
        return name.to_owned();
    }
    ['\u{2026}'].into_iter().chain(name.chars().skip(count - NAME + 1)).collect()
}
