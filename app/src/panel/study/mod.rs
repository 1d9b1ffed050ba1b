//! Studies: what is looked at beside the pictures or in their place.

pub mod best_map;
pub mod best_map_job;
pub mod cells;
pub mod convergence;
pub mod curves_job;
pub mod explain;
pub mod grid;
pub mod means;
pub mod parts;
pub mod plane;
pub mod plane_job;
pub mod plane_map;
pub mod plot;
pub mod pyramid;
pub mod tiles;

use mislab_renderer::{Pace, PixelRect};

use crate::picture::film_texture::FilmPipeline;
use crate::picture::live::LivePicture;
use crate::picture::reference::References;
use crate::picture::slot_errors::Measuring;
use crate::state::document::Document;
use crate::state::study::Study;

/// All studies, and which is open. What one has found stays when it is closed.
#[derive(Default)]
pub struct Studies {
    /// The one on screen.
    pub open: Option<Study>,
    /// Its state, as that of each.
    pub convergence: convergence::Convergence,
    /// See [`Self::convergence`].
    pub means: means::Means,
    /// See [`Self::convergence`].
    pub pyramid: pyramid::Pyramid,
    /// See [`Self::convergence`].
    pub grid: grid::Grid,
    /// See [`Self::convergence`].
    pub plane: plane::Plane,
    /// See [`Self::convergence`].
    pub explain: explain::Explain,
    /// See [`Self::convergence`].
    pub best_c: best_map::BestC,
}

impl Studies {
    /// Those that are not on screen render nothing.
    pub fn rest(&mut self) {
        if self.open != Some(Study::Pyramid) {
            self.pyramid.rest();
        }
        if self.open != Some(Study::Grid) {
            self.grid.rest();
        }
        if self.open != Some(Study::Plane) {
            self.plane.rest();
        }
        if self.open != Some(Study::Explain) {
            self.explain.rest();
        }
        if self.open != Some(Study::BestC) {
            self.best_c.rest();
        }
    }

    /// Back from one enlarged picture of the study to all, or from the pixel that is pinned. False if there is none.
    pub fn step_back(&mut self) -> bool {
        match self.open {
            Some(Study::Pyramid) => self.pyramid.step_back(),
            Some(Study::Grid) => self.grid.step_back(),
            Some(Study::Explain) => self.explain.step_back(),
            None | Some(Study::Convergence | Study::Means | Study::Plane | Study::BestC) => false,
        }
    }
}

/// What a study is about.
pub struct Subject<'a> {
    /// Scene and settings.
    pub document: &'a Document,
    /// The part of the pictures that was dragged out, in pixels of the full image.
    pub selected: Option<PixelRect>,
    /// A live picture for each slot of the document.
    pub pictures: &'a [LivePicture],
    /// What errors are measured against.
    pub references: &'a References,
    /// Errors and means of the pictures.
    pub measuring: &'a Measuring,
    /// Worker threads, for renderers of its own.
    pub threads: usize,
    /// How fast their passes follow each other.
    pub pace: Pace,
    /// What pictures are drawn with; `None`: on the CPU.
    pub pipeline: Option<&'a FilmPipeline>,
    /// The pixel under the mouse in any of them, in coordinates of the full image.
    pub cursor: Option<[u32; 2]>,
}
