//! True holes in R^d: a shortest closed curve around each.
//!
//! In: closed curves as polygons.
//! Out: their centre, radius and length.
//! Invariants: a curve has at least two places.
//! Must not know: points, what the curves lie on.

use crate::scene::truth::Ideal;

/// A true hole in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueCycle {
    /// The same as long as the hole exists.
    pub id: u64,
    /// A shortest closed curve around it, as a closed polygon.
    pub curve: Vec<Vec<f64>>,
    /// The mean of the curve. If the curve may be anywhere along an orbit: the centre of the orbit.
    pub center: Vec<f64>,
    /// Half the largest distance of two places of the curve.
    pub radius: f64,
    /// The distance from the centre to the means of the shortest curves. It is 0 unless the curve goes around a tube.
    pub orbit: f64,
    /// The length of the curve.
    pub length: f64,
}

/// A hole of the ideal shape (infinitely many points, no noise).
#[derive(Clone, Debug)]
pub struct IdealCycle {
    /// A shortest closed curve around it.
    pub curve: Vec<Vec<f64>>,
    /// The centre and the radius of the orbit, if it goes around a tube.
    pub orbit: Option<(Vec<f64>, f64)>,
    /// Death minus birth in the Vietoris-Rips filtration, by radii.
    pub persistence: f64,
    /// As in [`Ideal::partner`].
    pub partner: Option<usize>,
}

impl Ideal for IdealCycle {
    type Hole = TrueCycle;

    fn persistence(&self) -> f64 {
        self.persistence
    }

    fn partner(&self) -> Option<usize> {
        self.partner
    }

    fn named(&self, id: u64) -> TrueCycle {
        let (mean, length) = mean_and_length(&self.curve);
        let (center, orbit) = self.orbit.clone().unwrap_or((mean, 0.0));
        TrueCycle { id, center, radius: half_diameter(&self.curve), orbit, length, curve: self.curve.clone() }
    }
}

fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Half the largest distance of two places of a polygon.
pub fn half_diameter(curve: &[Vec<f64>]) -> f64 {
    let farthest =
        |(number, a): (usize, &Vec<f64>)| curve[..number].iter().map(|b| distance_squared(a, b)).fold(0.0, f64::max);
    curve.iter().enumerate().map(farthest).fold(0.0, f64::max).sqrt() / 2.0
}

fn mean_and_length(curve: &[Vec<f64>]) -> (Vec<f64>, f64) {
    let mut mean = vec![0.0; curve.first().map_or(0, Vec::len)];
    let mut length = 0.0;
    for (a, b) in curve.iter().zip(curve.iter().cycle().skip(1)) {
        let side = distance_squared(a, b).sqrt();
        length += side;
        for ((mean, a), b) in mean.iter_mut().zip(a).zip(b) {
            *mean += side * (a + b) / 2.0;
        }
    }
    mean.iter_mut().for_each(|mean| *mean /= length);
    (mean, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_has_its_mean_by_length() {
        // Many places on one side draw the mean of the places, but not that of the curve.
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let curve = square.map(|place| place.to_vec()).to_vec();
        let ideal = IdealCycle { curve, orbit: None, persistence: 1.0, partner: None };
        let TrueCycle { center, radius, orbit, length, .. } = ideal.named(1);
        assert_eq!((center, radius, orbit, length), (vec![2.0, 2.0], 8.0_f64.sqrt(), 0.0, 16.0));
    }
}
