//! The words for the forms of input and output, with their help.
//!
//! In: the forms that `formats` knows.
//! Out: possible values of options.
//! Must not know: how the forms are read and written.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::formats::images::finder::InputForm;
use crate::formats::input::space::DistanceForm;
use crate::formats::messages::MessageForm;
use crate::formats::point_writer::PointForm;
use crate::formats::skeleton::OutputFormat;
use crate::formats::tracks::chart::Axis;
use crate::formats::tracks::table::TableFormat;

macro_rules! words {
    ($form:ident { $($variant:ident $word:literal $help:literal)+ }) => {
        impl ValueEnum for $form {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$variant),+]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(match self {
                    $(Self::$variant => PossibleValue::new($word).help($help),)+
                })
            }
        }
    };
}

words!(OutputFormat {
    Json "json" "Everything, as one JSON object"
    Svg "svg" "Cloud and skeleton, critical edges coloured by persistence, beside the persistence diagram"
    Png "png" "The same picture, in pixels (needs the feature png, on by default)"
    Csv "csv" "A table of the view's edges, one a line"
    Dots "dots" "A table of the persistence diagram as CSV, one dot a line, with edge and hole"
    Geojson "geojson" "The view's edges and holes as features"
});

words!(MessageForm {
    Text "text" "A line a frame, for people"
    Events "events" "What happens to tracks and nothing else, for people"
    Jsonl "jsonl" "JSON lines, as of serve"
    Bin "bin" "A recording, for replay"
});

words!(PointForm {
    Text "text" "x,y a line, and a blank line at the end of a frame"
    Jsonl "jsonl" "JSON lines: {\"points\":[[x,y],...]}, and {\"commit\":true,\"time\":t} at the end of a frame"
    Bin "bin" "Messages of the protocol: Batch and Commit"
});

words!(InputForm {
    Images "images" "A picture a file: PNG or JPEG"
    Y4m "y4m" "Video: YUV4MPEG2"
    Gray "gray" "Video: bare frames of gray pixels, of the size of --size"
});

words!(DistanceForm {
    Full "full" "All rows and columns"
    Lower "lower" "Below the diagonal: rows of 1, 2, 3, ... numbers, or one list (Ripser's lower-distance)"
    Upper "upper" "Above the diagonal: rows of which each is one number shorter, or one list (Ripser's upper-distance)"
    Condensed "condensed" "Above the diagonal, row by row in one list, as scipy's pdist returns it"
    Sparse "sparse" "Rows i j distance, points counted from 0; pairs that are not there are never joined"
    Binary "binary" "Below the diagonal in one list of little-endian floats of 4 bytes (Ripser's binary; suffix .bin)"
});

words!(TableFormat {
    Table "table" "For people: streams and times have columns only where there are any"
    Csv "csv" "All columns, with a header line"
    Json "json" "One object on one line"
});

words!(Axis {
    Frame "frame" "Frames, by number"
    Time "time" "Their times"
});
