//! Converts colours to gray as OpenCV's `imread(..., IMREAD_GRAYSCALE)` does, and luma of video to gray.
//!
//! In: samples. Out: one byte a pixel.
//!
//! Invariants: gray samples do not change. The weights are whole 32768ths of 0.299, 0.587 and 0.114, and add up to 1.
//! Rounding is as in libpng and libjpeg.
//!
//! Must not know: where samples come from.

/// The weights of red, green and blue in libpng. They add up to 1 << 15.
const WEIGHTS: [u32; 3] = [9797, 19_234, 3737];

/// Half of the sum of weights, to round.
const HALF: u32 = 1 << 14;

/// Gray of samples of 8 bits, rounded down, as for PNG.
pub fn from_rgb(samples: [u8; 3]) -> u8 {
    (weighted(samples.map(u32::from)) >> 15) as u8
}

/// Gray of samples of 8 bits, rounded, as for the few JPEG files without luma.
pub fn from_rgb_rounded(samples: [u8; 3]) -> u8 {
    ((weighted(samples.map(u32::from)) + HALF) >> 15) as u8
}

/// Gray of samples of 16 bits, rounded, then cut to 8 bits.
pub fn from_deep_rgb(samples: [u16; 3]) -> u8 {
    ((weighted(samples.map(u32::from)) + HALF) >> 23) as u8
}

fn weighted(samples: [u32; 3]) -> u32 {
    samples.iter().zip(WEIGHTS).map(|(sample, weight)| sample * weight).sum()
}

/// The transfer function of a file that states its gamma. Colours are then mixed in linear light, as in libpng.
#[derive(Clone, Debug)]
pub struct Gamma {
    /// The low bits of a sample that the tables ignore.
    shift: u32,
    to_light: Vec<u16>,
    from_light: Vec<u16>,
}

impl Gamma {
    /// For samples of 8 bits. The exponent converts linear light to samples, such as 0.45455. None if it is close to 1
    /// or not meaningful.
    pub fn new(exponent: f64) -> Option<Self> {
        Self::with(exponent, u8::MAX.into(), 0)
    }

    /// For samples of 16 bits.
    pub fn deep(exponent: f64) -> Option<Self> {
        // 11 bits are enough for gray values of 8 bits.
        Self::with(exponent, u16::MAX, 5)
    }

    fn with(exponent: f64, largest: u16, shift: u32) -> Option<Self> {
        let makes_sense = exponent > 1e-4 && exponent < 1e4;
        let differs = (exponent - 1.0).abs() > 0.05;
        let last = largest >> shift;
        let power = |entry: u16, exponent: f64| (f64::from(entry) / f64::from(last)).powf(exponent);
        let table = |exponent: f64| {
            (0..=last).map(|entry| (power(entry, exponent) * f64::from(largest) + 0.5) as u16).collect()
        };
        let tables = || Self { shift, to_light: table(1.0 / exponent), from_light: table(exponent) };
        (makes_sense && differs).then(tables)
    }

    /// Gray, mixed in linear light. Samples have at most the number of bits that this was made for.
    pub fn gray(&self, samples: [u16; 3]) -> u16 {
        match samples {
            [red, green, blue] if red == green && green == blue => red,
            _ => {
                let light = weighted(samples.map(|sample| u32::from(self.to_light[usize::from(sample >> self.shift)])));
                self.from_light[(((light + HALF) >> 15) >> self.shift) as usize]
            }
        }
    }
}

/// A table of gray values by luma for video in which black is 16 and white is 235, as in most video.
pub fn of_limited_luma() -> [u8; 256] {
    std::array::from_fn(|luma| ((luma as f64 - 16.0) * (255.0 / 219.0)).round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_stays_as_it_is() {
        let gamma = Gamma::new(0.45455).unwrap();
        for gray in 0..=255 {
            assert_eq!(from_rgb([gray; 3]), gray);
            assert_eq!(from_deep_rgb([u16::from(gray) << 8 | 0x80; 3]), gray);
            assert_eq!(gamma.gray([gray.into(); 3]), gray.into());
        }
    }

    #[test]
    fn green_is_lighter_than_red_and_red_than_blue() {
        let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255]];
        assert_eq!(colours.map(from_rgb), [76, 149, 29]);
        assert_eq!(colours.map(from_rgb_rounded), [76, 150, 29]);
        let deep = [[u16::MAX, 0, 0], [0, u16::MAX, 0], [0, 0, u16::MAX]];
        assert_eq!(deep.map(from_deep_rgb), [76, 150, 29]);
        // Mixing in linear light gives a lighter gray.
        let gamma = Gamma::new(0.45455).unwrap();
        assert_eq!(colours.map(|colour| gamma.gray(colour.map(u16::from))), [147, 200, 95]);
    }

    #[test]
    fn a_gamma_close_to_1_or_without_meaning_is_none() {
        for exponent in [1.0, 0.96, 0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(Gamma::new(exponent).is_none() && Gamma::deep(exponent).is_none(), "{exponent}");
        }
    }

    #[test]
    fn limited_luma_is_stretched() {
        let gray = of_limited_luma();
        assert_eq!([0, 16, 17, 126, 234, 235, 255].map(|luma| gray[luma]), [0, 0, 1, 128, 254, 255, 255]);
    }
}
