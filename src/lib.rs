//! `hopes` turns a live stream of 2D points into a live skeleton.
//!
//! It keeps a dynamic Delaunay triangulation of the points. Once per frame it computes their homologically persistent
//! skeleton (HoPeS): the minimum spanning tree and the critical edges that give birth to persistent cycles. It reports
//! what changed. There is no scale parameter: the widest gaps of the persistence diagram select the cycles.
//!
//! ```text
//!  points ──▶ cloud ──▶ Delaunay ──▶ alpha filtration ──▶ reduction ──▶ HoPeS ──▶ view (k, l) ──▶ diff
//! ```
//!
//! The library is the pure core, [`topology`], whose page says how a frame is computed and how a change travels. Beside
//! it are [`scene`], which makes streams of points whose true holes are known, and [`edges`], which finds edges in
//! images. The program `hopes` (feature `daemon`, on by default) adds files, sockets, threads and formats. To embed the
//! core alone: `hopes = { version = "0.1", default-features = false }`.
//!
//! # Library use
//!
//! A [`Pipeline`](topology::Pipeline) takes points (`feed_*`), closes frames (`commit`), and computes a frame when it
//! is polled: once, whatever the number of views. `poll_step` gives a [`Follower`](topology::Follower) what changed in
//! its view, at the cost of what changed. `poll_tracks` gives a [`Tracker`](topology::Tracker) the events of its
//! tracks, `track_regions` the regions of their holes. `poll_frame` gives the whole skeleton. Tiles, and clouds of more
//! than some hundred thousand points, are computed on the current [`rayon`](https://docs.rs/rayon) pool: call these
//! methods inside `install` of your own pool to choose the number of threads.
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
//!     let hole = frame.skeleton.hole(dot).expect("a hole of the plane has a centre");
//!     println!("a hole around {:?} lives from {} to {}", hole.center, dot.birth, dot.death);
//! }
//!
//! // The state of a consumer, and its change when a point is added.
//! let mut follower = Follower::new(ViewSpec::default());
//! let first = pipeline.poll_step(&mut follower).expect("the follower is at no frame yet");
//! let before = Snapshot::default().apply(&first.diff)?;
//! pipeline.feed_point(1.0, 3.5, None)?;
//! pipeline.commit(None);
//! let step = pipeline.poll_step(&mut follower).expect("there is a new frame");
//! assert_eq!(step.diff.vertices_added.len(), 1);
//! assert_eq!(before.apply(&step.diff)?.checksum(), step.checksum);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Skeleton`](topology::Skeleton) may also be of any finite metric space, by its Vietoris-Rips filtration:
//!
//! ```
//! use hopes::topology::spaces::{Matrix, Workspace};
//! use hopes::topology::{Skeleton, numbered};
//!
//! // Four points on a cycle of length 4, by their distances: d(1,0), d(2,0), d(2,1), d(3,0), d(3,1), d(3,2).
//! let space = Matrix::from_lower(4, &[1.0, 2.0, 1.0, 1.0, 2.0, 1.0])?;
//! let skeleton = Skeleton::of_space(&space, &numbered(4), None, &mut Workspace::default());
//! let [dot] = skeleton.dots() else { panic!("one cycle") };
//! assert_eq!((dot.birth, dot.death), (0.5, 1.0));
//! # Ok::<(), hopes::topology::spaces::SpaceError>(())
//! ```
//!
//! # The mathematics in one minute
//!
//! Grow a disc around every point. Components merge: the edges at which they do are the minimum spanning tree. Cycles
//! appear and are filled. A cycle is *born* with the edge that closes it, at half the length of that edge. It *dies*
//! when the last triangle inside it is filled, at the circumradius of that triangle. All scales are radii.
//!
//! The pairs (birth, death) are the *dots* of the persistence diagram. Dots near the diagonal are noise. The widest
//! empty strip parallel to the diagonal, the first diagonal *gap*, separates them from the rest: DS_k is what lies
//! above the lowest of the k widest diagonal gaps (Definition 10), VS_{k,l} what of it lies left of the leftmost of the
//! l widest vertical gaps (Definition 12).
//!
//! *HoPeS(C)* is the minimum spanning tree with one labelled critical edge for each dot (Definition 7). Its *reduced*
//! view at a scale alpha has the edges and the cycles that are there at that scale (Definition 8). It is the shortest
//! of all graphs with the topology of the cloud at that scale (Theorem 9). Its *derived* view HoPeS_{k,l} is cut at the
//! scale that the gaps select (Definition 14). It is stable under noise (Theorem 15; Propositions 11 and 13 give the
//! margins).
//!
//! V. Kurlin, "A one-dimensional homologically persistent skeleton of an unstructured point cloud in any metric space",
//! Computer Graphics Forum 34(5), 2015. Where the paper leaves a choice: of equally wide gaps the lower, or left, one
//! is the wider. A k or l beyond the number of gaps means the last gap. ds_k is the upper side of the k-th gap. Without
//! dots the skeleton is the tree, and vs is infinite.
//!
//! # Glossary
//!
//! | term | meaning |
//! | --- | --- |
//! | dot | A point (birth, death) of the 1-dimensional persistence diagram; one cycle. |
//! | birth | The scale at which a cycle appears: half the length of its critical edge. |
//! | death | The scale at which its hole is filled: the circumradius of the last triangle. |
//! | persistence | Death minus birth. |
//! | critical edge | The edge that gives birth to a cycle, labelled with birth and death. |
//! | gap | An empty strip of the diagram; k and l are ranks of diagonal and vertical gaps by width. |
//! | HoPeS | Homologically persistent skeleton: minimum spanning tree and critical edges. |
//! | view | A part of a skeleton: full, reduced at a scale alpha, or derived by k and l. |
//! | elder rule | When two components meet, the younger one ends. |
//! | basin | All triangles whose gradient flow ends in the same local maximum. |
//! | hole | What a cycle encloses at its birth: a union of basins. |
//! | tile | A part of the plane whose reduction is stored, so that a change costs what it touches. |
//! | stream | A named cloud of points that changes, with its own pipeline, producers and consumers. |
//! | commit | Closes a frame: the changes since the commit before take effect together. |
//! | frame | The numbered state of a stream as of a commit. |
//! | window | The points that a stream keeps: all, the last N, of the last N frames, or of the last T of event time. |
//! | outlier | A point of the window that is left out of the skeleton as clutter, if that is asked for. |
//! | snapshot | A view of a frame as a whole. |
//! | diff | What turns a view of one frame into that of a later one. |
//! | checksum | A sum of hashes, by which a consumer verifies that its mirror of a view is right. |
//! | view log | The last frames of a view that the daemon keeps, as diffs. |
//! | cursor | The position of a consumer in a view log. |
//! | lagged | Said of a consumer that was too slow: it gets several frames merged into one diff, or a snapshot. |
//! | resume | To go on after a lost connection from the frame that a consumer has. |
//! | epoch | One life of a stream or daemon; frame numbers and ids are valid in one epoch. |
//! | track | A persistent cycle followed over frames under one id, with events: born, split, merged, died. |

pub mod edges;
pub mod scene;
pub mod topology;
