//! A file that asks for two strategies: the last one counts, as in pbrt, and the picture is not taken for one of the other.

use mislab_renderer::Strategy;

use crate::{assert_warning, parse};

const LIGHT: &str = "Integrator \"veachMIS\" \"string MISstrategy\" \"light\"\n";
const BOTH: &str = "SurfaceIntegrator \"veachMIS\" \"string sample_method\" \"mis_all\"\n";
const FILM: &str = "Film \"image\" \"string filename\" \"veach_MIS_ALLx36.exr\"\n";
const OTHER_FILM: &str = "Film \"image\" \"string filename\" \"veachMIS_L.exr\"\n";
const REST: &str = "Camera \"perspective\" WorldBegin WorldEnd";

#[test]
fn of_two_strategies_the_one_that_counts_is_said() {
    let words = ["Integrator after the SurfaceIntegrator of line 2", "this one counts", ": by light, not by mis_all"];
    let file = assert_warning(&format!("{FILM}{BOTH}{LIGHT}{REST}"), 3, 1, &words);
    assert_eq!(file.settings.estimator.strategy, Strategy::Light);
    let file = parse(&format!("{LIGHT}{LIGHT}{FILM}{REST}"));
    assert!(file.warnings.iter().all(|w| !w.message.contains("not by")), "{:?}", file.warnings);
}

#[test]
fn one_film_for_two_strategies_may_be_meant_for_either() {
    let doubtful = |header: &[&str]| parse(&format!("{}{REST}", header.concat())).contradicts_itself;
    assert!(doubtful(&[FILM, BOTH, LIGHT]) && doubtful(&[BOTH, FILM, LIGHT]) && doubtful(&[LIGHT, BOTH, FILM]));
    // A header before or after another one, both whole.
    assert!(!doubtful(&[OTHER_FILM, LIGHT, FILM, BOTH]) && !doubtful(&[BOTH, FILM, OTHER_FILM, LIGHT]));
    assert!(!doubtful(&[LIGHT, LIGHT, OTHER_FILM]) && !doubtful(&[FILM, BOTH]));
    // Of another program's integrator there is nothing to be meant.
    assert!(!doubtful(&["Integrator \"path\"\n", BOTH, FILM]));
}
