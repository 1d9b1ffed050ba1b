//! Where things stand in the scene files, and what is to be said about them.

use std::cell::Cell;
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
    /// The last place asked for: most are asked for in the order of the file, which may be long.
    last: Cell<Mark>,
}

/// A line and column, from 1, and where they are.
#[derive(Clone, Copy)]
struct Mark {
    offset: usize,
    line: u32,
    column: u32,
}

impl Mark {
    const START: Self = Self { offset: 0, line: 1, column: 1 };
}

struct Warning {
    diagnostic: Diagnostic,
    /// What it says about a file of pbrt-v4, see [`Log::warn_dialect`].
    dialect: Option<String>,
}

/// All texts read so far, all files looked for and all warnings given so far.
#[derive(Default)]
pub(super) struct Log {
    sources: Vec<Source>,
    files: Vec<PathBuf>,
    warnings: Vec<Warning>,
    said: HashSet<String>,
    /// Something was found that only files of pbrt-v4 have.
    is_v4: bool,
}

impl Log {
    /// Enough for any honest file; more would only bury the first.
    const MAX_WARNINGS: usize = 100;

    /// Registers a text, so that positions in it can be named.
    pub fn add_source(&mut self, name: &str, text: Arc<str>) -> u32 {
        self.sources.push(Source { name: Arc::from(name), text, last: Cell::new(Mark::START) });
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
        let offset = pos.offset as usize;
        let mut mark = Some(source.last.get()).filter(|last| last.offset <= offset).unwrap_or(Mark::START);
        for c in source.text.get(mark.offset..offset).unwrap_or_default().chars() {
            if c == '\n' {
                mark = Mark { line: mark.line + 1, column: 1, ..mark };
            } else if c != '\u{feff}' {
                // A byte order mark is not a column.
                mark.column += 1;
            }
        }
        source.last.set(Mark { offset, ..mark });
        Location { file: source.name.clone(), line: mark.line, column: mark.column }
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
        if !self.has_said(key) {
            let location = self.locate(pos);
            self.push(key, Diagnostic { location, message: message.into() }, None);
        }
    }

    /// Warns unless the same was said before.
    pub fn warn(&mut self, pos: Pos, message: impl Into<String>) {
        let message = message.into();
        self.warn_once(&message.clone(), pos, message);
    }

    /// Warns of what is wrong with one item of the scene, and says what happens `instead` of refusing the scene. What is
    /// no matter of a place in the scene is still an error.
    pub fn leave_out(&mut self, error: Error, instead: &str) -> Result<(), Error> {
        let Error::Scene(Diagnostic { location, message }) = error else { return Err(error) };
        let message = format!("{message}; {instead}");
        if !self.has_said(&message) {
            self.push(&message.clone(), Diagnostic { location, message }, None);
        }
        Ok(())
    }

    /// Warns of something that other versions of pbrt have and pbrt-v3 has not. In a file of pbrt-v4 all of these make one
    /// warning, in which this is called `short`.
    pub fn warn_dialect(&mut self, pos: Pos, message: impl Into<String>, short: impl Into<String>) {
        let message = message.into();
        if !self.has_said(&message) {
            let location = self.locate(pos);
            self.push(&message.clone(), Diagnostic { location, message }, Some(short.into()));
        }
    }

    /// Notes that the file is one of pbrt-v4.
    pub fn found_v4(&mut self) {
        self.is_v4 = true;
    }

    fn push(&mut self, key: &str, mut diagnostic: Diagnostic, dialect: Option<String>) {
        if self.warnings.len() == Self::MAX_WARNINGS {
            "more warnings are left out".clone_into(&mut diagnostic.message);
        } else {
            self.said.insert(key.to_owned());
        }
        self.warnings.push(Warning { diagnostic, dialect });
    }

    /// The warnings, in the order given.
    pub fn take_warnings(&mut self) -> Vec<Diagnostic> {
        let mut warnings = std::mem::take(&mut self.warnings);
        if self.is_v4 {
            let differences: Vec<String> = warnings.iter().filter_map(|w| w.dialect.clone()).collect();
            let message =
                format!("a file of pbrt-v4, read with these differences as pbrt-v3: {}", differences.join(", "));
            if let Some(first) = warnings.iter_mut().find(|w| w.dialect.is_some()) {
                first.diagnostic.message = message;
                first.dialect = None;
            }
            warnings.retain(|w| w.dialect.is_none());
        }
        warnings.into_iter().map(|w| w.diagnostic).collect()
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
