//! Points of any dimension, from every form that has them.
//!
//! In: texts and files. Out: the points, or a message.
//! Must not know: series, distances.

use super::*;

#[test]
fn all_columns_of_a_table_are_coordinates() {
    for text in
        ["1,2,3\n4,5,6", "1;2;3\n4;5;6\n", "1 2 3\r4\t5 6", "1\t2\t3\r\n4\t5\t6", "# c\nx,y,z\n\n1,2,3 # d\n4,5,6,,"]
    {
        assert_eq!(read(text), ["3: 1 2 3, 4 5 6"], "{text:?}");
    }
    assert_eq!(read("1\n2\n-3.5\n"), ["1: 1, 2, -3.5"]);
    assert_eq!(read("1,5;2,5\n"), ["2: 1.5 2.5"]);
    let unlike = "line 2: 2 coordinate(s), and the points before have 1: give all points as many";
    assert_eq!(read("1\n2,5\n3\n"), ["1: 1, 3", unlike]);
    assert_eq!(read("7"), ["1: 7"]);
    assert_eq!(read("-0,1e150"), [format!("2: 0 1{}", "0".repeat(150))]);
    assert_eq!(read(""), ["0: "]);
    assert_eq!(read("\n# nothing\n"), ["0: "]);
}

#[test]
fn utf_16_and_gzip_are_taken_off() {
    let text: Vec<u8> = "\u{feff}1,2,3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(&text), ["3: 1 2 3"]);
    assert_eq!(read(compressed(&text)), ["3: 1 2 3"]);
    let whole = compressed(b"1,2,3\n4,5,6\n");
    let said = read(&whole[..whole.len() - 4]);
    assert!(said[1].contains("the gzip data end in the middle"), "{said:?}");
    assert_eq!((said.len(), &*said[0]), (2, "3: 1 2 3, 4 5 6"));
}

#[test]
fn a_header_has_no_numbers_and_is_as_wide_as_the_first_row() {
    assert_eq!(read("temperature\n1\n2"), ["1: 1, 2"]);
    assert_eq!(read("a b c\n1 2 3"), ["3: 1 2 3"]);
    let title = "line 1, column 1: \"The\" is not a number: write one such as 1.5 or -2e-3";
    assert_eq!(read("The data\n1"), ["1: 1", title]);
    let mixed = "line 1, column 1: \"a\" is not a number: write one such as 1.5 or -2e-3";
    assert_eq!(read("a,2,b\n1,2,3"), ["3: 1 2 3", mixed]);
    let wide = "line 3: 3 columns, and the header has 2: complete the header, or mend the line";
    assert_eq!(read("a,b\n1,2\n3,4,5"), ["2: 1 2", wide]);
}

#[test]
fn an_index_without_a_name_is_no_coordinate() {
    for text in [",x,y\n0,1,2\n1,3,4", "\"\",\"V1\",\"V2\"\n\"a\",1,2\n\"b\",3,4", ",0,1\n5,1,2\n6,3,4"] {
        assert_eq!(read(text), ["2: 1 2, 3 4"], "{text:?}");
    }
    assert_eq!(read(",value\n17,1.5\n18,2.5\n"), ["1: 1.5, 2.5"]);
    let index = ["the header names columns: all are coordinates, column 1 is an index"];
    assert_eq!(taken(&PointSettings::default(), ",x,y\n0,1,2"), index);
}

#[test]
fn columns_are_chosen_by_number_or_name() {
    assert_eq!(read_with(&chosen("3,1"), "1,a,3\n4,b,6\n"), ["2: 3 1, 6 4"]);
    assert_eq!(read_with(&chosen("c,a"), "a,b,c\n1,x,3\n"), ["2: 3 1"]);
    assert_eq!(read_with(&chosen("2"), "id v\nA 1\nB 2\n"), ["1: 1, 2"]);
    let missing = "line 2, column 3: missing, split at commas the line has 2 column(s): complete the line, or choose \
                   other columns";
    assert_eq!(read_with(&chosen("3"), "1,2,3\n4,5\n"), ["1: 3", missing]);
    let unknown = read_with(&chosen("d"), "a,b,c\n1,2,3\n");
    assert!(unknown[0].starts_with("line 1: no column is called \"d\" in the header \"a,b,c\""), "{unknown:?}");
}

#[test]
fn a_time_is_no_coordinate_where_times_are_wanted() {
    let text = "t,x,y,z\n2026-11-29T12:00:00Z,1,2,3\n5,4,5,6\n";
    let settings = PointSettings { wants_times: true, ..PointSettings::default() };
    assert_eq!(read_with(&settings, text), ["3: 1 2 3, 4 5 6"]);
    let mut reader = PointReader::new(None, text.as_bytes(), &settings).unwrap();
    let mut times = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        if let PointRecord::Points { time, .. } = record {
            times.push(time);
        }
    }
    assert_eq!(times, [Some(1_795_953_600.0), Some(5.0)]);
    assert_eq!(read("t,x\n1,2"), ["2: 1 2"]);
    let missing = "line 3, column 1: empty: write a number";
    assert_eq!(read_with(&settings, "t,x\n1,2\n,3"), ["1: 2", missing]);
    let missing = read_with(&settings, "x,t\n1,2\n3");
    assert!(missing[1].starts_with("line 3, column 2: missing"), "{missing:?}");
}

#[test]
fn rows_of_another_dimension_and_bad_coordinates_are_told() {
    let text = "1,2,3\n4,5\n6,7,8,9\nnan,1,2\n1,inf,2\n1,2,2e150\n1,,3\n1,x,3\n4,5,6\n";
    let unlike = "and the points before have 3: give all points as many";
    let finite = "is not a finite number: leave the point out or mend its source";
    let expected = [
        "3: 1 2 3, 4 5 6".to_owned(),
        format!("line 2: 2 coordinate(s), {unlike}"),
        format!("line 3: 4 coordinate(s), {unlike}"),
        format!("line 4, column 1: NaN {finite}"),
        format!("line 5, column 2: inf {finite}"),
        "line 6, column 3: 2e150 is beyond 1e150: use a larger unit".to_owned(),
        "line 7, column 2: empty: write a number".to_owned(),
        "line 8, column 2: \"x\" is not a number: write one such as 1.5 or -2e-3".to_owned(),
    ];
    assert_eq!(read(text), expected);
    assert_eq!(read_with(&chosen("3,2"), "1,nan,3\n")[1], format!("line 1, column 2: NaN {finite}"));
    assert_eq!(read(",a,b\n0,1,2\n1,3,nan\n")[1], format!("line 3, column 3: NaN {finite}"));
}

#[test]
fn json_lines_have_points_of_any_dimension() {
    let text = "[1,2,3]\n{\"x\":4,\"y\":5,\"z\":6}\n{\"points\":[[7,8,9],[10,11,12]],\"t\":5}\n{\"commit\":true}\n";
    assert_eq!(read(text), ["3: 1 2 3, 4 5 6, 7 8 9, 10 11 12"]);
    assert_eq!(read("[5]\n{\"x\":6}\n"), ["1: 5, 6"]);
    assert_eq!(read("[1,2,3,4,5]"), ["5: 1 2 3 4 5"]);
    let finite = "is not a finite number: leave the point out or mend its source";
    let text =
        "{\"points\":[[1,2],[\"a\",2],[1,null],[3],7,[3,4]]}\n[1,\"b\"]\n[]\n{\"y\":1}\n{\"z\":1,\"x\":2}\n[[1],2]";
    let expected = [
        "2: 1 2, 3 4".to_owned(),
        format!("line 1, coordinate 2: NaN {finite}"),
        "line 1: 1 coordinate(s), and the points before have 2: give all points as many".to_owned(),
        "line 1, points, point 2, coordinate 1: \"a\" is not a number: write one such as 1.5, without quotes"
            .to_owned(),
        "line 1, points, point 5: 7 is not a point: write [x,y]".to_owned(),
        "line 2, coordinate 2: \"b\" is not a number: write one such as 1.5, without quotes".to_owned(),
        "line 3: 0 element(s): write [x,y,...] with a number for each coordinate".to_owned(),
        "line 4, x: missing: write both x and y".to_owned(),
        "line 5, y: missing: write both x and y".to_owned(),
        "line 6, coordinate 1: an array is not a number: write one such as 1.5, without quotes".to_owned(),
    ];
    assert_eq!(read(text), expected);
    let back = "line 2: points are not taken back here: leave them out";
    assert_eq!(read("[1]\n{\"retract\":[[1]]}\n"), ["1: 1", back]);
}

#[test]
fn many_bad_points_of_a_list_are_counted() {
    let list = vec!["[null]"; 500].join(",");
    let said = read(format!("{{\"points\":[[1],{list}]}}"));
    assert_eq!((said.len(), &*said[0]), (501, "1: 1"));
    assert_eq!(said[500], "line 1: one more of its points is none: correct it like those before");
}

#[test]
fn json_arrays_are_points() {
    assert_eq!(read("[[1,2,3],\n[4,5,6]]"), ["3: 1 2 3, 4 5 6"]);
    assert_eq!(read("[{\"x\":1,\"y\":2,\"z\":3}]"), ["3: 1 2 3"]);
    let said = read("[[1,2,3],[4,5],[6,7,8]]");
    let unlike = "element 2: 2 coordinate(s), and the points before have 3: give all points as many";
    assert_eq!(said, ["3: 1 2 3, 6 7 8", unlike]);
}

#[test]
fn arrays_of_numpy_have_rows_of_any_width() {
    let values: Vec<f64> = (1..=6).map(f64::from).collect();
    assert_eq!(read(array("(2, 3)", false, &values)), ["3: 1 2 3, 4 5 6"]);
    assert_eq!(read(array("(2, 3)", true, &values)), ["3: 1 3 5, 2 4 6"]);
    assert_eq!(read(array("(6,)", false, &values)), ["1: 1, 2, 3, 4, 5, 6"]);
    assert_eq!(read(array("(6,)", true, &values)), ["1: 1, 2, 3, 4, 5, 6"]);
    assert_eq!(read_with(&chosen("3,1"), array("(2, 3)", false, &values)), ["2: 3 1, 6 4"]);
    assert_eq!(read_with(&chosen("3,1"), array("(2, 3)", true, &values)), ["2: 5 1, 6 2"]);
    let bytes = npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 4)}", &[1, 2, 3, 4, 5, 6, 7, 255]);
    assert_eq!(read(bytes), ["4: 1 2 3 4, 5 6 7 255"]);
    let told = "an NPY array of shape (2, 3): 3 coordinate(s), column 1, column 2, column 3";
    assert_eq!(taken(&PointSettings::default(), array("(2, 3)", false, &values)), [told]);
    let fields = "{'descr': [('x', '<i2'), ('t', '<i2'), ('y', '<i2'), ('z', '<i2')], 'fortran_order': False, \
                  'shape': (1,)}";
    assert_eq!(read(npy(fields, &[1, 0, 2, 0, 3, 0, 4, 0])), ["3: 1 3 4"]);
}

#[test]
fn arrays_that_are_none_of_points_are_refused_at_once() {
    for (shape, is_fortran, reason) in [
        ("()", false, "its shape is (), and points are rows: save a.reshape(len(a), -1)"),
        ("(2, 2, 2)", false, "its shape is (2, 2, 2), and points are rows: save a.reshape(len(a), -1)"),
        ("(2, 0)", false, "its shape is (2, 0), and a row has no numbers: save what has some"),
        (
            "(10, 4097)",
            false,
            "its shape is (10, 4097), and a point has at most 4096 coordinates: take fewer columns, or reduce them, as by \
             PCA",
        ),
        ("(1000000000000, 3)", true, "it is too large to be read column by column: save numpy.ascontiguousarray(a)"),
    ] {
        assert_eq!(read(array(shape, is_fortran, &[])), [format!("this is an NPY array: {reason}")]);
    }
    let named = read_with(&chosen("x,y"), array("(2, 3)", false, &[]));
    let reason = "its shape is (2, 3), and its columns have no names: choose \"x\", \"y\" by number";
    assert_eq!(named, [format!("this is an NPY array: {reason}")]);
}

#[test]
fn what_an_array_claims_is_not_believed() {
    let said = read(array("(1000000000000, 3)", false, &[1.0, 2.0, 3.0]));
    let missing = "the file is cut short: 999999999999 of 1000000000000 points are missing, after point 1";
    assert_eq!(said, ["3: 1 2 3", missing]);
    let said = read(array("(1, 2)", false, &[1.0, f64::NAN, 3.0]));
    let finite = "point 1, coordinate 2: NaN is not a finite number: leave the point out or mend its source";
    assert_eq!((said.len(), &*said[1]), (3, finite));
    assert!(said[2].starts_with("8 bytes after the array"), "{said:?}");
    let widest: Vec<f64> = (0..4096).map(f64::from).collect();
    let Space::Points { dimension, coordinates } =
        read_points(None, &array("(1, 4096)", false, &widest)[..], &PointSettings::default(), 1, &mut |_| {})
            .unwrap()
            .space
    else {
        panic!("an array has points")
    };
    assert_eq!((dimension, coordinates), (4096, widest));
}

#[test]
fn clouds_of_other_programs_have_x_y_and_z() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty uchar red\nproperty float y\nproperty \
               float z\nend_header\n1 9 2 3\n4 9 5 6\n";
    assert_eq!(read(ply), ["3: 1 2 3, 4 5 6"]);
    assert_eq!(read_with(&chosen("z,red"), ply), ["2: 3 9, 6 9"]);
    let told = "a PLY file: 3 coordinate(s), the property \"x\", \"y\", \"z\"";
    assert_eq!(taken(&PointSettings::default(), ply), [told]);
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty short z\nproperty short y\nproperty \
                  short x\nend_header\n";
    let binary = [header.as_bytes(), &[3, 0, 2, 0, 1, 0, 6, 0, 5, 0, 4, 0]].concat();
    assert_eq!(read(&binary), ["3: 1 2 3, 4 5 6"]);
    assert!(read(&binary[..binary.len() - 6])[1].contains("cut short"));
    let flat = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n";
    assert_eq!(read(flat), ["2: 1 2"]);
    let header = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT \
                  1\nPOINTS 2\nDATA ";
    assert_eq!(read(format!("{header}ascii\n1 2 3 0\n4 5 6 0\n")), ["3: 1 2 3, 4 5 6"]);
    let data = [1.0_f32, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 0.0].into_iter().flat_map(f32::to_le_bytes);
    let binary: Vec<u8> = format!("{header}binary\n").into_bytes().into_iter().chain(data).collect();
    assert_eq!(read(binary), ["3: 1 2 3, 4 5 6"]);
}

#[test]
fn degrees_are_longitude_and_latitude() {
    let settings = degrees();
    assert_eq!(read_with(&settings, "lat,name,lon\n50,a,7\n-90,b,180\n"), ["2: 7 50, 180 -90"]);
    assert_eq!(read_with(&settings, "7,50,99\n"), ["2: 7 50"]);
    let geo = r#"{"type":"MultiPoint","coordinates":[[7,50,3],[8,51]]}"#;
    assert_eq!(read_with(&settings, geo), ["2: 7 50, 8 51"]);
    let said = read_with(&settings, "lat,lon\n91,7\n");
    let reason =
        "line 2, column 1: 91 is no latitude, which is from -90 to 90 degrees: if it is a longitude, write it first";
    assert_eq!(said, ["0: ", reason]);
}

#[test]
fn too_many_points_or_coordinates_end_the_reading() {
    let points = |most| {
        let mut lines = 0;
        let source = std::iter::from_fn(move || {
            lines += 1;
            // A source that does not end.
            Some(b"1,2\n"[lines % 4])
        });
        struct Endless<I>(I);
        impl<I: Iterator<Item = u8>> Read for Endless<I> {
            fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
                room.iter_mut().zip(&mut self.0).for_each(|(byte, next)| *byte = next);
                Ok(room.len())
            }
        }
        let source = io::Cursor::new(b"1").chain(Endless(source));
        read_points(None, source, &PointSettings::default(), most, &mut |_| {}).unwrap_err().to_string()
    };
    let said = points(5000);
    assert_eq!(said, "line 5001: more than 5000 points: take some of them by --landmarks M, or a smaller sample");
    let wide = read(format!("[{}]", vec!["1"; 5000].join(",")));
    assert_eq!(
        wide,
        [
            "line 1: a point has 5000 coordinates, and may have 4096: take fewer columns by --columns, or reduce them, as \
          by PCA"
        ]
    );
}

#[test]
fn what_is_no_text_is_refused() {
    let noise: Vec<u8> = (0..2000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let said = read(&noise);
    assert!(said[0].starts_with("this is ") || said.len() > 1, "{said:?}");
    let said = read(b"\x89PNG\r\n\x1a\n");
    assert!(said[0].starts_with("this is "), "{said:?}");
}
