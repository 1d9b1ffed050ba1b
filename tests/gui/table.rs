//! The tutorial's table.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

use crate::lab::Lab;

#[test]
fn the_tables_run_is_in_the_status_bar() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.key(Modifiers::NONE, Key::Escape);
    assert!(!lab.has("Table progress"), "the window is closed");
    assert!(lab.has("Progress of the table"));
    lab.click("Stop the table");
    lab.until("the end of the job", |lab| !lab.has("Progress of the table"));
    assert!(lab.has("4 / 4 spp"), "the bar is about the picture again");
}

#[test]
fn the_table_is_filled_in_and_can_be_stopped() {
    let mut lab = Lab::new();
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.until("the job", |lab| lab.has("Cancel"));
    lab.click("Cancel");
    lab.until("the end of the job", |lab| !lab.has("Cancel"));
    assert!(!lab.has("small light"), "a stopped job leaves nothing");
    lab.click("Fill in the table");
    lab.until("the table", |lab| lab.has("small light"));
    assert!(lab.has("\u{d7}  "), "there are crosses");
    lab.click(".csv");
    lab.until("the file", |lab| lab.file("veach_table.csv").exists());
}

#[test]
fn every_column_is_in_view_at_a_desk_and_in_the_projector_view() {
    let mut lab = Lab::with_size([1280.0, 720.0]);
    lab.key(Modifiers::NONE, Key::T);
    lab.click("Image size of the table");
    lab.click("100 \u{d7} 100");
    lab.click("Fill in the table");
    lab.until("the table", |lab| lab.has("small light"));
    for view in ["at a desk", "in the projector view"] {
        lab.harness.run_steps(12);
        let window = lab.harness.get_by_role_and_label(Role::Window, "The tutorial's table").rect();
        assert!(window.left() >= 0.0 && window.right() <= 1280.0, "{view}: {window:?}");
        assert!(window.top() >= 0.0 && window.bottom() <= 720.0, "{view}: {window:?}");
        let cells: Vec<_> = lab.harness.query_all_by_label_contains(" \u{b1} ").map(|cell| cell.rect()).collect();
        assert!(cells.len() >= 16, "{view}: {} cells", cells.len());
        for cell in cells {
            assert!(window.contains_rect(cell), "{view}: {cell:?} in {window:?}");
        }
        lab.key(Modifiers::COMMAND, Key::B);
    }
}
