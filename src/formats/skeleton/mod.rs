//! What `compute` writes: one file a format.
//!
//! In: an [`Answer`].
//! Out: bytes.
//! Invariants: a number that is not finite is null in JSON and empty in CSV; vertices are numbered in order of
//! first appearance.
//! Must not know: where the bytes go.

mod csv;
mod dots;
mod geojson;
mod json;

use std::fmt;
use std::io::{self, Write};

use hopes::topology::spaces::Landmarks;
use hopes::topology::{Decluttered, Edge, Exact, Simplified, Skeleton, View};

use super::layout::Layout;
use super::picture;
use super::projection::Projection;

/// Everything that can be said of a cloud.
#[derive(Clone, Copy)]
pub struct Answer<'a> {
    /// What the cloud is called, if it has a name.
    pub name: Option<&'a str>,
    /// The whole skeleton.
    pub skeleton: &'a Skeleton,
    /// The view asked for.
    pub view: &'a View,
    /// The view simplified, and below which half-length its edges were collapsed.
    pub simplified: Option<(f64, &'a Simplified)>,
    /// Points beyond the first on their position.
    pub duplicates: u64,
    /// Lines and points that could not be used.
    pub rejected: u64,
    /// What was left out as outliers, if that was asked for.
    pub outliers: Option<Outliers<'a>>,
    /// How metres were made of degrees, if that was so.
    pub projection: Option<&'a Projection>,
    /// The sample that it is the skeleton of, if it is not of all points.
    pub landmarks: Option<&'a Landmarks>,
    /// Where a picture has the vertices, if they are not in the plane.
    pub layout: Option<&'a Layout<2>>,
}

/// What was left out of a skeleton as outliers.
#[derive(Clone, Copy)]
pub struct Outliers<'a> {
    /// How they were told apart.
    pub report: Decluttered,
    /// Where they are.
    pub positions: &'a [[f64; 2]],
}

impl Answer<'_> {
    /// Whether its points have two coordinates, in whatever metric.
    fn is_flat(&self) -> bool {
        self.skeleton.vertices().dimension() == 2
    }

    /// The ends of an edge between points of two coordinates.
    fn segment(&self, edge: Edge) -> [[f64; 2]; 2] {
        edge.map(|vertex| self.skeleton.vertices().xy(vertex))
    }
}

/// A number of a table; nothing if it is not finite.
#[derive(Clone, Copy)]
struct Cell(f64);

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_finite() { Exact(self.0).fmt(f) } else { Ok(()) }
    }
}

/// A form of output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputFormat {
    /// Everything, as one JSON object.
    #[default]
    Json,
    /// Picture of the skeleton beside the persistence diagram.
    Svg,
    /// The same picture, in pixels.
    Png,
    /// A table of the view's edges.
    Csv,
    /// A table of the persistence diagram.
    Dots,
    /// The view's edges as features for maps.
    Geojson,
}

impl OutputFormat {
    /// Whether this build can write it.
    pub fn is_built_in(self) -> bool {
        self != Self::Png || cfg!(feature = "png")
    }

    /// Writes an answer in this form.
    ///
    /// # Errors
    /// Those of the sink, and of a picture that cannot be made into pixels.
    pub fn write(self, answer: &Answer, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Json => json::write(answer, out)?,
            Self::Csv => csv::write(answer, out)?,
            Self::Geojson => geojson::write(answer, out)?,
            Self::Dots => dots::write(answer, out)?,
            Self::Svg | Self::Png => return self.write_drawing(&drawing(answer), out),
        }
        out.flush()
    }

    /// Whether it is a picture.
    pub fn is_picture(self) -> bool {
        matches!(self, Self::Svg | Self::Png)
    }

    /// Writes a picture that is drawn already, as SVG, in pixels where this form is PNG.
    ///
    /// # Errors
    /// As [`OutputFormat::write`].
    pub fn write_drawing(self, drawing: &str, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Png => out.write_all(&pixels(drawing)?)?,
            _ => out.write_all(drawing.as_bytes())?,
        }
        out.flush()
    }
}

fn drawing(answer: &Answer) -> String {
    let places = answer.simplified.map(|(_, simplified)| picture::places(&simplified.positions, answer.layout));
    let simplified = answer.simplified.zip(places.as_deref()).map(|((_, s), places)| (places, s.edges.as_slice()));
    let options = picture::Options { name: answer.name.map(str::to_owned), ..picture::Options::default() };
    picture::svg(
        picture::Subject {
            skeleton: answer.skeleton,
            layout: answer.layout,
            outliers: answer.outliers.map_or(&[], |outliers| outliers.positions),
        },
        answer.view,
        simplified,
        &options,
    )
}

/// A drawing as a PNG file, two pixels for each of its units.
#[cfg(feature = "png")]
fn pixels(drawing: &str) -> io::Result<Vec<u8>> {
    picture::png(drawing, 2.0).map_err(io::Error::other)
}

#[cfg(not(feature = "png"))]
fn pixels(_: &str) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hopes::topology::{Dot, Killer, VertexId, Vertices, ViewSpec, simplify};

    /// A quadrilateral whose ids are 3, 5, 6 and 8, with one dot that dies with an edge and one that never dies.
    fn quadrilateral(coordinates: [&[f64]; 4]) -> Skeleton {
        let vertices: Vertices = [3, 5, 6, 8].map(VertexId).into_iter().zip(coordinates).collect();
        let dots = vec![
            Dot { birth: 2.0, death: 3.0, edge: [0, 3], killer: Killer::Edge([1, 3]) },
            Dot { birth: 2.5, death: f64::INFINITY, edge: [0, 2], killer: Killer::None },
        ];
        Skeleton::with_lengths(vertices, vec![([0, 1], 0.5), ([1, 2], 1.0), ([2, 3], 1.5)], dots)
    }

    fn written(skeleton: &Skeleton, format: OutputFormat) -> String {
        let view = View::new(skeleton, ViewSpec::Full);
        let simplified = simplify(skeleton, &View::new(skeleton, ViewSpec::Reduced { alpha: 2.2 }), 0.6);
        let simplified = Some((0.6, &simplified));
        let answer = Answer {
            name: None,
            skeleton,
            view: &view,
            simplified,
            duplicates: 1,
            rejected: 2,
            outliers: None,
            projection: None,
            landmarks: None,
            layout: None,
        };
        let mut bytes = Vec::new();
        format.write(&answer, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    const DOTS: &str = "\"dots\":[{\"birth\":2.5,\"death\":null,\"edge\":[0,2],\"death_edge\":null},\
        {\"birth\":2.0,\"death\":3.0,\"edge\":[0,3],\"death_edge\":[1,3]}],\
        \"mst\":{\"edges\":[[0,1],[1,2],[2,3]],\"length\":6.0}";

    #[test]
    fn points_of_space_have_all_their_coordinates_in_json() {
        let space = quadrilateral([&[0.0, 0.5, 9.0], &[1.0, 0.0, 9.0], &[2.0, 0.0, 9.0], &[3.0, -1.0, 9.0]]);
        let json = written(&space, OutputFormat::Json);
        let head = "{\"points\":4,\"duplicates\":1,\"rejected\":2,\"filtration\":\"rips\",\"dimension\":3,\
            \"vertices\":[[0.0,0.5,9.0],[1.0,0.0,9.0],[2.0,0.0,9.0],[3.0,-1.0,9.0]],";
        assert!(json.starts_with(&format!("{head}{DOTS}")), "{json}");
        let tail = "\"simplified\":{\"threshold\":0.6,\"vertices\":[[0.5,0.25,9.0],[2.0,0.0,9.0],[3.0,-1.0,9.0]],\
            \"edges\":[[0,1],[0,2],[1,2]]}}\n";
        assert!(json.ends_with(tail), "{json}");
    }

    #[test]
    fn labels_are_their_ids_in_json() {
        let json = written(&quadrilateral([&[]; 4]), OutputFormat::Json);
        let head = "\"filtration\":\"rips\",\"dimension\":0,\"vertices\":[3,5,6,8],";
        assert!(json.contains(&format!("{head}{DOTS}")), "{json}");
        let tail = "\"vertices\":[3,6,8],\"edges\":[[0,1],[0,2],[1,2]]}}\n";
        assert!(json.ends_with(tail), "{json}");
    }

    #[test]
    fn tables_have_positions_of_two_dimensions_only() {
        let flat = quadrilateral([&[0.0, 0.0], &[1.0, 0.0], &[2.0, 0.0], &[3.0, -1.0]]);
        for other in [quadrilateral([&[]; 4]), quadrilateral([&[0.0], &[1.0], &[2.0], &[3.0]])] {
            let dots = written(&other, OutputFormat::Dots);
            assert_eq!(dots, "birth,death,persistence,i,j,shown\n2.5,,,0,2,1\n2,3,1,0,3,1\n");
            let edges = written(&other, OutputFormat::Csv);
            let rows = "tree,0,1,1,,,\ntree,1,2,2,,,\ntree,2,3,3,,,\ncritical,0,2,5,2.5,,\ncritical,0,3,4,2,3,1\n";
            assert_eq!(edges, format!("kind,i,j,length,birth,death,persistence\n{rows}"));
        }
        let dots = written(&flat, OutputFormat::Dots);
        let head = "birth,death,persistence,i,j,x1,y1,x2,y2,center_x,center_y,radius,shown\n";
        assert_eq!(dots, format!("{head}2.5,,,0,2,0,0,2,0,,,,1\n2,3,1,0,3,0,0,3,-1,,,,1\n"));
        assert!(written(&flat, OutputFormat::Csv).contains("\ncritical,0,3,0,0,3,-1,4,2,3,1\n"));
        let picture = written(&flat, OutputFormat::Svg);
        let numbers = picture.replace("class=\"infinity\"", "");
        assert!(!numbers.contains("NaN") && !numbers.contains("inf"), "{picture}");
        let features = written(&flat, OutputFormat::Geojson);
        assert!(features.contains("\"critical\"") && !features.contains("\"hole\""), "{features}");
    }
}
