//! What a file is, by its first bytes, and by the end of its name where these do not decide.
//!
//! In: a name, the first bytes, and whether there are more.
//! Out: what the file is, or that more bytes are needed.
//! Invariants: more bytes are asked for only while the first line has not ended, while the bytes may still become those
//! of another format, or while there was nothing but blank lines and comments. So of a live stream of text nothing is
//! held back that a reader of lines could hand on.
//! Must not know: how a file is read.

use std::path::Path;

use super::Readable;
use super::json_start::{self, JsonStart};
use super::refusal::Refusal;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Kind {
    Gzip,
    Utf16 {
        is_big_endian: bool,
    },
    Text,
    /// An array or object on every line.
    JsonLines,
    Readable(Readable),
    Refused(Refusal),
}

/// What the first bytes say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// Not this.
    Other,
    /// More bytes may say it.
    Open,
    Is(Kind),
}

/// How many bytes decide at the most.
pub(in super::super) const DECISIVE: usize = 64 * 1024;

/// How many bytes tell binary data from text.
const BEGINNING: usize = 512;

/// What stands before the first line of a UTF-8 text.
const MARK: &[u8] = b"\xef\xbb\xbf";

const fn refused(refusal: Refusal) -> Kind {
    Kind::Refused(refusal)
}

/// What files begin with, all of it binary or of no use in a text.
const MAGIC: [(&[u8], Kind); 36] = [
    (b"\x1f\x8b", Kind::Gzip),
    (b"\x93NUMPY", Kind::Readable(Readable::Npy)),
    (b"\x89PNG", refused(Refusal::Photo)),
    (b"\xff\xd8\xff", refused(Refusal::Photo)),
    (b"GIF87a", refused(Refusal::Bitmap)),
    (b"GIF89a", refused(Refusal::Bitmap)),
    (b"II*\0", refused(Refusal::Bitmap)),
    (b"MM\0*", refused(Refusal::Bitmap)),
    (b"\x89HDF", refused(Refusal::Hdf5)),
    (b"MATLAB 7.3 MAT-file", refused(Refusal::Hdf5)),
    (b"MATLAB 5.0 MAT-file", refused(Refusal::Matlab)),
    (b"ARROW1\0\0", refused(Refusal::Arrow)),
    (b"\x80\x02", refused(Refusal::Pickle)),
    (b"\x80\x03", refused(Refusal::Pickle)),
    (b"\x80\x04", refused(Refusal::Pickle)),
    (b"\x80\x05", refused(Refusal::Pickle)),
    (b"PK\x05\x06", refused(Refusal::Zip)),
    (b"\x28\xb5\x2f\xfd", refused(Refusal::Zstd)),
    (b"\xfd7zXZ\0", refused(Refusal::Xz)),
    (b"\x04\x22\x4d\x18", refused(Refusal::Lz4)),
    (b"7z\xbc\xaf", refused(Refusal::SevenZip)),
    (b"Rar!\x1a\x07", refused(Refusal::Rar)),
    (b"SQLite format 3\0", refused(Refusal::Sqlite)),
    (b"\x00\x00\x27\x0a", refused(Refusal::Shapefile)),
    (b"LASF\0", refused(Refusal::Las)),
    (b"HOPES\r\n\x1a", refused(Refusal::Recording)),
    (b"\xd0\xcf\x11\xe0", refused(Refusal::Excel)),
    (b"\x1a\x45\xdf\xa3", refused(Refusal::Video)),
    (b"FLV\x01", refused(Refusal::Video)),
    (b"OggS\0", refused(Refusal::Video)),
    (b"\x00\x00\x01\xba", refused(Refusal::Video)),
    (b"YUV4MPEG2", refused(Refusal::Y4m)),
    (b"%PDF-", refused(Refusal::Pdf)),
    (b"\xff\xfe\0\0", refused(Refusal::Utf32)),
    (b"\0\0\xfe\xff", refused(Refusal::Utf32)),
    (b"\xfe\xff", Kind::Utf16 { is_big_endian: true }),
];

/// What the first bytes are; none if more are needed. Of a format that was chosen, `is_chosen`, only encodings and
/// binary data are recognised; the answer is text for all else.
pub(in super::super) fn recognise(path: Option<&Path>, first: &[u8], is_all: bool, is_chosen: bool) -> Option<Kind> {
    let is_all = is_all || first.len() >= DECISIVE;
    let suffix = path.and_then(Path::extension).and_then(|suffix| suffix.to_str()).map(str::to_ascii_lowercase);
    let suffix = suffix.unwrap_or_default();
    for verdict in [magic(first), zip(first, &suffix), container(first), without_mark(first)] {
        match verdict {
            Verdict::Other => {}
            Verdict::Open if is_all => {}
            Verdict::Open => return None,
            Verdict::Is(kind) => return Some(kind),
        }
    }
    if is_chosen { Some(Kind::Text) } else { text(first, &suffix, is_all) }
}

fn magic(first: &[u8]) -> Verdict {
    if let Some((_, kind)) = MAGIC.iter().find(|(magic, _)| first.starts_with(magic)) {
        return Verdict::Is(*kind);
    }
    // The mark of UTF-16 is the beginning of that of UTF-32.
    if first.starts_with(b"\xff\xfe") && !b"\xff\xfe\0\0".starts_with(first) {
        return Verdict::Is(Kind::Utf16 { is_big_endian: false });
    }
    if MAGIC.iter().any(|(magic, _)| magic.starts_with(first)) { Verdict::Open } else { Verdict::Other }
}

/// A zip archive says by the name of its first file what it is for.
fn zip(first: &[u8], suffix: &str) -> Verdict {
    const START: &[u8] = b"PK\x03\x04";
    if START.starts_with(first) {
        return Verdict::Open;
    }
    let Some(header) = first.strip_prefix(START) else { return Verdict::Other };
    let is_office = ["xlsx", "xlsm", "ods"].contains(&suffix);
    let begins = |name: &[u8]| header.get(26..).is_some_and(|names| names.starts_with(name));
    let first_name = header.get(26..).unwrap_or_default();
    let name_length = header.get(22..24).map_or(0, |length| usize::from(length[0]) | usize::from(length[1]) << 8);
    if suffix == "npz" || first_name.get(..name_length).is_some_and(|name| name.ends_with(b".npy")) {
        return Verdict::Is(refused(Refusal::Npz));
    }
    if is_office || begins(b"[Content_Types].xml") || begins(b"xl/") || begins(b"_rels/") {
        return Verdict::Is(refused(Refusal::Excel));
    }
    if first_name.len() < name_length || header.len() < 26 { Verdict::Open } else { Verdict::Is(refused(Refusal::Zip)) }
}

/// Formats that are not known by their first byte alone.
fn container(first: &[u8]) -> Verdict {
    let at = |from: usize, known: &[u8]| first.get(from..).is_some_and(|rest| rest.starts_with(known));
    let needs = |length: usize| first.len() < length && !first.iter().any(|byte| matches!(byte, b'\n' | b'\r'));
    let picture = Verdict::Is(refused(Refusal::Bitmap));
    match first {
        // A word at the beginning of a line is followed by text, a magic number is not.
        [b'P', b'A', b'R', b'1', next, ..] | [b'F', b'E', b'A', b'1', next, ..] if !is_text(*next) => {
            Verdict::Is(refused(if first[0] == b'P' { Refusal::Parquet } else { Refusal::Arrow }))
        }
        [b'B', b'Z', b'h', b'1'..=b'9', ..] if at(4, b"1AY&SY") => Verdict::Is(refused(Refusal::Bzip2)),
        [b'B', b'M', ..] if at(6, &[0; 4]) => picture,
        [b'R', b'I', b'F', b'F', ..] if at(8, b"WEBP") => picture,
        [b'R', b'I', b'F', b'F', ..] if at(8, b"AVI ") => Verdict::Is(refused(Refusal::Video)),
        [0, 0, _, _, ..] if at(4, b"ftyp") => Verdict::Is(refused(Refusal::Video)),
        [b'P', b'1'..=b'7', b'\n' | b'\r', ..] => picture,
        [b'P' | b'F' | b'B' | b'R', ..] if needs(12) => Verdict::Open,
        [0, ..] if first.len() < 12 => Verdict::Open,
        _ => Verdict::Other,
    }
}

fn is_text(byte: u8) -> bool {
    byte.is_ascii_graphic() || byte.is_ascii_whitespace()
}

/// UTF-16 has NULs at every other byte of plain letters and numbers.
fn without_mark(first: &[u8]) -> Verdict {
    let beginning = &first[..first.len().min(4)];
    let is = |odd: bool| beginning.iter().enumerate().all(|(at, &byte)| (byte == 0) == ((at % 2 == 1) == odd));
    match (is(true), is(false)) {
        (false, false) => Verdict::Other,
        _ if beginning.len() < 4 => Verdict::Open,
        (_, is_big_endian) => Verdict::Is(refused(Refusal::Utf16 { is_big_endian })),
    }
}

/// What is text in the widest sense, if the first line of content says it.
fn text(first: &[u8], suffix: &str, is_all: bool) -> Option<Kind> {
    let content = first.strip_prefix(MARK).unwrap_or(first);
    if content.starts_with(b"# .PCD") || content.starts_with(b"#.PCD") {
        return Some(Kind::Readable(Readable::Pcd));
    }
    let start = content_start(content);
    let content = &content[start..];
    let json = match content.first() {
        Some(b'[' | b'{') => Some(json_start::start(content, is_all)),
        _ => None,
    };
    let line_end = content.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
    match json {
        Some(JsonStart::Open) => return None,
        Some(JsonStart::GeoJson) => return Some(Kind::Readable(Readable::GeoJson)),
        Some(JsonStart::Elements) => return Some(Kind::Readable(Readable::Elements)),
        Some(JsonStart::Lines) => {
            let is_geo = |kind: &Kind| *kind == Kind::Readable(Readable::GeoJson);
            return Some(by_suffix(suffix).filter(is_geo).unwrap_or(Kind::JsonLines));
        }
        None if line_end.is_none() && !is_all && !(first.len() >= BEGINNING && is_binary(&first[..BEGINNING])) => {
            return None;
        }
        None => {}
    }
    let line = content[..line_end.unwrap_or(content.len())].trim_ascii();
    let model = model(line);
    if let Some(Kind::Readable(_)) = model {
        return model;
    }
    if suffix == "stl" && !content.starts_with(b"solid") {
        return Some(refused(Refusal::StlBinary));
    }
    let beginning = &first[..first.len().min(BEGINNING)];
    let line_end = line_end.map_or(first.len(), |end| first.len() - content.len() + end);
    // One strange byte in the first line is reason enough to look at more.
    if strange(&beginning[..line_end.min(beginning.len())]) > 0 {
        if !is_all && first.len() < BEGINNING {
            return None;
        }
        if is_binary(beginning) {
            let is_archive = first.get(257..).is_some_and(|rest| rest.starts_with(b"ustar"));
            let refusal = refused(if is_archive { Refusal::Tar } else { Refusal::Unknown });
            return Some(by_suffix(suffix).unwrap_or(refusal));
        }
    }
    match markup(content, line, is_all) {
        Verdict::Open => return None,
        Verdict::Is(kind) => return Some(kind),
        Verdict::Other => {}
    }
    Some(model.or_else(|| by_suffix(suffix)).unwrap_or(Kind::Text))
}

/// Where the first line begins that is neither blank nor a comment.
fn content_start(bytes: &[u8]) -> usize {
    let mut start = 0;
    while let Some(skipped) = bytes[start..].iter().position(|byte| !byte.is_ascii_whitespace() && *byte != b'\x1e') {
        start += skipped;
        if bytes[start] != b'#' {
            return start;
        }
        let end = bytes[start..].iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        start = end.map_or(bytes.len(), |end| start + end);
    }
    bytes.len()
}

/// Formats whose first bytes do not say what they are.
fn by_suffix(suffix: &str) -> Option<Kind> {
    Some(match suffix {
        "geojson" | "geojsonl" => Kind::Readable(Readable::GeoJson),
        "json" | "jsonl" | "ndjson" => Kind::JsonLines,
        "obj" => refused(Refusal::Obj),
        "off" => refused(Refusal::Off),
        "pkl" | "pickle" => refused(Refusal::Pickle),
        "mat" => refused(Refusal::Matlab),
        "wkt" => refused(Refusal::Wkt),
        _ => return None,
    })
}

/// Whether more than a stray byte is none of a text.
fn is_binary(beginning: &[u8]) -> bool {
    let strange = strange(beginning);
    strange >= 4 && strange * 8 > beginning.len()
}

/// How many bytes are no characters of a text.
fn strange(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte < b' ' && !byte.is_ascii_whitespace() && byte != b'\x1b').count()
}

/// XML in all its forms, by its first element.
fn markup(content: &[u8], line: &[u8], is_all: bool) -> Verdict {
    if !matches!(line, [b'<', next, ..] if next.is_ascii_alphabetic() || matches!(next, b'?' | b'!')) {
        return Verdict::Other;
    }
    let text = String::from_utf8_lossy(&content[..content.len().min(4096)]).to_ascii_lowercase();
    let elements = [
        ("<gpx", Refusal::Gpx),
        ("<kml", Refusal::Kml),
        ("<svg", Refusal::Svg),
        ("<html", Refusal::Html),
        ("<!doctype html", Refusal::Html),
    ];
    let known = elements.iter().filter_map(|(element, refusal)| Some((text.find(element)?, *refusal)));
    match known.min_by_key(|(at, _)| *at) {
        Some((_, refusal)) => Verdict::Is(refused(refusal)),
        None if !is_all && content.len() < 4096 => Verdict::Open,
        None => Verdict::Is(refused(Refusal::Xml)),
    }
}

/// Models of solids, clouds and shapes, by their first line.
fn model(line: &[u8]) -> Option<Kind> {
    let line = std::str::from_utf8(&line[..line.len().min(256)]).ok()?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let numbers = |words: &[&str]| !words.is_empty() && words.iter().all(|word| word.parse::<f64>().is_ok());
    let upper = line.to_ascii_uppercase();
    Some(match words[..] {
        ["ply"] => Kind::Readable(Readable::Ply),
        ["VERSION", "0.7" | ".7" | "0.6" | ".6" | "0.5" | ".5"] => Kind::Readable(Readable::Pcd),
        ["OFF" | "COFF" | "NOFF" | "CNOFF" | "STOFF", ref counts @ ..] if counts.is_empty() || numbers(counts) => {
            refused(Refusal::Off)
        }
        ["solid", ref name @ ..]
            if name.first().is_none_or(|name| name.parse::<f64>().is_err()) && !line.contains(',') =>
        {
            refused(Refusal::StlText)
        }
        ["mtllib", _] => refused(Refusal::Obj),
        ["v", ref position @ ..] if (3..=7).contains(&position.len()) && numbers(position) => refused(Refusal::Obj),
        _ if is_well_known(&upper) => refused(Refusal::Wkt),
        _ => return None,
    })
}

fn is_well_known(upper: &str) -> bool {
    const SHAPES: [&str; 7] =
        ["POINT", "MULTIPOINT", "LINESTRING", "MULTILINESTRING", "POLYGON", "MULTIPOLYGON", "GEOMETRYCOLLECTION"];
    let shape = upper.strip_prefix("SRID=").and_then(|rest| rest.split_once(';')).map_or(upper, |(_, shape)| shape);
    let shape = shape.trim_start_matches('"');
    SHAPES.iter().any(|known| {
        let rest = shape.strip_prefix(known).map(str::trim_start);
        let rest = rest.map(|rest| rest.trim_start_matches(['Z', 'M']).trim_start());
        rest.is_some_and(|rest| rest.starts_with('('))
    })
}
