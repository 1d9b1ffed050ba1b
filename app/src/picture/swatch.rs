//! Small pictures of the plates, cut from the live picture.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use eframe::egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use mislab_renderer::{Channel, Frame};

use crate::picture::picking::{Finder, Target};
use crate::picture::tone::tone_map;
use crate::state::view::{ToneMap, ViewState};

/// Texels of a swatch.
const SIZE: [usize; 2] = [96, 48];
/// Swatches follow the picture at most this often: they are there to recognise a plate by.
const INTERVAL: Duration = Duration::from_millis(150);

/// The swatches of all plates.
#[derive(Default)]
pub struct Swatches {
    textures: HashMap<Target, TextureHandle>,
    key: Option<(u64, u32, f32, f32, ToneMap)>,
    made: Option<Instant>,
}

impl Swatches {
    /// Brings them up to date with the frame on screen.
    pub fn update(&mut self, ctx: &Context, frame: &Frame, view: &ViewState) {
        let key = (frame.generation(), frame.spp(), view.exposure_ev, view.offset, view.tone_map);
        if self.key == Some(key) {
            return;
        }
        if let Some(made) = self.made
            && made.elapsed() < INTERVAL
        {
            // The last frame of a picture must arrive, too.
            ctx.request_repaint_after(INTERVAL.saturating_sub(made.elapsed()));
            return;
        }
        self.key = Some(key);
        self.made = Some(Instant::now());
        let scene = &frame.request().scene;
        let finder = Finder::new(scene, frame.request().settings.image.resolution);
        for index in 0..scene.materials.len() {
            let target = Target::Material(index);
            if scene.materials[index].bsdf.alpha().is_none() {
                continue;
            }
            let Some(bounds) = finder.bounds(target) else { continue };
            let image = cut(frame, view, bounds);
            self.textures
                .entry(target)
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

/// The part of the picture inside `bounds`, squeezed into a swatch.
fn cut(frame: &Frame, view: &ViewState, [min, max]: [[f32; 2]; 2]) -> ColorImage {
    let held = frame.bounds();
    let texels = SIZE[0] * SIZE[1];
    if held.area() == 0 {
        return ColorImage::filled(SIZE, Color32::TRANSPARENT);
    }
    // The pixel that each texel shows.
    let pixels: Vec<[u32; 2]> = (0..texels)
        .map(|texel| {
            let at = [texel % SIZE[0], texel / SIZE[0]];
            [0, 1].map(|axis| {
                let share = (at[axis] as f32 + 0.5) / SIZE[axis] as f32;
                let place = min[axis] + share * (max[axis] - min[axis]);
                (place.max(0.0) as u32).clamp(held.min[axis], held.max[axis] - 1)
            })
        })
        .collect();
    let mut planes = vec![0.0; 3 * texels];
    frame.resolve_pixels(&[Channel::R, Channel::G, Channel::B], &pixels, &mut planes);
    let gain = view.exposure_ev.exp2();
    let level = |v: f32| (tone_map(view.tone_map, v * gain + view.offset) * 255.0 + 0.5) as u8;
    let colour = |texel: usize| {
        let [r, g, b] = [0, 1, 2].map(|channel| level(planes[channel * texels + texel]));
        Color32::from_rgb(r, g, b)
    };
    ColorImage::new(SIZE, (0..texels).map(colour).collect())
}
