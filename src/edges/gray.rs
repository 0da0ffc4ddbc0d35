//! Gray out of colours, as OpenCV's `imread(..., IMREAD_GRAYSCALE)` has it for PNG, and out of the luma of video.
//!
//! In: samples. Out: one byte a pixel. Invariants: gray stays as it is; weights are whole 32768ths of 0.299, 0.587 and 0.114, and what is left is cut off (16 bits a sample: rounded, then cut to 8). Must not know: where samples come from.

/// The weights of red, green and blue: libpng's, which add up to 1 << 15.
const WEIGHTS: [u32; 3] = [9797, 19_234, 3737];

/// Gray by weights only.
pub fn from_rgb([red, green, blue]: [u8; 3]) -> u8 {
    (weighted([red, green, blue].map(u32::from)) >> 15) as u8
}

/// Gray of samples of 16 bits.
pub fn from_deep_rgb(samples: [u16; 3]) -> u8 {
    ((weighted(samples.map(u32::from)) + (1 << 14)) >> 23) as u8
}

fn weighted(samples: [u32; 3]) -> u32 {
    samples.iter().zip(WEIGHTS).map(|(sample, weight)| sample * weight).sum()
}

/// How light a sample stands for, where a file tells it: then colours are mixed as light is, as libpng does.
///
/// (Of 16 bits libpng has coarser tables than these, and may differ in the last bits.)
#[derive(Clone, Debug)]
pub struct Gamma {
    to_light: Vec<u16>,
    from_light: Vec<u16>,
}

impl Gamma {
    /// The exponent that makes samples of light, such as 0.45455, and the largest sample. None if there is nothing to do: it is 1 or about that, or makes no sense.
    pub fn new(exponent: f64, largest: u16) -> Option<Self> {
        let makes_sense = exponent > 1e-4 && exponent < 1e4;
        let differs = (exponent - 1.0).abs() > 0.05;
        let scale = f64::from(largest);
        let light = |sample: u16, exponent: f64| ((f64::from(sample) / scale).powf(exponent) * scale + 0.5) as u16;
        let table = |exponent: f64| (0..=largest).map(|sample| light(sample, exponent)).collect();
        (makes_sense && differs).then(|| Self { to_light: table(1.0 / exponent), from_light: table(exponent) })
    }

    /// Gray by light; no sample is above the largest.
    pub fn gray(&self, samples: [u16; 3]) -> u16 {
        match samples {
            [red, green, blue] if red == green && green == blue => red,
            _ => {
                let light = weighted(samples.map(|sample| u32::from(self.to_light[usize::from(sample)])));
                self.from_light[((light + (1 << 14)) >> 15) as usize]
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
        let gamma = Gamma::new(0.45455, 255).unwrap();
        for gray in 0..=255 {
            assert_eq!(from_rgb([gray; 3]), gray);
            assert_eq!(from_deep_rgb([u16::from(gray) << 8 | 0x80; 3]), gray);
            assert_eq!(gamma.gray([gray.into(); 3]), gray.into());
        }
    }

    #[test]
    fn green_is_lighter_than_red_and_red_than_blue() {
        assert_eq!([[255, 0, 0], [0, 255, 0], [0, 0, 255]].map(from_rgb), [76, 149, 29]);
        let deep = [[u16::MAX, 0, 0], [0, u16::MAX, 0], [0, 0, u16::MAX]];
        assert_eq!(deep.map(from_deep_rgb), [76, 150, 29]);
        // Light is more than the number that stands for it.
        let gamma = Gamma::new(0.45455, 255).unwrap();
        assert_eq!([[255, 0, 0], [0, 255, 0], [0, 0, 255]].map(|colour| gamma.gray(colour)), [147, 200, 95]);
    }

    #[test]
    fn a_gamma_that_says_nothing_is_none() {
        for exponent in [1.0, 0.96, 0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(Gamma::new(exponent, 255).is_none(), "{exponent}");
        }
    }

    #[test]
    fn limited_luma_is_stretched() {
        let gray = of_limited_luma();
        assert_eq!([0, 16, 17, 126, 234, 235, 255].map(|luma| gray[luma]), [0, 0, 1, 128, 254, 255, 255]);
    }
}
