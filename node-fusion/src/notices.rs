//! What happens to the node itself, as a person reads it in the status: overload, messages that could not be published, a clock
//! that was set. Each kind is logged once when it begins and shown until some seconds after it ended.

use std::collections::BTreeMap;

/// How long a notice is shown after it was last given, ns.
const SHOWN_NS: u64 = 10_000_000_000;

/// What a notice is about: one of each is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Observations were dropped unread.
    Overload,
    /// Observations were too old on arrival.
    TooOld,
    /// Messages could not be encoded.
    Unpublished,
    /// The host's clock was set.
    ClockStep,
}

/// The notices of the last seconds.
#[derive(Debug, Default)]
pub struct Notices {
    shown: BTreeMap<Kind, (u64, String)>,
}

impl Notices {
    /// Gives a notice in place of the former one of its kind; `now_ns` is monotonic.
    pub fn give(&mut self, kind: Kind, words: String, now_ns: u64) {
        if self
            .shown
            .get(&kind)
            .is_none_or(|(at_ns, _)| is_over(*at_ns, now_ns))
        {
            tracing::warn!("{words}");
        }
        self.shown.insert(kind, (now_ns, words));
    }

    /// What is to be shown.
    pub fn sentences(&mut self, now_ns: u64) -> Vec<String> {
        self.shown.retain(|_, (at_ns, _)| !is_over(*at_ns, now_ns));
        self.shown
            .values()
            .map(|(_, words)| words.clone())
            .collect()
    }
}

fn is_over(at_ns: u64, now_ns: u64) -> bool {
    now_ns.saturating_sub(at_ns) >= SHOWN_NS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_notice_of_a_kind_is_shown_for_some_seconds() {
        let mut notices = Notices::default();
        notices.give(Kind::Overload, "3 dropped".to_owned(), 10);
        notices.give(Kind::Overload, "5 dropped".to_owned(), 20);
        notices.give(Kind::ClockStep, "the clock was set".to_owned(), 30);
        assert_eq!(notices.sentences(40), ["5 dropped", "the clock was set"]);
        assert_eq!(notices.sentences(20 + SHOWN_NS), ["the clock was set"]);
        assert!(notices.sentences(30 + SHOWN_NS).is_empty());
    }
}
