//! Every key in one table: what dispatches, what the key sheet shows, what the palette lists.

use eframe::egui::{Context, Event, Key, Modifiers, ThemePreference};
use mislab_renderer::{Heuristic, Layer, Lockstep, OneSampleWeights, SamplerKind, Strategy};

use crate::look::layer::LayerLook;
use crate::look::names::{equal_name, heuristic_name, sampler_name, strategy_name, weights_name};
use crate::look::versus::Versus;
use crate::look::zoom::ZoomStep;
use crate::state::arrangement::Arrangement;
use crate::state::command::{Command, Figure, Shipped};
use crate::state::edit::{Edit, SppTarget};
use crate::state::study::Study;
use crate::state::view::{ToneMap, VarianceUnit};

/// A command with its name and, perhaps, its key.
pub struct Action {
    /// Section of the key sheet.
    pub group: &'static str,
    /// What it does, as the palette lists it.
    pub name: String,
    /// The key as written on screen; empty without one.
    pub keys: &'static str,
    /// Modifiers and key.
    pub shortcut: Option<(Modifiers, Key)>,
    /// What it does.
    pub command: Command,
}

const PLAIN: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// Everything that has a key, in the order of the key sheet.
#[rustfmt::skip]
pub fn bindings() -> Vec<Action> {
    let action = |group, name: &str, keys, modifiers, key, command: Command| Action {
        group, name: name.into(), keys, shortcut: Some((modifiers, key)), command,
    };
    let strategy = |keys, key, s: Strategy| {
        let name = format!("{} ({})", strategy_name(s), s.name());
        action("Strategy", &name, keys, PLAIN, key, Edit::SetStrategy(s).into())
    };
    let study = |keys, modifiers, key, s: Study| action("Study", s.name(), keys, modifiers, key, Command::ToggleStudy(s));
    let layout = |keys, key, a: Arrangement| action("Layout", a.name(), keys, PLAIN, key, Edit::Arrange(a).into());
    vec![
        strategy("1", Key::Num1, Strategy::Light),
        strategy("2", Key::Num2, Strategy::Bsdf),
        strategy("3", Key::Num3, Strategy::MisAll),
        strategy("4", Key::Num4, Strategy::Mis),
        action("Strategy", "Larger c, the share of light samples", "]", PLAIN, Key::CloseBracket, Edit::NudgeLightProb(0.05).into()),
        action("Strategy", "Smaller c", "[", PLAIN, Key::OpenBracket, Edit::NudgeLightProb(-0.05).into()),
        layout("A", Key::A, Arrangement::One),
        layout("B", Key::B, Arrangement::Beside),
        layout("W", Key::W, Arrangement::Wipe),
        layout("H", Key::H, Arrangement::Flip),
        layout("D", Key::D, Arrangement::Difference),
        layout("Q", Key::Q, Arrangement::Four),
        action("Layout", "Controls for the next picture", "X", PLAIN, Key::X, Command::ActivateNext),
        action("Layout", "Keep the picture, go on beside it", "K", PLAIN, Key::K, Command::Keep),
        action("Layout", "Compare with an EXR \u{2026}", "Shift+K", SHIFT, Key::K, Command::Compare),
        action("Layout", "This layer in all pictures", "L", PLAIN, Key::L, Edit::ShareLayer.into()),
        study("I", PLAIN, Key::I, Study::Explain),
        study("C", PLAIN, Key::C, Study::BestC),
        study("G", PLAIN, Key::G, Study::Convergence),
        study("M", PLAIN, Key::M, Study::Means),
        study("P", PLAIN, Key::P, Study::Pyramid),
        study("Shift+G", SHIFT, Key::G, Study::Grid),
        study("Shift+P", SHIFT, Key::P, Study::Plane),
        action("Rendering", "Pause, go on", "Space", PLAIN, Key::Space, Command::TogglePause),
        action("Rendering", "One pass", "S", PLAIN, Key::S, Command::Step),
        action("Rendering", "Restart", "Backspace", PLAIN, Key::Backspace, Command::Restart),
        action("View", "Brighter by half a stop", "E", PLAIN, Key::E, Edit::NudgeExposure(0.5).into()),
        action("View", "Darker by half a stop", "Shift+E", SHIFT, Key::E, Edit::NudgeExposure(-0.5).into()),
        action("View", "More offset", "O", PLAIN, Key::O, Edit::NudgeOffset(0.05).into()),
        action("View", "Less offset", "Shift+O", SHIFT, Key::O, Edit::NudgeOffset(-0.05).into()),
        action("View", "Normalise: set the exposure from the picture", "N", PLAIN, Key::N, Command::Normalise),
        action("View", "Reset exposure, offset, tone map", "R", PLAIN, Key::R, Edit::ResetView.into()),
        action("View", "Next layer", "V", PLAIN, Key::V, Edit::CycleLayer(1).into()),
        action("View", "Previous layer", "Shift+V", SHIFT, Key::V, Edit::CycleLayer(-1).into()),
        action("View", "Fit the picture", "F", PLAIN, Key::F, Command::Fit),
        action("View", "Fit plates and lights", "Shift+F", SHIFT, Key::F, Command::FitThings),
        action("View", "100 %: one pixel to one", "Ctrl+0", CTRL, Key::Num0, Command::ActualSize),
        action("File", "Open \u{2026}", "Ctrl+O", CTRL, Key::O, Command::Open),
        action("File", "Open a typed path \u{2026}", "Ctrl+Shift+O", CTRL.plus(SHIFT), Key::O, Command::OpenTyped),
        action("File", "Read the open file again", "F5", PLAIN, Key::F5, Command::Reload),
        action("File", "Save a snapshot", "Ctrl+S", CTRL, Key::S, Command::Save),
        action("File", "Copy the picture", "Ctrl+C", CTRL, Key::C, Command::CopyPicture),
        action("File", "Copy the values under the cursor", "Ctrl+Shift+C", CTRL.plus(SHIFT), Key::C, Command::CopyValues),
        action("File", "Export what is seen as PNG", "Ctrl+E", CTRL, Key::E, Command::Export(Figure::Png)),
        action("File", "Copy what is seen", "Ctrl+Shift+E", CTRL.plus(SHIFT), Key::E, Command::Export(Figure::Clipboard)),
        action("Edit", "Undo", "Ctrl+Z", CTRL, Key::Z, Command::Undo),
        action("Edit", "Redo", "Ctrl+Y", CTRL, Key::Y, Command::Redo),
        action("Window", "Projector view: hide the panels", "Ctrl+B", CTRL, Key::B, Command::TogglePanels),
        action("Window", "Full screen", "F11", PLAIN, Key::F11, Command::ToggleFullScreen),
        action("Window", "Larger", "Ctrl++", CTRL, Key::Plus, Command::ZoomInterface(ZoomStep::Larger)),
        action("Window", "Smaller", "Ctrl+\u{2212}", CTRL, Key::Minus, Command::ZoomInterface(ZoomStep::Smaller)),
        action("Window", "The tutorial's table", "T", PLAIN, Key::T, Command::ToggleTable),
        action("Window", "All commands", "Ctrl+Shift+P", CTRL.plus(SHIFT), Key::P, Command::TogglePalette),
        action("Window", "Keys", "?", PLAIN, Key::Questionmark, Command::ToggleHelp),
    ]
}

/// Second ways to the same commands, which the key sheet does not list.
fn aliases() -> [(Modifiers, Key, Command); 4] {
    [
        (CTRL.plus(SHIFT), Key::Z, Command::Redo),
        (CTRL, Key::Equals, Command::ZoomInterface(ZoomStep::Larger)),
        (SHIFT, Key::Slash, Command::ToggleHelp),
        (PLAIN, Key::F1, Command::ToggleHelp),
    ]
}

/// Everything the palette offers: all keys, then what has none.
pub fn actions() -> Vec<Action> {
    let mut all = bindings();
    let mut add = |group, name: String, command: Command| {
        all.push(Action { group, name, keys: "", shortcut: None, command });
    };
    for h in Heuristic::ALL {
        add("Weights", format!("Heuristic: {}", heuristic_name(h)), Edit::SetHeuristic(h).into());
    }
    for w in OneSampleWeights::ALL {
        add("Weights", format!("One-sample weights: {}", weights_name(w)), Edit::SetWeights(w).into());
    }
    for s in SamplerKind::ALL {
        add("Samples", format!("Sampler: {} ({})", sampler_name(s), s.name()), Edit::SetSampler(s).into());
    }
    for target in SppTarget::choices() {
        let name = match target {
            SppTarget::Passes(n) => format!("Samples per pixel: {n}"),
            SppTarget::Endless => "Samples per pixel: endless".into(),
        };
        add("Samples", name, Edit::SetSpp(target).into());
    }
    for equal in EQUAL {
        add("Layout", format!("Several pictures: equal {}", equal_name(equal)), Edit::SetEqual(equal).into());
    }
    for layer in Layer::ALL {
        add("View", format!("Layer: {}", LayerLook::of(layer).name), Edit::SetLayer(layer).into());
    }
    for tone_map in ToneMap::ALL {
        add("View", format!("Tone map: {}", tone_map.name()), Edit::SetToneMap(tone_map).into());
    }
    for versus in Versus::ALL {
        add("View", format!("A against B: {}", versus.title()), Edit::SetVersus(versus).into());
    }
    for unit in VarianceUnit::ALL {
        add("View", format!("Unit of the variance: {}", unit.title()), Edit::SetVarianceUnit(unit).into());
    }
    add("View", "Mark clipped pixels".into(), Edit::SetMarkClipped(true).into());
    add("View", "Do not mark clipped pixels".into(), Edit::SetMarkClipped(false).into());
    add("Rendering", "Full speed".into(), Command::SetRate(None));
    add("Rendering", "Slowly: two passes a second".into(), Command::SetRate(Some(2.0)));
    for shipped in Shipped::ALL {
        add("File", format!("Open: {}", shipped.name()), Command::OpenShipped(shipped));
    }
    add("File", "Export the study as SVG".into(), Command::Export(Figure::Svg));
    add("File", "Folder of snapshots \u{2026}".into(), Command::ChooseFolder);
    add("Edit", "Reset scene and settings to the file".into(), Edit::ResetScene.into());
    for (name, preference) in THEMES {
        add("Window", format!("Theme: {name}"), Command::SetTheme(preference));
    }
    add("Window", "Interface at 100 %".into(), Command::ZoomInterface(ZoomStep::Reset));
    add("Window", "Right panel".into(), Command::ToggleInspector);
    add("Window", "Reduce motion".into(), Command::ToggleMotion);
    all
}

/// What several pictures can have alike.
pub const EQUAL: [Lockstep; 3] = [Lockstep::Spp, Lockstep::Rays, Lockstep::CpuSeconds];

/// The themes by name.
pub const THEMES: [(&str, ThemePreference); 3] =
    [("Light", ThemePreference::Light), ("Dark", ThemePreference::Dark), ("System", ThemePreference::System)];

/// The commands of the keys pressed since the last pass. Text being typed is left alone.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    let typing = ctx.text_edit_focused();
    // Tab walks through the controls; the one it stopped at keeps Space for itself.
    let focused = ctx.memory(|m| m.focused().is_some());
    let table: Vec<(Modifiers, Key, Command)> = bindings()
        .into_iter()
        .filter_map(|a| a.shortcut.map(|(modifiers, key)| (modifiers, key, a.command)))
        .chain(aliases())
        .collect();
    let mut commands = Vec::new();
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let (key, modifiers) = match event {
                Event::Key { key, pressed: true, modifiers, .. } => (*key, *modifiers),
                // The window system turns Ctrl+C into this; Shift is still told apart.
                Event::Copy if !typing => {
                    let values = input.modifiers.shift;
                    commands.push(if values { Command::CopyValues } else { Command::CopyPicture });
                    return false;
                }
                _ => return true,
            };
            let with_control = modifiers.command || matches!(key, Key::F1 | Key::F5 | Key::F11);
            if typing && (!with_control || edits_text(key)) {
                return true;
            }
            if focused && matches!(key, Key::Space) {
                return true;
            }
            let same = |wanted: &Modifiers| {
                let shift_free = key == Key::Questionmark || key == Key::Plus;
                wanted.command == modifiers.command && (wanted.shift == modifiers.shift || shift_free) && !modifiers.alt
            };
            match table.iter().find(|(wanted, k, _)| *k == key && same(wanted)) {
                Some((_, _, command)) => {
                    commands.push(command.clone());
                    false
                }
                None => true,
            }
        });
    });
    commands
}

/// Keys that mean something of their own while text is edited.
fn edits_text(key: Key) -> bool {
    matches!(key, Key::Z | Key::Y | Key::C | Key::X | Key::V | Key::A | Key::Backspace)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_has_two_meanings() {
        let mut seen = std::collections::HashSet::new();
        let keys = bindings().into_iter().filter_map(|a| a.shortcut).chain(aliases().map(|(m, k, _)| (m, k)));
        for (modifiers, key) in keys {
            assert!(seen.insert((modifiers.command, modifiers.shift, key)), "{key:?} with {modifiers:?} twice");
        }
    }
}
