//! A snapshot as GeoJSON (RFC 7946).
//!
//! In: a snapshot.
//! Out: a FeatureCollection as `hopes compute --format geojson` writes it, without the holes, which a snapshot does not
//! have: the vertices as one MultiPoint, the tree as one MultiLineString, each critical edge as a LineString with its
//! label.
//! Invariants: an edge whose vertices the snapshot lacks is left out.
//! Must not know: streams.

use hopes_protocol::Snapshot;
use serde_json::{Value, json};

use super::{position, segment};

/// The collection, one feature on a line.
pub fn write(snapshot: &Snapshot) -> serde_json::Result<Vec<u8>> {
    let mut out = b"{\"type\":\"FeatureCollection\",\"features\":[\n".to_vec();
    let mut separator: &[u8] = b"";
    for feature in features(snapshot) {
        out.extend_from_slice(separator);
        serde_json::to_writer(&mut out, &feature)?;
        separator = b",\n";
    }
    out.extend_from_slice(b"\n]}\n");
    Ok(out)
}

fn features(snapshot: &Snapshot) -> impl Iterator<Item = Value> {
    let vertices: Vec<_> = snapshot.vertices.iter().filter_map(|&(id, ..)| position(snapshot, id)).collect();
    let tree: Vec<_> = snapshot.edges.iter().filter_map(|&(a, b)| segment(snapshot, a, b)).collect();
    let components = snapshot.frame.components;
    let whole = [
        feature("MultiPoint", json!(vertices), json!({"role": "vertices", "frame": snapshot.frame.number})),
        feature("MultiLineString", json!(tree), json!({"role": "tree", "components": components})),
    ];
    let critical = snapshot.critical.iter().filter_map(|&(a, b, birth, death)| {
        let label = json!({"role": "critical", "birth": birth, "death": death, "persistence": death - birth});
        Some(feature("LineString", json!(segment(snapshot, a, b)?), label))
    });
    whole.into_iter().chain(critical)
}

fn feature(kind: &str, coordinates: Value, properties: Value) -> Value {
    json!({"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties})
}
