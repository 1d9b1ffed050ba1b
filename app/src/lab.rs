//! Everything in the window: what is edited, what renders it, what shows it. Panels draw from it, commands change it.

use std::sync::Arc;

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use mislab_renderer::{Layer, SamplerKind};

use crate::files::Files;
use crate::look::theme::TypeScale;
use crate::look::versus::Versus;
use crate::panel::messages::Messages;
use crate::panel::open::OpenSheet;
use crate::panel::palette::Palette;
use crate::panel::picture::PictureSheet;
use crate::panel::study::Studies;
use crate::panel::table::TablePanel;
use crate::picture::engine::Engine;
use crate::picture::foreign::Foreign;
use crate::picture::histogram::Histogram;
use crate::picture::live::LivePicture;
use crate::picture::pane::{Pane, Panes};
use crate::picture::picking::Target;
use crate::picture::reference::References;
use crate::picture::replicates::Replicates;
use crate::picture::sheet::Sheet;
use crate::picture::shelf::Shelf;
use crate::picture::slot_errors::Measuring;
use crate::picture::swatch::Swatches;
use crate::state::arrangement::Arrangement;
use crate::state::command::Figure;
use crate::state::destination::Destination;
use crate::state::document::{Document, Opened};
use crate::state::history::History;
use crate::state::pacing::Pacing;
use crate::state::prefs::Prefs;
use crate::state::study::Study;

/// The lab.
pub struct Lab {
    /// What is edited.
    pub document: Document,
    /// What undo takes back.
    pub history: History,
    /// How fast it goes.
    pub pacing: Pacing,
    /// What is kept between runs.
    pub prefs: Prefs,
    /// Where snapshots of this scene go.
    pub destination: Destination,
    /// The workers and a live picture for each slot of the document.
    pub engine: Engine,
    /// What is on screen of each.
    pub panes: Panes,
    /// Frames that were kept.
    pub shelf: Shelf,
    /// What the mouse is on in a panel.
    pub pointed_at: Option<Target>,
    /// Small pictures of the plates, cut from the active picture.
    pub swatches: Swatches,
    /// How bright the active picture is.
    pub histogram: Histogram,
    /// Work on files.
    pub files: Files,
    /// What lies over the window.
    pub sheets: Sheets,
    /// What errors are measured against.
    pub references: References,
    /// Errors and means of the pictures against it.
    pub measuring: Measuring,
    /// What the samples of the active picture's pattern are worth.
    pub replicates: Replicates,
    /// Plots, numbers and series of pictures.
    pub studies: Studies,
    /// What is to be said.
    pub messages: Messages,
    /// The figures asked for.
    pub figures: Vec<Figure>,
    /// What they are made of, recorded in the pass after.
    pub sheet: Option<Sheet>,
}

/// What can be opened over the window.
#[derive(Default)]
pub struct Sheets {
    /// The key sheet.
    pub help: bool,
    /// The list of all commands.
    pub palette: Option<Palette>,
    /// The field for a typed path.
    pub open: Option<OpenSheet>,
    /// The tutorial's table.
    pub table: TablePanel,
    /// The file whose warnings have been put away.
    pub warnings_read: Option<Arc<Opened>>,
    /// Text was being edited at the end of the last pass: Escape is about that.
    pub typing: bool,
    /// A picture from elsewhere.
    pub picture: Option<PictureSheet>,
    /// What of it is to be compared with.
    pub compared: Option<Foreign>,
}

impl Lab {
    /// Starts `threads` workers (0: one per core) that will ask `ctx` for a pass whenever there is news.
    pub fn new(ctx: &egui::Context, document: Document, prefs: Prefs, threads: usize) -> Self {
        let mut lab = Self {
            document,
            history: History::default(),
            pacing: Pacing::default(),
            prefs,
            destination: Destination::default(),
            engine: Engine::new(ctx, threads),
            panes: Panes::new(None),
            shelf: Shelf::default(),
            pointed_at: None,
            swatches: Swatches::default(),
            histogram: Histogram::default(),
            files: Files::new(ctx),
            sheets: Sheets::default(),
            references: References::default(),
            measuring: Measuring::default(),
            replicates: Replicates::default(),
            studies: Studies::default(),
            messages: Messages::default(),
            figures: Vec::new(),
            sheet: None,
        };
        lab.match_slots();
        lab
    }

    /// Draws pictures on that device from here on.
    pub fn draw_on(&mut self, render_state: &RenderState) {
        self.panes = Panes::new(Some(render_state));
        self.match_slots();
    }

    /// A live picture and a pane for each slot of the document: to be called after every change of it.
    pub fn match_slots(&mut self) {
        let Self { document, engine, panes, shelf, .. } = self;
        let requests: Vec<_> =
            document.slots().iter().map(|slot| slot.kept.is_none().then(|| document.request(slot))).collect();
        engine.match_requests(&requests);
        panes.set_count(requests.len());
        for (index, slot) in document.slots().iter().enumerate() {
            engine.show_kept(index, slot.kept.and_then(|kept| shelf.get(kept)));
        }
    }

    /// Makes the reference as long as a study or the picture needs it, and measures the pictures against what there is of it.
    pub fn measure(&mut self, ctx: &egui::Context) {
        let Self { document, engine, panes, references, measuring, replicates, studies, sheets, .. } = self;
        // A table is not to be spoiled.
        let quiet = sheets.table.is_running();
        let against = document.arrangement() == Arrangement::Difference && document.view.versus == Versus::Errors;
        let wanted = studies.open.map_or(against, Study::is_beside_pictures) && !quiet;
        let request = document.request(document.active());
        references.keep(ctx, &request, wanted, engine.threads());
        // What was made stays of use: captions go on showing errors when the study is closed.
        let selected = panes.selected(request.settings.pixel_bounds());
        measuring.update(ctx, references.latest(), engine.pictures(), selected);
        let variance = !quiet
            && document.slots().len() == 1
            && document.active().layer == Layer::Variance
            && studies.open.is_none_or(Study::is_beside_pictures)
            && document.sampling().sampler.kind != SamplerKind::Independent;
        replicates.keep(ctx, variance.then(|| document.request(document.active())));
        studies.convergence.hold(quiet || studies.open != Some(Study::Convergence));
    }

    /// The live picture that controls are about.
    pub fn live(&self) -> &LivePicture {
        &self.engine.pictures()[self.document.active_index()]
    }

    /// Its pane.
    pub fn pane(&self) -> &Pane {
        &self.panes.all()[self.document.active_index()]
    }

    /// Samples per pixel that a snapshot of the picture will have once it is complete; where it never is, that it has now.
    pub fn snapshot_spp(&self) -> u32 {
        let now = || self.live().current_frame().map_or(1, |frame| frame.spp());
        self.document.settings(self.document.active()).sampling.spp.map_or_else(now, |target| target.get())
    }

    /// The size of type: larger in the projector view.
    pub fn scale(&self) -> TypeScale {
        if self.prefs.panels { TypeScale::Desk } else { TypeScale::Hall }
    }
}
