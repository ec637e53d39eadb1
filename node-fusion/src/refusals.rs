//! The changes that were refused of late, as a person reads them in the status.

use std::collections::BTreeMap;

/// How long a refusal is told.
const TOLD_NS: u64 = 60_000_000_000;
/// Most refusals told at a time: the status has room for faults, too.
const MOST: usize = 4;

/// The last refusal of each key.
#[derive(Debug, Default)]
pub struct Refusals {
    by_key: BTreeMap<String, (u64, String)>,
}

impl Refusals {
    /// A change of `key` was refused at `now_ns`; `sender` is who signed it.
    pub fn add(&mut self, key: &str, sender: Option<&str>, cause: &str, now_ns: u64) {
        let from = sender.map_or_else(String::new, |sender| format!(" from {sender}"));
        let sentence = format!("change of {key}{from} refused: {cause}");
        self.by_key.insert(key.to_owned(), (now_ns, sentence));
        if self.by_key.len() > MOST {
            let oldest = self.by_key.iter().min_by_key(|(_, (at_ns, _))| *at_ns);
            let oldest = oldest.map(|(key, _)| key.clone());
            oldest.map(|key| self.by_key.remove(&key));
        }
    }

    /// A change of `key` was taken: what was refused before is history.
    pub fn settle(&mut self, key: &str) {
        self.by_key.remove(key);
    }

    /// What is still to be told, by key.
    pub fn sentences(&mut self, now_ns: u64) -> Vec<String> {
        self.by_key
            .retain(|_, (at_ns, _)| now_ns.saturating_sub(*at_ns) < TOLD_NS);
        let sentences = self.by_key.values();
        sentences.map(|(_, sentence)| sentence.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_told_for_a_minute_or_until_a_change_is_taken() {
        let mut refusals = Refusals::default();
        refusals.add("config/rig", Some("ann@desk"), "no camera", 10);
        refusals.add("config/object/cube", None, "no tag", 20);
        assert_eq!(
            refusals.sentences(TOLD_NS),
            [
                "change of config/object/cube refused: no tag",
                "change of config/rig from ann@desk refused: no camera"
            ]
        );
        assert_eq!(refusals.sentences(TOLD_NS + 10).len(), 1);
        refusals.settle("config/object/cube");
        assert!(refusals.sentences(TOLD_NS + 10).is_empty());
    }

    #[test]
    fn a_flood_of_keys_pushes_the_oldest_out() {
        let mut refusals = Refusals::default();
        for k in 0..1000_u64 {
            refusals.add(&format!("config/object/o{k}"), None, "no", k);
        }
        let told = refusals.sentences(1000);
        assert_eq!(told.len(), MOST);
        assert!(told[0].contains("o996"), "{told:?}");
    }
}
