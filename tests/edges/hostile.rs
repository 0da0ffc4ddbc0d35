//! Invalid input: it is refused with its name and counted, and the rest is processed.

use crate::common::process::hopes;
use crate::common::random::Random;
use crate::{Gray, column, edges, folder, frames};

/// The most memory that a process may use, whatever a file announces.
#[cfg(target_os = "linux")]
const MEMORY: u64 = 400 << 20;

fn good() -> Vec<u8> {
    Gray::step(12, 3, 5, 200).png()
}

/// A PNG that announces this size.
fn announced(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = good();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = u32::MAX;
    for byte in &bytes[12..29] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = crc >> 1 ^ (0xEDB8_8320 * (crc & 1)));
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

/// A JPEG with an overwritten size.
fn announced_jpeg(width: u16, height: u16) -> Vec<u8> {
    let mut bytes = std::fs::read("tests/data/edges/bunny-gray.jpg").unwrap();
    let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    bytes[frame + 5..frame + 7].copy_from_slice(&height.to_be_bytes());
    bytes[frame + 7..frame + 9].copy_from_slice(&width.to_be_bytes());
    bytes
}

#[test]
fn bad_pictures_are_named_and_skipped() {
    let jpeg = std::fs::read("tests/data/edges/bunny-gray.jpg").unwrap();
    let files = [
        ("1.png", good()),
        ("2.png", good()[..60].to_vec()),
        ("3.png", b"not a picture".to_vec()),
        ("4.png", Vec::new()),
        ("5.jpg", jpeg[..jpeg.len() / 2].to_vec()),
        ("6.jpg", jpeg[..20].to_vec()),
        ("7.png", announced(i32::MAX as u32, i32::MAX as u32)),
        ("8.png", announced(60_000, 60_000)),
        ("9.jpg", announced_jpeg(60_000, 60_000)),
        ("10.png", good()),
    ];
    let bad = folder(&files);
    let finished = edges(bad.path(), "--rate 100 --format jsonl").runs();
    for words in [
        "2.png: damaged PNG",
        "3.png: it is neither PNG, JPEG nor YUV4MPEG2",
        "4.png: it is neither",
        "5.jpg: damaged JPEG",
        "6.jpg: damaged JPEG",
        "7.png: its size, 2147483647 x 2147483647, is too large: 67108864 pixels",
        "8.png: its size, 60000 x 60000, is too large",
        "9.jpg: its size, 60000 x 60000, is too large",
        "2 frames, 8 refused",
    ] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
    // A refused picture keeps its place in time.
    let text = finished.text();
    assert!(text.contains("\"time\":0.0}") && text.contains("\"time\":0.09}") && text.lines().count() == 4, "{text}");
    edges(bad.path().join("2.png"), "").runs().fails(1, &["2.png: damaged PNG", "nothing of the input could be used"]);
    let strict = edges(bad.path(), "--strict").runs();
    assert_eq!(strict.code, Some(3), "{}", strict.err);
    assert!(
        strict.err.contains("2.png: damaged PNG") && strict.err.contains("(--strict stops here)"),
        "{}",
        strict.err
    );
    assert_eq!(frames(&String::from_utf8(strict.out).unwrap()), [column(4, 0..3)]);
}

#[test]
fn an_error_in_a_video_names_the_frame() {
    let frame = [b"FRAME\n".as_slice(), &Gray::step(12, 3, 5, 200).pixels].concat();
    let video = |header: &str, rest: &[&[u8]]| [format!("YUV4MPEG2 {header}\n").as_bytes(), &rest.concat()].concat();
    for (input, found, words) in [
        (video("W12 H3 Cmono", &[&frame, &frame[..20]]), 1, "stdin: frame 2 is cut off after 14 of 36 bytes"),
        (video("W12 H3", &[&frame]), 0, "frame 1 is cut off after 36 of 60 bytes"),
        (video("W12 H3 Cmono", &[&frame, b"FRAMES\n", &frame]), 1, "frame 2 does not begin where it should"),
        (video("W12 H3 Cmono", &[&frame, b"FRAME", &[b' '; 5000], b"\n"]), 1, "the header of frame 2 does not end"),
        (video("W4294967295 H4294967295 Cmono", &[&frame]), 0, "4294967295 x 4294967295, is no use"),
        (video("W99999999999999 H3", &[&frame]), 0, "\"W99999999999999\" in its header makes no sense"),
        (video("W0 H3", &[]), 0, "0 x 3, is no use"),
        (video("W12 Cmono", &[&frame]), 0, "does not say how wide and how high"),
        (video("W12 H3 Cxyz", &[&frame]), 0, "its colours are \"xyz\""),
        (video("W12 H3 C420p99", &[&frame]), 0, "its colours are \"420p99\""),
        (video("W12 H3 F30", &[&frame]), 0, "\"F30\" in its header makes no sense"),
        (video(&"X".repeat(5000), &[&frame]), 0, "the header of the video does not end within 4096 bytes"),
        (b"YUV4MPEG2 W12 H3".to_vec(), 0, "the header of the video does not end"),
        (b"YUV4MPEG2W12 H3\n".to_vec(), 0, "it is no YUV4MPEG2"),
        (b"RIFF....AVI LIST".to_vec(), 0, "say how large they are: --size WxH"),
        (Vec::new(), 0, "stdin: it is neither"),
    ] {
        let finished = hopes("edges -").reads(input).code_and_log();
        assert!(finished.1.contains(words), "{words}: {}", finished.1);
        assert_eq!((finished.0, finished.2), (Some(i32::from(found == 0)), found), "{words}");
    }
    let finished = hopes("edges - --size 12x3").reads(&frame[6..40]);
    finished.fails(1, &["frame 1 is cut off after 34 of 36 bytes"]);
    hopes("edges - --input y4m").reads(good()).fails(1, &["stdin: it is no YUV4MPEG2"]);
    hopes("edges - --input images").reads(&frame).fails(1, &["stdin: it is neither PNG nor JPEG"]);
}

impl crate::common::process::Finished {
    /// The exit code, the log, and the number of written frames.
    fn code_and_log(self) -> (Option<i32>, String, usize) {
        assert!(!self.err.contains("panicked"), "{}", self.err);
        let text = String::from_utf8(self.out).unwrap();
        (self.code, self.err, frames(&text).len())
    }
}

/// The process goes through all damaged files.
#[test]
fn damaged_files_never_end_the_process() {
    let mut random = Random::new(7);
    let sources = ["text.png", "horse.png", "camera-16-bits.png", "bunny-gray.jpg", "hubble-without-luma.jpg"];
    let damaged = tempfile::tempdir().unwrap();
    for source in sources {
        let good = std::fs::read(format!("tests/data/edges/{source}")).unwrap();
        for number in 0..24 {
            let mut bytes = good.clone();
            for _ in 0..1 + number % 4 {
                // Damage to headers is the most interesting.
                let end = if random.below(2) == 0 { bytes.len().min(700) } else { bytes.len() };
                bytes[random.below(end as u64) as usize] = random.below(256) as u8;
            }
            bytes.truncate(if number % 5 == 0 { random.below(bytes.len() as u64) as usize } else { bytes.len() });
            std::fs::write(damaged.path().join(format!("{number}-{source}")), bytes).unwrap();
        }
    }
    std::fs::write(damaged.path().join("z.png"), good()).unwrap();
    let (code, log, found) = edges(damaged.path(), "").runs().code_and_log();
    assert_eq!(code, Some(0), "{log}");
    assert!((2..121).contains(&found), "{found} frames: {log}");
    assert!(log.contains(&format!("{found} frames, {} refused", 121 - found)), "{log}");
}

#[cfg(target_os = "linux")]
fn cut_off(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len() / 2);
    bytes
}

/// Sizes that are only announced take no memory, or little.
#[cfg(target_os = "linux")]
#[test]
fn announced_sizes_take_no_memory() {
    for input in [
        announced(8192, 8192),
        cut_off(announced_jpeg(8192, 8192)),
        b"YUV4MPEG2 W8192 H8192 C444\nFRAME\nabc".to_vec(),
        b"YUV4MPEG2 W1 H67108864 Cmono16\nFRAME\nabc".to_vec(),
    ] {
        let mut running = hopes("edges -").start();
        running.say(&input);
        drop(running.take_stdin());
        let mut peak = 0;
        while running.is_alive() {
            peak = peak.max(running.peak_if_alive().unwrap_or(0));
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(peak < MEMORY, "{peak}");
        running.finish().fails(1, &["nothing of the input could be used"]);
    }
}
