//! Small streams as protocol messages with correct checksums, and recordings of them.

use std::time::Duration;

use hopes_protocol::{
    Banner, Cause, Checksum, Critical, Cut, Diff, Dot, Dots, Edge, Elapsed, FILE_VERSION, FrameInfo, Message, Simplify,
    Snapshot, StreamOpened, VERSION, Vertex, View, Window, encode,
};

/// The default view of clients.
pub const VIEW: View = View { cut: Cut::Derived(1, 1), simplify: Simplify::No };

/// A stream that gets one vertex, and the edge to it, in each frame.
#[derive(Clone)]
pub struct GrowingStream {
    pub stream: u32,
    pub number: u64,
    vertices: Vec<Vertex>,
    edges: Vec<Edge>,
    critical: Vec<Critical>,
    checksum: Checksum,
}

impl GrowingStream {
    /// The stream at frame 1, with one vertex.
    pub fn new(stream: u32) -> Self {
        let mut scene = Self {
            stream,
            number: 0,
            vertices: Vec::new(),
            edges: Vec::new(),
            critical: Vec::new(),
            checksum: Checksum::default(),
        };
        scene.step();
        scene
    }

    /// Goes to the next frame.
    fn step(&mut self) {
        let id = self.number;
        self.number += 1;
        self.vertices.push((id, id as f64, 0.5));
        self.checksum.add((id, id as f64, 0.5));
        if id > 0 {
            self.edges.push((id - 1, id));
            self.checksum.add((id - 1, id));
        }
    }

    pub fn opened(&self, name: &str, epoch: u64) -> Message {
        let (stream, name, frame) = (self.stream, name.to_owned(), self.number);
        StreamOpened { stream, name, epoch, window: Window::All, resolution: None, frame }.into()
    }

    pub fn frame(&self) -> FrameInfo {
        FrameInfo {
            number: self.number,
            time: Some(self.number as f64 / 2.0),
            points: self.vertices.len() as u64,
            vertices: self.vertices.len() as u64,
            rejected: 0,
            view: VIEW,
            ds: None,
            vs: None,
            components: 1,
            cycles: 0,
        }
    }

    pub fn snapshot(&self, cause: Cause) -> Message {
        let (vertices, edges, critical) = (self.vertices.clone(), self.edges.clone(), self.critical.clone());
        let (frame, checksum) = (self.frame(), self.checksum.0);
        Snapshot { stream: self.stream, cause, frame, vertices, edges, critical, checksum }.into()
    }

    /// The diff to the next frame.
    pub fn diff(&mut self) -> Message {
        let (from, edges) = (self.number, self.edges.len());
        self.step();
        Diff {
            stream: self.stream,
            from,
            frame: self.frame(),
            vertices_added: self.vertices[from as usize..].to_vec(),
            vertices_removed: Vec::new(),
            edges_added: self.edges[edges..].to_vec(),
            edges_removed: Vec::new(),
            critical_set: Vec::new(),
            critical_removed: Vec::new(),
            checksum: self.checksum.0,
        }
        .into()
    }

    /// The diff to the next frame, with a wrong checksum.
    pub fn wrong_diff(&mut self) -> Message {
        match self.diff() {
            Message::Diff(diff) => Diff { checksum: !diff.checksum, ..diff }.into(),
            other => other,
        }
    }

    pub fn dots(&self) -> Message {
        let dot = Dot { edge: (0, 1), birth: 0.5, death: 2.0, center: (1.0, 1.0), radius: 2.0 };
        Dots { stream: self.stream, frame: self.number, total: 7, dots: vec![dot] }.into()
    }
}

/// A recording: messages and their times.
pub fn recording(messages: &[(Duration, Message)]) -> Vec<u8> {
    recording_in(FILE_VERSION, messages)
}

/// The same in another version.
pub fn recording_in(version: u16, messages: &[(Duration, Message)]) -> Vec<u8> {
    let mut bytes = Banner { lowest: version, highest: version }.encode().to_vec();
    for (elapsed, message) in messages {
        let elapsed = Elapsed { nanoseconds: elapsed.as_nanos() as u64 };
        bytes.extend(encode(version, 0, &elapsed.into()).unwrap());
        bytes.extend(encode(version, 1, message).unwrap());
    }
    bytes
}

/// The frames of messages after a banner.
pub fn frames(messages: &[Message]) -> Vec<u8> {
    let mut bytes = Banner { lowest: VERSION, highest: VERSION }.encode().to_vec();
    for message in messages {
        bytes.extend(encode(VERSION, 3, message).unwrap());
    }
    bytes
}
