//! Gray out of colours, as OpenCV's `imread(..., IMREAD_GRAYSCALE)` has it, and out of the luma of video.
//!
//! In: samples. Out: one byte a pixel. Invariants: gray stays as it is; weights are whole 32768ths of 0.299, 0.587 and
//! 0.114, which add up to 1; what is rounded how is as in libpng and libjpeg. Must not know: where samples come from.

/// The weights of red, green and blue: libpng's, which add up to 1 << 15.
const WEIGHTS: [u32; 3] = [9797, 19_234, 3737];

/// Half of what weights add up to, for rounding.
const HALF: u32 = 1 << 14;

/// Gray of samples of 8 bits, rounded down, as in PNG.
pub fn from_rgb(samples: [u8; 3]) -> u8 {
    (weighted(samples.map(u32::from)) >> 15) as u8
}

/// Gray of samples of 8 bits, rounded, as in the few JPEG that have no luma.
pub fn from_rgb_rounded(samples: [u8; 3]) -> u8 {
    ((weighted(samples.map(u32::from)) + HALF) >> 15) as u8
}

/// Gray of samples of 16 bits: rounded, then cut to 8.
pub fn from_deep_rgb(samples: [u16; 3]) -> u8 {
    ((weighted(samples.map(u32::from)) + HALF) >> 23) as u8
}

fn weighted(samples: [u32; 3]) -> u32 {
    samples.iter().zip(WEIGHTS).map(|(sample, weight)| sample * weight).sum()
}

/// How light a sample stands for, where a file tells it: then colours are mixed as light is, as libpng does.
#[derive(Clone, Debug)]
pub struct Gamma {
    /// Bits of a sample that tables leave out.
    shift: u32,
    to_light: Vec<u16>,
    from_light: Vec<u16>,
}

impl Gamma {
    /// For samples of 8 bits: the exponent that makes samples of light, such as 0.45455. None if there is nothing to
    /// do: it is 1 or about that, or makes no sense.
    pub fn new(exponent: f64) -> Option<Self> {
        Self::with(exponent, u8::MAX.into(), 0)
    }

    /// For samples of 16 bits.
    pub fn deep(exponent: f64) -> Option<Self> {
        // 11 bits tell enough for a gray of 8.
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

    /// Gray by light; no sample has more bits than it is for.
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

/// The gray of each luma where black is 16 and white 235, as in most video.
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
        // Light is more than the number that stands for it.
        let gamma = Gamma::new(0.45455).unwrap();
        assert_eq!(colours.map(|colour| gamma.gray(colour.map(u16::from))), [147, 200, 95]);
    }

    #[test]
    fn a_gamma_that_says_nothing_is_none() {
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
