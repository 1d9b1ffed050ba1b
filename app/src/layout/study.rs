//! A study beside the pictures or in their place.

use eframe::egui::{Frame, Margin, Rect, Ui, UiBuilder};

use mislab_renderer::Pace;

use crate::lab::Lab;
use crate::look::theme::GRID;
use crate::panel::study::Subject;
use crate::panel::study::best_map::best_map_ui;
use crate::panel::study::convergence::convergence_ui;
use crate::panel::study::explain::explain_ui;
use crate::panel::study::grid::grid_ui;
use crate::panel::study::means::means_ui;
use crate::panel::study::plane::plane_ui;
use crate::panel::study::pyramid::pyramid_ui;
use crate::state::command::Command;
use crate::state::study::Study;

/// The least width that pictures and a study share.
const SHARED: f32 = 800.0;

/// Divides the stage between pictures and study; either may get nothing.
pub(super) fn divide(stage: Rect, study: Option<Study>) -> [Option<Rect>; 2] {
    match study {
        None => [Some(stage), None],
        Some(study) if study.is_beside_pictures() && stage.width() >= SHARED => {
            let picture = stage.height().min(0.5 * stage.width());
            let (pictures, study) = stage.split_left_right_at_x((stage.left() + picture).round());
            [Some(pictures), Some(study)]
        }
        Some(_) => [None, Some(stage)],
    }
}

/// Draws the study that is open.
pub(super) fn study_ui(ui: &mut Ui, lab: &mut Lab, study: Study, place: Rect, out: &mut Vec<Command>) {
    let frame = Frame::new().inner_margin(Margin::same(GRID as i8 * 3));
    ui.scope_builder(UiBuilder::new().id_salt("study").max_rect(place), |ui| {
        ui.set_clip_rect(place.intersect(ui.clip_rect()));
        let Lab { studies, document, engine, panes, references, measuring, pacing, sheets, .. } = lab;
        // A table is not to be spoiled.
        let pace = if sheets.table.is_running() { Pace::Paused } else { pacing.pace() };
        let selected = panes.selected(document.request(document.active()).settings.pixel_bounds());
        let subject = Subject {
            document,
            selected,
            pictures: engine.pictures(),
            references,
            measuring,
            threads: engine.threads(),
            pace,
            pipeline: panes.pipeline(),
            cursor: panes.cursor(),
        };
        frame.show(ui, |ui| match study {
            Study::Convergence => convergence_ui(ui, &mut studies.convergence, &subject, out),
            Study::Means => means_ui(ui, &mut studies.means, &subject, out),
            Study::Pyramid => pyramid_ui(ui, &mut studies.pyramid, &subject, out),
            Study::Grid => grid_ui(ui, &mut studies.grid, &subject, out),
            Study::Plane => plane_ui(ui, &mut studies.plane, &subject, out),
            Study::Explain => explain_ui(ui, &mut studies.explain, &subject, out),
            Study::BestC => best_map_ui(ui, &mut studies.best_c, &subject, out),
        });
    });
}
