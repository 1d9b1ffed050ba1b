//! The exposure of a picture, wherever there is one to set.

use eframe::egui::Ui;

use crate::panel::hint;
use crate::panel::math::text;
use crate::panel::widgets::{ParamSlider, Scale};
use crate::state::view::ViewState;

/// A slider for stops, over the width of the column, named `name` in `label_width` points. `remark` says what does not
/// change with it, and its keys. Returns what it is moved to.
pub fn exposure_ui(
    ui: &mut Ui,
    (name, label_width): (&str, f32),
    view: &ViewState,
    default: f32,
    remark: &str,
) -> Option<f32> {
    let slider = ParamSlider {
        name,
        label_width,
        value: f64::from(view.exposure_ev),
        default: f64::from(default),
        range: -10.0..=10.0,
        scale: Scale::Linear(1),
        template: "-10.0",
        unit: " EV",
        accent: None,
        zero_text: "",
        explain: &|ui| {
            text("x = 2^EV L + offset").show(ui, 18.0);
            hint::lines(ui, &format!("Exposure in stops: the picture times 2^EV. {remark}"), &[]);
        },
    };
    slider.show(ui).changed.map(|ev| ev as f32)
}
