//! The newest frame of each slot, and the outboxes of the connected clients.
//!
//! Each kind of slot has room for so many ids, and all frames together for so many bytes. Drop rule: what finds no room
//! is refused and counted; a slot without news for [`FORGOTTEN_NS`] is forgotten.

use crate::frame::{Frame, length};
use axum::extract::ws::Utf8Bytes;
use sextant_process::monotonic_ns;
use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_site_mirror::limits::FORGOTTEN_NS;
use sextant_site_mirror::{BoundedMap, Full};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What waits for one client: the newest frame of each slot. For a client that has fallen behind for good everything is
/// dropped and the connection is to be closed; a page then connects anew and gets the newest of everything.
pub(crate) type Outbox = Queue<Frame, Slot>;

/// What waits for a client at most: the newest of everything that the hub keeps, and some farewells.
const WAITING: StreamBounds = StreamBounds::new(8192, 48 << 20);

/// A text frame.
#[cfg(test)]
pub(crate) fn text(json: &str) -> Frame {
    Frame::Text(json.into())
}

/// Message type and id. A new client receives frames in this order: models first, then poses.
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
    Proposal(String),
    Former(String),
    Pose(String),
    Joints(String),
    Truth(String),
    Observations(String),
    DetectionReport(String),
    Preview(String),
    Zones,
    Events,
}

/// Ids that are kept of each kind of slot, in the order of [`Slot`].
const ROOM: [usize; 18] = [
    1, 2048, 256, 256, 64, 64, 1, 1, 64, 64, 2048, 1024, 1024, 256, 256, 128, 1, 1,
];
/// Bytes of all frames that are kept.
const MAX_BYTES: usize = 32 << 20;
/// Clients at one time.
const MAX_CLIENTS: usize = 64;

impl Slot {
    /// Place in [`ROOM`].
    fn kind(&self) -> usize {
        match self {
            Self::Rig => 0,
            Self::Object(_) => 1,
            Self::Alive(..) => 2,
            Self::CameraStatus(_) => 3,
            Self::FusionStatus(_) => 4,
            Self::Clocks(_) => 5,
            Self::BridgeStatus => 6,
            Self::Wizard => 7,
            Self::Proposal(_) => 8,
            Self::Former(_) => 9,
            Self::Pose(_) => 10,
            Self::Joints(_) => 11,
            Self::Truth(_) => 12,
            Self::Observations(_) => 13,
            Self::DetectionReport(_) => 14,
            Self::Preview(_) => 15,
            Self::Zones => 16,
            Self::Events => 17,
        }
    }

    /// Whether its message is sent once and holds until the next one.
    fn lasts(&self) -> bool {
        matches!(
            self,
            Self::Rig
                | Self::BridgeStatus
                | Self::Wizard
                | Self::Proposal(_)
                | Self::Former(_)
                | Self::Zones
                | Self::Events
        )
    }
}

/// Everything newest, for new clients, and the outboxes of the present ones.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    state: Mutex<HubState>,
}

#[derive(Debug)]
struct HubState {
    /// By kind.
    newest: [BoundedMap<Slot, Frame>; ROOM.len()],
    bytes: usize,
    clients: Vec<Arc<Outbox>>,
    replaced_before: u64,
}

impl Default for HubState {
    fn default() -> Self {
        Self {
            newest: ROOM.map(|room| BoundedMap::new(room, FORGOTTEN_NS)),
            bytes: 0,
            clients: Vec::new(),
            replaced_before: 0,
        }
    }
}

/// Frames that a client was not sent.
fn skipped(outbox: &Outbox) -> u64 {
    let counts = outbox.counts();
    counts.replaced + counts.dropped
}

impl Hub {
    /// Hands a frame to every client and keeps it for later ones.
    pub(crate) fn publish(&self, slot: &Slot, frame: Frame) -> Result<(), Full> {
        let mut state = self.lock();
        state.keep(monotonic_ns(), slot, &frame, slot.lasts())?;
        state.hand_out(slot, &frame);
        Ok(())
    }

    /// As [`Self::publish`], of a frame that holds until the next of its slot.
    pub(crate) fn publish_lasting(&self, slot: &Slot, frame: Frame) -> Result<(), Full> {
        let mut state = self.lock();
        state.keep(monotonic_ns(), slot, &frame, true)?;
        state.hand_out(slot, &frame);
        Ok(())
    }

    /// Marks objects that a fusion node lists, and their links, as existing.
    pub(crate) fn confirm_objects(&self, objects: &BTreeSet<&str>) {
        let is_one = |slot: &Slot| match slot {
            Slot::Object(id) => objects.contains(id.split('.').next().unwrap_or(id)),
            _ => false,
        };
        self.lock().newest[Slot::Object(String::new()).kind()].touch_where(monotonic_ns(), is_one);
    }

    /// Forgets slots without news.
    pub(crate) fn expire(&self, now_ns: u64) {
        self.lock().expire(now_ns);
    }

    /// The ids under which clients know an object and its links: its own, and those that go on with a dot.
    pub(crate) fn parts_of(&self, object: &str) -> Vec<String> {
        let state = self.lock();
        let ids = state.newest().filter_map(|(slot, _)| match slot {
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

    /// Forgets an object: connected clients receive this frame last, later ones nothing. An object that no client knows
    /// is passed over.
    pub(crate) fn forget_object(&self, id: &str, farewell: &Frame) {
        let slots =
            [Slot::Object, Slot::Pose, Slot::Joints, Slot::Truth].map(|slot| slot(id.to_owned()));
        let mut state = self.lock();
        let mut was_known = false;
        for slot in &slots {
            was_known |= state.remove(slot);
            for client in &state.clients {
                client.withdraw(slot);
            }
        }
        if was_known {
            state.hand_out(&slots[0], farewell);
        }
    }

    /// A new client's outbox, filled with the newest of everything; none when there are too many clients.
    pub(crate) fn join(&self) -> Option<Arc<Outbox>> {
        let mut state = self.lock();
        if state.clients.len() >= MAX_CLIENTS {
            return None;
        }
        let outbox = Arc::new(Outbox::new(WAITING, DropRule::All));
        for (slot, frame) in state.newest() {
            outbox.put(slot.clone(), frame.clone(), length(frame));
        }
        state.clients.push(Arc::clone(&outbox));
        Some(outbox)
    }

    /// The client is gone.
    pub(crate) fn leave(&self, outbox: &Arc<Outbox>) {
        let mut state = self.lock();
        state.clients.retain(|client| !Arc::ptr_eq(client, outbox));
        state.replaced_before += skipped(outbox);
    }

    /// The newest text of every slot.
    pub(crate) fn newest_texts(&self) -> Vec<Utf8Bytes> {
        // Frames are shared: nothing but references is copied under the lock.
        let texts = |(_, frame): (&Slot, &Frame)| match frame {
            Frame::Text(text) => Some(text.clone()),
            _ => None,
        };
        self.lock().newest().filter_map(texts).collect()
    }

    /// Present clients, and frames that clients have ever skipped.
    pub(crate) fn counts(&self) -> (usize, u64) {
        let state = self.lock();
        let replaced: u64 = state.clients.iter().map(|client| skipped(client)).sum();
        (state.clients.len(), state.replaced_before + replaced)
    }

    fn lock(&self) -> MutexGuard<'_, HubState> {
        // Nothing under the lock panics half way, so a poisoned state is a whole one.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl HubState {
    fn newest(&self) -> impl Iterator<Item = (&Slot, &Frame)> {
        self.newest.iter().flat_map(BoundedMap::iter)
    }

    fn keep(
        &mut self,
        now_ns: u64,
        slot: &Slot,
        frame: &Frame,
        is_lasting: bool,
    ) -> Result<(), Full> {
        let before = self.newest[slot.kind()].get(slot).map_or(0, length);
        if self.bytes - before + length(frame) > MAX_BYTES {
            return Err(Full);
        }
        let kind = &mut self.newest[slot.kind()];
        let gave_way = match is_lasting {
            true => kind.insert_lasting(now_ns, slot.clone(), frame.clone())?,
            false => kind.insert(now_ns, slot.clone(), frame.clone())?,
        };
        self.bytes = self.bytes + length(frame) - gave_way.as_ref().map_or(0, length);
        Ok(())
    }

    fn remove(&mut self, slot: &Slot) -> bool {
        let removed = self.newest[slot.kind()].remove(slot);
        self.bytes -= removed.as_ref().map_or(0, length);
        removed.is_some()
    }

    fn expire(&mut self, now_ns: u64) {
        for kind in &mut self.newest {
            let expired = kind.expire(now_ns);
            let bytes: usize = expired.iter().map(|(_, frame)| length(frame)).sum();
            self.bytes -= bytes;
        }
    }

    fn hand_out(&self, slot: &Slot, frame: &Frame) {
        for client in &self.clients {
            client.put(slot.clone(), frame.clone(), length(frame));
        }
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
        assert_eq!(outbox.try_pop(), Some(text("rig")));
        assert_eq!(outbox.try_pop(), Some(text("pose 2")));
        assert_eq!(outbox.try_pop(), None);
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
        assert_eq!(
            [late.try_pop(), late.try_pop()],
            [Some(text("other")), None]
        );
        let heard: Vec<_> = std::iter::from_fn(|| present.try_pop()).collect();
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

    fn bytes_kept(hub: &Hub) -> usize {
        let state = hub.lock();
        let sum: usize = state.newest().map(|(_, frame)| length(frame)).sum();
        assert_eq!(sum, state.bytes);
        sum
    }

    #[test]
    fn a_flood_of_one_kind_ends_at_its_bound_and_leaves_room_for_the_others() {
        let hub = Hub::default();
        type Make = fn(String) -> Slot;
        let kinds: [(Make, usize); 4] = [
            (Slot::Preview, 128),
            (Slot::Pose, 2048),
            (Slot::CameraStatus, 256),
            (|id| Slot::Alive("camera".to_owned(), id), 256),
        ];
        for (make, room) in kinds {
            let slots = (0..10 * room).map(|n| make(n.to_string()));
            let kept = slots.filter(|slot| hub.publish(slot, text("x")).is_ok());
            assert_eq!(kept.count(), room);
        }
        assert_eq!(bytes_kept(&hub), 128 + 2048 + 256 + 256);
    }

    #[test]
    fn a_flood_of_large_frames_ends_at_the_bytes() {
        let hub = Hub::default();
        let large = Frame::Binary(vec![0; MAX_BYTES / 16].into());
        let slots = (0..160).map(|n| Slot::Object(n.to_string()));
        let kept = slots.filter(|slot| hub.publish(slot, large.clone()).is_ok());
        assert_eq!(kept.count(), 16);
        // Those that are kept may go on.
        hub.publish(&Slot::Object("3".to_owned()), large).unwrap();
        assert_eq!(bytes_kept(&hub), MAX_BYTES);
    }

    #[test]
    fn what_nothing_is_heard_of_is_forgotten() {
        let hub = Hub::default();
        let object = |id: &str| Slot::Object(id.to_owned());
        for slot in [object("forged"), Slot::Rig, Slot::Pose("cube".to_owned())] {
            hub.publish(&slot, text("x")).unwrap();
        }
        let node = Slot::Alive("fusion".to_owned(), "main".to_owned());
        hub.publish_lasting(&node, text("up")).unwrap();
        let published = monotonic_ns();
        for id in ["arm", "arm.upper"] {
            hub.publish(&object(id), text("x")).unwrap();
        }
        while monotonic_ns() == published {}
        hub.confirm_objects(&BTreeSet::from(["arm"]));
        hub.expire(published + FORGOTTEN_NS);
        let state = hub.lock();
        let kept: Vec<&Slot> = state.newest().map(|(slot, _)| slot).collect();
        assert_eq!(
            kept,
            [&Slot::Rig, &object("arm"), &object("arm.upper"), &node]
        );
    }

    #[test]
    fn farewells_to_objects_that_nobody_knows_reach_nobody() {
        let hub = Hub::default();
        let client = hub.join().unwrap();
        for n in 0..20_480 {
            hub.forget_object(&n.to_string(), &text("gone"));
        }
        assert_eq!(client.len(), 0);
        // Nor do those to objects that came and went fill the outbox of a client that does not read.
        for n in 0..20_480 {
            let id = n.to_string();
            hub.publish(&Slot::Object(id.clone()), text("object"))
                .unwrap();
            hub.forget_object(&id, &text("gone"));
        }
        assert!(client.is_closed());
        assert_eq!((client.len(), bytes_kept(&hub)), (0, 0));
    }

    #[test]
    fn clients_are_bounded() {
        let hub = Hub::default();
        let clients: Vec<_> = (0..2 * MAX_CLIENTS).filter_map(|_| hub.join()).collect();
        assert_eq!(clients.len(), MAX_CLIENTS);
    }
}
