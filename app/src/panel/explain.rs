//! What layers, controls and numbers are: the formula, a sentence, and the tutorial's word for it.

use eframe::egui::Ui;
use mislab_renderer::{Channel, Estimator, Heuristic, Layer, Strategy};

use crate::look::names::strategy_description;
use crate::look::theme::Inks;
use crate::panel::formula::{Technique, formulas, weight};
use crate::panel::hint::lines;
use crate::panel::math::{Math, frac, row, sub, text};

/// Size of type of a formula in a hint.
const SIZE: f32 = 18.0;

/// A layer.
pub fn layer(ui: &mut Ui, layer: Layer) {
    let inks = Inks::of(ui.visuals());
    let [light, bsdf] = Technique::both(inks);
    let mean = |inner: Math| row([text("mean of  "), inner]);
    let plain = |base: &str, index: &str| sub(base, index, ui.visuals().text_color());
    let contribution = |t: &Technique| row([t.w(), Math::Gap(0.1), frac(text("f"), t.p())]);
    let both = || row([text("Y("), light.letter("L"), text(") + Y("), bsdf.letter("L"), text(")")]);
    let (formula, what, tutorial) = match layer {
        Layer::Picture => (
            row([text("L  =  "), plain("L", "e"), text("  +  "), light.letter("L"), text("  +  "), bsdf.letter("L")]),
            "The picture: lamps that are seen, plus what the light samples and the BSDF samples contribute.",
            "The tutorial's image.",
        ),
        Layer::Light => (
            row([light.letter("L"), text("  =  "), mean(contribution(&light))]),
            "What the light samples contribute to the picture, weighted. Divided by c too where one technique is drawn.",
            "The tutorial: f * Li * AbsDot * MISweight / lightPdf.",
        ),
        Layer::Bsdf => (
            row([bsdf.letter("L"), text("  =  "), mean(contribution(&bsdf))]),
            "What the BSDF samples contribute to the picture, weighted. Divided by 1 \u{2212} c too where one technique is drawn.",
            "The tutorial: f * Li * AbsDot * MISweight / bsdfPdf.",
        ),
        Layer::WeightLight => (
            row([mean(light.w()), text(" ,   "), light.w(), text("  =  "), balance(&light, &bsdf)]),
            "The mean weight of the light samples that carried light; on the right the balance heuristic.",
            "The tutorial's MISweight of the light sample.",
        ),
        Layer::WeightBsdf => (
            row([mean(bsdf.w()), text(" ,   "), bsdf.w(), text("  =  "), balance(&bsdf, &light)]),
            "The mean weight of the BSDF samples that carried light; on the right the balance heuristic.",
            "The tutorial's MISweight of the BSDF sample.",
        ),
        Layer::ShareLight => (
            frac(row([text("Y("), light.letter("L"), text(")")]), both()),
            "How much of the reflected light the light samples bring: which technique a pixel lives from. Y is luminance.",
            "The tutorial asks for it in words: which sampling is better where?",
        ),
        Layer::Variance => (
            row([text("V  =  "), text("mean of Y\u{b2}  \u{2212}  (mean of Y)\u{b2}")]),
            "Variance of the luminance of one sample per pixel; n samples have V / n. What the noise is made of.",
            "The tutorial's \u{201c}quality\u{201d}, as a number.",
        ),
    };
    formula.show(ui, SIZE);
    let names: Vec<&str> = layer.channels().iter().map(|channel: &Channel| channel.exr_name()).collect();
    lines(ui, what, &[tutorial, &format!("In the EXR file: {}", names.join(", "))]);
}

/// The weight of the samples of `of` by the balance heuristic.
fn balance(of: &Technique, other: &Technique) -> Math {
    frac(of.p(), row([of.p(), text(" + "), other.p()]))
}

/// A strategy.
pub fn strategy(ui: &mut Ui, estimator: &Estimator, strategy: Strategy) {
    let inks = Inks::of(ui.visuals());
    for formula in formulas(&Estimator { strategy, ..*estimator }, inks) {
        formula.show(ui, SIZE);
    }
    let tutorial = match strategy {
        Strategy::Light => "The tutorial: sampling according to the light source.",
        Strategy::Bsdf => "The tutorial: sampling according to the BSDF.",
        Strategy::MisAll => "The tutorial: multi-sample model.",
        Strategy::Mis => "The tutorial: one-sample model.",
    };
    let file = format!("In a scene file: \"string MISstrategy\" [\"{}\"]", strategy.name());
    lines(ui, strategy_description(strategy), &[tutorial, &file]);
}

/// A heuristic.
pub fn heuristic(ui: &mut Ui, heuristic: Heuristic) {
    let [light, bsdf] = Technique::both(Inks::of(ui.visuals()));
    row([light.w(), text("  =  "), weight(heuristic, &light, &bsdf, None)]).show(ui, SIZE);
    let what = match heuristic {
        Heuristic::Balance => "Weights in proportion to the densities.",
        Heuristic::Power => "Weights in proportion to the squared densities.",
        Heuristic::Cutoff => "Densities below a tenth of the larger are dropped, the rest is balanced.",
        Heuristic::Maximum => "The technique with the larger density takes all.",
    };
    let tutorial = match heuristic {
        Heuristic::Balance => "The tutorial's heuristic.",
        Heuristic::Power | Heuristic::Cutoff | Heuristic::Maximum => "Veach's thesis, section 9.2.",
    };
    lines(ui, what, &[tutorial, &format!("In a scene file: \"string heuristic\" [\"{}\"]", heuristic.name())]);
}

/// c.
pub fn light_prob(ui: &mut Ui, matters: bool) {
    let [light, bsdf] = Technique::both(Inks::of(ui.visuals()));
    row([text("d  =  c "), light.p(), text("  +  (1 \u{2212} c) "), bsdf.p()]).show(ui, SIZE);
    let what = if matters {
        "c: probability of drawing the direction from the lights. Keys [ and ] by 0.05."
    } else {
        "c: probability of drawing from the lights. Takes part in strategy 4 only."
    };
    lines(ui, what, &["The tutorial's sample_L_pdf.", "In a scene file: \"float lightprob\" [0.5]"]);
}

/// Roughness.
pub fn roughness(ui: &mut Ui) {
    row([text("D(h)  ~  1 / (cos\u{b2}\u{3b8} (\u{3b1}\u{b2} \u{2212} 1) + 1)\u{b2}")]).show(ui, SIZE);
    lines(
        ui,
        "\u{3b1}: width of the GGX lobe. At 0 the plate is a mirror, and only BSDF samples find the light.",
        &[
            "The tutorial: narrow or broad BRDF lobe, glossiness.",
            "In a scene file: \"float roughness\"; double-click: back to it",
        ],
    );
}

/// Radius of a light.
pub fn radius(ui: &mut Ui) {
    row([text("r\u{b2} L"), text("  stays,  "), text("solid angle  ~  r\u{b2}")]).show(ui, SIZE);
    lines(
        ui,
        "Radius of the light at the same power: smaller is brighter, and harder to hit for BSDF samples.",
        &["The tutorial: small and large light.", "In a scene file: \"float radius\"; double-click: back to it"],
    );
}
