//! What waits for one client: one slot per message type and id, the newest of each.
//!
//! Drop rule: a newer frame takes the place of an unsent one of its slot. A client for which more waits than the bounds below
//! has fallen behind for good: all of it is dropped and the connection is to be closed. A page then connects anew and gets the
//! newest of everything.

use crate::hub::{Frame, Slot, length};
use std::collections::{HashMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Frames that wait at most: the newest of everything that the hub keeps, and some farewells.
pub(crate) const MAX_FRAMES: usize = 8192;
/// Bytes that wait at most.
pub(crate) const MAX_BYTES: usize = 48 << 20;

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
    bytes: usize,
    replaced: u64,
    has_overflowed: bool,
}

impl Waiting {
    fn insert(&mut self, slot: &Slot, frame: Frame) {
        self.bytes += length(&frame);
        match self.frames.insert(slot.clone(), frame) {
            Some(before) => {
                self.bytes -= length(&before);
                self.replaced += 1;
            }
            None => self.order.push_back(slot.clone()),
        }
        if self.frames.len() > MAX_FRAMES || self.bytes > MAX_BYTES {
            *self = Self {
                replaced: self.replaced + self.frames.len() as u64,
                has_overflowed: true,
                ..Self::default()
            };
        }
    }

    fn remove(&mut self, slot: &Slot) -> Option<Frame> {
        let frame = self.frames.remove(slot)?;
        self.bytes -= length(&frame);
        Some(frame)
    }
}

impl Outbox {
    /// Puts a frame in, in the place of an unsent one of the same slot.
    pub(crate) fn put(&self, slot: &Slot, frame: Frame) {
        let mut waiting = self.lock();
        if !waiting.has_overflowed {
            waiting.insert(slot, frame);
        }
        drop(waiting);
        self.arrival.notify_one();
    }

    /// Takes an unsent frame of a slot back.
    pub(crate) fn withdraw(&self, slot: &Slot) {
        let mut waiting = self.lock();
        if waiting.remove(slot).is_some() {
            waiting.order.retain(|other| other != slot);
        }
    }

    /// Takes the frame whose slot has been due for longest.
    pub(crate) fn take(&self) -> Option<Frame> {
        let mut waiting = self.lock();
        let slot = waiting.order.pop_front()?;
        waiting.remove(&slot)
    }

    /// How many frames wait.
    pub(crate) fn len(&self) -> usize {
        self.lock().order.len()
    }

    /// Whether too much waited: nothing is taken in any more.
    pub(crate) fn has_overflowed(&self) -> bool {
        self.lock().has_overflowed
    }

    /// Returns as soon as something waits, or too much did.
    pub(crate) async fn filled(&self) {
        while self.len() == 0 && !self.has_overflowed() {
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

    #[test]
    fn a_client_for_which_too_much_waits_is_given_up() {
        let outbox = Outbox::default();
        for id in 0..10 * MAX_FRAMES {
            outbox.put(&Slot::Object(id.to_string()), text("gone"));
        }
        assert!(outbox.has_overflowed());
        assert_eq!((outbox.len(), outbox.take()), (0, None));

        let outbox = Outbox::default();
        let large = Frame::Binary(vec![0; MAX_BYTES / 8].into());
        for id in 0..80 {
            outbox.put(&Slot::Preview(id.to_string()), large.clone());
        }
        assert!(outbox.has_overflowed());
    }

    #[test]
    fn what_is_taken_makes_room() {
        let outbox = Outbox::default();
        let large = Frame::Binary(vec![0; MAX_BYTES].into());
        for id in 0..10 {
            outbox.put(&Slot::Preview(id.to_string()), large.clone());
            assert!(outbox.take().is_some());
        }
        assert!(!outbox.has_overflowed());
    }
}
