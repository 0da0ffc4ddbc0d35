//! Labels along an edge, moved apart where they would overlap.
//!
//! In: labels with the place each of them is about, the most important first.
//! Out: where they go.
//! Invariants: labels keep the order of their places, do not overlap and stay inside the edge; if there is no room
//! for all, the least important are left out.
//! Must not know: what is labelled.

use super::page::{Anchor, Page, Type, text_width};

const SPACE: f64 = 8.0;
/// A label this near to its place needs no line to it.
const NEAR: f64 = 3.0;

/// A label.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// What it is about: a place along the edge.
    pub about: f64,
    pub text: String,
    pub color: &'static str,
}

/// A row of labels along a horizontal edge.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Where along the edge labels may be.
    pub from: f64,
    pub to: f64,
    /// Height of the edge that lines come from.
    pub edge: f64,
    /// Height at which lines end.
    pub reach: f64,
    /// Height of the texts' base line.
    pub base: f64,
}

impl Row {
    /// Draws what there is room for.
    pub fn draw(self, page: &mut Page, labels: Vec<Label>) {
        for (label, x) in spread(labels, self.from, self.to) {
            if (x - label.about).abs() > NEAR {
                let style = format_args!("stroke=\"{}\" stroke-width=\".75\"", label.color);
                page.line([label.about, self.edge], [x, self.reach], style);
            }
            page.text([x, self.base], Type::new(Anchor::Middle, label.color), &label.text);
        }
    }
}

/// Labels with the places of their middles, by place.
fn spread(mut labels: Vec<Label>, from: f64, to: f64) -> Vec<(Label, f64)> {
    while labels.iter().map(room).sum::<f64>() > to - from && !labels.is_empty() {
        labels.pop();
    }
    labels.sort_by(|a, b| a.about.total_cmp(&b.about));
    // With labels side by side from 0 on, each of them asks for a shift. Shifts that rise keep them apart, so we want
    // the rising ones that are nearest to those asked for.
    let mut taken = 0.0;
    let mut middles = Vec::with_capacity(labels.len());
    for label in &labels {
        middles.push(taken + room(label) / 2.0);
        taken += room(label);
    }
    let asked = labels.iter().zip(&middles).map(|(label, middle)| label.about - middle);
    let shifts = rising(asked);
    let placed = middles.iter().zip(shifts).map(|(middle, shift)| middle + shift.clamp(from, to - taken));
    let placed: Vec<f64> = placed.collect();
    labels.into_iter().zip(placed).collect()
}

/// How much of an edge a label needs.
pub fn room(label: &Label) -> f64 {
    text_width(&label.text) + SPACE
}

/// The rising sequence nearest to `values`: runs that fall become their mean.
fn rising(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut runs: Vec<(f64, usize)> = Vec::new();
    for value in values {
        let mut run = (value, 1);
        while let Some(&(mean, length)) = runs.last()
            && mean >= run.0
        {
            runs.pop();
            let both = length + run.1;
            run = ((mean * length as f64 + run.0 * run.1 as f64) / both as f64, both);
        }
        runs.push(run);
    }
    runs.into_iter().flat_map(|(mean, length)| std::iter::repeat_n(mean, length)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(places: &[f64]) -> Vec<Label> {
        places.iter().map(|&about| Label { about, text: "dgap 1".to_owned(), color: "#000" }).collect()
    }

    fn middles(places: &[f64]) -> Vec<f64> {
        spread(labels(places), 0.0, 200.0).into_iter().map(|(_, middle)| middle.round()).collect()
    }

    #[test]
    fn lone_labels_are_where_they_belong() {
        assert_eq!(middles(&[100.0]), [100.0]);
        assert_eq!(middles(&[30.0, 150.0]), [30.0, 150.0]);
    }

    #[test]
    fn crowded_labels_move_apart_and_stay_inside() {
        for places in [[1.0, 2.0, 3.0], [199.0, 198.0, 197.0], [100.0, 100.0, 100.0]] {
            let middles = middles(&places);
            assert!(middles.windows(2).all(|pair| pair[1] - pair[0] >= 47.0), "{middles:?}");
            assert!(middles[0] >= 24.0 && middles[2] <= 176.0, "{middles:?}");
        }
    }

    #[test]
    fn a_crowd_stays_around_its_places() {
        let middles = middles(&[99.0, 100.0, 101.0]);
        assert_eq!(middles[1], 100.0);
        assert_eq!(rising([1.0, 3.0, 1.0, 5.0].into_iter()), [1.0, 2.0, 2.0, 5.0]);
    }

    #[test]
    fn without_room_the_last_are_left_out() {
        assert_eq!(middles(&[150.0, 20.0, 100.0, 60.0, 70.0]).len(), 4);
        assert_eq!(spread(labels(&[1.0]), 0.0, 5.0), []);
    }
}
