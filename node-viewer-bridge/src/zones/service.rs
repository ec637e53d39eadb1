//! What network, server and webhook share of the zones.
//!
//! Invariant: the file is read and written under the lock of editing only, which no network thread takes.

use super::command::Command;
use super::event::Event;
use super::judge::Judge;
use super::sample::Sample;
use super::zone::{Zone, ZonesFile};
use crate::frame::frame_of;
use crate::hub::{Hub, Slot};
use crate::refusal::Refusal;
use serde::Serialize;
use sextant_proto::ObjectPose;
use sextant_site_files::{FileError, read_toml_checked, write_toml};
use sextant_site_model::ObjectId;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Events sent to clients.
const REMEMBERED: usize = 64;
/// Events waiting for the network's thread. Drop rule: the oldest, counted.
const WAITING: usize = 256;

/// The zones of a bridge and the last events.
pub(crate) struct ZoneService {
    /// Where the zones are kept; without it they last as long as the bridge.
    file: Option<PathBuf>,
    editing: Mutex<()>,
    state: Mutex<ZonesState>,
}

#[derive(Default)]
struct ZonesState {
    judge: Judge,
    n_events: u64,
    last: VecDeque<Event>,
    waiting: VecDeque<Event>,
    dropped: u64,
}

/// Every zone with the objects in it.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "zones")]
struct ZonesReport<'a> {
    zones: Vec<Occupied<'a>>,
    /// Whether they are kept in a file.
    kept: bool,
}

#[derive(Debug, Serialize)]
struct Occupied<'a> {
    #[serde(flatten)]
    zone: &'a Zone,
    inside: Vec<&'a ObjectId>,
}

/// The last events, oldest first.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "events")]
struct EventsReport<'a> {
    events: &'a VecDeque<Event>,
    /// Events that were not published on the network for want of room.
    dropped: u64,
}

impl ZoneService {
    /// Reads `zones.toml` in the folder, if there is one.
    ///
    /// # Errors
    /// A file that is unreadable or does not describe zones.
    pub(crate) fn open(folder: Option<&Path>) -> Result<Self, FileError> {
        let file = folder.map(|folder| folder.join("zones.toml"));
        let zones = match &file {
            Some(file) if file.exists() => read_toml_checked(file, ZonesFile::check)?.zones,
            _ => Vec::new(),
        };
        let mut state = ZonesState::default();
        state.judge.set_zones(zones);
        Ok(Self {
            file,
            editing: Mutex::default(),
            state: Mutex::new(state),
        })
    }

    /// Publishes zones and events for clients.
    pub(crate) fn show(&self, hub: &Hub) {
        self.show_locked(&self.lock(), hub);
    }

    /// Takes a pose from the network.
    pub(crate) fn take_pose(&self, pose: &ObjectPose, hub: &Hub) {
        let Some(sample) = Sample::from_pose(pose) else {
            return;
        };
        let mut state = self.lock();
        let judgement = state.judge.handle(&pose.object, &sample);
        if judgement.events.is_empty() && !judgement.occupancy_changed {
            return;
        }
        for kind in judgement.events {
            let sequence = state.n_events;
            state.push(Event {
                sequence,
                t_ns: pose.capture_ns,
                object: pose.object.clone(),
                kind,
                position: pose.position,
            });
        }
        self.show_locked(&state, hub);
    }

    /// There is no such object any more.
    pub(crate) fn forget_object(&self, object: &ObjectId, hub: &Hub) {
        let mut state = self.lock();
        if state.judge.forget(object) {
            self.show_locked(&state, hub);
        }
    }

    /// Changes the zones, in the file first; may wait for the disk.
    ///
    /// # Errors
    /// Something entered that is wrong, too many zones, or a file that cannot be written: nothing changes.
    pub(crate) fn command(&self, command: Command, hub: &Hub) -> Result<(), Refusal> {
        let _editing = self.editing.lock().unwrap_or_else(PoisonError::into_inner);
        let before = self.lock().judge.zones().to_vec();
        let changed = command.apply(&before)?;
        if let Some(file) = &self.file {
            write_toml(file, &changed).map_err(Refusal::not_now)?;
        }
        let mut state = self.lock();
        state.judge.set_zones(changed.zones);
        self.show_locked(&state, hub);
        Ok(())
    }

    /// The oldest event that is not on the network yet.
    pub(crate) fn take_event(&self) -> Option<Event> {
        self.lock().waiting.pop_front()
    }

    fn show_locked(&self, state: &ZonesState, hub: &Hub) {
        let occupied = |zone| Occupied {
            zone,
            inside: state.judge.inside(zone).collect(),
        };
        let zones = ZonesReport {
            zones: state.judge.zones().iter().map(occupied).collect(),
            kept: self.file.is_some(),
        };
        let events = EventsReport {
            events: &state.last,
            dropped: state.dropped,
        };
        // One slot each: fails only when other frames fill the hub.
        let _ = hub.publish(&Slot::Zones, frame_of(&zones));
        let _ = hub.publish(&Slot::Events, frame_of(&events));
    }

    fn lock(&self) -> MutexGuard<'_, ZonesState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ZonesState {
    fn push(&mut self, event: Event) {
        self.n_events += 1;
        if self.last.len() == REMEMBERED {
            self.last.pop_front();
        }
        self.last.push_back(event.clone());
        if self.waiting.len() == WAITING {
            self.waiting.pop_front();
            self.dropped += 1;
        }
        self.waiting.push_back(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_report::State as PoseState;

    const SET: &str =
        r#"{"do":"set","zone":{"shape":"sphere","name":"ball","centre":[0,0,0],"radius":1}}"#;

    fn obey(service: &ZoneService, hub: &Hub, text: &str) -> Result<(), Refusal> {
        service.command(Command::parse(text.as_bytes())?, hub)
    }

    fn cross(service: &ZoneService, hub: &Hub, crossings: u64) {
        for frame in 0..10 * crossings {
            let x = if (frame / 10) % 2 == 0 { 3.0 } else { 0.0 };
            let pose = ObjectPose {
                object: ObjectId::new("cube").unwrap(),
                epoch: 1,
                sequence: frame,
                capture_ns: 1 + frame * 33_000_000,
                published_ns: 1,
                state: PoseState::Tracking,
                position: [x, 0.0, 0.0],
                orientation: [0.0, 0.0, 0.0, 1.0],
                covariance: [0.0; 36],
                twist: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                cameras: 1,
                tags: 1,
                rms_px: 0.1,
            };
            service.take_pose(&pose, hub);
        }
    }

    #[test]
    fn zones_survive_the_bridge_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let hub = Hub::default();
        let service = ZoneService::open(Some(folder.path())).unwrap();
        obey(&service, &hub, SET).unwrap();
        let again = ZoneService::open(Some(folder.path())).unwrap();
        assert_eq!(again.lock().judge.zones(), service.lock().judge.zones());
        assert_eq!(again.lock().judge.zones().len(), 1);
    }

    #[test]
    fn a_file_that_says_something_else_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let text =
            "[[zone]]\nshape = \"sphere\"\nname = \"a\"\ncentre = [0.0, 0.0, 0.0]\nradius = -1.0\n";
        std::fs::write(folder.path().join("zones.toml"), text).unwrap();
        let error = ZoneService::open(Some(folder.path()))
            .map(drop)
            .unwrap_err();
        let error = error.to_string();
        assert!(
            error.contains("zones.toml:5") && error.contains("radius"),
            "{error}"
        );
    }

    #[test]
    fn a_change_that_cannot_be_written_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let hub = Hub::default();
        let service = ZoneService::open(Some(&folder.path().join("missing"))).unwrap();
        assert!(obey(&service, &hub, SET).is_err());
        assert!(service.lock().judge.zones().is_empty());
    }

    #[test]
    fn a_flood_of_events_ends_at_its_bounds() {
        let hub = Hub::default();
        let service = ZoneService::open(None).unwrap();
        obey(&service, &hub, SET).unwrap();
        cross(&service, &hub, 2 * WAITING as u64);
        let state = service.lock();
        assert_eq!(
            (state.last.len(), state.waiting.len()),
            (REMEMBERED, WAITING)
        );
        assert_eq!(state.dropped, state.n_events - WAITING as u64);
        assert!(state.dropped > 0);
    }
}
