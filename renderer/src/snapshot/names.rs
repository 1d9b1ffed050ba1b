//! Names of the attributes this program writes. OpenEXR's limit is 31 characters.

/// Version of the `mislab...` attributes; a reader refuses larger numbers.
pub(super) const FORMAT: i32 = 2;

pub(super) const FORMAT_NAME: &str = "mislabFormat";
pub(super) const SETTINGS: &str = "mislabSettings";
pub(super) const SCENE: &str = "mislabScene";
/// Instead of [`SCENE`]: why it is not there.
pub(super) const SCENE_MISSING: &str = "mislabSceneMissing";
pub(super) const VIEW: &str = "mislabView";
/// pbrt-v4's name.
pub(super) const SPP: &str = "samplesPerPixel";
/// pbrt-v4's name.
pub(super) const RENDER_SECONDS: &str = "renderTimeSeconds";
pub(super) const CPU_SECONDS: &str = "cpuTimeSeconds";
pub(super) const STRATEGY: &str = "strategy";
pub(super) const LIGHT_PROB: &str = "lightProb";
pub(super) const HEURISTIC: &str = "heuristic";
pub(super) const WEIGHTS: &str = "weights";
pub(super) const SAMPLER: &str = "sampler";
pub(super) const STRATA: &str = "strata";
pub(super) const JITTER: &str = "jitter";
pub(super) const SEED: &str = "seed";
pub(super) const CROP: &str = "cropWindow";
pub(super) const PATHS: &str = "paths";
pub(super) const SIMD: &str = "simd";
pub(super) const THREADS: &str = "threads";
pub(super) const INVALID_SAMPLES: &str = "invalidSamples";
pub(super) const SCENE_NAME: &str = "sceneName";

/// Every name above, which callers cannot use for their own attributes.
pub(super) const RESERVED: [&str; 22] = [
    FORMAT_NAME,
    SETTINGS,
    SCENE,
    SCENE_MISSING,
    VIEW,
    SPP,
    RENDER_SECONDS,
    CPU_SECONDS,
    STRATEGY,
    LIGHT_PROB,
    HEURISTIC,
    WEIGHTS,
    SAMPLER,
    STRATA,
    JITTER,
    SEED,
    CROP,
    PATHS,
    SIMD,
    THREADS,
    INVALID_SAMPLES,
    SCENE_NAME,
];
