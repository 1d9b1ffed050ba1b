//! Whoever draws progress is told when execution time runs.

use std::sync::Arc;

use mislab_renderer::pbrt::embedded_scene;
use mislab_renderer::table::{TableOptions, Timing, TutorialRun, run_table};

#[test]
fn a_file_is_announced_before_its_time_runs_and_nothing_else_is_timed() {
    let scene = Arc::new(embedded_scene().scene);
    let options = TableOptions { size: Some([64, 64]), reference_spp: 2, replicates: 5, threads: 1, seed: 1 };
    let mut told: Vec<(Timing, String)> = Vec::new();
    run_table(&scene, &options, &mut |now| {
        let report = (now.timing, now.step.clone());
        assert!(now.finished.is_none() || now.timing == Timing::No, "its time has run");
        if told.last() != Some(&report) {
            told.push(report);
        }
        true
    })
    .expect("can be rendered");
    let files = TutorialRun::ALL.map(|run| run.file);
    let expected = files.map(|file| [Timing::Next, Timing::Now, Timing::No].map(|timing| (timing, file.to_owned())));
    assert_eq!(told[..12], *expected.as_flattened());
    assert!(told[12..].iter().all(|(timing, _)| *timing == Timing::No), "{:?}", &told[12..]);
}
