//! Points of any dimension as JSON lines write them: `[x,y,...]`, elements of a list, and `{"x":0,"y":0,"z":0}`.
//!
//! In: arrays and members that serde reads.
//! Out: all numbers of a point, or which of them is none.
//! Invariants: an array holds coordinates and nothing else: no time.
//! Must not know: how many coordinates the other points have.

use serde::de::SeqAccess;

use super::super::error::{BadLineReason, Coordinate, Fault, Field, Member};
use super::super::json_values::{ReadRow, Scalar};
use super::super::jsonl::{JsonPoint, Members, as_coordinate, not_a_number};

/// All elements of an array, or the first of them, counted from 1, that is no number.
#[derive(Debug)]
pub struct Numbers(Result<Vec<f64>, (usize, BadLineReason)>);

impl ReadRow for Numbers {
    fn read<'de, A: SeqAccess<'de>>(mut source: A) -> Result<Self, A::Error> {
        let mut numbers = Ok(Vec::new());
        let mut place = 0;
        while let Some(element) = source.next_element::<Scalar>()? {
            place += 1;
            if let Ok(known) = &mut numbers {
                match as_coordinate(&element) {
                    Some(number) => known.push(number),
                    None => numbers = Err((place, not_a_number(&element))),
                }
            }
        }
        Ok(Self(numbers))
    }
}

impl JsonPoint for Vec<f64> {
    type Row = Numbers;
    const MAY_HAVE_Z: bool = true;

    fn of_array(row: Numbers) -> Result<(Self, Option<f64>), Fault> {
        let numbers = row.0.map_err(|(place, reason)| Fault::at(Field::Coordinate(place), reason))?;
        if numbers.is_empty() { Err(Fault::of_line(nothing())) } else { Ok((numbers, None)) }
    }

    fn of_element(row: Numbers, at: impl Fn(Option<Coordinate>) -> Field) -> Result<Self, Fault> {
        let number = |place| at(Some(Coordinate::Number(place)));
        let numbers = row.0.map_err(|(place, reason)| Fault::at(number(place), reason))?;
        if numbers.is_empty() { Err(Fault::at(at(None), nothing())) } else { Ok(numbers) }
    }

    fn of_members(members: &mut Members) -> Result<Self, Fault> {
        let axes = [Member::X, Member::Y, Member::Z];
        let dimension = axes.iter().rposition(|&axis| members.has(axis)).map_or(0, |last| last + 1);
        axes[..dimension].iter().map(|&axis| members.coordinate(axis)).collect()
    }
}

fn nothing() -> BadLineReason {
    BadLineReason::WrongLength { found: 0, expected: "[x,y,...] with a number for each coordinate" }
}
