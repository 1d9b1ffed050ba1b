//! Where things stand in the scene files, and what is to be said about them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Diagnostic, Error, Location};

/// A byte in one of the files read. Cheap to keep; becomes a line and column only when needed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pos {
    /// Index into [`Log::sources`].
    pub source: u32,
    /// Byte offset in its text.
    pub offset: u32,
}

struct Source {
    name: Arc<str>,
    text: Arc<str>,
}

/// All texts read so far, all files looked for and all warnings given so far.
#[derive(Default)]
pub(super) struct Log {
    sources: Vec<Source>,
    files: Vec<PathBuf>,
    warnings: Vec<Diagnostic>,
    said: HashSet<String>,
}

impl Log {
    /// Enough for any honest file; more would only bury the first.
    const MAX_WARNINGS: usize = 100;

    /// Registers a text, so that positions in it can be named.
    pub fn add_source(&mut self, name: &str, text: Arc<str>) -> u32 {
        self.sources.push(Source { name: Arc::from(name), text });
        (self.sources.len() - 1) as u32
    }

    /// Remembers a file that the scene depends on, there or not.
    pub fn add_file(&mut self, path: &Path) {
        if !self.files.iter().any(|known| known == path) {
            self.files.push(path.to_owned());
        }
    }

    /// The files remembered, in the order they were asked for.
    pub fn take_files(&mut self) -> Vec<PathBuf> {
        std::mem::take(&mut self.files)
    }

    /// File, line and column of a position. A tab is one column, CRLF one line end.
    pub fn locate(&self, pos: Pos) -> Location {
        let source = &self.sources[pos.source as usize];
        let before = source.text.get(..pos.offset as usize).unwrap_or(&source.text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = before.bytes().filter(|&b| b == b'\n').count() as u32 + 1;
        // A byte order mark is not a column.
        let column = before[line_start..].chars().filter(|&c| c != '\u{feff}').count() as u32 + 1;
        Location { file: source.name.clone(), line, column }
    }

    /// An error at a position.
    pub fn error(&self, pos: Pos, message: impl Into<String>) -> Error {
        Error::Scene(Diagnostic { location: self.locate(pos), message: message.into() })
    }

    /// True if a warning with that key would not be shown again.
    pub fn has_said(&self, key: &str) -> bool {
        self.warnings.len() > Self::MAX_WARNINGS || self.said.contains(key)
    }

    /// Warns unless something with the same key was said before.
    pub fn warn_once(&mut self, key: &str, pos: Pos, message: impl Into<String>) {
        if self.has_said(key) {
            return;
        }
        let message = if self.warnings.len() == Self::MAX_WARNINGS {
            "more warnings are left out".to_owned()
        } else {
            self.said.insert(key.to_owned());
            message.into()
        };
        self.warnings.push(Diagnostic { location: self.locate(pos), message });
    }

    /// Warns unless the same was said before.
    pub fn warn(&mut self, pos: Pos, message: impl Into<String>) {
        let message = message.into();
        self.warn_once(&message.clone(), pos, message);
    }

    /// The warnings, in the order given.
    pub fn take_warnings(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.warnings)
    }
}

/// Text from a file, fit for a one-line message: quoted, short, without control characters.
pub(super) fn shown(text: &str) -> String {
    const MAX: usize = 40;
    let mut out = String::from("\"");
    for (i, c) in text.chars().enumerate() {
        if i == MAX {
            out.push_str("...");
            break;
        }
        out.push(if c.is_whitespace() {
            ' '
        } else if c.is_control() {
            '?'
        } else {
            c
        });
    }
    out.push('"');
    out
}

/// ` (did you mean "x"?)` for the candidate that differs from `word` by case or at most two letters, else nothing.
pub(super) fn suggestion(word: &str, candidates: &[&str]) -> String {
    if word.len() > 40 {
        return String::new();
    }
    let lower = word.to_lowercase();
    let allowed = if word.len() < 5 { 1 } else { 2 };
    candidates
        .iter()
        .map(|c| (edit_distance(&lower, &c.to_lowercase()), c))
        .filter(|(d, _)| *d <= allowed)
        .min_by_key(|(d, _)| *d)
        .map_or_else(String::new, |(_, c)| format!(" (did you mean \"{c}\"?)"))
}

/// Levenshtein distance, one row at a time.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
