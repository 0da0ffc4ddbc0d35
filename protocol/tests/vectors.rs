//! The golden vectors: every message as bytes and as JSON, for clients in any language.
//!
//! In: a folder of vectors for each version, and the samples from which they were made. Out: whether bytes and JSON
//! agree in both directions, and whether a vector is missing or left over.
//!
//! Invariants: a vector never changes.

mod samples;

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{
    Banner, Decoder, FrameError, LARGEST_FRAME, Message, Mirror, SpaceMirror, SpaceTrackMirror, TrackMirror, VERSION,
    encode,
};
use samples::VERSIONS;
use samples::bad::{self, Refusal};
use samples::files::{self, bad_folder, folder};
use samples::json::{self, BannerEntry};
use serde_json::Value;

/// All vectors of messages by version and name.
fn messages() -> Vec<(u16, String)> {
    let of = |version| files::vectors(&folder(version)).into_iter().map(move |name| (version, name));
    VERSIONS.into_iter().flat_map(of).filter(|(_, name)| name != "banner").collect()
}

/// Decodes the bytes of a vector, in the version of its folder.
fn decoded(version: u16, name: &str) -> (u32, Message) {
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.set_version(version);
    decoder.push(&files::bytes(&folder(version), name));
    let frame = decoder.frame().unwrap_or_else(|error| panic!("{name}: {error}")).expect("it is whole");
    assert!(!decoder.is_within_frame(), "{name} goes on after its frame");
    assert_eq!(frame.version, version, "{name}");
    (frame.channel, frame.message().unwrap_or_else(|error| panic!("{name}: {error}")))
}

/// The banner of a side that supports all versions up to this one.
fn banner(version: u16) -> Banner {
    Banner { lowest: 1, highest: version }
}

fn banner_entry(version: u16) -> BannerEntry {
    let Banner { lowest, highest } = banner(version);
    BannerEntry { name: "Banner".into(), lowest, highest }
}

#[test]
fn every_vector_decodes_to_its_json() {
    for (version, name) in messages() {
        let (channel, message) = decoded(version, &name);
        assert_eq!(json::of(channel, &message), files::read(&folder(version), &format!("{name}.json")), "{name}");
    }
}

#[test]
fn every_json_encodes_to_its_bytes() {
    for (version, name) in messages() {
        let (channel, message) = json::read(&files::read(&folder(version), &format!("{name}.json")));
        let bytes = encode(version, channel, &message).expect("it is short");
        assert_eq!(files::hex(&bytes), files::read(&folder(version), &format!("{name}.hex")), "{name}");
    }
}

#[test]
fn every_sample_encodes_to_its_vector() {
    for sample in samples::all() {
        let bytes = encode(sample.version, sample.channel, &sample.message).expect("it is short");
        let vector = files::read(&folder(sample.version), &format!("{}.hex", sample.name));
        assert_eq!(files::hex(&bytes), vector, "{}", sample.name);
        assert_eq!(decoded(sample.version, sample.name), (sample.channel, sample.message), "{}", sample.name);
    }
}

#[test]
fn the_banner_of_each_version_has_a_vector() {
    for version in VERSIONS {
        let folder = folder(version);
        let entry: BannerEntry = serde_json::from_str(&files::read(&folder, "banner.json")).expect("it is JSON");
        let written = Banner { lowest: entry.lowest, highest: entry.highest };
        assert_eq!(json::pretty(&entry), json::pretty(&banner_entry(version)));
        assert_eq!(files::hex(&written.encode()), files::read(&folder, "banner.hex"));
        assert_eq!(Banner::decode(&files::bytes(&folder, "banner")), Ok(written));
        assert_eq!(Banner::OURS.agree(written), Ok(version.min(VERSION)));
    }
    assert_eq!(banner(VERSION), Banner::OURS);
}

#[test]
fn every_type_of_message_has_a_vector() {
    let in_its_own = |(version, name): &(u16, String)| {
        let message = decoded(*version, name).1;
        (message.since() == *version).then_some(message.kind())
    };
    let found: BTreeSet<u16> = messages().iter().filter_map(in_its_own).collect();
    for (number, name) in Message::KINDS {
        assert!(found.contains(number), "{name} ({number:#06x}) has no vector in the first version that has it");
    }
}

/// A message has the same body in every later version. Only the frame's version and the header's CRC differ.
#[test]
fn a_message_has_the_same_body_in_every_later_version() {
    let mut compared = [0; VERSIONS.len()];
    for (version, name) in messages() {
        let (channel, message) = decoded(version, &name);
        let first = files::bytes(&folder(version), &name);
        for later in VERSIONS.into_iter().filter(|later| *later > version) {
            let second = encode(later, channel, &message).expect("it is short");
            let parts = |bytes: &[u8]| [&bytes[..4], &bytes[6..16], &bytes[20..]].concat();
            assert_eq!(parts(&first), parts(&second), "{name} in version {later}");
            assert_eq!((&first[4..6], &second[4..6]), (&version.to_le_bytes()[..], &later.to_le_bytes()[..]), "{name}");
            compared[usize::from(later) - 1] += 1;
        }
    }
    let taken_over =
        |later| messages().iter().any(|(version, name)| *version == later && decoded(later, name).1.since() < later);
    assert!(compared[1] > 70 && compared[2] > 90 && compared[3] > 105, "{compared:?}");
    assert!(taken_over(2) && taken_over(3) && taken_over(4), "each later version has a vector of an older message");
}

/// Debug output includes the field's name, so the `All` of a window differs from the `All` of dots.
#[test]
fn every_case_of_every_enum_has_a_vector() {
    let found: String = messages().iter().map(|(version, name)| format!("{:?}\n", decoded(*version, name).1)).collect();
    let cases = [
        "window: All, window: Points( window: Frames( window: Time( window: None",
        "window: Some(All) window: Some(Points( window: Some(Frames( window: Some(Time(",
        "cut: Full cut: Reduced( cut: Derived( simplify: No simplify: AtScale simplify: Below(",
        "dots: No dots: Top( dots: All resume: None resume: Some( time: None time: Some( ds: None ds: Some(",
        "vs: None vs: Some( resolution: None resolution: Some( created: true created: false end: true end: false",
        "cause: Start cause: ViewChanged cause: Lagged cause: CannotResume policy: DropOldest policy: DropNewest",
        "tracks: No tracks: Events tracks: Alive tracks: Cycles alive: None alive: Some( selected: true selected: false",
        "happening: Born happening: Split( happening: Updated( happening: Unselected happening: Reselected",
        "metric: Euclidean metric: Manhattan metric: Chebyshev metric: Angular metric: Haversine metric: None",
        "metric: Some( dimension: None dimension: Some( death: None death: Some( death_edge: None death_edge: Some(",
        "happening: Merged( happening: Died center: true center: false birth: true birth: false death: true death: false",
    ];
    let words = cases.iter().flat_map(|line| line.split(' ')).collect::<Vec<_>>();
    for case in words.chunks(2).map(|pair| pair.join(" ")) {
        assert!(found.contains(&case), "no vector has `{case}`");
    }
}

#[test]
fn every_list_has_an_empty_and_a_filled_vector() {
    let (mut empty, mut other) = (BTreeSet::new(), BTreeSet::new());
    for sample in samples::all() {
        for (path, value) in leaves(&sample) {
            if let Value::Array(list) = value {
                let found = if list.is_empty() { &mut empty } else { &mut other };
                found.insert((sample.message.kind(), path));
            }
        }
    }
    // These are pairs, not lists.
    other.retain(|(_, path)| ![".edge", ".death_edge", ".Derived"].iter().any(|pair| path.ends_with(pair)));
    // So are these in the plane.
    other.retain(|(kind, path)| *kind >= 0x0210 || ![".center", ".velocity"].iter().any(|pair| path.ends_with(pair)));
    assert_eq!(empty, other);
    assert_eq!(empty.len(), 55, "{empty:?}");
}

/// If two fields were equal in all vectors of a message, an exchange of them would not be detected.
#[test]
fn any_two_fields_of_a_message_differ_in_a_vector() {
    let mut never_differed = BTreeMap::new();
    for sample in samples::all() {
        let leaves = leaves(&sample);
        for (index, (path, value)) in leaves.iter().enumerate() {
            for (other_path, other) in &leaves[..index] {
                let pair = (sample.message.kind(), other_path.clone(), path.clone());
                let same = never_differed.entry(pair).or_insert(true);
                *same &= value == other;
            }
        }
    }
    let exchangeable: Vec<_> = never_differed.iter().filter(|(_, same)| **same).collect();
    assert!(exchangeable.is_empty(), "{exchangeable:?}");
}

/// The fields of a body with their paths, including those of the first element of each list.
fn leaves(sample: &samples::Sample) -> Vec<(String, Value)> {
    let entry: json::Entry<Value> =
        serde_json::from_str(&json::of(sample.channel, &sample.message)).expect("it was just written");
    let mut found = Vec::new();
    collect(String::new(), entry.body, &mut found);
    found
}

fn collect(path: String, value: Value, into: &mut Vec<(String, Value)>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                collect(format!("{path}.{name}"), value, into);
            }
        }
        Value::Array(mut list) => {
            into.push((path.clone(), Value::Array(list.clone())));
            // Cycles are lists of lists. All other elements that are arrays are pairs or the like.
            if list.first().is_some_and(|first| first.is_object() || path.ends_with(".walks")) {
                collect(format!("{path}[]"), list.swap_remove(0), into);
            }
        }
        value => into.push((path, value)),
    }
}

#[test]
fn every_file_belongs_to_a_sample() {
    for version in VERSIONS {
        let of_samples = samples::of(version).into_iter().map(|sample| sample.name);
        assert_eq!(files::names(&folder(version)), both(of_samples.chain(["banner"])));
        assert_eq!(files::names(&bad_folder(version)), both(bad::of(version).into_iter().map(|bad| bad.name)));
    }
}

/// The names of vectors. Each has two files, and no name occurs twice.
fn both<'a>(names: impl Iterator<Item = &'a str>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for name in names {
        for ending in ["hex", "json"] {
            assert!(found.insert(format!("{name}.{ending}")), "two samples are called {name}");
        }
    }
    found
}

#[test]
fn the_diffs_of_a_sequence_apply_one_after_the_other() {
    for story in [&["snapshot", "diff", "diff_onwards"][..], &["diff_from_nothing", "diff_merged"]] {
        let mut mirror = Mirror::new();
        for name in story {
            let applied = match decoded(1, name).1 {
                Message::Snapshot(snapshot) => mirror.apply_snapshot(&snapshot),
                Message::Diff(diff) => mirror.apply_diff(&diff),
                other => panic!("{name} is no part of a story: {other:?}"),
            };
            assert_eq!(applied, Ok(()), "{name}");
        }
    }
}

#[test]
fn the_space_messages_of_a_sequence_apply_one_after_the_other() {
    for story in [&["space_snapshot", "space_diff", "space_diff_onwards"][..], &["space_diff_borders"]] {
        let mut mirror = SpaceMirror::default();
        for name in story {
            let applied = match decoded(4, name).1 {
                Message::SpaceSnapshot(snapshot) => mirror.apply_space_snapshot(&snapshot),
                Message::SpaceDiff(diff) => mirror.apply_space_diff(&diff),
                other => panic!("{name} is no part of a story: {other:?}"),
            };
            assert_eq!(applied, Ok(()), "{name}");
        }
    }
    for alone in ["space_snapshot_nothing", "space_snapshot_earth", "space_snapshot_251"] {
        let Message::SpaceSnapshot(snapshot) = decoded(4, alone).1 else { panic!("{alone} is no snapshot") };
        assert_eq!(SpaceMirror::default().apply_space_snapshot(&snapshot), Ok(()), "{alone}");
    }
    let mut mirror = SpaceTrackMirror::default();
    for name in ["space_tracks_start", "space_tracks", "space_tracks_merged"] {
        let Message::SpaceTracks(tracks) = decoded(4, name).1 else { panic!("{name} has no tracks") };
        assert_eq!((mirror.apply(&tracks), mirror.frame()), (Ok(()), tracks.frame), "{name}");
    }
}

#[test]
fn the_track_messages_of_a_sequence_apply_one_after_the_other() {
    for story in [&["tracks_start", "tracks", "tracks_merged"][..], &["tracks_start_events", "tracks_events"]] {
        let mut mirror = TrackMirror::new();
        for name in story {
            let Message::Tracks(tracks) = decoded(2, name).1 else { panic!("{name} has no tracks") };
            assert_eq!(mirror.apply(&tracks), Ok(()), "{name}");
            assert_eq!(mirror.frame(), tracks.frame, "{name}");
        }
    }
}

/// The class of error of a reader, as the vectors write it.
fn class(version: u16, bytes: &[u8]) -> &'static str {
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.set_version(version);
    decoder.push(bytes);
    match decoder.frame() {
        Err(FrameError::Malformed(_)) => bad::MALFORMED,
        Err(FrameError::UnsupportedVersion { .. }) => bad::VERSION,
        Err(FrameError::TooLarge { .. }) => bad::TOO_LARGE,
        Err(FrameError::Incomplete { .. }) => panic!("the decoder never says so: it waits"),
        Ok(None) if decoder.is_within_frame() => bad::INCOMPLETE,
        Ok(None) => "nothing",
        Ok(Some(frame)) if frame.message().is_err() => bad::BODY,
        Ok(Some(_)) => "none",
    }
}

#[test]
fn bad_vectors_give_their_class_of_error() {
    let all = [bad::MALFORMED, bad::VERSION, bad::TOO_LARGE, bad::INCOMPLETE, bad::BODY];
    let later = [bad::VERSION, bad::BODY];
    // Later versions have bad vectors only for what is new in them: everything else is wrong in the same way.
    for (version, classes) in VERSIONS.into_iter().zip([&all[..], &later, &later, &later]) {
        let folder = bad_folder(version);
        let mut found = BTreeSet::new();
        for name in files::vectors(&folder) {
            let text = files::read(&folder, &format!("{name}.json"));
            let refusal: Refusal = serde_json::from_str(&text).expect("it is JSON");
            let class = class(version, &files::bytes(&folder, &name));
            assert_eq!(class, refusal.error, "{name}: {}", refusal.why);
            found.insert(class);
        }
        assert_eq!(found, classes.iter().copied().collect(), "each class has a vector");
    }
}

#[test]
fn bad_samples_equal_their_vectors() {
    for (folder, all) in VERSIONS.map(|version| (bad_folder(version), bad::of(version))) {
        for bad in all {
            assert_eq!(files::hex(&bad.bytes), files::read(&folder, &format!("{}.hex", bad.name)), "{}", bad.name);
            let text = files::read(&folder, &format!("{}.json", bad.name));
            assert_eq!(json::pretty(&bad.refusal), text, "{}", bad.name);
        }
    }
}

#[test]
fn a_vector_is_never_overwritten() {
    let path = std::env::temp_dir().join(format!("hopes-vector-{}", std::process::id()));
    let written = [files::write_once(&path, "1\n"), files::write_once(&path, "1\n")];
    let refused = files::write_once(&path, "2\n").expect_err("it is there");
    let left = std::fs::read_to_string(&path).expect("it is there");
    std::fs::remove_file(&path).expect("it can be removed");
    assert_eq!((written, left.as_str()), ([Ok(()), Ok(())], "1\n"));
    assert!(refused.contains("never changed"), "{refused}");
}

/// Writes the vectors of new samples. Existing ones must not change.
#[test]
#[ignore = "writes into the source tree: cargo test -p hopes-protocol --test vectors -- --ignored write_vectors"]
fn write_vectors() {
    let mut texts = Vec::new();
    for version in VERSIONS {
        let (folder, bad_folder) = (folder(version), bad_folder(version));
        let banner = (files::hex(&banner(version).encode()), json::pretty(&banner_entry(version)));
        texts.push((folder.clone(), "banner", banner.0, banner.1));
        for sample in samples::of(version) {
            let bytes = encode(version, sample.channel, &sample.message).expect("it is short");
            texts.push((folder.clone(), sample.name, files::hex(&bytes), json::of(sample.channel, &sample.message)));
        }
        std::fs::create_dir_all(&bad_folder).expect("the source tree can be written to");
        for bad in bad::of(version) {
            texts.push((bad_folder.clone(), bad.name, files::hex(&bad.bytes), json::pretty(&bad.refusal)));
        }
    }
    let write = |(folder, name, hex, json): &(std::path::PathBuf, &str, String, String)| {
        let hex = files::write_once(&folder.join(format!("{name}.hex")), hex).err();
        [hex, files::write_once(&folder.join(format!("{name}.json")), json).err()]
    };
    let refused: Vec<String> = texts.iter().flat_map(write).flatten().collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}
