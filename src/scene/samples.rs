//! Samples of which a share is drawn again in every frame.
//!
//! In: how one sample is drawn; for every frame the share.
//! Out: the samples, in an order that lasts.
//! Invariants: their number changes only when asked to. Over many frames exactly the share is drawn again.
//! Must not know: what a sample is.

use super::random::Random;

/// Samples, and their random numbers.
#[derive(Clone, Debug)]
pub struct Samples<S> {
    all: Vec<S>,
    random: Random,
    /// The fraction of a sample that is still to be drawn again.
    due: f64,
    /// The indices of the samples, in any order.
    numbers: Vec<u32>,
}

impl<S> Samples<S> {
    /// Draws `count` samples.
    pub fn new(count: u32, mut random: Random, mut draw: impl FnMut(&mut Random) -> S) -> Self {
        let all = (0..count).map(|_| draw(&mut random)).collect();
        Self { all, random, due: 0.0, numbers: (0..count).collect() }
    }

    /// Draws a share of them again.
    pub fn churn(&mut self, share: f64, mut draw: impl FnMut(&mut Random) -> S) {
        let due = self.due + share * self.all.len() as f64;
        self.due = due - due.floor();
        let count = (due.floor() as usize).min(self.all.len());
        self.random.choose(&mut self.numbers, count);
        for &number in &self.numbers[..count] {
            self.all[number as usize] = draw(&mut self.random);
        }
    }

    /// Draws more of them, or drops the last ones.
    pub fn resize(&mut self, count: u32, mut draw: impl FnMut(&mut Random) -> S) {
        let Self { all, random, .. } = self;
        if all.len() != count as usize {
            all.resize_with(count as usize, || draw(random));
            self.numbers = (0..count).collect();
        }
    }

    /// All, in order, to be changed.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, S> {
        self.all.iter_mut()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// All, in order.
    pub fn iter(&self) -> std::slice::Iter<'_, S> {
        self.all.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exactly_the_share_is_drawn_again() {
        let draw = |random: &mut Random| random.unit();
        let mut samples = Samples::new(101, Random::new(1), draw);
        let mut changed = 0;
        for _ in 0..100 {
            let before: Vec<f64> = samples.iter().copied().collect();
            samples.churn(0.105, draw);
            changed += before.iter().zip(samples.iter()).filter(|(a, b)| a != b).count();
        }
        assert_eq!(changed, (101.0_f64 * 0.105 * 100.0) as usize);
        let before: Vec<f64> = samples.iter().copied().collect();
        samples.churn(1.0, draw);
        assert!(before.iter().zip(samples.iter()).all(|(a, b)| a != b));
        assert_eq!(samples.len(), 101);
    }
}
