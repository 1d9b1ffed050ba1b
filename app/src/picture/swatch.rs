//! Small pictures of the plates, cut from the live picture.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use mislab_renderer::kernel::world::BuiltScene;
use mislab_renderer::{Channel, Frame, PixelRect, Scene};

use crate::picture::picking::{Finder, Target};
use crate::picture::tone::tone_map;
use crate::state::passes;
use crate::state::view::{ToneMap, ViewState};

/// Texels of a swatch.
const SIZE: [usize; 2] = [96, 48];
/// Swatches follow the picture at most this often: they are there to recognise a plate by.
const INTERVAL: Duration = Duration::from_millis(150);

/// The swatches of all plates.
#[derive(Default)]
pub struct Swatches {
    textures: HashMap<Target, TextureHandle>,
    places: Option<Places>,
    key: Option<Key>,
    made: Option<Instant>,
}

/// What swatches are made of: generation, how often the samples have doubled, and the view. Less noise than that is not seen in them.
type Key = (u64, u32, f32, f32, ToneMap);

impl Swatches {
    /// Brings them up to date with the frame on screen.
    pub fn update(&mut self, ctx: &Context, frame: &Frame, view: &ViewState) {
        let key = (frame.generation(), frame.spp().ilog2(), view.exposure_ev, view.offset, view.tone_map);
        if self.key == Some(key) {
            return;
        }
        if let Some(made) = self.made
            && made.elapsed() < INTERVAL
        {
            // The last frame of a picture must arrive, too.
            passes::for_news_in(ctx, INTERVAL.saturating_sub(made.elapsed()));
            return;
        }
        self.key = Some(key);
        self.made = Some(Instant::now());
        let places = match self.places.take().filter(|places| places.are_of(frame)) {
            Some(places) => self.places.insert(places),
            None => self.places.insert(Places::of(frame)),
        };
        for (target, pixels) in &places.pixels {
            let image = cut(frame, view, pixels);
            self.textures
                .entry(*target)
                .and_modify(|texture| texture.set(image.clone(), TextureOptions::LINEAR))
                .or_insert_with(|| ctx.load_texture("swatch", image, TextureOptions::LINEAR));
        }
    }

    /// The swatch of a target, if there is one yet.
    pub fn get(&self, target: Target) -> Option<&TextureHandle> {
        self.textures.get(&target)
    }

    /// Forgets all of them: another scene.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// The pixels that the texels of all swatches show: a question of geometry, camera and image, asked once for all their frames.
struct Places {
    scene: Arc<Scene>,
    resolution: [u32; 2],
    held: PixelRect,
    pixels: Vec<(Target, Vec<[u32; 2]>)>,
}

impl Places {
    fn of(frame: &Frame) -> Self {
        let (request, held) = (frame.request(), frame.bounds());
        let (scene, resolution) = (request.scene.clone(), request.settings.image.resolution);
        let finder = Finder::new(&scene, resolution);
        let pixels = |material: usize| {
            let target = Target::Material(material);
            scene.materials[material].bsdf.alpha()?;
            Some((target, pixels(held, finder.bounds(target)?)))
        };
        let pixels = (0..scene.materials.len()).filter(|_| held.area() > 0).filter_map(pixels).collect();
        Self { scene, resolution, held, pixels }
    }

    fn are_of(&self, frame: &Frame) -> bool {
        let request = frame.request();
        let (old, new) = (&self.scene, &request.scene);
        let rough = |scene: &Scene| scene.materials.iter().map(|m| m.bsdf.alpha().is_some()).collect::<Vec<_>>();
        let same = || {
            old.camera == new.camera
                && BuiltScene::same_geometry(old, new)
                && old.shapes.iter().map(|shape| shape.material).eq(new.shapes.iter().map(|shape| shape.material))
                && rough(old) == rough(new)
        };
        self.resolution == request.settings.image.resolution
            && self.held == frame.bounds()
            && (Arc::ptr_eq(old, new) || same())
    }
}

/// The pixels of `held` that the texels of a swatch show of the part inside two corners.
fn pixels(held: PixelRect, [min, max]: [[f32; 2]; 2]) -> Vec<[u32; 2]> {
    let pixel = |texel: usize| {
        let at = [texel % SIZE[0], texel / SIZE[0]];
        [0, 1].map(|axis| {
            let share = (at[axis] as f32 + 0.5) / SIZE[axis] as f32;
            let place = min[axis] + share * (max[axis] - min[axis]);
            (place.max(0.0) as u32).clamp(held.min[axis], held.max[axis] - 1)
        })
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// Those pixels of a frame as a swatch.
fn cut(frame: &Frame, view: &ViewState, pixels: &[[u32; 2]]) -> ColorImage {
    let texels = pixels.len();
    let mut planes = vec![0.0; 3 * texels];
    frame.resolve_pixels(&[Channel::R, Channel::G, Channel::B], pixels, &mut planes);
    let gain = view.exposure_ev.exp2();
    let level = |v: f32| (tone_map(view.tone_map, v * gain + view.offset) * 255.0 + 0.5) as u8;
    let colour = |texel: usize| {
        let [r, g, b] = [0, 1, 2].map(|channel| level(planes[channel * texels + texel]));
        Color32::from_rgb(r, g, b)
    };
    ColorImage::new(SIZE, (0..texels).map(colour).collect())
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;

    use super::*;
    use glam::{DMat4, DVec3};
    use mislab_renderer::pbrt::embedded_scene;
    use mislab_renderer::{ImageSettings, Request, Sampling, Settings, render};

    fn frame(mut scene: Scene, edit: impl FnOnce(&mut Scene), resolution: [u32; 2]) -> Arc<Frame> {
        let settings = Settings::default();
        edit(&mut scene);
        let settings = Settings {
            sampling: Sampling { spp: NonZeroU32::new(1), ..settings.sampling },
            image: ImageSettings { resolution, ..settings.image },
            ..settings
        };
        render(&Request { scene: Arc::new(scene), settings }, 1, &mut |_| true).expect("renders")
    }

    #[test]
    fn places_are_asked_for_again_only_where_they_are_others() {
        let size = [24, 24];
        let scene = embedded_scene().scene;
        let places = Places::of(&frame(scene.clone(), |_| {}, size));
        assert_eq!(places.pixels.len(), 4, "one for each plate");
        let kept = |edit: fn(&mut Scene)| {
            let frame = frame(scene.clone(), edit, size);
            let kept = places.are_of(&frame);
            assert!(!kept || Places::of(&frame).pixels == places.pixels, "kept, though they are others");
            kept
        };
        assert!(kept(|_| {}));
        assert!(kept(|scene| {
            let alpha = scene.materials.iter_mut().find_map(|material| material.bsdf.alpha_mut());
            *alpha.expect("a plate") = 0.3;
        }));
        assert!(kept(|scene| scene.shapes.iter_mut().filter_map(|s| s.light.as_mut()).for_each(|l| l.radiance *= 2.0)));
        assert!(!kept(|scene| {
            scene.camera.world_from_camera =
                DMat4::from_translation(DVec3::new(0.0, 0.5, 0.0)) * scene.camera.world_from_camera;
        }));
        assert!(!kept(|scene| {
            let plate = scene.shapes.iter_mut().find(|shape| shape.material.is_some() && shape.light.is_none());
            plate.expect("a plate").material = None;
        }));
        assert!(!places.are_of(&frame(scene.clone(), |_| {}, [25, 24])));
    }
}
