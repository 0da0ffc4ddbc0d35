//! The last known state of a track in the plane, and how like a detection is to it.
//!
//! In: detections.
//! Out: whether a detection may continue a track.
//! Invariant: likeness is symmetric.
//! Must not know: which detection continues which track, events, hysteresis.

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::similarity::Motion;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::Hole;
use crate::topology::tracks::detection::Detected;

/// The gate: the largest distance between centres of one hole, as a share of the larger radius.
pub const NEAR: f64 = 0.5;

/// The gate: the largest ratio of two radii of one hole.
pub const LIKE_RADIUS: f64 = 2.0;

/// The largest ratio of the persistences of one track in two frames.
const LIKE_PERSISTENCE: f64 = 4.0;

/// The last known state of a track.
#[derive(Clone, Copy, Debug)]
pub struct LastSeen<'a, R> {
    /// The triangle that names its death.
    pub triangle: [VertexId; 3],
    /// Its hole when it was last seen.
    pub hole: Hole,
    /// The predicted centre of its hole.
    pub expected: [f64; 2],
    /// Its persistence when it was last seen.
    pub persistence: f64,
    /// Its region when that was last found. Unknown before the track is announced; then only the region of the
    /// detection is tested.
    pub region: &'a R,
    /// The common motion since the region was found.
    pub motion: Motion,
    /// The movement of the centre besides that.
    pub shift: [f64; 2],
    /// A dot of less persistence does not continue it, unless the dot is selected.
    pub least: f64,
    /// Whether it has been missing for long, and is remembered.
    pub is_remembered: bool,
}

impl<R: HoleRegion> LastSeen<'_, R> {
    /// Whether a detection is persistent enough to continue it, and not much more persistent: so noise takes over no
    /// hole, and no hole is taken for noise that was there before.
    pub fn goes_on(&self, detection: &Detection, is_selected: bool) -> bool {
        let is_enough = is_selected || detection.persistence() >= self.least;
        is_enough && self.likeness(detection) >= 1.0 / LIKE_PERSISTENCE
    }

    /// The smaller persistence as a share of the larger one.
    pub fn likeness(&self, detection: &Detection) -> f64 {
        let [less, more] = in_order(self.persistence, detection.persistence());
        less / more
    }

    /// The smaller radius as a share of the larger one.
    pub fn radius_likeness(&self, detection: &Detection) -> f64 {
        let [less, more] = in_order(self.hole.radius, detection.hole.radius);
        less / more
    }

    /// Whether the radius is like that of a detection.
    pub fn has_like_radius(&self, detection: &Detection) -> bool {
        self.radius_likeness(detection) >= 1.0 / LIKE_RADIUS
    }

    /// Whether both persistences and radii have at least this ratio.
    pub fn is_much_alike(&self, detection: &Detection, least: f64) -> bool {
        self.likeness(detection) >= least && self.radius_likeness(detection) >= least
    }

    /// What is gained if a detection continues it, given how remote it is, from 0 to 1. The more persistent both are,
    /// the more it matters; and two pairs of unlike ones are worth less than one pair of like ones.
    pub fn gain(&self, detection: &Detection, remoteness: f64) -> f64 {
        self.persistence.min(detection.persistence()) * self.likeness(detection) * (1.0 - remoteness)
    }

    /// Whether its region contains a point now.
    pub fn holds(&self, point: [f64; 2]) -> bool {
        held(self.region, &self.motion, self.shift, point)
    }
}

/// How remote two holes are: 0 if they are equal, more than 1 outside the gate.
pub fn remoteness(a: Hole, b: Hole) -> f64 {
    let apart = distance(a.center, b.center) / (NEAR * a.radius.max(b.radius));
    let unlike = (b.radius / a.radius).ln().abs() / LIKE_RADIUS.ln();
    if apart <= 1.0 && unlike <= 1.0 { (apart + unlike) / 2.0 } else { f64::INFINITY }
}

/// Whether a region that was found some frames ago contains a point now, after a common motion. The movement of the
/// centre besides that may be that of the region, or only that of the centre inside it; either is accepted.
pub fn held(region: &impl HoleRegion, motion: &Motion, shift: [f64; 2], point: [f64; 2]) -> bool {
    region.contains(motion.undo(point)) || region.contains(motion.undo(back(point, shift)))
}

/// A point before a shift.
pub fn back(point: [f64; 2], shift: [f64; 2]) -> [f64; 2] {
    [point[0] - shift[0], point[1] - shift[1]]
}

pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn in_order(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}
