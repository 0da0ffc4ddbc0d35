//! Layouts as wholes.
//!
//! In: small spaces.
//! Out: nothing; a test fails if places are not where they should be.
//! Invariants: lengths are compared, where axes are free.
//! Must not know: pictures.

use hopes::topology::spaces::{Graph, Matrix, Points};

use super::*;

fn vertices(points: &[Vec<f64>]) -> Vertices {
    points.iter().enumerate().map(|(id, point)| (VertexId(id as u64), point.as_slice())).collect()
}

/// A coil whose axis is the first one.
fn coil(count: u32) -> Vec<Vec<f64>> {
    (0..count).map(f64::from).map(|i| vec![0.3 * i, i.cos(), 2.0 * i.sin(), 0.5]).collect()
}

fn length<const K: usize>(a: [f64; K], b: [f64; K]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

fn plain<const K: usize>(vertices: &Vertices, shape: Shape<'_>) -> Layout<K> {
    Layout::new(vertices, shape, None)
}

#[test]
fn points_of_few_dimensions_stay_where_they_are() {
    let flat = plain::<2>(&vertices(&[vec![3.0, 4.0], vec![-1.0, 0.0]]), Shape::Points(Metric::Manhattan));
    assert_eq!((flat.places(), flat.account()), (&[[3.0, 4.0], [-1.0, 0.0]][..], Account::Coordinates));
    assert_eq!((flat.metric(), flat.has_lengths()), (Some(Metric::Manhattan), false));
    let line = plain::<3>(&vertices(&[vec![3.0], vec![-1.0]]), Shape::Points(Metric::Euclidean));
    assert_eq!(line.places(), [[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
    let before = plain::<3>(&vertices(&[vec![7.0], vec![9.0]]), Shape::Points(Metric::Euclidean));
    let after = Layout::new(&vertices(&[vec![3.0], vec![-1.0]]), Shape::Points(Metric::Euclidean), Some(&before));
    assert_eq!(after.places(), line.places(), "coordinates are not turned");
}

#[test]
fn three_components_of_a_coil_keep_its_distances() {
    let cloud = coil(50);
    let layout = plain::<3>(&vertices(&cloud), Shape::Points(Metric::Euclidean));
    for (a, one) in cloud.iter().enumerate() {
        for (b, other) in cloud.iter().enumerate() {
            let wanted = length::<4>(one.as_slice().try_into().unwrap(), other.as_slice().try_into().unwrap());
            assert!((length(layout.places()[a], layout.places()[b]) - wanted).abs() < 1e-9);
        }
    }
    let Account::Principal(shares) = layout.account() else { panic!("{:?}", layout.account()) };
    assert!(shares.is_sorted_by(|a, b| a > b) && (shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{shares:?}");
}

#[test]
fn the_order_of_points_does_not_matter() {
    let cloud = coil(40);
    let reversed: Vec<Vec<f64>> = cloud.iter().rev().cloned().collect();
    for metric in [Metric::Euclidean, Metric::Angular] {
        let [there, back] = [&cloud, &reversed].map(|cloud| plain::<2>(&vertices(cloud), Shape::Points(metric)));
        assert!(there.places().iter().eq(back.places().iter().rev()), "{metric:?}");
        assert_eq!(there.account(), back.account());
    }
}

#[test]
fn directions_have_no_length() {
    let short = vertices(&[vec![1.0, 0.0, 0.0], vec![0.0, 2.0, 0.0], vec![0.0, 3.0, 3.0]]);
    let long = vertices(&[vec![9.0, 0.0, 0.0], vec![0.0, 1e150, 0.0], vec![0.0, 1e-200, 1e-200]]);
    let [short, long] = [short, long].map(|cloud| plain::<2>(&cloud, Shape::Points(Metric::Angular)));
    for (a, b) in short.places().iter().zip(long.places()) {
        assert!(length(*a, *b) < 1e-12, "{a:?} {b:?}");
    }
}

#[test]
fn positions_are_projected_as_vertices_are() {
    let cloud = coil(30);
    let positions = Positions::Coordinates { dimension: 4, flat: cloud.concat() };
    for metric in [Metric::Euclidean, Metric::Angular] {
        let first = plain::<2>(&vertices(&cloud), Shape::Points(metric));
        let turned = Layout::new(&vertices(&cloud[3..]), Shape::Points(metric), Some(&first));
        assert_eq!(first.of_positions(&positions), first.places());
        assert_eq!(turned.of_positions(&positions)[3..], *turned.places());
        assert_eq!(first.of_positions(&Positions::Labels(vec![7, 1])), [first.places()[7], first.places()[1]]);
    }
}

#[test]
fn a_layout_is_turned_onto_the_one_before() {
    let square = |signs: [f64; 2]| {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| vec![signs[0] * x, signs[1] * y]);
        Points::new(Metric::Euclidean, 2, &corners.concat()).unwrap()
    };
    let names = vertices(&vec![vec![]; 4]);
    let before = plain::<2>(&names, Shape::Distances(&Space::Points(square([1.0, 1.0]))));
    let mut mirrored = before.clone();
    mirrored.places.iter_mut().for_each(|[x, y]| (*x, *y) = (20.0 - *y, *x));
    let after = Layout::new(&names, Shape::Distances(&Space::Points(square([1.0, 1.0]))), Some(&mirrored));
    for (a, b) in after.places().iter().zip(mirrored.places()) {
        assert!(length(*a, *b) < 1e-9, "{a:?} {b:?}");
    }
    let strangers: Vertices = (90..94).map(|id| (VertexId(id), &[][..])).collect();
    let alone = Layout::new(&strangers, Shape::Distances(&Space::Points(square([1.0, 1.0]))), Some(&mirrored));
    assert_eq!(alone.places(), before.places(), "nothing is shared");
}

#[test]
fn a_ring_of_hops_is_round() {
    let hops = |a: usize, b: usize| (a.abs_diff(b)).min(60 - a.abs_diff(b)) as f64;
    let lower: Vec<f64> = (0..60).flat_map(|b| (0..b).map(move |a| hops(a, b))).collect();
    let edges: Vec<(u32, u32, f64)> = (0..60).map(|a| (a, (a + 1) % 60, 1.0)).collect();
    let matrix = Space::Matrix(Matrix::from_lower(60, &lower).unwrap());
    let graph = Space::Graph(Graph::new(60, &edges).unwrap());
    for space in [matrix, graph] {
        let layout = plain::<2>(&vertices(&vec![vec![]; 60]), Shape::Distances(&space));
        let middle = [0, 1].map(|axis| layout.places().iter().map(|place| place[axis]).sum::<f64>() / 60.0);
        let radii: Vec<f64> = layout.places().iter().map(|&place| length(place, middle)).collect();
        assert!(radii.iter().all(|radius| (radius - radii[0]).abs() < 1e-9 * radii[0]), "{radii:?}");
        assert!(matches!(layout.account(), Account::Scaling { parts: 1, share } if share > 0.6 && share < 1.0));
        assert!(layout.has_lengths() && layout.metric().is_none());
    }
}

#[test]
fn parts_stand_beside_each_other() {
    let edges = [(0, 1, 1.0), (1, 2, 1.0), (3, 4, 2.0), (4, 5, 2.0), (5, 3, 2.0), (3, 6, 1.0)];
    let space = Space::Graph(Graph::new(8, &edges).unwrap());
    let layout = plain::<2>(&vertices(&vec![vec![]; 8]), Shape::Distances(&space));
    let places = layout.places();
    assert!(matches!(layout.account(), Account::Scaling { parts: 3, .. }), "{:?}", layout.account());
    assert!((length(places[0], places[2]) - 2.0).abs() < 1e-9);
    let nearest = |part: &[usize], others: &[usize]| {
        let pairs = part.iter().flat_map(|&a| others.iter().map(move |&b| length(places[a], places[b])));
        pairs.fold(f64::INFINITY, f64::min)
    };
    assert!(nearest(&[0, 1, 2], &[3, 4, 5, 6, 7]) > 0.1 && nearest(&[7], &[3, 4, 5, 6]) > 0.1);
}

#[test]
fn nothing_has_a_layout() {
    for shape in [Shape::Points(Metric::Euclidean), Shape::Distances(&Space::Graph(Graph::new(0, &[]).unwrap()))] {
        let layout = plain::<2>(&Vertices::default(), shape);
        assert!(layout.places().is_empty() && layout.of_positions(&Positions::default()).is_empty());
    }
}
