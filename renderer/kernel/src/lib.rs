//! The kernel of MIS Lab: the estimator and all that runs once per sample.
//!
//! A camera ray hits a surface at x. What it reflects towards the eye is
//!
//! ```text
//! L(x, wo) = integral over directions of  bsdf(wo, wi) Le(wi) V(wi) |cos| dwi
//! ```
//!
//! and is estimated with one secondary ray per sample (two for `mis_all`), drawn from the lights, from the BSDF, or from
//! either, and weighted by multiple importance sampling.
//!
//! Reading order: [`estimator`] is the page all else serves; [`bsdf`], [`light`] and [`warp`] the techniques it draws with; [`sampler`] the
//! random numbers; [`lanes`] how one text runs on many pixels at once. [`request`] says
//! *what* is rendered. Machinery: [`geometry`] intersects rays, [`world`] is the built scene and what is culled for a
//! patch of pixels, [`tile`] walks over pixels, [`film`] adds up.
//!
//! # Glossary
//!
//! | term | means (unit) |
//! |---|---|
//! | `wo`, `wi` | unit vectors away from the surface: to the eye, to the light |
//! | `f`, integrand | `bsdf Le V cos` at one direction (W / (m^2 sr^2)) |
//! | q | density of the technique that drew a direction, as the heuristic sees it: p, or c p |
//! | `p_light`, `p_bsdf` | densities of the techniques at one direction (1/sr), of the light technique over all lights |
//! | technique | one way to draw `wi`: light, BSDF |
//! | strategy | a combination of techniques: `light`, `bsdf`, `mis_all` (one of each), `mis` (one of either) |
//! | c | probability that `mis` draws by the light technique |
//! | heuristic | how weights follow from densities: balance, power, cutoff, maximum |
//! | weight, w | MIS weight of the technique that drew a direction, in [0, 1] |
//! | effective density, d | `p / w` (or `c p / w`): every estimator is `f / d` |
//! | contribution | `f / d` of one sample |
//! | spp, pass | samples (camera rays) per pixel; some samples more of every pixel |
//! | packet | the pixels worked on at once, 1, 16 or 32, one per lane |
//! | hit, query | what a ray strikes first; a question to the scene: nearest hit, or whether anything is in the way |
//! | block, patch, tile | 8 x 4 pixels stored together; 8 x 8 culled together; 800 x 8 rendered by one worker at a time |
//! | culling | leaving out primitives that no ray of a patch can hit |
//! | film, frame, layer | sums of samples; an immutable snapshot of them; one image in it |

pub mod bsdf;
pub mod estimator;
pub mod film;
pub mod geometry;
pub mod lanes;
pub mod light;
pub mod request;
pub mod sampler;
pub mod stop;
pub mod tile;
pub mod warp;
pub mod world;
