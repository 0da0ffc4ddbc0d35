//! Where the points of `hopes compute` come from: a file of points, or the edges of a picture.
//!
//! In: a file or stdin.
//! Out: the frame of its points, and the picture if it is one.
//! Invariants: one thread reads a file of points while another inserts them, with a bounded queue between them. Nothing
//! is taken out of stdin to find out what it holds.
//! Must not know: what becomes of the frame.

use std::fs::File;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

use anyhow::Context;
use hopes::edges::Detector;
use hopes::topology::{Exact, Frame, Options, Pipeline};
use indicatif::ProgressBar;

use super::Failure;
use crate::cli::{files, progress};
use crate::daemon::InputErrors;
use crate::formats::images::photo::{Photo, is_picture};
use crate::formats::projection::Projector;
use crate::formats::runs::{Found, RunSource};

/// Runs of points that may wait to be inserted.
const WAITING: usize = 4;

/// So many bytes tell a picture from points.
const FIRST: u64 = 8;

/// What a file holds.
pub enum Source {
    /// Points, and what makes metres of their degrees.
    Points(RunSource, Option<Projector>),
    /// A picture, with how its edges are found.
    Picture(Photo, hopes::edges::Options),
}

/// Whether a file is a picture. One that cannot be read is not: the reader of points says why it cannot.
pub fn holds_picture(file: &Path) -> bool {
    if files::is_pipe(file) {
        // A pipe may bring its first bytes one by one: then the reader of points says what it finds.
        return io::stdin().lock().fill_buf().is_ok_and(is_picture);
    }
    let mut first = Vec::new();
    let read = File::open(file).and_then(|file| file.take(FIRST).read_to_end(&mut first));
    read.is_ok() && is_picture(&first)
}

/// Reads a picture.
pub fn picture(file: &Path) -> Result<Photo, Failure> {
    Ok(Photo::read(files::open(file)?).with_context(|| file.display().to_string())?)
}

/// Takes all points, and computes their frame. Beside it are the positions that were left out as outliers.
pub fn frame(
    source: &mut Source,
    options: Options,
    progress: &ProgressBar,
    input_errors: &mut InputErrors,
) -> Result<(Arc<Frame>, Vec<[f64; 2]>), Failure> {
    let mut pipeline = Pipeline::new(options);
    match source {
        Source::Points(source, projector) => {
            read(source.clone(), projector.as_mut(), &mut pipeline, input_errors, progress)?;
        }
        Source::Picture(photo, options) => {
            let edges = photo.edges(&mut Detector::new(*options)?)?;
            for (index, refusal) in pipeline.feed_points(&edges, None) {
                let [x, y] = edges[index].map(Exact);
                input_errors.add(&format_args!("pixel ({x}, {y}): {refusal}"))?;
            }
        }
    }
    progress.set_message("computing the skeleton");
    progress.enable_steady_tick(progress::TICK);
    pipeline.commit(None);
    let frame = pipeline.poll_frame().context("the frame was taken before it was polled")?;
    let outliers = pipeline.poll_outliers(0).added;
    let outliers = (0..outliers.len() as u32).map(|outlier| outliers.xy(outlier)).collect();
    // Giving back every page of a large cloud would only take time: the process ends soon.
    std::mem::forget(pipeline);
    Ok((frame, outliers))
}

/// Reads all points into a pipeline. If they cannot be taken, the reading thread ends at its next
/// point, and is not waited for.
fn read(
    source: RunSource,
    mut projector: Option<&mut Projector>,
    pipeline: &mut Pipeline,
    input_errors: &mut InputErrors,
    progress: &ProgressBar,
) -> Result<(), Failure> {
    let (sender, receiver) = sync_channel(WAITING);
    let progress = progress.clone();
    let read = move || source.read(&mut |found| sender.send(found).is_ok(), &|bytes| progress.set_position(bytes));
    let reading = thread::Builder::new().name("reader".to_owned()).spawn(read);
    let reading = reading.context("cannot start the reader's thread")?;
    for found in receiver {
        match found {
            Found::Bad(reason) => input_errors.add(&reason)?,
            Found::More(points) => pipeline.reserve(points),
            Found::Run(mut run) => {
                if let Some(projector) = &mut projector {
                    run.project(projector).iter().try_for_each(|refused| input_errors.add(refused))?;
                }
                run.feed(pipeline).try_for_each(|refused| input_errors.add(&refused))?;
            }
        }
    }
    Ok(reading.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?)
}
