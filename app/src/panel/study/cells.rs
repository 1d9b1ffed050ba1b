//! Which settings the grid compares, and how its pictures are asked for.

use std::num::NonZeroU32;

use mislab_renderer::{
    Estimator, Heuristic, ImageSettings, OneSampleWeights, Request, SamplerKind, SamplerSettings, Sampling, Settings,
    Strategy,
};

use crate::look::names::{heuristic_name, strategy_name, weights_name};
use crate::state::document::{Document, Slot};

/// What varies over the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// Strategies in rows, heuristics in columns.
    #[default]
    Heuristics,
    /// One-sample weights in rows, c in columns.
    LightProb,
}

/// Values of c: the ends, near one, the middle, near the other.
const LIGHT_PROBS: [f32; 5] = [0.0, 0.1, 0.5, 0.9, 1.0];

/// Longer side of a cell's picture in pixels.
const SIDE: u32 = 200;
/// Camera rays per pixel of either half of the reference.
pub const REFERENCE_SPP: u32 = 512;
/// Where a picture without end stops in a cell.
const ENDLESS: NonZeroU32 = NonZeroU32::new(64).expect("not zero");

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// What is rendered.
    pub estimator: Estimator,
    /// Column and row.
    pub at: [usize; 2],
    /// What it is called.
    pub name: String,
    /// The same where its row is named already.
    pub short: String,
}

impl Axes {
    /// The cells; what does not vary is as in `own`.
    pub fn cells(self, own: &Estimator) -> Vec<Cell> {
        match self {
            Self::Heuristics => {
                let alone = [Strategy::Light, Strategy::Bsdf].into_iter().enumerate().map(|(column, strategy)| Cell {
                    estimator: Estimator { strategy, ..*own },
                    at: [column, 0],
                    name: strategy_name(strategy).to_owned(),
                    short: strategy_name(strategy).to_owned(),
                });
                let weighted = [Strategy::MisAll, Strategy::Mis].into_iter().enumerate().flat_map(|(row, strategy)| {
                    Heuristic::ALL.into_iter().enumerate().map(move |(column, heuristic)| Cell {
                        estimator: Estimator { strategy, heuristic, ..*own },
                        at: [column, row + 1],
                        name: format!("{}, {}", strategy_name(strategy), heuristic_name(heuristic).to_lowercase()),
                        short: heuristic_name(heuristic).to_owned(),
                    })
                });
                alone.chain(weighted).collect()
            }
            Self::LightProb => {
                let row = |(row, weights): (usize, OneSampleWeights)| {
                    LIGHT_PROBS.into_iter().enumerate().map(move |(column, light_prob)| Cell {
                        estimator: Estimator { strategy: Strategy::Mis, weights, light_prob, ..*own },
                        at: [column, row],
                        name: format!("c {light_prob}, {}", weights_name(weights)),
                        short: format!("c {light_prob}"),
                    })
                };
                OneSampleWeights::ALL.into_iter().enumerate().flat_map(row).collect()
            }
        }
    }

    /// What each row has alike.
    pub fn rows(self) -> &'static [&'static str] {
        match self {
            Self::Heuristics => &["One alone", "MIS, both", "MIS, one"],
            Self::LightProb => &["Veach", "Tutorial"],
        }
    }

    /// Columns and rows.
    pub fn size(self) -> [usize; 2] {
        match self {
            Self::Heuristics => [Heuristic::ALL.len(), 3],
            Self::LightProb => [LIGHT_PROBS.len(), OneSampleWeights::ALL.len()],
        }
    }
}

/// What the renderer is asked for: a picture for each cell, and the two halves of a reference.
pub fn requests(document: &Document, cells: &[Cell]) -> (Vec<Request>, [Request; 2]) {
    let image = small(document.image);
    let ask = |settings| Request { scene: document.scene.clone(), settings };
    let slot = Slot { kept: None, ..*document.active() };
    let cells = cells
        .iter()
        .map(|cell| {
            let slot = Slot { estimator: cell.estimator, ..slot };
            let settings = document.settings_at_equal_rays(&slot, document.spp.unwrap_or(ENDLESS));
            ask(Settings { image, ..settings })
        })
        .collect();
    (cells, [0, 1].map(|half| ask(reference(image, document.seed, half))))
}

/// A half of the reference: both techniques, points that converge fast, seeds far from those of the cells.
fn reference(image: ImageSettings, seed: u32, half: u32) -> Settings {
    let sampler = SamplerSettings { kind: SamplerKind::Lattice, ..Sampling::default().sampler };
    let sampling =
        Sampling { sampler, spp: NonZeroU32::new(REFERENCE_SPP), seed: seed.wrapping_add(1 << 31).wrapping_add(half) };
    Settings { estimator: Estimator::default(), sampling, image }
}

/// The same picture in fewer pixels.
fn small(image: ImageSettings) -> ImageSettings {
    let longer = image.resolution[0].max(image.resolution[1]).max(1);
    let shrink = |n: u32| (u64::from(n) * u64::from(SIDE.min(longer)) / u64::from(longer)).max(1) as u32;
    ImageSettings { resolution: image.resolution.map(shrink), ..image }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_places_of_their_own_and_differ() {
        for axes in [Axes::Heuristics, Axes::LightProb] {
            let cells = axes.cells(&Estimator::default());
            for (i, cell) in cells.iter().enumerate() {
                assert!(cell.at[0] < axes.size()[0] && cell.at[1] < axes.size()[1], "{cell:?}");
                let same = |other: &Cell| other.at == cell.at || other.estimator == cell.estimator;
                assert!(!cells[..i].iter().any(same), "{cell:?}");
            }
        }
    }

    #[test]
    fn pictures_of_cells_keep_their_shape() {
        let image = |resolution| ImageSettings { resolution, ..ImageSettings::default() };
        assert_eq!(small(image([800, 400])).resolution, [200, 100]);
        assert_eq!(small(image([60, 60])).resolution, [60, 60], "no larger than the picture itself");
    }
}
