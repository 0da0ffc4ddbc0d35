//! Which kind of JSON a text is: lines of points, a document of points, or GeoJSON.
//!
//! In: the text from its first bracket on.
//! Out: a [`JsonStart`].
//! Invariant: more text is asked for only while a line of JSON would not have ended.
//! Must not know: how JSON is read.

/// What a JSON text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JsonStart {
    /// More text may say it.
    Open,
    /// One array or object on each line.
    Lines,
    /// Arrays of points, or objects over several lines.
    Elements,
    GeoJson,
}

/// Members of an object that is a line of points.
const OF_LINES: [&[u8]; 7] = [b"x", b"y", b"t", b"points", b"retract", b"commit", b"time"];

/// Members of GeoJSON.
const OF_GEOJSON: [&[u8]; 4] = [b"features", b"geometry", b"geometries", b"coordinates"];

/// Types of GeoJSON.
const TYPES: [&[u8]; 9] = [
    b"Feature",
    b"FeatureCollection",
    b"Point",
    b"MultiPoint",
    b"LineString",
    b"MultiLineString",
    b"Polygon",
    b"MultiPolygon",
    b"GeometryCollection",
];

/// What the text is. `is_all`: no more will come.
pub(super) fn start(text: &[u8], is_all: bool) -> JsonStart {
    let decided = if text.first() == Some(&b'[') { array(text) } else { object(text) };
    if decided != JsonStart::Open || !is_all {
        return decided;
    }
    // It breaks off.
    let is_array = text.first() == Some(&b'[');
    let is_line = |byte: &u8| !(matches!(byte, b'\n' | b'\r') || is_array && *byte == b'{');
    if text.trim_ascii_end().iter().all(is_line) { JsonStart::Lines } else { JsonStart::Elements }
}

/// An array with arrays, objects or line ends in it is no line.
fn array(text: &[u8]) -> JsonStart {
    let mut scan = Scan::default();
    for (at, &byte) in text.iter().enumerate().skip(1) {
        if scan.is_in_string(byte) {
            continue;
        }
        match byte {
            // Features may stand in a list of their own.
            b'{' => {
                return match object(&text[at..]) {
                    JsonStart::GeoJson => JsonStart::GeoJson,
                    JsonStart::Open => JsonStart::Open,
                    JsonStart::Lines | JsonStart::Elements => JsonStart::Elements,
                };
            }
            b'[' | b'\n' | b'\r' if is_list(&text[at..]) => return JsonStart::Elements,
            b']' => return JsonStart::Lines,
            _ => {}
        }
    }
    JsonStart::Open
}

/// After a line end, only the next byte that is not blank says what it is a list of.
fn is_list(rest: &[u8]) -> bool {
    rest.iter().find(|byte| !byte.is_ascii_whitespace()).is_some_and(|&byte| byte != b'{')
}

fn object(text: &[u8]) -> JsonStart {
    let mut scan = Scan::default();
    let mut depth = 0_usize;
    let mut has_lines = false;
    // Where the last string in the outer object began, and its text.
    let (mut begin, mut last, mut key): (usize, &[u8], &[u8]) = (0, b"", b"");
    let mut is_known = false;
    for (at, &byte) in text.iter().enumerate() {
        let was_in_string = scan.is_open;
        if scan.is_in_string(byte) {
            if !was_in_string {
                begin = at + 1;
            } else if !scan.is_open && depth == 1 {
                last = &text[begin..at];
                if key == b"type" && TYPES.contains(&last) {
                    return JsonStart::GeoJson;
                }
            }
            continue;
        }
        match byte {
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth = depth.saturating_sub(1),
            b'\n' | b'\r' => has_lines = true,
            b',' if depth == 1 => key = b"",
            b':' if depth == 1 => key = last,
            _ => {}
        }
        if byte == b':' && depth == 1 {
            if OF_GEOJSON.contains(&key) {
                return JsonStart::GeoJson;
            }
            is_known |= OF_LINES.contains(&key);
        }
        if has_lines && is_known {
            return JsonStart::Elements;
        }
        if depth == 0 {
            return if has_lines { JsonStart::Elements } else { JsonStart::Lines };
        }
    }
    JsonStart::Open
}

/// Tells strings from the rest.
#[derive(Default)]
struct Scan {
    is_open: bool,
    is_escaped: bool,
}

impl Scan {
    /// Whether the byte belongs to a string, its quotes included.
    fn is_in_string(&mut self, byte: u8) -> bool {
        if !self.is_open {
            self.is_open = byte == b'"';
            return self.is_open;
        }
        self.is_open = byte != b'"' || self.is_escaped;
        self.is_escaped = byte == b'\\' && !self.is_escaped;
        true
    }
}
