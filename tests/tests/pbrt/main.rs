//! The scene reader: every directive, the tutorial's headers, places of messages, and damaged files.

mod coincident;
mod damage;
mod files;
mod header;
mod materials;
mod messages;
mod names;
mod outside;
mod shapes;
mod shipped;
mod surfaces_in_one_place;
mod transformations;
mod tutorial;
mod two_integrators;

use std::sync::Arc;

use glam::{DMat4, Vec3};
use mislab_renderer::pbrt::{self, SceneFile};
use mislab_renderer::{Error, Geometry, Shape};

fn parse(text: &str) -> SceneFile {
    pbrt::parse(text, "test.pbrt", None).unwrap_or_else(|e| panic!("{e}\nin\n{text}"))
}

/// Line, column and message of the error.
fn failure(text: &str) -> (u32, u32, String) {
    match pbrt::parse(text, "test.pbrt", None) {
        Err(Error::Scene(d)) => {
            assert_eq!(&*d.location.file, "test.pbrt", "the message names the file");
            assert!(!d.message.contains('\n'), "a message is one line: {}", d.message);
            (d.location.line, d.location.column, d.message)
        }
        Err(e) => panic!("expected an error with a place, found {e}"),
        Ok(_) => panic!("expected an error in\n{text}"),
    }
}

/// Fails unless the error is at that place and its message contains all the words.
#[track_caller]
fn assert_failure(text: &str, line: u32, column: u32, words: &[&str]) {
    let (l, c, message) = failure(text);
    assert_eq!((l, c), (line, column), "{message}");
    for word in words {
        assert!(message.contains(word), "expected {word:?} in {message:?}");
    }
}

/// Fails unless the scene is read with a warning at that place that contains all the words.
#[track_caller]
fn assert_warning(text: &str, line: u32, column: u32, words: &[&str]) -> SceneFile {
    let file = parse(text);
    let found = warnings(&file);
    let here = |(l, c, m): &(u32, u32, &str)| (*l, *c) == (line, column) && words.iter().all(|word| m.contains(word));
    assert!(found.iter().any(here), "expected {words:?} at {line}:{column} in {found:#?}");
    file
}

/// Fails unless something at that place is left out with a warning that contains all the words.
#[track_caller]
fn assert_left_out(text: &str, line: u32, column: u32, words: &[&str]) {
    assert_warning(text, line, column, &[words, &["left out"]].concat());
}

/// A whole file around the content of a world.
fn world(body: &str) -> String {
    format!("Camera \"perspective\"\nWorldBegin\n{body}\nWorldEnd\n")
}

/// Warnings as (line, column, message).
fn warnings(file: &SceneFile) -> Vec<(u32, u32, &str)> {
    file.warnings.iter().map(|w| (w.location.line, w.location.column, w.message.as_str())).collect()
}

#[track_caller]
fn assert_no_warnings(file: &SceneFile) {
    assert!(file.warnings.is_empty(), "unexpected warnings: {:?}", file.warnings);
}

#[track_caller]
fn assert_matrix(found: DMat4, rows: [[f64; 4]; 4], tolerance: f64) {
    let expected = DMat4::from_cols_array_2d(&rows).transpose();
    assert!(found.abs_diff_eq(expected, tolerance), "found\n{found}\nexpected\n{expected}");
}

fn sphere(shape: &Shape) -> (Vec3, f32) {
    match &shape.geometry {
        Geometry::Sphere { center, radius } => (*center, *radius),
        Geometry::Mesh { .. } => panic!("expected a sphere"),
    }
}

fn mesh(shape: &Shape) -> (&Arc<Vec<Vec3>>, &Arc<Vec<[u32; 3]>>) {
    match &shape.geometry {
        Geometry::Mesh { positions, triangles } => (positions, triangles),
        Geometry::Sphere { .. } => panic!("expected a mesh"),
    }
}

/// The matrix after some transformations, read off the camera: it keeps the inverse.
fn ctm(directives: &str) -> DMat4 {
    parse(&format!("{directives}\nCamera \"perspective\"\nWorldBegin WorldEnd"))
        .scene
        .camera
        .world_from_camera
        .inverse()
}
