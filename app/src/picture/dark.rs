//! What each pixel is where it is black, found on a thread of its own.

use std::sync::Arc;

use eframe::egui::Context;
use mislab_renderer::blind::{Dark, dark_materials, dark_pixels};
use mislab_renderer::{Frame, Layer, Request, Strategy};

use crate::picture::background::{Background, Effort};

/// For each pixel of the full image what it is; `None` while that is not known.
pub type Darks = Option<Arc<Vec<Dark>>>;

/// Whether two pictures are of the same pixels of the same surfaces, which may have moved: then what is known of one may be shown in the
/// other until that is known.
pub fn are_alike(a: &Request, b: &Request) -> bool {
    let about =
        |Request { scene, settings }: &Request| (settings.image.resolution, dark_materials(scene, &settings.estimator));
    about(a) == about(b)
}

/// What the pixels of one picture are, as far as that is known.
pub struct DarkSpots {
    background: Background<About, Arc<Vec<Dark>>>,
    /// What was known last.
    last: Option<(About, Arc<Vec<Dark>>)>,
}

/// Two of them are equal if all pixels are the same in both.
#[derive(Clone)]
struct About(Arc<Request>);

impl About {
    fn is_like(&self, Self(other): &Self) -> bool {
        are_alike(&self.0, other)
    }
}

impl PartialEq for About {
    fn eq(&self, other: &Self) -> bool {
        // What is seen through the camera, and by which light: roughness changes nothing of it but where a mirror begins.
        let (this, that) = (&self.0.scene, &other.0.scene);
        let same_scene = Arc::ptr_eq(this, that) || (this.shapes == that.shapes && this.camera == that.camera);
        Arc::ptr_eq(&self.0, &other.0) || (same_scene && self.is_like(other))
    }
}

impl Default for DarkSpots {
    fn default() -> Self {
        Self { background: Background::new("dark spots"), last: None }
    }
}

/// Those of pictures of one scene, whatever their strategies: with a mirror that cannot be sampled, and without.
#[derive(Default)]
pub struct SharedDarkSpots([DarkSpots; 2]);

impl SharedDarkSpots {
    /// As [`DarkSpots::of`].
    pub fn of(&mut self, ctx: &Context, frame: &Frame, layer: Layer) -> Darks {
        let Self([whole, blind]) = self;
        // By what tells those of two pictures apart, so that neither gives up what is known of the other.
        let materials = dark_materials(&frame.request().scene, &asked(frame, layer).settings.estimator);
        let spots = if materials.contains(&Dark::Blind) { blind } else { whole };
        spots.of(ctx, frame, layer)
    }
}

/// Whose samples a layer is about: those of the light technique never hit a mirror's one direction, whatever else is drawn.
fn asked(frame: &Frame, layer: Layer) -> Arc<Request> {
    let request = frame.request();
    match layer {
        Layer::Light | Layer::WeightLight if request.settings.estimator.strategy.draws().bsdf => {
            let mut request = (**request).clone();
            request.settings.estimator.strategy = Strategy::Light;
            Arc::new(request)
        }
        Layer::Light
        | Layer::WeightLight
        | Layer::Picture
        | Layer::Bsdf
        | Layer::WeightBsdf
        | Layer::ShareLight
        | Layer::Variance => request.clone(),
    }
}

impl DarkSpots {
    /// Those of a layer of a frame. While they are not known nothing is marked or, where something has been moved, what was before; a
    /// pass is asked for when they are.
    pub fn of(&mut self, ctx: &Context, frame: &Frame, layer: Layer) -> Darks {
        let about = About(asked(frame, layer));
        // Without a thread nothing is marked; the caption says it all the same.
        let found = self
            .background
            .of(ctx, about.clone(), Effort::Soon, |About(request), _| Some(Arc::new(dark_pixels(request))));
        if let Some(found) = found {
            self.last = Some((about.clone(), found));
        }
        self.last.as_ref().filter(|(last, _)| last.is_like(&about)).map(|(_, found)| found.clone())
    }
}
