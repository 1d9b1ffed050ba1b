//! The pixel that is explained before anybody has pointed at one: a highlight in the middle of the picture.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::Scene;
use mislab_renderer::plane::Square;
use mislab_renderer::projection::Projector;

use crate::picture::background::{Background, Effort};
use crate::state::document::Document;

/// Looks for it beside the pictures.
pub struct FirstPixel(Background<About, [u32; 2]>);

#[derive(Clone)]
struct About {
    scene: Arc<Scene>,
    resolution: [u32; 2],
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene) && self.resolution == other.resolution
    }
}

impl Default for FirstPixel {
    fn default() -> Self {
        Self(Background::new("first pixel"))
    }
}

impl FirstPixel {
    /// Where a plate shows a light; in a scene without such, the middle of the picture.
    pub fn of(&mut self, ctx: &Context, document: &Document) -> Option<[u32; 2]> {
        let about = About { scene: document.scene.clone(), resolution: document.image.resolution };
        self.0.of(ctx, about, Effort::Aside, |about, goes_on| {
            goes_on().then(|| highlight(about).unwrap_or(about.resolution.map(|n| n / 2)))
        })
    }

    /// Gives up looking.
    pub fn rest(&mut self) {
        self.0.rest();
    }
}

/// The middle one of all, as a pixel inside the picture.
fn highlight(About { scene, resolution }: &About) -> Option<[u32; 2]> {
    let squares = Square::all(scene);
    let square = squares.get(squares.len() / 2)?;
    let at = Projector::new(&scene.camera, *resolution).project(square.point())?;
    let inside = (0..2).all(|i| (0.0..f64::from(resolution[i])).contains(&at[i]));
    inside.then(|| at.map(|v| v as u32))
}
