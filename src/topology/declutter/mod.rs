//! Outliers: which points of a cloud are clutter, and are left out of its skeleton.
//!
//! In: the cloud, and what changed in it.
//! Out: the points that stay, the outliers, and a report.
//! Invariants: whether a point stays depends on the distinct positions of the cloud alone: not on their order, history
//! or multiplicity. The same however many threads there are, and whether computed at once or followed from frame to
//! frame. A change costs logarithmic time for each point whose neighbours it changes.
//! Must not know: triangulations, frames, formats.
//!
//! # The rule
//!
//! Let d be the distance of a point to its K-th nearest other position (K = 3). The point stays if
//!
//! 1. **reach:** d is at most R, and
//! 2. **contrast:** fewer than 2K + 2 points within 1.5 d of it have a distance of at most d / 4.
//!
//! Clutter far from everything has no K neighbours within R. Clutter near a wall has, but its neighbours are much
//! closer together than it is to them. So many witnesses are asked for since a clump of K + 1 outliers, or one close
//! pair in a wall, must not take its surroundings away.
//!
//! Unless R is given, it is found from the cloud. The density of clutter is estimated by lone points, on a grid
//! (`occupancy`). R is the largest radius at which at most one clutter point (or another number) is expected to have K
//! others within R: the tail of a Poisson distribution (`radius`). R is on a ladder of steps of 2^(1/4), so it rests
//! while the cloud changes a little. R is never below twice the median of d (on the ladder), so a cloud of one density
//! loses nothing. Where no point is alone there is no clutter, and all points stay.
//!
//! Duplicates count once: a sensor that repeats itself has not seen more.
//!
//! # What is certified
//!
//! Let rho be the largest d that stays. *If no outlier has K outliers within rho, and no true point was removed*, then
//! births and deaths of the skeleton are those of the true points within rho, and dots of a persistence above 2 rho are
//! real: every outlier that stays has a true point within rho, so the distance functions of both clouds differ by rho
//! at most. The premise cannot be checked, but it is what R is chosen for. It is called certified if R was given, or if
//! at most 0.1 clutter points were asked for and are expected to stay.
//!
//! # What it cannot do
//!
//! * Walls of very uneven density: at 10:1 and with 5% of clutter the thinnest parts are as thin as clutter.
//! * Clumps of more than K outliers are as dense as walls. Where all clutter is in clumps and no point is alone, none
//!   is found.
//! * Clutter close to a wall, within a few of its distances, stays; it moves births and deaths by no more than that.
//! * A cloud whose density falls off smoothly, such as a normal distribution, loses some of its tail.

mod contrast;
mod filter;
mod ladder;
mod occupancy;
mod radius;
mod report;
mod rule;
mod search;
#[cfg(test)]
mod textbook;
mod tree;

pub use filter::{Filter, Sides};
pub use report::Decluttered;
pub use rule::{Declutter, DeclutterError, MAX_NEIGHBOURS};
