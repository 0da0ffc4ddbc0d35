//! The rule of a view, applied to one edge or dot at a time.
//!
//! In: a [`ViewSpec`], and the scales that its gaps select.
//! Out: whether the view shows an edge or a dot.
//! Invariant: it shows what [`View`](crate::topology::View) shows.
//! Must not know: frames.

use crate::topology::skeleton::{Critical, Selection, ViewSpec, up_to};

/// Decides which dots and edges a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRule {
    /// The largest scale of its edges.
    pub limit: f64,
    /// The least persistence of its dots.
    pub least: f64,
    /// The latest birth of its dots.
    latest_birth: f64,
    /// Its dots die after this scale.
    alive_at: f64,
}

impl ViewRule {
    /// Shows nothing.
    pub const NOTHING: Self = Self {
        limit: f64::NEG_INFINITY,
        least: f64::INFINITY,
        latest_birth: f64::NEG_INFINITY,
        alive_at: f64::INFINITY,
    };

    /// The rule of a view, given its selection by gaps.
    pub fn new(spec: ViewSpec, selection: Option<&Selection>) -> Self {
        let all = Self { limit: f64::INFINITY, least: 0.0, latest_birth: f64::INFINITY, alive_at: f64::NEG_INFINITY };
        match (spec, selection) {
            (ViewSpec::Reduced { alpha }, _) => {
                Self { limit: up_to(alpha), latest_birth: up_to(alpha), alive_at: alpha, ..all }
            }
            (ViewSpec::Derived { .. }, Some(Selection { ds, vs, .. })) => {
                Self { limit: up_to(*vs), least: ds.unwrap_or(f64::INFINITY), latest_birth: *vs, alive_at: *vs }
            }
            (ViewSpec::Full | ViewSpec::Derived { .. }, _) => all,
        }
    }

    /// Whether it shows a dot.
    pub fn shows(&self, dot: &Critical) -> bool {
        dot.death - dot.birth >= self.least && dot.birth <= self.latest_birth && dot.death > self.alive_at
    }

    /// Whether it shows the same dots as another rule.
    pub fn same_dots(&self, other: &Self) -> bool {
        Self { limit: other.limit, ..*self } == *other
    }
}
