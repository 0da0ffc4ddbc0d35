//! The leading eigenvectors of a symmetric matrix.
//!
//! In: a matrix whose entries are of the order of one.
//! Out: a [`Spectrum`]: the largest eigenvalues that are positive, with their vectors.
//! Invariants: vectors have length one and a fixed sign: the entry of largest magnitude is positive, of equal ones the
//! first. The same matrix gives the same bits.
//! Must not know: what the matrix is of.

use nalgebra::{DMatrix, SymmetricEigen};

/// Eigenvalues below this share of the largest are rounding.
const LEAST: f64 = 1e-10;
/// Entries whose magnitudes differ by less than this share are equally large.
const SAME: f64 = 1e-9;
/// So many steps an eigenvalue are far more than are ever needed.
const STEPS: usize = 1000;

/// The largest eigenvalues of a matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Eigenvalues and their vectors, the largest first.
    pub pairs: Vec<(f64, Vec<f64>)>,
    /// The sum of the magnitudes of all eigenvalues.
    pub total: f64,
}

impl Spectrum {
    /// At most so many eigenvalues; fewer if fewer are positive.
    pub fn leading(matrix: DMatrix<f64>, most: usize) -> Self {
        if matrix.is_empty() {
            return Self::default();
        }
        let steps = STEPS * matrix.nrows();
        let Some(eigen) = SymmetricEigen::try_new(matrix, f64::EPSILON, steps) else { return Self::default() };
        let values = eigen.eigenvalues.as_slice();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        let least = LEAST * order.first().map_or(0.0, |&first| values[first]);
        let chosen = order.into_iter().take(most).filter(|&place| values[place] > least);
        let vector = |place: usize| signed(eigen.eigenvectors.column(place).iter().copied().collect());
        let pairs = chosen.map(|place| (values[place], vector(place))).collect();
        Self { pairs, total: values.iter().map(|value| value.abs()).sum() }
    }
}

/// The vector or its opposite, whichever has the fixed sign.
pub fn signed(mut vector: Vec<f64>) -> Vec<f64> {
    let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let first = vector.iter().copied().find(|x| x.abs() >= largest * (1.0 - SAME));
    if first.is_some_and(|x| x < 0.0) {
        vector.iter_mut().for_each(|x| *x = -*x);
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_positive_eigenvalues_come_first() {
        let matrix = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, -5.0]);
        let spectrum = Spectrum::leading(matrix, 3);
        let values: Vec<f64> = spectrum.pairs.iter().map(|(value, _)| *value).collect();
        assert!(values.len() == 2 && (values[0] - 3.0).abs() < 1e-12 && (values[1] - 1.0).abs() < 1e-12, "{values:?}");
        assert!((spectrum.total - 9.0).abs() < 1e-12);
        let half = 0.5_f64.sqrt();
        for (found, wanted) in spectrum.pairs[1].1.iter().zip([half, -half, 0.0]) {
            assert!((found - wanted).abs() < 1e-12, "{:?}", spectrum.pairs[1].1);
        }
    }

    #[test]
    fn nothing_has_no_eigenvalues() {
        assert_eq!(Spectrum::leading(DMatrix::zeros(0, 0), 2), Spectrum::default());
        assert_eq!(Spectrum::leading(DMatrix::zeros(4, 4), 2), Spectrum::default());
    }

    #[test]
    fn the_largest_entry_is_positive() {
        assert_eq!(signed(vec![0.5, -0.6, 0.1]), [-0.5, 0.6, -0.1]);
        assert_eq!(signed(vec![-0.7, 0.7 + 1e-13]), [0.7, -0.7 - 1e-13], "of equal ones the first");
        assert_eq!(signed(Vec::new()), Vec::<f64>::new());
    }
}
