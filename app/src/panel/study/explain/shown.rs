//! What the parts of the explanation are about.

use mislab_renderer::Estimator;

use super::place::{Place, Surface};
use super::samples::Samples;
use crate::state::document::Document;

/// What the tabs of a surface need to know.
pub struct Shown<'a> {
    /// The pixel.
    pub place: &'a Place,
    /// Its surface.
    pub surface: &'a Surface,
    /// Of the active picture.
    pub estimator: Estimator,
    /// Its samples, as far as they are replayed.
    pub samples: Option<&'a Samples>,
    /// What edits are made to.
    pub document: &'a Document,
}
