//! Why a command did not do what it was asked for, and the exit code for it.

/// Why a command did not do what it was asked for.
#[derive(Debug)]
pub(super) enum Failure {
    /// It could not be done: exit code 1.
    Run(String),
    /// It should not have been asked for: exit code 2.
    Usage(String),
}

impl From<mislab_renderer::Error> for Failure {
    fn from(error: mislab_renderer::Error) -> Self {
        Self::Run(error.to_string())
    }
}
