//! The newest frame of everything, and the clients that want to hear of it.

use crate::outbox::Outbox;
use axum::extract::ws;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// One WebSocket frame, shared by all clients without a copy.
pub(crate) type Frame = ws::Message;

/// A text frame.
#[cfg(test)]
pub(crate) fn text(json: &str) -> Frame {
    Frame::Text(json.into())
}

/// Message type and id. The order is that in which a new client hears of things: first what they are, then where.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Slot {
    Rig,
    Object(String),
    Alive(String, String),
    CameraStatus(String),
    FusionStatus(String),
    Clocks(String),
    BridgeStatus,
    Wizard,
    Pose(String),
    Joints(String),
    Truth(String),
    Observations(String),
    DetectionReport(String),
    Preview(String),
}

/// Slots that the bridge keeps: a site of a hundred cameras and a few hundred objects. More is somebody's mistake.
const MAX_SLOTS: usize = 2048;
/// Pictures that the bridge keeps; at most 100 kB each.
const MAX_PREVIEWS: usize = 128;
/// Clients at one time.
const MAX_CLIENTS: usize = 64;

/// Everything newest, for new clients, and the outboxes of the present ones.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    newest: BTreeMap<Slot, Frame>,
    n_previews: usize,
    clients: Vec<Arc<Outbox>>,
    replaced_before: u64,
}

/// The bridge keeps no more slots.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Full;

impl Hub {
    /// Hands a frame to every client and keeps it for later ones.
    pub(crate) fn publish(&self, slot: &Slot, frame: Frame) -> Result<(), Full> {
        let mut state = self.lock();
        state.keep(slot, &frame)?;
        for client in &state.clients {
            client.put(slot, frame.clone());
        }
        Ok(())
    }

    /// The ids under which clients know an object and its links: its own, and those that go on with a dot.
    pub(crate) fn parts_of(&self, object: &str) -> Vec<String> {
        let state = self.lock();
        let ids = state.newest.keys().filter_map(|slot| match slot {
            Slot::Object(id) | Slot::Pose(id) => Some(id),
            _ => None,
        });
        let is_link = |id: &&String| {
            let rest = id.strip_prefix(object);
            rest.is_some_and(|rest| rest.starts_with('.'))
        };
        let links: BTreeSet<String> = ids.filter(is_link).cloned().collect();
        std::iter::once(object.to_owned()).chain(links).collect()
    }

    /// An object is gone: later clients don't hear of it, the present ones get this frame last.
    pub(crate) fn forget_object(&self, id: &str, farewell: &Frame) {
        let slots =
            [Slot::Object, Slot::Pose, Slot::Joints, Slot::Truth].map(|slot| slot(id.to_owned()));
        let mut state = self.lock();
        for slot in &slots {
            state.newest.remove(slot);
            for client in &state.clients {
                client.withdraw(slot);
            }
        }
        for client in &state.clients {
            client.put(&slots[0], farewell.clone());
        }
    }

    /// A new client's outbox, filled with the newest of everything; none when there are too many clients.
    pub(crate) fn join(&self) -> Option<Arc<Outbox>> {
        let mut state = self.lock();
        if state.clients.len() >= MAX_CLIENTS {
            return None;
        }
        let outbox = Arc::new(Outbox::default());
        for (slot, frame) in &state.newest {
            outbox.put(slot, frame.clone());
        }
        state.clients.push(Arc::clone(&outbox));
        Some(outbox)
    }

    /// The client is gone.
    pub(crate) fn leave(&self, outbox: &Arc<Outbox>) {
        let mut state = self.lock();
        state.clients.retain(|client| !Arc::ptr_eq(client, outbox));
        state.replaced_before += outbox.replaced();
    }

    /// The newest text of every slot.
    pub(crate) fn newest_texts(&self) -> Vec<ws::Utf8Bytes> {
        let texts = |frame: &Frame| match frame {
            Frame::Text(text) => Some(text.clone()),
            _ => None,
        };
        self.lock().newest.values().filter_map(texts).collect()
    }

    /// Present clients, and frames that clients have ever skipped.
    pub(crate) fn counts(&self) -> (usize, u64) {
        let state = self.lock();
        let replaced: u64 = state.clients.iter().map(|client| client.replaced()).sum();
        (state.clients.len(), state.replaced_before + replaced)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing under the lock panics half way, so a poisoned state is a whole one.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn keep(&mut self, slot: &Slot, frame: &Frame) -> Result<(), Full> {
        if let Some(kept) = self.newest.get_mut(slot) {
            *kept = frame.clone();
            return Ok(());
        }
        let is_preview = matches!(slot, Slot::Preview(_));
        if self.newest.len() >= MAX_SLOTS || is_preview && self.n_previews >= MAX_PREVIEWS {
            return Err(Full);
        }
        self.n_previews += usize::from(is_preview);
        self.newest.insert(slot.clone(), frame.clone());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_client_hears_the_newest_of_everything_models_first() {
        let hub = Hub::default();
        let pose = Slot::Pose("cube".to_owned());
        hub.publish(&pose, text("pose 1")).unwrap();
        hub.publish(&pose, text("pose 2")).unwrap();
        hub.publish(&Slot::Rig, text("rig")).unwrap();
        let outbox = hub.join().unwrap();
        assert_eq!(outbox.take(), Some(text("rig")));
        assert_eq!(outbox.take(), Some(text("pose 2")));
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn nobody_hears_of_an_object_after_its_farewell() {
        let hub = Hub::default();
        let present = hub.join().unwrap();
        let id = || "cube".to_owned();
        hub.publish(&Slot::Object(id()), text("object")).unwrap();
        hub.publish(&Slot::Pose(id()), text("pose")).unwrap();
        hub.publish(&Slot::Pose("box".to_owned()), text("other"))
            .unwrap();
        hub.forget_object("cube", &text("gone"));
        let late = hub.join().unwrap();
        assert_eq!([late.take(), late.take()], [Some(text("other")), None]);
        let heard: Vec<_> = std::iter::from_fn(|| present.take()).collect();
        assert!(heard.contains(&text("gone")) && !heard.contains(&text("pose")));
    }

    #[test]
    fn the_links_of_an_object_are_its_parts() {
        let hub = Hub::default();
        for id in ["arm.upper", "arm.lower", "arms", "armory.x"] {
            hub.publish(&Slot::Pose(id.to_owned()), text(id)).unwrap();
        }
        assert_eq!(hub.parts_of("arm"), ["arm", "arm.lower", "arm.upper"]);
    }

    #[test]
    fn skipped_frames_are_counted_beyond_their_clients_life() {
        let hub = Hub::default();
        let outbox = hub.join().unwrap();
        for frame in ["1", "2", "3"] {
            hub.publish(&Slot::Rig, text(frame)).unwrap();
        }
        assert_eq!(hub.counts(), (1, 2));
        hub.leave(&outbox);
        assert_eq!(hub.counts(), (0, 2));
    }

    #[test]
    fn a_flood_of_ids_ends_at_the_bound() {
        let hub = Hub::default();
        let previews = (0..2 * MAX_PREVIEWS).map(|n| Slot::Preview(format!("p{n}")));
        let refused = previews.filter(|slot| hub.publish(slot, text("")).is_err());
        assert_eq!(refused.count(), MAX_PREVIEWS);
        let poses = (0..2 * MAX_SLOTS).map(|n| Slot::Pose(format!("o{n}")));
        let kept = poses.filter(|slot| hub.publish(slot, text("")).is_ok());
        assert_eq!(kept.count(), MAX_SLOTS - MAX_PREVIEWS);
    }

    #[test]
    fn clients_are_bounded() {
        let hub = Hub::default();
        let clients: Vec<_> = (0..2 * MAX_CLIENTS).filter_map(|_| hub.join()).collect();
        assert_eq!(clients.len(), MAX_CLIENTS);
    }
}
