//! Distances, in every form, named and unnamed.
//!
//! In: texts and files. Out: the distances below the diagonal, or a message.
//! Must not know: points.

use super::*;

/// What is read, `3: 1, 2 3`, and what it was taken for; or why nothing is.
fn read_as(form: impl Into<Option<DistanceForm>>, name: &str, bytes: impl AsRef<[u8]>) -> Result<[String; 2], String> {
    let mut told = Vec::new();
    let path = (!name.is_empty()).then(|| Path::new(name));
    let space = read_distances(path, bytes.as_ref(), form.into(), 100, &mut |notice| told.push(notice));
    let space = space.map_err(|error| error.to_string())?;
    let taken = told.into_iter().map(|notice| match notice {
        Notice::Taken(text) | Notice::Refused(text) => text,
    });
    Ok([shown(&space), taken.collect::<Vec<_>>().join("; ")])
}

fn space(form: impl Into<Option<DistanceForm>>, bytes: impl AsRef<[u8]>) -> String {
    read_as(form, "", bytes).map_or_else(|error| error, |[space, _]| space)
}

fn fault(form: impl Into<Option<DistanceForm>>, bytes: impl AsRef<[u8]>) -> String {
    read_as(form, "", bytes).unwrap_err()
}

const FULL: &str = "0,1,2,inf\n1,0,3,4\n2,3,0,5\ninf,4,5,0\n";
const ALL: &str = "4: 1, 2 3, inf 4 5";

#[test]
fn the_rows_say_what_they_are() {
    for (text, taken) in [
        (FULL, "a full matrix of 4 points"),
        (",a,b,c,d\na,0,1,2,inf\nb,1,0,3,4\nc,2,3,0,5\nd,inf,4,5,0", "a full matrix of 4 points"),
        ("[[0,1,2,Infinity],[1,0,3,4],\n[2,3,0,5],[Infinity,4,5,0]]", "a full matrix of 4 points"),
        ("\n1\n2 3\nInfinity 4 5\n", "a lower triangle without its diagonal, of 4 points"),
        ("0\n1,0\n2,3,0\ninf,4,5,0\n", "a lower triangle with its diagonal, of 4 points"),
        ("1,2,inf\n3,4\n5\n", "an upper triangle without its diagonal, of 4 points"),
        ("0;1;2;inf\n0;3;4\n0;5\n0\n", "an upper triangle with its diagonal, of 4 points"),
    ] {
        assert_eq!(read_as(None, "", text), Ok([ALL.to_owned(), taken.to_owned()]), "{text:?}");
    }
    let pairs = "0 1 1\n2 1 3\n# c\n0 2 2\n1 3 4\n2\t3\t5\n";
    let taken = "5 pairs i j distance, of 4 points".to_owned();
    assert_eq!(read_as(None, "", pairs), Ok(["4: 0-1 1, 0-2 2, 1-2 3, 1-3 4, 2-3 5".to_owned(), taken]));
    assert_eq!(space(None, "0 1 2\n1 0 3\n2 3 0"), "3: 1, 2 3");
    assert_eq!(space(None, "0,1\n1,0"), "2: 1");
    assert_eq!(space(None, "1\n2,3"), "3: 1, 2 3");
    assert_eq!(space(None, "1,2\n3"), "3: 1, 2 3");
}

#[test]
fn few_points_are_spaces_too() {
    assert_eq!(space(None, ""), "0: ");
    assert_eq!(space(None, "0"), "1: ");
    assert_eq!(space(None, "2.5"), "2: 2.5");
    assert_eq!(space(DistanceForm::Lower, "0"), "2: 0");
    assert_eq!(space(DistanceForm::Condensed, ""), "0: ");
    assert_eq!(space(DistanceForm::Sparse, ""), "0: ");
    assert_eq!(space(DistanceForm::Sparse, "4 4 0"), "5: ");
}

#[test]
fn a_named_form_is_taken() {
    assert_eq!(space(DistanceForm::Full, FULL), ALL);
    for text in ["1,2,3,inf,4,5", "1\n2,3\ninf,4,5", "1 2\n3 inf 4\n5", "0\n1 0\n2 3 0\ninf 4 5 0"] {
        assert_eq!(space(DistanceForm::Lower, text), ALL, "{text:?}");
    }
    for text in ["1,2,inf,3,4,5", "1\n2\ninf\n3\n4\n5", "1,2,inf\n3,4\n5"] {
        assert_eq!(space(DistanceForm::Upper, text), ALL, "{text:?}");
        assert_eq!(space(DistanceForm::Condensed, text), ALL, "{text:?}");
    }
    // Two points coincide.
    assert_eq!(space(DistanceForm::Condensed, "0 1 1"), "3: 0, 1 1");
    assert_eq!(space(DistanceForm::Sparse, "0,1,2.5\n1,0,2.5\n0,2,inf\n"), "3: 0-1 2.5");
}

#[test]
fn rows_that_say_nothing_are_refused() {
    let none = |lengths: &str| {
        format!(
            "rows of {lengths} numbers do not say what they are: name it by --distances full, lower, upper, condensed or \
             sparse; if these are points, name their metric"
        )
    };
    for (text, place, lengths) in [
        ("1 2 3\n", "before line 2", "3"),
        ("1\n2\n3\n", "line 2", "1, 1"),
        ("1 2\n3 4 5\n", "line 2", "2, 3"),
        ("1 2 3\n4\n", "line 2", "3, 1"),
        ("1 2 3\n4 5 6\n7 8\n", "line 3", "3, 3, 2"),
        ("0 1 .5\n1 2 .5\n2 3 .5\n.5 1 2\n", "line 4", "3, 3, 3, 3"),
    ] {
        assert_eq!(fault(None, text), format!("{place}: {}", none(lengths)), "{text:?}");
    }
}

#[test]
fn a_matrix_is_symmetric_to_the_last_bit_with_a_zero_diagonal() {
    assert_eq!(
        fault(None, "0,1,2\n1,0,3\n2,3.0000000000000004,0\n"),
        "before line 4: row 3 column 2 = 3.0000000000000004, and row 2 column 3 = 3: make the matrix symmetric to the \
         last bit, as by numpy.maximum(a, a.T)"
    );
    let diagonal = "0.5, and a point is at distance 0 from itself: correct the diagonal (row 2, column 2)";
    assert_eq!(fault(None, "0,1\n1,0.5\n"), format!("line 2, column 2: {diagonal}"));
    assert_eq!(space(None, "0,inf\ninf,-0\n"), "2: inf");
    assert_eq!(
        fault(None, "0,1,2,3\n1,0,2,3\n1,2,0\n"),
        "line 3: row 3 has 3 number(s), and in a full matrix it has 4: complete it, or name another form by --distances"
    );
    let square = "a matrix of 2 columns has as many rows, and this has 3: if these are points, name their metric";
    assert_eq!(fault(None, "0,1\n1,0\n5,5\n"), format!("line 3: {square}"));
    let square = "a matrix of 4 columns has as many rows, and this has 2: if these are points, name their metric";
    assert_eq!(fault(None, "0,1,2,3\n1,0,2,3\n"), format!("before line 3: {square}"));
}

#[test]
fn nothing_is_left_out_of_distances() {
    let no = "is no distance: write a number from 0 up, or inf for points that are never joined";
    assert_eq!(
        fault(None, "0,-1\n-1,0\n"),
        format!("line 2, column 1: -1 {no}").replace("line 2, column 1", "line 2, column 2")
    );
    assert_eq!(fault(DistanceForm::Full, "0,-1\n-1,0\n"), format!("line 1, column 2: -1 {no}"));
    assert_eq!(fault(DistanceForm::Lower, "1\n2,nan\n"), format!("line 2, column 2: NaN {no}"));
    assert_eq!(
        fault(DistanceForm::Lower, "1\n2,,3\n"),
        "line 2, column 2: empty: write a number; no distance may be missing"
    );
    assert!(fault(None, "1\n2,x\n").starts_with("line 2, column 2: \"x\" is not a number"));
    assert!(fault(None, "[1]\n{\"retract\":[[1]]}\n").starts_with("line 2: points to take back are no distances"));
    let whole = compressed(FULL.as_bytes());
    assert!(fault(None, &whole[..whole.len() - 9]).contains("gzip data end in the middle"));
    assert_eq!(
        fault(None, "1\n2,3\n4,5\n"),
        "line 3: row 3 has 2 number(s), and in a lower triangle it has 3: complete it, or name another form by --distances"
    );
    assert_eq!(
        fault(None, "1,2,3\n4,5\n"),
        "before line 3: the rows of an upper triangle end with 1 number, and the last has 2: complete it"
    );
    assert_eq!(
        fault(DistanceForm::Condensed, "1,2,3,4\n"),
        "before line 2: 4 numbers are no triangle: n points have n (n - 1) / 2 distances"
    );
}

#[test]
fn pairs_are_of_two_points_at_one_distance() {
    let sparse = |text: &str| fault(DistanceForm::Sparse, text);
    let point = "is no point: count points from 0, in whole numbers";
    assert_eq!(sparse("0 1.5 2\n"), format!("line 1, column 2: 1.5 {point}"));
    assert_eq!(sparse("-1 1 2\n"), format!("line 1, column 1: -1 {point}"));
    assert_eq!(sparse("0 nan 2\n"), format!("line 1, column 2: NaN {point}"));
    assert_eq!(sparse("0 100 2\n"), "line 1, column 2: more than 100 points: take a smaller sample");
    assert_eq!(
        sparse("0 1 2\n3 3 1\n"),
        "line 2, column 3: point 3 is at distance 1 from itself, which is 0: leave the row out"
    );
    assert_eq!(
        sparse("0 1 2\n1 2 5\n1 0 3\n"),
        "before line 4: points 0 and 1 are at distance 3 in row 3, and at 2 in row 1: keep one"
    );
    assert_eq!(
        sparse("0 1\n"),
        "line 1: row 1 has 2 number(s), and in a list of pairs it has 3: complete it, or name another form by --distances"
    );
    // Many rows of one pair take the room of one.
    assert_eq!(space(DistanceForm::Sparse, "7 2 0.5\n".repeat(100_000)), "8: 2-7 0.5");
}

#[test]
fn arrays_are_matrices_or_condensed() {
    let full: Vec<f64> = vec![0.0, 1.0, 2.0, 1.0, 0.0, 3.0, 2.0, 3.0, 0.0];
    for is_fortran in [false, true] {
        assert_eq!(space(None, array("(3, 3)", is_fortran, &full)), "3: 1, 2 3");
    }
    let condensed: Vec<f64> = vec![1.0, 2.0, f64::INFINITY, 3.0, 4.0, 5.0];
    assert_eq!(space(None, array("(6,)", false, &condensed)), ALL);
    assert_eq!(space(DistanceForm::Condensed, array("(6,)", false, &condensed)), ALL);
    let cut = fault(None, array("(3, 3)", false, &full[..6]));
    assert!(
        cut.starts_with("the file is cut short: 1 of 3 points are missing")
            && cut.ends_with("no distance may be missing")
    );
    let large = fault(None, array("(100000, 100000)", false, &full));
    assert!(large.contains("a matrix is of at most 100 points: take a smaller sample"), "{large}");
}

#[test]
fn binary_distances_are_a_lower_triangle_of_floats() {
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let bytes = floats(&[1.0, 2.0, 3.0, f32::INFINITY, 4.0, 5.0]);
    let named = |name, bytes: &[u8]| read_as(None, name, bytes).map(|[space, _]| space);
    assert_eq!(named("a/d.bin", &bytes).as_deref(), Ok(ALL));
    assert_eq!(named("d.bin.gz", &compressed(&bytes)).as_deref(), Ok(ALL));
    assert_eq!(space(DistanceForm::Binary, &bytes), ALL);
    // Zeros are no diagonal.
    assert_eq!(named("d.bin", &floats(&[0.0, 1.0, 0.0])).as_deref(), Ok("3: 0, 1 0"));
    let cut = "byte 20: the file ends within a number, which has 4 bytes: copy it again";
    assert_eq!(named("d.bin", &bytes[..22]), Err(cut.to_owned()));
    let no = "byte 5: -2 is no distance: write a number from 0 up, or inf for points that are never joined";
    assert_eq!(named("d.bin", &floats(&[1.0, -2.0])), Err(no.to_owned()));
    assert_eq!(
        named("d.bin", &bytes[..16]),
        Err("byte 16: 4 numbers are no triangle: n points have n (n - 1) / 2 distances".to_owned())
    );
    assert!(named("d.bin.gz", &compressed(&bytes)[..20]).unwrap_err().contains("gzip"));
    assert_eq!(named("d.bin", b"").as_deref(), Ok("0: "));
    let endless = read_distances(None, io::repeat(0), Some(DistanceForm::Binary), 100, &mut |_| {});
    assert_eq!(endless.unwrap_err().to_string(), "byte 20201: more than 100 points: take a smaller sample");
}

#[test]
fn too_many_points_are_refused_before_their_distances_are_held() {
    let row = |length: usize| vec!["0"; length].join(" ");
    let most = "more than 100 points: take a smaller sample";
    assert_eq!(fault(DistanceForm::Full, row(101)), format!("line 1: {most}"));
    assert_eq!(fault(None, format!("{}\n{}", row(101), row(101))), format!("line 2: {most}"));
    assert_eq!(fault(DistanceForm::Lower, row(6000)), format!("line 1, column 5051: {most}"));
    assert_eq!(fault(DistanceForm::Upper, row(101 * 50)), format!("before line 2: {most}"));
    let triangle: String = (1..=101).map(|length| row(length).replace('0', "1") + "\n").collect();
    assert_eq!(fault(None, &triangle), format!("line 101, column 1: {most}"));
    // The limit of a caller is no larger than that of a matrix.
    let text = row(MOST_OF_A_MATRIX + 1);
    let error = read_distances(None, text.as_bytes(), Some(DistanceForm::Full), usize::MAX, &mut |_| {}).unwrap_err();
    assert_eq!(error.to_string(), "line 1: more than 65536 points: take a smaller sample");
}
