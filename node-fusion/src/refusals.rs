//! Refused changes: errors of the libraries as [`Refusal`]s, and those of the last minute for the status.

use sextant_estimator::ModelError;
use sextant_proto::{DecodeError, Notice, Refusal, RigConfigError, limits};
use sextant_site_model::ObjectError;
use std::collections::BTreeMap;
use std::fmt::Display;

/// How long a refusal is shown, ns.
const SHOWN_NS: u64 = 60_000_000_000;
/// Most refusals shown at a time; the oldest gives way.
const MOST: usize = 4;

/// The text of an error, as long as a message may hold.
pub fn detail(error: &dyn Display) -> String {
    limits::clipped(&error.to_string(), limits::MAX_DETAIL_BYTES)
}

/// Bytes that are no message.
pub fn undecodable(error: DecodeError) -> Refusal {
    Refusal::Undecodable {
        detail: detail(&error),
    }
}

/// A message that makes no rig.
pub fn invalid_camera(error: &RigConfigError) -> Refusal {
    let detail = detail(error);
    match error.camera().cloned() {
        Some(camera) => Refusal::InvalidCamera { camera, detail },
        None => Refusal::Undecodable { detail },
    }
}

/// A message whose tags, links and joints make no object.
pub fn invalid_object(error: &ObjectError) -> Refusal {
    Refusal::InvalidObject {
        tag: error.tag(),
        detail: detail(error),
    }
}

/// Models that the estimator refuses.
pub fn unusable(error: ModelError) -> Refusal {
    match error {
        ModelError::SharedTag { tag, first, second } => Refusal::SharedTag { tag, first, second },
        other => Refusal::Other {
            detail: detail(&other),
        },
    }
}

/// The last refusal of each key.
#[derive(Debug, Default)]
pub struct Refusals {
    /// With the time of the refusal, ns.
    by_key: BTreeMap<String, (u64, Notice)>,
}

impl Refusals {
    /// Adds the refusal of a change of `key` that `sender` asked for, at `now_ns`.
    pub fn add(&mut self, key: &str, sender: Option<&str>, refusal: &Refusal, now_ns: u64) {
        let notice = Notice::ChangeRefused {
            key: key.to_owned(),
            sender: sender.map(str::to_owned),
            refusal: refusal.clone(),
        };
        self.by_key.insert(key.to_owned(), (now_ns, notice));
        if self.by_key.len() > MOST {
            let oldest = self.by_key.iter().min_by_key(|(_, (at_ns, _))| *at_ns);
            let oldest = oldest.map(|(key, _)| key.clone());
            oldest.map(|key| self.by_key.remove(&key));
        }
    }

    /// Drops the refusal of a key whose change was accepted since.
    pub fn remove(&mut self, key: &str) {
        self.by_key.remove(key);
    }

    /// What is shown at `now_ns`, by key.
    pub fn notices(&mut self, now_ns: u64) -> Vec<Notice> {
        self.by_key
            .retain(|_, (at_ns, _)| now_ns.saturating_sub(*at_ns) < SHOWN_NS);
        let notices = self.by_key.values();
        notices.map(|(_, notice)| notice.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_shown_for_a_minute_or_until_a_change_is_accepted() {
        let mut refusals = Refusals::default();
        refusals.add("config/rig", Some("ann@desk"), &Refusal::NoCamera, 10);
        let limit = Refusal::TooManyObjects { limit: 3 };
        refusals.add("config/object/cube", None, &limit, 20);
        let texts = |refusals: &mut Refusals, now_ns| -> Vec<String> {
            let notices = refusals.notices(now_ns);
            notices.iter().map(ToString::to_string).collect()
        };
        assert_eq!(
            texts(&mut refusals, SHOWN_NS),
            [
                "change of config/object/cube refused: a site has at most 3 objects",
                "change of config/rig by ann@desk refused: the rig has no camera"
            ]
        );
        assert_eq!(refusals.notices(SHOWN_NS + 10).len(), 1);
        refusals.remove("config/object/cube");
        assert!(refusals.notices(SHOWN_NS + 10).is_empty());
    }

    #[test]
    fn a_flood_of_keys_pushes_the_oldest_out() {
        let mut refusals = Refusals::default();
        for k in 0..1000_u64 {
            refusals.add(&format!("config/object/o{k}"), None, &Refusal::NoCamera, k);
        }
        let shown = refusals.notices(1000);
        assert_eq!(shown.len(), MOST);
        assert!(shown[0].to_string().contains("o996"), "{shown:?}");
    }
}
