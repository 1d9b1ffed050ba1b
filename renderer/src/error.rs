//! What can go wrong, said once: where, what was found, what was expected.

use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_kernel::request::Invalid;

use crate::near::no_such_file;

/// A place in a text file. Lines and columns count from 1; columns count characters.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Location {
    /// The file, as the user named it.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// One message about a place in a scene file, an error or a warning by context.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Where.
    pub location: Location,
    /// What was found and what was expected.
    pub message: String,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.location, self.message)
    }
}

/// Any failure of this library. Its text is one line, fit for a terminal and for a panel.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file that cannot be read as pbrt.
    #[error("{0}")]
    Scene(Diagnostic),
    /// The operating system refused a file.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: "read", "save" ...
        action: &'static str,
        /// Why not.
        source: std::io::Error,
    },
    /// A file whose content is not what its name or header claims.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was found and what was expected.
        message: String,
    },
    /// A scene or setting that cannot be rendered.
    #[error("{0}")]
    Invalid(String),
}

impl From<Invalid> for Error {
    fn from(Invalid(message): Invalid) -> Self {
        Self::Invalid(message)
    }
}

impl Error {
    /// An [`Error::Io`] about `path`. Of a file to read that is missing it says where it was looked for, and what is
    /// there of a similar name.
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        let missing = action == "read" && source.kind() == ErrorKind::NotFound;
        let source = if missing { std::io::Error::new(ErrorKind::NotFound, no_such_file(path)) } else { source };
        Self::Io { path: path.to_owned(), action, source }
    }

    /// An [`Error::File`] about `path`.
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        Self::File { path: path.to_owned(), message: message.into() }
    }
}
