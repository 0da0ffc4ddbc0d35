//! The folders of vectors: names, hexadecimal digits, and writing without overwriting.
//!
//! In: file names and texts. Out: the same. Must not know: the content of the files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the vectors of a version.
pub fn folder(version: u16) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("vectors/v{version}"))
}

/// The folder of the bad vectors of a version.
pub fn bad_folder(version: u16) -> PathBuf {
    folder(version).join("bad")
}

/// The names of all files in a folder.
pub fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let entries = entries.map(|entry| entry.expect("the folder can be read"));
    let files = entries.filter(|entry| entry.file_type().expect("it has a type").is_file());
    files.map(|file| file.file_name().into_string().expect("names are ASCII")).collect()
}

/// The names of all vectors in a folder. Each vector has two files.
pub fn vectors(folder: &Path) -> Vec<String> {
    names(folder).iter().filter_map(|name| name.strip_suffix(".hex")).map(String::from).collect()
}

pub fn read(folder: &Path, name: &str) -> String {
    let path = folder.join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The bytes of a vector.
pub fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    from_hex(&read(folder, &format!("{name}.hex")))
}

/// Hexadecimal digits, 64 in a line.
pub fn hex(bytes: &[u8]) -> String {
    let line = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>() + "\n";
    bytes.chunks(32).map(line).collect()
}

pub fn from_hex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.bytes().filter(|byte| *byte != b'\n').collect();
    let pairs = digits.chunks(2).map(|pair| std::str::from_utf8(pair).expect("hexadecimal digits are ASCII"));
    pairs.map(|pair| u8::from_str_radix(pair, 16).expect("two hexadecimal digits")).collect()
}

/// Writes a file that does not exist yet.
///
/// # Errors
/// The file exists with another content: a released vector never changes.
pub fn write_once(path: &Path, text: &str) -> Result<(), String> {
    match fs::read_to_string(path) {
        Ok(there) if there == text => Ok(()),
        Ok(_) => Err(format!("{} is there and differs: vectors are never changed (vectors/README.md)", path.display())),
        Err(_) => fs::write(path, text).map_err(|error| format!("{}: {error}", path.display())),
    }
}
