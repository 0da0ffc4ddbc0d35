//! Many points or segments as the data of one path.
//!
//! In: places in pixels.
//! Out: path data in short relative moves.
//! Invariants: it depends on the set of marks, not on their order; of dots on the same pixel one is kept, of equal
//! segments too, so its size is bounded by the panel's and not by the cloud's; numbers have at most two decimals,
//! and rounding does not add up along a path.
//! Must not know: styles.

/// A place on the grid, in hundredths of a pixel.
pub type Place = [i32; 2];

/// A grid that places are rounded to: the finer, the fewer marks there are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    step: i32,
}

impl Grid {
    /// The grid for so many marks on so many square pixels.
    pub fn new(marks: usize, area: f64) -> Self {
        let spacing = (area / marks.max(1) as f64).sqrt();
        let step = if spacing >= 4.0 {
            1
        } else if spacing >= 2.0 {
            25
        } else {
            100
        };
        Self { step }
    }

    /// The nearest place.
    pub fn place(self, at: [f64; 2]) -> Place {
        // Nothing that shows is farther away than that.
        at.map(|v| (v.clamp(-1e6, 1e6) * 100.0 / f64::from(self.step)).round() as i32 * self.step)
    }

    /// Side of the square in which one dot hides another.
    fn pixel(self) -> i32 {
        if self.step == 1 { 50 } else { 100 }
    }

    /// Dots: subpaths of no length, which show by their round caps.
    pub fn dots(self, places: impl Iterator<Item = [f64; 2]>) -> String {
        let pixel = self.pixel();
        let cell = |[x, y]: Place| [y.div_euclid(pixel), x.div_euclid(pixel)];
        let mut places: Vec<Place> = places.map(|at| self.place(at)).collect();
        places.sort_unstable_by_key(|&place| (cell(place), place));
        places.dedup_by_key(|place| cell(*place));
        let mut pen = Pen::default();
        for place in places {
            pen.move_to(place);
            pen.dot();
        }
        pen.data
    }

    /// Segments; those that end where they begin are left out.
    pub fn segments(self, segments: impl Iterator<Item = [[f64; 2]; 2]>) -> String {
        let downwards = |ends: [[f64; 2]; 2]| {
            let mut ends = ends.map(|end| self.place(end));
            ends.sort_unstable_by_key(|&[x, y]| [y, x]);
            ends
        };
        let mut segments: Vec<[Place; 2]> = segments.map(downwards).filter(|[from, to]| from != to).collect();
        segments.sort_unstable_by_key(|&[[x, y], to]| ([y, x], to));
        segments.dedup();
        let mut pen = Pen::default();
        for [from, to] in segments {
            pen.move_to(from);
            pen.line_to(to);
        }
        pen.data
    }
}

/// Writes path data.
#[derive(Default)]
struct Pen {
    data: String,
    at: Option<Place>,
}

impl Pen {
    fn move_to(&mut self, to: Place) {
        match self.at {
            Some(at) if at == to => return,
            Some(at) => self.command('m', [to[0] - at[0], to[1] - at[1]]),
            None => self.command('M', to),
        }
        self.at = Some(to);
    }

    fn dot(&mut self) {
        self.data.push_str("h0");
    }

    fn line_to(&mut self, to: Place) {
        let at = self.at.unwrap_or_default();
        match [to[0] - at[0], to[1] - at[1]] {
            [dx, 0] => self.single('h', dx),
            [0, dy] => self.single('v', dy),
            both => self.command('l', both),
        }
        self.at = Some(to);
    }

    fn single(&mut self, command: char, value: i32) {
        self.data.push(command);
        self.number(value);
    }

    fn command(&mut self, command: char, [x, y]: Place) {
        self.single(command, x);
        if y >= 0 {
            self.data.push(' ');
        }
        self.number(y);
    }

    /// Hundredths without needless zeros: 1250 is 12.5, -5 is -.05.
    fn number(&mut self, hundredths: i32) {
        if hundredths < 0 {
            self.data.push('-');
        }
        let [whole, part] = [hundredths.unsigned_abs() / 100, hundredths.unsigned_abs() % 100];
        if whole > 0 || part == 0 {
            self.data.push_str(&whole.to_string());
        }
        match part {
            0 => {}
            part if part % 10 == 0 => self.data.push_str(&format!(".{}", part / 10)),
            part => self.data.push_str(&format!(".{part:02}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Grid = Grid { step: 1 };

    #[test]
    fn numbers_are_short() {
        let written = [0, 5, -5, 50, 100, 1250, -1234].map(|hundredths| {
            let mut pen = Pen::default();
            pen.number(hundredths);
            pen.data
        });
        assert_eq!(written, ["0", ".05", "-.05", ".5", "1", "12.5", "-12.34"]);
    }

    #[test]
    fn dots_of_one_pixel_are_one() {
        let dots = |places: &[[f64; 2]]| FINE.dots(places.iter().copied());
        assert_eq!(dots(&[[1.1, 2.0], [1.0, 2.0], [5.0, 2.5]]), "M1 2h0m4 .5h0");
        assert_eq!(dots(&[[5.0, 2.5], [1.0, 2.0], [1.0, 2.0]]), "M1 2h0m4 .5h0");
        assert_eq!(dots(&[]), "");
    }

    #[test]
    fn segments_have_no_direction_and_join() {
        let segments = [[[0.0, 3.0], [0.0, 0.0]], [[4.0, 3.0], [0.0, 3.0]], [[0.0, 0.0], [0.0, 3.0]], [[1.0, 1.0]; 2]];
        assert_eq!(FINE.segments(segments.into_iter()), "M0 0v3h4");
    }

    #[test]
    fn crowds_are_on_a_coarser_grid() {
        let area = 100.0 * 100.0;
        assert_eq!([10, 2_000, 50_000].map(|marks| Grid::new(marks, area).step), [1, 25, 100]);
        let crowd = (0..1_000_000).map(|i| [f64::from(i % 1000) * 0.1, f64::from(i / 1000) * 0.1]);
        assert!(Grid::new(1_000_000, area).dots(crowd).len() < 80_000);
    }

    #[test]
    fn far_places_do_not_overflow() {
        assert_eq!(Grid { step: 100 }.place([f64::INFINITY, -1e300]), [100_000_000, -100_000_000]);
    }
}
