//! The files of the page, which are part of the program.
//!
//! In: a path. Out: a file, its kind and its version. Invariants: whatever lies in `page/` is served, and nothing
//! else. Must not know: what the files do.

use std::hash::{DefaultHasher, Hash, Hasher};

/// Name and contents of each file.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_bytes!(concat!("page/", $name)))),*]
    };
}

const FILES: &[(&str, &[u8])] = files![
    "bounds.js",
    "bytes.js",
    "camera.js",
    "canvas.js",
    "checksum.js",
    "colors.js",
    "connection.js",
    "controls.js",
    "cycles.js",
    "diagram.js",
    "elements.js",
    "frames.js",
    "gl.js",
    "history.js",
    "index.html",
    "lifelines.js",
    "lives.js",
    "looks.js",
    "main.js",
    "mirror.js",
    "painter.js",
    "plane.js",
    "protocol.js",
    "raster.js",
    "session.js",
    "sketch.js",
    "slots.js",
    "status.js",
    "strips.js",
    "style.css",
    "tracks.js"
];

/// What kind of file has such a name.
fn kind(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

/// A file.
#[derive(Debug)]
pub struct Asset {
    name: &'static str,
    /// What kind it is of.
    pub kind: &'static str,
    /// What stands in it.
    pub body: &'static [u8],
    /// Its version: another one where it differs.
    pub tag: String,
}

/// All of them.
#[derive(Debug)]
pub struct Assets(Vec<Asset>);

impl Assets {
    /// Those that were there when the program was made.
    pub fn new() -> Self {
        let asset = |&(name, body): &(&'static str, &'static [u8])| {
            let mut hasher = DefaultHasher::new();
            body.hash(&mut hasher);
            Asset { name, kind: kind(name), body, tag: format!("\"{:016x}\"", hasher.finish()) }
        };
        Self(FILES.iter().map(asset).collect())
    }

    /// The file at a path; the page itself is at `/`.
    pub fn get(&self, path: &str) -> Option<&Asset> {
        let name = path.strip_prefix('/')?;
        let name = if name.is_empty() { "index.html" } else { name };
        self.0.iter().find(|asset| asset.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_page_is_served() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/view/page");
        let assets = Assets::new();
        let names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        for name in &names {
            let asset = assets.get(&format!("/{name}")).unwrap_or_else(|| panic!("{name} stands in no list here"));
            assert_eq!(asset.body, std::fs::read(format!("{folder}/{name}")).unwrap(), "{name}");
        }
        assert_eq!(names.len(), FILES.len());
        assert_eq!(assets.get("/").unwrap().name, "index.html");
    }

    #[test]
    fn the_page_asks_nobody_else_and_runs_only_its_own_files() {
        for asset in Assets::new().0 {
            let text = str::from_utf8(asset.body).unwrap();
            for word in ["https://", "//cdn", "eval(", "onclick=", "style=\"", "javascript:"] {
                assert!(!text.contains(word), "{} has {word}", asset.name);
            }
        }
    }
}
