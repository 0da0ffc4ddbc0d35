//! Signals with ground truth: a periodic series of numbers that stops, and runs again with another period.
//!
//! In: a kind and [`SignalOptions`].
//! Out: frames of the next samples; whether they are periodic, and with which period.
//! Invariants: the samples depend only on the kind, the seed and the noise, not on how many make a frame. They are the
//! same on every machine, bit for bit. A sample never goes: how many are kept is up to the window that reads them.
//! Must not know: delay vectors, holes of clouds.

use super::frame::Frame;
use super::random::Random;
use super::truth::{Ideal, TruthTracker};
use super::turn::wave;
use super::{OptionError, check_noise};

/// How long a run is, in samples.
const RUN: u64 = 480;
/// How long the rest after a run is, in samples.
const REST: u64 = 240;

/// Samples in a frame: no more than half a rest, so that each frame sees at most one change.
pub const SAMPLES: std::ops::RangeInclusive<u32> = 1..=120;

/// The kinds of signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalKind {
    /// A few harmonics, as in the acceleration of a walking body.
    Gait,
    /// One sine.
    Sine,
}

/// The parameters of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalOptions {
    /// The seed of all random numbers.
    pub seed: u64,
    /// Samples in a frame: 1 to 120.
    pub samples: u32,
    /// Each sample is off by at most this share of the first harmonic's amplitude: 0 to 0.3.
    pub noise: f64,
}

impl Default for SignalOptions {
    fn default() -> Self {
        Self { seed: 1, samples: 4, noise: 0.1 }
    }
}

/// A run of a signal. With fitting delay vectors it is a hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueRun {
    /// The same as long as the run goes on.
    pub id: u64,
    /// The period in samples.
    pub period: u32,
    /// The number of its first sample. Samples are counted from 1.
    pub since: u64,
}

/// A run, or the rest after it.
#[derive(Clone, Copy, Debug)]
struct Phase {
    runs: bool,
    period: u32,
    since: u64,
}

/// A signal that goes on.
#[derive(Clone, Debug)]
pub struct Signal {
    kind: SignalKind,
    options: SignalOptions,
    /// The periods are drawn from this.
    periods: Random,
    noise: Random,
    phase: Phase,
    truth: TruthTracker,
    /// Samples, and frames, so far.
    samples: u64,
    frames: u64,
}

impl SignalKind {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::Gait, Self::Sine];

    /// The name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gait => "gait",
            Self::Sine => "sine",
        }
    }

    /// A description of one line.
    pub fn about(self) -> &'static str {
        match self {
            Self::Gait => "a periodic signal, a number a line, that stops and goes on with another period",
            Self::Sine => "the same with one harmonic: a noisy sine that stops and goes on",
        }
    }

    /// The amplitude and the phase in turns of each harmonic.
    fn harmonics(self) -> &'static [[f64; 2]] {
        const GAIT: [[f64; 2]; 3] = [[1.0, 0.0], [0.5, 0.15], [0.25, 0.4]];
        match self {
            Self::Gait => &GAIT,
            Self::Sine => &GAIT[..1],
        }
    }

    /// The value after a share of the period.
    fn value(self, share: f64) -> f64 {
        let harmonics = (1u32..).zip(self.harmonics());
        harmonics.map(|(times, [amplitude, phase])| amplitude * wave(f64::from(times) * share + phase)).sum()
    }
}

impl Signal {
    /// A signal before its first sample.
    ///
    /// # Errors
    /// [`OptionError`]: an option is out of its range.
    pub fn new(kind: SignalKind, options: SignalOptions) -> Result<Self, OptionError> {
        options.check()?;
        let mut random = Random::new(options.seed);
        let (mut periods, noise) = (random.fork(), random.fork());
        let phase = Phase { runs: true, period: period_of_run(0, &mut periods), since: 1 };
        Ok(Self { kind, options, periods, noise, phase, truth: TruthTracker::new(0.5), samples: 0, frames: 0 })
    }

    /// The next frame. A signal has no end.
    pub fn next_frame(&mut self) -> Frame<[f64; 1], TrueRun> {
        self.frames += 1;
        let come: Vec<[f64; 1]> = (0..self.options.samples).map(|_| [self.next_sample()]).collect();
        let truth = self.truth.advance(&[self.phase]);
        Frame { points: come.clone(), come, ..Frame::new(self.frames, truth) }
    }

    fn next_sample(&mut self) -> f64 {
        self.samples += 1;
        let into = (self.samples - 1) % (RUN + REST);
        if into == 0 && self.samples > 1 {
            let number = (self.samples - 1) / (RUN + REST);
            let period = period_of_run(number, &mut self.periods);
            self.phase = Phase { runs: true, period, since: self.samples };
        } else if into == RUN {
            self.phase.runs = false;
        }
        let noise = self.options.noise * self.noise.between(-1.0, 1.0);
        if !self.phase.runs {
            return noise;
        }
        noise + self.kind.value((self.samples - self.phase.since) as f64 / f64::from(self.phase.period))
    }
}

/// Slow and fast runs take turns.
fn period_of_run(number: u64, random: &mut Random) -> u32 {
    let low = if number.is_multiple_of(2) { 60.0 } else { 40.0 };
    random.between(low, low + 10.0).floor() as u32
}

impl Ideal for Phase {
    type Hole = TrueRun;

    fn persistence(&self) -> f64 {
        f64::from(u8::from(self.runs))
    }

    fn partner(&self) -> Option<usize> {
        None
    }

    fn named(&self, id: u64) -> TrueRun {
        TrueRun { id, period: self.period, since: self.since }
    }
}

impl SignalOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`OptionError`]: which option is out of its range.
    pub fn check(&self) -> Result<(), OptionError> {
        if !SAMPLES.contains(&self.samples) {
            return Err(OptionError::Samples(self.samples));
        }
        check_noise(self.noise)
    }
}
