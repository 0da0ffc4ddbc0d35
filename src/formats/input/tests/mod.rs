//! What the whole module promises: every form of line, every message, and that neither the bytes nor the way they
//! arrive can upset it.

use std::io::{self, Read};

use super::error::ReadError;
use super::*;

mod hostile;

/// A record in few characters: `+(1,2)@3`, `-(1,2)`, `commit@3`, `blank`, or the message.
fn show(record: &Record<'_>) -> String {
    let list = |points: &[[f64; 2]]| -> String { points.iter().map(|[x, y]| format!("({x},{y})")).collect() };
    let at = |time: &Option<f64>| time.map_or_else(String::new, |time| format!("@{time}"));
    match record {
        Record::Points { points, time } => format!("+{}{}", list(points), at(time)),
        Record::Retract { points } => format!("-{}", list(points)),
        Record::Commit { time } => format!("commit{}", at(time)),
        Record::Blank => "blank".to_owned(),
        Record::Nothing => "nothing".to_owned(),
        Record::Bad(bad) => bad.to_string(),
        Record::Missed(reason) => reason.clone(),
    }
}

fn read_all<R: Read>(reader: &mut Reader<R>) -> Result<Vec<String>, ReadError> {
    let mut shown = Vec::new();
    while let Some(record) = reader.next_record()? {
        if record != Record::Nothing {
            shown.push(show(&record));
        }
    }
    Ok(shown)
}

fn table_with(columns: &str, input: impl AsRef<[u8]>) -> Result<Vec<String>, ReadError> {
    let columns = columns.parse().unwrap();
    read_all(&mut Reader::new(input.as_ref(), Format::Text, columns, Limits::default()))
}

fn table(input: impl AsRef<[u8]>) -> Vec<String> {
    read_all(&mut Reader::new(input.as_ref(), Format::Text, Columns::default(), Limits::default())).unwrap()
}

fn json(input: impl AsRef<[u8]>) -> Vec<String> {
    let columns = Columns::default();
    read_all(&mut Reader::new(input.as_ref(), Format::JsonLines, columns, Limits::default())).unwrap()
}

#[test]
fn a_table_may_be_separated_in_any_usual_way() {
    for line in [
        "1,2",
        "1;2",
        "1\t2",
        "1 2",
        "  1   2  ",
        "1 , 2",
        "1, 2",
        "1\t 2",
        "1 \t 2",
        "1;\t2",
        ",1,2",
        "1,2,3,a;b",
        "1,2 # c",
        "1,2#c",
        "\"1\",\"2\"",
        "\" 1 \" \"2\"",
        "1,2\r",
        "+1,2.0e0",
        "1 2 a,b",
    ] {
        let columns = if line.starts_with(',') { "2,3" } else { "1,2" };
        assert_eq!(table_with(columns, line).unwrap(), ["+(1,2)"], "{line:?}");
    }
}

#[test]
fn numbers_are_all_that_a_float_can_be() {
    assert_eq!(
        table("nan,inf\n-inf 1\n"),
        ["+(NaN,inf)", "line 2, column 1: \"-inf 1\" is not a number: write one such as 1.5 or -2e-3"]
    );
    assert_eq!(table("1e400,-0.0"), ["+(inf,-0)"]);
    assert_eq!(table("Infinity,.5"), ["+(inf,0.5)"]);
}

#[test]
fn blank_lines_differ_from_comments_and_headers() {
    let input = "\u{feff}# made by hand\n\nx,y\n1,2\n  # more\n \t\r\n3,4 # last\n#\n";
    assert_eq!(table(input), ["blank", "+(1,2)", "blank", "+(3,4)"]);
    assert_eq!(table("\u{feff}1,2"), ["+(1,2)"]);
    assert_eq!(table("1,2\n\u{feff}3,4").len(), 2);
    assert_eq!(table(""), [""; 0]);
}

#[test]
fn a_header_stands_before_all_points_and_is_as_wide_as_the_next_line() {
    assert_eq!(table("x,y\n1,2"), ["+(1,2)"]);
    let title = "line 1, column 1: \"The\" is not a number: write one such as 1.5 or -2e-3";
    assert_eq!(table("The data of 2020\n1,2"), [title, "+(1,2)"]);
    assert_eq!(table("The data of 2020\nx,y\n1,2"), [title, "+(1,2)"]);
    assert_eq!(table("\"x of it\" \"y\"\n1 2"), ["+(1,2)"]);
    assert_eq!(table("# c\n\na;b;c\n1;2;3"), ["blank", "+(1,2)"]);
    assert_eq!(
        table("# c\n\na;b;c\n1,2"),
        ["blank", "line 3, column 1: \"a\" is not a number: write one such as 1.5 or -2e-3", "+(1,2)"]
    );
    assert_eq!(
        table("1,2\nx,y\n"),
        ["+(1,2)", "line 2, column 1: \"x\" is not a number: write one such as 1.5 or -2e-3"]
    );
    assert_eq!(table("x,y\nx,y\n").len(), 1);
}

#[test]
fn what_is_no_row_and_no_header_is_reported() {
    let bad =
        |input: &str| -> Vec<String> { table(input).into_iter().filter(|shown| !shown.starts_with('+')).collect() };
    for (input, lines) in [
        ("POINT(1 2)\nPOINT(3 4)\n", &[1, 2][..]),
        ("[1,2]\n1,2\n", &[1]),
        ("[1,2]\n", &[1]),
        ("{\"x\":1,\"y\":2}\n1,2\n", &[1]),
        ("a|b\n1,2\n", &[1]),
        ("one line", &[1]),
        ("a,b,c\n1,2\n3,4\n", &[1]),
        ("a,b\n1,2,3\n4,5\n", &[1]),
        ("x,y\n1,2\n3,4,5\n6,7\n", &[3]),
        ("x,y\n", &[1]),
        ("x,y\n1,2,3", &[2]),
        ("id,x,y\n7\n8,1,2\n", &[2]),
        ("a,b\n1,c\n1,2\n", &[1, 2]),
        ("ab\n1x\n0,0\n", &[1, 2]),
    ] {
        let found = bad(input);
        let expected: Vec<String> = lines.iter().map(|line| format!("line {line}")).collect();
        assert_eq!(found.len(), expected.len(), "{input:?}: {found:?}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found.starts_with(expected.as_str()), "{input:?}: {found}");
        }
    }
    assert_eq!(bad("x,y\n"), ["line 1: this header has no rows after it: add rows, or leave it out"]);
    assert_eq!(bad("x,y\n1,2,3"), ["line 2: 3 columns, and the header has 2: complete the header, or mend the line"]);
}

#[test]
fn a_header_says_which_columns_are_x_and_y() {
    for (input, points) in [
        (",x,y\n0,1,2\n1,3,4\n", ["+(1,2)", "+(3,4)"]),
        ("time,x,y\n9,1,2\n9,3,4\n", ["+(1,2)", "+(3,4)"]),
        ("id;lat;lon\n7;2;1\n8;4;3\n", ["+(1,2)", "+(3,4)"]),
        ("name,X [m],Y [m]\nBonn,1,2\nUlm,3,4\n", ["+(1,2)", "+(3,4)"]),
        ("# x y\n1 2\n3 4\n", ["+(1,2)", "+(3,4)"]),
        ("# made by hand\n#y,x\n2,1\n4,3\n", ["+(1,2)", "+(3,4)"]),
        ("# x y z\n1 2\n3 4\n", ["+(1,2)", "+(3,4)"]),
        ("x,y\n1,2,\n3,4,,\n", ["+(1,2)", "+(3,4)"]),
    ] {
        assert_eq!(table(input), points, "{input:?}");
    }
    let timed = |input: &str| {
        let columns = Columns::default().with_times(true);
        read_all(&mut Reader::new(input.as_bytes(), Format::Text, columns, Limits::default())).unwrap()
    };
    assert_eq!(timed("Time,x,y\n9,1,2\n"), ["+(1,2)@9"]);
    assert_eq!(timed("x,y\n1,2\n"), ["+(1,2)"]);
    // What somebody has chosen holds.
    assert_eq!(table_with("1,2", "id,x,y\n7,1,2\n").unwrap(), ["+(7,1)"]);
}

#[test]
fn what_the_header_has_chosen_is_told_once() {
    let told_of = |input: &str| {
        let mut reader = Reader::new(input.as_bytes(), Format::Text, Columns::default(), Limits::default());
        let mut told = Vec::new();
        while reader.next_record().unwrap().is_some() {
            told.extend(reader.take_choice().map(|choice| choice.text));
        }
        told
    };
    assert_eq!(
        told_of("#17,1,2\n#18,3,4\n# text\n"),
        ["line 1: \"#17,1,2\" is taken for a comment: if it is a row, choose columns that are numbers"]
    );
    assert_eq!(told_of("# 2020: all\n1,2\n"), [""; 0]);
    let told = told_of("id,lat,lon\n7,2,1\n8,4,3\n");
    assert_eq!(told, ["the header names columns: x is column 3 \"lon\", y is column 2 \"lat\""]);
}

#[test]
fn a_row_may_begin_with_the_mark_of_a_comment() {
    let input = "1,1,2\n#17,3,4\n# 18,5,6\n#19,7,8 # last\n#not a row\n";
    assert_eq!(table_with("2,3", input).unwrap(), ["+(1,2)", "+(3,4)", "+(7,8)"]);
    assert_eq!(table("1,2\n#3,4\n"), ["+(1,2)"], "a row that is commented out");
    assert_eq!(table_with("2,3", "#17,1,2\n#18 3 4\n#19,5,6").unwrap(), ["+(1,2)", "+(5,6)"]);
    assert_eq!(table("id,x,y\n#17,1,2\n"), ["+(1,2)"]);
    assert_eq!(table("#17,1,2\n"), [""; 0]);
}

#[test]
fn a_return_alone_ends_a_line() {
    assert_eq!(table("x,y\r1,2\r3,4\r"), ["+(1,2)", "+(3,4)"]);
    assert_eq!(table("1,2\r\r3,4"), ["+(1,2)", "blank", "+(3,4)"]);
    assert_eq!(json("[1,2]\r[3,4]\r\n[5,6]"), ["+(1,2)", "+(3,4)", "+(5,6)"]);
}

#[test]
fn a_first_line_with_a_number_is_not_a_header() {
    for line in ["1,abc", "abc 2", "5", "1.5|2.5", ",", "\"\",\"\""] {
        let records = table(line);
        assert_eq!(records.len(), 1, "{line:?}");
        assert!(records[0].starts_with("line 1, column "), "{line:?}: {records:?}");
    }
}

#[test]
fn columns_are_chosen_by_number_or_name() {
    let input = "id,lon,lat,at\n7,1,2,3\n8,4,5,6\n";
    for columns in ["2,3", "lon,lat", "2,lat", "\"lon\",3"] {
        assert_eq!(table_with(columns, input).unwrap(), ["+(1,2)", "+(4,5)"], "{columns}");
    }
    for columns in ["2,3,4", "lon,lat,at"] {
        assert_eq!(table_with(columns, input).unwrap(), ["+(1,2)@3", "+(4,5)@6"], "{columns}");
    }
    assert_eq!(table_with("lat,lon", input).unwrap(), ["+(2,1)", "+(5,4)"]);
    assert_eq!(table_with("1,2,1", "1,2").unwrap(), ["+(1,2)@1"]);
    assert_eq!(table_with("y,x", "\"x\" \"y\"\n1 2").unwrap(), ["+(2,1)"]);
}

#[test]
fn a_name_that_the_header_lacks_is_fatal() {
    let message = |columns, input| table_with(columns, input).unwrap_err().to_string();
    assert_eq!(
        message("lon,alt", "# c\n\n lon,lat \n1,2"),
        "line 3: no column is called \"alt\" in the header \"lon,lat\": \
         choose names that are there, or number the columns from 1"
    );
    assert_eq!(
        message("lon,lat", "0.5,0.5\n1,2"),
        "line 1: no column is called \"lon\" in the header \"0.5,0.5\": \
         choose names that are there, or number the columns from 1"
    );
    assert_eq!(table_with("lon,lat", "# nothing\n").unwrap(), [""; 0]);
}

#[test]
fn a_bad_row_is_named_with_its_column() {
    let cases = [
        ("3,abc", "line 2, column 2: \"abc\" is not a number: write one such as 1.5 or -2e-3"),
        ("3,", "line 2, column 2: empty: write a number"),
        (" , 3", "line 2, column 1: empty: write a number"),
        (
            "3",
            "line 2, column 2: missing, split at commas the line has 1 column(s): \
             complete the line, or choose other columns",
        ),
        ("3 4", "line 2, column 1: \"3 4\" is not a number: write one such as 1.5 or -2e-3"),
        (
            "\"3,5\",4",
            "line 2, column 1: \"3,5\" has a comma: write \"3.5\" if it is decimal, \"35\" if it marks thousands",
        ),
    ];
    for (line, message) in cases {
        assert_eq!(table(format!("1,2\n{line}\n5,6")), ["+(1,2)", message, "+(5,6)"], "{line:?}");
    }
}

#[test]
fn a_decimal_comma_never_makes_two_columns() {
    for separator in [";", "\t", " "] {
        let input = format!("1{separator}2\n1,5{separator}2,5\n1,5\n");
        let records = table(&input);
        assert_eq!(records[..2], ["+(1,2)", "+(1.5,2.5)"], "{input:?}");
        assert!(records[2].starts_with("line 3, column 2: missing"), "{input:?}: {records:?}");
        assert_eq!(table(format!("x{separator}y\n1,5{separator}2,5\n")), ["+(1.5,2.5)"]);
    }
    assert_eq!(table("1,2 3\n"), ["+(1.2,3)"]);
    assert_eq!(table("1,2\n1,5 2,5\n").len(), 2, "the first row has decided");
}

#[test]
fn bytes_that_are_no_text_are_one_bad_line() {
    let message = "line 2, byte 3: not UTF-8 text: convert the input, as with iconv -f LATIN1 -t UTF-8";
    assert_eq!(table(b"1,2\n3,\xff4\n5,6"), ["+(1,2)", message, "+(5,6)"]);
    assert_eq!(json(b"[1,2]\n [\xff4]\n[5,6]"), ["+(1,2)", message, "+(5,6)"]);
    assert_eq!(table(b"1,2 # \xff\n# \xff"), ["+(1,2)"]);
}

#[test]
fn a_line_over_the_limit_is_one_bad_line() {
    for (format, input) in [(Format::Text, "1,2\n3,44444\n5,6"), (Format::JsonLines, "[1,2]\n[3,44444]\n[5,6]")] {
        let mut reader = Reader::new(input.as_bytes(), format, Columns::default(), Limits { line_bytes: 5 });
        let message = "line 2: longer than 5 bytes, the most of a line: split it into several";
        assert_eq!(read_all(&mut reader).unwrap(), ["+(1,2)", message, "+(5,6)"]);
        assert_eq!((reader.line(), reader.bytes_read()), (3, input.len() as u64));
    }
}

#[test]
fn every_form_of_json_line_is_read() {
    let cases = [
        ("[1,2]", "+(1,2)"),
        (" [ 1 , -2.5e1 ] \r", "+(1,-25)"),
        ("[1,2,3]", "+(1,2)@3"),
        ("[1,2,null]", "+(1,2)"),
        (r#"{"x":1,"y":2}"#, "+(1,2)"),
        (r#"{"y":2,"t":3,"x":1}"#, "+(1,2)@3"),
        (r#"{"x":1,"y":2,"t":null}"#, "+(1,2)"),
        (r#"{"id":{"a":[1,{}]},"x":1,"y":2,"name":"p","time":"noon"}"#, "+(1,2)"),
        (r#"{"\u0078":1,"y":2}"#, "+(1,2)"),
        (r#"{"points":[[1,2],[3,4]]}"#, "+(1,2)(3,4)"),
        (r#"{"points":[[1,2]],"t":5}"#, "+(1,2)@5"),
        (r#"{"points":[]}"#, "+"),
        (r#"{"retract":[[1,2],[3,4]]}"#, "-(1,2)(3,4)"),
        (r#"{"retract":[],"t":"ignored"}"#, "-"),
        (r#"{"commit":true}"#, "commit"),
        (r#"{"commit":true,"time":4}"#, "commit@4"),
        (r#"{"commit":true,"t":4}"#, "commit@4"),
        (r#"{"commit":true,"t":4,"time":5}"#, "commit@5"),
        ("[18446744073709551615,-9223372036854775808]", "+(18446744073709552000,-9223372036854776000)"),
        ("", "blank"),
    ];
    for (line, expected) in cases {
        assert_eq!(json(format!("# c\n{line}\n")), [expected], "{line}");
    }
    assert_eq!(json("\u{feff}[1,2]\n\n  # c\n[3,4]"), ["+(1,2)", "blank", "+(3,4)"]);
}

#[test]
fn a_bad_json_line_is_named_with_its_member() {
    let number = "is not a number: write one such as 1.5, without quotes";
    let time = "is not a time: write seconds such as 1.5, or a date and time such as 2026-11-29T12:30:00Z";
    let cases = [
        ("[\"1\",2]", format!("x: \"1\" {number}")),
        ("[1,2,\"noon\"]", format!("t: \"noon\" {time}")),
        ("[[1,2],[3,4]]", format!("x: an array {number}")),
        (r#"{"x":true,"y":1}"#, format!("x: true {number}")),
        (r#"{"x":1,"y":{"a":1}}"#, format!("y: an object {number}")),
        (r#"{"x":1,"y":2,"t":"noon"}"#, format!("t: \"noon\" {time}")),
        (r#"{"commit":true,"time":"noon"}"#, format!("time: \"noon\" {time}")),
        (r#"{"x":1}"#, "y: missing: write both x and y".into()),
        (r#"{"y":1}"#, "x: missing: write both x and y".into()),
        (r#"{"x":1,"y":2,"x":3}"#, "x: written twice: write it once".into()),
        (r#"{"x":1,"points":[]}"#, "points: stands beside x: write each on a line of its own".into()),
        (r#"{"points":[],"retract":[]}"#, "retract: stands beside points: write each on a line of its own".into()),
        (r#"{"commit":false}"#, "commit: false is not true: write \"commit\":true, or leave the line out".into()),
    ];
    for (line, message) in cases {
        assert_eq!(json(format!("{line}\n[5,6]")), [format!("line 1, {message}"), "+(5,6)".into()]);
    }
}

#[test]
fn a_bad_json_line_is_named_as_a_whole() {
    let cases = [
        ("[1]", "1 element(s): write [x,y] or [x,y,t]"),
        ("[]", "0 element(s): write [x,y] or [x,y,t]"),
        ("[1,2,3,[4],5]", "5 element(s): write [x,y] or [x,y,t]"),
        ("{}", "no x and y, points, retract or commit: write one of them"),
        (r#"{"t":1}"#, "no x and y, points, retract or commit: write one of them"),
        ("1,2", "\"1,2\" is neither an array nor an object: write [x,y] or {\"x\":0,\"y\":0}"),
    ];
    for (line, message) in cases {
        assert_eq!(json(line), [format!("line 1: {message}")], "{line}");
    }
}

#[test]
fn a_bad_element_of_a_list_takes_no_other_with_it() {
    let number = "is not a number: write one such as 1.5, without quotes";
    let cases = [
        (r#"["points":[[1,2],["a",2],[3,4]]]"#, "points, point 2, x: \"a\"".to_owned() + " " + number),
        (r#"["points":[[1,2],[2,[1]],[3,4]]]"#, format!("points, point 2, y: an array {number}")),
        (r#"["points":[[1,2],[1,2,3],[3,4]]]"#, "points, point 2: 3 element(s): write [x,y]".into()),
        (r#"["points":[[1,2],null,[3,4]]]"#, "points, point 2: null is not a point: write [x,y]".into()),
        (r#"["points":[[1,2],3.5,[3,4]]]"#, "points, point 2: 3.5 is not a point: write [x,y]".into()),
        (r#"["points":[[1,2],"a",[3,4]]]"#, "points, point 2: \"a\" is not a point: write [x,y]".into()),
        (r#"["points":[[1,2],{"x":1},[3,4]]]"#, "points, point 2: an object is not a point: write [x,y]".into()),
    ];
    for (line, message) in cases {
        let line = format!("{{{}}}", &line[1..line.len() - 1]);
        assert_eq!(json(format!("{line}\n[5,6]")), ["+(1,2)(3,4)", &format!("line 1, {message}"), "+(5,6)"]);
        let retract = line.replace("points", "retract");
        assert_eq!(json(&retract), ["-(1,2)(3,4)", &format!("line 1, {}", message.replace("points", "retract"))]);
    }
    // The first are named, and all are counted.
    let line = format!("{{\"points\":[{}[1,2]]}}\n[3,4]", "0,".repeat(1000));
    let found = json(line);
    assert_eq!((found.len(), found[0].as_str(), found[1001].as_str()), (1002, "+(1,2)", "+(3,4)"));
    assert_eq!(found[64], "line 1, points, point 64: 0 is not a point: write [x,y]");
    assert_eq!(found[65], "line 1: one more of its points is none: correct it like those before");
    // A line that is no JSON in the end has no points.
    assert_eq!(json("{\"points\":[[1,2],0,[3,4]").len(), 1);
}

#[test]
fn numbers_that_json_has_no_word_for_are_numbers_that_no_point_has() {
    for (line, points) in [
        ("[1,null]", "+(1,NaN)"),
        ("[NaN,-Infinity]", "+(NaN,-inf)"),
        ("[\"NaN\",1]", "+(NaN,1)"),
        ("[1,1e999]", "+(1,inf)"),
        (r#"{"x":NaN,"y":null,"t":3}"#, "+(NaN,NaN)@3"),
        (r#"{"points":[[1,2],[3,null],[NaN,Infinity],[5,6]]}"#, "+(1,2)(3,NaN)(NaN,inf)(5,6)"),
        (r#"{"retract":[[1,nan]],"note":"NaN [\" NaN"}"#, "-(1,NaN)"),
        (r#"{"points":[[1,2]],"t":NaN}"#, "+(1,2)@NaN"),
    ] {
        assert_eq!(json(line), [points], "{line}");
    }
    assert_eq!(json("[NaN,1"), ["line 1: EOF while parsing a list: correct the JSON"]);
}

#[test]
fn times_may_be_written_in_iso_8601() {
    let time = "1970-01-01T00:01:00Z";
    assert_eq!(json(format!("[1,2,\"{time}\"]")), ["+(1,2)@60"]);
    assert_eq!(json(format!(r#"{{"commit":true,"time":"{time}"}}"#)), ["commit@60"]);
    assert_eq!(
        table_with("1,2,3", format!("1,2,{time}\n3,4,1970-01-01 00:02\n")).unwrap(),
        ["+(1,2)@60", "+(3,4)@120"]
    );
    let timed = |input: &str| {
        let columns = Columns::default().with_times(true);
        read_all(&mut Reader::new(input.as_bytes(), Format::JsonLines, columns, Limits::default())).unwrap()
    };
    for name in ["t", "time", "stamp", "timestamp"] {
        assert_eq!(timed(&format!(r#"{{"x":1,"y":2,"{name}":60}}"#)), ["+(1,2)@60"]);
        assert_eq!(timed(&format!(r#"{{"{name}":"{time}","points":[[1,2]]}}"#)), ["+(1,2)@60"]);
    }
    assert_eq!(timed(r#"{"x":1,"y":2,"time":"noon","t":3}"#), ["+(1,2)@3"]);
    let header = format!("x,y,when\n1,2,{time}\n");
    assert_eq!(table_with("x,y,when", header).unwrap(), ["+(1,2)@60"]);
}

#[test]
fn a_json_error_is_named_with_its_byte() {
    let cases = [
        ("[1,2", "byte 4: EOF while parsing a list"),
        ("[1,2]]", "byte 6: trailing characters"),
        ("  [1,2],", "byte 8: trailing characters"),
        ("{\"x\":1,}", "byte 8: trailing comma"),
        ("{\"x\" 1}", "byte 6: expected `:`"),
        ("{\"points\":3}", "byte 11: invalid type: integer `3`, expected a list of points [[x,y]]"),
        ("{\"points\":\"a\"}", "byte 13: invalid type: string, expected a list of points [[x,y]]"),
    ];
    for (line, message) in cases {
        assert_eq!(json(line), [format!("line 1, {message}: correct the JSON")], "{line}");
    }
}

#[test]
fn deep_nesting_is_refused_and_not_followed() {
    for open in ["[", "{\"a\":", "{\"points\":[", "{\"x\":["] {
        assert!(json(open.repeat(100_000))[0].starts_with("line 1, byte "), "{open}");
    }
}

#[test]
fn a_failing_source_is_reported_with_the_line() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("cable cut"))
        }
    }
    let source = b"1,2\n3,".chain(Failing);
    let mut reader = Reader::new(source, Format::Text, Columns::default(), Limits::default());
    assert!(matches!(reader.next_record(), Ok(Some(Record::Points { .. }))));
    let error = reader.next_record().unwrap_err().to_string();
    assert_eq!(error, "line 2: reading failed: cable cut");
}

#[test]
fn lines_and_bytes_are_counted() {
    let input = "# c\nx,y\n1,2\r\n\n3,4";
    let mut reader = Reader::new(input.as_bytes(), Format::Text, Columns::default(), Limits::default());
    let mut counts = vec![(reader.line(), reader.bytes_read())];
    while reader.next_record().unwrap().is_some() {
        counts.push((reader.line(), reader.bytes_read()));
    }
    assert_eq!(counts, [(0, 0), (1, 4), (2, 8), (3, 12), (4, 14), (5, 17)]);
}
