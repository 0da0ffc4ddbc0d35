//! `hopes` turns a live stream of 2D points into a live skeleton.
//!
//! It keeps a dynamic Delaunay triangulation of the points, computes their homologically persistent skeleton (HoPeS:
//! the minimum spanning tree and the critical edges that give birth to persistent cycles) once per frame, and tells
//! what changed. There is no scale parameter: the widest gaps of the persistence diagram choose the cycles.
//!
//! ```text
//!  points ──▶ cloud ──▶ Delaunay ──▶ alpha filtration ──▶ reduction ──▶ HoPeS ──▶ view (k, l) ──▶ diff
//! ```
//!
//! The library is the pure core, [`topology`], and beside it [`scene`], which makes streams of points whose true holes
//! are known, and [`edges`], which finds edges in images; the program `hopes` (feature `daemon`, on by default) puts
//! files, threads and formats around it. To embed the core alone:
//! `hopes = { version = "0.1", default-features = false }`.
//!
//! ```
//! use hopes::topology::{Follower, Options, Pipeline, Snapshot, ViewSpec};
//!
//! // Two squares that share a side: two holes, the larger one more persistent.
//! let points = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [5.0, 0.0], [5.0, 2.0]];
//! let mut pipeline = Pipeline::new(Options::default());
//! assert!(pipeline.feed_points(&points, None).is_empty(), "no point was refused");
//! pipeline.commit(None);
//!
//! let frame = pipeline.poll_frame().expect("a frame was committed");
//! let view = frame.view(ViewSpec::default()); // HoPeS_{1,1}: by the widest diagonal and vertical gap
//! assert_eq!((view.components, view.cycles), (1, 1));
//! for dot in frame.skeleton.dots() {
//!     let hole = frame.skeleton.hole(dot);
//!     println!("a hole around {:?} lives from {} to {}", hole.center, dot.birth, dot.death);
//! }
//!
//! // A consumer's state, and what changes in it when a point comes.
//! let mut follower = Follower::new(ViewSpec::default());
//! let first = pipeline.poll_step(&mut follower).expect("it knows nothing yet");
//! let before = Snapshot::default().apply(&first.diff)?;
//! pipeline.feed_point(1.0, 3.5, None)?;
//! pipeline.commit(None);
//! let step = pipeline.poll_step(&mut follower).expect("there is a new frame");
//! assert_eq!(step.diff.vertices_added.len(), 1);
//! assert_eq!(before.apply(&step.diff)?.checksum(), step.checksum);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod edges;
pub mod scene;
pub mod topology;
