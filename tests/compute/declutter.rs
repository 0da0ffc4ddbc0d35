//! `hopes compute --declutter`: outliers are left out, counted and told apart.
//!
//! In: rings with and without clutter, on stdin.
//! Out: answers, pictures, messages.
//! Must not know: how outliers are told apart.

use serde_json::{Value, json};

use super::common::process::hopes;
use super::common::random::Random;
use super::csv;

/// Two rings of 120 points, one of them twice as large.
fn rings() -> Vec<[f64; 2]> {
    let ring = |center: f64, radius: f64| {
        (0..120).map(move |place| {
            let (sin, cos) = (f64::from(place) * std::f64::consts::TAU / 120.0).sin_cos();
            [center + radius * cos, radius * sin]
        })
    };
    ring(0.0, 1.0).chain(ring(4.0, 2.0)).collect()
}

/// The rings, one point of them twice, and five points far from them.
fn cluttered() -> String {
    let mut points = rings();
    points.push(points[7]);
    points.extend([[0.1, 0.2], [3.5, 0.4], [4.6, -0.7], [1.4, 1.9], [0.9, -1.8]]);
    csv(&points)
}

fn answer(arguments: &str, input: &str) -> Value {
    serde_json::from_slice(&hopes(&format!("compute - {arguments}")).reads(input).out()).unwrap()
}

#[test]
fn outliers_are_left_out_and_told() {
    let clean = answer("", &csv(&rings()));
    let spoilt = answer("", &cluttered());
    let filtered = answer("--declutter", &cluttered());
    assert_ne!(spoilt["dots"][0], clean["dots"][0], "a point in the middle of a ring halves its persistence");
    for key in ["dots", "mst", "view", "vertices", "points"] {
        assert_eq!(filtered[key], clean[key], "{key}");
    }
    assert_eq!(
        (&filtered["filtered"], &filtered["duplicates"], &filtered["rejected"]),
        (&json!(5), &json!(1), &json!(0))
    );
    let told = filtered["declutter"].as_object().unwrap();
    let keys: Vec<&str> = told.keys().map(String::as_str).collect();
    assert_eq!(keys, ["certified", "expected", "k", "outliers", "radius", "rho"]);
    assert_eq!((&told["k"], &told["certified"]), (&json!(3), &json!(false)));
    assert_eq!(told["outliers"], json!([[0.1, 0.2], [3.5, 0.4], [4.6, -0.7], [1.4, 1.9], [0.9, -1.8]]));
    let rho = told["rho"].as_f64().unwrap();
    assert!((0.1..0.3).contains(&rho), "{rho}");
    assert!(told["radius"].as_f64().unwrap() >= rho);
}

#[test]
fn without_clutter_nothing_is_left_out() {
    let clean = answer("", &csv(&rings()));
    let mut filtered = answer("--declutter", &csv(&rings()));
    assert_eq!(filtered["declutter"]["radius"], Value::Null);
    for key in ["filtered", "declutter"] {
        filtered.as_object_mut().unwrap().remove(key);
    }
    assert_eq!(filtered, clean);
    let few = answer("--declutter", "0,0\n1,0\n1,1\n0,1\n");
    assert_eq!((&few["filtered"], &few["points"]), (&json!(0), &json!(4)));
}

#[test]
fn a_given_radius_is_certified() {
    let filtered = answer("--declutter=2:0.25", &cluttered());
    assert_eq!((&filtered["filtered"], &filtered["declutter"]["radius"]), (&json!(5), &json!(0.25)));
    assert_eq!(filtered["declutter"]["certified"], json!(true));
    let all = answer("--declutter=2:0.001", &cluttered());
    assert_eq!((&all["filtered"], &all["points"]), (&json!(245), &json!(0)));
}

#[test]
fn the_order_of_points_does_not_matter() {
    let mut random = Random::new(5);
    let mut points = rings();
    points.extend((0..25).map(|_| [random.unit() * 8.0 - 1.5, random.unit() * 5.0 - 2.5]));
    let outliers = |points: &[[f64; 2]]| {
        let answer = answer("--declutter", &csv(points));
        let mut outliers: Vec<String> =
            answer["declutter"]["outliers"].as_array().unwrap().iter().map(Value::to_string).collect();
        outliers.sort();
        let Value::Object(mut declutter) = answer["declutter"].clone() else { panic!("it is an object") };
        declutter.remove("outliers");
        (outliers, declutter)
    };
    let first = outliers(&points);
    assert!(first.0.len() > 10, "{first:?}");
    points.reverse();
    assert_eq!(outliers(&points), first);
    points.rotate_left(100);
    assert_eq!(outliers(&points), first);
}

#[test]
fn a_summary_is_told_and_the_picture_has_hollow_points() {
    let run = hopes("compute - --declutter --format svg").reads(cluttered());
    let message = &run.err;
    assert!(message.contains("--declutter: 5 outliers left out, 240 points stay: K = 3, R = "), "{message}");
    let picture = String::from_utf8_lossy(&run.out);
    assert!(picture.contains("class=\"outliers\"") && picture.contains(">outlier</text>"), "{picture}");
    assert!(picture.contains("5 outliers left out"));
    let plain = hopes("compute - --format svg").reads(cluttered()).text();
    assert!(!plain.contains("outlier"));
    let panels = hopes("compute - --declutter --panels cloud,skeleton").reads(cluttered()).text();
    assert_eq!(panels.matches("class=\"outliers\"").count(), 2);
    let quiet = hopes("compute - --declutter").reads(csv(&rings()));
    assert!(quiet.err.contains("--declutter: no outlier among 240 points"), "{}", quiet.err);
}

#[test]
fn spaces_and_words_that_are_none_are_refused() {
    for (arguments, says) in [
        ("--declutter --metric euclidean", "--declutter is for the plane"),
        ("--declutter --distances full", "--declutter is for the plane"),
        ("--declutter=0", "0 neighbours cannot be asked for: K is from 1 to 64"),
        ("--declutter=x", "write K or K:R, such as 3 or 3:0.25"),
        ("--declutter=3:0", "R must be above 0 and finite"),
    ] {
        hopes(&format!("compute - {arguments}")).reads("0,0\n").fails(2, &[says]);
    }
}
