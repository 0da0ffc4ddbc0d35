//! Options of a view: which part of the skeleton is shown.
//!
//! In: words of the command line.
//! Out: the core's and the protocol's views.
//! Must not know: input and output.

use std::num::NonZeroU32;

use clap::Args;
use hopes::topology::ViewSpec;
use hopes_protocol as wire;

use super::values::{rank, scale};
use crate::cli::Failure;
use crate::daemon;

/// Which part of the skeleton is shown.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "View")]
pub struct ViewArgs {
    /// Derived skeleton HoPeS_{k,l}: take the dots above the lowest of the K widest diagonal gaps.
    #[arg(short, long, default_value = "1", value_name = "K", value_parser = rank)]
    k: NonZeroU32,
    /// Derived skeleton HoPeS_{k,l}: cut at the leftmost of the L widest vertical gaps.
    #[arg(short, long, default_value = "1", value_name = "L", value_parser = rank)]
    l: NonZeroU32,
    /// Reduced skeleton HoPeS(C; ALPHA) instead: at the scale ALPHA, a radius.
    #[arg(long, value_name = "ALPHA", value_parser = scale, conflicts_with_all = ["k", "l", "full"])]
    alpha: Option<f64>,
    /// The whole skeleton instead: the tree and every critical edge.
    #[arg(long, conflicts_with_all = ["k", "l"])]
    full: bool,
}

impl ViewArgs {
    /// The view they ask for.
    pub fn spec(self) -> ViewSpec {
        match self.alpha {
            Some(alpha) => ViewSpec::Reduced { alpha },
            None if self.full => ViewSpec::Full,
            None => ViewSpec::Derived { k: self.k, l: self.l },
        }
    }
}

/// Which part of the skeleton is shown, and whether short edges of it are collapsed.
#[derive(Clone, Copy, Debug, Args)]
pub struct SimplifiedViewArgs {
    #[command(flatten)]
    view: ViewArgs,
    /// Also collapse edges of half-length below RADIUS, the shortest first, keeping every cycle [default: vs, or
    /// ALPHA].
    #[arg(
        long,
        value_name = "RADIUS",
        value_parser = scale,
        num_args = 0..=1,
        require_equals = true,
        help_heading = "View"
    )]
    simplify: Option<Option<f64>>,
}

/// Below which half-length edges are collapsed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// The scale of the view.
    AtScale,
    /// A given radius.
    Below(f64),
}

impl SimplifiedViewArgs {
    /// The view they ask for.
    pub fn spec(self) -> ViewSpec {
        self.view.spec()
    }

    /// The threshold they ask for, if any.
    pub fn threshold(self) -> Result<Option<Threshold>, Failure> {
        match (self.simplify, self.spec()) {
            (None, _) => Ok(None),
            (Some(Some(radius)), _) => Ok(Some(Threshold::Below(radius))),
            (Some(None), ViewSpec::Full) => {
                Err(Failure::usage("--simplify with --full needs a radius: --simplify=RADIUS"))
            }
            (Some(None), _) => Ok(Some(Threshold::AtScale)),
        }
    }

    /// As the protocol has it.
    pub fn wire(self) -> Result<wire::View, Failure> {
        let simplify = match self.threshold()? {
            None => wire::Simplify::No,
            Some(Threshold::AtScale) => wire::Simplify::AtScale,
            Some(Threshold::Below(radius)) => wire::Simplify::Below(radius),
        };
        Ok(wire::View { cut: daemon::cut(self.spec()), simplify })
    }
}
