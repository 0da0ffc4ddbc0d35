//! A snapshot as a picture: the cloud, the tree, the critical edges.
//!
//! In: a snapshot; its stream's name.
//! Out: a self-contained SVG document.
//! Invariants: y points up, and both axes have one scale. Points and edges that fall on the same pixels are drawn once,
//! so the size is bounded by the pixels and not by the cloud. Names, which any producer chooses, are escaped.
//! Must not know: views.
//!
//! The pictures of `hopes compute` also have the persistence diagram, which a snapshot of a view does not contain.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use hopes_protocol::Snapshot;

use super::{position, segment};

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 720.0;
const MARGIN: f64 = 24.0;
const HEADLINE: f64 = 32.0;

/// A position in the picture, in half pixels: smaller distances are invisible.
type Pixel = (i32, i32);

/// The transform from the plane to the picture.
#[derive(Clone, Copy, Debug)]
struct Projection {
    middle: (f64, f64),
    scale: f64,
}

impl Projection {
    fn new(snapshot: &Snapshot) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &(_, x, y) in &snapshot.vertices {
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        let room = [WIDTH - 2.0 * MARGIN, HEIGHT - HEADLINE - 2.0 * MARGIN];
        let scales = [0, 1].map(|axis| room[axis] / (high[axis] - low[axis]));
        // With less than two points any scale will do.
        let scale = scales.into_iter().filter(|scale| scale.is_finite() && *scale > 0.0).fold(f64::INFINITY, f64::min);
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Self { middle: (f64::midpoint(low[0], high[0]), f64::midpoint(low[1], high[1])), scale }
    }

    fn pixel(self, (x, y): (f64, f64)) -> Pixel {
        let across = WIDTH / 2.0 + (x - self.middle.0) * self.scale;
        let down = (HEIGHT + HEADLINE) / 2.0 - (y - self.middle.1) * self.scale;
        // The casts map NaN to 0 and saturate.
        ((across * 2.0).round() as i32, (down * 2.0).round() as i32)
    }
}

/// The document.
pub fn write(name: &str, snapshot: &Snapshot) -> String {
    let projection = Projection::new(snapshot);
    let frame = &snapshot.frame;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         viewBox=\"0 0 {WIDTH} {HEIGHT}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{MARGIN}\" y=\"{HEADLINE}\" font-family=\"sans-serif\" font-size=\"16\" fill=\"#222\">\
         {}: frame {}, {} points, {} components, {} cycles</text>\n",
        escape(name),
        frame.number,
        frame.vertices,
        frame.components,
        frame.cycles,
    );
    let points: BTreeSet<Pixel> = snapshot
        .vertices
        .iter()
        .filter_map(|&(id, ..)| position(snapshot, id))
        .map(|point| projection.pixel(point))
        .collect();
    let dots = points.iter().map(|&pixel| [pixel, pixel]);
    path(&mut out, "vertices", "#9aa4b2", 3.0, dots);
    let line = |a, b| segment(snapshot, a, b).map(|ends| ends.map(|end| projection.pixel(end)));
    let tree: BTreeSet<[Pixel; 2]> =
        snapshot.edges.iter().filter_map(|&(a, b)| line(a, b)).filter(|[a, b]| a != b).collect();
    path(&mut out, "tree", "#33506e", 1.0, tree.into_iter());
    let persistences = snapshot.critical.iter().map(|&(.., birth, death)| death - birth);
    let longest = persistences.filter(|persistence| persistence.is_finite()).fold(0.0, f64::max);
    let mut critical: BTreeMap<[Pixel; 2], f64> = BTreeMap::new();
    for &(a, b, birth, death) in &snapshot.critical {
        if let Some(ends) = line(a, b).filter(|[a, b]| a != b) {
            let persistence = critical.entry(ends).or_default();
            *persistence = persistence.max(death - birth);
        }
    }
    for (ends, persistence) in critical {
        // A cycle that is never filled is as red as any.
        let share = if persistence.is_finite() { persistence / longest } else { 1.0 };
        path(&mut out, "critical", &colour(share), 2.5, [ends].into_iter());
    }
    out.push_str("</svg>\n");
    out
}

/// From blue, for the least persistent cycles, to red.
fn colour(share: f64) -> String {
    let hue = 220.0 * (1.0 - share.clamp(0.0, 1.0));
    format!("hsl({hue:.0},85%,45%)")
}

fn path(out: &mut String, class: &str, colour: &str, width: f64, lines: impl Iterator<Item = [Pixel; 2]>) {
    // Writing into a string does not fail.
    let _ = write!(
        out,
        "<path class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
         stroke-linecap=\"round\" d=\""
    );
    let half = |number: i32| f64::from(number) / 2.0;
    for [(x1, y1), (x2, y2)] in lines {
        let _ = write!(out, "M{} {}L{} {}", half(x1), half(y1), half(x2), half(y2));
    }
    out.push_str("\"/>\n");
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
