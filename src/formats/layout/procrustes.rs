//! Procrustes: the rigid motion that brings a layout nearest to the one before.
//!
//! In: pairs of places, now and before.
//! Out: a [`Motion`].
//! Invariants: lengths stay as they are; a reflection is a motion too. The sum of the squared distances from where
//! the places were is least.
//! Must not know: which vertices the places are of.
//!
//! P. H. Schönemann, "A generalized solution of the orthogonal Procrustes problem", Psychometrika 31, 1966.

use nalgebra::DMatrix;

/// A place now, and where it was before.
pub type Pair<const K: usize> = ([f64; K], [f64; K]);

/// A rotation or reflection, and a shift.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion<const K: usize> {
    from: [f64; K],
    to: [f64; K],
    /// The image of each axis.
    turn: [[f64; K]; K],
}

impl<const K: usize> Motion<K> {
    /// The motion that fits pairs (now, before) best; none without a pair.
    pub fn fitting(pairs: &[Pair<K>]) -> Option<Self> {
        if pairs.is_empty() {
            return None;
        }
        let mean = |place: fn(&Pair<K>) -> [f64; K]| {
            let mut mean = [0.0; K];
            for pair in pairs {
                mean.iter_mut().zip(place(pair)).for_each(|(mean, x)| *mean += x / pairs.len() as f64);
            }
            mean
        };
        let (from, to) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let differences = |(now, before): &Pair<K>| {
            let from: [f64; K] = std::array::from_fn(|axis| now[axis] - from[axis]);
            let to: [f64; K] = std::array::from_fn(|axis| before[axis] - to[axis]);
            (from, to)
        };
        let pairs: Vec<Pair<K>> = pairs.iter().map(differences).collect();
        Some(Self { from, to, turn: nearest_turn(&pairs)? })
    }

    /// Where a place comes to be.
    pub fn place(&self, place: [f64; K]) -> [f64; K] {
        let mut moved = self.to;
        for (axis, image) in self.turn.iter().enumerate() {
            let by = place[axis] - self.from[axis];
            moved.iter_mut().zip(image).for_each(|(moved, x)| *moved += by * x);
        }
        moved
    }
}

/// From the singular vectors of the covariance of both. None if it has none.
fn nearest_turn<const K: usize>(pairs: &[Pair<K>]) -> Option<[[f64; K]; K]> {
    let largest = |place: fn(&Pair<K>) -> &[f64; K]| {
        pairs.iter().flat_map(place).fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()))
    };
    let units = [largest(|pair| &pair.0), largest(|pair| &pair.1)];
    let mut sum = DMatrix::<f64>::zeros(K, K);
    for (now, before) in pairs {
        for (a, x) in now.iter().enumerate() {
            for (b, y) in before.iter().enumerate() {
                sum[(a, b)] += (x / units[0]) * (y / units[1]) / pairs.len() as f64;
            }
        }
    }
    let svd = sum.try_svd(true, true, f64::EPSILON, 1000)?;
    let turn = svd.u? * svd.v_t?;
    Some(std::array::from_fn(|a| std::array::from_fn(|b| turn[(a, b)])))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOUD: [[f64; 3]; 5] = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.5], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 4.0, 2.0]];

    #[test]
    fn a_rotation_and_a_reflection_are_undone() {
        for mirror in [1.0, -1.0] {
            let moved = CLOUD.map(|[x, y, z]| [5.0 + 0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y - 9.0, mirror * z + 2.0]);
            let pairs: Vec<([f64; 3], [f64; 3])> = moved.into_iter().zip(CLOUD).collect();
            let motion = Motion::fitting(&pairs).unwrap();
            for (moved, place) in pairs {
                let back = motion.place(moved);
                assert!((0..3).all(|axis| (back[axis] - place[axis]).abs() < 1e-12), "{back:?} {place:?}");
            }
        }
    }

    #[test]
    fn lengths_stay_even_where_nothing_fits() {
        let pairs = [([0.0, 1.0], [1e9, 7.0]), ([2.0, 5.0], [1e9, -3.0]), ([4.0, 4.0], [2e9, 4.0])];
        let motion = Motion::fitting(&pairs).unwrap();
        let [a, b] = [[0.0, 0.0], [3.0, 4.0]].map(|place| motion.place(place));
        assert!(((a[0] - b[0]).hypot(a[1] - b[1]) - 5.0).abs() < 1e-6);
    }

    #[test]
    fn one_pair_shifts_and_none_does_nothing() {
        let motion = Motion::fitting(&[([1.0, 2.0], [5.0, 5.0])]).unwrap();
        assert_eq!((motion.place([1.0, 2.0]), motion.place([1.0, 3.0])), ([5.0, 5.0], [5.0, 6.0]));
        assert_eq!(Motion::<2>::fitting(&[]), None);
    }
}
