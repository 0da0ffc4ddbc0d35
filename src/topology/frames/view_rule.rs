//! Which dots and edges a view shows, as a rule for one edge or dot alone.
//!
//! In: a [`ViewSpec`], and the scales that its gaps choose. Out: yes or no for an edge or a dot. Invariant: what it shows is what
//! [`View`](crate::topology::View) shows. Must not know: frames.

use crate::topology::skeleton::{Critical, Selection, ViewSpec, up_to};

/// Which dots and edges a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRule {
    /// Edges enter up to this scale.
    pub limit: f64,
    /// Dots are at least as persistent.
    pub least: f64,
    /// Dots are born no later.
    latest_birth: f64,
    /// Dots die after this.
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

    /// That of a view, given what the gaps select.
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

    /// Whether it shows the same dots as another one.
    pub fn same_dots(&self, other: &Self) -> bool {
        Self { limit: other.limit, ..*self } == *other
    }
}
