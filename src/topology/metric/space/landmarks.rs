//! A sample that covers a space: farthest points, one after the other.
//!
//! In: a space, and how many landmarks are wanted.
//! Out: [`Landmarks`]: which vertices, and how far from them any other is.
//! Invariants: it begins at the first vertex; of points equally far the first is taken; so it depends on the space
//! alone. Landmarks are at positive distance from each other.
//! Must not know: skeletons.
//!
//! The covering radius r bounds what the sample may hide: the diagrams of the two Vietoris-Rips filtrations, with
//! scales as radii, are at most r apart. (Theorem 5.2 of F. Chazal, V. de Silva, S. Oudot, "Persistence stability for
//! geometric complexes", Geometriae Dedicata 173, 2014: twice the Gromov-Hausdorff distance, with scales as diameters.)

use super::Distances;

/// A sample of a space.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmarks {
    /// The vertices chosen, in increasing order.
    pub vertices: Vec<u32>,
    /// The largest distance of any vertex from the nearest one chosen; +infinity if some can not be reached.
    pub covering_radius: f64,
}

/// At most so many landmarks.
pub fn landmarks(space: &dyn Distances, most: usize) -> Landmarks {
    let count = space.count();
    let mut nearest = vec![f64::INFINITY; count];
    let mut row = vec![0.0; count];
    let mut vertices = Vec::new();
    let mut farthest = (f64::INFINITY, 0);
    while vertices.len() < most.min(count) && farthest.0 > 0.0 {
        let chosen = farthest.1;
        vertices.push(chosen as u32);
        space.lengths(chosen as u32, 0, &mut row);
        farthest = (0.0, 0);
        for (vertex, (nearest, &length)) in nearest.iter_mut().zip(&row).enumerate() {
            *nearest = nearest.min(length);
            if *nearest > farthest.0 {
                farthest = (*nearest, vertex);
            }
        }
    }
    vertices.sort_unstable();
    let covering_radius = if vertices.is_empty() { 0.0 } else { 2.0 * space.radius(farthest.0) };
    Landmarks { vertices, covering_radius }
}
