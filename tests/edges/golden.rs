//! Comparison with OpenCV: pictures, and OpenCV's edges in them (`tests/data/edges/make.py` made both).

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use crate::{edges, frames};

type Pixels = BTreeSet<[u32; 2]>;

/// OpenCV's parameters, by bit, and our options for the same.
const SETTINGS: [(u8, &str); 3] = [(128, ""), (64, "--low 50 --ratio 2"), (32, "--low 40 --blur 1.4")];

/// The share of either side's pixels that the other side must have too. All decoders give the same pixels of a PNG. In
/// a JPEG some levels differ by one, and a blurred slope has many near ties.
fn least_agreement(is_jpeg: bool, bit: u8) -> f64 {
    match (is_jpeg, bit) {
        (false, _) => 1.0,
        (true, 32) => 0.98,
        (true, _) => 0.99,
    }
}

/// The edges that OpenCV found.
fn found(path: &Path) -> (u32, Vec<u8>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    assert_eq!(reader.output_color_type(), (png::ColorType::Grayscale, png::BitDepth::Eight));
    let mut bits = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bits).unwrap();
    (reader.info().width, bits)
}

fn pictures() -> Vec<(PathBuf, PathBuf)> {
    let folder = Path::new("tests/data/edges");
    let masks = std::fs::read_dir(folder).unwrap().filter_map(|entry| {
        let mask = entry.unwrap().path();
        let name = mask.file_name()?.to_str()?.strip_suffix(".edges.png")?;
        let (stem, ending) = name.rsplit_once('-')?;
        Some((folder.join(format!("{stem}.{ending}")), mask))
    });
    let mut pictures: Vec<_> = masks.collect();
    pictures.sort();
    pictures
}

#[test]
fn edges_equal_those_of_opencv() {
    let pictures = pictures();
    assert_eq!(pictures.len(), 20);
    for (picture, mask) in pictures {
        let (width, bits) = found(&mask);
        for (bit, arguments) in SETTINGS {
            let theirs: Pixels = (0_u32..)
                .zip(&bits)
                .filter(|&(_, bits)| bits & bit != 0)
                .map(|(at, _)| [at % width, at / width])
                .collect();
            let ours = frames(&edges(&picture, arguments).and("--y-down").runs().text());
            assert_eq!(ours.len(), 1, "{picture:?}");
            let ours: Pixels = ours[0].iter().copied().collect();
            assert!(theirs.len() > 200, "{picture:?} is no test");
            let both = ours.intersection(&theirs).count() as f64;
            let share = (both / ours.len() as f64).min(both / theirs.len() as f64);
            let is_jpeg = picture.extension().is_some_and(|ending| ending == "jpg");
            assert!(share >= least_agreement(is_jpeg, bit), "{picture:?} {arguments}: {share}");
        }
    }
}
