//! The arguments, as typed. The names are an interface: scripts and lessons use them.

use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use clap::{Parser, Subcommand};
use mislab_renderer::{Heuristic, OneSampleWeights, PixelRect, SamplerKind, Settings, Strategy};

use super::failure::Failure;
use super::output::{Destination, PictureFile};
use super::version::version;
use crate::state::paths::expand_home;

/// A laboratory for multiple importance sampling.
///
/// Without a command: opens the window, on SCENE if given. Where no window can be opened, renders the tutorial's
/// pictures and table into the current folder.
#[derive(Debug, Parser)]
#[command(name = "mislab", version = version(), args_conflicts_with_subcommands = true)]
pub(super) struct Args {
    #[command(subcommand)]
    pub(super) command: Option<Command>,
    /// A scene (.pbrt), or a picture saved by this program (.exr), which restores scene and settings
    #[arg(value_parser = path())]
    pub(super) scene: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Renders one picture, without a window
    Render(RenderArgs),
    /// Renders the tutorial's four pictures and a reference, and fills in the tutorial's table
    Table(TableArgs),
    /// Measures how the error of each strategy falls with the samples
    Converge(ConvergeArgs),
    /// Says how far two pictures are apart
    Compare(CompareArgs),
    /// Shows the settings a picture was made with
    Info(InfoArgs),
    /// Measures how fast this machine renders
    Bench(BenchArgs),
    /// Says what is exactly true of one pixel: mean, variances, best c, densities
    Inspect(InspectArgs),
    /// Draws one sample of one pixel again, with all its numbers
    Replay(ReplayArgs),
    /// Finds the samples that outweigh all others of their pixel
    Fireflies(FirefliesArgs),
}

/// What is not named here comes from the scene file, then from the defaults.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Options may also be written with one dash, as in pbrt-v3.
Exit code 0: the picture is saved; 1: it failed; 2: the arguments cannot be used.
Stopped with Ctrl+C, it saves nothing and leaves an older file as it was.")]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) picture: PictureArgs,

    #[command(flatten)]
    pub(super) samples: SampleArgs,

    #[command(flatten)]
    pub(super) how: HowArgs,

    /// File to save: .exr with all layers and settings, or .png, 8 bits, sRGB-encoded, clipped to [0, 1]
    /// [default: the Film's filename; for a picture NAME.exr rendered again, NAME_again.exr; or
    /// the next free name where that is taken: only a FILE named here is replaced]
    #[arg(long, value_name = "FILE", value_parser = picture_file)]
    pub(super) outfile: Option<PictureFile>,

    /// Writes settings, work and time as JSON to this file; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<Destination>,

    /// A quick preview: a quarter of width and height and at most 4 samples per pixel, where not named
    #[arg(long)]
    pub(super) quick: bool,
}

/// Which picture, but for its strategy and samples.
#[derive(Debug, clap::Args)]
pub(super) struct PictureArgs {
    /// A scene (.pbrt), or a picture saved by this program (.exr), to render again [default: Veach's scene]
    #[arg(value_parser = path())]
    pub(super) scene: Option<PathBuf>,

    /// Probability of a light sample in the strategy `mis`, in [0, 1]
    #[arg(long, value_name = "C", value_parser = unit, allow_negative_numbers = true)]
    pub(super) light_prob: Option<f32>,

    /// How the two techniques are weighted
    #[arg(long, value_name = "NAME", value_parser = names(Heuristic::ALL.map(Heuristic::name), Heuristic::from_name))]
    pub(super) heuristic: Option<Heuristic>,

    /// Whether the light probability takes part in the weights of the strategy `mis`
    #[arg(
        long,
        value_name = "NAME",
        value_parser = names(OneSampleWeights::ALL.map(OneSampleWeights::name), OneSampleWeights::from_name)
    )]
    pub(super) weights: Option<OneSampleWeights>,

    /// Pattern of the samples in a pixel
    #[arg(
        long,
        value_name = "NAME",
        value_parser = names(SamplerKind::ALL.map(SamplerKind::name), SamplerKind::from_name)
    )]
    pub(super) sampler: Option<SamplerKind>,

    /// Seed of all random numbers
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    pub(super) seed: Option<u32>,

    /// Image size in pixels, e.g. 800x800
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,

    /// Part of the image to render, as fractions of its width (x0, x1) and height (y0, y1) from the top left
    #[arg(long, num_args = 4, value_names = ["x0", "x1", "y0", "y1"], value_parser = unit, allow_negative_numbers = true)]
    pub(super) cropwindow: Option<Vec<f32>>,

    /// Roughness (GGX alpha, in [0, 1]) of the material NAME; 0 is a mirror. May be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = alpha)]
    pub(super) alpha: Vec<Alpha>,
}

/// Strategy and samples of a picture.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct SampleArgs {
    /// How directions are sampled
    #[arg(long, value_name = "NAME", value_parser = names(Strategy::ALL.map(Strategy::name), Strategy::from_name))]
    pub(super) strategy: Option<Strategy>,

    /// Samples per pixel; for stratified samplers arranged as squarely as can be, 64 as 8 x 8
    #[arg(long, value_name = "N", value_parser = at_least_one, allow_negative_numbers = true)]
    pub(super) spp: Option<NonZeroU32>,
}

/// Each point is the mean over pictures with different seeds, rendered to just that many samples.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Errors are relMSE against a converged picture in two halves, whose own noise does not add to them.
The slope is that of the line on logarithmic axes, with its 95 % interval; independent samples have -1.")]
pub(super) struct ConvergeArgs {
    #[command(flatten)]
    pub(super) picture: PictureArgs,

    /// A curve for each of these
    #[arg(
        long,
        value_name = "NAME,NAME",
        value_delimiter = ',',
        value_parser = names(Strategy::ALL.map(Strategy::name), Strategy::from_name),
        default_value = "light,bsdf,mis_all,mis"
    )]
    pub(super) strategies: Vec<Strategy>,

    /// Samples per pixel of the points, ascending; `...` goes on by the same factor
    #[arg(long, value_name = "N,N,...,N", value_parser = counts, default_value = "1,2,4,...,256", allow_negative_numbers = true)]
    pub(super) at: Counts,

    /// Pictures of each point, with different seeds
    #[arg(long, value_name = "N", default_value = "8", value_parser = replicates, allow_negative_numbers = true)]
    pub(super) replicates: u32,

    /// A converged picture of the same pixels, taken as exact [default: rendered by the program]
    #[arg(long, value_name = "F.exr", value_parser = path())]
    pub(super) reference: Option<PathBuf>,

    /// Also each of the tutorial's squares by itself: light small or large, BSDF broad or sharp
    #[arg(long)]
    pub(super) by_square: bool,

    /// Writes the points as CSV to this file; `-` for standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<Destination>,

    /// Writes everything as JSON to this file; `-` for standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<Destination>,

    #[command(flatten)]
    pub(super) how: HowArgs,
}

/// How something is computed, which never changes its bits.
#[derive(Debug, clap::Args)]
pub(super) struct HowArgs {
    /// Worker threads; 0: one per core. The picture is the same for any number
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true, value_parser = threads, allow_negative_numbers = true)]
    pub(super) nthreads: usize,

    /// Says nothing but errors, and why a picture is black
    #[arg(long)]
    pub(super) quiet: bool,
}

#[derive(Debug, clap::Args)]
pub(super) struct TableArgs {
    /// A scene (.pbrt) or a picture saved by this program (.exr) with plates and lights [default: Veach's scene]
    #[arg(value_parser = path())]
    pub(super) scene: Option<PathBuf>,

    /// Size of all pictures [default: the SCENE's; the tutorial's own sizes without SCENE or if it has 800x800]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<[u32; 2]>,

    /// Folder for the four pictures, created if need be
    #[arg(long, value_name = "DIR", default_value = ".", value_parser = path())]
    pub(super) outdir: PathBuf,

    /// How the table is printed
    #[arg(long, value_name = "NAME", default_value = "md", value_parser = ["md", "csv", "json"])]
    pub(super) format: String,

    #[command(flatten)]
    pub(super) how: HowArgs,
}

#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// The picture
    #[arg(value_name = "A.exr", value_parser = path())]
    pub(super) a: PathBuf,

    /// The reference
    #[arg(value_name = "B.exr", value_parser = path())]
    pub(super) b: PathBuf,

    /// Compares pictures of different sizes, too: both on the coarser grid, every pixel the mean over its area
    #[arg(long)]
    pub(super) resample: bool,

    /// Writes the numbers as JSON to this file; `-` for standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<Destination>,
}

#[derive(Debug, clap::Args)]
pub(super) struct InfoArgs {
    /// The picture
    #[arg(value_name = "FILE.exr", value_parser = path())]
    pub(super) file: PathBuf,
}

#[derive(Debug, clap::Args)]
pub(super) struct BenchArgs {
    /// About how long to measure; more is steadier
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub(super) seconds: f64,

    #[command(flatten)]
    pub(super) numbers: NumbersArgs,
}

/// Nothing is sampled: all numbers are integrals over the directions of the lights, by quadrature.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Means, variances and second moments are those of the luminance of one sample at the centre of the pixel.
Each is known to the tolerance that is stated, relative to itself; a variance far below the squared mean, to
that share of the squared mean.")]
pub(super) struct InspectArgs {
    #[command(flatten)]
    pub(super) place: PlaceArgs,

    #[command(flatten)]
    pub(super) numbers: NumbersArgs,
}

/// Random numbers are a function of seed, pixel, sample and dimension: the numbers are those of the picture, bit for bit.
#[derive(Debug, clap::Args)]
pub(super) struct ReplayArgs {
    #[command(flatten)]
    pub(super) place: PlaceArgs,

    /// Which sample of the pixel, from 0
    #[arg(long, value_name = "I", value_parser = whole, allow_negative_numbers = true)]
    pub(super) index: u32,

    #[command(flatten)]
    pub(super) numbers: NumbersArgs,
}

/// A scene is rendered first. Of a picture, the pixels whose sums betray an outlier are drawn again.
#[derive(Debug, clap::Args)]
pub(super) struct FirefliesArgs {
    /// A picture saved by this program (.exr), or a scene (.pbrt) [default: Veach's scene]
    #[arg(value_name = "FILE.exr|SCENE", value_parser = path())]
    pub(super) scene: Option<PathBuf>,

    /// How many, the brightest first
    #[arg(long, value_name = "N", default_value = "10", value_parser = outliers, allow_negative_numbers = true)]
    pub(super) count: usize,

    /// Writes them as JSON to this file; `-` for standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<Destination>,

    #[command(flatten)]
    pub(super) how: HowArgs,
}

/// Where the numbers of a command without pictures go.
#[derive(Debug, clap::Args)]
pub(super) struct NumbersArgs {
    /// Writes the numbers as JSON to this file; `-` for standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<Destination>,

    /// Says nothing but results and errors
    #[arg(long)]
    pub(super) quiet: bool,
}

/// One pixel of one picture.
#[derive(Debug, clap::Args)]
pub(super) struct PlaceArgs {
    #[command(flatten)]
    pub(super) picture: PictureArgs,

    #[command(flatten)]
    pub(super) samples: SampleArgs,

    /// Column and row of the pixel, from 0 at the top left
    #[arg(
        long,
        num_args = 2,
        required = true,
        value_names = ["X", "Y"],
        value_parser = whole,
        allow_negative_numbers = true
    )]
    pixel: Vec<u32>,
}

impl PlaceArgs {
    /// The pixel.
    ///
    /// # Errors
    /// If the picture has no such pixel.
    pub(super) fn pixel_of(&self, settings: &Settings) -> Result<[u32; 2], Failure> {
        let PixelRect { min, max } = settings.pixel_bounds();
        match self.pixel.as_slice() {
            &[x, y] if (min[0]..max[0]).contains(&x) && (min[1]..max[1]).contains(&y) => Ok([x, y]),
            pixel => {
                let numbers: Vec<String> = pixel.iter().map(u32::to_string).collect();
                Err(Failure::Usage(format!(
                    "--pixel {}: not in the picture, expected x from {} to {} and y from {} to {}",
                    numbers.join(" "),
                    min[0],
                    max[0] - 1,
                    min[1],
                    max[1] - 1
                )))
            }
        }
    }
}

/// The numbers of `--at`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Counts(pub(super) Vec<u32>);

/// One `--alpha NAME=VALUE`.
#[derive(Clone, Debug)]
pub(super) struct Alpha {
    pub(super) material: String,
    pub(super) value: f32,
}

/// One of `names`, which `from_name` understands.
fn names<const N: usize, T: Clone + Send + Sync + 'static>(
    names: [&'static str; N],
    from_name: fn(&str) -> Option<T>,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(move |name| from_name(&name).ok_or("not a known name"))
}

/// A path, with `~` for the home folder also where the shell leaves it (`--outdir=~/pictures`).
fn path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(expand_home)
}

fn unit(text: &str) -> Result<f32, String> {
    // The range leaves out NaN too.
    text.parse().ok().filter(|v| (0.0..=1.0).contains(v)).ok_or_else(|| "expected a number in [0, 1]".to_owned())
}

fn at_least_one(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| format!("expected a whole number from 1 to {}", u32::MAX))
}

fn replicates(text: &str) -> Result<u32, String> {
    let count = text.parse().ok().filter(|n| (2..=1000).contains(n));
    count.ok_or_else(|| "expected a whole number from 2 to 1000".to_owned())
}

/// Ascending numbers with commas. `...` before the last goes on by the factor of the two before it.
fn counts(text: &str) -> Result<Counts, String> {
    const EXPECTED: &str = "expected ascending whole numbers from 1, e.g. 1,2,4,...,256";
    let mut all: Vec<u32> = Vec::new();
    let mut parts = text.split(',').map(str::trim);
    while let Some(part) = parts.next() {
        if ["...", "\u{2026}"].contains(&part) {
            let last = parts.next().and_then(|last| last.parse::<u32>().ok()).ok_or(EXPECTED)?;
            let &[.., before, latest] = &all[..] else { return Err(EXPECTED.to_owned()) };
            let mut next = latest;
            while next < last {
                next = next.saturating_mul(latest) / before;
                all.push(next);
            }
            if next != last {
                let factor = f64::from(latest) / f64::from(before);
                return Err(format!("{last} is not {latest} times a power of {factor}, {EXPECTED}"));
            }
        } else {
            all.push(part.parse().ok().filter(|n| *n > 0).ok_or(EXPECTED)?);
        }
        if !all.is_sorted_by(|a, b| a < b) {
            return Err(EXPECTED.to_owned());
        }
    }
    Ok(Counts(all))
}

fn whole(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u32::MAX))
}

fn outliers(text: &str) -> Result<usize, String> {
    const MOST: usize = 1000;
    let count = text.parse().ok().filter(|n| (1..=MOST).contains(n));
    count.ok_or_else(|| format!("expected a whole number from 1 to {MOST}"))
}

fn threads(text: &str) -> Result<usize, String> {
    const MOST: usize = 1024;
    text.parse().ok().filter(|n| *n <= MOST).ok_or_else(|| format!("expected a whole number from 0 to {MOST}"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| (0.0..=3600.0).contains(s));
    seconds.ok_or_else(|| "expected a number of seconds from 0 to 3600".to_owned())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|n| (1..=65536).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "expected width and height in pixels, 1 to 65536 each, e.g. 800x800".to_owned())
}

fn alpha(text: &str) -> Result<Alpha, String> {
    let (material, value) = text.rsplit_once('=').ok_or("expected NAME=VALUE, e.g. plate2=0.02")?;
    Ok(Alpha { material: material.to_owned(), value: unit(value)? })
}

fn picture_file(text: &str) -> Result<PictureFile, String> {
    PictureFile::new(expand_home(text.into())).ok_or_else(|| "expected a name that ends in .exr or .png".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        for text in ["nan", "inf", "1e999", "-0.1", "1.0001", "", "0,5"] {
            assert!(unit(text).is_err(), "{text}");
        }
        assert_eq!(unit("1e-3"), Ok(0.001));
        for text in ["800", "800x", "x800", "0x5", "5x65537", "-5x5", "5x5x5", "4294967296x1"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert_eq!(size("800x600"), Ok([800, 600]));
        for text in ["", "0", "2,1", "1,1", "1,2,x", "1,...,8", "1,2,...", "1,2,...,9", "...,4", "1,2,4,...,2", "-1,2"]
        {
            assert!(counts(text).is_err(), "{text}");
        }
        assert_eq!(counts("1,2,4,...,64,100"), Ok(Counts(vec![1, 2, 4, 8, 16, 32, 64, 100])));
        assert_eq!(counts(" 9, 27, ..., 81"), Ok(Counts(vec![9, 27, 81])));
    }
}
