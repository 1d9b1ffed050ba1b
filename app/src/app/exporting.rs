//! Figures of what is seen: asked for in one pass, recorded in the next but one, made by a thread.

use std::sync::Arc;

use eframe::egui::{self, Context};
use mislab_renderer::Layer;

use super::MisLabApp;
use crate::look::layer::LayerLook;
use crate::look::names::equal_name;
use crate::picture::figure::caption;
use crate::picture::legend::colour_note;
use crate::picture::paper::Paper;
use crate::picture::sheet::{Recorder, Sheet};
use crate::state::arrangement::Arrangement;
use crate::state::command::Figure;
use crate::state::file_name;
use crate::state::study::Study;

impl MisLabApp {
    /// Asks for a figure, which takes two more passes: the first forgets the mouse.
    pub(super) fn export(&mut self, ctx: &Context, figure: Figure) {
        if figure == Figure::Svg && self.lab.studies.open.is_none() {
            self.lab.messages.complain("An SVG is made of a study: open one first, e.g. G for convergence.");
            return;
        }
        self.lab.figures.push(figure);
        // A readout under the mouse is nothing on paper.
        Recorder::hide_mouse(ctx);
        ctx.request_repaint();
    }

    /// Makes the figures asked for of what this pass has recorded.
    pub(super) fn make_figures(&mut self, ctx: &Context) {
        let Some(sheet) = self.lab.sheet.take().map(Arc::new) else { return };
        Recorder::show_mouse(ctx);
        for figure in std::mem::take(&mut self.lab.figures) {
            self.make_figure(ctx, figure, sheet.clone());
        }
    }

    fn make_figure(&mut self, ctx: &Context, figure: Figure, sheet: Arc<Sheet>) {
        let dark = ctx.theme() == egui::Theme::Dark;
        let lab = &self.lab;
        let paper = Paper {
            sheet,
            legends: self.unexplained(),
            view: lab.document.view.clone(),
            lines: self.figure_lines(),
            dark,
            type_scale: lab.scale(),
        };
        let what = lab.studies.open.map_or("layout", |study| study.key());
        // Of a single picture, or of several strategies at once.
        let of_one = lab.studies.open.map_or(lab.document.slots().len() == 1, |study| study == Study::Pyramid);
        let spp = of_one.then(|| lab.snapshot_spp());
        let name = format!("{}_{what}", lab.destination.name(&lab.document, spp));
        let folder = lab.destination.folder(&lab.document);
        match figure {
            Figure::Clipboard => self.lab.files.make_figure(paper),
            Figure::Png | Figure::Svg => match file_name::check(&name) {
                Ok(()) => self.lab.files.export(paper, figure == Figure::Svg, folder, name),
                Err(why) => self.lab.messages.complain(format!("Not exported: {why}")),
            },
        }
    }

    /// The layer whose legend stands in a column of the window, away from the pictures.
    fn unexplained(&self) -> Vec<Layer> {
        let layer = self.lab.document.active().layer;
        let explained = LayerLook::of(layer).is_colour() || self.lab.studies.open.is_some();
        if explained { Vec::new() } else { vec![layer] }
    }

    /// What made it, as far as no caption says so.
    fn figure_lines(&self) -> Vec<String> {
        let lab = &self.lab;
        let document = &lab.document;
        let [width, height] = document.image.resolution;
        if let Some(study) = lab.studies.open {
            let what = format!("{}: {}", document.scene.name, study.name());
            return vec![match study {
                Study::Convergence | Study::Means | Study::Pyramid | Study::Explain => {
                    format!("{what}, {width} x {height}, seed {}", document.seed)
                }
                // No samples; of the pixels of this picture.
                Study::BestC => format!("{what}, {width} x {height}"),
                // The one has pictures of a size of its own, which it says; the other has no samples.
                Study::Grid | Study::Plane => what,
            }];
        }
        let view = colour_note(&document.view);
        match lab.live().frame() {
            Some(frame) if document.slots().len() == 1 => {
                let [how, what] = caption(&frame);
                vec![how, format!("{what}, {view}")]
            }
            Some(_) | None if document.slots().len() == 1 => {
                // A file: its name is all that is known of it.
                let name = lab.live().file().map(|file| file.name().to_owned());
                vec![format!("{}, {view}", name.unwrap_or_else(|| document.scene.name.clone()))]
            }
            Some(_) | None => {
                let (scene, equal) = (&document.scene.name, equal_name(document.equal));
                let what = format!("{scene}: {width} x {height}, equal {equal}, seed {}", document.seed);
                // Ratios and differences have colours of their own, which the legend in the picture explains.
                let has_own_colours = document.arrangement() == Arrangement::Difference;
                vec![if has_own_colours { what } else { format!("{what}, {view}") }]
            }
        }
    }
}
