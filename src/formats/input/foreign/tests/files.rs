//! One format after the other: what is read, and what is said of the rest.

use super::*;

const TABLE: &str = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }";

#[test]
fn rows_of_an_array_are_points() {
    let data = doubles(&[1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0]);
    assert_eq!(read_cut(&npy(TABLE, &data)), ["(1,2)", "(NaN,4)", "(5,6)"]);
    let fortran = TABLE.replace("False", "True");
    assert_eq!(read_cut(&npy(&fortran, &doubles(&[1.0, 3.0, 5.0, 2.0, 4.0, 6.0]))), ["(1,2)", "(3,4)", "(5,6)"]);
    let old = "{\"fortran_order\": False, \"shape\": (1L, 3L), \"descr\": \">i2\"}";
    assert_eq!(read_cut(&npy(old, &[0, 1, 0xff, 0xff, 0, 9])), ["(1,-1)"]);
    let wide = [&b"\x93NUMPY\x02\x00"[..], &60_u32.to_le_bytes(), format!("{TABLE:60}").as_bytes(), &data].concat();
    assert_eq!(read_cut(&wide).len(), 3);
}

#[test]
fn columns_of_an_array_can_be_chosen() {
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3)}";
    let rows = npy(header, &doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    assert_eq!(read_from(&rows[..], None, "3,1,2"), ["(3,1)@2", "(6,4)@5"]);
    let columns = npy(&header.replace("False", "True"), &doubles(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
    assert_eq!(read_from(&columns[..], None, "3,1,2"), ["(3,1)@2", "(6,4)@5"]);
    let none = "this is an NPY array: its shape is (2, 3), and there is no column 4: choose others";
    assert_eq!(read_from(&rows[..], None, "1,4"), [none]);
}

#[test]
fn records_of_an_array_are_read_by_their_names() {
    let header = "{'descr': [('t', '<f4'), ('pad', '|V3'), (('title', 'y'), '<i2'), ('X', '|u1'), ('s', '<U1', (2,))], \
                  'fortran_order': False, 'shape': (2,)}";
    let record = |t: f32, y: i16, x: u8| [&t.to_le_bytes()[..], &[9; 3], &y.to_le_bytes(), &[x], &[0; 8]].concat();
    let bytes = npy(header, &[record(0.5, -2, 7), record(1.5, 3, 8)].concat());
    assert_eq!(read_cut(&bytes), ["(7,-2)@0.5", "(8,3)@1.5"]);
    assert_eq!(read_from(&bytes[..], None, "t,y"), ["(0.5,-2)", "(1.5,3)"]);
    let other = "{'descr': [('a', '<f4'), ('b', '<f4')], 'fortran_order': False, 'shape': (2,)}";
    let without = "this is an NPY array: its fields are a, b, without x and y: choose with --columns";
    assert_eq!(read(npy(other, &[0; 16])), [without]);
}

#[test]
fn an_array_that_is_no_list_of_points_is_refused() {
    let said = |descr: &str, shape: &str| {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}");
        let said = read(npy(&header, &[0; 64]));
        assert_eq!(said.len(), 1, "{said:?}");
        said[0].clone()
    };
    for (descr, shape, words) in [
        ("'<f8'", "(24,)", "its shape is (24), and points are rows: save a.reshape(-1, 2)"),
        ("'<f8'", "(24, 1)", "numpy.column_stack((x, y))"),
        ("'<f8'", "(2, 24)", "save a.T"),
        ("'<f8'", "(4, 3, 2)", "save a.reshape(-1, 2)"),
        ("'|O'", "(24, 2)", "save a.astype(float)"),
        ("'<f2'", "(24, 2)", "save a.astype(float)"),
        ("'<c16'", "(24, 2)", "save a.astype(float)"),
        ("'<f8'", "(9, 999999999999999999)", "save only x and y"),
        ("'é'", "(24, 2)", "save a.astype(float)"),
        ("3", "(24, 2)", "its type is unknown"),
    ] {
        let said = said(descr, shape);
        assert!(said.contains(words), "{descr} {shape}: {said}");
    }
    let large = "{'descr': '<f8', 'fortran_order': True, 'shape': (999999999999, 2)}";
    assert!(read(npy(large, &[0; 64]))[0].contains("numpy.ascontiguousarray"));
    assert!(read(npy("{'descr': '<f8'", b""))[0].contains("header cannot be read"));
}

#[test]
fn what_is_missing_of_an_array_and_what_is_too_much_is_told() {
    let data = doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let short = npy(TABLE, &data[..33]);
    assert_eq!(read_cut(&short), ["(1,2)", "(3,4)", "the file is cut short: 1 of 3 points are missing, after point 2"]);
    let long = npy(TABLE, &[&data[..], b"more"].concat());
    let from = long.len() - 4;
    assert_eq!(read_cut(&long)[3], format!("4 bytes after the array, from byte {from} on, were not read"));
    let lying = TABLE.replace("(3,", "(1000000000000000000,");
    let said = read_cut(&npy(&lying, &data));
    assert_eq!(
        said[3],
        "the file is cut short: 999999999999999997 of 1000000000000000000 points are missing, after point 3"
    );
    let fortran = TABLE.replace("False", "True");
    let said = read_cut(&npy(&fortran, &data[..30]));
    assert_eq!(said, ["the file is cut short: 3 of 3 points are missing, after point 0"]);
    assert!(read_cut(&npy(TABLE, &data)[..20])[0].contains("at byte 20: the file ends there"));
}

const PLY: &str = "ply\nformat ascii 1.0\ncomment c\nelement thing 1\nproperty list uchar int l\nelement vertex 3\n\
                   property double y\nproperty list uchar float n\nproperty float x\nelement face 1\n\
                   property list uchar int i\nend_header\n";

#[test]
fn vertices_of_text_are_points() {
    let data = "2 7 7\n1 0 2\n\n3 1 9 nan\n.5 2 9 9 6.\n3 0 1 2\n";
    let text = format!("{PLY}{data}");
    assert_eq!(read_cut(text.as_bytes()), ["(2,1)", "(NaN,3)", "(6,0.5)"]);
    for end in ["\r\n", "\r"] {
        assert_eq!(read_cut(text.replace('\n', end).as_bytes()).len(), 3, "{end:?}");
    }
    let bad = format!("{PLY}0\n1 0 x\n2 1\n3 0 4 5\n");
    assert_eq!(
        read_cut(bad.as_bytes()),
        [
            "point 1: line 14: property \"x\": \"x\" is not a number: write one such as 1.5",
            "point 2: line 15: property \"n\" has 0 of 1 values: complete the line",
            "point 3: line 16: 1 more values than the header says: complete the header, or mend the line",
            &format!("the file is cut short, at byte {}: 1 elements \"face\" are missing", bad.len()),
        ]
    );
    assert_eq!(
        read(format!("{text}3 0 1 2\n")).last().unwrap(),
        "line 19: it stands after the elements, and was not read"
    );
}

#[test]
fn vertices_of_binary_data_are_points() {
    let row = |x: f32, y: f64, list: &[f32]| {
        let list: Vec<u8> = list.iter().flat_map(|value| value.to_be_bytes()).collect();
        [&y.to_be_bytes()[..], &[(list.len() / 4) as u8], &list, &x.to_be_bytes()].concat()
    };
    let head = PLY.replace("ascii", "binary_big_endian");
    let data = [vec![0], row(1.0, 2.0, &[9.0; 3]), row(3.0, 4.0, &[]), row(5.0, 6.0, &[1.0]), vec![0]].concat();
    let whole = [head.as_bytes(), &data].concat();
    assert_eq!(read_cut(&whole), ["(1,2)", "(3,4)", "(5,6)"]);
    let windows = [head.replace('\n', "\r\n").as_bytes(), &data].concat();
    assert_eq!(read_cut(&windows).len(), 3);
    let more = [&whole[..], b"??"].concat();
    assert_eq!(read_cut(&more)[3], format!("2 bytes after the elements, from byte {} on, were not read", whole.len()));
    let short = &whole[..whole.len() - 15];
    assert_eq!(
        read_cut(short)[2..],
        [format!("the file is cut short, at byte {}: 1 elements \"vertex\" are missing", short.len())]
    );
}

#[test]
fn a_header_of_ply_that_lies_costs_nothing() {
    let head = "ply\nformat binary_little_endian 1.0\nelement none 999999999999999999\nelement vertex 999999999999999999\n\
                property float x\nproperty list int double l\nproperty float y\nend_header\n";
    let point = [&1.0_f32.to_le_bytes()[..], &0_i32.to_le_bytes(), &2.0_f32.to_le_bytes()].concat();
    let endless = [&1.0_f32.to_le_bytes()[..], &i32::MAX.to_le_bytes(), &[0; 99]].concat();
    let said = read_cut(&[head.as_bytes(), &point, &endless].concat());
    assert_eq!(said.len(), 2);
    assert!(said[1].ends_with("999999999999999998 elements \"vertex\" are missing"), "{said:?}");
    let negative = [&1.0_f32.to_le_bytes()[..], &(-1_i32).to_le_bytes(), &point].concat();
    let said = read_cut(&[head.as_bytes(), &negative].concat());
    assert!(said[0].starts_with("a list has a negative length, before byte "), "{said:?}");
}

#[test]
fn a_ply_without_points_is_refused() {
    for (text, words) in [
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n", "without x and y"),
        ("ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n", "no element vertex"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty floot x\n", "line 4: \"property floot x\" has no place"),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty list int int x\nproperty int y\nend_header\n",
            "without x and y",
        ),
        ("ply\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n", "there is no format"),
        ("ply\nformat ascii 1.0\n", "the file ends before end_header"),
    ] {
        let said = read_cut(text.as_bytes());
        assert!(said.len() == 1 && said[0].contains(words), "{text}: {said:?}");
    }
}

fn pcd(data: &str) -> String {
    format!(
        "# .PCD v.7\nVERSION .7\nFIELDS a x y\nSIZE 1 4 8\nTYPE U F F\nCOUNT 2 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA {data}\n"
    )
}

#[test]
fn points_of_a_pcd_are_read() {
    let text = pcd("ascii");
    assert_eq!(read_cut(format!("{text}0 0 1 2\n\n0 0 nan 4\n").as_bytes()), ["(1,2)", "(NaN,4)"]);
    assert_eq!(
        read_cut(format!("{text}0 0 1\n0 0 1 e").as_bytes()),
        [
            "point 1: line 11: 3 values, and the header has 4: complete the header, or mend the line",
            "point 2: line 12: value 4: \"e\" is not a number: write one such as 1.5",
        ]
    );
    assert_eq!(
        read_cut(format!("{text}0 0 1 2\n").as_bytes())[1],
        "the file is cut short: 1 of 2 points are missing, after line 11"
    );
    assert_eq!(
        read_cut(format!("{text}0 0 1 2\n0 0 1 2\n0 0 1 2\n").as_bytes())[2],
        "line 13: it stands after the points, and was not read"
    );
    let row = |x: f32, y: f64| [&[7, 7][..], &x.to_le_bytes(), &y.to_le_bytes()].concat();
    let binary = [pcd("binary").as_bytes(), &row(1.0, 2.0), &row(3.0, 4.0)].concat();
    assert_eq!(read_cut(&binary), ["(1,2)", "(3,4)"]);
    assert_eq!(read_cut(&binary[..binary.len() - 1]).len(), 2);
    assert_eq!(read_cut(&[&binary[..], b"!"].concat())[2].split(',').next().unwrap(), "1 byte after the points");
}

/// Data as they are, in the form of compressed ones.
fn literal(data: &[u8]) -> Vec<u8> {
    data.chunks(32).flat_map(|chunk| [&[chunk.len() as u8 - 1][..], chunk].concat()).collect()
}

#[test]
fn points_of_a_compressed_pcd_are_read() {
    let columns = [&[7; 4][..], &1.0_f32.to_le_bytes(), &3.0_f32.to_le_bytes(), &doubles(&[2.0, 4.0])].concat();
    let compressed = literal(&columns);
    let lengths = [(compressed.len() as u32).to_le_bytes(), (columns.len() as u32).to_le_bytes()].concat();
    let whole = [pcd("binary_compressed").as_bytes(), &lengths, &compressed].concat();
    assert_eq!(read_cut(&whole), ["(1,2)", "(3,4)"]);
    let short = read_cut(&whole[..whole.len() - 3]);
    assert_eq!(short, ["(1,2)", "the file is cut short: 1 of 2 points are missing, after point 1"]);
    let damaged = [pcd("binary_compressed").as_bytes(), &lengths, &[0xff; 30]].concat();
    assert!(read_cut(&damaged)[0].starts_with("the compressed data are damaged"));
    let lying = pcd("binary_compressed").replace("POINTS 2", "POINTS 999999999999999");
    assert!(read_cut(lying.as_bytes())[0].contains("only x and y"));
    for (from, to, words) in [
        ("SIZE 1 4 8", "SIZE 1 4", "as many entries"),
        ("SIZE 1 4 8", "SIZE 1 4 x", "must have numbers"),
        ("x y", "u v", "without x and y"),
        ("POINTS 2\n", "POINTS\n", "must have numbers"),
        ("COUNT 2", "COUNT 18446744073709551615", "too large"),
        ("ascii", "zipped", "write them as ascii or binary"),
    ] {
        let said = read_cut(pcd("ascii").replace(from, to).as_bytes());
        assert!(said.len() == 1 && said[0].contains(words), "{to}: {said:?}");
    }
}

#[test]
fn positions_of_every_geometry_are_points() {
    let geometry = |kind: &str, coordinates: &str| format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
    for (text, points) in [
        (geometry("Point", "[1,2]"), &["(1,2)"][..]),
        (geometry("Point", "[1,2,3,null]"), &["(1,2)"]),
        (geometry("Point", "[]"), &[]),
        (geometry("MultiPoint", "[[1,2],[3,4],[1,2]]"), &["(1,2)", "(3,4)", "(1,2)"]),
        (geometry("LineString", "[[1,2],[3,4]]"), &["(1,2)", "(3,4)"]),
        (geometry("Polygon", "[[[0,0],[1,0],[1,1],[0,0]],[]]"), &["(0,0)", "(1,0)", "(1,1)"]),
        (geometry("Polygon", "[[[0,0],[1,0],[1,1]]]"), &["(0,0)", "(1,0)", "(1,1)"]),
        (
            geometry("MultiPolygon", "[[[[0,0],[1,0],[1,1],[0,0]]],[[[5,5],[6,5],[6,6],[5,5]]]]"),
            &["(0,0)", "(1,0)", "(1,1)", "(5,5)", "(6,5)", "(6,6)"],
        ),
        (
            r#"{"features":[{"properties":{"coordinates":[7,7],"geometry":{"coordinates":[8,8]}},"geometry":
               {"coordinates":[1,2],"type":"Point"},"type":"Feature","bbox":[0,0,0,0]}],"type":"FeatureCollection"}"#
                .to_owned(),
            &["(1,2)"],
        ),
        (
            r#"{"type":"GeometryCollection","geometries":[{"type":"Point","coordinates":[1,2]},
               {"type":"Point","coordinates":[3,4]}]}"#
                .to_owned(),
            &["(1,2)", "(3,4)"],
        ),
        (r#"[{"type":"Point","coordinates":[1,2]}]"#.to_owned(), &["(1,2)"]),
        (
            "\x1e".to_owned() + &geometry("Point", "[1,2]\n") + "\n\x1e" + &geometry("Point", "[3,4]"),
            &["(1,2)", "(3,4)"],
        ),
    ] {
        assert_eq!(read_cut(text.as_bytes()), points, "{text}");
    }
}

#[test]
fn a_bad_position_loses_only_itself() {
    let text = r#"{"type":"MultiPoint","coordinates":[[1,2],[null,3],[4,NaN],[5],["6",7],[[8,9],10],{"x":1},[-Infinity,1],[11,12]]}"#;
    assert_eq!(
        read_cut(text.as_bytes()),
        [
            "(1,2)",
            "point 2: x: null is not a number: write one such as 1.5",
            "point 3: y: NaN or Infinity is not a number: write one such as 1.5",
            "point 4: a position is [longitude, latitude]: write both numbers",
            "point 5: x: \"6\" is not a number: write one such as 1.5",
            "(8,9)",
            "point 7: a position is [longitude, latitude]: write both numbers",
            "point 8: x: NaN or Infinity is not a number: write one such as 1.5",
            "(11,12)",
            "point 10: x: an object is not a number: write one such as 1.5",
        ]
    );
    let feature = r#"{"type":"FeatureCollection","features":[{"type":"Feature","geometry":null},3]}"#;
    assert_eq!(
        read_cut(feature.as_bytes()),
        [
            "point 1: null stands where a geometry should be: give it one",
            "point 2: 3 is no feature and no geometry: leave it out",
        ]
    );
}

#[test]
fn geojson_that_breaks_off_says_where() {
    let text = r#"{"type":"LineString","coordinates":[[1,2],[3,4"#;
    let said = read_cut(text.as_bytes());
    assert_eq!(said[0], "(1,2)");
    assert!(said[1].starts_with(&format!("byte {}: ", text.len())) && said[1].ends_with("nothing after it was read"));
    let said = read_cut(br#"{"type":"LineString","coordinates":[[1,2] [3,4]]}"#);
    assert!(said.len() == 2 && said[1].starts_with("byte 43: "), "{said:?}");
}

#[test]
fn the_units_of_geojson_are_told_once() {
    let choice = |text: &str| {
        let (format, source) = opened(None, None, text.as_bytes()).unwrap();
        let mut reader = Reader::new(source, format, Columns::default(), Limits::default());
        let mut choices = Vec::new();
        while reader.next_record().unwrap().is_some() {
            choices.extend(reader.take_choice().map(|choice| choice.text));
        }
        choices
    };
    let points = r#""type":"MultiPoint","coordinates":[[1,2],[3,4]]}"#;
    assert_eq!(choice(&format!("{{{points}")), ["GeoJSON: x is longitude, y is latitude, in degrees"]);
    let system =
        |name: &str| format!(r#"{{"crs":{{"type":"name","properties":{{"name":"urn:ogc:def:crs:{name}"}}}},{points}"#);
    assert_eq!(choice(&system("OGC:1.3:CRS84")), ["GeoJSON: x is longitude, y is latitude, in degrees"]);
    assert_eq!(
        choice(&system("EPSG::3857")),
        ["GeoJSON: x and y are in the coordinate system \"urn:ogc:def:crs:EPSG::3857\""]
    );
}

#[test]
fn elements_of_arrays_are_read_like_lines() {
    for text in [
        "[[1,2],[3,4]]",
        "[[1,2],\n[3,4]]\n",
        "[\n  [\n    1,\n    2\n  ],\n  [3, 4]\n]\n",
        r#"[{"x":1,"y":2},{"x":3,"y":4}]"#,
        "[[1,2]]\n[[3,4]]\n",
        "[[1,2]]\n[3,4]\n",
        "[{\"points\":[[1,2],[3,4]]}]",
        "{\n\"points\": [\n[1,2],\n[3,4]\n]\n}\n",
        "{\"x\": 1,\n\"y\": 2}\n{\"x\":3,\"y\":4}",
    ] {
        assert_eq!(read_cut(text.as_bytes()), ["(1,2)", "(3,4)"], "{text}");
    }
    assert_eq!(read_cut(br#"[[1,2,3],{"x":1,"y":2,"t":4},{"commit":true}]"#), ["(1,2)@3", "(1,2)@4", "commit"]);
}

#[test]
fn a_bad_element_loses_only_itself() {
    let said = read_cut(br#"[null,[1,2],"a,]b",7,[3],{"x":1},,[3 4],[5,6] [7,8],[[9,9],9]]"#);
    let points: Vec<_> = said.iter().filter(|said| said.starts_with('(')).collect();
    assert_eq!(points, ["(1,2)", "(5,6)", "(7,8)"]);
    assert_eq!(said[0], "element 1: \"null\" is no point: write [x,y] or {\"x\":0,\"y\":0}");
    assert_eq!(said[2], "element 3: \"\\\"a,]b\\\"\" is no point: write [x,y] or {\"x\":0,\"y\":0}");
    assert_eq!(said[5], "element 6, y: missing: write both x and y".replace(", y", ": y"));
    assert_eq!(said[6], "byte 34: an element is missing before the comma");
    assert!(said.contains(&"byte 47: a comma is missing between two elements".to_owned()), "{said:?}");
    assert_eq!(said.len(), 12);
    assert_eq!(
        read_cut(b"[[1,2]] x [[3,4]] y"),
        [
            "(1,2)",
            "1 byte before byte 11 are no array and no object: they were not read",
            "(3,4)",
            "1 byte before byte 20 are no array and no object: they were not read",
        ]
    );
    assert_eq!(read_cut(b"[[1,2],[3")[1], "the text ends within an element, at byte 9");
    assert_eq!(read_cut(b"[[1,2],")[1], "the text ends at byte 7 before the array does");
    let long = format!("[[1,2],[3,{}4],[5,6]]", " ".repeat(1 << 20));
    assert_eq!(read(long), ["(1,2)", "element 2: longer than 1048576 bytes: split it", "(5,6)"]);
}
