//! From files to edges, one picture or frame after the other.
//!
//! In: files, or stdin.
//! Out: [`Found`]: the edge pixels of each picture and frame, or why one cannot be used.
//! Invariants: pictures and frames come in order. They are counted whether they can be used or not, so that one
//! that cannot does not shift the times of others. Memory is bounded by the largest one. A sink that returns false
//! ends it.
//! Must not know: where edges go.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use hopes::edges::{Detector, View, ViewError};
use thiserror::Error;

use super::decode::{self, JPEG, PNG};
use super::files::STDIN;
use super::image::GrayImage;
use super::video::{MAGIC, Range, Size, Video, VideoError};

/// What comes of a picture or a frame.
#[derive(Debug)]
pub enum Found {
    /// Its edges.
    Frame {
        /// Pixels on edges.
        points: Vec<[u32; 2]>,
        /// Seconds since the first frame, if the rate is known.
        time: Option<f64>,
    },
    /// Nothing, with where and why.
    Bad(String),
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputForm {
    /// A picture a file: PNG or JPEG.
    Images,
    /// Video: YUV4MPEG2.
    Y4m,
    /// Video: bare frames of gray pixels, of the size of --size.
    Gray,
}

/// How edges are found.
#[derive(Clone, Debug)]
pub struct Finder {
    pub detector: Detector,
    /// Only there: a column and a row, and how many of each.
    pub part: Option<[u32; 4]>,
    /// Rows are counted from the bottom.
    pub y_up: bool,
    /// Frames a second, for event times, where a video does not say it.
    pub rate: Option<f64>,
    /// What files hold; none: by their first bytes.
    pub input: Option<InputForm>,
    /// Of bare frames.
    pub size: Option<Size>,
    /// Of luma; none: as the video says.
    pub range: Option<Range>,
}

/// No picture and no frame of the input could be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("nothing of the input could be used")]
pub struct NothingUsed;

/// The sink takes no more.
struct Closed;

impl Finder {
    /// Finds the edges of all files in turn. After each file, `file_done` is called.
    ///
    /// # Errors
    /// [`NothingUsed`].
    pub fn run(
        self,
        files: &[PathBuf],
        sink: &mut dyn FnMut(Found) -> bool,
        file_done: &dyn Fn(),
    ) -> Result<(), NothingUsed> {
        let mut search = Search { finder: self, sink, seen: 0, used: 0 };
        for file in files {
            if let Err(Closed) = search.file(file) {
                return Ok(());
            }
            file_done();
        }
        if search.used == 0 && search.seen > 0 { Err(NothingUsed) } else { Ok(()) }
    }
}

/// A pass through files.
struct Search<'a> {
    finder: Finder,
    sink: &'a mut dyn FnMut(Found) -> bool,
    /// Pictures and frames so far.
    seen: u64,
    /// Those of them that could be used.
    used: u64,
}

impl Search<'_> {
    fn file(&mut self, file: &Path) -> Result<(), Closed> {
        let (name, source): (_, Box<dyn Read>) = if file == Path::new(STDIN) {
            ("stdin".to_owned(), Box::new(io::stdin().lock()))
        } else {
            match File::open(file) {
                Ok(opened) => (file.display().to_string(), Box::new(opened)),
                Err(error) => return self.refuse(&file.display(), &format_args!("cannot open it: {error}")),
            }
        };
        let mut source = BufReader::with_capacity(1 << 16, source);
        // A pipe may bring its first bytes one by one.
        let mut first = Vec::new();
        if let Err(error) = source.by_ref().take(MAGIC.len() as u64).read_to_end(&mut first) {
            return self.refuse(&name, &format_args!("cannot read it: {error}"));
        }
        let form = self.form(&first);
        let source = Cursor::new(first).chain(source);
        match (form, self.finder.size) {
            (Some(InputForm::Images), _) => self.picture(&name, source),
            (Some(InputForm::Y4m), _) => self.video(&name, Video::yuv4mpeg(source, self.finder.range)),
            (Some(InputForm::Gray), Some(size)) => self.video(&name, Video::raw(source, size, self.finder.range)),
            _ => self.refuse(
                &name,
                &"it is neither PNG, JPEG nor YUV4MPEG2; if it is bare gray frames, say how large they are: --size WxH",
            ),
        }
    }

    fn form(&self, first: &[u8]) -> Option<InputForm> {
        let by_content = || match first {
            _ if first.starts_with(PNG) || first.starts_with(JPEG) => Some(InputForm::Images),
            _ if first == MAGIC => Some(InputForm::Y4m),
            _ => None,
        };
        self.finder.input.or(self.finder.size.map(|_| InputForm::Gray)).or_else(by_content)
    }

    fn picture(&mut self, name: &str, source: impl Read) -> Result<(), Closed> {
        match decode::read(source) {
            Err(error) => self.refuse(name, &error),
            Ok(picture) => match self.edges(&picture) {
                Err(error) => self.refuse(name, &error),
                Ok(points) => self.found(points, self.finder.rate),
            },
        }
    }

    fn video(&mut self, name: &str, video: Result<Video<impl BufRead>, VideoError>) -> Result<(), Closed> {
        let mut video = match video {
            Ok(video) => video,
            Err(error) => return self.refuse(name, &error),
        };
        let rate = video.rate().or(self.finder.rate);
        let mut frame = GrayImage::default();
        loop {
            match video.next(&mut frame) {
                Ok(false) => return Ok(()),
                Err(error) => return self.refuse(name, &error),
                Ok(true) => match self.edges(&frame) {
                    Ok(points) => self.found(points, rate)?,
                    // All frames are of one size, so none will do.
                    Err(error) => return self.refuse(name, &error),
                },
            }
        }
    }

    fn edges(&mut self, picture: &GrayImage) -> Result<Vec<[u32; 2]>, ViewError> {
        let Finder { detector, part, y_up, .. } = &mut self.finder;
        let whole = View::new(&picture.pixels, picture.width, picture.height)?;
        let [left, top, ..] = part.unwrap_or_default();
        let seen = part.map_or(Ok(whole), |part| whole.part(part))?;
        let place = |&[x, y]: &[u32; 2]| {
            let (x, y) = (left + x, top + y);
            [x, if *y_up { picture.height - 1 - y } else { y }]
        };
        Ok(detector.edges(seen).iter().map(place).collect())
    }

    fn found(&mut self, points: Vec<[u32; 2]>, rate: Option<f64>) -> Result<(), Closed> {
        let time = rate.map(|rate| self.seen as f64 / rate);
        self.seen += 1;
        self.used += 1;
        self.send(Found::Frame { points, time })
    }

    fn refuse(&mut self, name: &(impl Display + ?Sized), reason: &dyn Display) -> Result<(), Closed> {
        self.seen += 1;
        self.send(Found::Bad(format!("{name}: {reason}")))
    }

    fn send(&mut self, found: Found) -> Result<(), Closed> {
        if (self.sink)(found) { Ok(()) } else { Err(Closed) }
    }
}
