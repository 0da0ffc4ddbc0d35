//! The lines of a JSON stream: one array or object per line.
//!
//! In: one line (UTF-8, not blank).
//! Out: what it says, or what is wrong with it. The forms are `[x,y]`, `[x,y,t]`, `{"x":0,"y":0,"t":0}`,
//! `{"points":[[x,y]],"t":0}`, `{"retract":[[x,y]]}` and `{"commit":true,"time":0}`. `t` and `time` may be left out
//! or null, and may be written in ISO 8601; `t` also serves for a commit without `time`; members of other names, or of
//! no use to the form, are ignored. Where event times are wanted, `t` of points may also be called `time`, `stamp` or
//! `timestamp`. A coordinate that is null, `NaN` or infinite is a number here that no point has.
//! Invariants: points go straight into the caller's buffer; a listed point that is none takes no other with it; nothing
//! of a value that is not used is kept, so memory is bounded by the line.
//! Must not know: line ends, line numbers, what becomes of the points.

use std::collections::VecDeque;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::error::{BadLineReason, Coordinate, Fault, Field, Member};
use super::excerpt::Excerpt;
use super::json_literals::with_quoted_literals;
use super::json_values::{Element, Name, ReadRow, Row, Scalar, a_string};
use super::record::{Parsed, Point};

/// Listed points whose fault is kept in words. Those after them are only counted.
const KEPT: usize = 64;

/// What is wrong with single points of a list.
#[derive(Debug, Default)]
pub(super) struct Faults {
    kept: VecDeque<Fault>,
    more: usize,
}

impl Faults {
    pub(super) fn add(&mut self, fault: Fault) {
        if self.kept.len() < KEPT { self.kept.push_back(fault) } else { self.more += 1 }
    }

    /// The next one, in the order of the points.
    pub(super) fn next(&mut self) -> Option<Fault> {
        self.kept.pop_front().or_else(|| {
            self.more = self.more.checked_sub(1)?;
            Some(Fault::of_line(BadLineReason::OneMorePoint))
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.kept.is_empty() && self.more == 0
    }

    pub(super) fn clear(&mut self) {
        self.kept.clear();
        self.more = 0;
    }
}

/// A point as JSON lines write it.
pub trait JsonPoint: Point {
    /// What is kept of an array of its coordinates.
    type Row: ReadRow;
    /// Whether an object may have a member `z`, which is no coordinate in the plane.
    const MAY_HAVE_Z: bool;

    /// The point that stands on a line of its own as an array, and its time.
    ///
    /// # Errors
    /// What is wrong with it.
    fn of_array(row: Self::Row) -> Result<(Self, Option<f64>), Fault>;

    /// A point in a list; `at` names its place.
    ///
    /// # Errors
    /// What is wrong with it.
    fn of_element(row: Self::Row, at: impl Fn(Option<Coordinate>) -> Field) -> Result<Self, Fault>;

    /// The point that an object says.
    ///
    /// # Errors
    /// What is missing, or wrong.
    fn of_members(members: &mut Members) -> Result<Self, Fault>;
}

impl JsonPoint for [f64; 2] {
    type Row = Row;
    const MAY_HAVE_Z: bool = false;

    #[inline]
    fn of_array(Row { elements: [x, y, t], length }: Row) -> Result<(Self, Option<f64>), Fault> {
        if !matches!(length, 2 | 3) {
            let reason = BadLineReason::WrongLength { found: length, expected: "[x,y] or [x,y,t]" };
            return Err(Fault::of_line(reason));
        }
        Ok(([coordinate(x, Member::X)?, coordinate(y, Member::Y)?], time(t, Member::T)?))
    }

    #[inline]
    fn of_element(row: Row, at: impl Fn(Option<Coordinate>) -> Field) -> Result<Self, Fault> {
        let [x, y, _] = &row.elements;
        if row.length != 2 {
            return Err(Fault::at(at(None), BadLineReason::WrongLength { found: row.length, expected: "[x,y]" }));
        }
        let coordinate = |value, member| {
            let fault = || Fault::at(at(Some(Coordinate::Member(member))), not_a_number(value));
            as_coordinate(value).ok_or_else(fault)
        };
        Ok([coordinate(x, Member::X)?, coordinate(y, Member::Y)?])
    }

    fn of_members(members: &mut Members) -> Result<Self, Fault> {
        Ok([members.coordinate(Member::X)?, members.coordinate(Member::Y)?])
    }
}

/// Parses a line. Points are put into `points`, and what is wrong with single ones into `faults`. If event times are
/// wanted, they may have other names than `t`.
pub(super) fn parse<P: JsonPoint>(
    line: &str,
    wants_times: bool,
    points: &mut Vec<P>,
    faults: &mut Faults,
) -> Result<Parsed, Fault> {
    let parsed = parse_strictly(line, wants_times, points, faults);
    if !matches!(parsed, Err(Fault { reason: BadLineReason::Json { .. }, .. })) {
        return parsed;
    }
    let Some(quoted) = with_quoted_literals(line) else { return parsed };
    points.clear();
    faults.clear();
    // Places in the line with quotes are not those of the line.
    parse_strictly(&quoted, wants_times, points, faults).map_err(|fault| match fault.field {
        Some(Field::Byte(_)) => Fault::of_line(fault.reason),
        _ => fault,
    })
}

fn parse_strictly<P: JsonPoint>(
    line: &str,
    wants_times: bool,
    points: &mut Vec<P>,
    faults: &mut Faults,
) -> Result<Parsed, Fault> {
    let content = line.trim_ascii_start();
    match content.as_bytes().first() {
        Some(b'[') => parse_array(line, points),
        Some(b'{') => parse_object(line, wants_times, points, faults),
        _ => {
            let found = Excerpt::of(content.as_bytes());
            Err(Fault::of_line(BadLineReason::NotAnEntry { found }))
        }
    }
}

fn parse_array<P: JsonPoint>(line: &str, points: &mut Vec<P>) -> Result<Parsed, Fault> {
    let element: Element<P::Row> = serde_json::from_str(line).map_err(|error| json_fault(&error))?;
    let (point, time) = P::of_array(element.row().map_err(Fault::of_line)?)?;
    points.push(point);
    Ok(Parsed::Points { time })
}

fn parse_object<P: JsonPoint>(
    line: &str,
    wants_times: bool,
    points: &mut Vec<P>,
    faults: &mut Faults,
) -> Result<Parsed, Fault> {
    let mut fault = None;
    let mut json = serde_json::Deserializer::from_str(line);
    let object = Object { points, faults, fault: &mut fault };
    let members = object.deserialize(&mut json).and_then(|members| json.end().map(|()| members));
    match (members, fault) {
        (_, Some(fault)) => Err(fault),
        (Err(error), None) => Err(json_fault(&error)),
        (Ok(members), None) => members.assemble(wants_times, points),
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

/// A value where a coordinate should be: null is no number, which no point has.
pub(super) fn as_coordinate(value: &Scalar) -> Option<f64> {
    match *value {
        Scalar::Number(number) => Some(number),
        Scalar::Null => Some(f64::NAN),
        _ => None,
    }
}

fn coordinate(value: Scalar, member: Member) -> Result<f64, Fault> {
    as_coordinate(&value).ok_or_else(|| Fault::of_member(member, not_a_number(&value)))
}

/// A value where a time should be; none if it is null.
fn time(value: Scalar, member: Member) -> Result<Option<f64>, Fault> {
    match value {
        Scalar::Null => Ok(None),
        Scalar::Number(time) | Scalar::Time(time, _) => Ok(Some(time)),
        Scalar::Text(found) => Err(Fault::of_member(member, BadLineReason::NotATime { found })),
        other => Err(Fault::of_member(member, not_a_number(&other))),
    }
}

pub(super) fn not_a_number(value: &Scalar) -> BadLineReason {
    BadLineReason::NotAJsonNumber { found: value.to_string() }
}

/// A list of points, which go into `points`, or what is wrong with them into `faults`.
struct List<'a, P> {
    list: Member,
    points: &'a mut Vec<P>,
    faults: &'a mut Faults,
}

impl<'de, P: JsonPoint> DeserializeSeed<'de> for List<'_, P> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de, P: JsonPoint> Visitor<'de> for List<'_, P> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of points [[x,y]]")
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Err(a_string(&self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut source: A) -> Result<(), A::Error> {
        for number in 1.. {
            let Some(element) = source.next_element()? else {
                break;
            };
            match listed_point(element, self.list, number) {
                Ok(point) => self.points.push(point),
                Err(fault) => self.faults.add(fault),
            }
        }
        Ok(())
    }
}

fn listed_point<P: JsonPoint>(element: Element<P::Row>, list: Member, point: usize) -> Result<P, Fault> {
    let at = |coordinate| Field::Listed { list, point, coordinate };
    P::of_element(element.row().map_err(|reason| Fault::at(at(None), reason))?, at)
}

/// Ends the parsing of a line for a fault that is not the JSON parser's: keeps the fault, and makes
/// an error that nobody will see.
fn stop<E: Error>(kept: &mut Option<Fault>, fault: Fault) -> E {
    *kept = Some(fault);
    E::custom("stopped")
}

/// A JSON object. Listed points go into `points`, what is wrong with single ones into `faults`, and what JSON has no
/// word for into `fault`.
struct Object<'a, P> {
    points: &'a mut Vec<P>,
    faults: &'a mut Faults,
    fault: &'a mut Option<Fault>,
}

impl<'de, P: JsonPoint> DeserializeSeed<'de> for Object<'_, P> {
    type Value = Members;

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<Members, D::Error> {
        source.deserialize_map(self)
    }
}

impl<'de, P: JsonPoint> Visitor<'de> for Object<'_, P> {
    type Value = Members;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut source: A) -> Result<Members, A::Error> {
        let mut members = Members::default();
        while let Some(Name(name)) = source.next_key()? {
            match name.filter(|&member| member != Member::Z || P::MAY_HAVE_Z) {
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

impl<P: JsonPoint> Object<'_, P> {
    fn value<'de, A: MapAccess<'de>>(&mut self, member: Member, source: &mut A) -> Result<Scalar, A::Error> {
        if !matches!(member, Member::Points | Member::Retract) {
            return source.next_value();
        }
        let list = List { list: member, points: &mut *self.points, faults: &mut *self.faults };
        source.next_value_seed(list).map(|()| Scalar::Array)
    }
}

/// The members found, by the number of the [`Member`]. The value of a list is [`Scalar::Array`].
#[derive(Debug, Default)]
pub struct Members([Option<Scalar>; Member::ALL.len()]);

impl Members {
    pub(super) fn has(&self, member: Member) -> bool {
        self.0[member as usize].is_some()
    }

    fn take(&mut self, member: Member) -> Option<Scalar> {
        self.0[member as usize].take()
    }

    /// Decides which form the object has, and reads it as that.
    fn assemble<P: JsonPoint>(mut self, wants_times: bool, points: &mut Vec<P>) -> Result<Parsed, Fault> {
        match self.form()? {
            Member::Points => Ok(Parsed::Points { time: self.event_time(wants_times)? }),
            Member::Retract => Ok(Parsed::Retract),
            Member::Commit => self.commit(),
            _ => self.point(wants_times, points),
        }
    }

    /// The member that stands for the form; for a single point, either coordinate.
    fn form(&self) -> Result<Member, Fault> {
        let coordinate = [Member::X, Member::Y, Member::Z].into_iter().find(|&member| self.has(member));
        let others = [Member::Points, Member::Retract, Member::Commit];
        let mut forms = coordinate.into_iter().chain(others.into_iter().filter(|&member| self.has(member)));
        match (forms.next(), forms.next()) {
            (Some(form), None) => Ok(form),
            (Some(other), Some(form)) => Err(Fault::of_member(form, BadLineReason::Conflict { other })),
            (None, _) => Err(Fault::of_line(BadLineReason::NothingKnown)),
        }
    }

    fn point<P: JsonPoint>(mut self, wants_times: bool, points: &mut Vec<P>) -> Result<Parsed, Fault> {
        points.push(P::of_members(&mut self)?);
        Ok(Parsed::Points { time: self.event_time(wants_times)? })
    }

    /// The value of a coordinate, which must be there.
    pub(super) fn coordinate(&mut self, member: Member) -> Result<f64, Fault> {
        match self.take(member) {
            Some(value) => coordinate(value, member),
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

    /// The time of points: `t`, else one of the other names if times are wanted.
    fn event_time(&mut self, wants_times: bool) -> Result<Option<f64>, Fault> {
        let others = [Member::Time, Member::Stamp, Member::Timestamp];
        let other = others.into_iter().find(|&member| wants_times && self.has(member));
        let member = if self.has(Member::T) { Member::T } else { other.unwrap_or(Member::T) };
        self.time(member)
    }

    fn time(&mut self, member: Member) -> Result<Option<f64>, Fault> {
        time(self.take(member).unwrap_or_default(), member)
    }
}
