//! The tutorial's Table 1, measured.

use std::path::Path;
use std::sync::Arc;

use eframe::egui::{self, ComboBox, Grid, Id, ProgressBar, RichText, ScrollArea, Ui, Window};
use mislab_renderer::table::{Cell, LightSize, LobeWidth, Table, TableOptions, TableResult, TutorialRun, with_error};
use mislab_renderer::{Scene, Strategy};

use crate::files::Files;
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks, medium};
use crate::panel::hint::Hint as _;
use crate::panel::number::seconds;
use crate::panel::table_job::{Progress, TableJob};
use crate::panel::widgets::{caption, sheet_type, wide_button};

/// Everything about the table.
#[derive(Default)]
pub struct TablePanel {
    /// The window is open.
    pub open: bool,
    /// Image size in pixels on each side; `None` as the tutorial has it.
    size: Option<u32>,
    job: Option<TableJob>,
    result: Option<Result<TableResult, String>>,
    /// How wide a window the table needed in the last pass, in points.
    width: f32,
}

impl TablePanel {
    /// Is one being made? The live picture should hold then: the times are the point.
    pub fn is_running(&self) -> bool {
        self.job.is_some()
    }

    /// Takes over what the job has brought.
    pub fn poll(&mut self) {
        if let Some(outcome) = self.job.as_mut().and_then(TableJob::poll) {
            self.job = None;
            match outcome {
                Ok(Some(table)) => self.result = Some(Ok(table)),
                Ok(None) => {}
                Err(error) => self.result = Some(Err(error)),
            }
        }
    }

    /// How far the one is that is being made.
    pub fn progress(&self) -> Option<Progress> {
        self.job.as_ref().map(TableJob::progress)
    }

    /// Asks the one that is being made to stop.
    pub fn cancel(&self) {
        if let Some(job) = &self.job {
            job.cancel();
        }
    }

    /// Stops what is running.
    pub fn stop(&mut self) {
        self.job = None;
    }
}

/// Around the window, and its title bar, in points.
const MARGIN: f32 = 20.0;
const TITLE: f32 = 60.0;

/// The window.
pub fn table_ui(ctx: &egui::Context, panel: &mut TablePanel, scene: &Arc<Scene>, folder: &Path, files: &mut Files) {
    let mut open = panel.open;
    let size = ctx.content_rect().size();
    let widest = size.x - 2.0 * MARGIN;
    Window::new("The tutorial's table")
        .id(Id::unique("table window"))
        .open(&mut open)
        .collapsible(false)
        .default_width(840.0_f32.min(widest))
        .min_width(panel.width.min(widest))
        .max_size(egui::vec2(widest, size.y - 2.0 * MARGIN - TITLE))
        .constrain_to(ctx.content_rect())
        .pivot(egui::Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            sheet_type(ui);
            start_ui(ui, panel, scene);
            match &panel.result {
                Some(Ok(result)) => {
                    ui.add_space(2.0 * GRID);
                    let around = ui.spacing().window_margin.sum().x + 2.0 * ui.visuals().window_stroke.width;
                    panel.width = table_grid(ui, &result.table) + around + ui.spacing().scroll.allocated_width();
                    export_ui(ui, result, folder, files);
                }
                Some(Err(error)) => {
                    let wrong = Inks::of(ui.visuals()).wrong;
                    ui.label(RichText::new(format!("No table: {error}")).color(wrong));
                }
                None if panel.job.is_none() => {
                    ui.label(
                        "Renders the tutorial's four files and a converged reference of this scene, takes the time, and \
                         measures where each strategy is good.",
                    );
                }
                None => {}
            }
        });
    panel.open = open;
}

fn start_ui(ui: &mut Ui, panel: &mut TablePanel, scene: &Arc<Scene>) {
    ui.horizontal(|ui| {
        if let Some(job) = &panel.job {
            let progress = job.progress();
            if wide_button(ui, "Cancel", 100.0).clicked() {
                job.cancel();
            }
            let bar = ProgressBar::new(progress.fraction).desired_width(ui.available_width() - 80.0);
            let text = RichText::new(&progress.step).color(ui.visuals().text_color());
            ui.add(bar.fill(ui.visuals().selection.bg_fill).corner_radius(2.0).text(text))
                .accessible_name("Table progress");
            ui.label(seconds(progress.elapsed.as_secs_f64()));
            return;
        }
        if wide_button(ui, "Fill in", 100.0).accessible_name("Fill in the table").clicked() {
            let options = TableOptions { size: panel.size.map(|n| [n, n]), ..TableOptions::default() };
            match TableJob::start(ui.ctx(), scene.clone(), options) {
                Ok(job) => panel.job = Some(job),
                Err(error) => panel.result = Some(Err(format!("no thread for it: {error}"))),
            }
        }
        let name = |size: Option<u32>| match size {
            Some(n) => format!("{n} \u{d7} {n}"),
            None => "the tutorial's sizes".into(),
        };
        let combo = ComboBox::from_id_salt("table size").width(200.0).selected_text(name(panel.size));
        let response = combo.show_ui(ui, |ui| {
            for size in [None, Some(400), Some(200), Some(100)] {
                if ui.selectable_value(&mut panel.size, size, name(size)).clicked() {
                    ui.close();
                }
            }
        });
        response.response.accessible_name("Image size of the table");
        caption(ui, "The live picture holds meanwhile: it would spoil the times.");
    });
}

const LIGHTS: [(LightSize, &str); 2] = [(LightSize::Small, "small light"), (LightSize::Large, "large light")];
const LOBES: [(LobeWidth, &str); 2] = [(LobeWidth::Broad, "broad BSDF"), (LobeWidth::Sharp, "sharp BSDF")];

/// Returns how wide the table is where there is room for it.
fn table_grid(ui: &mut Ui, table: &Table) -> f32 {
    let strong = |text: &str| RichText::new(text).family(medium());
    let area = ScrollArea::both().auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("tutorial table").num_columns(6).striped(false).spacing([20.0, 6.0]).show(ui, |ui| {
            for head in ["Strategy, file", "samples", "time", "relMSE"] {
                ui.label(strong(head));
            }
            for (_, name) in LOBES {
                ui.label(strong(name));
            }
            ui.end_row();
            for row in &table.rows {
                for (index, (light, light_name)) in LIGHTS.into_iter().enumerate() {
                    if index == 0 {
                        let ink = Inks::of(ui.visuals()).strategy(row.run.strategy);
                        ui.label(strong(strategy_name(row.run.strategy)).color(ink));
                        let [x, y] = row.run.strata;
                        ui.label(format!("{x} \u{d7} {y}")).hint(format!("{} paths", row.paths));
                        ui.label(seconds(row.render_seconds)).hint(format!(
                            "{} on {} threads",
                            seconds(row.cpu_seconds),
                            row.threads
                        ));
                    } else {
                        caption(ui, row.run.file);
                        let [width, height] = row.resolution;
                        let of_two = if row.run.strategy == Strategy::MisAll { ", two paths a sample" } else { "" };
                        caption(ui, format!("{width} \u{d7} {height}")).hint(format!("Pixels of the picture{of_two}"));
                        ui.label("");
                    }
                    ui.label(light_name);
                    for (lobe, _) in LOBES {
                        match row.cells.iter().find(|c| c.light == light && c.bsdf == lobe) {
                            Some(cell) => cell_ui(ui, cell),
                            None => {
                                ui.label("");
                            }
                        }
                    }
                    ui.end_row();
                }
            }
        });
    });
    caption(
        ui,
        format!(
            "\u{d7}: best in its square, or not distinguishable from the best. relMSE against a reference of {} spp per \
             light, mean of {} renders \u{b1} standard error. Times compare at the same number of pixels. Sharp: {}; broad: {}. Small: {}; large: {}.",
            table.reference_spp,
            table.replicates,
            table.sharp.join(", "),
            table.broad.join(", "),
            table.small.join(", "),
            table.large.join(", "),
        ),
    );
    area.content_size.x
}

fn cell_ui(ui: &mut Ui, cell: &Cell) {
    let cross = if cell.cross { "\u{d7}" } else { "  " };
    let text = match (cell.rel_mse, cell.standard_error) {
        (Some(value), Some(error)) => format!("{cross}  {}", with_error(value, error)),
        (Some(value), None) => format!("{cross}  {}", with_error(value, f64::NAN)),
        _ => format!("{cross}  no pixels"),
    };
    let text = RichText::new(text);
    ui.label(if cell.cross { text.family(medium()) } else { text.color(ui.visuals().weak_text_color()) });
}

fn export_ui(ui: &mut Ui, result: &TableResult, folder: &Path, files: &mut Files) {
    let table = &result.table;
    ui.add_space(GRID);
    ui.horizontal(|ui| {
        ui.label("Copy");
        if ui.button("Markdown").clicked() {
            ui.copy_text(table.to_markdown());
        }
        if ui.button("CSV").clicked() {
            ui.copy_text(table.to_csv());
        }
        if ui.button("JSON").clicked() {
            ui.copy_text(table.to_json());
        }
        ui.separator();
        ui.label("Save");
        let mut save_text = |label: &str, extension, text: &dyn Fn() -> String| {
            if ui.button(label).clicked() {
                files.save_text(folder.to_owned(), "veach_table".into(), extension, text());
            }
        };
        save_text(".md", "md", &|| table.to_markdown());
        save_text(".csv", "csv", &|| table.to_csv());
        save_text(".json", "json", &|| table.to_json());
        if ui.button("the four EXRs").hint("Under the tutorial's names, over older ones.").clicked() {
            let names = TutorialRun::ALL.iter().map(|run| run.file);
            files.save_tutorial(folder.to_owned(), names.zip(result.frames.iter().cloned()).collect());
        }
    });
}
