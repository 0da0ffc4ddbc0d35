//! The files of the page, which are part of the program.
//!
//! In: the path of a request.
//! Out: a file, its media type and its version.
//! Invariants: the files in `page/` and its folders are served, and nothing else.
//! Must not know: what the files do.

use std::hash::{DefaultHasher, Hash, Hasher};

/// Path and contents of each file.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_bytes!(concat!("page/", $name)))),*]
    };
}

const FILES: &[(&str, &[u8])] = files![
    "drawing/bounds.js",
    "drawing/camera.js",
    "drawing/canvas.js",
    "drawing/colors.js",
    "drawing/indices.js",
    "drawing/layers.js",
    "drawing/picking.js",
    "drawing/raster.js",
    "drawing/renderer.js",
    "drawing/software_renderer.js",
    "drawing/strips.js",
    "drawing/styles.js",
    "drawing/webgl.js",
    "drawing/webgl_renderer.js",
    "index.html",
    "main.js",
    "panels/controls.js",
    "panels/crowds.js",
    "panels/diagram.js",
    "panels/numbers.js",
    "panels/ruler.js",
    "panels/spaces.js",
    "panels/status.js",
    "panels/timeline.js",
    "projection/linear.js",
    "projection/orientation.js",
    "projection/places.js",
    "projection/principal.js",
    "projection/projection.js",
    "projection/vertices.js",
    "session/assembly.js",
    "session/bytes.js",
    "session/checksum.js",
    "session/connection.js",
    "session/dots.js",
    "session/elements.js",
    "session/frames.js",
    "session/history.js",
    "session/lifetimes.js",
    "session/mirror.js",
    "session/protocol.js",
    "session/session.js",
    "session/spaces.js",
    "session/tracks.js",
    "style.css"
];

/// The media type of a file.
fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

/// A file of the page.
#[derive(Debug)]
pub struct Asset {
    name: &'static str,
    /// Its media type.
    pub media_type: &'static str,
    /// Its contents.
    pub body: &'static [u8],
    /// Its entity tag, derived from the contents.
    pub tag: String,
}

/// All files of the page.
#[derive(Debug)]
pub struct Assets(Vec<Asset>);

impl Assets {
    /// The files of which the program was built.
    pub fn new() -> Self {
        let asset = |&(name, body): &(&'static str, &'static [u8])| {
            let mut hasher = DefaultHasher::new();
            body.hash(&mut hasher);
            Asset { name, media_type: media_type(name), body, tag: format!("\"{:016x}\"", hasher.finish()) }
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
    use std::path::{Path, PathBuf};

    use super::*;

    fn files_below(folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries.flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect()
    }

    #[test]
    fn every_file_of_the_page_is_served() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/view/page");
        let assets = Assets::new();
        let paths = files_below(Path::new(folder));
        for path in &paths {
            let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
            let asset = assets.get(&format!("/{name}")).unwrap_or_else(|| panic!("{name} is missing in FILES"));
            assert_eq!(asset.body, std::fs::read(path).unwrap(), "{name}");
        }
        assert_eq!(paths.len(), FILES.len());
        assert_eq!(assets.get("/").unwrap().name, "index.html");
        for path in ["", "session", "/session", "/session/", "/session.js", "/session/../main.js", "//main.js"] {
            assert!(assets.get(path).is_none(), "{path}");
        }
    }

    #[test]
    fn the_page_loads_and_runs_nothing_but_its_own_files() {
        for asset in Assets::new().0 {
            let text = str::from_utf8(asset.body).unwrap();
            for word in ["https://", "//cdn", "eval(", "onclick=", "style=\"", "javascript:"] {
                assert!(!text.contains(word), "{} has {word}", asset.name);
            }
        }
    }
}
