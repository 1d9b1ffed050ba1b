//! What the window edits: scene, settings and view.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::Arc;

use mislab_renderer::pbrt::SceneFile;
use mislab_renderer::{
    Diagnostic, Estimator, Geometry, ImageSettings, Layer, Lockstep, Request, SamplerSettings, Sampling, Scene,
    Settings, Strategy,
};

use super::arrangement::Arrangement;
use super::view::ViewState;

/// Where a scene came from and how it was there: what resets go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// The scene as the file says it.
    pub scene: Arc<Scene>,
    /// The settings as the file says them.
    pub settings: Settings,
    /// The layer as the file says it; the picture for a scene file.
    pub layer: Layer,
    /// The view as the file says it; the default view for a scene file.
    pub view: ViewState,
    /// What the reader did not understand.
    pub warnings: Vec<Diagnostic>,
    /// The file, `None` for a scene shipped inside the program.
    pub path: Option<PathBuf>,
    /// Name for titles.
    pub title: String,
}

impl Opened {
    /// What a scene file says, with the default view.
    pub fn from_scene_file(file: SceneFile, path: Option<PathBuf>) -> Self {
        Self {
            title: file.scene.name.clone(),
            scene: Arc::new(file.scene),
            settings: file.settings,
            layer: Layer::Picture,
            view: ViewState::default(),
            warnings: file.warnings,
            path,
        }
    }
}

/// What the number of samples per pixel counts in a picture that stands alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// Camera rays, as in the tutorial: `mis_all` pays for two further rays each.
    Samples,
    /// Second rays: `mis_all` stops after half the samples.
    Rays,
}

/// One picture of the document: what it has to itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// How the radiance is estimated.
    pub estimator: Estimator,
    /// The pattern of its samples.
    pub sampler: SamplerSettings,
    /// Which image of the frame is shown.
    pub layer: Layer,
    /// It is not rendered: what was kept is shown.
    pub kept: Option<Kept>,
}

impl Slot {
    /// It shows a file, which nothing set here has made.
    pub fn is_file(&self) -> bool {
        matches!(self.kept, Some(Kept::File(_)))
    }
}

/// The number of what was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// A frame.
    Frame(u64),
    /// A picture from a file.
    File(u64),
}

/// Everything a control sets. Pictures differ in their [`Slot`]s and share the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// Where it came from.
    pub opened: Arc<Opened>,
    /// The scene with every edit applied.
    pub scene: Arc<Scene>,
    /// Samples per pixel to stop at; `None` goes on until stopped. See [`Self::settings`] for several pictures.
    pub spp: Option<NonZeroU32>,
    /// What that number counts; several pictures have [`Self::equal`] for it.
    pub counted: Counted,
    /// Seed of every random number.
    pub seed: u32,
    /// Image size and crop.
    pub image: ImageSettings,
    /// How the pictures are looked at; never reaches the renderer.
    pub view: ViewState,
    /// The pictures, at least one.
    slots: Vec<Slot>,
    /// Index of the one that controls are about.
    active: usize,
    /// How they lie in the window.
    arrangement: Arrangement,
    /// What several pictures have alike at every moment.
    pub equal: Lockstep,
    /// Two and four pictures as they were left for another number of them.
    aside: [Option<Vec<Slot>>; 2],
}

impl Document {
    /// A file as it was opened, without edits.
    pub fn new(opened: Opened) -> Self {
        let Settings { estimator, sampling, image } = opened.settings;
        Self {
            scene: opened.scene.clone(),
            spp: sampling.spp,
            counted: Counted::Samples,
            seed: sampling.seed,
            image,
            view: opened.view.clone(),
            slots: vec![Slot { estimator, sampler: sampling.sampler, layer: opened.layer, kept: None }],
            active: 0,
            arrangement: Arrangement::One,
            // `mis_all` pays for two rays a sample: at equal samples it would be flattered.
            equal: Lockstep::Rays,
            aside: [None, None],
            opened: Arc::new(opened),
        }
    }

    /// The same document after its file has changed: what the file says, looked at as before.
    pub fn reloaded(&self, opened: Opened) -> Self {
        let mut document =
            Self { view: self.view.clone(), equal: self.equal, counted: self.counted, ..Self::new(opened) };
        document.active_mut().layer = self.active().layer;
        if self.arrangement != Arrangement::One {
            let own = *document.active();
            document.slots.clone_from(&self.slots);
            document.active = self.active;
            document.arrangement = self.arrangement;
            document.adopt(own);
        }
        document
    }

    /// The pictures, in their order on screen.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Which of [`Self::slots`] controls are about.
    pub fn active_index(&self) -> usize {
        self.active
    }

    /// The picture that controls are about.
    pub fn active(&self) -> &Slot {
        &self.slots[self.active]
    }

    /// The same, for editing.
    pub fn active_mut(&mut self) -> &mut Slot {
        &mut self.slots[self.active]
    }

    /// Makes another one the picture that controls are about; an index beyond the last changes nothing.
    pub fn activate(&mut self, index: usize) {
        if index < self.slots.len() {
            self.active = index;
        }
    }

    /// How the pictures lie in the window.
    pub fn arrangement(&self) -> Arrangement {
        self.arrangement
    }

    /// Lays out the pictures in another way. The active one stays; others come back as they were left, or else show
    /// the other strategies.
    pub fn arrange(&mut self, arrangement: Arrangement) {
        if arrangement.count() != self.arrangement.count() {
            let own = *self.active();
            let shown = self.slots.clone();
            if let Some(aside) = self.aside_of(self.arrangement) {
                *aside = Some(shown);
            }
            let left = self.aside_of(arrangement).and_then(Option::take);
            self.slots = left.unwrap_or_else(|| self.first_slots(arrangement));
            self.active = self.active.min(self.slots.len() - 1);
            self.adopt(own);
        }
        self.arrangement = arrangement;
    }

    fn aside_of(&mut self, arrangement: Arrangement) -> Option<&mut Option<Vec<Slot>>> {
        let [two, four] = &mut self.aside;
        match arrangement {
            Arrangement::One => None,
            Arrangement::Beside | Arrangement::Wipe | Arrangement::Flip | Arrangement::Difference => Some(two),
            Arrangement::Four => Some(four),
        }
    }

    /// The pictures of an arrangement that has not been used yet.
    fn first_slots(&self, arrangement: Arrangement) -> Vec<Slot> {
        let own = *self.active();
        let with = |strategy| {
            let shown = self.slots.iter().find(|slot| slot.estimator.strategy == strategy);
            shown.copied().unwrap_or(Slot { estimator: Estimator { strategy, ..own.estimator }, kept: None, ..own })
        };
        match arrangement {
            Arrangement::One => vec![own],
            Arrangement::Beside | Arrangement::Wipe | Arrangement::Flip | Arrangement::Difference => {
                let other = match own.estimator.strategy {
                    Strategy::Light => Strategy::Bsdf,
                    Strategy::Bsdf => Strategy::Light,
                    Strategy::MisAll => Strategy::Mis,
                    Strategy::Mis => Strategy::MisAll,
                };
                vec![own, with(other)]
            }
            Arrangement::Four => Strategy::ALL.map(with).to_vec(),
        }
    }

    /// Makes `own` one of the pictures, and the active one: in place of one like it, or of the same strategy.
    fn adopt(&mut self, own: Slot) {
        let find = |same: &dyn Fn(&Slot) -> bool| self.slots.iter().position(same);
        let place = find(&|slot| *slot == own).or_else(|| find(&|slot| slot.estimator == own.estimator));
        let place = place.or_else(|| find(&|slot| slot.estimator.strategy == own.estimator.strategy));
        self.active = place.unwrap_or(self.active);
        if self.slots[self.active].layer != own.layer {
            // Another layer was chosen meanwhile: pictures of different layers are not what one compares.
            self.share_layer(own.layer);
        }
        *self.active_mut() = own;
    }

    /// The same layer in all pictures.
    pub fn share_layer(&mut self, layer: Layer) {
        for slot in &mut self.slots {
            slot.layer = layer;
        }
    }

    /// Where all pictures stop, with patterns of as many strata.
    pub fn set_spp(&mut self, spp: Option<NonZeroU32>) {
        self.spp = spp;
        for slot in &mut self.slots {
            fit_strata(&mut slot.sampler, spp);
        }
    }

    /// Shows a kept frame of the active picture beside it.
    pub fn keep(&mut self, kept: Kept) {
        if self.arrangement.count() != 2 {
            self.arrange(Arrangement::Beside);
        }
        let own = Slot { kept: None, ..*self.active() };
        *self.active_mut() = own;
        self.slots[1 - self.active] = Slot { kept: Some(kept), ..own };
    }

    /// Shows a picture from a file beside the active one, or in place of the next of four.
    pub fn compare(&mut self, kept: Kept) {
        if self.slots.len() < 2 {
            self.arrange(Arrangement::Beside);
        }
        let next = (self.active + 1) % self.slots.len();
        // Compared is what the active one shows.
        self.slots[next] = Slot { kept: Some(kept), ..*self.active() };
    }

    /// The samples of the active picture as it would be alone.
    pub fn sampling(&self) -> Sampling {
        Sampling { sampler: self.active().sampler, spp: self.spp, seed: self.seed }
    }

    /// Everything but the scene that decides the bits of a picture. At equal rays, and where rays are counted, a picture
    /// ends with as many rays as one ray a sample gives: `mis_all` after half the samples.
    pub fn settings(&self, slot: &Slot) -> Settings {
        let several = self.slots.len() > 1;
        let of_rays = if several { self.equal == Lockstep::Rays } else { self.counted == Counted::Rays };
        match self.spp {
            Some(rays) if of_rays => self.settings_at_equal_rays(slot, rays),
            spp => self.settings_with(slot, spp),
        }
    }

    /// The same with so many rays a pixel, whatever the strategy.
    pub fn settings_at_equal_rays(&self, slot: &Slot, rays: NonZeroU32) -> Settings {
        let spp = rays.get() / slot.estimator.strategy.rays_per_sample();
        let mut settings = self.settings_with(slot, Some(NonZeroU32::new(spp).unwrap_or(NonZeroU32::MIN)));
        fit_strata(&mut settings.sampling.sampler, settings.sampling.spp);
        settings
    }

    fn settings_with(&self, slot: &Slot, spp: Option<NonZeroU32>) -> Settings {
        let Slot { estimator, sampler, layer: _, kept: _ } = *slot;
        Settings { estimator, sampling: Sampling { sampler, spp, seed: self.seed }, image: self.image }
    }

    /// What the renderer should be working on for a picture.
    pub fn request(&self, slot: &Slot) -> Request {
        Request { scene: self.scene.clone(), settings: self.settings(slot) }
    }

    /// Scene and settings back to the file's; the view stays.
    pub fn reset_scene(&mut self) {
        let Settings { estimator, sampling, image } = self.opened.settings;
        self.scene = self.opened.scene.clone();
        self.spp = sampling.spp;
        self.seed = sampling.seed;
        self.image = image;
        self.active_mut().estimator = estimator;
        self.active_mut().sampler = sampling.sampler;
    }

    /// Whether [`Self::reset_scene`] would change anything.
    pub fn is_edited(&self) -> bool {
        let settings = Settings { estimator: self.active().estimator, sampling: self.sampling(), image: self.image };
        self.scene != self.opened.scene || settings != self.opened.settings
    }

    /// The GGX width of a material in the file.
    pub fn original_alpha(&self, material: usize) -> Option<f32> {
        self.opened.scene.materials.get(material)?.bsdf.alpha()
    }

    /// The radius of a sphere in `scene`.
    pub fn radius(scene: &Scene, shape: usize) -> Option<f32> {
        match scene.shapes.get(shape)?.geometry {
            Geometry::Sphere { radius, .. } => Some(radius),
            Geometry::Mesh { .. } => None,
        }
    }
}

/// A stratified pattern has as many strata as the picture has samples, so that the whole of it is
/// used; other samplers keep theirs, which has no effect on them.
pub(super) fn fit_strata(sampler: &mut SamplerSettings, spp: Option<NonZeroU32>) {
    let Some(spp) = spp else { return };
    if sampler.kind.has_strata() && u64::from(sampler.strata[0]) * u64::from(sampler.strata[1]) != u64::from(spp.get())
    {
        sampler.strata = SamplerSettings::strata_for(spp.get());
    }
}
