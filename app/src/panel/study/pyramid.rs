//! Each technique: its picture, its weights, both multiplied; the sum is the picture.

use eframe::egui::{Align2, Color32, Rect, TextStyle, Ui, UiBuilder, Vec2, pos2, vec2};
use mislab_renderer::{Estimator, Layer, Pace, Request, Settings, Strategy, Technique};

use super::Subject;
use super::tiles::{Tiles, Wanted, caption_that_fits, words};
use crate::look::layer::LayerLook;
use crate::look::names::strategy_name;
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{sheet_type, title};
use crate::picture::dark::SharedDarkSpots;
use crate::picture::engine::Engine;
use crate::picture::legend::{Key, legend_overlay, legend_size, legend_ui};
use crate::picture::live::LivePicture;
use crate::picture::sheet::Recorder;
use crate::state::command::Command;
use crate::state::edit::Edit;

/// What is kept of it while it is open. Nothing after: its pictures are those of the active slot.
#[derive(Default)]
pub struct Pyramid {
    open: Option<Open>,
}

/// The two renderers' worth of pictures, and what is on screen.
struct Open {
    /// Each technique alone.
    alone: Engine,
    /// What is hatched in all of them.
    dark: SharedDarkSpots,
    tiles: Tiles,
}

/// A picture of the pyramid.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    /// What the technique estimates by itself.
    Alone(Technique),
    /// Mean weight of its samples.
    Weight(Technique),
    /// What it adds to the picture.
    Weighted(Technique),
    /// The picture.
    Sum,
}

impl Part {
    /// Row by row.
    const ALL: [Self; 7] = [
        Self::Alone(Technique::Light),
        Self::Weight(Technique::Light),
        Self::Weighted(Technique::Light),
        Self::Alone(Technique::Bsdf),
        Self::Weight(Technique::Bsdf),
        Self::Weighted(Technique::Bsdf),
        Self::Sum,
    ];

    fn layer(self) -> Layer {
        match self {
            Self::Alone(_) | Self::Sum => Layer::Picture,
            Self::Weight(Technique::Light) => Layer::WeightLight,
            Self::Weight(Technique::Bsdf) => Layer::WeightBsdf,
            Self::Weighted(Technique::Light) => Layer::Light,
            Self::Weighted(Technique::Bsdf) => Layer::Bsdf,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Alone(Technique::Light) => "Light alone",
            Self::Alone(Technique::Bsdf) => "BSDF alone",
            Self::Weight(Technique::Light) => "Weight of light",
            Self::Weight(Technique::Bsdf) => "Weight of BSDF",
            Self::Weighted(Technique::Light) => "Light, weighted",
            Self::Weighted(Technique::Bsdf) => "BSDF, weighted",
            Self::Sum => "Picture",
        }
    }

    fn ink(self, ui: &Ui) -> Color32 {
        let inks = Inks::of(ui.visuals());
        match self {
            Self::Alone(t) | Self::Weight(t) | Self::Weighted(t) => match t {
                Technique::Light => inks.light,
                Technique::Bsdf => inks.bsdf,
            },
            Self::Sum => ui.visuals().text_color(),
        }
    }
}

impl Pyramid {
    /// Not on screen: nothing is rendered for it.
    pub fn rest(&mut self) {
        self.open = None;
    }

    /// One picture has the whole place; now all have theirs again. False if none had.
    pub fn step_back(&mut self) -> bool {
        self.open.as_mut().is_some_and(|open| open.tiles.enlarged.take().is_some())
    }
}

/// Draws it over all that is left of `ui`.
pub fn pyramid_ui(ui: &mut Ui, study: &mut Pyramid, subject: &Subject<'_>, out: &mut Vec<Command>) {
    let live = &subject.pictures[subject.document.active_index()];
    let request = match live.kept() {
        Some(kept) => Request::clone(kept.request()),
        None => subject.document.request(subject.document.active()),
    };
    match request.settings.estimator.strategy {
        strategy @ (Strategy::Light | Strategy::Bsdf) => {
            study.rest();
            unweighted_ui(ui, strategy, out);
        }
        Strategy::MisAll | Strategy::Mis => {
            let open = study.open.get_or_insert_with(|| Open {
                alone: Engine::new(ui.ctx(), subject.threads),
                dark: SharedDarkSpots::default(),
                tiles: Tiles::new(Part::ALL.len(), subject.pipeline, subject.document.view.placement),
            });
            open.tiles.match_device(subject.pipeline);
            open.follow(ui, &request, live, subject.pace);
            match open.tiles.enlarged {
                Some(index) => open.enlarged_ui(ui, index, subject),
                None => open.all_ui(ui, subject),
            }
        }
    }
}

/// There are no weights to show.
fn unweighted_ui(ui: &mut Ui, strategy: Strategy, out: &mut Vec<Command>) {
    title(ui, "Techniques and weights");
    ui.label(format!(
        "The strategy \u{201c}{}\u{201d} draws from one technique alone: all of its weights are 1, and its picture is that \
         technique's.",
        strategy_name(strategy)
    ));
    ui.add_space(2.0 * GRID);
    let hint = "One direction from each technique, weighted and added (3).";
    if Recorder::on_screen_only(ui, |ui| ui.button("Use MIS, both").hint(hint)).clicked() {
        out.push(Edit::SetStrategy(Strategy::MisAll).into());
    }
}

impl Open {
    /// Hands over what is to be rendered, and takes what has been.
    fn follow(&mut self, ui: &Ui, request: &Request, live: &LivePicture, pace: Pace) {
        let alone = [Strategy::Light, Strategy::Bsdf].map(|strategy| alone(request, strategy));
        self.alone.match_requests(&alone.each_ref().map(|request| Some(request.clone())));
        for (picture, request) in self.alone.pictures_mut().iter_mut().zip(alone) {
            picture.submit(request);
            picture.hold();
        }
        self.alone.set_pace(pace);
        let (alone, dark) = (self.alone.pictures(), &mut self.dark);
        let wanted = Part::ALL.map(|part| {
            let from = match part {
                Part::Alone(Technique::Light) => alone.first(),
                Part::Alone(Technique::Bsdf) => alone.get(1),
                Part::Weight(_) | Part::Weighted(_) | Part::Sum => Some(live),
            }?;
            let behind = from.marked_in().is_some_and(|wait| wait.is_zero());
            let (frame, layer) = (from.frame()?, part.layer());
            let dark = dark.of(ui.ctx(), &frame, layer);
            Some(Wanted { frame, layer, dark, behind })
        });
        self.tiles.refresh(ui.ctx(), &wanted, 1);
        drop(wanted);
        self.alone.release(ui.ctx());
    }

    /// One of them over the whole place.
    fn enlarged_ui(&mut self, ui: &mut Ui, index: usize, subject: &Subject<'_>) {
        let part = Part::ALL[index];
        ui.horizontal(|ui| {
            let hint = "All pictures again (Escape, or a click on the picture).";
            if Recorder::on_screen_only(ui, |ui| ui.button("Back").hint(hint)).clicked() {
                self.tiles.enlarged = None;
            }
            ui.colored_label(part.ink(ui), part.name());
        });
        let place = ui.available_rect_before_wrap();
        self.tiles.tile_ui(ui, index, place, &subject.document.view, part.name());
        if !LayerLook::of(part.layer()).is_colour() {
            let key = Key { quantity: part.layer().into(), view: &subject.document.view, here: None };
            legend_overlay(ui, place, place, key);
        }
    }

    fn all_ui(&mut self, ui: &mut Ui, subject: &Subject<'_>) {
        let view = &subject.document.view;
        let area = ui.available_rect_before_wrap();
        let plan = Plan::new(area, view.placement.aspect(subject.document.image.resolution), line(ui));
        for (index, part) in Part::ALL.into_iter().enumerate() {
            let tile = plan.tiles[index];
            let label = Rect::from_min_max(pos2(tile.left(), tile.top() - line(ui)), tile.right_top());
            words(ui, label, Align2::LEFT_CENTER, part.name(), TextStyle::Body, part.ink(ui));
            let name = format!("Enlarge: {}", part.name());
            let response = self.tiles.tile_ui(ui, index, tile, view, &name);
            response.hint(explained(part));
        }
        for (sign, at) in &plan.signs {
            let place = Rect::from_center_size(*at, Vec2::splat(SIGN));
            words(ui, place, Align2::CENTER_CENTER, sign, TextStyle::Heading, ui.visuals().text_color());
        }
        ui.scope_builder(UiBuilder::new().id_salt("about").max_rect(plan.about), |ui| {
            ui.set_clip_rect(plan.about.intersect(ui.clip_rect()));
            ui.scope(|ui| {
                let key = Key { quantity: Layer::WeightLight.into(), view, here: None };
                let size = legend_size(ui, key, ui.available_width());
                if size.x > plan.about.width() || size.y > plan.about.height() {
                    // Rather small than cut.
                    sheet_type(ui);
                }
                legend_ui(ui, key);
            });
            ui.add_space(GRID);
            caption_that_fits(
                ui,
                "Alone: as many samples, same seed. Weights are of samples, and a pixel shows their mean: so the product \
                 holds sample by sample, the sum pixel by pixel. Lights seen directly are in the picture only.",
                "Products hold sample by sample, the sum pixel by pixel.",
            );
        });
        ui.advance_cursor_after_rect(area);
    }
}

/// What the technique alone estimates, with the same samples.
fn alone(request: &Request, strategy: Strategy) -> Request {
    let estimator = Estimator { strategy, ..request.settings.estimator };
    Request { scene: request.scene.clone(), settings: Settings { estimator, ..request.settings.clone() } }
}

fn explained(part: Part) -> &'static str {
    match part {
        Part::Alone(_) => "f / p: the mean of this technique's samples, none of them weighted.",
        Part::Weight(_) => "w: how much of its samples counts, the rest being left to the other technique.",
        Part::Weighted(_) => "w f / p: what this technique adds to the picture.",
        Part::Sum => "The sum of both weighted pictures.",
    }
}

/// Height of the line over a tile.
fn line(ui: &Ui) -> f32 {
    ui.text_style_height(&TextStyle::Body) + GRID
}

/// Room for a sign between two tiles.
const SIGN: f32 = 7.0 * GRID;

/// Where everything is.
struct Plan {
    tiles: [Rect; 7],
    signs: Vec<(&'static str, eframe::egui::Pos2)>,
    about: Rect,
}

impl Plan {
    /// Three rows, the picture under what is added; or two, the picture to their right: whichever leaves larger pictures.
    /// `aspect`: width over height of a picture; `line`: height of the words over one.
    fn new(area: Rect, aspect: f32, line: f32) -> Self {
        let height = |columns: f32, rows: f32| {
            let across = (area.width() - (columns - 1.0) * SIGN) / columns / aspect;
            across.min((area.height() - rows * line - (rows - 1.0) * SIGN) / rows).max(1.0)
        };
        let wide = height(4.0, 2.0) > height(3.0, 3.0);
        let h = if wide { height(4.0, 2.0) } else { height(3.0, 3.0) };
        let (size, step) = (vec2(aspect * h, h), vec2(aspect * h + SIGN, h + line + SIGN));
        let columns = if wide { 4.0 } else { 3.0 };
        let left = area.left() + 0.5 * (area.width() - columns * step.x + SIGN).max(0.0);
        let at = |column: f32, row: f32| {
            Rect::from_min_size(pos2(left + column * step.x, area.top() + line + row * step.y), size)
        };
        let sum = if wide { at(3.0, 0.5) } else { at(2.0, 2.0) };
        let tiles = [at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(2.0, 1.0), sum];
        let beside = |tile: Rect| pos2(tile.left() - 0.5 * SIGN, tile.center().y);
        // Between a tile and the words over the one below.
        let under = |tile: Rect| pos2(tile.center().x, tile.bottom() + 0.5 * SIGN);
        let mut signs = vec![
            ("\u{d7}", beside(tiles[1])),
            ("=", beside(tiles[2])),
            ("\u{d7}", beside(tiles[4])),
            ("=", beside(tiles[5])),
            ("+", under(tiles[2])),
        ];
        signs.push(("=", if wide { beside(sum) } else { under(tiles[5]) }));
        let about = if wide {
            let under_sum = Rect::from_min_max(sum.left_bottom() + vec2(0.0, 2.0 * GRID), area.right_bottom());
            let top = tiles[3].bottom() + 2.0 * GRID;
            let under_rows = Rect::from_min_max(pos2(left, top), pos2(tiles[5].right(), area.bottom()));
            if under_rows.area() > under_sum.area() { under_rows } else { under_sum }
        } else {
            let top = tiles[3].bottom() + SIGN;
            Rect::from_min_max(pos2(tiles[0].left(), top), pos2(tiles[1].right(), area.bottom()))
        };
        Self { tiles, signs, about }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_apart_and_inside() {
        for (w, h, aspect) in [(620.0, 560.0, 1.0), (1240.0, 560.0, 1.0), (900.0, 900.0, 1.5), (620.0, 560.0, 0.5)] {
            let area = Rect::from_min_size(pos2(10.0, 20.0), vec2(w, h));
            let plan = Plan::new(area, aspect, 24.0);
            let mut places = plan.tiles.to_vec();
            places.push(plan.about);
            for (i, a) in places.iter().enumerate() {
                assert!(area.expand(0.5).contains_rect(*a), "{a:?} is not in {area:?}");
                assert!(places[..i].iter().all(|b| !a.shrink(0.5).intersects(*b)), "{a:?} lies over another");
            }
        }
    }
}
