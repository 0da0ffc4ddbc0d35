//! README.md in parts: sections, blocks of code, recipes, rows of a table.
//!
//! In: the file. Out: its parts, as text. Invariants: what is asked for and is not there fails the test.
//! Must not know: what commands do.

/// The whole text.
pub const README: &str = include_str!("../../README.md");

/// A command with its comment.
pub struct Recipe {
    /// The comment.
    pub title: String,
    /// Its lines.
    pub commands: String,
}

/// What stands below a heading, up to the next one.
pub fn section(heading: &str) -> String {
    let (_, rest) =
        README.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("README has no {heading}"));
    rest.split("\n## ").next().expect("there is a first part").to_owned()
}

/// The blocks of code in a language.
pub fn blocks(section: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let starts = section.split(&fence).skip(1);
    starts.map(|block| block.split("```").next().expect("a block ends").to_owned()).collect()
}

/// The lines of a block that are no comments.
pub fn without_comments(block: &str) -> String {
    let lines: Vec<&str> = block.lines().filter(|line| !line.starts_with('#')).collect();
    lines.join("\n")
}

/// All recipes: they are separated by empty lines, and each begins with a comment.
pub fn recipes() -> Vec<Recipe> {
    let blocks = blocks(&section("Recipes"), "sh");
    let texts = blocks.iter().flat_map(|block| block.trim_end().split("\n\n"));
    let recipe = |text: &str| {
        let (comment, commands) = text.split_once('\n').expect("a comment and commands");
        let title = comment.strip_prefix("# ").unwrap_or_else(|| panic!("{comment:?} is no comment"));
        Recipe { title: title.to_owned(), commands: commands.to_owned() }
    };
    texts.map(recipe).collect()
}

/// The cells of the rows of a table, without its head.
pub fn rows(section: &str) -> Vec<Vec<String>> {
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    // A bar in a cell is written with a backslash.
    let cells = |row: &str| {
        let row = row.replace("\\|", "\u{0}");
        row.trim_matches('|').split('|').map(|cell| cell.trim().replace('\u{0}', "|")).collect()
    };
    rows.map(cells).collect()
}
