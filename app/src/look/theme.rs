//! The look: one language of colour, three sizes of type, a grid of four points.
//!
//! Two techniques, two colours, everywhere the same (Okabe and Ito's colour-blind safe set): light
//! sampling is amber, BSDF sampling is blue. Red means "wrong" and nothing else is coloured.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::{
    self, Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Margin, Shadow, Stroke, Style,
    TextStyle, Theme, Visuals, vec2,
};
use mislab_renderer::Strategy;

/// The unit of every distance in the window, in points.
pub const GRID: f32 = 4.0;

/// How large type is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeScale {
    /// At a desk.
    Desk,
    /// From the last row of a lecture hall: nothing below 24 points.
    Hall,
}

impl TypeScale {
    /// Sizes of caption, body and title in points.
    pub fn sizes(self) -> [f32; 3] {
        match self {
            Self::Desk => [14.0, 16.0, 20.0],
            Self::Hall => [24.0, 26.0, 32.0],
        }
    }

    /// Height of anything one can click, in points.
    pub fn row_height(self) -> f32 {
        match self {
            Self::Desk => 24.0,
            Self::Hall => 42.0,
        }
    }
}

/// The medium weight, for titles and for what is on.
pub fn medium() -> FontFamily {
    FontFamily::Name("medium".into())
}

/// The coloured part of the vocabulary, by theme.
#[derive(Clone, Copy, Debug)]
pub struct Inks {
    /// Dark theme?
    pub dark: bool,
    /// Light technique as ink: text, lines, dots.
    pub light: Color32,
    /// BSDF technique as ink.
    pub bsdf: Color32,
    /// Wrong, and nothing else.
    pub wrong: Color32,
}

impl Inks {
    /// The inks of the theme `visuals` belongs to.
    pub fn of(visuals: &Visuals) -> Self {
        if visuals.dark_mode {
            Self {
                dark: true,
                light: Color32::from_rgb(0xF2, 0xB2, 0x33),
                bsdf: Color32::from_rgb(0x5A, 0xB0, 0xE6),
                wrong: Color32::from_rgb(0xFF, 0x6B, 0x5E),
            }
        } else {
            Self {
                dark: false,
                light: Color32::from_rgb(0xA8, 0x6C, 0x00),
                bsdf: Color32::from_rgb(0x00, 0x72, 0xB2),
                wrong: Color32::from_rgb(0xC6, 0x1A, 0x09),
            }
        }
    }

    /// A strategy as ink.
    pub fn strategy(self, strategy: Strategy) -> Color32 {
        match (strategy, self.dark) {
            (Strategy::Light, _) => self.light,
            (Strategy::Bsdf, _) => self.bsdf,
            (Strategy::MisAll, true) => Color32::from_rgb(0xDE, 0x9A, 0xC0),
            (Strategy::MisAll, false) => Color32::from_rgb(0xA5, 0x45, 0x7B),
            (Strategy::Mis, true) => Color32::from_rgb(0x2F, 0xC4, 0x98),
            (Strategy::Mis, false) => Color32::from_rgb(0x00, 0x7F, 0x5C),
        }
    }
}

/// A strategy as the fill of a large area, the same in both themes, and the text to put on it.
pub fn strategy_fill(strategy: Strategy) -> (Color32, Color32) {
    match strategy {
        Strategy::Light => (Color32::from_rgb(0xE6, 0x9F, 0x00), Color32::BLACK),
        Strategy::Bsdf => (Color32::from_rgb(0x00, 0x72, 0xB2), Color32::WHITE),
        Strategy::MisAll => (Color32::from_rgb(0xCC, 0x79, 0xA7), Color32::BLACK),
        Strategy::Mis => (Color32::from_rgb(0x00, 0x9E, 0x73), Color32::BLACK),
    }
}

/// Installs both styles. Call again when the scale changes.
pub fn install(ctx: &egui::Context, scale: TypeScale, reduce_motion: bool) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| {
            *style = style_for(theme, scale);
            if reduce_motion {
                style.animation_time = 0.0;
                style.scroll_animation = egui::style::ScrollAnimation::none();
            }
        });
    }
}

/// One family for words and numbers. Roboto's figures are all of one width, so counters stand still.
pub fn install_fonts(ctx: &egui::Context) {
    let mut fonts = FontDefinitions::default();
    let regular = include_bytes!("../../../assets/fonts/Roboto-Regular.ttf").as_slice();
    let strong = include_bytes!("../../../assets/fonts/Roboto-Medium.ttf").as_slice();
    fonts.font_data.insert("roboto".into(), Arc::new(FontData::from_static(regular)));
    fonts.font_data.insert("roboto-medium".into(), Arc::new(FontData::from_static(strong)));
    let fallbacks = fonts.families.get(&FontFamily::Proportional).cloned().unwrap_or_default();
    let family = |first: &str| std::iter::once(first.to_owned()).chain(fallbacks.iter().cloned()).collect::<Vec<_>>();
    fonts.families.insert(FontFamily::Proportional, family("roboto"));
    fonts.families.insert(medium(), family("roboto-medium"));
    ctx.set_fonts(fonts);
}

fn style_for(theme: Theme, scale: TypeScale) -> Style {
    let [caption, body, title] = scale.sizes();
    let text_styles = BTreeMap::from([
        (TextStyle::Small, FontId::new(caption, FontFamily::Proportional)),
        (TextStyle::Body, FontId::new(body, FontFamily::Proportional)),
        (TextStyle::Button, FontId::new(body, FontFamily::Proportional)),
        (TextStyle::Monospace, FontId::new(body, FontFamily::Monospace)),
        (TextStyle::Heading, FontId::new(title, medium())),
    ]);
    let mut style = Style { visuals: visuals_for(theme), text_styles, animation_time: 0.12, ..Style::default() };
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(2.0 * GRID, GRID);
    spacing.button_padding = vec2(2.5 * GRID, 0.5 * GRID);
    spacing.interact_size = vec2(10.0 * GRID, scale.row_height());
    spacing.window_margin = Margin::same(12);
    spacing.menu_margin = Margin::same(12);
    spacing.slider_rail_height = GRID;
    spacing.icon_width = 0.75 * scale.row_height();
    spacing.icon_width_inner = 0.4 * scale.row_height();
    spacing.icon_spacing = 2.0 * GRID;
    spacing.combo_height = 600.0;
    spacing.tooltip_width = 360.0;
    spacing.scroll = egui::style::ScrollStyle::thin();
    style.interaction.selectable_labels = false;
    style.interaction.tooltip_delay = 0.4;
    style
}

fn visuals_for(theme: Theme) -> Visuals {
    // Neutral grey throughout: a tint around a picture changes how the picture is judged.
    struct Greys {
        panel: u8,
        field: u8,
        control: u8,
        hover: u8,
        pressed: u8,
        line: u8,
        text: u8,
        weak: u8,
        selected: u8,
    }
    let (mut visuals, g) = match theme {
        Theme::Dark => (
            Visuals::dark(),
            Greys {
                panel: 34,
                field: 22,
                control: 54,
                hover: 68,
                pressed: 82,
                line: 62,
                text: 234,
                weak: 172,
                selected: 104,
            },
        ),
        Theme::Light => (
            Visuals::light(),
            Greys {
                panel: 255,
                field: 246,
                control: 236,
                hover: 224,
                pressed: 208,
                line: 206,
                text: 0,
                weak: 84,
                selected: 186,
            },
        ),
    };
    let grey = Color32::from_gray;
    let round = CornerRadius::same(4);
    visuals.panel_fill = grey(g.panel);
    visuals.window_fill = grey(g.panel);
    visuals.extreme_bg_color = grey(g.field);
    visuals.faint_bg_color = grey(g.field);
    visuals.window_stroke = Stroke::new(1.0, grey(g.line));
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = round;
    let shadow = Shadow { offset: [0, 4], blur: 16, spread: 0, color: Color32::from_black_alpha(90) };
    visuals.window_shadow = shadow;
    visuals.popup_shadow = shadow;
    visuals.selection.bg_fill = grey(g.selected);
    visuals.selection.stroke = Stroke::new(1.5, grey(if g.text > 128 { 255 } else { 0 }));
    visuals.weak_text_color = Some(grey(g.weak));
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Circle;
    let inks = Inks::of(&visuals);
    visuals.error_fg_color = inks.wrong;
    visuals.warn_fg_color = grey(g.text);
    visuals.hyperlink_color = grey(g.text);
    visuals.text_cursor.stroke = Stroke::new(2.0, grey(g.text));

    let widgets = &mut visuals.widgets;
    for (state, fill, line) in [
        (&mut widgets.noninteractive, g.panel, g.line),
        (&mut widgets.inactive, g.control, g.line),
        (&mut widgets.hovered, g.hover, g.weak),
        (&mut widgets.active, g.pressed, g.text),
        (&mut widgets.open, g.hover, g.weak),
    ] {
        state.bg_fill = grey(fill);
        state.weak_bg_fill = grey(fill);
        state.bg_stroke = Stroke::new(1.0, grey(line));
        state.fg_stroke = Stroke::new(1.5, grey(g.text));
        state.corner_radius = round;
        state.expansion = 0.0;
    }
    widgets.noninteractive.fg_stroke.width = 1.0;
    widgets.inactive.bg_stroke = Stroke::NONE;
    visuals
}
