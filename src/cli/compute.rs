//! `hopes compute`: a file of points or a picture in, its skeleton out, once.
//!
//! In: a file or stdin, and options.
//! Out: JSON, CSV, GeoJSON, SVG or PNG, to a file or stdout.
//! Invariants: points that cannot be used are reported, counted and left out, unless `--strict` stops at the first.
//! Must not know: how skeletons are computed or pictures drawn.

mod panels;
mod source;
mod space;

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use hopes::topology::spaces::Landmarks;
use hopes::topology::{Decluttered, Exact, Frame, Options, Simplified, View, simplify};
use indicatif::ProgressBar;

use super::args::{
    DeclutterArgs, DetectionArgs, MetricArgs, ProjectArgs, SimplifiedViewArgs, SpaceOptions, Threshold, by_suffix,
    chosen, resolution,
};
use super::{Failure, files, progress};
use crate::daemon::InputErrors;
use crate::formats::input::Format;
use crate::formats::runs::RunSource;
use crate::formats::skeleton::{Answer, Outliers, OutputFormat};
use panels::{Cut, PanelWord, panel};
use source::Source;

/// Compute the skeleton of a file of points or distances, or of the edges of a picture, once.
///
/// Reads a table (comma, semicolon, tab or blank separated, with or without a header line, # comments) or JSON lines:
/// [x,y], {"x":..,"y":..} or {"points":[[x,y],...]}; also JSON arrays, GeoJSON, NPY, PLY, PCD, and all of these
/// compressed by gzip. Of a picture (PNG, JPEG) the points are its edge pixels, as of
/// hopes edges. Writes the persistence diagram, the minimum spanning tree and the chosen view of the skeleton.
///
/// Points are of the plane, by their alpha filtration. With --metric they are of any space, or distances, by the
/// Vietoris-Rips filtration: an edge enters at half its length, a triangle with its longest edge. Births and deaths are
/// half of what Ripser prints. Lengths are doubles, summed in the order of the coordinates, and only compared, so in
/// these doubles the answer is exact. A sweep takes at most 65536 points.
#[derive(Debug, Args)]
#[command(
    after_help = EXAMPLES,
    after_long_help = format!("{EXAMPLES}\n\n{KEYS}"),
)]
pub struct Compute {
    /// File of points, or a picture; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// What the file holds.
    #[arg(long, value_enum, default_value_t)]
    input: Input,
    /// Columns of a table, by number from 1 or by name in the header [default: what the header calls x and y, or lon
    /// and lat; else 1,2; with --metric all].
    #[arg(long, value_name = "X,Y")]
    columns: Option<String>,
    #[command(flatten)]
    project: ProjectArgs,
    /// Snap positions to a grid of this step.
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// What to write [default: as the suffix of --output says, else json; with --panels svg].
    #[arg(short, long, value_enum)]
    format: Option<OutputFormat>,
    /// Where to write it; - for stdout [default: -].
    ///
    /// Its suffix chooses the format: .json, .svg, .png, .csv or .geojson. A file that is there is replaced at the end,
    /// by the whole answer, or not at all.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw these panels side by side, as .svg or .png: image, cloud, diagram, skeleton, simplified.
    ///
    /// Any of them, in the order given, also more than once. The image is that of a picture; skeletons stand on it.
    /// A diagram, skeleton or simplified one is that of -k and -l, or of its own ranks: skeleton:7:4 has k = 7, l = 4.
    #[arg(long, value_name = "PANEL,...", value_delimiter = ',', value_parser = panel)]
    panels: Vec<PanelWord>,
    /// Stop at the first line or point that cannot be used (exit code 3).
    ///
    /// Without it, such lines and points are reported with their line, counted and left out.
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    declutter: DeclutterArgs,
    #[command(flatten)]
    view: SimplifiedViewArgs,
    #[command(flatten)]
    metric: MetricArgs,
    #[command(flatten)]
    detection: DetectionArgs,
}

const EXAMPLES: &str = "Examples:
  hopes compute points.csv                                 all of it as JSON
  hopes compute points.csv -o points.svg                   a picture beside the persistence diagram
  hopes compute points.csv --format dots > dots.csv        the persistence diagram as a table
  hopes compute photo.jpg -o fig.svg --panels image,cloud,diagram,skeleton,simplified -k 7 -l 4
  hopes compute points.csv -o two.png --panels skeleton:1:1,skeleton:3:2
  hopes compute scan.tsv --columns lon,lat --project -k 2 --simplify --format geojson
  hopes compute points.csv --declutter -o clean.svg        without outliers, which are drawn hollow
  hopes compute points.csv --declutter=4:0.5 -f json       with 4 others within 0.5, or left out
  produce | hopes compute - --alpha 0.5                    the reduced skeleton at the scale 0.5
  hopes compute cloud.csv --metric euclidean               points of R^d: the Vietoris-Rips skeleton
  hopes compute distances.csv --metric matrix              of distances
  hopes compute signal.csv --embed 3:8 --format dots       what repeats in a series
  hopes compute vectors.npy --metric angular --landmarks 99   a sample that covers a cloud";

const KEYS: &str = "Keys of the JSON output:
  points      how many distinct positions, without outliers
  duplicates  points beyond the first on their position
  rejected    lines and points that could not be used
  filtered    with --declutter: how many distinct positions were left out as outliers
  declutter   with --declutter: k, radius, rho, expected (lone clutter points that stay),
              certified, outliers [x,y]; without clutter the radius is null
  origin      with --project: longitude and latitude of [0,0]
  vertices    [x,y] in order of first appearance; all indices refer to them
  dots        the persistence diagram, most persistent first:
              birth, death, edge [i,j], hole {center, radius}
  mst         edges [i,j] and length of the minimum spanning tree
  view        kind, k, l, ds, vs, edges, critical, components, cycles, length,
              margins {diagonal, vertical}; a reduced view has alpha in the place of
              k, l, ds, vs and margins
  simplified  with --simplify: threshold, vertices [x,y], edges [i,j]

With --metric: filtration (rips) and dimension; vertices have as many coordinates, or are the
numbers of the points of a matrix; a dot has death_edge [i,j] in the place of a hole. A dot that
never dies has the death null. With --landmarks: how many, and covering_radius, the distance within
which every point has a landmark. It stands in margins too: noise below a margin less it leaves the
gaps of the whole cloud the chosen ones.

Margins say how much noise on every point leaves the chosen gaps the chosen ones. A gap that is
not there counts as width 0. An infinite number is null: vs of a cloud without dots, the vertical
margin for l = 1.

A line of the CSV output: kind,i,j,x1,y1,x2,y2,length,birth,death,persistence
A line of dots: birth,death,persistence,i,j,x1,y1,x2,y2,center_x,center_y,radius,shown
Without two coordinates: kind,i,j,length,birth,death,persistence and birth,death,persistence,i,j,shown";

/// A skeleton, and what is told of it.
struct Computed {
    frame: Arc<Frame>,
    duplicates: u64,
    /// Positions that were left out as outliers.
    outliers: Vec<[f64; 2]>,
    /// What it is of, in the plane.
    source: Option<Source>,
    landmarks: Option<Landmarks>,
    /// What a picture places its vertices by, if they are not in the plane.
    shape: Option<space::SpaceShape>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Input {
    /// By the file's name, else its first bytes.
    #[default]
    Auto,
    /// A table: comma, semicolon, tab or blank separated.
    Text,
    /// JSON lines: [x,y], {"x":..,"y":..}, {"points":[[x,y],...]}.
    Jsonl,
    /// A picture: PNG or JPEG.
    Picture,
}

/// What the suffix of a file says.
const SUFFIXES: [(&str, OutputFormat); 5] = [
    ("json", OutputFormat::Json),
    ("svg", OutputFormat::Svg),
    ("png", OutputFormat::Png),
    ("csv", OutputFormat::Csv),
    ("geojson", OutputFormat::Geojson),
];

/// Below this many bytes of input, the work is too short for a progress bar.
const LONG_WORK: u64 = 8 << 20;

/// What is said where pictures cannot be made into pixels.
const NO_PNG: &str =
    "this hopes was built without PNG output: write .svg, or build it again with the feature png (on by default)";

impl Compute {
    pub fn run(self) -> Result<(), Failure> {
        let format = self.format()?;
        let cut = Cut { spec: self.view.spec(), threshold: self.view.threshold()? };
        if files::is_pipe(&self.file) {
            files::check_stdin()?;
        }
        // An output that cannot be written is refused before the work.
        let output = self.output.as_deref().filter(|&path| !files::is_pipe(path));
        let stdout = match output {
            Some(path) => {
                files::check_place(path)?;
                None
            }
            None if format == OutputFormat::Png => Some(files::binary_stdout("a PNG", "-o picture.png")?),
            None => Some(files::stdout()?),
        };
        let space = self.space(format)?;
        let progress = self.progress();
        let mut input_errors = InputErrors::new(self.strict).of(files::name(&self.file));
        let computed = match space {
            Some(options) => self.of_space(options, cut, &progress, &mut input_errors)?,
            None => self.of_plane(cut, &progress, &mut input_errors)?,
        };
        progress.set_message("writing");
        let rejected = input_errors.count();
        input_errors.sum_up();
        if computed.frame.points == 0 && rejected > 0 {
            let name = files::name(&self.file).unwrap_or_else(|| "stdin".to_owned());
            let what = "nothing in it could be used";
            return Err(anyhow!("{name}: {what}, of {rejected} lines or points: see hopes help compute").into());
        }
        let name = self.file.file_stem().and_then(|stem| stem.to_str()).filter(|_| !files::is_pipe(&self.file));
        let frame = &computed.frame;
        let outliers = frame.decluttered.map(|report| Outliers { report, positions: &computed.outliers });
        if let Some(report) = &frame.decluttered {
            tracing::info!("{}", summary(report, frame.skeleton.vertices().len()));
        }
        let shape = computed.shape.as_ref().filter(|_| format.is_picture());
        let layout = shape.map(|shape| shape.layout(frame.skeleton.vertices()));
        if self.panels.is_empty() {
            let view = frame.view(cut.spec);
            let simplified = cut.threshold.map(|threshold| simplified(frame, &view, threshold));
            let answer = Answer {
                name,
                skeleton: &frame.skeleton,
                view: &view,
                simplified: simplified.as_ref().map(|(threshold, simplified)| (*threshold, simplified)),
                duplicates: computed.duplicates,
                rejected,
                outliers,
                projection: if let Some(Source::Points(_, Some(projector))) = &computed.source {
                    projector.projection()
                } else {
                    None
                },
                landmarks: computed.landmarks.as_ref(),
                layout: layout.as_ref(),
            };
            write(stdout, output, |mut sink| format.write(&answer, &mut sink))?;
        } else {
            let photo = if let Some(Source::Picture(photo, _)) = &computed.source { Some(photo) } else { None };
            let drawing = panels::draw(frame, &computed.outliers, layout.as_ref(), &self.panels, cut, photo, name);
            write(stdout, output, |mut sink| format.write_drawing(&drawing, &mut sink))?;
        }
        progress.finish_and_clear();
        // The process ends here: giving back every page of a large skeleton first would only take time.
        std::mem::forget(computed);
        Ok(())
    }

    /// The skeleton of points in the plane, or of a picture.
    fn of_plane(&self, cut: Cut, progress: &ProgressBar, input_errors: &mut InputErrors) -> Result<Computed, Failure> {
        let mut source = self.source()?;
        panels::check(&self.panels, cut, matches!(source, Source::Picture(..)), &self.file.display().to_string())?;
        let options = Options { resolution: self.resolution, declutter: self.declutter.rule(), ..Options::default() };
        let (frame, outliers) = source::frame(&mut source, options, progress, input_errors)?;
        let duplicates = frame.points - (frame.skeleton.vertices().len() + outliers.len()) as u64;
        Ok(Computed { frame, duplicates, outliers, source: Some(source), landmarks: None, shape: None })
    }

    /// The skeleton of a metric space.
    fn of_space(
        &self,
        options: SpaceOptions,
        cut: Cut,
        progress: &ProgressBar,
        input_errors: &mut InputErrors,
    ) -> Result<Computed, Failure> {
        panels::check(&self.panels, cut, false, &self.file.display().to_string())?;
        let format = match self.input {
            Input::Text => Some(Format::Text),
            Input::Jsonl => Some(Format::JsonLines),
            _ => None,
        };
        let source = space::SpaceSource { file: &self.file, format, columns: self.columns.as_deref() };
        let space::SpaceFrame { frame, duplicates, landmarks, shape } =
            space::frame(&source, options, progress, input_errors)?;
        let outliers = Vec::new();
        Ok(Computed { frame: Arc::new(frame), duplicates, outliers, source: None, landmarks, shape: Some(shape) })
    }

    /// The space that is asked for; none for the plane. What makes sense in the plane only is refused with it.
    fn space(&self, format: OutputFormat) -> Result<Option<SpaceOptions>, Failure> {
        let options = self.metric.options()?;
        if options.is_none() {
            return Ok(None);
        }
        let refused = [
            (
                self.project.is_on(),
                "--project makes a plane of degrees: with --metric, haversine takes them as they are",
            ),
            (self.resolution.is_some(), "--resolution is for the plane: leave it out with --metric"),
            (
                self.declutter.rule().is_some(),
                "--declutter is for the plane, where a density can be told: leave it out with --metric",
            ),
            (matches!(self.input, Input::Picture), "--input picture is for the plane: leave out --metric"),
            (format == OutputFormat::Geojson, "GeoJSON is for maps: write a skeleton with --metric as json or csv"),
        ];
        match refused.into_iter().find(|&(is_so, _)| is_so) {
            Some((_, reason)) => Err(Failure::usage(reason)),
            None => Ok(options),
        }
    }

    /// What is written: as it is said, else as the file's name says.
    fn format(&self) -> Result<OutputFormat, Failure> {
        let has_panels = !self.panels.is_empty();
        let usual = if has_panels { OutputFormat::Svg } else { OutputFormat::default() };
        let format = match self.format {
            Some(format) => format,
            None => by_suffix(self.output.as_deref(), &SUFFIXES)?.unwrap_or(usual),
        };
        if has_panels && !format.is_picture() {
            return Err(Failure::usage(
                "--panels draws a picture: write it into a file .svg or .png, or say --format svg",
            ));
        }
        if format.is_built_in() { Ok(format) } else { Err(Failure::usage(NO_PNG)) }
    }

    fn source(&self) -> Result<Source, Failure> {
        let format = match self.input {
            Input::Auto if source::holds_picture(&self.file) => return self.picture(),
            Input::Picture => return self.picture(),
            Input::Auto => None,
            Input::Text => Some(Format::Text),
            Input::Jsonl => Some(Format::JsonLines),
        };
        let chosen = chosen(self.columns.as_deref())?;
        let (file, columns) = (self.file.clone(), self.project.columns(chosen.as_ref()));
        let projector = self.project.projector();
        // A grid of metres says nothing of degrees: the pipeline checks what is on it.
        let resolution = self.resolution.filter(|_| projector.is_none());
        let is_projected = projector.is_some();
        Ok(Source::Points(RunSource { file, format, columns, resolution, is_projected }, projector))
    }

    fn picture(&self) -> Result<Source, Failure> {
        if self.project.is_on() {
            return Err(Failure::usage("--project is for longitudes and latitudes: a picture has pixels"));
        }
        Ok(Source::Picture(source::picture(&self.file)?, self.detection.options()))
    }

    fn progress(&self) -> ProgressBar {
        let length = if files::is_pipe(&self.file) { 0 } else { progress::length(&self.file) };
        if length < LONG_WORK {
            return ProgressBar::hidden();
        }
        let template = "{spinner} {msg:24} {wide_bar} {bytes}/{total_bytes} {elapsed}";
        progress::bar(length, template).with_message("reading points")
    }
}

/// Writes to stdout, or into a file that takes its place when it is whole.
fn write(
    stdout: Option<File>,
    output: Option<&Path>,
    write: impl Fn(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    if let Some(stdout) = stdout {
        write(&mut files::buffered(stdout)).context(files::CANNOT_WRITE_TO_STDOUT)?;
    }
    if let Some(path) = output {
        let file = files::create(path)?;
        let written = write(&mut files::buffered(&file));
        written.and_then(|()| file.finish()).with_context(|| files::cannot_write(path))?;
    }
    Ok(())
}

/// What the filter of outliers has done, in words.
fn summary(report: &Decluttered, kept: usize) -> String {
    let &Decluttered { filtered, neighbours, radius, rho, expected, is_certified } = report;
    if filtered == 0 {
        return format!("--declutter: no outlier among {kept} points (K = {neighbours})");
    }
    let certified = if is_certified { ", certified" } else { "" };
    format!(
        "--declutter: {filtered} outliers left out, {kept} points stay: K = {neighbours}, R = {}, rho = {}, \
        {expected:.2} lone clutter points expected to stay{certified}",
        Exact(radius),
        Exact(rho)
    )
}

fn simplified(frame: &Frame, view: &View, threshold: Threshold) -> (f64, Simplified) {
    let threshold = match threshold {
        Threshold::AtScale => view.scale(),
        Threshold::Below(radius) => radius,
    };
    (threshold, simplify(&frame.skeleton, view, threshold))
}
