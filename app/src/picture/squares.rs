//! The squares of a picture, plate by light, found on a thread of their own.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::study::Cells;
use mislab_renderer::{ImageSettings, PixelRect, Renderer, Request, Scene};

use crate::picture::background::{Background, Effort};

/// The squares of one picture, as far as they are known.
pub struct Squares(Background<About, Arc<Cells>>);

/// What squares depend on: no strategy moves them.
#[derive(Clone)]
struct About {
    scene: Arc<Scene>,
    image: ImageSettings,
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        // A scene is compared by its numbers only if it is not the very same one.
        self.image == other.image && (Arc::ptr_eq(&self.scene, &other.scene) || self.scene == other.scene)
    }
}

impl Default for Squares {
    fn default() -> Self {
        Self(Background::new("squares"))
    }
}

impl Squares {
    /// Those of a picture; none while they are not known, and where the picture itself cannot be rendered.
    pub fn of(&mut self, ctx: &Context, request: &Request) -> Option<Arc<Cells>> {
        let about = About { scene: request.scene.clone(), image: request.settings.image };
        self.0.of(ctx, about, Effort::Soon, |of, goes_on| {
            let cells = Cells::of(&Renderer::in_background(1), &of.scene, of.image, goes_on);
            cells.ok().flatten().map(Arc::new)
        })
    }

    /// Which of them a pixel of the full image is in, of a picture of these bounds.
    pub fn at(&self, pixel: [u32; 2], bounds: PixelRect) -> Option<usize> {
        let cells = self.0.known()?;
        let index = (pixel[1] - bounds.min[1]) * bounds.width() + pixel[0] - bounds.min[0];
        cells.squares.iter().position(|square| square.pixels.binary_search(&index).is_ok())
    }
}
