//! Samples of the messages between a producer and the daemon (SPEC.md, section 6).
//!
//! In: nothing. Out: samples. Invariants and what it must not know: as in the parent module.

use hopes_protocol::{
    Accepted, Batch, Close, Closed, Commit, Committed, Open, Opened, Overloaded, Policy, Refusal, RefusalCode, Refused,
    Retract, Window,
};

use super::{BORDERS, SPECIAL, Sample, sample};

pub fn samples() -> Vec<Sample> {
    [opens(), batches(), others(), answers(), refusals()].concat()
}

fn opens() -> Vec<Sample> {
    let open = |name: &str, window, resolution| Open { name: name.into(), window, resolution };
    let opened = Opened {
        stream: 251,
        epoch: 0xFEDC_BA98_7654_3210,
        created: true,
        window: Window::All,
        resolution: None,
        frame: 0,
        largest_batch: 65_536,
    };
    let joined = Opened {
        stream: u32::MAX,
        created: false,
        window: Window::Frames(1),
        resolution: Some(0.125),
        frame: u64::MAX,
        ..opened.clone()
    };
    vec![
        sample("open", 1, open("scan", None, None)),
        sample("open_all", 2, open("größe/2 µm", Some(Window::All), Some(0.5))),
        sample("open_points", 3, open("a", Some(Window::Points(65_536)), None)),
        sample("open_frames", 4, open(&"n".repeat(200), Some(Window::Frames(250)), Some(f64::MIN_POSITIVE))),
        sample("open_time", 5, open("z", Some(Window::Time(1.5)), Some(f64::MAX))),
        sample("opened", 1, opened),
        sample("opened_joined", 4, joined),
    ]
}

fn batches() -> Vec<Sample> {
    let points = vec![(0.0, 0.5), (1.0, -2.0), (1e300, -1e-300)];
    let plain = Batch { sequence: 1, points: points.clone(), times: vec![], tags: vec![] };
    let timed = Batch { sequence: 2, times: vec![10.0, 9.5, 1.7e9], ..plain.clone() };
    let tagged = Batch { sequence: 3, tags: vec![250, 251, u64::MAX], ..plain.clone() };
    let everything = Batch { sequence: 250, times: timed.times.clone(), ..tagged.clone() };
    let special = Batch {
        sequence: u64::MAX,
        points: SPECIAL.iter().copied().zip(SPECIAL.iter().rev().copied()).collect(),
        times: SPECIAL.to_vec(),
        tags: BORDERS[..SPECIAL.len()].to_vec(),
    };
    vec![
        sample("batch", 7, plain.clone()),
        sample("batch_times", 7, timed),
        sample("batch_tags", 7, tagged),
        sample("batch_times_tags", 7, everything),
        sample("batch_empty", 7, Batch { sequence: 4, points: vec![], ..plain }),
        sample("batch_special", 0x0102_0304, special),
        sample("retract", 7, Retract { sequence: 65_535, points }),
        sample("retract_empty", 7, Retract { sequence: 0, points: vec![] }),
    ]
}

fn others() -> Vec<Sample> {
    vec![
        sample("commit", 7, Commit { sequence: 251, time: None }),
        sample("commit_time", 7, Commit { sequence: 252, time: Some(-0.0) }),
        sample("close", 7, Close { end: false }),
        sample("close_end", 8, Close { end: true }),
        sample("closed", 7, Closed { frame: 65_536 }),
    ]
}

fn answers() -> Vec<Sample> {
    let placed = vec![(250, 0), (251, 65_536), (u64::MAX, 0x1_0000_0000)];
    let late = Overloaded { sequence: 9, points: 1_000, total: 0x1_0000_0001, policy: Policy::DropOldest };
    let early = Overloaded { sequence: 10, points: 65_535, total: 250, policy: Policy::DropNewest };
    vec![
        sample("accepted", 7, Accepted { sequence: 1, points: 3, placed: vec![] }),
        sample("accepted_placed", 7, Accepted { sequence: 3, points: 0xFFFF_FFFF, placed }),
        sample("committed", 7, Committed { sequence: 251, frame: 12 }),
        sample("overloaded", 7, late),
        sample("overloaded_newest", 7, early),
    ]
}

fn refusals() -> Vec<Sample> {
    let codes = [
        RefusalCode::Coordinate,
        RefusalCode::NoTime,
        RefusalCode::TimeNotFinite,
        RefusalCode::TooLate,
        RefusalCode::NotThere,
        RefusalCode::StreamFull,
        RefusalCode::DaemonFull,
    ];
    let known = codes.map(|code| code as u16);
    let reasons = (0..).zip(known.into_iter().chain([u16::MAX]));
    let reason = |(index, code): (u32, u16)| Refusal { index: 249 + index, code, text: format!("{code} because") };
    let refused = |reasons, placed| Refused { sequence: 5, accepted: 2, refused: 8, reasons, placed };
    vec![
        sample("refused", 7, refused(reasons.map(reason).collect(), vec![])),
        sample("refused_placed", 7, refused(vec![], vec![(17, 4), (18, 3)])),
    ]
}
