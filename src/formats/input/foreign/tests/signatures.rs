//! What first bytes and names say, and how many of them.

use std::collections::VecDeque;
use std::path::Path;

use super::super::refusal::Refusal;
use super::super::signature::{Kind, recognise};
use super::*;

fn kind_of(name: &str, bytes: &[u8]) -> Kind {
    recognise(Some(Path::new(name)), bytes, true, false).unwrap()
}

#[test]
fn first_bytes_say_what_a_file_is() {
    let refused = Kind::Refused;
    let mut tar = vec![0; 512];
    tar[..5].copy_from_slice(b"a.csv");
    tar[257..262].copy_from_slice(b"ustar");
    let zip = |name: &str| {
        let length = [name.len() as u8, 0];
        [&b"PK\x03\x04"[..], &[0; 22], &length, &[0; 2], name.as_bytes(), b"..."].concat()
    };
    let cases: Vec<(&[u8], Kind)> = vec![
        (b"\x1f\x8b\x08", Kind::Gzip),
        (b"\x89PNG\r\n\x1a\n", refused(Refusal::Photo)),
        (b"\xff\xd8\xff\xe0", refused(Refusal::Photo)),
        (b"GIF89a", refused(Refusal::Bitmap)),
        (b"BM\x36\x04\x01\0\0\0\0\0\x36", refused(Refusal::Bitmap)),
        (b"II*\0", refused(Refusal::Bitmap)),
        (b"RIFF\x10\0\0\0WEBPVP8", refused(Refusal::Bitmap)),
        (b"P5\n24 24\n255\n", refused(Refusal::Bitmap)),
        (b"RIFF\x10\0\0\0AVI LIST", refused(Refusal::Video)),
        (b"\0\0\0\x20ftypisom", refused(Refusal::Video)),
        (b"\x1a\x45\xdf\xa3", refused(Refusal::Video)),
        (b"YUV4MPEG2 W4 H4", refused(Refusal::Y4m)),
        (b"\x89HDF\r\n\x1a\n", refused(Refusal::Hdf5)),
        (b"MATLAB 5.0 MAT-file, Platform", refused(Refusal::Matlab)),
        (b"PAR1\x15\x04", refused(Refusal::Parquet)),
        (b"ARROW1\0\0", refused(Refusal::Arrow)),
        (b"\x80\x04\x95", refused(Refusal::Pickle)),
        (b"LASF\0\0", refused(Refusal::Las)),
        (b"%PDF-1.7\n", refused(Refusal::Pdf)),
        (b"SQLite format 3\0", refused(Refusal::Sqlite)),
        (b"\0\0\x27\x0a\0\0\0\0", refused(Refusal::Shapefile)),
        (b"\x28\xb5\x2f\xfd", refused(Refusal::Zstd)),
        (b"\xfd7zXZ\0", refused(Refusal::Xz)),
        (b"BZh91AY&SY", refused(Refusal::Bzip2)),
        (b"HOPES\r\n\x1a\x01", refused(Refusal::Recording)),
        (b"\xff\xfe1\0", Kind::Utf16 { is_big_endian: false }),
        (b"\xff\xfe1", Kind::Utf16 { is_big_endian: false }),
        (b"\xfe\xff\x001", Kind::Utf16 { is_big_endian: true }),
        (b"1\0,\x002\0", refused(Refusal::Utf16 { is_big_endian: false })),
        (b"\x001\0,\x002", refused(Refusal::Utf16 { is_big_endian: true })),
        (b"\xff\xfe\0\x001\0\0\0", refused(Refusal::Utf32)),
        (b"OFF\n3 1 0\n", refused(Refusal::Off)),
        (b"# a model\nOFF 3 1 0\n", refused(Refusal::Off)),
        (b"mtllib a.mtl\n", refused(Refusal::Obj)),
        (b"# Blender\nv 1.0 2.0 3.0\n", refused(Refusal::Obj)),
        (b"solid cube\n", refused(Refusal::StlText)),
        (b"POINT(1 2)\n", refused(Refusal::Wkt)),
        (b"SRID=4326;Polygon Z ((0 0 0,1 1 1))\n", refused(Refusal::Wkt)),
        (b"\"LINESTRING (1 2, 3 4)\",7\n", refused(Refusal::Wkt)),
        (b"<?xml version=\"1.0\"?>\n<!-- c --><gpx version=\"1.1\">", refused(Refusal::Gpx)),
        (b"<kml>", refused(Refusal::Kml)),
        (b"<svg xmlns=\"\">", refused(Refusal::Svg)),
        (b"<!DOCTYPE html>\n", refused(Refusal::Html)),
        (b"<?xml version=\"1.0\"?>\n<points/>\n", refused(Refusal::Xml)),
        (&tar, refused(Refusal::Tar)),
        (b"\x01\x02\x03\x04\x05\x06 what\n", refused(Refusal::Unknown)),
        (b"ply\nformat ascii 1.0\n", Kind::Readable(Readable::Ply)),
        (b"VERSION 0.7\nFIELDS x y\n", Kind::Readable(Readable::Pcd)),
        (b"# .PCD v0.7\n", Kind::Readable(Readable::Pcd)),
        (b"\x93NUMPY\x01\0", Kind::Readable(Readable::Npy)),
        (b"{\"name\":\"a \\\" b\",\"type\":\"FeatureCollection\",", Kind::Readable(Readable::GeoJson)),
        (b"{\"features\":[", Kind::Readable(Readable::GeoJson)),
        (b"[[1,2],[3,4]]\n", Kind::Readable(Readable::Elements)),
        (b"[null, [1,2]]\n", Kind::Readable(Readable::Elements)),
        (b"[\n{\"x\":1", Kind::Readable(Readable::Elements)),
        (b"{\n  \"points\": [", Kind::Readable(Readable::Elements)),
    ];
    for (bytes, kind) in cases {
        assert_eq!(kind_of("", bytes), kind, "{:?}", String::from_utf8_lossy(bytes));
    }
    for (name, inner, refusal) in [
        ("a.zip", "a.csv", Refusal::Zip),
        ("a", "x.npy", Refusal::Npz),
        ("a.npz", "other", Refusal::Npz),
        ("a", "[Content_Types].xml", Refusal::Excel),
        ("a.ods", "mimetype", Refusal::Excel),
    ] {
        assert_eq!(kind_of(name, &zip(inner)), refused(refusal), "{name} {inner}");
    }
    assert_eq!(kind_of("a.stl", &[&[b' '; 80][..], &[3, 0, 0, 0, 9]].concat()), refused(Refusal::StlBinary));
    assert_eq!(kind_of("a.pkl", b"(lp0\n"), refused(Refusal::Pickle));
}

#[test]
fn tables_and_lines_remain_what_they_are() {
    for text in [
        "P,x,y\n",
        "P1 12.5 33.1\n",
        "PARTS,a\n",
        "BMI,age\n1,2\n",
        "RIFF x\n",
        "v,x,y\n",
        "v 1\n",
        "solid,x,y\n",
        "OFF,ON\n",
        "POINT,1,2\n",
        "point 1 2\n",
        "x,y\n",
        "<- here\n",
        "\u{feff}1,2",
        "FEAT,x\n",
        "GIF,x\n",
        "B 1 2\n",
        "# a comment\n1 2\n",
        "HOPES,x\n",
        "MATLAB,x\n",
        "Höhe;x\n",
        "",
        "\n",
        "PK,x\n",
        "%x y\n",
        "1,2\0\n",
    ] {
        assert_eq!(kind_of("a.csv", text.as_bytes()), Kind::Text, "{text:?}");
    }
    for text in ["[1,2]\n", "{\"x\":1,\"y\":2}\n", "[1,2,null]", "{\"points\":[[1,2]]}\n", "# [[\n[1,2]\n", "[]", "{}"]
    {
        assert_eq!(kind_of("a.csv", text.as_bytes()), Kind::JsonLines, "{text:?}");
    }
    // What was chosen is read as that, unless it is binary or encoded.
    for text in ["OFF\n", "POINT(1 2)\n", "[[1,2]]\n", "\x01\x02\x03\x04\x05\n"] {
        assert_eq!(recognise(None, text.as_bytes(), false, true), Some(Kind::Text), "{text:?}");
    }
    assert_eq!(recognise(None, b"\x89PNG\r\n", false, true), Some(Kind::Refused(Refusal::Photo)));
}

/// A live source: it fails when it is asked for more than there is.
struct Live(VecDeque<&'static [u8]>);

impl Read for Live {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        let piece = self.0.pop_front().expect("one read too many");
        room[..piece.len()].copy_from_slice(piece);
        Ok(piece.len())
    }
}

#[test]
fn a_live_stream_is_not_waited_for_longer_than_its_first_line() {
    for first in [
        &b"1,2\n"[..],
        b"P\n",
        b"PK\n",
        b"RI\r",
        b"[1,2]\n",
        b"[1,2]",
        b"{\"x\":1,\"y\":2}\n",
        b"{\"x\":1}",
        b"[[1,2],",
        b"{\"type\":\"Feature\"",
        b"{\n\"x\":",
        b"ply\n",
        b"\x93NUMPY",
        b"OFF\n",
        b"<- x\n",
    ] {
        for size in 1..=first.len() {
            drop(opened(None, None, Live(first.chunks(size).collect())));
        }
    }
    for first in [&b"1,"[..], b"[[", b"OFF\n"] {
        drop(opened(None, Some(Format::Text), Live([first].into())));
    }
}

#[test]
fn every_point_of_a_live_source_is_ready_when_its_bytes_are_there() {
    let pieces: [&[u8]; 3] = [b"[[1,2],[3,4],", b"[5,6]", b",[7,8]"];
    let (format, source) = opened(None, None, Live(pieces.into())).unwrap();
    let mut reader = Reader::new(source, format, Columns::default(), Limits::default());
    let mut ready = Vec::new();
    for _ in 0..4 {
        assert!(matches!(reader.next_record(), Ok(Some(Record::Points { .. }))));
        ready.push((reader.line(), reader.unit(), reader.is_ready()));
    }
    assert_eq!(ready, [(1, "element", true), (2, "element", false), (3, "element", false), (4, "element", false)]);
}
