//! What is on paper: no trace of the mouse, and nothing to press.

use std::path::Path;

use eframe::egui::{self, Key, Modifiers};
use mislab::state::command::{Command, Figure};

use crate::lab::Lab;

/// Width, and pixels in rows.
fn png(path: &Path) -> (u32, Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("is there"));
    let mut reader = png::Decoder::new(file).read_info().expect("is a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("fits")];
    let info = reader.next_frame(&mut bytes).expect("is whole");
    (info.width, bytes)
}

fn rest_of(lab: &mut Lab, at: egui::Pos2) {
    lab.harness.hover_at(at);
    lab.harness.run_steps(45);
}

/// Exports twice, the mouse away and at a place of the window; both figures are the same to the bit.
#[track_caller]
fn exports_without(lab: &mut Lab, at: egui::Pos2, name: &str) {
    lab.harness.remove_cursor();
    lab.harness.run_steps(5);
    lab.key(Modifiers::COMMAND, Key::E);
    let first = lab.file(&format!("{name}.png"));
    lab.until("the figure without a mouse", |_| first.exists());
    rest_of(lab, at);
    lab.key(Modifiers::COMMAND, Key::E);
    let second = lab.file(&format!("{name}_2.png"));
    lab.until("the figure under the mouse", |_| second.exists());
    let [(width, first), (_, second)] = [png(&first), png(&second)];
    let differ = first.iter().zip(&second).position(|(a, b)| a != b).map(|byte| byte as u32 / 4);
    let at = differ.map(|pixel| [pixel % width, pixel / width]);
    assert!(first.len() == second.len() && at.is_none(), "{name} depends on the mouse at pixel {at:?}");
}

#[test]
fn the_mouse_is_in_no_figure_of_pictures_and_comes_back() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    let middle = lab.picture_rects()[0].center();
    rest_of(&mut lab, middle);
    assert!(lab.has("Pixel: x "), "it reads a pixel");
    exports_without(&mut lab, middle, "small_layout");
    lab.harness.run_steps(5);
    assert!(lab.has("Pixel: x "), "and goes on doing so");
}

#[test]
fn the_mouse_is_in_no_figure_of_a_study() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::SHIFT, Key::P);
    let map = "Map: best strategy by roughness and light radius";
    lab.until("the map", |lab| lab.has(map) && !lab.has(" \u{2026}"));
    let place = lab.rect(map).lerp_inside(egui::vec2(0.75, 0.25));
    exports_without(&mut lab, place, "small_plane");
    lab.key(Modifiers::SHIFT, Key::G);
    lab.until("all errors", |lab| !lab.has("relMSE \u{2026}") && !lab.has("so far"));
    let place = lab.rect("Enlarge: MIS, both, balance").center();
    exports_without(&mut lab, place, "small_grid");
}

#[test]
fn buttons_are_left_out_with_their_room() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::G);
    lab.until("curves", |lab| lab.has("MIS, both: slope \u{2212}"));
    lab.apply(Command::Export(Figure::Svg));
    let file = lab.file("small_convergence.svg");
    lab.until("the file", |_| file.exists());
    let text = std::fs::read_to_string(&file).expect("a text");
    for button in ["CSV", "Draw your prediction", "From a file \u{2026}"] {
        assert!(!text.contains(&format!(">{button}<")), "{button} is nothing on paper");
    }
    for said in ["Convergence", "relMSE", "samples per pixel", "MIS, both: slope"] {
        assert!(text.contains(said), "{said} is");
    }
    let height = text.split("height=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse::<f32>().ok());
    let (height, plot) = (height.expect("it has a height"), lab.rect("Plot of errors"));
    // Two rows of controls are above the plot; below it stand slopes and sentences, and the line that says what it is.
    assert!(height < lab.size[1] - plot.top() + 60.0, "{height} points, the plot begins at {}", plot.top());
}
