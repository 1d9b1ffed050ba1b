//! Passes of the window that nobody's hand asks for: for news of a picture, or of what is worked out beside it.
//!
//! Whoever has news asks here and not the toolkit, so that all of it comes together in the passes that drawing has a [`Share`] for.

use std::time::{Duration, Instant};

use eframe::egui::{Context, Event, RawInput, plugin::Plugin};
use mislab_renderer::Spent;

use crate::state::share::Share;

/// A repaint at once would cost two passes.
const SOON: Duration = Duration::from_millis(1);

/// From this time until the next one on, passes are rare.
const RARE: Duration = Duration::from_millis(100);

/// Tells what has been spent since the program started.
#[derive(Clone, Copy, Debug)]
pub struct Meter(pub fn() -> Spent);

impl Meter {
    /// By the process: all that it does beside rendering counts as drawing.
    pub fn of_process() -> Self {
        Self(Spent::now)
    }
}

impl Default for Meter {
    /// Nothing: drawing is for free.
    fn default() -> Self {
        Self(Spent::default)
    }
}

/// Keeps the account of a window's passes.
pub struct Passes {
    share: Share,
    meter: Meter,
    /// Mouse buttons that are down.
    pressed: usize,
    /// Something that follows the mouse has asked for the next pass.
    follows: bool,
    /// How many want quiet.
    quiet: usize,
}

impl Passes {
    /// Of this machine.
    pub fn new(meter: Meter) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self { share: Share::new(cores), meter, pressed: 0, follows: false, quiet: 0 }
    }
}

impl Passes {
    /// Whether somebody does something. A mouse that is only moved is followed, but for that the picture need not be newer.
    fn acts(&mut self, events: &[Event]) -> bool {
        let mut acts = false;
        for event in events {
            match event {
                Event::PointerMoved(_) | Event::MouseMoved(_) => acts |= self.pressed > 0,
                Event::PointerButton { pressed, .. } => {
                    self.pressed = if *pressed { self.pressed + 1 } else { self.pressed.saturating_sub(1) };
                    acts = true;
                }
                // A button may be let go where the window does not see it.
                Event::PointerGone | Event::WindowFocused(false) => self.pressed = 0,
                _ => acts = true,
            }
        }
        acts
    }
}

impl Plugin for Passes {
    fn debug_name(&self) -> &'static str {
        "passes"
    }

    fn input_hook(&mut self, _ctx: &Context, input: &mut RawInput) {
        let now = Instant::now();
        let acts = self.acts(&input.events) || !input.dropped_files.is_empty();
        if acts {
            self.share.freshen(now);
        }
        let follows = std::mem::take(&mut self.follows) || !input.events.is_empty();
        self.share.begin_pass(now, (self.meter.0)(), follows && !acts);
    }
}

/// Something has changed that is to be seen at once.
pub fn freshen(ctx: &Context) {
    ctx.with_plugin(|passes: &mut Passes| passes.share.freshen(Instant::now()));
}

/// When the next pass for news is due; now, where nobody keeps account.
pub fn due(ctx: &Context) -> Instant {
    let now = Instant::now();
    ctx.with_plugin(|passes: &mut Passes| passes.share.due(now)).unwrap_or(now)
}

/// Whether passes are so far apart that one may take its time.
pub fn are_rare(ctx: &Context) -> bool {
    due(ctx).saturating_duration_since(Instant::now()) > RARE
}

/// There is news: asks for a pass as soon as one is due.
pub fn for_news(ctx: &Context) {
    for_news_in(ctx, SOON);
}

/// There is something new of what follows the mouse: asks for a pass now.
pub fn for_hand(ctx: &Context) {
    ctx.with_plugin(|passes: &mut Passes| passes.follows = true);
    ctx.request_repaint_after(SOON);
}

/// There will be news in a while: asks for a pass then, or when one is due after that.
pub fn for_news_in(ctx: &Context, wait: Duration) {
    let quiet = ctx.with_plugin(|passes: &mut Passes| passes.quiet > 0).unwrap_or(false);
    if !quiet {
        ctx.request_repaint_after(wait.max(due(ctx).saturating_duration_since(Instant::now())));
    }
}

/// As long as it is there nothing is drawn for news. Whoever drops it asks for a pass, in which all of it is looked at.
pub struct Quiet(Context);

impl Quiet {
    /// From here on.
    pub fn begin(ctx: &Context) -> Self {
        ctx.with_plugin(|passes: &mut Passes| passes.quiet += 1);
        Self(ctx.clone())
    }
}

impl Drop for Quiet {
    fn drop(&mut self) {
        self.0.with_plugin(|passes: &mut Passes| passes.quiet -= 1);
    }
}
