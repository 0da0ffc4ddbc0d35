//! The golden vectors: every message as bytes and as JSON, for clients in any language.
//!
//! In: `vectors/v1`, and the samples that they were made from. Out: whether bytes and JSON say the same, in both directions, and whether nothing is missing or left over. Invariants: a vector
//! that was written is never changed.

mod samples;

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{Banner, Decoder, FrameError, LARGEST_FRAME, Message, Mirror, VERSION, encode};
use samples::bad::{self, Refusal};
use samples::files::{self, bad_folder, folder};
use samples::json::{self, BannerEntry};
use serde_json::Value;

/// All vectors of messages by name.
fn messages() -> Vec<String> {
    files::vectors(&folder()).into_iter().filter(|name| name != "banner").collect()
}

/// What a vector's bytes say.
fn decoded(name: &str) -> (u32, Message) {
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.push(&files::bytes(&folder(), name));
    let frame = decoder.frame().unwrap_or_else(|error| panic!("{name}: {error}")).expect("it is whole");
    assert!(!decoder.is_within_frame(), "{name} goes on after its frame");
    (frame.channel, frame.message().unwrap_or_else(|error| panic!("{name}: {error}")))
}

fn banner() -> BannerEntry {
    BannerEntry { name: "Banner".into(), lowest: Banner::OURS.lowest, highest: Banner::OURS.highest }
}

#[test]
fn every_vector_decodes_to_its_json() {
    for name in messages() {
        let (channel, message) = decoded(&name);
        assert_eq!(json::of(channel, &message), files::read(&folder(), &format!("{name}.json")), "{name}");
    }
}

#[test]
fn every_json_encodes_to_the_bytes_beside_it() {
    for name in messages() {
        let (channel, message) = json::read(&files::read(&folder(), &format!("{name}.json")));
        let bytes = encode(VERSION, channel, &message).expect("it is short");
        assert_eq!(files::hex(&bytes), files::read(&folder(), &format!("{name}.hex")), "{name}");
    }
}

#[test]
fn every_sample_encodes_to_its_vector() {
    for sample in samples::all() {
        let bytes = encode(VERSION, sample.channel, &sample.message).expect("it is short");
        let vector = files::read(&folder(), &format!("{}.hex", sample.name));
        assert_eq!(files::hex(&bytes), vector, "{}", sample.name);
        assert_eq!(decoded(sample.name), (sample.channel, sample.message), "{}", sample.name);
    }
}

#[test]
fn the_banner_has_a_vector() {
    let entry: BannerEntry = serde_json::from_str(&files::read(&folder(), "banner.json")).expect("it is JSON");
    let written = Banner { lowest: entry.lowest, highest: entry.highest };
    assert_eq!(json::pretty(&entry), json::pretty(&banner()));
    assert_eq!(files::hex(&written.encode()), files::read(&folder(), "banner.hex"));
    assert_eq!(Banner::decode(&files::bytes(&folder(), "banner")), Ok(written));
}

#[test]
fn every_type_of_message_has_a_vector() {
    let found: BTreeSet<u16> = messages().iter().map(|name| decoded(name).1.kind()).collect();
    for (number, name) in Message::KINDS {
        assert!(found.contains(number), "{name} ({number:#06x}) has no vector");
    }
}

/// Debug forms name the field too, and so tell the `All` of a window from that of the dots.
#[test]
fn every_case_of_every_choice_has_a_vector() {
    let found: String = messages().iter().map(|name| format!("{:?}\n", decoded(name).1)).collect();
    let cases = [
        "window: All, window: Points( window: Frames( window: Time( window: None",
        "window: Some(All) window: Some(Points( window: Some(Frames( window: Some(Time(",
        "cut: Full cut: Reduced( cut: Derived( simplify: No simplify: AtScale simplify: Below(",
        "dots: No dots: Top( dots: All resume: None resume: Some( time: None time: Some( ds: None ds: Some(",
        "vs: None vs: Some( resolution: None resolution: Some( created: true created: false end: true end: false",
        "cause: Start cause: ViewChanged cause: Lagged cause: CannotResume policy: DropOldest policy: DropNewest",
    ];
    let words = cases.iter().flat_map(|line| line.split(' ')).collect::<Vec<_>>();
    for case in words.chunks(2).map(|pair| pair.join(" ")) {
        assert!(found.contains(&case), "no vector has `{case}`");
    }
}

#[test]
fn every_list_has_an_empty_and_another_vector() {
    let (mut empty, mut other) = (BTreeSet::new(), BTreeSet::new());
    for sample in samples::all() {
        for (path, value) in leaves(&sample) {
            if let Value::Array(list) = value {
                let found = if list.is_empty() { &mut empty } else { &mut other };
                found.insert((sample.message.kind(), path));
            }
        }
    }
    // These are pairs, no lists.
    other.retain(|(_, path)| ![".edge", ".center", ".Derived"].iter().any(|pair| path.ends_with(pair)));
    assert_eq!(empty, other);
    assert_eq!(empty.len(), 22, "{empty:?}");
}

/// Two fields that were equal in all vectors of their message could be exchanged, and nobody would see it.
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

/// The fields of a body with their paths, those of the first element of a list too.
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
            if list.first().is_some_and(Value::is_object) {
                collect(format!("{path}[]"), list.swap_remove(0), into);
            }
        }
        value => into.push((path, value)),
    }
}

#[test]
fn every_file_belongs_to_a_sample() {
    let of_samples = samples::all().into_iter().map(|sample| sample.name);
    assert_eq!(files::names(&folder()), both(of_samples.chain(["banner"])));
    assert_eq!(files::names(&bad_folder()), both(bad::all().into_iter().map(|bad| bad.name)));
}

/// The two files of each name; no name may be there twice.
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
fn the_vectors_of_a_story_lead_from_one_to_the_next() {
    for story in [&["snapshot", "diff", "diff_onwards"][..], &["diff_from_nothing", "diff_merged"]] {
        let mut mirror = Mirror::new();
        for name in story {
            let applied = match decoded(name).1 {
                Message::Snapshot(snapshot) => mirror.apply_snapshot(&snapshot),
                Message::Diff(diff) => mirror.apply_diff(&diff),
                other => panic!("{name} is no part of a story: {other:?}"),
            };
            assert_eq!(applied, Ok(()), "{name}");
        }
    }
}

/// What a reader says of bytes, in the words of the vectors.
fn class(bytes: &[u8]) -> &'static str {
    let mut decoder = Decoder::new(LARGEST_FRAME);
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
fn bad_vectors_are_refused_as_they_say() {
    let names = files::vectors(&bad_folder());
    for name in &names {
        let refusal: Refusal =
            serde_json::from_str(&files::read(&bad_folder(), &format!("{name}.json"))).expect("it is JSON");
        assert_eq!(class(&files::bytes(&bad_folder(), name)), refusal.error, "{name}: {}", refusal.why);
    }
    let classes: BTreeSet<&str> = names.iter().map(|name| class(&files::bytes(&bad_folder(), name))).collect();
    let all = [bad::MALFORMED, bad::VERSION, bad::TOO_LARGE, bad::INCOMPLETE, bad::BODY];
    assert_eq!(classes, BTreeSet::from(all), "each class has a vector");
}

#[test]
fn bad_samples_are_their_vectors() {
    for bad in bad::all() {
        assert_eq!(files::hex(&bad.bytes), files::read(&bad_folder(), &format!("{}.hex", bad.name)), "{}", bad.name);
        let text = files::read(&bad_folder(), &format!("{}.json", bad.name));
        assert_eq!(json::pretty(&bad.refusal), text, "{}", bad.name);
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

/// Writes the vectors of new samples; those that are there must be what they were.
#[test]
#[ignore = "writes into the source tree: cargo test -p hopes-protocol --test vectors -- --ignored write_vectors"]
fn write_vectors() {
    let mut texts = vec![(folder(), "banner", files::hex(&Banner::OURS.encode()), json::pretty(&banner()))];
    for sample in samples::all() {
        let bytes = encode(VERSION, sample.channel, &sample.message).expect("it is short");
        texts.push((folder(), sample.name, files::hex(&bytes), json::of(sample.channel, &sample.message)));
    }
    for bad in bad::all() {
        texts.push((bad_folder(), bad.name, files::hex(&bad.bytes), json::pretty(&bad.refusal)));
    }
    std::fs::create_dir_all(bad_folder()).expect("the source tree can be written to");
    let write = |(folder, name, hex, json): &(std::path::PathBuf, &str, String, String)| {
        let hex = files::write_once(&folder.join(format!("{name}.hex")), hex).err();
        [hex, files::write_once(&folder.join(format!("{name}.json")), json).err()]
    };
    let refused: Vec<String> = texts.iter().flat_map(write).flatten().collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}
