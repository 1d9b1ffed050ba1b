//! The mirror image of a scene gives the mirror image of the picture.

use std::sync::Arc;

use glam::{DMat4, DVec3};
use mislab_renderer::{Channel, Estimator, Geometry, Sampling, Scene, Settings, Strategy};
use mislab_tests::experiment::{independent, render, veach};
use mislab_tests::statistics::Family;

const SIDE: usize = 160;
/// Pixels are compared in squares of this side, whose mean is nearly normal.
const SQUARE: usize = 4;
/// Squares are compared where their noise is below this part of their value.
const NOISE: f64 = 0.03;

/// The scene with x and -x exchanged. Winding and normals of faces turn round with it.
fn mirrored(scene: &Scene) -> Scene {
    let mut mirrored = scene.clone();
    let flip = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    mirrored.camera.world_from_camera = flip * scene.camera.world_from_camera * flip;
    for shape in &mut mirrored.shapes {
        match &mut shape.geometry {
            Geometry::Sphere { center, .. } => center.x = -center.x,
            Geometry::Mesh { positions, triangles } => {
                Arc::make_mut(positions).iter_mut().for_each(|p| p.x = -p.x);
                Arc::make_mut(triangles).iter_mut().for_each(|t| t.swap(1, 2));
            }
        }
    }
    mirrored
}

/// Mean and squared standard error of the green channel over squares of pixels, row by row, of a grey scene.
fn squares(scene: &Arc<Scene>, settings: &Settings) -> Vec<(f64, f64)> {
    let frame = render(scene, settings);
    let (value, variance) = (frame.channel(Channel::G), frame.channel(Channel::VarianceY));
    let (spp, count) = (f64::from(frame.spp()), (SQUARE * SQUARE) as f64);
    let mut squares = Vec::new();
    for top in (0..SIDE).step_by(SQUARE) {
        for left in (0..SIDE).step_by(SQUARE) {
            let pixels = (0..SQUARE * SQUARE).map(|i| (top + i / SQUARE) * SIDE + left + i % SQUARE);
            let (mut sum, mut error) = (0.0, 0.0);
            for i in pixels {
                sum += f64::from(value[i]);
                error += f64::from(variance[i]) / spp;
            }
            squares.push((sum / count, error / (count * count)));
        }
    }
    squares
}

#[test]
fn a_mirrored_scene_gives_the_mirrored_picture() {
    let scene = Arc::new(veach());
    let mirror = Arc::new(mirrored(&scene));
    let mut family = Family::new("mirrored picture");
    let row = SIDE / SQUARE;
    for (number, strategy) in Strategy::ALL.into_iter().enumerate() {
        let size = [SIDE as u32, SIDE as u32];
        let base = independent(512, 10 + number as u32, size);
        let settings = Settings { estimator: Estimator { strategy, ..base.estimator }, ..base };
        let here = squares(&scene, &settings);
        let there = squares(
            &mirror,
            &Settings { sampling: Sampling { seed: 20 + number as u32, ..settings.sampling }, ..settings },
        );
        let before = family.len();
        for (i, (value, error2)) in here.into_iter().enumerate() {
            let (other, other_error2) = there[i / row * row + row - 1 - i % row];
            let error = (error2 + other_error2).sqrt();
            if error < NOISE * value.max(other) {
                family.test(format!("{}, square {i}", strategy.name()), value, other, error.hypot(1e-5 * value));
            }
        }
        println!("{}: {} squares", strategy.name(), family.len() - before);
    }
    family.judge(2500);
}
