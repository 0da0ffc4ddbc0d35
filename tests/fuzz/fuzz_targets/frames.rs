//! The banner and the frames in a stream of bytes: however the stream is cut, the decoder finds the same, and what it
//! finds is what the bytes say.
//!
//! The input: a byte for options, four lengths of pieces, the stream.
#![no_main]

use hopes_fuzz::pieces::Pieces;
use hopes_fuzz::wire::mended;
use hopes_protocol::{Banner, Decoder, Frame, FrameError, header};
use libfuzzer_sys::fuzz_target;

/// All that a decoder finds.
#[derive(Debug, PartialEq)]
struct Found {
    banner: Option<Banner>,
    frames: Vec<Frame>,
    error: Option<FrameError>,
    offset: u64,
    is_within_frame: bool,
}

fuzz_target!(|data: &[u8]| {
    let Some((options, data)) = data.split_first() else { return };
    let Some((pieces, wire)) = Pieces::of(data) else { return };
    let largest = if options & 1 == 0 { u32::MAX } else { 100 };
    if options & 2 == 0 {
        let wire = mended(wire);
        check(pieces.over(&wire), &wire, largest);
    } else {
        check(pieces, wire, largest);
    }
});

fn check(pieces: Pieces<'_>, wire: &[u8], largest: u32) {
    let found = find([wire].into_iter(), largest);
    let (decoded, rest) = wire.split_at(found.offset as usize);
    let mut written = written(&found);
    // Four bytes of a banner are ignored, and its CRC counts them.
    written.iter_mut().zip(decoded).take(Banner::LENGTH).skip(12).for_each(|(byte, sent)| *byte = *sent);
    assert_eq!(written, decoded, "{found:?}");
    assert_eq!(found.is_within_frame, !rest.is_empty(), "{found:?}");
    assert_eq!(found, find(pieces, largest));
}

fn find<'a>(mut pieces: impl Iterator<Item = &'a [u8]>, largest: u32) -> Found {
    let mut decoder = Decoder::new(largest);
    let (mut banner, mut frames, mut error) = (None, Vec::new(), None);
    for piece in pieces.by_ref() {
        decoder.push(piece);
        error = take(&mut decoder, &mut banner, &mut frames).err();
        if let Some(error) = error {
            let again = take(&mut decoder, &mut banner, &mut frames);
            assert_eq!(again, Err(error), "nothing more can be read after an error");
            break;
        }
    }
    pieces.for_each(|piece| decoder.push(piece));
    Found { banner, frames, error, offset: decoder.offset(), is_within_frame: decoder.is_within_frame() }
}

fn take(decoder: &mut Decoder, banner: &mut Option<Banner>, frames: &mut Vec<Frame>) -> Result<(), FrameError> {
    if banner.is_none() {
        *banner = decoder.banner()?;
        let Some(theirs) = banner else { return Ok(()) };
        if let Ok(version) = Banner::OURS.agree(*theirs) {
            assert!((theirs.lowest..=theirs.highest).contains(&version));
            decoder.set_version(version);
        }
    }
    while let Some(frame) = decoder.frame()? {
        frames.push(frame);
    }
    Ok(())
}

/// The bytes of all that was found.
fn written(found: &Found) -> Vec<u8> {
    let mut bytes: Vec<u8> = found.banner.iter().flat_map(|banner| banner.encode()).collect();
    for Frame { version, channel, kind, body } in &found.frames {
        bytes.extend(header(*version, *kind, *channel, body.len() as u32));
        bytes.extend(body);
        bytes.extend(crc32c::crc32c(body).to_le_bytes());
    }
    bytes
}
