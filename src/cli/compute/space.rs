//! The skeleton of a metric space, for `hopes compute`: a file of points or distances in, a frame out.
//!
//! In: a file or stdin, and what it holds.
//! Out: the frame, how many points there were, the sample if one was taken, what a picture places vertices by.
//! Invariants: vertices are called by the number of their first point, counted from 0. More points than can be swept
//! are refused as soon as they are seen, unless a sample of them is taken.
//! Must not know: what becomes of the frame.

use std::path::Path;

use hopes::topology::spaces::{Graph, Landmarks, MAX_VERTICES, Matrix, Metric, Points, Space, Workspace, landmarks};
use hopes::topology::{Frame, Skeleton, VertexId, Vertices, numbered};
use indicatif::ProgressBar;

use super::Failure;
use crate::cli::args::{SpaceKind, SpaceOptions, coordinates};
use crate::cli::{files, progress};
use crate::daemon::InputErrors;
use crate::formats::input::Format;
use crate::formats::input::space::{
    Notice, PointSettings, Space as SpaceRead, SpaceError, read_distances, read_points,
};
use crate::formats::layout::{Layout, Shape};

/// The most points of which a sample is taken.
const MOST_SAMPLED: usize = 1 << 24;

/// The skeleton of a file, and what is told of it.
pub struct SpaceFrame {
    /// The frame.
    pub frame: Frame,
    /// Points on the position of another.
    pub duplicates: u64,
    /// The sample that it is of.
    pub landmarks: Option<Landmarks>,
    /// What a picture needs to know of it.
    pub shape: SpaceShape,
}

/// What the vertices of a skeleton are placed by.
pub enum SpaceShape {
    /// Their coordinates, under a metric.
    Points(Metric),
    /// Their distances.
    Distances(Space),
}

impl SpaceShape {
    fn new(space: Space, names: &Vertices, vertices: &Vertices) -> Self {
        match space {
            Space::Points(points) => Self::Points(points.metric()),
            space if names.len() == vertices.len() => Self::Distances(space),
            space => {
                // Names of distances are in order, and those of twins are not among the vertices.
                let kept =
                    (0..names.len() as u32).filter(|&name| vertices.ids().binary_search(&names.id(name)).is_ok());
                Self::Distances(space.subset(&kept.collect::<Vec<u32>>()))
            }
        }
    }

    /// Where a picture has the vertices. A file is one frame: there is none before it.
    pub fn layout(&self, vertices: &Vertices) -> Layout<2> {
        let shape = match self {
            Self::Points(metric) => Shape::Points(*metric),
            Self::Distances(space) => Shape::Distances(space),
        };
        Layout::new(vertices, shape, None)
    }
}

/// Which file, and how it is read.
pub struct SpaceSource<'a> {
    /// The file; - is stdin.
    pub file: &'a Path,
    /// How its points are written, if that was said.
    pub format: Option<Format>,
    /// Which columns are coordinates, in words.
    pub columns: Option<&'a str>,
}

/// Reads a space and computes its skeleton.
pub fn frame(
    source: &SpaceSource,
    options: SpaceOptions,
    progress: &ProgressBar,
    input_errors: &mut InputErrors,
) -> Result<SpaceFrame, Failure> {
    let most = if options.landmarks.is_some() { MOST_SAMPLED } else { MAX_VERTICES };
    let read = read(source, options.kind, most, progress, input_errors)?;
    progress.set_message("computing the skeleton");
    progress.enable_steady_tick(progress::TICK);
    let Named { mut space, mut names, points } = with_names(options.kind, read)?;
    let distinct = names.len();
    let sample = options.landmarks.map(|most| landmarks(space.distances(), most));
    if let Some(sample) = &sample {
        space = space.subset(&sample.vertices);
        names = sample.vertices.iter().map(|&vertex| (names.id(vertex), names.coordinates(vertex))).collect();
    }
    if names.len() > MAX_VERTICES {
        return Err(Failure::usage(format!("--landmarks {}: at most {MAX_VERTICES} can be swept", names.len())));
    }
    let skeleton = Skeleton::of_space(space.distances(), &names, options.threshold, &mut Workspace::default());
    let twins = names.len() - skeleton.vertices().len();
    let shape = SpaceShape::new(space, &names, skeleton.vertices());
    Ok(SpaceFrame {
        frame: Frame { number: 1, time: None, points: points as u64, decluttered: None, skeleton },
        duplicates: (points - distinct + twins) as u64,
        landmarks: sample,
        shape,
    })
}

/// Reads a file. What cannot be used is counted.
fn read(
    source: &SpaceSource,
    kind: SpaceKind,
    most: usize,
    progress: &ProgressBar,
    input_errors: &mut InputErrors,
) -> Result<SpaceRead, Failure> {
    let path = (!files::is_pipe(source.file)).then_some(source.file);
    let mut stop = None;
    let mut notice = |notice| match notice {
        Notice::Taken(choice) => tracing::info!("{choice}"),
        Notice::Refused(reason) => {
            if stop.is_none() {
                stop = input_errors.add(&reason).err();
            }
        }
    };
    let bytes = progress.wrap_read(files::open(source.file)?);
    let read = match kind {
        SpaceKind::Points(metric, embedding) => {
            let coordinates = coordinates(metric, source.columns)?;
            let settings = PointSettings { format: source.format, coordinates, wants_times: false, embedding };
            read_points(path, bytes, &settings, most, &mut notice).map(|read| {
                if read.gaps > 0 {
                    tracing::warn!("the series is interrupted at {} places: no vector goes across them", read.gaps);
                }
                read.space
            })
        }
        SpaceKind::Distances(form) => {
            if source.columns.is_some() {
                return Err(Failure::usage("--columns is for points: a matrix of distances is read whole"));
            }
            read_distances(path, bytes, form, most, &mut notice)
        }
    };
    match stop {
        Some(stop) => Err(stop.into()),
        None => read.map_err(|error| of_file(source.file, error)),
    }
}

/// An error of a file, which says which.
fn of_file(file: &Path, error: SpaceError) -> Failure {
    let failure = Failure::from(error);
    match files::name(file) {
        Some(name) => failure.of(&name),
        None => failure,
    }
}

/// A space whose vertices have names, and how many points it was made of.
struct Named {
    space: Space,
    names: Vertices,
    points: usize,
}

fn with_names(kind: SpaceKind, read: SpaceRead) -> Result<Named, Failure> {
    let metric = if let SpaceKind::Points(metric, _) = kind { metric } else { Metric::Euclidean };
    Ok(match read {
        SpaceRead::Points { coordinates, .. } if coordinates.is_empty() => {
            Named { space: Space::Matrix(Matrix::from_lower(0, &[])?), names: Vertices::default(), points: 0 }
        }
        SpaceRead::Points { dimension, coordinates } => {
            let space = Points::new(metric, dimension, &coordinates)?;
            let name = |&row: &u32| (VertexId(row.into()), &coordinates[row as usize * dimension..][..dimension]);
            let names = space.rows().iter().map(name).collect();
            Named { points: coordinates.len() / dimension, space: Space::Points(space), names }
        }
        SpaceRead::Lower { count, distances } => Named {
            space: Space::Matrix(Matrix::from_lower(count, &distances)?),
            names: numbered(count),
            points: count,
        },
        SpaceRead::Sparse { count, edges } => {
            Named { space: Space::Graph(Graph::new(count, &edges)?), names: numbered(count), points: count }
        }
    })
}
