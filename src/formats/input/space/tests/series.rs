//! Series of numbers, as delay vectors.
//!
//! In: texts. Out: the vectors, the gaps, or a message.
//! Must not know: points that are none of a series.

use super::*;

fn series(dimension: usize, lag: usize, columns: Option<&str>) -> PointSettings {
    let coordinates = columns.map_or_else(Coordinates::default, |columns| Coordinates::Any(columns.parse().unwrap()));
    let embedding = Some(Embedding::new(dimension, lag).unwrap());
    PointSettings { coordinates, embedding, ..PointSettings::default() }
}

fn gaps(settings: &PointSettings, text: &str) -> u64 {
    read_points(None, text.as_bytes(), settings, 1000, &mut |_| {}).unwrap().gaps
}

#[test]
fn one_column_of_numbers_becomes_vectors() {
    let text = "1\n2\n3\n4\n5\n";
    assert_eq!(read_with(&series(2, 1, None), text), ["2: 1 2, 2 3, 3 4, 4 5"]);
    assert_eq!(read_with(&series(3, 2, None), text), ["3: 1 3 5"]);
    assert_eq!(read_with(&series(3, 3, None), text), ["0: "]);
    assert_eq!(read_with(&series(2, 1, Some("v")), "t,v\n0,1\n1,2\n2,3\n"), ["2: 1 2, 2 3"]);
    assert_eq!(read_with(&series(2, 1, None), "{\"points\":[[1],[2],[3]]}\n[4]\n"), ["2: 1 2, 2 3, 3 4"]);
    assert_eq!(read_with(&series(2, 2, None), array("(4,)", false, &[1.0, 2.0, 3.0, 4.0])), ["2: 1 3, 2 4"]);
    let mut reader = PointReader::new(None, text.as_bytes(), &series(2, 1, None)).unwrap();
    assert_eq!(reader.next_record().unwrap(), Some(PointRecord::Points { coordinates: &[], time: None }));
    assert_eq!(reader.dimension(), Some(2));
    let wide = "line 1: 2 numbers, and a series has one: choose its column, as by --columns 1";
    assert_eq!(read_with(&series(2, 1, None), "1,2\n"), [wide]);
}

#[test]
fn a_long_list_comes_in_pieces() {
    let samples: Vec<String> = (0..3000).map(|sample| format!("[{sample}]")).collect();
    let text = format!("{{\"points\":[{}],\"t\":5}}\n[3000]\n", samples.join(","));
    let mut reader = PointReader::new(None, text.as_bytes(), &series(1000, 1, None)).unwrap();
    let (mut last, mut pieces) = (Vec::new(), 0);
    while let Some(record) = reader.next_record().unwrap() {
        let PointRecord::Points { coordinates, time } = record else { panic!("all lines are samples") };
        assert!(coordinates.len() < (1 << 16) + 1000);
        last.extend(coordinates.chunks(1000).map(|vector| vector[999]));
        pieces += u32::from(time == Some(5.0));
        assert_eq!(reader.place(), if last.last() == Some(&3000.0) { "line 2" } else { "line 1" });
    }
    assert_eq!(pieces, 31);
    assert!(last.into_iter().eq((999..=3000).map(f64::from)));
}

#[test]
fn no_vector_straddles_a_gap() {
    for bad in ["oops", "nan", "inf", "1,2,3 x"] {
        let text = format!("1\n2\n{bad}\n3\n4\n# a comment is none\n\n5\n");
        let said = read_with(&series(2, 1, None), &text);
        assert_eq!((said.len(), &*said[0]), (2, "2: 1 2, 3 4, 4 5"), "{said:?}");
        assert_eq!(gaps(&series(2, 1, None), &text), 1, "{bad}");
    }
    assert_eq!(gaps(&series(2, 1, None), "1\n2\n3\n"), 0);
    assert_eq!(gaps(&series(2, 1, None), "1\nx\nx\n2\nx\n"), 2);
}

#[test]
fn a_list_with_a_gap_is_left_out_as_a_whole() {
    let text = "[1]\n[2]\n{\"points\":[[3],[4],[\"x\"],[5],[6]]}\n[7]\n[8]\n";
    let left_out = "line 3: 4 sample(s) of a list with gaps are left out: write each on a line of its own";
    let bad = "line 3, points, point 3, coordinate 1: \"x\" is not a number: write one such as 1.5, without quotes";
    assert_eq!(read_with(&series(2, 1, None), text), ["2: 1 2, 7 8", left_out, bad]);
    let listed = format!("[{}]", text.trim_end().replace('\n', ","));
    let said = read_with(&series(2, 1, None), listed);
    assert_eq!((said.len(), &*said[0]), (3, "2: 1 2, 7 8"), "{said:?}");
    // The place of null is known.
    let said = read_with(&series(2, 1, None), "{\"points\":[[1],[2],[null],[3],[4]]}");
    assert_eq!((said.len(), &*said[0]), (2, "2: 1 2, 3 4"), "{said:?}");
}

#[test]
fn nothing_is_taken_back_from_a_series() {
    let back = "line 2: points cannot be taken back here: leave the line out";
    assert_eq!(read_with(&series(2, 1, None), "[1]\n{\"retract\":[[1]]}\n[2]\n"), ["2: 1 2", back]);
}
