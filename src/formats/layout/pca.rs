//! Principal components: the directions in which a cloud of R^d is widest.
//!
//! In: the coordinates of points.
//! Out: [`Principal`]: the cloud's mean, so many axes, and how much of the variance each of them holds.
//! Invariants: axes are orthonormal and have a fixed sign. They depend on the set of points, to the last bit, not on
//! their order: sums are taken in lexicographic order. Offsets and units do not change them but by rounding.
//! Must not know: what is drawn.
//!
//! Where d is large, axes are those of the Gram matrix of a sample; where d is not and the points are many, of the
//! covariance of a sample. A sample is evenly spaced in lexicographic order. What the axes hold of the variance is
//! taken of all points.

use hopes::topology::Vertices;
use nalgebra::DMatrix;

use super::eigen::{Spectrum, signed};

/// In more dimensions, the Gram matrix of so many points is smaller than the covariance.
const MOST: usize = 256;
/// About so many products are summed for a covariance.
const PRODUCTS: usize = 200_000_000;

/// The main directions of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Principal<const K: usize> {
    mean: Vec<f64>,
    /// Fewer where the cloud is flat.
    axes: Vec<Vec<f64>>,
    /// What each axis holds of the variance, from 0 to 1.
    pub shares: [f64; K],
}

impl<const K: usize> Principal<K> {
    /// The main directions of points.
    pub fn new(points: &Vertices) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| points.compare(a, b));
        let centered = Centered::new(points, &order);
        let axes = if points.dimension() <= MOST { centered.by_covariance(K) } else { centered.by_gram(K) };
        let mut principal = Self { mean: Vec::new(), axes, shares: [0.0; K] };
        principal.shares = principal.shares_of(&centered, &order);
        Self { mean: centered.mean, ..principal }
    }

    /// Where a point is, along the axes, from the mean.
    pub fn place(&self, point: &[f64]) -> [f64; K] {
        self.along(|coordinate| point[coordinate] - self.mean[coordinate])
    }

    fn along(&self, difference: impl Fn(usize) -> f64) -> [f64; K] {
        let mut place = [0.0; K];
        for (place, axis) in place.iter_mut().zip(&self.axes) {
            *place = axis.iter().enumerate().map(|(coordinate, &a)| a * difference(coordinate)).sum();
        }
        place
    }

    fn shares_of(&self, centered: &Centered<'_>, order: &[u32]) -> [f64; K] {
        let (mut held, mut total) = ([0.0; K], 0.0);
        for &point in order {
            let difference = centered.difference(point);
            total += difference.iter().map(|x| x * x).sum::<f64>();
            let along = self.along(|coordinate| difference[coordinate]);
            held.iter_mut().zip(along).for_each(|(held, x)| *held += x * x);
        }
        held.map(|held| if total > 0.0 { held / total } else { 0.0 })
    }
}

/// Points from their mean, in units of the largest difference, so that no square overflows or is lost.
struct Centered<'a> {
    points: &'a Vertices,
    order: &'a [u32],
    mean: Vec<f64>,
    unit: f64,
}

impl<'a> Centered<'a> {
    fn new(points: &'a Vertices, order: &'a [u32]) -> Self {
        let mut mean = vec![0.0; points.dimension()];
        for &point in order {
            mean.iter_mut().zip(points.coordinates(point)).for_each(|(mean, x)| *mean += x);
        }
        mean.iter_mut().for_each(|mean| *mean /= order.len() as f64);
        let largest = |most: f64, &point: &u32| {
            points.coordinates(point).iter().zip(&mean).fold(most, |most, (x, mean)| most.max((x - mean).abs()))
        };
        let unit = order.iter().fold(0.0, largest);
        Self { points, order, mean, unit: if unit > 0.0 { unit } else { 1.0 } }
    }

    fn difference(&self, point: u32) -> Vec<f64> {
        let coordinates = self.points.coordinates(point).iter().zip(&self.mean);
        coordinates.map(|(x, mean)| (x - mean) / self.unit).collect()
    }

    /// At most so many points, evenly spaced in their order.
    fn sample(&self, most: usize) -> impl Iterator<Item = Vec<f64>> {
        let count = self.order.len().min(most);
        (0..count).map(move |place| self.difference(self.order[place * self.order.len() / count]))
    }

    fn by_covariance(&self, axes: usize) -> Vec<Vec<f64>> {
        let dimension = self.mean.len();
        let mut sum = DMatrix::zeros(dimension, dimension);
        for point in self.sample(PRODUCTS / (dimension * dimension).max(1)) {
            for (a, x) in point.iter().enumerate() {
                for (b, y) in point[..=a].iter().enumerate() {
                    sum[(a, b)] += x * y;
                }
            }
        }
        sum.fill_upper_triangle_with_lower_triangle();
        Spectrum::leading(sum / self.order.len() as f64, axes).pairs.into_iter().map(|(_, axis)| axis).collect()
    }

    /// An eigenvector of the Gram matrix says how much of each point is in an axis.
    fn by_gram(&self, axes: usize) -> Vec<Vec<f64>> {
        let sample: Vec<Vec<f64>> = self.sample(MOST).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let gram = DMatrix::from_fn(sample.len(), sample.len(), |a, b| product(&sample[a], &sample[b]));
        let axis = |(_, parts): (f64, Vec<f64>)| {
            let mut axis = vec![0.0; self.mean.len()];
            for (part, point) in parts.iter().zip(&sample) {
                axis.iter_mut().zip(point).for_each(|(axis, x)| *axis += part * x);
            }
            let norm = product(&axis, &axis).sqrt();
            signed(axis.into_iter().map(|x| x / norm).collect())
        };
        Spectrum::leading(gram / self.mean.len() as f64, axes).pairs.into_iter().map(axis).collect()
    }
}

#[cfg(test)]
mod tests {
    use hopes::topology::VertexId;

    use super::*;

    fn vertices(points: &[Vec<f64>]) -> Vertices {
        points.iter().enumerate().map(|(id, point)| (VertexId(id as u64), point.as_slice())).collect()
    }

    /// Points on an ellipsoid with these half-axes along these orthonormal directions; each with its opposite and its
    /// mirror images, so that the directions are exactly the principal ones.
    fn ellipsoid(half_axes: [f64; 3], directions: [[f64; 3]; 3]) -> Vec<Vec<f64>> {
        let mut points = Vec::new();
        for step in 1..40 {
            let (height, turn) = (f64::from(step) / 40.0, f64::from(step) * 2.4);
            let around = (1.0 - height * height).sqrt();
            let [x, y, z] = [around * turn.cos(), around * turn.sin(), height];
            for signs in 0..8_u32 {
                let sign = |axis: u32| if (signs >> axis) & 1 == 0 { 1.0 } else { -1.0 };
                let local = [sign(0) * x * half_axes[0], sign(1) * y * half_axes[1], sign(2) * z * half_axes[2]];
                points.push((0..3).map(|c| 7.0 + (0..3).map(|a| local[a] * directions[a][c]).sum::<f64>()).collect());
            }
        }
        points
    }

    const TURNED: [[f64; 3]; 3] = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]];

    #[test]
    fn the_axes_of_an_ellipsoid_are_found() {
        let points = ellipsoid([9.0, 1.0, 4.0], TURNED);
        let principal = Principal::<2>::new(&vertices(&points));
        for (axis, wanted) in principal.axes.iter().zip([TURNED[0], TURNED[2].map(|x| -x)]) {
            assert!(axis.iter().zip(wanted).all(|(x, y)| (x - y).abs() < 1e-9), "{axis:?}");
        }
        assert!(principal.shares[0] > principal.shares[1] && principal.shares.iter().sum::<f64>() > 0.98);
        let moved: Vec<f64> = (0..3).map(|c| 7.0 + 2.0 * TURNED[0][c] - 3.0 * TURNED[2][c]).collect();
        let [x, y] = principal.place(&moved);
        assert!((x - 2.0).abs() < 1e-9 && (y - 3.0).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn the_order_of_points_does_not_matter_to_the_last_bit() {
        let mut points = ellipsoid([5.0, 5.0, 5.0], TURNED);
        let first = Principal::<3>::new(&vertices(&points));
        points.reverse();
        points.swap(3, 77);
        assert_eq!(Principal::<3>::new(&vertices(&points)), first, "even where all axes are equally long");
    }

    #[test]
    fn many_dimensions_are_as_few() {
        let low = ellipsoid([9.0, 1.0, 4.0], TURNED);
        let high: Vec<Vec<f64>> = low
            .iter()
            .take(200)
            .map(|point| (0..600).map(|c| if c % 200 == 7 { point[c / 200] } else { 3.0 }).collect())
            .collect();
        let few = Principal::<2>::new(&vertices(&low[..200]));
        let many = Principal::<2>::new(&vertices(&high));
        for (low, high) in low.iter().zip(&high) {
            let [a, b] = [few.place(low), many.place(high)];
            assert!((0..2).all(|axis| (a[axis] - b[axis]).abs() < 1e-9), "{a:?} {b:?}");
        }
    }

    #[test]
    fn extremes_have_places() {
        for unit in [1e-150, 1e150] {
            let cloud = vertices(&[vec![unit, 0.0, 0.0], vec![-unit, 0.0, 0.0], vec![0.0, unit / 2.0, 0.0]]);
            let principal = Principal::<3>::new(&cloud);
            assert!((principal.shares[0] - 12.0 / 13.0).abs() < 1e-9, "{:?}", principal.shares);
            assert_eq!(principal.place(&[unit, 0.0, 0.0])[0], unit);
        }
        for cloud in [vec![], vec![vec![1.0, 2.0, 3.0]]] {
            let principal = Principal::<2>::new(&vertices(&cloud));
            assert_eq!((principal.shares, principal.place(&[9.0, 9.0, 9.0])), ([0.0; 2], [0.0; 2]));
        }
    }
}
