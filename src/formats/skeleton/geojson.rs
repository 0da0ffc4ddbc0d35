//! The view as GeoJSON (RFC 7946), for maps and for all programs that read features.
//!
//! In: an [`Answer`] of points in two dimensions.
//! Out: a FeatureCollection: the vertices as one MultiPoint; the tree as one MultiLineString; every critical edge
//! as a LineString and its hole's centre, if it has one, as a Point, both with the label; the simplified view, if
//! asked for, as one more MultiLineString.
//! Invariants: coordinates are written as they are, but as degrees where metres were made of degrees. For a map they
//! must be longitudes and latitudes. Births, deaths and thresholds are in the units of the skeleton.
//! Must not know: files.

use std::io::{self, Write};
use std::iter;

use hopes::topology::{Dot, Edge};
use serde_json::{Value, json};

use super::Answer;

/// Writes the collection, one feature a line.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    out.write_all(b"{\"type\":\"FeatureCollection\",\"features\":[\n")?;
    let mut separator = "";
    for feature in features(answer) {
        out.write_all(separator.as_bytes())?;
        serde_json::to_writer(&mut *out, &feature)?;
        separator = ",\n";
    }
    out.write_all(b"\n]}\n")
}

fn features<'a>(answer: &'a Answer<'a>) -> impl Iterator<Item = Value> + 'a {
    let vertices: Vec<[f64; 2]> = answer.skeleton.vertices().positions().map(|point| place(answer, point)).collect();
    let tree: Vec<[[f64; 2]; 2]> = answer.view.tree.iter().map(|&edge| segment(answer, edge)).collect();
    let whole = [
        feature("MultiPoint", json!(vertices), json!({"role": "vertices"})),
        feature("MultiLineString", json!(tree), json!({"role": "tree", "components": answer.view.components})),
    ];
    let dots = answer.view.critical.iter().map(|&index| &answer.skeleton.dots()[index as usize]);
    whole.into_iter().chain(dots.flat_map(|dot| of_dot(answer, dot))).chain(simplified(answer))
}

fn of_dot(answer: &Answer, dot: &Dot) -> impl Iterator<Item = Value> {
    let label =
        |role: &str| json!({"role": role, "birth": dot.birth, "death": dot.death, "persistence": dot.persistence()});
    let critical = feature("LineString", json!(segment(answer, dot.edge)), label("critical"));
    let hole = answer.skeleton.hole(dot);
    let hole = hole.map(|hole| feature("Point", json!(place(answer, hole.center)), label("hole")));
    iter::once(critical).chain(hole)
}

fn simplified(answer: &Answer) -> Option<Value> {
    let (threshold, simplified) = answer.simplified?;
    let at = |vertex: u32| place(answer, simplified.positions.planar()[vertex as usize]);
    let lines: Vec<[[f64; 2]; 2]> = simplified.edges.iter().map(|edge| edge.map(at)).collect();
    Some(feature("MultiLineString", json!(lines), json!({"role": "simplified", "threshold": threshold})))
}

/// Where a map has a point.
fn place(answer: &Answer, point: [f64; 2]) -> [f64; 2] {
    answer.projection.map_or(point, |projection| projection.degrees(point))
}

fn segment(answer: &Answer, edge: Edge) -> [[f64; 2]; 2] {
    answer.segment(edge).map(|end| place(answer, end))
}

fn feature(kind: &str, coordinates: Value, properties: Value) -> Value {
    json!({"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties})
}
