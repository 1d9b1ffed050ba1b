//! A picture from elsewhere: its channels, windows and attributes, and its pixels. It lies over the live picture, which stays.

use std::sync::Arc;

use eframe::egui::{self, Id, RichText, ScrollArea, Ui, Window, vec2};
use mislab_renderer::Layer;
use mislab_renderer::snapshot::{self, ChannelInfo, Image, Part, shown};

use crate::files::opening::PictureFile;
use crate::look::theme::{GRID, Inks};
use crate::panel::exposure::exposure_ui;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{caption, title, wide_button};
use crate::picture::foreign::{Foreign, colours, place};
use crate::picture::normalise::normalise;
use crate::picture::planes::Planes;
use crate::picture::viewport::{Shown, Viewport};
use crate::state::view::ViewState;

/// Width of the column beside the picture, in points.
const COLUMN: f32 = 300.0;

/// The sheet, while it is open.
pub struct PictureSheet {
    file: PictureFile,
    choices: Vec<Choice>,
    chosen: usize,
    view: ViewState,
    viewport: Viewport,
    planes: Option<Arc<Planes>>,
    pixel: Option<[u32; 2]>,
    /// Asked to be shown beside the live picture.
    compare: bool,
}

/// What can be shown of the file at a time: the colours of a layer, or one channel in grey.
struct Choice {
    name: String,
    channels: [usize; 3],
}

impl PictureSheet {
    /// Shows the first layer that there is.
    pub fn new(file: PictureFile) -> Self {
        let announced: Vec<&ChannelInfo> = file.parts.iter().flat_map(|part| &part.channels).collect();
        let choices = file.image.as_ref().map_or_else(|_| Vec::new(), |image| choices(image, &announced));
        // Drawn by the processor: it is drawn again only when something about it changes.
        let viewport = Viewport::new(None);
        Self {
            file,
            choices,
            chosen: 0,
            view: ViewState::default(),
            viewport,
            planes: None,
            pixel: None,
            compare: false,
        }
    }

    /// What is to be compared with, if that was asked for: what is chosen in the sheet as the picture, and all else.
    pub fn compared(self) -> Option<Foreign> {
        let Self { file, choices, chosen, compare, .. } = self;
        let colours = choices.get(chosen)?.channels;
        let image = file.image.ok().filter(|_| compare)?;
        Foreign::new(&file.path, image, Some(colours)).ok()
    }

    fn planes(&mut self) -> Option<Arc<Planes>> {
        if self.planes.is_none()
            && let (Ok(image), Some(choice)) = (&self.file.image, self.choices.get(self.chosen))
        {
            self.planes = Some(Arc::new(planes(image, choice)));
        }
        self.planes.clone()
    }
}

/// Layers with red, green and blue in colour, then every channel by itself, as the file announces it.
fn choices(image: &Image, announced: &[&ChannelInfo]) -> Vec<Choice> {
    let names: Vec<&str> = image.channels.iter().map(|(name, _)| name.as_str()).collect();
    let colour =
        colours(image).into_iter().map(|(layer, channels)| Choice { channels, name: format!("{layer} in colour") });
    let single = names.iter().enumerate().map(|(c, name)| {
        let channel = announced.iter().find(|channel| channel.name == *name);
        Choice { name: channel.map_or_else(|| (*name).to_owned(), |channel| described(channel)), channels: [c; 3] }
    });
    colour.chain(single).collect()
}

/// "light.R  FLOAT"
fn described(channel: &ChannelInfo) -> String {
    let sampling = match channel.sampling {
        [1, 1] => String::new(),
        [x, y] => format!(", one for every {x} x {y} pixels"),
    };
    format!("{}  {}{sampling}", shown(&channel.name), channel.kind)
}

fn planes(image: &Image, choice: &Choice) -> Planes {
    let (bounds, size) = place(image);
    let data = choice.channels.iter().flat_map(|&c| image.channels[c].1.iter().copied()).collect();
    Planes::new(Layer::Picture, bounds, size, data)
}

/// The sheet. Returns false when it is done with.
pub fn picture_ui(ctx: &egui::Context, sheet: &mut PictureSheet) -> bool {
    let mut open = !sheet.compare;
    let name = sheet.file.path.file_name().map_or_else(|| "Picture".into(), |n| n.to_string_lossy().into_owned());
    let room = ctx.content_rect().size() - vec2(80.0, 120.0);
    Window::new(shown(&name))
        .id(Id::unique("picture window"))
        .open(&mut open)
        .collapsible(false)
        .default_size((0.75 * room).max(vec2(1040.0, 700.0)).min(room))
        .max_size(room)
        .pivot(egui::Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            caption(ui, &sheet.file.remark);
            ui.add_space(GRID);
            let size = ui.available_size();
            ui.horizontal_top(|ui| {
                ui.allocate_ui(vec2((size.x - COLUMN - 6.0 * GRID).max(120.0), size.y), |ui| picture(ui, sheet));
                ui.add_space(GRID);
                ui.allocate_ui(vec2(COLUMN, size.y), |ui| {
                    ui.vertical(|ui| column(ui, sheet));
                });
            });
        });
    open
}

fn picture(ui: &mut Ui, sheet: &mut PictureSheet) {
    if let Err(error) = &sheet.file.image {
        ui.vertical(|ui| ui.label(RichText::new(format!("No pixels: {error}")).color(Inks::of(ui.visuals()).wrong)));
        return;
    }
    let planes = sheet.planes();
    let shown = Shown { quantity: Layer::Picture.into(), planes: planes.as_ref(), stale: None };
    sheet.pixel = sheet.viewport.ui(ui, &mut sheet.view, shown).hovered_pixel;
}

fn column(ui: &mut Ui, sheet: &mut PictureSheet) {
    if let Some(planes) = sheet.planes() {
        pixel_ui(ui, sheet);
        let remark = "The numbers of the file stay what they are.";
        if let Some(ev) = exposure_ui(ui, ("File exposure", 100.0), &sheet.view, 0.0, remark) {
            sheet.view.exposure_ev = ev;
        }
        ui.horizontal(|ui| {
            let width = (ui.available_width() - GRID) / 2.0;
            let hint = "Sets the exposure so that 99 of 100 pixels stay below white.";
            if wide_button(ui, "Normalise", width).hint(hint).clicked() {
                normalise(&mut sheet.view, &planes);
            }
            if wide_button(ui, "Fit", width).clicked() {
                sheet.view.placement.fit();
            }
        });
        let hint = "Shows it beside the live picture, with the same exposure, zoom and cursor: what is chosen here as the \
                    picture, and the layers of a snapshot.";
        sheet.compare |= wide_button(ui, "Compare with it", ui.available_width()).hint(hint).clicked();
    }
    ScrollArea::vertical().id_salt("about the picture").auto_shrink(false).show(ui, |ui| {
        if let Ok(image) = &sheet.file.image {
            windows_ui(ui, image.window, image.display);
            title(ui, "Channels");
            for (i, choice) in sheet.choices.iter().enumerate() {
                if ui.selectable_label(sheet.chosen == i, shown(&choice.name)).clicked() {
                    sheet.chosen = i;
                    sheet.planes = None;
                }
            }
        }
        for part in &sheet.file.parts {
            if sheet.file.image.is_err() {
                part_ui(ui, part);
            }
            attributes_ui(ui, part);
        }
    });
}

/// The pixel under the mouse, in the file's own coordinates.
fn pixel_ui(ui: &mut Ui, sheet: &PictureSheet) {
    let (Ok(image), Some(pixel), Some(choice)) = (&sheet.file.image, sheet.pixel, sheet.choices.get(sheet.chosen))
    else {
        caption(ui, "Point at a pixel to read its values.");
        return;
    };
    let (bounds, _) = place(image);
    let [x, y] = [0, 1].map(|axis| pixel[axis] - bounds.min[axis]);
    let index = y as usize * image.window.size[0] as usize + x as usize;
    let mut channels = choice.channels.to_vec();
    channels.dedup();
    let values: Vec<String> = channels.iter().map(|&c| format!("{:.5}", image.channels[c].1[index])).collect();
    let at = [(0, x), (1, y)].map(|(axis, v)| i64::from(image.window.min[axis]) + i64::from(v));
    caption(ui, format!("({}, {}): {}", at[0], at[1], values.join("  ")));
}

fn windows_ui(ui: &mut Ui, data: snapshot::Window, display: snapshot::Window) {
    title(ui, "Windows");
    caption(ui, format!("data: {data}"));
    caption(ui, format!("display: {display}"));
}

/// A part whose pixels cannot be shown.
fn part_ui(ui: &mut Ui, part: &Part) {
    let kind = if part.deep { " of deep pixels" } else { "" };
    title(ui, &format!("Part{kind}: {}", part.name.as_deref().map_or_else(|| "without a name".into(), shown)));
    windows_ui(ui, part.window, part.display);
    title(ui, "Channels");
    for channel in &part.channels {
        caption(ui, described(channel));
    }
}

fn attributes_ui(ui: &mut Ui, part: &Part) {
    title(ui, "Attributes");
    let said = ["channels", "dataWindow", "displayWindow"];
    for (name, value) in part.attributes.iter().filter(|(name, _)| !said.contains(&name.as_str())) {
        let text = RichText::new(format!("{}: {}", shown(name), shown(value))).small();
        ui.add(egui::Label::new(text).selectable(true).wrap());
    }
}
