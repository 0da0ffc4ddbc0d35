//! Bytes that mean nothing, and files with damage: no panic, no endless work, and the same however they are cut.

use super::*;

/// Files of every format, with headers that are right.
fn file() -> impl Strategy<Value = Vec<u8>> {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/foreign");
    let names = [
        "ring.npy",
        "fortran.npy",
        "records.npy",
        "ascii.ply",
        "little_endian.ply",
        "big_endian.ply",
        "ascii.pcd",
        "binary.pcd",
        "compressed.pcd",
        "ring.geojson",
        "pretty.json",
        "array.json",
        "utf16.csv",
        "ring.csv.gz",
        "ring.npy.gz",
    ];
    prop::sample::select(names.to_vec()).prop_map(move |name| std::fs::read(format!("{directory}/{name}")).unwrap())
}

/// The beginnings of formats, with anything behind them.
fn begun() -> impl Strategy<Value = Vec<u8>> {
    let beginnings: Vec<&[u8]> = vec![
        b"\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (",
        b"\x93NUMPY\x03\x00",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 9999999\nproperty list int int a\nproperty float x\n\
          property float y\nend_header\n",
        b"ply\nformat ascii 1.0\n",
        b"# .PCD\nFIELDS x y\nSIZE 8 8\nTYPE F F\nPOINTS 99999999\nDATA binary_compressed\n",
        b"# .PCD\nFIELDS x y\n",
        b"{\"type\":\"Polygon\",\"coordinates\":[[[",
        b"[[1,2],",
        b"[{",
        b"\xff\xfe",
        b"\x1f\x8b\x08\x00",
        b"PK\x03\x04",
        b"",
    ];
    let likely = prop::sample::select(b"0123456789[]{},:\"\\ \nNaInfty-e.'()".to_vec());
    let rest = prop_oneof![prop::collection::vec(likely, 0..200), prop::collection::vec(any::<u8>(), 0..200),];
    (prop::sample::select(beginnings), rest).prop_map(|(beginning, rest)| [beginning, &rest].concat())
}

/// A file with bytes changed, removed and added.
fn damaged() -> impl Strategy<Value = Vec<u8>> {
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4);
    (file(), changes, any::<prop::sample::Index>(), 0..3_u8).prop_map(|(mut file, changes, end, kind)| {
        for (at, byte) in changes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        match kind {
            0 => file.truncate(end.index(file.len())),
            1 => drop(file.drain(..end.index(file.len()))),
            _ => {}
        }
        file
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn damage_and_noise_are_the_same_however_they_are_cut(
        bytes in prop_oneof![damaged(), begun(), prop::collection::vec(any::<u8>(), 0..600)],
        lengths in prop::collection::vec(1..200_usize, 1..4),
    ) {
        let whole = read_from(&bytes[..], None, "");
        for said in &whole {
            let is_point = said.starts_with(['(', '-']);
            prop_assert!((is_point || said.chars().count() < 600) && !said.chars().any(char::is_control), "{said:?}");
        }
        // Where damaged gzip breaks off is a matter of how it is cut: see `Gzip`.
        prop_assume!(!bytes.starts_with(b"\x1f\x8b"));
        prop_assert_eq!(read_from(Pieces::new(&bytes, &lengths), None, ""), whole);
    }

    #[test]
    fn a_file_that_is_cut_short_gives_its_beginning_and_a_word_about_the_rest(
        file in file(),
        end in any::<prop::sample::Index>(),
    ) {
        let beginning = &file[..8 + end.index(file.len() - 8)];
        let (all, cut) = (read(&file), read(beginning));
        let points = |said: &[String]| -> Vec<String> { said.iter().filter(|said| said.starts_with('(')).cloned().collect() };
        let (all_points, cut_points) = (points(&all), points(&cut));
        prop_assert_eq!(all_points.len(), all.len());
        let all_but_one = cut_points.len().saturating_sub(1);
        // The last number of a text may be cut into a shorter one, if nothing after it says that it is not whole.
        prop_assert_eq!(&cut_points[..all_but_one], &all_points[..all_but_one]);
        prop_assert!(cut_points.len() == all_points.len() || cut.len() > cut_points.len() || may_end(beginning), "{:?}", cut);
    }
}

/// A table may end anywhere, and gzip after each of its members.
fn may_end(beginning: &[u8]) -> bool {
    let mut members = flate2::bufread::MultiGzDecoder::new(beginning);
    beginning.starts_with(b"\xff\xfe") || std::io::copy(&mut members, &mut std::io::sink()).is_ok()
}
