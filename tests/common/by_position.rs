//! A skeleton with positions instead of ids, for comparisons bit for bit.

use hopes::topology::{Dot, Killer, Skeleton};

use super::clouds::Point;

/// A dot with its critical edge and its hole.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct DotAt {
    pub birth: f64,
    pub death: f64,
    /// The critical edge, the smaller end first.
    pub edge: [Point; 2],
    /// The triangle whose circumradius is the death. Its corners are sorted.
    pub triangle: [Point; 3],
    /// The centre of the hole.
    pub center: Point,
}

/// The content of a skeleton without ids. All lists are sorted by position.
#[derive(Clone, Debug, PartialEq)]
pub struct ByPosition {
    pub vertices: Vec<Point>,
    pub tree: Vec<[Point; 2]>,
    pub dots: Vec<DotAt>,
}

impl ByPosition {
    /// Also checks that the skeleton's own lists are sorted.
    pub fn of(skeleton: &Skeleton) -> Self {
        assert_in_order(skeleton);
        let at = |v: u32| skeleton.vertices().xy(v);
        let dot = |dot: &Dot| DotAt {
            birth: dot.birth,
            death: dot.death,
            edge: in_order(dot.edge.map(at)),
            triangle: triangle(dot).map(at),
            center: skeleton.hole(dot).expect("every hole of the plane has a centre").center,
        };
        Self {
            vertices: in_order(skeleton.vertices().positions().collect::<Vec<_>>()),
            tree: in_order(skeleton.tree().iter().map(|edge| in_order(edge.map(at))).collect::<Vec<_>>()),
            dots: in_order(skeleton.dots().iter().map(dot).collect::<Vec<_>>()),
        }
    }

    /// Panics with the first difference only, since whole skeletons are too long to read.
    #[track_caller]
    pub fn assert_same(&self, want: &Self) {
        first_difference("vertices", &self.vertices, &want.vertices);
        first_difference("tree edges", &self.tree, &want.tree);
        first_difference("dots", &self.dots, &want.dots);
    }
}

#[track_caller]
fn first_difference<T: PartialEq + std::fmt::Debug>(what: &str, ours: &[T], theirs: &[T]) {
    for index in 0..ours.len().max(theirs.len()) {
        let (our, their) = (ours.get(index), theirs.get(index));
        let counts = (ours.len(), theirs.len());
        assert!(our == their, "{what} {counts:?}, the first difference at {index}: {our:?} should be {their:?}");
    }
}

/// Sorted by plain comparison. There are no NaNs.
pub fn in_order<T: PartialOrd, L: AsMut<[T]>>(mut list: L) -> L {
    list.as_mut().sort_by(|a, b| a.partial_cmp(b).expect("no NaN in a skeleton"));
    list
}

fn triangle(dot: &Dot) -> [u32; 3] {
    let Killer::Triangle(corners) = dot.killer else { panic!("a triangle of the plane kills every dot: {dot:?}") };
    corners
}

fn assert_in_order(skeleton: &Skeleton) {
    let at = |v: u32| skeleton.vertices().xy(v);
    assert!(skeleton.vertices().ids().is_sorted_by(|a, b| a < b), "vertices by id");
    assert!(skeleton.tree().is_sorted_by(|a, b| a < b), "tree edges by ends");
    assert!(skeleton.tree().iter().all(|[a, b]| a < b), "the smaller end of a tree edge first");
    assert!(skeleton.dots().iter().all(|dot| dot.edge[0] < dot.edge[1]), "the smaller end of a critical edge first");
    assert!(
        skeleton.dots().iter().all(|dot| triangle(dot).is_sorted_by(|&a, &b| at(a) < at(b))),
        "corners by position"
    );
    let ranks = skeleton.dots().iter().map(|dot| (-dot.persistence(), dot.edge));
    assert!(ranks.is_sorted_by(|a, b| a < b), "dots by persistence, the largest first, equal ones by edge");
}
