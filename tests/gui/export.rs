//! Figures of what is seen: files and clipboard.

use std::path::Path;

use eframe::egui::{Key, Modifiers, OutputCommand};
use mislab::state::command::{Command, Figure};
use mislab::state::edit::Edit;
use mislab::state::study::Study;
use mislab_renderer::Layer;

use crate::lab::Lab;

/// Size and pixels of a PNG.
fn png(path: &Path) -> ([usize; 2], Vec<[u8; 4]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("is there"));
    let mut reader = png::Decoder::new(file).read_info().expect("is a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("fits")];
    let info = reader.next_frame(&mut bytes).expect("is whole");
    let pixels = bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    ([info.width as usize, info.height as usize], pixels)
}

fn count(pixels: &[[u8; 4]], like: impl Fn([i32; 3]) -> bool) -> usize {
    pixels.iter().filter(|p| like([0, 1, 2].map(|i| i32::from(p[i])))).count()
}

#[test]
fn four_pictures_become_a_figure_with_their_captions() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::Q);
    lab.settle_all();
    let rects = lab.picture_rects();
    lab.key(Modifiers::COMMAND, Key::E);
    lab.until("the file", |lab| lab.has("Exported small_layout.png to"));
    let (size, pixels) = png(&lab.file("small_layout.png"));
    let both = rects[3].right() - rects[0].left();
    assert!((size[0] as f32 - 2.0 * both).abs() <= 2.0, "two pixels a point: {size:?} of {both} points");
    assert!(size[1] as f32 > 2.0 * (rects[3].bottom() - rects[0].top()), "with captions");
    // Names of strategies in their colours: blue and green letters are in no picture.
    let blue = count(&pixels, |[r, g, b]| b > 200 && r < 120 && g > 140);
    let green = count(&pixels, |[r, g, b]| g > 170 && r < 90 && b < 170);
    assert!(blue > 50 && green > 50, "{blue} blue and {green} green pixels");
    // Pixels of the picture, each of them once: the largest light is white.
    let light = count(&pixels[..pixels.len() / 2], |[r, g, b]| r == 255 && g == 255 && b == 255);
    assert!(light > 4000, "{light} white pixels");
    lab.key(Modifiers::COMMAND, Key::E);
    lab.until("the next name", |lab| lab.file("small_layout_2.png").exists());
}

#[test]
fn false_colours_have_their_legend_wherever_it_stands_in_the_window() {
    let mut lab = Lab::new();
    lab.key(Modifiers::COMMAND, Key::E);
    lab.until("the picture", |lab| lab.file("small_mis_all_4spp_layout.png").exists());
    let (plain, _) = png(&lab.file("small_mis_all_4spp_layout.png"));
    lab.apply(Edit::SetLayer(Layer::ShareLight));
    lab.key(Modifiers::COMMAND, Key::E);
    lab.until("the layer", |lab| lab.file("small_mis_all_4spp_layout_2.png").exists());
    let (size, pixels) = png(&lab.file("small_mis_all_4spp_layout_2.png"));
    assert!(size[0] == plain[0] && size[1] > plain[1] + 80, "{size:?} after {plain:?}");
    let strip = &pixels[size[0] * (plain[1] - 110)..];
    let amber = count(strip, |[r, g, b]| r > 180 && g > 110 && b < 60);
    let blue = count(strip, |[r, g, b]| b > 140 && r < 60 && g > 60);
    assert!(amber > 500 && blue > 500, "{amber} amber and {blue} blue pixels under the picture");
}

#[test]
fn a_figure_goes_to_the_clipboard() {
    let mut lab = Lab::new();
    lab.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::E);
    let copied = std::cell::Cell::new(None);
    lab.until("the figure", |lab| {
        let commands = &lab.harness.output().platform_output.commands;
        let image = commands.iter().find_map(|command| match command {
            OutputCommand::CopyImage(image) => Some(image.size),
            OutputCommand::CopyText(_) | OutputCommand::OpenUrl(_) | OutputCommand::TextSelectionSettled(_) => None,
        });
        copied.set(copied.get().or(image));
        copied.get().is_some()
    });
    let rect = lab.picture_rects()[0];
    let width = copied.get().expect("copied")[0] as f32;
    assert!((width - 2.0 * rect.width()).abs() <= 2.0, "{width} pixels of {} points", rect.width());
    assert!(!lab.file("small_mis_all_4spp_layout.png").exists(), "no file");
}

#[test]
fn a_study_becomes_an_svg_and_pictures_do_not() {
    let mut lab = Lab::new();
    lab.apply(Command::Export(Figure::Svg));
    lab.harness.step();
    assert!(lab.has("An SVG is made of a study"));
    lab.apply(Command::ToggleStudy(Study::Grid));
    lab.apply(Command::Export(Figure::Svg));
    lab.until("the file", |lab| lab.has("Exported small_grid.svg to"));
    let text = std::fs::read_to_string(lab.file("small_grid.svg")).expect("a text");
    assert!(text.starts_with("<svg ") && text.ends_with("</svg>\n"));
    assert!(text.contains(": Grid of pictures</text>"), "what it is: {text}");
}
