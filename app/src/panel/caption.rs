//! The caption of a picture: what made it. One for each pane; nothing in it moves while numbers count.

use eframe::egui::{self, Align2, FontId, Layout, RichText, Role, TextStyle, Ui, vec2};
use mislab_renderer::blind::why_blind;
use mislab_renderer::{Frame, Layer, Lockstep, Strategy};

use crate::look::layer::LayerLook;
use crate::look::names::{heuristic_name, strategy_name};
use crate::look::theme::{GRID, Inks, medium};
use crate::panel::hint::Hint as _;
use crate::panel::number::{seconds, si, two_digits};
use crate::panel::widgets::{cell, text_width};

/// The frame on screen in words: true of it at every moment, whatever the settings are by now.
pub struct Caption {
    strategy: Strategy,
    /// Heuristic and c, where there are any.
    how: String,
    spp: String,
    paths: String,
    /// Per pixel.
    rays: String,
    cpu: String,
    time: String,
    scene: String,
    bias: Option<String>,
    /// It is of older settings.
    behind: bool,
    /// It was kept: nothing in it is equal to that of others.
    kept: bool,
    /// relMSE against the reference; empty without one.
    error: String,
    /// What the layer on screen is about, and what samples are worth.
    spread: Option<String>,
}

/// What several pictures are to have alike.
#[derive(Clone, Copy)]
pub struct Alike {
    /// Which of their numbers.
    pub what: Lockstep,
    /// It is the same in all by now.
    pub exactly: bool,
}

/// What a frame has of what can be alike, in words.
pub fn number(of: Lockstep, frame: &Frame) -> String {
    match of {
        Lockstep::Spp => format!("{} spp", frame.spp()),
        Lockstep::Rays => {
            let strategy = frame.request().settings.estimator.strategy;
            let rays = u64::from(frame.spp()) * u64::from(strategy.rays_per_sample());
            if rays == 1 { "1 ray".to_owned() } else { format!("{rays} rays") }
        }
        Lockstep::CpuSeconds => seconds(frame.stats().cpu_seconds),
    }
}

/// The widest that stands in each place.
const HOW: &str = "maximum, c 0.88";
const SPP: &str = "88888 spp";
const RAYS: &str = "88888 rays";
const PATHS: &str = "88.8 M paths";
const TIME: &str = "88:88 min";
const ERROR: &str = "error 0.00088";
const BIASED: &str = "biased";
/// Captions of pictures narrower than so many times the size of body type are in caption type.
const NARROW: f32 = 19.0;

impl Caption {
    /// Of a frame; `behind` if it is of older settings.
    pub fn new(frame: &Frame, behind: bool) -> Self {
        let settings = &frame.request().settings;
        let strategy = settings.estimator.strategy;
        let heuristic = heuristic_name(settings.estimator.heuristic).to_lowercase();
        let how = match strategy {
            Strategy::Light | Strategy::Bsdf => String::new(),
            Strategy::MisAll => heuristic,
            Strategy::Mis => format!("{heuristic}, c {:.2}", settings.estimator.light_prob),
        };
        let stats = frame.stats();
        Self {
            strategy,
            how,
            spp: number(Lockstep::Spp, frame),
            paths: format!("{} paths", si(stats.paths as f64)),
            rays: number(Lockstep::Rays, frame),
            cpu: number(Lockstep::CpuSeconds, frame),
            time: seconds(stats.render_seconds),
            scene: frame.request().scene.name.clone(),
            bias: bias(frame),
            behind,
            kept: false,
            error: String::new(),
            spread: None,
        }
    }

    /// Of a frame that was kept.
    pub fn of_kept(frame: &Frame) -> Self {
        Self { kept: true, ..Self::new(frame, false) }
    }

    /// With a place for its relMSE, which is a dash until it is known; `None` without a reference.
    pub fn with_error(self, rel_mse: Option<Option<f64>>) -> Self {
        let text = |error: Option<f64>| format!("error {}", two_digits(error.unwrap_or(f64::NAN)));
        Self { error: rel_mse.map_or_else(String::new, text), ..self }
    }

    /// With what the layer of variances is about.
    pub fn with_spread(self, spread: Option<String>) -> Self {
        Self { spread, ..self }
    }

    fn spoken(&self) -> String {
        let parts = [strategy_name(self.strategy), &self.how, &self.spp, &self.paths, &self.time, &self.scene];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        format!("Caption: {}", parts.join(", "))
    }

    /// In a strip under the picture: numbers in one line, the scene and what is wrong in a second one, which leaves
    /// `aside` free at its right end.
    pub fn strip_ui(&self, ui: &mut Ui, aside: f32) {
        let font = TextStyle::Body.resolve(ui.style());
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0 * GRID;
            self.name_ui(ui, &font);
            let error = (&self.error, if self.error.is_empty() { "" } else { ERROR });
            let numbers = [
                (&self.how, HOW),
                (&self.spp, SPP),
                (&self.rays, RAYS),
                error,
                (&self.paths, PATHS),
                (&self.time, TIME),
            ];
            let hints = [HINTS[0], HINTS[1], HINTS[2], HINTS[5], HINTS[3], HINTS[4]];
            for ((text, template), hint) in
                numbers.into_iter().zip(hints).filter(|((_, template), _)| !template.is_empty())
            {
                // Rather nothing than half a number.
                if ui.available_width() < text_width(ui, template, &font) {
                    break;
                }
                cell(ui, text, template, font.clone(), None, Align2::LEFT_CENTER).hint(hint);
            }
        });
        ui.horizontal(|ui| {
            ui.set_max_width((ui.available_width() - aside).max(0.0));
            ui.spacing_mut().item_spacing.x = 3.0 * GRID;
            self.remarks_ui(ui);
        });
    }

    /// In one line under one of several pictures: what is alike in all of them stands first, and as much of the rest as
    /// there is room for. A `layer` comes before the rest. In a narrow place type is smaller, and where there is room
    /// for one number it is the error.
    pub fn line_ui(&self, ui: &mut Ui, alike: Alike, layer: Option<Layer>) {
        let equal = alike.what;
        let mut font = line_font(ui);
        let first = if self.error.is_empty() { "= 888 rays" } else { ERROR };
        // In the smallest pictures of a hall rather smaller type than half a word. The same in all pictures, whether or not one is biased.
        let needed = [strategy_name(Strategy::MisAll), first, BIASED]
            .map(|text| text_width(ui, text, &font))
            .iter()
            .sum::<f32>();
        let room = ui.available_width() - 4.0 * GRID;
        font.size *= (room / needed).clamp(0.7, 1.0);
        let medium = FontId::new(font.size, medium());
        let (inks, visuals) = (Inks::of(ui.visuals()), ui.visuals().clone());
        ui.spacing_mut().item_spacing.x = 2.0 * GRID;
        let name = strategy_name(self.strategy);
        let widest = strategy_name(Strategy::MisAll);
        cell(ui, name, widest, medium.clone(), Some(inks.strategy(self.strategy)), Align2::LEFT_CENTER);
        // While they run pictures differ by a pass.
        let sign = if alike.exactly { "=" } else { "\u{2248}" };
        let alike = |this: Lockstep, text: &str| {
            if this == equal && !self.kept { format!("{sign} {text}") } else { text.to_owned() }
        };
        let spp = (alike(Lockstep::Spp, &self.spp), "= 888 spp", "Samples per pixel.");
        let rays = (alike(Lockstep::Rays, &self.rays), "= 888 rays", HINTS[2]);
        let time =
            (alike(Lockstep::CpuSeconds, &self.cpu), "= 88.8 s", "Seconds of processor time, all threads together.");
        let how = (self.how.clone(), HOW, HINTS[0]);
        let error = (self.error.clone(), ERROR, HINTS[5]);
        let mut numbers = match equal {
            Lockstep::Spp => [spp, error, rays, time, how],
            Lockstep::Rays => [rays, error, spp, time, how],
            Lockstep::CpuSeconds => [time, error, spp, rays, how],
        };
        // The same in all pictures, whether or not this one is biased.
        let both = [numbers[0].1, ERROR, BIASED].map(|text| text_width(ui, text, &font)).iter().sum::<f32>();
        if !self.error.is_empty() && ui.available_width() < both + 2.0 * ui.spacing().item_spacing.x {
            numbers.swap(0, 1);
        }
        let layer = layer.map(|layer| LayerLook::of(layer).name);
        let behind = if self.kept { Some("kept") } else { self.behind.then_some("\u{2026}") };
        let comes = [self.bias.as_ref().map(|_| BIASED), layer, behind];
        let gap = ui.spacing().item_spacing.x;
        let kept: f32 = comes.iter().flatten().map(|text| text_width(ui, text, &font) + gap).sum();
        for (index, (text, template, hint)) in numbers.into_iter().enumerate() {
            if text.is_empty() && template == ERROR {
                continue;
            }
            // Rather nothing than half a number.
            if index > 0 && ui.available_width() < text_width(ui, template, &font) + kept {
                break;
            }
            let (font, ink) =
                if index == 0 { (&medium, visuals.strong_text_color()) } else { (&font, visuals.weak_text_color()) };
            cell(ui, &text, template, font.clone(), Some(ink), Align2::LEFT_CENTER).hint(hint);
        }
        let [bias, layer, behind] = comes;
        if let (Some(text), Some(why)) = (bias, &self.bias) {
            ui.label(RichText::new(text).font(font.clone()).color(inks.wrong)).hint(why.clone());
        }
        for text in [layer, behind].into_iter().flatten() {
            ui.add(egui::Label::new(RichText::new(text).font(font.clone())).truncate());
        }
    }

    /// What [`Self::line_ui`] says, for screen readers.
    pub fn spoken_line(&self) -> String {
        let kept = if self.kept { "kept" } else { "" };
        let parts = [strategy_name(self.strategy), &self.spp, &self.rays, &self.error, &self.how, kept];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ")
    }

    /// In a column beside the picture, line under line.
    pub fn column_ui(&self, ui: &mut Ui) {
        ui.spacing_mut().interact_size.y = 0.0;
        let font = TextStyle::Body.resolve(ui.style());
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            self.name_ui(ui, &font);
            ui.label(&self.how);
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            let numbers = [(&self.spp, SPP), (&self.rays, RAYS), (&self.error, ERROR), (&self.time, "88.8 s")];
            for (text, template) in numbers.into_iter().filter(|(text, _)| !text.is_empty()) {
                // Rather nothing than half a number.
                if text_width(ui, template, &font) <= ui.available_width() {
                    cell(ui, text, template, font.clone(), None, Align2::LEFT_CENTER);
                }
            }
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0 * GRID;
            self.remarks_ui(ui);
        });
    }

    fn name_ui(&self, ui: &mut Ui, font: &FontId) {
        let font = FontId::new(font.size, medium());
        let ink = Inks::of(ui.visuals()).strategy(self.strategy);
        let template = strategy_name(Strategy::MisAll);
        let response = cell(ui, strategy_name(self.strategy), template, font, Some(ink), Align2::LEFT_CENTER);
        response.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, self.spoken()));
        response.hint("The strategy of the picture on screen.");
    }

    /// The scene, and behind it what comes and goes.
    fn remarks_ui(&self, ui: &mut Ui) {
        let wrong = Inks::of(ui.visuals()).wrong;
        let font = TextStyle::Small.resolve(ui.style());
        let behind = self.behind.then_some("previous settings \u{2026}");
        let gap = ui.spacing().item_spacing.x;
        let spread = self.spread.as_deref();
        let wide = |texts: [Option<&str>; 3]| -> f32 {
            texts.into_iter().flatten().map(|text| text_width(ui, text, &font) + gap).sum()
        };
        // Where there is no room for the reason there is one for the word.
        let room = ui.available_width() - 5.0 * font.size;
        let bias = self.bias.as_deref();
        let biased = if wide([spread, bias, behind]) > room { bias.map(|_| BIASED) } else { bias };
        let remarks = wide([spread, biased, behind]);
        let small = |text: &str| RichText::new(text).text_style(TextStyle::Small);
        let scene = egui::Label::new(small(&self.scene).color(ui.visuals().weak_text_color())).truncate();
        // What is wrong goes before the name.
        let room = (ui.available_width() - remarks).max(5.0 * font.size);
        let scene = ui.scope(|ui| {
            ui.set_max_width(room);
            ui.add(scene)
        });
        scene.inner.hint(format!("The scene: {}", self.scene));
        if let (Some(text), Some(bias)) = (biased, &self.bias) {
            let response = ui.add(egui::Label::new(small(text).color(wrong)).truncate());
            response.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, bias));
            response.hint(bias.clone());
        }
        if let Some(text) = &self.spread {
            let ink = ui.visuals().text_color();
            ui.add(egui::Label::new(small(text).color(ink)).truncate()).hint(SPREAD);
        }
        if let Some(text) = behind {
            ui.label(small(text).italics());
        }
    }
}

/// Type of a caption of one line in the room there is.
pub fn line_font(ui: &Ui) -> FontId {
    let body = TextStyle::Body.resolve(ui.style());
    if ui.available_width() < NARROW * body.size { TextStyle::Small.resolve(ui.style()) } else { body }
}

const HINTS: [&str; 6] = [
    "How weights follow from the densities, and the probability c of a light sample.",
    "Samples per pixel. The tutorial: xsamples times ysamples.",
    "Second rays per pixel: \u{201c}MIS, both\u{201d} traces two a sample.",
    "Paths of the whole picture, of two segments each: as many as camera rays, in strategy 3 twice as many.",
    "Seconds spent rendering. The tutorial's Table 1: Time (secs).",
    "relMSE against the reference: the mean of (x - r)\u{b2} / (r\u{b2} + 0.01).",
];

const SPREAD: &str = "Variance, averaged over the pixels that show one surface and no rim of a light. The layer takes samples as \
                      independent. Small pictures of the pattern with other seeds say what a sample is worth as it is drawn: the \
                      number of samples times the variance of their mean. In squared radiance the few pixels at rims of mirrored \
                      lights weigh most, which that many replicates tell only roughly.";

/// Why the expected picture is not the true one, if so.
fn bias(frame: &Frame) -> Option<String> {
    let request = frame.request();
    let estimator = &request.settings.estimator;
    estimator.bias().map(str::to_owned).or_else(|| why_blind(&request.scene, estimator))
}

/// While there is no frame yet.
pub fn waiting_ui(ui: &mut Ui) {
    ui.label("Rendering the first picture \u{2026}");
}

/// What stands at the right end of the strip: how many warnings the scene file gave, or that files can be dropped. True
/// when the warnings are asked for.
pub fn aside_ui(ui: &mut Ui, warnings: usize) -> bool {
    let layout = Layout::right_to_left(egui::Align::Center);
    let size = vec2(ui.available_width(), ui.available_height());
    let add = |ui: &mut Ui| match warnings {
        0 => {
            let text = RichText::new("drop a .pbrt or .exr here").text_style(TextStyle::Small);
            ui.label(text.color(ui.visuals().weak_text_color()));
            false
        }
        n => {
            let text = if n == 1 { "1 warning".to_owned() } else { format!("{n} warnings") };
            let button = egui::Button::new(RichText::new(text).text_style(TextStyle::Small)).small();
            ui.add(button)
                .accessible_name("Warnings about the scene file")
                .hint("What the reader left out or changed.")
                .clicked()
        }
    };
    ui.allocate_ui_with_layout(size, layout, add).inner
}
