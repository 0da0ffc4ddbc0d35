//! How many distinct sites a cloud may have.
//!
//! In: the site of a point that is about to come.
//! Out: whether it may.
//! Invariants: at no commit has a cloud more vertices than its limit. A point at a vertex that has points may always
//! come. What leaves at the commit of the frame at the latest makes room for what comes: in a full cloud it leaves at
//! once.
//! Must not know: how vertices are found by site, what a vertex costs.

use super::refusal::Refusal;
use super::site::Site;
use super::store::Cloud;
use super::window::Window;

impl<S: Site> Cloud<S> {
    /// The same cloud with a limit of vertices.
    pub fn with_most(mut self, most: usize) -> Self {
        self.most = most;
        self
    }

    /// Makes room for a point at a site.
    ///
    /// # Errors [`Refusal::TooMany`].
    pub(super) fn make_room(&mut self, site: &S) -> Result<(), Refusal> {
        if self.occupied < self.most || self.points_at(site) > 0 {
            return Ok(());
        }
        match self.window {
            // The oldest point leaves when this one comes.
            Window::Points(points) if points.get() <= self.most as u64 => return Ok(()),
            Window::All | Window::Points(_) => {}
            Window::Frames(frames) => self.expire_below((self.frame + 1).saturating_sub(frames.get()) as f64),
            Window::Time(_) => {
                if let Some(newest) = self.newest_time.into_iter().chain(self.coming).reduce(f64::max) {
                    self.expire_below(self.window_start(newest));
                }
            }
        }
        if self.occupied < self.most { Ok(()) } else { Err(Refusal::TooMany(self.most)) }
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU64;

    use super::*;
    use crate::topology::cloud::{Coordinates, Staging};

    fn cloud(window: Window) -> Cloud<Coordinates> {
        Cloud::new(window, None).with_most(3)
    }

    fn at(x: f64) -> Coordinates {
        Coordinates::new(&[x, 0.0, -x]).unwrap()
    }

    fn insert(cloud: &mut Cloud<Coordinates>, xs: &[f64], time: Option<f64>) -> Vec<Result<(), Refusal>> {
        let inserted = xs.iter().map(|&x| cloud.insert_site(at(x), time).map(drop)).collect();
        cloud.check_invariants();
        inserted
    }

    const FULL: Result<(), Refusal> = Err(Refusal::TooMany(3));

    #[test]
    fn a_full_cloud_takes_duplicates_and_what_replaces_others() {
        let mut all = cloud(Window::All);
        assert_eq!(insert(&mut all, &[1.0, 2.0, 3.0, 4.0, 2.0], None), [Ok(()), Ok(()), Ok(()), FULL, Ok(())]);
        all.commit();
        assert_eq!(insert(&mut all, &[4.0, 1.0], None), [FULL, Ok(())]);
        all.retract_site(at(3.0)).unwrap();
        assert_eq!(insert(&mut all, &[4.0, 5.0], None), [Ok(()), FULL]);
        all.commit();
        assert_eq!((all.vertex_count(), all.point_count()), (3, 5));
    }

    #[test]
    fn a_window_within_the_limit_refuses_nothing() {
        let of = |count| NonZeroU64::new(count).unwrap();
        let mut points = cloud(Window::Points(of(3)));
        let mut frames = cloud(Window::Frames(of(1)));
        let mut time = cloud(Window::Time(1.0));
        for frame in 0..5 {
            let xs = [0.0, 1.0, 2.0].map(|x| x + f64::from(frame) * 3.0);
            for cloud in [&mut points, &mut frames, &mut time] {
                assert_eq!(insert(cloud, &xs, Some(f64::from(frame) * 1.5)), [Ok(()); 3]);
                cloud.commit();
                assert_eq!((cloud.vertex_count(), cloud.point_count()), (3, 3));
            }
        }
        assert_eq!(insert(&mut frames, &[0.0, 1.0, 2.0, 3.0], None), [Ok(()), Ok(()), Ok(()), FULL]);
        assert_eq!(insert(&mut time, &[20.0], Some(6.0)), [FULL]);
    }

    /// Stages points of a frame and commits it with a time. Returns the places that were refused.
    fn admit(cloud: &mut Cloud<Coordinates>, count: u32, frame: u32, time: f64) -> Vec<(usize, Refusal)> {
        let mut staging = Staging::default();
        for x in 0..count {
            cloud.stage_site(&mut staging, at(f64::from(x + count * frame)), None).unwrap();
        }
        let mut refused = Vec::new();
        cloud.admit(&mut staging, Some(time), &mut |place, refusal| refused.push((place, refusal)));
        cloud.commit();
        cloud.check_invariants();
        cloud.take_change();
        refused
    }

    #[test]
    fn staged_points_are_refused_at_their_commit() {
        let mut frames = cloud(Window::Frames(NonZeroU64::MIN));
        for frame in 0..3 {
            assert_eq!(admit(&mut frames, 4, frame, 0.0), [(3, Refusal::TooMany(3))]);
            assert_eq!((frames.vertex_count(), frames.used_count()), (3, 3));
        }
        let mut time = cloud(Window::Time(1.0));
        assert_eq!(admit(&mut time, 2, 0, 0.0), []);
        assert_eq!(admit(&mut time, 2, 1, 0.6), [(1, Refusal::TooMany(3))]);
        // Those of the first frame leave, before the two come.
        assert_eq!(admit(&mut time, 2, 2, 1.2), []);
        assert_eq!((time.vertex_count(), time.point_count()), (3, 3));
    }
}
