//! Video on stdin: YUV4MPEG2 of every kind, and raw gray frames.

use serde_json::Value;

use crate::common::process::hopes;
use crate::{Gray, column, frames};

/// Three frames with a step at different columns.
fn steps() -> [Gray; 3] {
    [5, 8, 12].map(|at| Gray::step(18, 7, at, 200))
}

/// A video of frames: the rest of its header, and the bytes after the luma of each frame.
fn video(header: &str, colours: &[u8], frames: &[Gray]) -> Vec<u8> {
    let mut bytes = format!("YUV4MPEG2 W{} H{} {header}\n", frames[0].width, frames[0].height).into_bytes();
    for frame in frames {
        bytes.extend(b"FRAME\n");
        bytes.extend(&frame.pixels);
        bytes.extend(colours);
    }
    bytes
}

/// The frame with samples of `bits` bits, in two bytes each.
fn deep(frame: &Gray, bits: u32) -> Gray {
    let pixels = frame.pixels.iter().flat_map(|&pixel| (u16::from(pixel) << (bits - 8) | 1).to_le_bytes()).collect();
    Gray { pixels, ..*frame }
}

fn expected() -> Vec<Vec<[u32; 2]>> {
    [4, 7, 11].map(|x| column(x, 0..7)).into()
}

#[test]
fn every_layout_gives_the_same_edges() {
    // 18 x 7: colours of 4:2:0 have 9 x 4 samples a plane.
    for (header, colours) in [
        ("F25:1", 2 * 9 * 4),
        ("F25:1 Ip A1:1 C420mpeg2 XYSCSS=420MPEG2", 2 * 9 * 4),
        ("C420jpeg XCOLORRANGE=FULL", 2 * 9 * 4),
        ("C420paldv", 2 * 9 * 4),
        ("C422", 2 * 9 * 7),
        ("C411", 2 * 5 * 7),
        ("C440", 2 * 18 * 4),
        ("C444", 2 * 18 * 7),
        ("C444alpha", 3 * 18 * 7),
        ("Cmono", 0),
        ("Cmono XCOLORRANGE=LIMITED", 0),
    ] {
        let input = video(header, &vec![77; colours], &steps());
        assert_eq!(frames(&hopes("edges -").reads(input).text()), expected(), "{header}");
    }
    for (header, bits, colours) in [("C420p10", 10, 4 * 9 * 4), ("C444p16", 16, 4 * 18 * 7), ("Cmono12", 12, 0)] {
        let input = video(header, &vec![77; colours], &steps().map(|frame| deep(&frame, bits)));
        assert_eq!(frames(&hopes("edges -").reads(input).text()), expected(), "{header}");
    }
    let raw = steps().map(|frame| frame.pixels).concat();
    assert_eq!(frames(&hopes("edges - --size 18x7").reads(&raw).text()), expected());
    assert_eq!(frames(&hopes("edges - --size 18x7 --input gray").reads(&raw).text()), expected());
    assert_eq!(frames(&hopes("edges - --input y4m").reads(video("Cmono", &[], &steps())).text()), expected());
}

#[test]
fn frame_headers_may_have_parameters() {
    let frame = Gray::step(6, 2, 3, 200);
    let mut input = b"YUV4MPEG2 W6 H2 Cmono\nFRAME It XSOMETHING=1\n".to_vec();
    input.extend(frame.pixels);
    assert_eq!(frames(&hopes("edges -").reads(input).text()), [column(2, 0..2)]);
}

#[test]
fn limited_luma_is_stretched() {
    // A step from 16 to 126 has a gradient of 440, and of 512 when it is stretched.
    let pixels = (0..10 * 4).map(|at| if at % 10 < 5 { 16 } else { 126 }).collect();
    let frame = Gray { width: 10, height: 4, pixels };
    let count = |arguments: &str, header: &str| {
        let colours = if header.contains("mono") { 0 } else { 2 * 5 * 2 };
        let input = video(header, &vec![128; colours], std::slice::from_ref(&frame));
        frames(&hopes("edges -").and(arguments).reads(input).text())[0].len()
    };
    assert_eq!(count("", "C420jpeg"), 4);
    assert_eq!(count("", "C420jpeg XCOLORRANGE=FULL"), 0);
    assert_eq!(count("--range full", "C420jpeg"), 0);
    assert_eq!(count("--range limited", "C420jpeg XCOLORRANGE=FULL"), 4);
    assert_eq!(count("", "Cmono"), 0);
    assert_eq!(count("", "Cmono XCOLORRANGE=LIMITED"), 4);
    assert_eq!(count("--low 128 --high 512", "C420jpeg"), 0, "512 is not above 512");
    assert_eq!(count("--low 128 --high 511", "C420jpeg"), 4);
    let raw =
        |arguments: &str| frames(&hopes("edges - --size 10x4").and(arguments).reads(&frame.pixels).text())[0].len();
    assert_eq!([raw(""), raw("--range limited")], [0, 4]);
}

#[test]
fn times_are_those_of_the_video() {
    let times = |arguments: &str, header: &str| {
        let text = hopes("edges - --format jsonl").and(arguments).reads(video(header, &[], &steps())).text();
        let commits = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let times: Vec<_> = commits.filter(|line| line["commit"] == true).map(|line| line["time"].as_f64()).collect();
        times
    };
    assert_eq!(times("", "Cmono F50:2"), [Some(0.0), Some(0.04), Some(0.08)]);
    assert_eq!(times("--rate 1000", "Cmono F30000:1001")[1], Some(1001.0 / 30_000.0));
    assert_eq!(times("--rate 1000", "Cmono F0:0"), [Some(0.0), Some(0.001), Some(0.002)]);
    assert_eq!(times("", "Cmono"), [None; 3]);
}

#[test]
fn a_frame_is_written_as_soon_as_it_has_arrived() {
    let mut running = hopes("edges -").start();
    let video = video("Cmono", &[], &steps());
    let (first, rest) = video.split_at(video.len() - 2 * (6 + 18 * 7));
    running.say(first);
    let lines: Vec<_> = (0..8).map(|_| running.line().unwrap()).collect();
    assert_eq!(frames(&(lines.join("\n") + "\n")), expected()[..1]);
    running.say(rest);
    assert_eq!(frames(&running.finish().text()), expected()[1..]);
}
