//! Files that hold no points, or hold them in a way that another program reads better.
//!
//! In: what a file is.
//! Out: its name in words, and the command that makes points of it.
//! Must not know: how a file is recognised.
//!
//! In a command, FILE stands for the file.

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    Arrow,
    Bitmap,
    Bzip2,
    Excel,
    Gpx,
    Hdf5,
    Html,
    Kml,
    Las,
    Lz4,
    Matlab,
    Npz,
    Obj,
    Off,
    Parquet,
    Pdf,
    Photo,
    Pickle,
    Rar,
    Recording,
    SevenZip,
    Shapefile,
    Sqlite,
    StlBinary,
    StlText,
    Svg,
    Tar,
    Unknown,
    Utf16 { is_big_endian: bool },
    Utf32,
    Video,
    Wkt,
    Xml,
    Xz,
    Y4m,
    Zip,
    Zstd,
}

impl Refusal {
    /// What the file is, with an article.
    pub(super) fn what(self) -> &'static str {
        match self {
            Self::Arrow => "an Arrow or Feather file",
            Self::Bitmap => "a picture, not points",
            Self::Bzip2 => "compressed by bzip2",
            Self::Excel => "a spreadsheet",
            Self::Gpx => "a GPX file",
            Self::Hdf5 => "an HDF5 file",
            Self::Html => "a page of HTML",
            Self::Kml => "a KML file",
            Self::Las => "a LAS or LAZ file",
            Self::Lz4 => "compressed by lz4",
            Self::Matlab => "a MATLAB file",
            Self::Npz => "an NPZ archive of arrays",
            Self::Obj => "an OBJ file",
            Self::Off => "an OFF file",
            Self::Parquet => "a Parquet file",
            Self::Pdf => "a PDF document, not points",
            Self::Photo => "a PNG or JPEG picture, not points",
            Self::Pickle => "a Python pickle",
            Self::Rar => "a RAR archive",
            Self::Recording => "in the binary form of hopes",
            Self::SevenZip => "a 7z archive",
            Self::Shapefile => "a shapefile",
            Self::Sqlite => "an SQLite database",
            Self::StlBinary => "a binary STL file",
            Self::StlText => "an STL file",
            Self::Svg => "an SVG drawing, not points",
            Self::Tar => "a tar archive",
            Self::Unknown => "binary data of an unknown kind",
            Self::Utf16 { .. } => "UTF-16 text without a byte-order mark",
            Self::Utf32 => "UTF-32 text",
            Self::Video => "a video, not points",
            Self::Wkt => "well-known text (WKT)",
            Self::Xml => "an XML file",
            Self::Xz => "compressed by xz",
            Self::Y4m => "a YUV4MPEG2 video, not points",
            Self::Zip => "a zip archive",
            Self::Zstd => "compressed by zstd",
        }
    }

    /// What to do.
    pub(super) fn remedy(self) -> &'static str {
        match self {
            Self::Arrow => {
                "convert it: python3 -c \"import pandas; pandas.read_feather('FILE').to_csv('points.csv', index=False)\""
            }
            Self::Bitmap => {
                "its edges are points: ffmpeg -loglevel error -i FILE -f yuv4mpegpipe -pix_fmt gray - | hopes edges - | \
                 hopes compute -"
            }
            Self::Bzip2 => "decompress it: bzip2 -dc FILE | hopes compute -",
            Self::Excel => {
                "convert it: python3 -c \"import pandas; pandas.read_excel('FILE').to_csv('points.csv', index=False)\""
            }
            Self::Gpx => "convert it: ogr2ogr -f GeoJSON points.geojson FILE track_points",
            Self::Hdf5 => {
                "convert one of its datasets: python3 -c \"import h5py, numpy; numpy.save('points.npy', \
                 h5py.File('FILE')['NAME'])\""
            }
            Self::Html => {
                "convert its first table: python3 -c \"import pandas; pandas.read_html('FILE')[0].to_csv('points.csv', \
                 index=False)\""
            }
            Self::Kml => "convert it: ogr2ogr -f GeoJSON points.geojson FILE",
            Self::Las => {
                "convert it: python3 -c \"import laspy, numpy; a = laspy.read('FILE'); numpy.save('points.npy', \
                 numpy.column_stack((a.x, a.y)))\""
            }
            Self::Lz4 => "decompress it: lz4 -dc FILE | hopes compute -",
            Self::Matlab => {
                "convert one of its arrays: python3 -c \"import scipy.io, numpy; numpy.save('points.npy', \
                 scipy.io.loadmat('FILE')['NAME'])\""
            }
            Self::Npz => "take one array out of it: unzip -p FILE NAME.npy | hopes compute -",
            Self::Obj => {
                "take its vertices: awk '$1 == \"v\" {print $2, $3}' FILE | hopes compute - (if it is a table: --input text)"
            }
            Self::Off => {
                "take its vertices: awk '{sub(/#.*/, \"\")} /OFF/ {sub(/.*OFF/, \"\")} NF && !c {if (NF > 2) c = $(NF - 2); \
                 next} NF && k++ < c {print $1, $2}' FILE | hopes compute -"
            }
            Self::Parquet => {
                "convert it: python3 -c \"import pandas; pandas.read_parquet('FILE').to_csv('points.csv', index=False)\""
            }
            Self::Pdf => {
                "the edges of a page are points: pdftoppm -png -f 1 -l 1 -singlefile FILE page && hopes edges page.png | \
                 hopes compute -"
            }
            Self::Photo => "its edges are points: hopes edges FILE | hopes compute -",
            Self::Pickle => {
                "if you trust it, convert it: python3 -c \"import pickle, numpy; numpy.save('points.npy', \
                 numpy.asarray(pickle.load(open('FILE', 'rb'))))\""
            }
            Self::Rar => "take one file out of it: unrar p -inul FILE NAME | hopes compute -",
            Self::Recording => "play a recording: hopes replay FILE; read points in it: hopes serve --input bin < FILE",
            Self::SevenZip => "take one file out of it: 7z x -so FILE NAME | hopes compute -",
            Self::Shapefile => "convert it: ogr2ogr -f GeoJSON points.geojson FILE",
            Self::Sqlite => "select points: sqlite3 -csv -header FILE 'SELECT x, y FROM NAME' | hopes compute -",
            Self::StlBinary => {
                "take its vertices: python3 -c \"import numpy; numpy.save('points.npy', numpy.fromfile('FILE', \
                 [('n', '<f4', 3), ('v', '<f4', (3, 3)), ('a', '<u2')], offset=84)['v'].reshape(-1, 3))\""
            }
            Self::StlText => "take its vertices: awk '$1 == \"vertex\" {print $2, $3}' FILE | hopes compute -",
            Self::Svg => {
                "its edges are points: rsvg-convert FILE -o page.png && hopes edges page.png | hopes compute -"
            }
            Self::Tar => "take one file out of it: tar -xOf FILE NAME | hopes compute -",
            Self::Unknown => {
                "convert it to text, a point x,y on a line; what is text after all is read with --input text"
            }
            Self::Utf16 { is_big_endian: false } => "convert it: iconv -f UTF-16LE -t UTF-8 FILE | hopes compute -",
            Self::Utf16 { is_big_endian: true } => "convert it: iconv -f UTF-16BE -t UTF-8 FILE | hopes compute -",
            Self::Utf32 => "convert it: iconv -f UTF-32 -t UTF-8 FILE | hopes compute -",
            Self::Video => {
                "its edges are points: ffmpeg -loglevel error -i FILE -f yuv4mpegpipe -pix_fmt gray - | hopes edges - | \
                 hopes serve --window frames:1"
            }
            Self::Wkt => {
                "take its numbers: grep -oE '[-+.0-9eE]+ [-+.0-9eE]+' FILE | hopes compute - (if it is a table: --input text)"
            }
            Self::Xml => {
                "convert it: python3 -c \"import pandas; pandas.read_xml('FILE').to_csv('points.csv', index=False)\""
            }
            Self::Xz => "decompress it: xz -dc FILE | hopes compute -",
            Self::Y4m => "its edges are points: hopes edges - < FILE | hopes serve --window frames:1",
            Self::Zip => "take one file out of it: unzip -p FILE NAME | hopes compute -",
            Self::Zstd => "decompress it: zstd -dc FILE | hopes compute -",
        }
    }
}
