//! Windows of time: commits date points, and no clock alone moves the window of others.
//!
//! In: acts of several sources. Out: frames and refusals, compared with a plain list of points, and with a stream that
//! a lying source has never fed.

use hopes::topology::{Admission, Confirmation, Options, Pipeline, Refusal, Staging, Window};
use proptest::prelude::*;

use crate::common::by_position::ByPosition;
use crate::common::clouds::cases;

const LENGTH: f64 = 10.0;

/// A stream with a time window, and its sources.
struct Stream {
    pipeline: Pipeline,
    sources: Vec<Staging>,
    next: f64,
}

/// What became of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    accepted: u64,
    refused: u64,
}

impl Stream {
    fn new(sources: usize) -> Self {
        let options = Options { window: Window::Time(LENGTH), ..Options::default() };
        Self { pipeline: Pipeline::new(options), sources: vec![Staging::default(); sources], next: 0.0 }
    }

    /// A place of its own for each point.
    fn place(&mut self) -> f64 {
        self.next += 1.0;
        self.next
    }

    fn say(&mut self, source: usize, time: Option<f64>) -> Result<(), Refusal> {
        let x = self.place();
        self.pipeline.stage_point(&mut self.sources[source], x, 0.0, time).map(drop)
    }

    fn say_all(&mut self, source: usize, times: impl IntoIterator<Item = f64>) -> Tally {
        let mut tally = Tally::default();
        for time in times {
            match self.say(source, Some(time)) {
                Ok(()) => tally.accepted += 1,
                Err(_) => tally.refused += 1,
            }
        }
        tally
    }

    fn commit(&mut self, source: usize, time: Option<f64>) -> Admission {
        let mut refused = 0;
        let admission = self.pipeline.feed_staged(&mut self.sources[source], time, &mut |_, _| refused += 1);
        assert_eq!(admission.refused, refused);
        self.pipeline.commit(self.pipeline.event_time());
        self.pipeline.check_invariants();
        admission
    }

    /// Points of these times, and their commit.
    fn frame(&mut self, source: usize, times: impl IntoIterator<Item = f64>) -> Admission {
        self.say_all(source, times);
        self.commit(source, None)
    }

    /// Sources say the same time.
    fn agree(&mut self, sources: std::ops::Range<usize>, time: f64) {
        for source in sources {
            assert_eq!(self.frame(source, [time]), Admission::default());
        }
    }

    fn now(&self) -> f64 {
        self.pipeline.event_time().expect("a time is known")
    }

    fn points(&self) -> u64 {
        self.pipeline.point_count()
    }
}

fn around(time: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |index| time + index as f64 / 1000.0)
}

#[test]
fn a_commit_dates_the_points_that_have_no_time() {
    let mut stream = Stream::new(1);
    for (number, expected) in [(0, 3), (6, 6), (12, 6), (22, 6), (23, 6)] {
        for _ in 0..3 {
            stream.say(0, None).unwrap();
        }
        let time = Some(f64::from(number));
        assert_eq!(stream.commit(0, time), Admission { time, ..Admission::default() });
        assert_eq!(stream.points(), expected, "at {number}");
    }
}

#[test]
fn without_a_commits_time_the_newest_one_known_dates_points() {
    let mut stream = Stream::new(2);
    stream.say(0, None).unwrap();
    let admission = stream.commit(0, None);
    assert_eq!((admission.refused, stream.points()), (1, 0), "no time is known");
    // The newest time of the frame itself counts, wherever it stands.
    stream.say(0, None).unwrap();
    stream.say(0, Some(5.0)).unwrap();
    stream.commit(0, None);
    assert_eq!((stream.points(), stream.now()), (2, 5.0));
    stream.say(1, None).unwrap();
    stream.commit(1, None);
    stream.frame(0, [15.0]);
    assert_eq!(stream.points(), 4, "all of them are of 5 or later");
    stream.frame(0, [15.5]);
    assert_eq!(stream.points(), 2);
}

#[test]
fn one_wild_time_is_refused_alone() {
    for wild in [1e9, f64::MAX, 1e300, -1e9, f64::MIN] {
        let mut stream = Stream::new(1);
        stream.frame(0, around(100.0, 20));
        let told = stream.say_all(0, [101.0, wild, 102.0]);
        let late = stream.commit(0, None).refused;
        assert_eq!((told.refused + late, stream.now(), stream.points()), (1, 102.0, 22), "{wild}");
        let told = stream.say_all(0, [103.0, wild]);
        let late = stream.commit(0, None).refused;
        assert_eq!((told.refused + late, stream.now()), (1, 103.0), "{wild}");
        assert_eq!(stream.frame(0, around(104.0, 20)), Admission::default());
        assert_eq!(stream.points(), 43, "{wild}");
    }
}

#[test]
fn a_source_alone_jumps_ahead_with_a_commit_of_sixteen_points() {
    let mut stream = Stream::new(1);
    stream.frame(0, around(100.0, 20));
    let admission = stream.frame(0, around(500.0, 15));
    assert_eq!((admission.refused, admission.restart, stream.points()), (15, None, 20));
    assert!(matches!(admission.doubt, Some(Refusal::Unconfirmed { newest: 100.019, .. })), "{admission:?}");
    let admission = stream.frame(0, [501.0]);
    let restart = admission.restart.unwrap();
    assert_eq!((restart.before, restart.newest, restart.confirmation), (100.019, 501.0, Confirmation::Alone));
    assert_eq!((admission.refused, stream.points()), (0, 1));
    assert_eq!(stream.frame(0, around(900.0, 16)).restart.map(|restart| restart.newest), Some(900.015));
    assert_eq!(stream.points(), 16);
    // The same by the commit's time alone.
    (0..16).for_each(|_| stream.say(0, None).unwrap());
    let admission = stream.commit(0, Some(2000.0));
    assert_eq!((admission.time, admission.refused, stream.points(), stream.now()), (Some(2000.0), 0, 16, 2000.0));
    (0..15).for_each(|_| stream.say(0, None).unwrap());
    let admission = stream.commit(0, Some(3000.0));
    assert_eq!((admission.time, admission.refused, stream.points(), stream.now()), (None, 15, 16, 2000.0));
}

#[test]
fn points_before_a_jump_in_the_same_commit_are_taken_before_it() {
    let mut stream = Stream::new(1);
    stream.frame(0, [0.0]);
    // A gap of its own input, with hours before and after it.
    let admission = stream.frame(0, (1..1000).chain(2000..3000).map(f64::from));
    assert_eq!((admission.refused, stream.points(), stream.now()), (0, 11, 2999.0));
}

#[test]
fn a_clock_that_steps_back_is_believed_over_a_commit_and_the_window_is_empty_before_it() {
    let mut stream = Stream::new(1);
    stream.frame(0, around(100.0, 20));
    let told = stream.say_all(0, around(50.0, 30));
    assert_eq!(told, Tally { accepted: 0, refused: 30 }, "they are too late as far as is known");
    let admission = stream.commit(0, None);
    assert_eq!((admission.restart, stream.points()), (None, 20));
    assert!(matches!(admission.doubt, Some(Refusal::TooLate { .. })), "{admission:?}");
    assert_eq!(stream.say_all(0, around(51.0, 30)).accepted, 30);
    let admission = stream.commit(0, None);
    let restart = admission.restart.unwrap();
    assert_eq!((restart.before, restart.newest, restart.confirmation), (100.019, 51.029, Confirmation::Alone));
    assert_eq!((admission.refused, stream.points(), stream.now()), (0, 30, 51.029));
    // Points of the commit that have no time are of the new window, wherever they stand.
    stream.frame(0, around(20.0, 20));
    stream.say(0, None).unwrap();
    stream.say_all(0, around(21.0, 20));
    stream.say(0, None).unwrap();
    assert_eq!((stream.commit(0, None).refused, stream.points()), (0, 22));
    stream.frame(0, around(51.0, 20));
    assert_eq!(stream.now(), 51.019);
    let outdated = Refusal::Outdated { time: 20.0, before: 21.019, newest: 51.019 };
    assert_eq!(stream.frame(0, [20.0]).doubt, Some(outdated));
}

#[test]
fn a_commits_time_that_steps_back_is_believed_likewise() {
    let mut stream = Stream::new(1);
    let mut frame = |time: f64| {
        (0..20).for_each(|_| stream.say(0, None).unwrap());
        let refused = stream.commit(0, Some(time)).refused;
        (refused, stream.points(), stream.now())
    };
    assert_eq!(frame(100.0), (0, 20, 100.0));
    assert_eq!(frame(50.0), (20, 20, 100.0));
    assert_eq!(frame(51.0), (0, 20, 51.0));
    assert_eq!(frame(52.0), (0, 40, 52.0));
}

#[test]
fn a_second_source_confirms_a_jump_either_way() {
    for to in [1000.0, 10.0] {
        let mut stream = Stream::new(2);
        stream.frame(0, [100.0]);
        stream.frame(1, [101.0]);
        assert_eq!(stream.frame(0, [to]).restart, None);
        assert_eq!(stream.now(), 101.0);
        assert_eq!(stream.say_all(1, [to + 1.0]).accepted, 1, "it is what another source has said");
        let admission = stream.commit(1, None);
        assert_eq!(admission.restart.map(|restart| restart.confirmation), Some(Confirmation::Others));
        assert_eq!((admission.refused, stream.points(), stream.now()), (0, 1, to + 1.0));
        assert_eq!(stream.frame(0, [to + 2.0]), Admission::default());
    }
}

#[test]
fn a_source_beside_silent_ones_is_believed_over_a_commit() {
    let mut stream = Stream::new(3);
    stream.agree(0..3, 100.0);
    assert_eq!(stream.frame(0, around(3700.0, 500)).restart, None, "the others have had no chance to contradict");
    assert!(stream.frame(0, around(3701.0, 500)).restart.is_some());
    assert_eq!(stream.frame(0, around(3702.0, 500)), Admission::default());
    // A source that is there no more has no say.
    let mut stream = Stream::new(2);
    stream.frame(0, [100.0]);
    stream.frame(1, [100.0]);
    stream.pipeline.discard_staged(&mut stream.sources[1]);
    assert!(stream.frame(0, around(3700.0, 16)).restart.is_some());
}

#[test]
fn what_a_source_has_moved_alone_another_one_moves_back_at_once() {
    let mut stream = Stream::new(2);
    stream.frame(0, [100.0]);
    stream.frame(1, [100.0]);
    stream.frame(1, around(1e6, 50));
    assert!(stream.frame(1, around(1e6 + 1.0, 50)).restart.is_some());
    assert_eq!(stream.say_all(0, [102.0]).accepted, 1);
    let admission = stream.commit(0, None);
    assert_eq!(admission.restart.map(|restart| restart.confirmation), Some(Confirmation::Undone));
    assert_eq!((admission.refused, stream.points(), stream.now()), (0, 1, 102.0));
    // It does not move the window a second time, as long as the other one is there.
    for number in 2..20 {
        assert_eq!(stream.frame(1, around(1e6 + f64::from(number), 50)).restart, None);
    }
    // Until it falls in with the other one.
    stream.frame(1, [101.0]);
    stream.frame(1, around(5000.0, 50));
    assert!(stream.frame(1, around(5001.0, 50)).restart.is_some());
}

#[test]
fn two_against_one_win_and_two_against_two_do_not() {
    let mut stream = Stream::new(4);
    // The first one of all is wrong.
    stream.frame(0, around(1e6, 50));
    stream.frame(1, [100.0]);
    assert_eq!(stream.now(), 1e6 + 0.049);
    assert!(stream.frame(2, [100.0]).restart.is_some());
    assert_eq!(stream.now(), 100.0);
    stream.frame(1, [101.0]);
    // The wrong one is joined by another one.
    stream.frame(0, [1e6 + 1.0]);
    assert_eq!(stream.frame(3, [1e6 + 1.0]).restart, None);
    assert_eq!(stream.now(), 101.0);
}

#[test]
fn a_window_without_times_takes_them_as_they_are() {
    let mut pipeline = Pipeline::new(Options::default());
    let mut staging = Staging::default();
    for (x, time) in [(0.0, 5.0), (1.0, 1e300), (2.0, -7.0)] {
        pipeline.stage_point(&mut staging, x, 0.0, Some(time)).unwrap();
    }
    let refused = pipeline.stage_point(&mut staging, 3.0, 0.0, Some(f64::NAN));
    assert!(matches!(refused, Err(Refusal::TimeNotFinite(_))));
    let admission = pipeline.feed_staged(&mut staging, Some(-1e9), &mut |_, _| {});
    assert_eq!(admission, Admission { time: Some(-1e9), ..Admission::default() });
    assert_eq!(pipeline.point_count(), 3);
}

// ---- random scripts

/// A frame of an honest source: how much time has passed, the ages of its points, whether its commit has a time.
#[derive(Clone, Debug)]
struct Honest {
    source: usize,
    later: u8,
    ages: Vec<Option<u8>>,
    is_dated: bool,
}

/// A frame of the lying source.
#[derive(Clone, Debug)]
struct Lie {
    times: Vec<f64>,
    undated: usize,
    commit: Option<f64>,
}

fn honest(sources: usize) -> impl Strategy<Value = Honest> {
    let ages = prop::collection::vec(prop::option::weighted(0.7, 0..8_u8), 0..20);
    (0..sources, 0..4_u8, ages, any::<bool>()).prop_map(|(source, later, ages, is_dated)| {
        // It says one time at least.
        let is_dated = is_dated || ages.iter().all(Option::is_none);
        Honest { source, later, ages, is_dated }
    })
}

/// A time far from those of honest sources, which stay between 0 and 1000.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        1e6..1e6 + 30.0,
        -1e6..-1e6 + 30.0,
        2000.0..1e12,
        -1e12..-2000.0,
        Just(f64::MAX),
        Just(f64::MIN),
        Just(1.5e6),
    ]
}

fn lie() -> impl Strategy<Value = Lie> {
    let times = prop_oneof![
        prop::collection::vec(wild(), 0..40),
        (wild(), 0..40_usize).prop_map(|(time, count)| around(time, count).collect()),
    ];
    (times, 0..30_usize, prop::option::weighted(0.7, wild())).prop_map(|(times, undated, commit)| Lie {
        times,
        // Without a time these would be of the newest one known, which is no lie.
        undated: if commit.is_some() { undated } else { 0 },
        commit,
    })
}

fn at(quarters: u32) -> f64 {
    f64::from(quarters) / 4.0
}

impl Stream {
    /// A frame of an honest source. Nothing of it may be refused.
    fn speak(&mut self, now: u32, frame: &Honest) {
        for age in &frame.ages {
            let time = age.map(|age| at(now) - f64::from(age) / 4.0);
            assert_eq!(self.say(frame.source, time), Ok(()), "{time:?} at {}", at(now));
        }
        let admission = self.commit(frame.source, frame.is_dated.then_some(at(now)));
        assert_eq!((admission.refused, admission.time_refused), (0, None), "{frame:?} at {}", at(now));
        assert!((self.now() - at(now)).abs() <= LENGTH, "{} is believed at {}", self.now(), at(now));
    }

    /// A frame of the liar. Every point is counted once.
    fn lie(&mut self, source: usize, lie: &Lie) -> Admission {
        let is_fooled = self.now().abs() > 1000.0;
        let (before, mut tally) = (self.points(), self.say_all(source, lie.times.iter().copied()));
        for _ in 0..lie.undated {
            tally.accepted += u64::from(self.say(source, None).is_ok());
        }
        assert_eq!(tally.accepted + tally.refused, (lie.times.len() + lie.undated) as u64);
        assert_eq!((self.points(), self.sources[source].point_count()), (before, tally.accepted), "they wait");
        let admission = self.commit(source, lie.commit);
        assert!(admission.refused <= tally.accepted);
        assert_eq!(self.sources[source].point_count(), 0);
        if admission.restart.is_none() && !is_fooled {
            assert_eq!((admission.refused, self.points()), (tally.accepted, before), "{lie:?}");
        }
        admission
    }
}

proptest! {
    #![proptest_config(cases(300))]

    /// Between two frames of honest sources the liar has its say once.
    #[test]
    fn a_liar_who_is_contradicted_changes_nothing(
        frames in prop::collection::vec((honest(3), prop::option::of(lie())), 1..60),
    ) {
        let (mut told, mut spared) = (Stream::new(4), Stream::new(4));
        for stream in [&mut told, &mut spared] {
            stream.agree(0..3, 0.0);
        }
        let mut now = 0;
        for (frame, lie) in frames {
            now += u32::from(frame.later);
            told.speak(now, &frame);
            spared.next = told.next - frame.ages.len() as f64;
            spared.speak(now, &frame);
            if let Some(lie) = lie {
                prop_assert_eq!(told.lie(3, &lie).restart, None);
            }
            prop_assert_eq!(told.points(), spared.points());
            prop_assert_eq!(told.pipeline.event_time(), spared.pipeline.event_time());
        }
        told.pipeline.commit(None);
        spared.pipeline.commit(None);
        let (told, spared) = (told.pipeline.poll_frame().unwrap(), spared.pipeline.poll_frame().unwrap());
        ByPosition::of(&told.skeleton).assert_same(&ByPosition::of(&spared.skeleton));
    }

    /// The liar may say as much as it likes while the others are silent.
    #[test]
    fn points_of_honest_sources_are_never_refused_for_a_liar(
        frames in prop::collection::vec(prop_oneof![honest(3).prop_map(Ok), lie().prop_map(Err)], 1..120),
    ) {
        let mut stream = Stream::new(4);
        stream.agree(0..3, 0.0);
        let mut now = 0;
        for frame in frames {
            match frame {
                Ok(frame) => {
                    now += u32::from(frame.later);
                    stream.speak(now, &frame);
                }
                Err(lie) => {
                    stream.lie(3, &lie);
                }
            }
        }
    }

    /// Alone with itself a source recovers from whatever it has said.
    #[test]
    fn any_source_recovers_within_three_frames(lies in prop::collection::vec(lie(), 0..30), time in -1e6..1e6) {
        let mut stream = Stream::new(1);
        for lie in &lies {
            stream.say_all(0, lie.times.iter().copied());
            stream.commit(0, lie.commit);
        }
        for frame in 0..2 {
            stream.frame(0, around(time + f64::from(frame), 20));
        }
        let last = stream.frame(0, around(time + 2.0, 20));
        prop_assert_eq!((last.refused, last.restart), (0, None));
        prop_assert_eq!(stream.now(), time + 2.019);
        prop_assert!(stream.points() >= 40, "{}", stream.points());
    }

    /// Commits date points as a plain list says, whoever commits.
    #[test]
    fn frames_are_those_of_a_plain_list(frames in prop::collection::vec(honest(3), 1..80)) {
        let (mut stream, mut now) = (Stream::new(3), 0);
        let (mut list, mut newest): (Vec<f64>, Option<f64>) = (Vec::new(), None);
        for frame in frames {
            now += u32::from(frame.later);
            let own = frame.ages.iter().map(|age| age.map(|age| at(now) - f64::from(age) / 4.0));
            let own: Vec<Option<f64>> = own.collect();
            let time = frame.is_dated.then_some(at(now));
            newest = own.iter().copied().chain([newest, time]).flatten().reduce(f64::max);
            for &of_point in &own {
                stream.say(frame.source, of_point).unwrap();
            }
            let dated = own.iter().filter_map(|of_point| of_point.or(time).or(newest));
            list.extend(dated);
            prop_assert_eq!(stream.commit(frame.source, time).refused, 0);
            let begin = newest.unwrap_or(0.0) - LENGTH;
            list.retain(|&time| time >= begin);
            prop_assert_eq!((stream.points(), stream.pipeline.event_time()), (list.len() as u64, newest));
        }
    }
}
