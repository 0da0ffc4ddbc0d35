//! Random numbers that are the same on every machine and in every version.
//!
//! In: a seed. Out: numbers, made of the words of a PCG generator.
//!
//! Invariants: the sequence of words is fixed for ever; a test holds its beginning. Draws from one fork do not change
//! the others, so each part of a scene has its own fork.
//!
//! Why ours: `oorandom` gives the words. The conversions to numbers and choices stand here, since those of `rand`
//! change between versions.
//!
//! Must not know: what is drawn.

use oorandom::Rand64;

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random(Rand64);

impl Random {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(Rand64::new(u128::from(seed)))
    }

    /// An independent stream. Its seed has 128 random bits, since streams with similar seeds have similar words.
    pub fn fork(&mut self) -> Self {
        let [high, low] = [(); 2].map(|()| u128::from(self.0.rand_u64()));
        Self(Rand64::new(high << 64 | low))
    }

    /// A number from 0 up to, but not including, 1.
    pub fn unit(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.rand_u64() >> 11) as f64 * STEP
    }

    /// A number from `low` up to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number from 0 to `end` - 1.
    pub fn below(&mut self, end: usize) -> usize {
        // The product of a number below 1 and `end` may round up to `end`.
        ((self.unit() * end as f64) as usize).min(end.saturating_sub(1))
    }

    /// A point of the unit ball (in the plane: of the unit disc), uniformly distributed.
    pub fn in_ball<const D: usize>(&mut self) -> [f64; D] {
        loop {
            let point: [f64; D] = std::array::from_fn(|_| self.between(-1.0, 1.0));
            if point.iter().map(|x| x * x).sum::<f64>() <= 1.0 {
                return point;
            }
        }
    }

    /// Moves a random choice of `count` elements to the front, in random order.
    pub fn choose<T>(&mut self, elements: &mut [T], count: usize) {
        for place in 0..count.min(elements.len()) {
            let chosen = place + self.below(elements.len() - place);
            elements.swap(place, chosen);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_fixed() {
        let mut random = Random::new(1);
        let mut fork = random.fork();
        let words = [&mut random, &mut fork].map(|random| [(); 2].map(|()| random.0.rand_u64()));
        let later = [4_758_538_779_453_212_100, 13_036_576_051_305_512_084];
        let forked = [9_406_684_239_583_102_153, 810_184_924_563_047_132];
        assert_eq!(words, [later, forked]);
    }

    #[test]
    fn draws_are_in_range_and_spread_over_it() {
        let mut random = Random::new(3);
        let mut seen = [0; 7];
        for _ in 0..7000 {
            seen[random.below(7)] += 1;
            let [x, y] = random.in_ball();
            assert!(x * x + y * y <= 1.0);
            assert!((2.0..5.0).contains(&random.between(2.0, 5.0)));
        }
        assert!(seen.iter().all(|&count| (800..1200).contains(&count)), "{seen:?}");
        let mut numbers: Vec<u32> = (0..50).collect();
        random.choose(&mut numbers, 50);
        assert!(!numbers.is_sorted());
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..50), "nothing is lost");
    }
}
