//! Accurate sums.
//!
//! In: numbers.
//! Out: their sum.
//! Invariant: the error does not grow with the number of terms.

/// The sum of some numbers with an error that does not grow with their number (Neumaier's algorithm).
pub fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
    }
    sum + lost
}
