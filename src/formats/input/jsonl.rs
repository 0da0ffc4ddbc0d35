//! The lines of a JSON stream: one array or object per line.
//!
//! In: one line (UTF-8, not blank).
//! Out: what it says, or what is wrong with it. The forms are `[x,y]`, `[x,y,t]`, `{"x":0,"y":0,"t":0}`,
//! `{"points":[[x,y]],"t":0}`, `{"retract":[[x,y]]}` and `{"commit":true,"time":0}`. `t` and `time` may be left out
//! or null; `t` also serves for a commit without `time`; members of other names, or of no use to the form, are
//! ignored.
//! Invariants: points go straight into the caller's buffer; nothing of a value that is not used is kept, so memory
//! is bounded by the line.
//! Must not know: line ends, line numbers, what becomes of the points.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::error::{BadLineReason, Fault, Field, Member};
use super::excerpt::Excerpt;
use super::json_values::{Name, Row, Scalar, a_string};
use super::record::Parsed;

/// Parses a line. Points are put into `points`.
pub(super) fn parse(line: &str, points: &mut Vec<[f64; 2]>) -> Result<Parsed, Fault> {
    let content = line.trim_ascii_start();
    match content.as_bytes().first() {
        Some(b'[') => parse_array(line, points),
        Some(b'{') => parse_object(line, points),
        _ => {
            let found = Excerpt::of(content.as_bytes());
            Err(Fault::of_line(BadLineReason::NotAnEntry { found }))
        }
    }
}

fn parse_array(line: &str, points: &mut Vec<[f64; 2]>) -> Result<Parsed, Fault> {
    let row: Row = serde_json::from_str(line).map_err(|error| json_fault(&error))?;
    let [x, y, t] = row.elements;
    if !matches!(row.length, 2 | 3) {
        let reason = BadLineReason::WrongLength { found: row.length, expected: "[x,y] or [x,y,t]" };
        return Err(Fault::of_line(reason));
    }
    points.push([number(x, Member::X)?, number(y, Member::Y)?]);
    Ok(Parsed::Points { time: number_or_null(t, Member::T)? })
}

fn parse_object(line: &str, points: &mut Vec<[f64; 2]>) -> Result<Parsed, Fault> {
    let mut fault = None;
    let mut json = serde_json::Deserializer::from_str(line);
    let object = Object { points, fault: &mut fault };
    let members = object.deserialize(&mut json).and_then(|members| json.end().map(|()| members));
    match (members, fault) {
        (_, Some(fault)) => Err(fault),
        (Err(error), None) => Err(json_fault(&error)),
        (Ok(members), None) => members.assemble(points),
    }
}

/// The fault that the JSON parser found, with the place as a byte of the line. Its messages quote
/// numbers at most, as strings are never reported through it.
fn json_fault(error: &serde_json::Error) -> Fault {
    let text = error.to_string();
    // The parser counts lines within the text it is given, which is always one line here.
    let message = text.rsplit_once(" at line ").map_or(text.as_str(), |(message, _)| message);
    let reason = BadLineReason::Json { message: message.to_owned() };
    Fault::at(Field::Byte(error.column()), reason)
}

fn number(value: Scalar, member: Member) -> Result<f64, Fault> {
    match value {
        Scalar::Number(number) => Ok(number),
        other => Err(Fault::of_member(member, not_a_number(&other))),
    }
}

fn number_or_null(value: Scalar, member: Member) -> Result<Option<f64>, Fault> {
    match value {
        Scalar::Null => Ok(None),
        other => number(other, member).map(Some),
    }
}

fn not_a_number(value: &Scalar) -> BadLineReason {
    BadLineReason::NotAJsonNumber { found: value.to_string() }
}

/// A list of points, which go into `points`. What JSON has no word for goes into `fault`.
struct List<'a> {
    list: Member,
    points: &'a mut Vec<[f64; 2]>,
    fault: &'a mut Option<Fault>,
}

impl<'de> DeserializeSeed<'de> for List<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for List<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of points [[x,y]]")
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Err(a_string(&self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut source: A) -> Result<(), A::Error> {
        for number in 1.. {
            let Some(row) = source.next_element()? else {
                break;
            };
            match listed_point(row, self.list, number) {
                Ok(point) => self.points.push(point),
                Err(fault) => return Err(stop(self.fault, fault)),
            }
        }
        Ok(())
    }
}

fn listed_point(row: Row, list: Member, point: usize) -> Result<[f64; 2], Fault> {
    let at = |coordinate| Field::Listed { list, point, coordinate };
    let [x, y, _] = row.elements;
    match (row.length, x, y) {
        (2, Scalar::Number(x), Scalar::Number(y)) => Ok([x, y]),
        (2, Scalar::Number(_), y) => Err(Fault::at(at(Some(Member::Y)), not_a_number(&y))),
        (2, x, _) => Err(Fault::at(at(Some(Member::X)), not_a_number(&x))),
        (found, ..) => {
            let reason = BadLineReason::WrongLength { found, expected: "[x,y]" };
            Err(Fault::at(at(None), reason))
        }
    }
}

/// Ends the parsing of a line for a fault that is not the JSON parser's: keeps the fault, and makes
/// an error that nobody will see.
fn stop<E: Error>(kept: &mut Option<Fault>, fault: Fault) -> E {
    *kept = Some(fault);
    E::custom("stopped")
}

/// A JSON object. Listed points go into `points`, what JSON has no word for into `fault`.
struct Object<'a> {
    points: &'a mut Vec<[f64; 2]>,
    fault: &'a mut Option<Fault>,
}

impl<'de> DeserializeSeed<'de> for Object<'_> {
    type Value = Members;

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<Members, D::Error> {
        source.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Object<'_> {
    type Value = Members;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut source: A) -> Result<Members, A::Error> {
        let mut members = Members::default();
        while let Some(Name(name)) = source.next_key()? {
            match name {
                None => drop(source.next_value::<IgnoredAny>()?),
                Some(member) if members.has(member) => {
                    let fault = Fault::of_member(member, BadLineReason::Repeated);
                    return Err(stop(self.fault, fault));
                }
                Some(member) => members.0[member as usize] = Some(self.value(member, &mut source)?),
            }
        }
        Ok(members)
    }
}

impl Object<'_> {
    fn value<'de, A: MapAccess<'de>>(&mut self, member: Member, source: &mut A) -> Result<Scalar, A::Error> {
        if !matches!(member, Member::Points | Member::Retract) {
            return source.next_value();
        }
        let list = List { list: member, points: &mut *self.points, fault: &mut *self.fault };
        source.next_value_seed(list).map(|()| Scalar::Array)
    }
}

/// The members found, by the number of the [`Member`]. The value of a list is [`Scalar::Array`].
#[derive(Debug, Default)]
struct Members([Option<Scalar>; Member::ALL.len()]);

impl Members {
    fn has(&self, member: Member) -> bool {
        self.0[member as usize].is_some()
    }

    fn take(&mut self, member: Member) -> Option<Scalar> {
        self.0[member as usize].take()
    }

    /// Decides which form the object has, and reads it as that.
    fn assemble(mut self, points: &mut Vec<[f64; 2]>) -> Result<Parsed, Fault> {
        match self.form()? {
            Member::Points => Ok(Parsed::Points { time: self.time(Member::T)? }),
            Member::Retract => Ok(Parsed::Retract),
            Member::Commit => self.commit(),
            _ => self.point(points),
        }
    }

    /// The member that stands for the form; for a single point, either coordinate.
    fn form(&self) -> Result<Member, Fault> {
        let coordinate = if self.has(Member::X) { Member::X } else { Member::Y };
        let mut forms = [coordinate, Member::Points, Member::Retract, Member::Commit]
            .into_iter()
            .filter(|&member| self.has(member));
        match (forms.next(), forms.next()) {
            (Some(form), None) => Ok(form),
            (Some(other), Some(form)) => Err(Fault::of_member(form, BadLineReason::Conflict { other })),
            (None, _) => Err(Fault::of_line(BadLineReason::NothingKnown)),
        }
    }

    fn point(mut self, points: &mut Vec<[f64; 2]>) -> Result<Parsed, Fault> {
        let x = self.coordinate(Member::X)?;
        let y = self.coordinate(Member::Y)?;
        points.push([x, y]);
        Ok(Parsed::Points { time: self.time(Member::T)? })
    }

    fn coordinate(&mut self, member: Member) -> Result<f64, Fault> {
        match self.take(member) {
            Some(value) => number(value, member),
            None => Err(Fault::of_member(member, BadLineReason::MissingMember)),
        }
    }

    fn commit(mut self) -> Result<Parsed, Fault> {
        match self.take(Member::Commit) {
            Some(Scalar::Bool(true)) => {}
            other => {
                let found = other.unwrap_or_default().to_string();
                return Err(Fault::of_member(Member::Commit, BadLineReason::NotTrue { found }));
            }
        }
        let time = self.time(Member::Time)?;
        Ok(Parsed::Commit { time: if time.is_some() { time } else { self.time(Member::T)? } })
    }

    fn time(&mut self, member: Member) -> Result<Option<f64>, Fault> {
        number_or_null(self.take(member).unwrap_or_default(), member)
    }
}
