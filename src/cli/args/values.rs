//! The small languages of values: scales, windows, durations, numbers of bytes.
//!
//! In: words of the command line.
//! Out: values, or what they may be.
//! Invariants: a value that the core could not use is refused here.
//! Must not know: options.

use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};
use std::str::FromStr;

use hopes::scene::UnknownScene;
use hopes::topology::{Remember, Window};

/// The rank of a gap, from 1.
pub fn rank(word: &str) -> Result<NonZeroU32, String> {
    word.parse().map_err(|_| format!("{word:?} is no rank: gaps are counted from 1, the widest"))
}

/// A whole number.
pub fn whole(word: &str) -> Result<u64, String> {
    word.parse().map_err(|_| format!("{word:?} is not a whole number from 0 to {}", u64::MAX))
}

/// A whole number, from 1.
pub fn from_one(word: &str) -> Result<u64, String> {
    let number = word.parse().ok().filter(|&number| number > 0);
    number.ok_or_else(|| format!("{word:?} is not a whole number from 1 to {}", u64::MAX))
}

/// A number of things that memory may hold.
pub fn how_many(word: &str) -> Result<usize, String> {
    word.parse().map_err(|_| format!("{word:?} is not a whole number from 0 up"))
}

/// A whole number, from LOW to HIGH.
pub fn within<const LOW: u32, const HIGH: u32>(word: &str) -> Result<u32, String> {
    let number = word.parse().ok().filter(|number| (LOW..=HIGH).contains(number));
    number.ok_or_else(|| format!("{word:?} is not a whole number from {LOW} to {HIGH}"))
}

/// A number of things, from 1.
pub fn at_least_one(word: &str) -> Result<NonZeroU32, String> {
    word.parse().map_err(|_| format!("{word:?} is not a whole number from 1 to {}", u32::MAX))
}

/// A number of things that memory may hold, from 1.
pub fn many(word: &str) -> Result<NonZeroUsize, String> {
    word.parse().map_err(|_| format!("{word:?} is not a whole number from 1 up"))
}

/// A rate or a speed: a positive number.
pub fn rate(word: &str) -> Result<f64, String> {
    positive(word, "rate")
}

/// A scale: a number, not negative.
pub fn scale(word: &str) -> Result<f64, String> {
    let value = number(word)?;
    if value >= 0.0 { Ok(value) } else { Err(format!("{word} is negative: a scale is a radius, from 0")) }
}

/// The step of a grid: a positive number.
pub fn resolution(word: &str) -> Result<f64, String> {
    positive(word, "step of a grid")
}

/// A window: `all`, `points:N`, `frames:N` or `time:T`.
pub fn window(word: &str) -> Result<Window, String> {
    let (kind, length) = word.split_once(':').unwrap_or((word, ""));
    let count = || length.parse::<NonZeroU64>().map_err(|_| format!("{length:?} is not a number of {kind}, from 1"));
    match (kind, length) {
        ("all", "") => Ok(Window::All),
        ("points", _) => count().map(Window::Points),
        ("frames", _) => count().map(Window::Frames),
        ("time", _) => time(length).map(Window::Time),
        _ => Err("a window is all, points:N, frames:N or time:T".to_owned()),
    }
}

/// How long a track is remembered: `N`, `frames:N` or `time:T`.
pub fn remember(word: &str) -> Result<Remember, String> {
    let frames = |word: &str| word.parse().map(Remember::Frames);
    let refused = |_| format!("{word:?} is none of N, frames:N (N frames, from 0) and time:T (a length of time)");
    match word.split_once(':') {
        None => frames(word).map_err(refused),
        Some(("frames", count)) => frames(count).map_err(refused),
        Some(("time", length)) => time(length).map(Remember::Time),
        Some(_) => Err(format!("{word:?} is none of N, frames:N and time:T")),
    }
}

/// A length of event time: a number, or with units, which are of seconds.
fn time(word: &str) -> Result<f64, String> {
    match humantime::parse_duration(word) {
        Ok(duration) if word.ends_with(|c: char| c.is_ascii_alphabetic()) && !duration.is_zero() => {
            Ok(duration.as_secs_f64())
        }
        _ => positive(word, "length of time").map_err(|error| format!("{error}: write it as 2.5 or 30s")),
    }
}

/// A length of real time, such as `100ms` or `2s`; not zero.
pub fn duration(word: &str) -> Result<std::time::Duration, String> {
    let duration = humantime::parse_duration(word).map_err(|error| format!("{error}: write it as 100ms or 2s"))?;
    if duration.is_zero() { Err(format!("{word} is no time at all: write it as 100ms or 2s")) } else { Ok(duration) }
}

/// An address of the page.
pub fn host_and_port(word: &str) -> Result<String, String> {
    let is_address = word.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    let is_whole = is_address && !word.contains('/');
    is_whole.then(|| word.to_owned()).ok_or_else(|| format!("{word:?} is no HOST:PORT, such as 127.0.0.1:8080"))
}

/// A name of the page's server, which may have a port.
pub fn host_name(word: &str) -> Result<String, String> {
    let (host, port) = split_port(word);
    let is_host = is_host(host) && port.is_none_or(|port| port.parse::<u16>().is_ok());
    is_host
        .then(|| word.to_owned())
        .ok_or_else(|| format!("{word:?} is no name of a host: write it as example.org, or as example.org:8443"))
}

/// The origin of a page: scheme, host and perhaps a port, as browsers send it.
pub fn origin(word: &str) -> Result<String, String> {
    let lower = word.to_ascii_lowercase();
    let host = lower.strip_prefix("https://").or_else(|| lower.strip_prefix("http://"));
    let is_origin = host.is_some_and(|host| host_name(host).is_ok());
    is_origin.then_some(lower).ok_or_else(|| {
        format!("{word:?} is no origin: write it as https://example.org, without a path and without a / at the end")
    })
}

/// A host, and what stands after its colon.
fn split_port(word: &str) -> (&str, Option<&str>) {
    match word.rsplit_once(':') {
        // The colons of an IPv6 address stand in brackets.
        Some((host, port)) if !port.ends_with(']') => (host, Some(port)),
        _ => (word, None),
    }
}

/// Whether a word is a name or an address as it stands in a request: browsers send other letters as xn--...
fn is_host(word: &str) -> bool {
    let is_in_brackets = word.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-' | '_');
    match is_in_brackets {
        Some(address) => {
            address.contains(':') && address.chars().all(|digit| digit.is_ascii_hexdigit() || digit == ':')
        }
        None => !word.is_empty() && word.chars().all(is_letter),
    }
}

/// A scene, by its name: of the plane, or of any family.
pub fn scene<K: FromStr<Err = UnknownScene>>(word: &str) -> Result<K, String> {
    word.parse().map_err(|error: UnknownScene| error.to_string())
}

fn positive(word: &str, what: &str) -> Result<f64, String> {
    let value = number(word)?;
    if value > 0.0 { Ok(value) } else { Err(format!("{word} is not a {what}: it must be above 0")) }
}

/// A finite number.
pub fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{word:?} is not a finite number")),
    }
}

/// A number of bytes: `4096`, `64KiB`, `512MiB`, `4GiB`.
pub fn bytes(word: &str) -> Result<u64, String> {
    let digits = word.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let unit: u64 = match &word[digits.len()..] {
        "" | "B" => 1,
        "KiB" => 1 << 10,
        "MiB" => 1 << 20,
        "GiB" => 1 << 30,
        unit => return Err(format!("{unit:?} is no unit: there are KiB, MiB, GiB")),
    };
    let number = digits.parse::<u64>().ok().and_then(|number| number.checked_mul(unit)).filter(|bytes| *bytes > 0);
    number.ok_or_else(|| format!("{word:?} is not a number of bytes: write 512MiB"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_read() {
        assert_eq!(window("all"), Ok(Window::All));
        assert_eq!(window("points:10"), Ok(Window::Points(NonZeroU64::new(10).unwrap())));
        assert_eq!(window("frames:1"), Ok(Window::Frames(NonZeroU64::MIN)));
        assert_eq!(window("time:2.5"), Ok(Window::Time(2.5)));
        for (word, seconds) in
            [("30s", 30.0), ("500ms", 0.5), ("1h 30m", 5400.0), ("2days", 172_800.0), ("1e3", 1000.0)]
        {
            assert_eq!(window(&format!("time:{word}")), Ok(Window::Time(seconds)), "{word}");
        }
    }

    #[test]
    fn bad_windows_are_refused_with_the_choices() {
        for (word, says) in [
            ("", "a window is all"),
            ("all:3", "a window is all"),
            ("points:0", "\"0\" is not a number of points, from 1"),
            ("points", "\"\" is not a number of points"),
            ("frames:-1", "\"-1\" is not a number of frames"),
            ("time:0", "0 is not a length of time"),
            ("time:inf", "\"inf\" is not a finite number"),
        ] {
            let error = window(word).unwrap_err();
            assert!(error.contains(says), "{word}: {error}");
        }
    }

    #[test]
    fn scales_and_steps_have_a_sign() {
        assert_eq!(scale("0"), Ok(0.0));
        assert!(scale("-1").is_err() && scale("nan").is_err());
        assert!(resolution("0").is_err() && resolution("0.5") == Ok(0.5));
        assert!(duration("0s").is_err() && duration("20ms").is_ok());
    }

    #[test]
    fn hosts_and_origins_are_those_that_browsers_send() {
        for word in ["example.org", "box:99", "[::1]", "[fe80::1]:8080", "a-b_c", "192.0.2.1:80"] {
            assert_eq!(host_name(word).as_deref(), Ok(word));
            assert_eq!(origin(&format!("HTTPS://{word}")), Ok(format!("https://{word}")));
        }
        for word in ["", "http://a", "a/b", "a:", "a:x", "a:99999", "*", "b\u{e4}r.example", "[::g]", "::1", "a b"] {
            assert!(host_name(word).unwrap_err().contains("example.org"), "{word}");
        }
        for word in ["", "example.org", "https://", "https://a/", "https://a/b", "ftp://a", "null", "*", "https://a?b"]
        {
            assert!(origin(word).unwrap_err().contains("https://example.org"), "{word}");
        }
    }

    #[test]
    fn bytes_have_units() {
        assert_eq!((bytes("4096"), bytes("64KiB"), bytes("2GiB")), (Ok(4096), Ok(65536), Ok(2 << 30)));
        for word in ["", "0", "-1", "1.5MiB", "3 MB", "99999999999GiB"] {
            assert!(bytes(word).is_err(), "{word}");
        }
    }
}
