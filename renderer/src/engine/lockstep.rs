//! Several pictures kept abreast, so that what they show can be compared at any moment.

/// What pictures in lock-step have alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lockstep {
    /// Samples per pixel.
    Spp,
    /// Secondary rays per pixel: `mis_all` traces two a sample and has half the spp of the others.
    Rays,
    /// Seconds of processor time spent on the picture, summed over threads.
    CpuSeconds,
}

/// A group of pictures in lock-step: dropping it lets them run freely. Made by [`super::Renderer::keep_abreast`].
#[must_use = "pictures are in lock-step as long as this is held"]
pub struct Abreast {
    pub(super) end: Box<dyn Fn() + Send + Sync>,
}

impl Drop for Abreast {
    fn drop(&mut self) {
        (self.end)();
    }
}

/// The pictures of a group, by id.
pub(super) struct Group {
    pub(super) id: u64,
    pub(super) by: Lockstep,
    pub(super) members: Vec<u64>,
}

/// How far a member is that others have to wait for, in the unit of the group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// Now.
    pub(super) done: f64,
    /// At the end of the running pass; `done` between passes.
    pub(super) planned: f64,
    /// Of one sample per pixel; 0 if not known yet.
    pub(super) per_sample: f64,
    /// Samples per pixel that its next pass would have if it were alone.
    pub(super) burst: u32,
}

/// Samples per pixel that the next pass of a member may have at most; `None` while it has to wait.
///
/// A pass begins only where no other member is behind, and no pass is longer than the next one of any other. So nobody is ever
/// ahead of the slowest by more than the one pass that took him there, and the slowest never waits. Those
/// behind a running pass end theirs where it will end: at equal samples or rays, all meet.
pub(super) fn room(own: &Standing, others: impl Iterator<Item = Standing>) -> Option<u32> {
    let mut most = f64::INFINITY;
    let mut goal: f64 = 0.0;
    for other in others {
        if other.done < own.done {
            return None;
        }
        goal = goal.max(other.planned);
        if other.per_sample > 0.0 {
            most = most.min(f64::from(other.burst) * other.per_sample);
        }
    }
    if goal > own.done {
        most = most.min(goal - own.done);
    }
    if own.per_sample > 0.0 && most.is_finite() {
        return Some(((most / own.per_sample) as u32).max(1));
    }
    Some(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(done: f64, pass: f64, burst: u32) -> Standing {
        Standing { done, planned: done + pass, per_sample: 2.0, burst }
    }

    #[test]
    fn nobody_begins_a_pass_ahead_of_another() {
        assert_eq!(room(&at(6.0, 0.0, 9), [at(6.0, 0.0, 50), at(4.0, 2.0, 50)].into_iter()), None);
        assert_eq!(room(&at(6.0, 0.0, 9), [].into_iter()), Some(u32::MAX), "alone");
    }

    #[test]
    fn no_pass_is_longer_than_the_next_one_of_another() {
        assert_eq!(room(&at(6.0, 0.0, 9), [at(6.0, 0.0, 7), at(8.0, 0.0, 5)].into_iter()), Some(1), "two of eight");
        assert_eq!(room(&at(6.0, 0.0, 9), [at(6.0, 0.0, 7), at(6.0, 0.0, 5)].into_iter()), Some(5));
        // Where nothing is known of the other yet, it has no pass behind it and the first pass is one sample.
        let unknown = Standing { done: 0.0, planned: 0.0, per_sample: 0.0, burst: 1 };
        assert_eq!(room(&unknown, [unknown].into_iter()), Some(u32::MAX));
    }

    #[test]
    fn those_behind_end_their_pass_where_the_first_will() {
        assert_eq!(room(&at(6.0, 0.0, 99), [at(6.0, 16.0, 50)].into_iter()), Some(8));
        assert_eq!(room(&at(6.0, 0.0, 99), [at(11.0, 0.0, 50)].into_iter()), Some(2), "not beyond it");
        assert_eq!(room(&at(6.0, 0.0, 99), [at(7.0, 0.0, 50)].into_iter()), Some(1), "unless by part of a sample");
    }
}
