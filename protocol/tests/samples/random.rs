//! Random numbers that are the same in every run (SplitMix64).
//!
//! In: a seed. Out: numbers and bytes. Must not know: what they are for.

/// A generator.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number from 0 to `end` - 1.
    pub fn below(&mut self, end: usize) -> usize {
        (self.word() % end as u64) as usize
    }

    /// A random element.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    /// Random bytes. Half of the time most of them are small, so that they are valid lengths and cases.
    pub fn bytes(&mut self, count: usize) -> Vec<u8> {
        let mask = if self.below(2) == 0 { 0xFF } else { 0x03 };
        let byte =
            |random: &mut Self| if random.below(8) == 0 { random.word() as u8 } else { random.word() as u8 & mask };
        (0..count).map(|_| byte(self)).collect()
    }
}
