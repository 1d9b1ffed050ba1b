//! Presses that are not lost: what is pressed is what was under the mouse then.

use eframe::egui::{Context, Event, Pos2, RawInput, plugin::Plugin};

/// From this distance in points between a press and a later place in the same pass, the press gets a pass of its own.
///
/// The toolkit asks once per pass what is under the mouse, at the end of all movement: a quick hand on a slow machine
/// would press where it has gone, not where it was.
const FAR: f32 = 2.0;

/// Hands the toolkit no more events in a pass than up to a press.
#[derive(Default)]
pub struct Presses {
    held: Vec<Event>,
}

impl Plugin for Presses {
    fn debug_name(&self) -> &'static str {
        "presses"
    }

    fn input_hook(&mut self, ctx: &Context, input: &mut RawInput) {
        if !self.held.is_empty() {
            self.held.append(&mut input.events);
            input.events = std::mem::take(&mut self.held);
        }
        if let Some(cut) = cut(&input.events) {
            self.held = input.events.split_off(cut);
            ctx.request_repaint();
        }
    }
}

/// Where to cut: behind the first press that the mouse then moves away from.
fn cut(events: &[Event]) -> Option<usize> {
    events.iter().enumerate().find_map(|(index, event)| {
        let Event::PointerButton { pos, pressed: true, .. } = event else { return None };
        let far = |to: &Pos2| to.distance(*pos) > FAR;
        let moved = events[index + 1..].iter().any(|later| match later {
            Event::PointerMoved(to) | Event::PointerButton { pos: to, .. } => far(to),
            _ => false,
        });
        moved.then_some(index + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Modifiers, PointerButton, pos2};

    fn press(x: f32, pressed: bool) -> Event {
        Event::PointerButton { pos: pos2(x, 0.0), button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    #[test]
    fn a_press_and_a_long_way_are_two_passes() {
        let moved = |x| Event::PointerMoved(pos2(x, 0.0));
        assert_eq!(cut(&[moved(1.0), press(1.0, true), moved(90.0)]), Some(2));
        assert_eq!(cut(&[press(1.0, true), press(1.0, false)]), None, "a click is a click");
        assert_eq!(cut(&[moved(1.0), moved(90.0), press(90.0, true)]), None);
        assert_eq!(cut(&[press(1.0, true), moved(2.0), press(50.0, false)]), Some(1));
    }

    #[test]
    fn nothing_is_lost_and_the_order_stays() {
        let ctx = Context::default();
        let mut presses = Presses::default();
        let moved = |x| Event::PointerMoved(pos2(x, 0.0));
        let mut input = RawInput { events: vec![press(1.0, true), moved(9.0)], ..RawInput::default() };
        presses.input_hook(&ctx, &mut input);
        assert_eq!(input.events, [press(1.0, true)]);
        let mut next = RawInput { events: vec![moved(10.0), press(10.0, false)], ..RawInput::default() };
        presses.input_hook(&ctx, &mut next);
        assert_eq!(next.events, [moved(9.0), moved(10.0), press(10.0, false)]);
    }
}
