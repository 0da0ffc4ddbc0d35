//! Queries: what stands after the question mark of a request.
//!
//! In: a query, the keys that it may have besides those of a view.
//! Out: the view `k=..&l=..`, `alpha=..` or `full`; the values of the other keys.
//! Invariants: a query with an unknown key, or with two values for one, is refused with the reason.
//! Must not know: what is requested.

use hopes_protocol::{Cut, Simplify, View};

/// The keys of a view.
const OF_VIEW: [&str; 4] = ["k", "l", "alpha", "full"];

/// Keys and values, decoded.
#[derive(Debug)]
pub struct Query<'a>(Vec<(&'a str, String)>);

impl<'a> Query<'a> {
    /// A query that may have `others` as keys, and those of a view.
    ///
    /// # Errors
    /// The text says what is wrong with it, and what may be requested.
    pub fn parse(query: &'a str, others: &[&str]) -> Result<Self, String> {
        let mut pairs: Vec<(&str, String)> = Vec::new();
        for part in query.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            if !others.iter().chain(&OF_VIEW).any(|known| *known == key) {
                let known = [others, &OF_VIEW[..]].concat().join(", ");
                return Err(format!("{key:?} cannot be requested: use {known}"));
            }
            if pairs.iter().any(|(other, _)| *other == key) {
                return Err(format!("{key} is requested twice"));
            }
            pairs.push((key, decoded(value)?));
        }
        Ok(Self(pairs))
    }

    /// The value of a key, if it has the key.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(other, _)| *other == key).map(|(_, value)| &value[..])
    }

    /// Whether it has a key, which has no value.
    ///
    /// # Errors
    /// It has a value.
    pub fn has(&self, key: &str) -> Result<bool, String> {
        match self.value(key) {
            Some(value) if !value.is_empty() => Err(format!("{key} has no value")),
            value => Ok(value.is_some()),
        }
    }

    /// The view; by default that of k = l = 1.
    ///
    /// # Errors
    /// The text says what is wrong with it.
    pub fn view(&self) -> Result<View, String> {
        let count = |key| self.value(key).map(|value| count(key, value)).transpose();
        let (k, l, full) = (count("k")?, count("l")?, self.has("full")?);
        let cut = match (full, self.value("alpha").map(radius).transpose()?, k.or(l)) {
            (true, None, None) => Cut::Full,
            (false, Some(alpha), None) => Cut::Reduced(alpha),
            (false, None, _) => Cut::Derived(k.unwrap_or(1), l.unwrap_or(1)),
            _ => return Err("request k and l, or alpha, or full: these are different views".to_owned()),
        };
        Ok(View { cut, simplify: Simplify::No })
    }
}

fn count(key: &str, value: &str) -> Result<u32, String> {
    let count = value.parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| format!("{key} is a number from 1 to {}, not {value:?}", u32::MAX))
}

fn radius(value: &str) -> Result<f64, String> {
    let radius = value.parse().ok().filter(|radius: &f64| radius.is_finite() && *radius >= 0.0);
    radius.ok_or_else(|| format!("alpha is a radius, a finite number from 0, not {value:?}"))
}

/// Decodes the percent-encoding of a part of an address.
///
/// # Errors
/// The text says what is wrong with it.
pub fn decoded(part: &str) -> Result<String, String> {
    let mut bytes = Vec::with_capacity(part.len());
    let mut rest = part.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        let byte = match (first, after) {
            (b'%', &[high, low, ref after @ ..]) => {
                rest = after;
                let digit = |byte: u8| char::from(byte).to_digit(16);
                digit(high).zip(digit(low)).map(|(high, low)| (high << 4 | low) as u8)
            }
            (b'%', _) => None,
            _ => Some(first),
        };
        bytes.push(byte.ok_or_else(|| format!("{part:?} has a % without two digits after it: write %25 for %"))?);
    }
    String::from_utf8(bytes).map_err(|_| format!("{part:?} is no UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_encoding_is_decoded() {
        assert_eq!(decoded("a%20%C3%A4%2Fb+").as_deref(), Ok("a ä/b+"));
        assert!(decoded("%FF").unwrap_err().contains("UTF-8"));
    }
}
