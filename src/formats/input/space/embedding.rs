//! Delay vectors: a series of numbers as points, so that what repeats in it becomes a cycle.
//!
//! In: an [`Embedding`], and samples one by one.
//! Out: for every sample s[t] with enough others before it, (s[t - (D-1) L], ..., s[t - L], s[t]).
//! Invariants: no vector holds samples from both sides of a gap; of the series, the last (D-1) L + 1 samples are kept.
//! Must not know: where samples come from.

use std::collections::VecDeque;

use thiserror::Error;

/// How a series becomes points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedding {
    dimension: usize,
    lag: usize,
}

/// Why a series cannot become points so.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum EmbeddingError {
    /// Not in a space that is known.
    #[error("{dimension} is no dimension: a vector has from 2 to {} samples", Embedding::MOST_DIMENSION)]
    Dimension {
        /// The number of samples in a vector.
        dimension: usize,
    },
    /// The same sample over and over.
    #[error("0 is no lag: it is a number of samples, from 1")]
    NoLag,
    /// More samples than are kept.
    #[error(
        "{dimension} samples at a distance of {lag} span more than {} samples: take fewer, or a smaller lag",
        Embedding::MOST_SAMPLES
    )]
    TooLong {
        /// The number of samples in a vector.
        dimension: usize,
        /// How far apart they are.
        lag: usize,
    },
}

impl Embedding {
    /// The most samples in a vector.
    pub const MOST_DIMENSION: usize = super::MOST_COORDINATES;

    /// The most that dimension times lag may be.
    pub const MOST_SAMPLES: usize = 1 << 20;

    /// Vectors of so many samples, each so many after the one before.
    ///
    /// # Errors
    /// [`EmbeddingError`].
    pub fn new(dimension: usize, lag: usize) -> Result<Self, EmbeddingError> {
        if !(2..=Self::MOST_DIMENSION).contains(&dimension) {
            return Err(EmbeddingError::Dimension { dimension });
        }
        if lag == 0 {
            return Err(EmbeddingError::NoLag);
        }
        if lag > Self::MOST_SAMPLES / dimension {
            return Err(EmbeddingError::TooLong { dimension, lag });
        }
        Ok(Self { dimension, lag })
    }

    /// The number of samples in a vector.
    pub fn dimension(self) -> usize {
        self.dimension
    }

    /// From the first sample of a vector to its last.
    fn span(self) -> usize {
        (self.dimension - 1) * self.lag + 1
    }
}

/// The vectors of a series that goes on.
#[derive(Clone, Debug)]
pub struct Delays {
    embedding: Embedding,
    /// The last samples without a gap between them.
    samples: VecDeque<f64>,
    gaps: u64,
}

impl Delays {
    /// Of a series that begins.
    pub fn new(embedding: Embedding) -> Self {
        Self { embedding, samples: VecDeque::new(), gaps: 0 }
    }

    /// The next sample. The vector that ends with it, if all its samples are known.
    pub fn push(&mut self, sample: f64) -> Option<impl Iterator<Item = f64>> {
        let Embedding { lag, .. } = self.embedding;
        let span = self.embedding.span();
        if self.samples.len() == span {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
        (self.samples.len() == span).then(|| self.samples.iter().step_by(lag).copied())
    }

    /// Some samples are not known: vectors begin anew after them.
    pub fn interrupt(&mut self) {
        self.gaps += u64::from(!self.samples.is_empty());
        self.samples.clear();
    }

    /// How often the series was interrupted after it had begun.
    pub fn gaps(&self) -> u64 {
        self.gaps
    }

    /// How many vectors it has.
    pub fn dimension(&self) -> usize {
        self.embedding.dimension
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vectors(delays: &mut Delays, samples: std::ops::Range<u32>) -> Vec<Vec<f64>> {
        samples.filter_map(|sample| delays.push(f64::from(sample)).map(Iterator::collect)).collect()
    }

    #[test]
    fn vectors_hold_samples_at_the_lag_and_do_not_straddle_a_gap() {
        let mut delays = Delays::new(Embedding::new(3, 2).unwrap());
        delays.interrupt();
        let found = vectors(&mut delays, 0..6);
        assert_eq!(found, [[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]]);
        delays.interrupt();
        delays.interrupt();
        assert_eq!(vectors(&mut delays, 7..11), [[0.0; 3]; 0]);
        assert_eq!(vectors(&mut delays, 11..12), [[7.0, 9.0, 11.0]]);
        assert_eq!(delays.gaps(), 1);
    }

    #[test]
    fn the_samples_kept_are_those_of_one_vector() {
        let mut delays = Delays::new(Embedding::new(4, 5).unwrap());
        let found = vectors(&mut delays, 0..1000);
        assert_eq!(found.len(), 1000 - 15);
        assert!(found.iter().zip(0..).all(|(vector, t)| *vector == [t, t + 5, t + 10, t + 15].map(f64::from)));
        assert_eq!(delays.samples.len(), 16);
    }

    #[test]
    fn what_cannot_be_kept_is_refused() {
        assert_eq!(Embedding::new(2, 1 << 19).map(Embedding::span), Ok((1 << 19) + 1));
        assert!(Embedding::new(4096, 256).is_ok());
        for (dimension, lag, error) in [
            (1, 1, EmbeddingError::Dimension { dimension: 1 }),
            (4097, 1, EmbeddingError::Dimension { dimension: 4097 }),
            (2, 0, EmbeddingError::NoLag),
            (2, (1 << 19) + 1, EmbeddingError::TooLong { dimension: 2, lag: (1 << 19) + 1 }),
            (4096, usize::MAX, EmbeddingError::TooLong { dimension: 4096, lag: usize::MAX }),
        ] {
            assert_eq!(Embedding::new(dimension, lag), Err(error));
        }
    }
}
