//! Classical multidimensional scaling, by landmarks: places whose distances are near to given ones.
//!
//! In: a space all of whose distances are finite, and how many landmarks there may be.
//! Out: a [`Scaling`].
//! Invariants: distances of a Euclidean space of K dimensions are kept but for rounding. It depends on the space alone.
//! Axes have a fixed sign. Work is bounded by the landmarks: their square a vertex, their cube once.
//! Must not know: missing distances, pictures.
//!
//! V. de Silva, J. B. Tenenbaum, "Sparse multidimensional scaling using landmark points", Stanford University, 2004:
//! the landmarks are placed by the eigenvectors of their centred squared distances, all others by their distances from
//! the landmarks.

use hopes::topology::spaces::{Distances, landmarks};
use nalgebra::DMatrix;

use super::eigen::Spectrum;

/// Places of the vertices of a space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scaling<const K: usize> {
    /// Of each vertex.
    pub places: Vec<[f64; K]>,
    /// What the axes hold of the squared distances of landmarks from their mean.
    pub held: f64,
    /// The same, if there were an axis for every eigenvalue; the negative ones count with their magnitudes.
    pub total: f64,
}

impl<const K: usize> Scaling<K> {
    /// Places all vertices, by at most so many landmarks.
    pub fn new(space: &dyn Distances, most: usize) -> Self {
        let chosen = landmarks(space, most).vertices;
        let rows: Vec<Vec<f64>> = chosen.iter().map(|&from| distances(space, from)).collect();
        let unit = rows.iter().flatten().fold(0.0_f64, |most, &distance| most.max(distance));
        if unit == 0.0 {
            return Self { places: vec![[0.0; K]; space.count()], held: 0.0, total: 0.0 };
        }
        let square = |distance: f64| (distance / unit) * (distance / unit);
        let squares = DMatrix::from_fn(chosen.len(), chosen.len(), |a, b| square(rows[a][chosen[b] as usize]));
        let means: Vec<f64> = squares.column_iter().map(|column| column.mean()).collect();
        let mean = squares.mean();
        let centered =
            DMatrix::from_fn(chosen.len(), chosen.len(), |a, b| 0.5 * (means[a] + means[b] - mean - squares[(a, b)]));
        let spectrum = Spectrum::leading(centered, K);
        let place = |vertex: usize| {
            let mut place = [0.0; K];
            for (place, (value, vector)) in place.iter_mut().zip(&spectrum.pairs) {
                let parts = vector.iter().zip(&means).zip(&rows);
                let sum: f64 = parts.map(|((part, mean), row)| part * (mean - square(row[vertex]))).sum();
                *place = unit * 0.5 * sum / value.sqrt();
            }
            place
        };
        let held = spectrum.pairs.iter().map(|(value, _)| value).sum();
        Self { places: (0..space.count()).map(place).collect(), held, total: spectrum.total }
    }
}

/// The distances of one vertex from all.
fn distances(space: &dyn Distances, from: u32) -> Vec<f64> {
    let mut row = vec![0.0; space.count()];
    space.lengths(from, 0, &mut row);
    row.iter_mut().for_each(|length| *length = 2.0 * space.radius(*length));
    row
}

#[cfg(test)]
mod tests {
    use hopes::topology::spaces::{Matrix, Metric, Points};

    use super::*;

    fn cloud(count: u32) -> Vec<f64> {
        (0..count).flat_map(|i| [f64::from(i % 17) * 1.3, f64::from(i * i % 23)]).collect()
    }

    fn between(a: [f64; 2], b: [f64; 2]) -> f64 {
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    fn keeps_distances(space: &dyn Distances, most: usize, tolerance: f64) {
        let scaling = Scaling::<2>::new(space, most);
        for a in 0..space.count() as u32 {
            for (b, wanted) in distances(space, a).into_iter().enumerate() {
                let found = between(scaling.places[a as usize], scaling.places[b]);
                assert!((found - wanted).abs() <= tolerance, "{a} {b}: {found}, not {wanted}");
            }
        }
        assert!((scaling.held / scaling.total - 1.0).abs() < 1e-9);
    }

    #[test]
    fn distances_of_the_plane_are_kept() {
        let points = Points::new(Metric::Euclidean, 2, &cloud(300)).unwrap();
        keeps_distances(&points, 300, 1e-9);
        keeps_distances(&points, 5, 1e-9);
    }

    #[test]
    fn units_of_any_magnitude_are_kept() {
        for unit in [1e-300, 1e300] {
            let space = Matrix::from_lower(3, &[3.0 * unit, 4.0 * unit, 5.0 * unit]).unwrap();
            keeps_distances(&space, 3, 1e-12 * unit);
        }
    }

    #[test]
    fn few_and_equal_vertices_have_places() {
        assert_eq!(Scaling::<2>::new(&Matrix::from_lower(0, &[]).unwrap(), 9).places, Vec::<[f64; 2]>::new());
        assert_eq!(Scaling::<3>::new(&Matrix::from_lower(2, &[0.0]).unwrap(), 9).places, [[0.0; 3]; 2]);
        let two = Matrix::from_lower(2, &[6.0]).unwrap();
        keeps_distances(&two, 9, 1e-12);
        assert!((Scaling::<2>::new(&two, 9).places[0][0] - 3.0).abs() < 1e-12, "the first is on the positive side");
    }
}
