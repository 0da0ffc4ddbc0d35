//! Released versions are frozen: the wire types do not change, and SPEC.md describes them.
//!
//! In: the sources of the wire types, SPEC.md and samples. Out: whether SPEC.md has the fingerprint of each version's
//! definitions, and whether it lists every message, field and case.
//!
//! Invariants: comments, layout and the order of definitions do not change a fingerprint. Names, types and the order of
//! fields and cases do. A definition that begins with a later version does not count for an earlier one.
//!
//! Must not know: bytes, which the vectors freeze.

mod samples;

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{Message, VERSION};
use samples::VERSIONS;

const SPEC: &str = include_str!("../SPEC.md");

/// Each source with the first version of its definitions. The table of messages states the version of each message
/// itself.
const SOURCES: [(u16, &str); 8] = [
    (1, include_str!("../src/types.rs")),
    (1, include_str!("../src/daemon.rs")),
    (1, include_str!("../src/producer.rs")),
    (1, include_str!("../src/consumer.rs")),
    (1, include_str!("../src/message.rs")),
    (2, include_str!("../src/tracks.rs")),
    (3, include_str!("../src/admin.rs")),
    (4, include_str!("../src/space.rs")),
];

/// Codes that were added to an older enum: its name, the first of these codes, and the version that began with them.
/// The latest come first.
const LATER_CODES: [(&str, u16, u16); 2] = [("ErrorCode", 19, 4), ("ErrorCode", 15, 3)];

// ---- definitions in the sources

/// The part of a source that counts: no comments, no attributes except serde's, no layout.
fn essence(source: &str) -> String {
    let code: String =
        source.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let mut kept = without_attributes(&code).split_whitespace().collect::<Vec<_>>().join(" ");
    for mark in ["{", "}", "(", ")", "[", "]", "<", ">", ",", ":", ";", "=", "!", "#", "&", "|"] {
        kept = kept.replace(&format!(" {mark}"), mark).replace(&format!("{mark} "), mark);
    }
    ["}", ")", ">"].iter().fold(kept, |kept, end| kept.replace(&format!(",{end}"), end))
}

fn without_attributes(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(start) = rest.find("#[") {
        let length = closing(&rest[start + 1..]);
        let (before, attribute) = rest[..start + 1 + length].split_at(start);
        kept += before;
        // These change bytes or JSON; `derive` and documentation do not.
        if attribute.contains("serde(") {
            kept += attribute;
        }
        rest = &rest[start + 1 + length..];
    }
    kept + rest
}

/// The length of the bracketed group at the beginning of a text.
fn closing(text: &str) -> usize {
    let mut depth = 0;
    for (at, mark) in text.char_indices() {
        match mark {
            '{' | '[' | '(' => depth += 1,
            '}' | ']' | ')' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + mark.len_utf8();
        }
    }
    panic!("brackets are not closed: {text}")
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Struct,
    Enum,
    Alias,
    Table,
}

struct Definition {
    kind: Kind,
    name: String,
    /// The text after the name.
    body: String,
    /// The whole definition.
    text: String,
}

/// The definitions in the essence of a source.
fn definitions(essence: &str) -> Vec<Definition> {
    let mut found = Vec::new();
    let mut rest = essence;
    // A group in braces is skipped as a whole, since the definitions inside a macro are not types.
    while let Some(open) = rest.find(['{', ';']) {
        let end = if rest[open..].starts_with(';') { open + 1 } else { open + closing(&rest[open..]) };
        found.extend(definition(&rest[..open], &rest[open..end]));
        rest = &rest[end..];
    }
    found
}

fn definition(head: &str, body: &str) -> Option<Definition> {
    let named = |kind, mark| head.split_once(mark).map(|(_, name): (&str, &str)| (kind, name, body));
    let alias = || head.split_once("pub type ")?.1.split_once('=').map(|(name, body)| (Kind::Alias, name, body));
    let table = || (head == "messages!").then_some((Kind::Table, head, body));
    let found = named(Kind::Struct, "pub struct ").or_else(|| named(Kind::Enum, "pub enum "));
    let (kind, name, body) = found.or_else(alias).or_else(table)?;
    Some(Definition { kind, name: name.to_owned(), body: body.to_owned(), text: format!("{head}{body}") })
}

fn all_definitions() -> Vec<Definition> {
    SOURCES.iter().flat_map(|(_, source)| definitions(&essence(source))).collect()
}

/// A definition as a version has it. The table of messages loses the messages of later versions, and an enum its codes.
fn in_version(version: u16, definition: Definition) -> Definition {
    let entry_and_first = match definition.kind {
        Kind::Table => entry_and_first,
        Kind::Enum if LATER_CODES.iter().any(|(name, ..)| *name == definition.name) => code_and_first,
        _ => return definition,
    };
    let known = inner(&definition.body).into_iter().map(entry_and_first).filter(|(_, since)| *since <= version);
    let entries: Vec<String> = known.map(|(entry, _)| entry).collect();
    let body = format!("{{{}}}", entries.join(","));
    let head = definition.text.strip_suffix(&definition.body).expect("a definition ends with its body");
    Definition { text: format!("{head}{body}"), body, ..definition }
}

/// The definitions of a kind: name and body.
fn all(kind: Kind) -> BTreeMap<String, String> {
    let of_kind = all_definitions().into_iter().filter(|definition| definition.kind == kind);
    of_kind.map(|definition| (definition.name, definition.body)).collect()
}

/// An entry of the table of messages, and the first version that has it.
fn entry_and_first(entry: String) -> (String, u16) {
    match entry.split_once(")since ") {
        Some((entry, since)) => (format!("{entry})"), since.parse().expect("a version")),
        None => (entry, 1),
    }
}

/// A case of an enum of codes, and the first version that has it.
fn code_and_first(case: String) -> (String, u16) {
    let (_, number) = case.split_once('=').expect("a code has a number");
    let number: u16 = number.parse().expect("it is one");
    let later = LATER_CODES.iter().find(|(_, first, _)| number >= *first);
    (case, later.map_or(1, |(.., since)| *since))
}

/// FNV-1a of all definitions of a version, independent of their order.
fn fingerprint(version: u16, sources: &[(u16, &str)]) -> u64 {
    let known = sources.iter().filter(|(since, _)| *since <= version);
    let found = known.flat_map(|(_, source)| definitions(&essence(source)));
    let lines: BTreeSet<String> = found.map(|definition| in_version(version, definition).text + "\n").collect();
    let bytes = lines.iter().flat_map(|line| line.bytes());
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}

#[test]
fn the_wire_types_of_each_version_have_not_changed() {
    let lines: Vec<&str> = SPEC.lines().filter(|line| line.starts_with("Fingerprint")).collect();
    assert_eq!(lines.len(), VERSIONS.len(), "SPEC.md has a fingerprint for each version");
    for (version, line) in VERSIONS.into_iter().zip(lines) {
        let fingerprint = fingerprint(version, &SOURCES);
        let found = format!("Fingerprint of the wire types of version {version}: `{fingerprint:016x}`.");
        assert!(
            line == found,
            "\nThe definitions of the wire types are not those of version {version}.\n\
             If it is released, undo the change: a released version never changes. New definitions belong to a new \
             version: a number in src/banner.rs, a source of types and rows with `since` in src/message.rs, a section \
             in SPEC.md, a folder of vectors, and a fingerprint in this test.\n\
             If it is not released yet, or only a Rust name has changed that is not on the wire, then explain it in \
             SPEC.md and replace the line there by\n\n{found}\n"
        );
    }
    assert_eq!(VERSIONS.last(), Some(&VERSION), "the newest version is checked too");
}

/// Released: these numbers must never change.
#[test]
fn the_fingerprints_of_released_versions_have_not_changed() {
    assert_eq!(fingerprint(1, &SOURCES), 0x4fa0_27c6_9f59_74ce);
    assert_eq!(fingerprint(2, &SOURCES), 0xd6f7_a24e_189f_05a5);
    assert_eq!(fingerprint(3, &SOURCES), 0xb256_e847_dcdb_f413);
}

#[test]
fn later_definitions_do_not_change_the_fingerprint_of_a_version() {
    let print = |version, sources: &[(u16, &str)]| fingerprint(version, sources);
    let old = [(1, "pub struct A { pub a: u64 } messages! { 0x0001 A(A), 0x0003 C(A), }")];
    let new = [
        (1, "pub struct A { pub a: u64 } messages! { 0x0001 A(A), 0x0002 B(B) since 2, 0x0003 C(A), }"),
        (2, "pub struct B { pub b: u64 }"),
    ];
    assert_eq!(print(1, &new), print(1, &old));
    assert_ne!(print(2, &new), print(2, &old));
    assert_eq!(print(3, &new), print(2, &new));
    // A message that is moved to another version changes both fingerprints.
    let moved =
        [(1, "pub struct A { pub a: u64 } messages! { 0x0001 A(A), 0x0002 B(B), 0x0003 C(A) since 2, }"), new[1]];
    assert_ne!(print(1, &moved), print(1, &new));
    let later = [(1, new[0].1), (3, new[1].1)];
    assert_ne!(print(2, &later), print(2, &new));
}

/// Codes may come in every version, but they are not in the definitions of the versions before them.
#[test]
fn later_codes_do_not_change_the_fingerprint_of_a_version() {
    let print = |version, source: &str| fingerprint(version, &[(1, source)]);
    let old = "#[repr(u16)] pub enum ErrorCode { A = 1, B = 14, } pub enum Other { C = 15, }";
    let new = "#[repr(u16)] pub enum ErrorCode { A = 1, B = 14, D = 15, } pub enum Other { C = 15, }";
    assert_eq!((print(1, new), print(2, new)), (print(1, old), print(2, old)));
    assert_ne!(print(3, new), print(3, old));
    let newest = new.replace("D = 15,", "D = 15, E = 19,");
    assert_eq!((print(2, &newest), print(3, &newest)), (print(2, old), print(3, new)));
    assert_ne!(print(4, &newest), print(4, new));
    for changed in [old.replace("B = 14", "B = 13"), old.replace("C = 15", "C = 16"), old.replace("B = 14", "B = 15")] {
        assert_ne!(print(1, &changed), print(1, old), "{changed}");
    }
}

#[test]
fn comments_and_layout_do_not_change_the_fingerprint() {
    let plain = "pub struct A { pub a: u64, pub b: Vec<(u64, f64)> } pub enum B { C, D(u64) }";
    let other = "//! Header.\n/// Doc, with {.\n#[derive(Clone, Debug)]\npub enum B {\n    /// [C].\n    C, // c\n    D(\n u64,\n ),\n}\n\n\
                 fn helper() { let x = 1; }\n#[derive(Copy)]\npub struct A {\n    pub a: u64,\n    pub b: Vec<(u64, f64)>,\n}\n";
    assert_eq!(fingerprint(1, &[(1, plain)]), fingerprint(1, &[(1, other)]));
}

#[test]
fn changes_that_affect_bytes_or_json_change_the_fingerprint() {
    let source = "pub struct A { pub a: u64, pub b: u64 } pub enum B { C, D(u64) } #[repr(u16)] pub enum E { F = 1 } \
                  pub type G = (u64, f64); messages! { 0x0001 A(A), }";
    let changes = [
        ("pub a: u64, pub b: u64", "pub b: u64, pub a: u64"),
        ("pub a: u64", "pub a: u32"),
        ("pub a: u64", "pub z: u64"),
        ("pub a: u64", "pub a: u64, pub c: bool"),
        ("pub a", "#[serde(skip)] pub a"),
        ("pub struct", "#[serde(transparent)] pub struct"),
        ("C, D(u64)", "D(u64), C"),
        ("D(u64)", "D(f64)"),
        ("F = 1", "F = 2"),
        ("(u64, f64)", "(f64, u64)"),
        ("0x0001", "0x0002"),
    ];
    for (from, to) in changes {
        let changed = source.replacen(from, to, 1);
        assert_ne!(source, changed, "{from} stands in the source");
        assert_ne!(fingerprint(1, &[(1, source)]), fingerprint(1, &[(1, &changed)]), "{from} -> {to}");
    }
}

// ---- definitions in SPEC.md

/// Number, name and body of a message in SPEC.md.
type Row = (u16, String, String);

/// The rows of the tables in SPEC.md, and the one message that is not in a table.
fn rows() -> Vec<Row> {
    let in_tables = SPEC.lines().filter(|line| line.starts_with("| 0x")).map(row);
    let elapsed = between(SPEC, "`Elapsed` (", ", channel 0)");
    let (number, body) = elapsed.split_once(", ").expect("number and body");
    let elapsed = (hexadecimal(number), "Elapsed".to_owned(), body.replace('`', ""));
    // The messages of a later version have a section of their own, but numbers among the older ones.
    let mut rows: Vec<Row> = in_tables.chain([elapsed]).collect();
    rows.sort_by_key(|(number, ..)| *number);
    rows
}

fn row(line: &str) -> Row {
    let cells: Vec<String> = line.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', "")).collect();
    let body = cells.last().expect("it has cells").clone();
    (hexadecimal(&cells[0]), cells[1].clone(), body)
}

fn hexadecimal(number: &str) -> u16 {
    u16::from_str_radix(number.trim_start_matches("0x"), 16).expect("a number like 0x0103")
}

/// The text between two texts on one line.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let start = text.find(before).unwrap_or_else(|| panic!("SPEC.md has no `{before}`")) + before.len();
    let end = text[start..].find(after).unwrap_or_else(|| panic!("nothing ends `{before}`"));
    &text[start..start + end]
}

/// Splits at commas outside of brackets.
fn parts(list: &str) -> Vec<String> {
    let mut depth = 0;
    let mut parts = vec![String::new()];
    for mark in list.chars() {
        match mark {
            '{' | '[' | '(' | '<' => depth += 1,
            '}' | ']' | ')' | '>' => depth -= 1,
            _ => {}
        }
        if depth == 0 && mark == ',' {
            parts.push(String::new());
        } else if let Some(part) = parts.last_mut() {
            part.push(mark);
        }
    }
    let parts = parts.into_iter().map(|part| part.trim().to_owned());
    parts.filter(|part| !part.is_empty()).collect()
}

/// Names and types of the fields in braces, as SPEC.md writes them, without its names for the parts of a pair.
fn fields(body: &str, wording: fn(&str) -> String) -> Vec<(String, String)> {
    let list = body.strip_prefix('{').and_then(|body| body.strip_suffix('}')).expect("fields stand in braces");
    let field = |field: String| {
        let (name, kind) = field.split_once(':').expect("name and type");
        (name.trim_start_matches("pub ").to_owned(), wording(kind.trim()))
    };
    parts(list).into_iter().map(field).collect()
}

/// A type in SPEC.md without the names of the parts of a pair.
fn spec_type(text: &str) -> String {
    if let Some(inner) = text.strip_suffix('?') {
        format!("{}?", spec_type(inner))
    } else if let Some(inner) = text.strip_prefix('[') {
        format!("[{}]", spec_type(inner.strip_suffix(']').expect("it is closed")))
    } else if let Some(inner) = text.strip_prefix('(') {
        let unnamed = |part: String| spec_type(part.split_once(": ").map_or(part.as_str(), |(_, kind)| kind));
        format!(
            "({})",
            parts(inner.strip_suffix(')').expect("it is closed"))
                .into_iter()
                .map(unnamed)
                .collect::<Vec<_>>()
                .join(",")
        )
    } else {
        text.to_owned()
    }
}

/// A Rust type as SPEC.md writes it.
fn rust_type(text: &str) -> String {
    let generic = |name: &str| text.strip_prefix(name)?.strip_prefix('<')?.strip_suffix('>');
    if let Some(inner) = generic("Option") {
        format!("{}?", rust_type(inner))
    } else if let Some(inner) = generic("Vec") {
        format!("[{}]", rust_type(inner))
    } else if let Some(inner) = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
        format!("({})", parts(inner).iter().map(|part| rust_type(part)).collect::<Vec<_>>().join(","))
    } else {
        match text {
            "String" => "string".to_owned(),
            "FrameInfo" => "Frame".to_owned(),
            text => text.to_owned(),
        }
    }
}

#[test]
fn the_spec_lists_every_message() {
    let rows = rows();
    let listed: Vec<(u16, &str)> = rows.iter().map(|(number, name, _)| (*number, name.as_str())).collect();
    assert_eq!(listed, Message::KINDS);
}

/// Messages of version 2 are in their own section, and no others are. So are those of versions 3 and 4.
#[test]
fn the_spec_states_the_first_version_of_each_message() {
    let tracks = between(SPEC, "## 9. Tracks\n\nSince version 2.", "\n## ");
    let administration = between(SPEC, "## 12. Administration\n\nSince version 3.", "\n## ");
    let (_, spaces) = SPEC.split_once("## 13. Spaces\n\nSince version 4.").expect("it has a section");
    for sample in samples::all() {
        let row = format!("| {:#06X} |", sample.message.kind()).replace("0X", "0x");
        assert_eq!(tracks.contains(&row), sample.message.since() == 2, "{}", sample.name);
        assert_eq!(administration.contains(&row), sample.message.since() == 3, "{}", sample.name);
        assert_eq!(spaces.contains(&row), sample.message.since() == 4, "{}", sample.name);
    }
}

#[test]
fn the_spec_lists_the_fields_of_every_sample() {
    let rows: BTreeMap<u16, Row> = rows().into_iter().map(|row| (row.0, row)).collect();
    for sample in samples::all() {
        let (_, name, body) = &rows[&sample.message.kind()];
        let listed: Vec<String> = fields(body, spec_type).into_iter().map(|(name, _)| name).collect();
        let json = samples::json::of(sample.channel, &sample.message);
        assert_eq!(json_fields(&json), listed, "{name}, {}", sample.name);
    }
}

/// The names of the fields of the body in pretty JSON: they are indented by four.
fn json_fields(json: &str) -> Vec<String> {
    let names = json.lines().filter_map(|line| line.strip_prefix("    \"")?.split_once('"'));
    names.map(|(name, _)| name.to_owned()).collect()
}

/// The table of messages in the source: from the name on the wire to the type of the body.
fn bodies() -> BTreeMap<String, String> {
    let entry = |entry: String| {
        let (entry, _) = entry_and_first(entry);
        let (_, message) = entry.split_once(' ').expect("number and message");
        let (name, body) = message.trim_end_matches(')').split_once('(').expect("name and body");
        (name.to_owned(), body.to_owned())
    };
    inner(&all(Kind::Table)["messages!"]).into_iter().map(entry).collect()
}

/// The text between braces.
fn inner(body: &str) -> Vec<String> {
    parts(&body[1..body.len() - 1])
}

#[test]
fn the_spec_has_the_types_of_all_fields() {
    let bodies = bodies();
    let of_message: BTreeMap<&String, String> =
        rows().into_iter().map(|(_, name, body)| (&bodies[&name], body)).collect();
    let structs = all(Kind::Struct);
    assert_eq!(structs.len(), of_message.len() + 17, "so many are no messages");
    for (name, body) in structs {
        let listed = of_message.get(&name).cloned().unwrap_or_else(|| shared(&rust_type(&name), "{"));
        assert_eq!(fields(&body, rust_type), fields(&listed, spec_type), "{name}");
    }
    let aliases = all(Kind::Alias);
    assert_eq!(aliases.len(), 3);
    for (name, alias) in aliases {
        assert_eq!(rust_type(&alias), spec_type(&shared(&name, "(")), "{name}");
    }
}

/// The definition of a type that is not a message, in a table or in a sentence.
fn shared(name: &str, opening: &str) -> String {
    let spec = SPEC.split_whitespace().collect::<Vec<_>>().join(" ");
    let starts = [format!("| `{name}` | `{opening}"), format!("`{name}` is `{opening}")];
    let start = starts.iter().find(|start| spec.contains(*start)).unwrap_or_else(|| panic!("SPEC.md has no `{name}`"));
    format!("{opening}{}", between(&spec, start, "`"))
}

#[test]
fn the_spec_has_every_case_of_every_enum() {
    let mut choices = all(Kind::Enum);
    // Enums with explicit numbers are codes.
    choices.retain(|_, body| !body.contains('='));
    assert_eq!(choices.len(), 9);
    for (name, body) in choices {
        assert_eq!(spec_cases(&name), inner(&body), "{name}");
    }
}

/// The cases of an enum in SPEC.md. Their numbers count from 0.
fn spec_cases(name: &str) -> Vec<String> {
    let spec = SPEC.split_whitespace().collect::<Vec<_>>().join(" ");
    let quoted = format!("`{name}`");
    let named = spec.match_indices(&quoted).map(|(at, text)| &spec[at + text.len()..]);
    let mut lists = named.filter_map(|after| after.split_once("one of:").filter(|(words, _)| !words.contains('`')));
    let (_, list) = lists.next().unwrap_or_else(|| panic!("SPEC.md has no cases of `{name}`"));
    let list = list.split(" |").next().and_then(|list| list.split(" * ").next()).expect("a list begins");
    let pieces: Vec<&str> = list.split('`').collect();
    let mut cases: Vec<String> = Vec::new();
    for pair in pieces.chunks_exact(2) {
        if pair[0].ends_with(&format!(" {} ", cases.len())) {
            cases.push(pair[1].replace(' ', ""));
        }
    }
    cases
}

/// SPEC.md gives the number of every code.
#[test]
fn the_spec_names_every_code() {
    let lists = [("ErrorCode", "Codes: ", "Others may come"), ("RefusalCode", "place in the batch; ", "`Policy`")];
    let spec = SPEC.split_whitespace().collect::<Vec<_>>().join(" ");
    for (name, before, after) in lists {
        let listed = between(&spec, before, after).split("; ").filter_map(|code| code.split(' ').next()?.parse().ok());
        let cases = inner(&all(Kind::Enum)[name]);
        let number = |case: &String| case.split_once('=').expect("it has a number").1.parse().expect("it is one");
        assert_eq!(listed.collect::<Vec<u16>>(), cases.iter().map(number).collect::<Vec<u16>>(), "{name}");
    }
}
