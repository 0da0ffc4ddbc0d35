//! Shared parts of the integration tests: the cases, clouds of every kind, skeletons from scratch.
#![allow(dead_code, missing_docs)]

pub mod by_position;
#[cfg(feature = "daemon")]
pub mod client;
pub mod clouds;
#[cfg(feature = "daemon")]
pub mod fake_daemon;
#[cfg(feature = "daemon")]
pub mod growing_stream;
#[cfg(feature = "daemon")]
pub mod mirror;
pub mod model;
pub mod naive;
#[cfg(feature = "daemon")]
pub mod peers;
#[cfg(feature = "daemon")]
pub mod process;
pub mod random;
pub mod random_script;
#[cfg(feature = "daemon")]
pub mod reply;
pub mod script;
#[cfg(feature = "daemon")]
pub mod window;

use std::collections::BTreeMap;
use std::path::Path;

use hopes::topology::{Options, Pipeline, Skeleton};
use serde::Deserialize;

/// A cloud with its exact answer.
pub struct Case {
    pub name: String,
    pub points: Vec<[f64; 2]>,
    pub answer: Answer,
}

#[derive(Deserialize)]
pub struct Answer {
    pub n_distinct: usize,
    pub mst_length: f64,
    pub mst_longest: f64,
    pub dots: Vec<[f64; 2]>,
    pub near_dots: Vec<[f64; 2]>,
    pub critical_edges: Vec<(u32, u32, f64, f64)>,
    pub skeletons: BTreeMap<String, DerivedAnswer>,
}

#[derive(Deserialize)]
pub struct DerivedAnswer {
    pub ds: Option<f64>,
    /// A number, or "inf".
    pub vs: serde_json::Value,
    #[serde(rename = "n_DS")]
    pub n_ds: usize,
    #[serde(rename = "n_VS")]
    pub n_vs: usize,
    pub mst_kept: usize,
    pub critical: usize,
    pub edges: usize,
    pub h1: usize,
    pub components: usize,
    pub length: f64,
}

/// All cases, by name.
pub fn cases() -> impl Iterator<Item = Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .filter_map(|entry| Some(entry.unwrap().file_name().to_str()?.strip_suffix(".csv")?.to_owned()))
        .collect();
    names.sort();
    names.into_iter().map(move |name| {
        let text = |extension: &str| std::fs::read_to_string(folder.join(format!("{name}.{extension}"))).unwrap();
        let points = points_of(&text("csv"));
        let answer = serde_json::from_str(&text("json")).unwrap();
        Case { points, answer, name }
    })
}

fn points_of(csv: &str) -> Vec<[f64; 2]> {
    csv.lines().map(|line| line.split_once(',').unwrap()).map(|(x, y)| [x, y].map(|v| v.parse().unwrap())).collect()
}

/// The skeleton of a cloud, from scratch.
pub fn skeleton_of(points: &[[f64; 2]]) -> Skeleton {
    let mut pipeline = Pipeline::new(Options::default());
    assert_eq!(pipeline.feed_points(points, None), []);
    pipeline.commit(None);
    pipeline.poll_frame().expect("a frame was committed").skeleton.clone()
}
