//! Tests of spaces: lengths by their definitions, rows against single lengths, refusals.

use super::*;

/// Lengths of a vertex to all, by both ways.
fn row(space: &dyn Distances, a: u32) -> Vec<f64> {
    let mut row = vec![f64::NAN; space.count()];
    space.lengths(a, 0, &mut row);
    for (b, &length) in row.iter().enumerate() {
        assert_eq!(length.to_bits(), space.length(a, b as u32).to_bits());
        assert_eq!(length.to_bits(), space.length(b as u32, a).to_bits());
    }
    for first in 0..space.count() {
        for end in first..=space.count() {
            let mut part = vec![f64::NAN; end - first];
            space.lengths(a, first as u32, &mut part);
            assert_eq!(part, row[first..end]);
        }
    }
    row
}

fn points(metric: Metric, dimension: usize, coordinates: &[f64]) -> Points {
    Points::new(metric, dimension, coordinates).unwrap()
}

#[test]
fn lengths_are_those_of_the_definitions() {
    let cloud = [0.0, 0.0, 0.0, 3.0, -4.0, 12.0];
    let distance = |metric| {
        let space = points(metric, 3, &cloud);
        2.0 * space.radius(row(&space, 0)[1])
    };
    assert_eq!(distance(Metric::Euclidean), 13.0);
    assert_eq!(distance(Metric::Manhattan), 19.0);
    assert_eq!(distance(Metric::Chebyshev), 12.0);
}

#[test]
fn angles_are_those_of_directions() {
    let space = points(Metric::Angular, 2, &[1.0, 0.0, 5.0, 0.0, 0.0, 1e-100, -3.0, 0.0, 1.0, 1.0]);
    let vertex = |point: usize| space.vertices()[point];
    let angle = |p, q| 2.0 * space.radius(space.length(vertex(p), vertex(q)));
    let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-15, "{value}, not {expected}");
    close(angle(0, 1), 0.0);
    close(angle(0, 2), std::f64::consts::FRAC_PI_2);
    close(angle(0, 3), std::f64::consts::PI);
    close(angle(2, 4), std::f64::consts::FRAC_PI_4);
}

#[test]
fn arcs_are_those_of_the_earth() {
    let cloud = [0.0, 90.0, 123.0, 90.0, -180.0, 0.0, 180.0, 0.0, 0.0, 0.0, 90.0, 0.0, 13.4, 52.5, 2.35, 48.85];
    let space = points(Metric::Haversine, 2, &cloud);
    let vertex = |point: usize| space.vertices()[point];
    let arc = |p, q| 2.0 * space.radius(space.length(vertex(p), vertex(q)));
    assert_eq!((arc(0, 1), arc(2, 3)), (0.0, 0.0), "one pole, one date line");
    let quarter = EARTH_RADIUS * std::f64::consts::FRAC_PI_2;
    for (p, q, expected) in [(0, 2, quarter), (4, 5, quarter), (3, 4, 2.0 * quarter), (6, 7, 877_463.0)] {
        assert!((arc(p, q) / expected - 1.0).abs() < 1e-3, "{} m, not {expected} m", arc(p, q));
    }
    assert!((arc(0, 2) / quarter - 1.0).abs() < 1e-15);
}

#[test]
fn vertices_are_distinct_and_in_lexicographic_order() {
    let cloud = [2.0, 1.0, -0.0, 5.0, 2.0, -1.0, 0.0, 5.0, 2.0, 1.0];
    let space = points(Metric::Euclidean, 2, &cloud);
    assert_eq!((space.rows(), space.vertices()), (&[1, 2, 0][..], &[2, 0, 1, 0, 2][..]));
    let part = space.subset(&[0, 2]);
    assert_eq!((part.count(), part.length(0, 1)), (2, space.length(0, 2)));
}

#[test]
fn any_number_of_points_in_any_dimension_is_measured_alike() {
    for dimension in [1, 2, 3, 7, 8, 9, 33] {
        for count in [1, 2, 7, 8, 9, 17] {
            let cloud: Vec<f64> = (0..count * dimension).map(|i| (i * i % 101) as f64 * 0.37).collect();
            for metric in [Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev] {
                let space = points(metric, dimension, &cloud);
                for a in 0..space.count() as u32 {
                    assert_eq!(row(&space, a)[a as usize], 0.0);
                }
            }
        }
    }
}

#[test]
fn matrices_and_graphs_are_read_by_rows() {
    let lower = [1.0, 2.0, 3.0, 4.0, f64::INFINITY, 6.0];
    let matrix = Matrix::from_lower(4, &lower).unwrap();
    assert_eq!(row(&matrix, 2), [2.0, 3.0, 0.0, 6.0]);
    let square: Vec<f64> = (0..4).flat_map(|a| row(&matrix, a)).collect();
    assert_eq!(Matrix::from_square(4, &square).unwrap(), matrix);
    assert_eq!(row(&matrix.subset(&[0, 3]), 0), [0.0, 4.0]);
    let edges = [(0, 1, 1.0), (2, 0, 2.0), (1, 2, 3.0), (3, 0, 4.0), (3, 2, 6.0), (0, 2, 2.0)];
    let graph = Graph::new(4, &edges).unwrap();
    for vertex in 0..4 {
        assert_eq!(row(&graph, vertex), row(&matrix, vertex));
    }
    assert_eq!(row(&graph.subset(&[1, 3]), 0), [0.0, f64::INFINITY]);
}

#[test]
fn a_large_matrix_is_transposed_rightly() {
    let count = 201;
    let lower: Vec<f64> = (0..count * (count - 1) / 2).map(|i| i as f64).collect();
    let matrix = Matrix::from_lower(count, &lower).unwrap();
    for a in 1..count {
        for b in 0..a {
            assert_eq!(matrix.length(a as u32, b as u32), lower[a * (a - 1) / 2 + b]);
        }
    }
}

#[test]
fn what_is_no_space_is_refused_with_its_place() {
    let refusal = |result: Result<(), SpaceError>| result.unwrap_err().to_string();
    let of = |metric, dimension, cloud: &[f64]| refusal(Points::new(metric, dimension, cloud).map(|_| ()));
    assert!(of(Metric::Euclidean, 0, &[]).starts_with("a point has 0 coordinates"));
    assert!(of(Metric::Euclidean, 4097, &[]).starts_with("a point has 4097 coordinates"));
    assert!(of(Metric::Euclidean, 2, &[1.0; 3]).starts_with("3 coordinates are not whole points"));
    assert!(of(Metric::Manhattan, 2, &[0.0, 1.0, 2.0, f64::NAN]).starts_with("coordinate 1 of point 1 is NaN"));
    assert!(of(Metric::Chebyshev, 1, &[1e151]).starts_with("coordinate 0 of point 0 is 1e151"));
    assert!(of(Metric::Angular, 2, &[1.0, 0.0, 0.0, -0.0]).starts_with("point 1 is zero"));
    assert!(of(Metric::Haversine, 2, &[1.0, 90.5]).starts_with("the latitude of point 0 is 90.5"));
    assert!(of(Metric::Haversine, 3, &[1.0, 2.0, 3.0]).starts_with("a point has 3 coordinates: haversine"));
    let square = |count, values: &[f64]| refusal(Matrix::from_square(count, values).map(|_| ()));
    assert!(square(2, &[0.0, 1.0, 1.5, 0.0]).starts_with("points 0 and 1 are at distance 1, but 1 and 0 at 1.5"));
    assert!(square(2, &[0.0, 1.0, 1.0, 2.0]).starts_with("the distance of point 1 from itself is 2"));
    assert!(square(2, &[0.0; 3]).starts_with("3 distances do not fit 2 points: 4"));
    let lower = |count, values: &[f64]| refusal(Matrix::from_lower(count, values).map(|_| ()));
    assert!(lower(3, &[1.0, -1.0, 2.0]).starts_with("the distance of points 2 and 0 is -1"));
    assert!(lower(3, &[1.0, f64::NAN, 2.0]).starts_with("the distance of points 2 and 0 is NaN"));
    assert!(lower(3, &[1.0; 4]).starts_with("4 distances do not fit 3 points: 3"));
    let graph = |edges: &[(u32, u32, f64)]| refusal(Graph::new(3, edges).map(|_| ()));
    assert!(graph(&[(0, 3, 1.0)]).starts_with("point 3 is named, but there are 3"));
    assert!(graph(&[(0, 1, 1.0), (1, 0, 2.0)]).starts_with("points 0 and 1 are at distance 1, but 1 and 0 at 2"));
    assert!(graph(&[(1, 1, 1.0)]).starts_with("the distance of point 1 from itself"));
    assert!(graph(&[(1, 2, -1.0)]).starts_with("the distance of points 1 and 2 is -1"));
}

#[test]
fn the_longest_length_of_a_scale_is_exact() {
    for metric in [Metric::Euclidean, Metric::Manhattan, Metric::Angular, Metric::Haversine] {
        let space = points(metric, 2, &[1.0, 2.0, 3.0, 4.0]);
        for radius in [0.0, 1e-300, 0.1, 0.5, 1.0, 1.7, 1e9] {
            let longest = space.longest(radius);
            assert!(space.radius(longest) <= radius, "{metric:?} {radius}");
            assert!(space.radius(longest.next_up()) > radius || longest == f64::MAX, "{metric:?} {radius} {longest}");
        }
        assert_eq!(space.longest(-1.0), f64::NEG_INFINITY);
    }
}

#[test]
fn landmarks_cover_the_space() {
    let line: Vec<f64> = (0..=10).map(f64::from).collect();
    let space = points(Metric::Euclidean, 1, &line);
    assert_eq!(landmarks(&space, 3), Landmarks { vertices: vec![0, 5, 10], covering_radius: 2.0 });
    assert_eq!(landmarks(&space, 100).covering_radius, 0.0);
    assert_eq!(landmarks(&space, 0).vertices, []);
    let apart = Graph::new(3, &[(0, 1, 1.0)]).unwrap();
    assert_eq!(landmarks(&apart, 1).covering_radius, f64::INFINITY);
    assert_eq!(landmarks(&apart, 2), Landmarks { vertices: vec![0, 2], covering_radius: 1.0 });
    let doubled = Matrix::from_lower(3, &[0.0, 1.0, 1.0]).unwrap();
    assert_eq!(landmarks(&doubled, 3).vertices, [0, 2]);
}

/// A cloud that suits all metrics.
fn places(count: usize) -> Vec<f64> {
    (0..count).flat_map(|i| [(i * i * 37 % 359) as f64 - 179.5, (i * 53 % 171) as f64 - 85.0]).collect()
}

const METRICS: [Metric; 5] =
    [Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev, Metric::Angular, Metric::Haversine];

#[test]
fn distances_of_points_are_those_of_vertices() {
    let cloud = places(13);
    for metric in METRICS {
        let space = points(metric, 2, &cloud);
        for (p, first) in cloud.chunks(2).zip(space.vertices()) {
            for (q, second) in cloud.chunks(2).zip(space.vertices()) {
                let expected = 2.0 * space.radius(space.length(*first, *second));
                let found = metric.distance(p, q).unwrap();
                assert!((found - expected).abs() <= 1e-12 * (1.0 + expected), "{metric:?}: {found}, not {expected}");
            }
        }
    }
    assert!(matches!(Metric::Angular.distance(&[1.0, 0.0], &[0.0, 0.0]), Err(SpaceError::NoDirection { .. })));
    assert!(matches!(Metric::Haversine.distance(&[0.0, 91.0], &[0.0, 0.0]), Err(SpaceError::Latitude { .. })));
}

#[test]
fn the_nearest_vertex_is_that_of_the_least_distance() {
    let cloud = places(21);
    for metric in METRICS {
        let space = points(metric, 2, &cloud);
        for point in [[0.5, 0.25], [-170.0, 80.0], [100.0, -3.0], [179.0, 1.0]] {
            let distance = |row: u32| metric.distance(&point, &cloud[2 * row as usize..][..2]).unwrap();
            let least = space.rows().iter().map(|&row| distance(row)).fold(f64::INFINITY, f64::min);
            let nearest = space.nearest(&point).unwrap().unwrap();
            assert_eq!(distance(space.rows()[nearest as usize]), least, "{metric:?} {point:?}");
        }
    }
    // The first of equally near ones.
    let square = points(Metric::Euclidean, 2, &[0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 2.0, 2.0]);
    assert_eq!(square.nearest(&[1.0, 1.0]).unwrap(), Some(0));
    assert_eq!(points(Metric::Euclidean, 2, &[]).nearest(&[1.0, 1.0]).unwrap(), None);
    assert!(points(Metric::Angular, 2, &[1.0, 0.0]).nearest(&[0.0, 0.0]).is_err());
}
