//! The last half minute of the site's messages, to be saved as a recording at any time. Pictures are not in it.
//!
//! In: payloads as they arrive. Out: an MCAP file with the models in force at its beginning. Bounded in time and bytes.

pub(crate) mod download;

use sextant_proto::{ANNOUNCED, KeyRef};
use sextant_recordings::RecordingError;
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::writer::McapWriter;
use sextant_zenoh_bus::Item;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Path of the recording.
pub(crate) const LAST_MCAP: &str = "/api/last.mcap";
/// How long messages are kept, ns.
const SPAN_NS: u64 = 30_000_000_000;
/// Most bytes of them; the oldest give way.
const MOST_BYTES: usize = 32 << 20;
/// Most models from before, and their bytes.
const MOST_MODELS: usize = 2048;
const MOST_MODEL_BYTES: usize = 8 << 20;

/// The messages, newest last.
#[derive(Debug, Default)]
pub(crate) struct LastSeconds {
    state: Mutex<KeptState>,
}

#[derive(Debug, Default)]
struct KeptState {
    messages: VecDeque<KeptMessage>,
    bytes: usize,
    /// Rig and objects in force before the first of the messages, by key.
    models: BTreeMap<Arc<str>, KeptMessage>,
    model_bytes: usize,
}

#[derive(Debug, Clone)]
struct KeptMessage {
    key: Arc<str>,
    payload: Arc<[u8]>,
    arrival_ns: u64,
    is_model: bool,
}

impl KeptMessage {
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.key.len() + self.payload.len()
    }
}

impl LastSeconds {
    /// Takes a message in, unless it is a picture or a request to change a model.
    pub(crate) fn take(&self, about: &KeyRef, item: &Item, now_ns: u64) {
        let is_model = about.is_config();
        let is_foreign = |sender: &String| !sender.starts_with(ANNOUNCED);
        let is_request = *about == KeyRef::ConfigModels
            || (is_model && item.sender.as_ref().is_some_and(is_foreign));
        let is_picture = matches!(about, KeyRef::Preview(_) | KeyRef::DetectionReport(_));
        let Some(payload) = item.bytes().filter(|_| !is_request && !is_picture) else {
            return;
        };
        let message = KeptMessage {
            key: item.key.as_str().into(),
            payload: payload.into(),
            arrival_ns: now_ns,
            is_model,
        };
        let mut state = self.lock();
        state.bytes += message.bytes();
        state.messages.push_back(message);
        state.forget(now_ns);
    }

    /// The recording since a time, or as far back as there is.
    ///
    /// # Errors
    /// None that memory knows.
    pub(crate) fn save(&self, site: &str, since_ns: u64) -> Result<Vec<u8>, RecordingError> {
        let kept = self.lock().since(since_ns);
        let info = RecordingInfo {
            site: site.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let mut writer = McapWriter::begin(Vec::new(), Path::new("last.mcap"), &info)?;
        for message in kept {
            writer.write_payload(&message.key, &message.payload, message.arrival_ns)?;
        }
        writer.finish()
    }

    fn lock(&self) -> MutexGuard<'_, KeptState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl KeptState {
    /// The messages since a time, after the models that were in force then.
    fn since(&self, since_ns: u64) -> Vec<KeptMessage> {
        let mut models = self.models.clone();
        let is_before = |message: &&KeptMessage| message.arrival_ns < since_ns;
        let n_before = self.messages.iter().take_while(is_before).count();
        for model in self.messages.iter().take(n_before).filter(|m| m.is_model) {
            models.insert(Arc::clone(&model.key), model.clone());
        }
        let messages = self.messages.iter().skip(n_before).cloned();
        models.into_values().chain(messages).collect()
    }

    fn forget(&mut self, now_ns: u64) {
        while let Some(oldest) = self.messages.front() {
            let is_old = now_ns.abs_diff(oldest.arrival_ns) > SPAN_NS;
            if !is_old && self.bytes <= MOST_BYTES {
                return;
            }
            if let Some(oldest) = self.messages.pop_front() {
                self.bytes -= oldest.bytes();
                if oldest.is_model {
                    self.keep_model(oldest);
                }
            }
        }
    }

    fn keep_model(&mut self, model: KeptMessage) {
        if let Some(former) = self.models.remove(&model.key) {
            self.model_bytes -= former.bytes();
        }
        let bytes = self.model_bytes + model.bytes();
        if self.models.len() < MOST_MODELS && bytes <= MOST_MODEL_BYTES {
            self.model_bytes = bytes;
            self.models.insert(Arc::clone(&model.key), model);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{Keys, ObjectConfig, encode};
    use sextant_recordings::mcap::site_recording::SiteRecording;
    use sextant_zenoh_bus::Payload;

    fn take(last: &LastSeconds, key: &str, payload: &[u8], now_ns: u64) {
        let keys = Keys::new("lab").unwrap();
        let item = Item {
            key: format!("sextant/v1/lab/{key}"),
            payload: Payload::Bytes(payload.to_vec()),
            sender: None,
        };
        last.take(&keys.parse(&item.key).unwrap(), &item, now_ns);
    }

    fn n_messages(last: &LastSeconds) -> usize {
        last.lock().messages.len()
    }

    #[test]
    fn messages_leave_after_their_time_and_models_stay() {
        let last = LastSeconds::default();
        let cube = ObjectConfig::from(&crate::wizard::samples::cube());
        take(&last, "config/object/cube", &encode(&cube).unwrap(), 5);
        for k in 0..10 {
            take(&last, "fusion/a/status", &[0; 10], 6 + k);
        }
        take(&last, "camera/north/preview", &[0; 10], 7);
        assert_eq!(n_messages(&last), 11);
        take(&last, "fusion/a/status", &[0; 10], 5 + SPAN_NS + 6);
        assert_eq!(n_messages(&last), 6);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("last.mcap");
        std::fs::write(&file, last.save("lab", 0).unwrap()).unwrap();
        let recording = SiteRecording::read(&file).unwrap();
        assert_eq!(recording.models.len(), 1);
        assert_eq!(recording.info.site, "lab");
    }

    #[test]
    fn a_shorter_recording_has_the_models_of_its_beginning() {
        let last = LastSeconds::default();
        let cube = ObjectConfig::from(&crate::wizard::samples::cube());
        take(&last, "fusion/a/status", &[0; 10], 1);
        take(&last, "config/object/cube", &encode(&cube).unwrap(), 2);
        take(&last, "fusion/a/status", &[0; 10], 3);
        let kept = last.lock().since(3);
        let arrivals: Vec<u64> = kept.iter().map(|message| message.arrival_ns).collect();
        assert_eq!(arrivals, [2, 3]);
    }

    #[test]
    fn a_flood_stays_at_the_bound() {
        let last = LastSeconds::default();
        for k in 0..1000 {
            take(&last, "fusion/a/status", &[0; 100_000], k);
            take(&last, &format!("config/object/o{k}"), &[0; 100_000], k);
        }
        let state = last.lock();
        assert!(state.bytes <= MOST_BYTES);
        assert!(state.model_bytes <= MOST_MODEL_BYTES && !state.models.is_empty());
    }
}
