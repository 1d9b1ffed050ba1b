//! All pictures of a renderer: who is next, in turn and in lock-step.

use std::time::{Duration, Instant};

use super::job::Machine;
use super::lockstep::{Group, room};
use super::schedule::{LONG, PictureState, Task};

/// What workers and handles share under the lock.
#[derive(Default)]
pub(super) struct Core {
    pub(super) shutdown: bool,
    pub(super) pictures: Vec<PictureState>,
    pub(super) groups: Vec<Group>,
    pub(super) machine: Machine,
    /// Where the next search for work starts, so that pictures take turns.
    turn: usize,
    next_id: u64,
}

impl Core {
    pub(super) fn new(machine: Machine) -> Self {
        Self { machine, ..Self::default() }
    }

    /// A number that no other picture or group has.
    pub(super) fn new_id(&mut self) -> u64 {
        self.next_id += 1;
        self.next_id
    }

    pub(super) fn picture(&mut self, id: u64) -> Option<&mut PictureState> {
        self.pictures.iter_mut().find(|p| p.id == id)
    }

    /// Something to do, or how long until there may be.
    pub(super) fn claim(&mut self, now: Instant) -> Result<Task, Duration> {
        let mut wait = LONG;
        let count = self.pictures.len();
        for k in 0..count {
            let i = (self.turn + k) % count;
            let Some(room) = self.room(i, now) else { continue };
            match self.pictures[i].claim(now, room) {
                Ok(task) => {
                    self.turn = (i + 1) % count;
                    return Ok(task);
                }
                Err(next) => wait = wait.min(next),
            }
        }
        Err(wait)
    }

    /// Samples per pixel that lock-step leaves to the next pass of a picture; `None` while it has to wait for another.
    fn room(&self, index: usize, now: Instant) -> Option<u32> {
        let picture = &self.pictures[index];
        let group = self.groups.iter().find(|group| group.members.contains(&picture.id));
        let (Some(group), Some(own)) = (group, group.and_then(|group| picture.standing(group.by, now))) else {
            return Some(u32::MAX);
        };
        if !picture.between_passes() {
            return Some(u32::MAX);
        }
        let others = self.pictures.iter().filter(|p| p.id != picture.id && group.members.contains(&p.id));
        room(&own, others.filter_map(|other| other.standing(group.by, now)))
    }
}
