//! What waits for one client: one slot per message type and id, the newest of each. Never larger than the site has slots.

use crate::hub::{Frame, Slot};
use std::collections::{HashMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// The frames that one client has not been sent yet, in the order in which their slots became due.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    waiting: Mutex<Waiting>,
    arrival: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    order: VecDeque<Slot>,
    frames: HashMap<Slot, Frame>,
    replaced: u64,
}

impl Outbox {
    /// Puts a frame in, in the place of an unsent one of the same slot.
    pub(crate) fn put(&self, slot: &Slot, frame: Frame) {
        let mut waiting = self.lock();
        if waiting.frames.insert(slot.clone(), frame).is_some() {
            waiting.replaced += 1;
        } else {
            waiting.order.push_back(slot.clone());
        }
        drop(waiting);
        self.arrival.notify_one();
    }

    /// Takes an unsent frame of a slot back.
    pub(crate) fn withdraw(&self, slot: &Slot) {
        let mut waiting = self.lock();
        if waiting.frames.remove(slot).is_some() {
            waiting.order.retain(|other| other != slot);
        }
    }

    /// Takes the frame whose slot has been due for longest.
    pub(crate) fn take(&self) -> Option<Frame> {
        let mut waiting = self.lock();
        let slot = waiting.order.pop_front()?;
        waiting.frames.remove(&slot)
    }

    /// How many frames wait.
    pub(crate) fn len(&self) -> usize {
        self.lock().order.len()
    }

    /// Returns as soon as something waits.
    pub(crate) async fn filled(&self) {
        while self.len() == 0 {
            self.arrival.notified().await;
        }
    }

    /// How many frames gave way to newer ones.
    pub(crate) fn replaced(&self) -> u64 {
        self.lock().replaced
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        // Nothing under the lock panics half way, so a poisoned state is a whole one.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hub::text;

    fn drain(outbox: &Outbox) -> Vec<Frame> {
        std::iter::from_fn(|| outbox.take()).collect()
    }

    #[test]
    fn the_newest_of_a_slot_wins_and_keeps_its_place() {
        let outbox = Outbox::default();
        let [a, b] = ["a", "b"].map(|id| Slot::Pose(id.to_owned()));
        outbox.put(&a, text("a1"));
        outbox.put(&b, text("b1"));
        outbox.put(&a, text("a2"));
        assert_eq!(outbox.replaced(), 1);
        assert_eq!(drain(&outbox), [text("a2"), text("b1")]);
        assert_eq!(outbox.len(), 0);
    }

    #[test]
    fn a_client_that_never_reads_holds_one_frame_a_slot() {
        let outbox = Outbox::default();
        let slot = Slot::Preview("north".to_owned());
        for count in 0..1000 {
            outbox.put(&slot, text(&count.to_string()));
        }
        assert_eq!(outbox.len(), 1);
        assert_eq!(drain(&outbox), [text("999")]);
    }
}
