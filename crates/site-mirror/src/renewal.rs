//! When to ask again for what a site's nodes keep for those who join late, and what comes meanwhile.

use std::collections::VecDeque;

/// Nodes that have lost each other agree within this time, ns. Until then two of them may answer.
const AGREED_NS: u64 = 5_000_000_000;
/// Most messages that wait for the answers: a rig, more objects than a site has, and settings.
const MOST_HELD: usize = 1024;

/// Decides when to ask for the values that the nodes of a site keep: what was published meanwhile may have been missed.
///
/// That is at the start, whenever the own link is back, and whenever a node appears that may keep values: it has
/// started, or lay beyond a link between routers that was down. Since two nodes may both believe to be in charge just
/// then, each question is asked again a little later.
///
/// What is published while a question is open is newer than the answers, and is to be handled after them:
/// [`hold`](Self::hold) keeps it until [`next_held`](Self::next_held) gives it back. The question is open until that
/// gives none.
#[derive(Debug)]
pub struct Renewal<T> {
    is_linked: bool,
    is_due: bool,
    again_ns: Option<u64>,
    /// While a question is open.
    held: Option<VecDeque<T>>,
}

impl<T> Default for Renewal<T> {
    fn default() -> Self {
        Self {
            is_linked: false,
            is_due: false,
            again_ns: None,
            held: None,
        }
    }
}

impl<T> Renewal<T> {
    /// State of the own link, whether or not it has changed.
    pub fn link(&mut self, is_linked: bool) {
        self.is_due |= is_linked && !self.is_linked;
        self.is_linked = is_linked;
    }

    /// A node that may keep values has appeared.
    pub fn joined(&mut self) {
        self.is_due = true;
    }

    /// Whether to ask at `now_ns`, by any clock that is not set. If so, the question is open from now on.
    pub fn take_due(&mut self, now_ns: u64) -> bool {
        let is_again = self.again_ns.is_some_and(|again_ns| now_ns >= again_ns);
        if !self.is_linked || self.held.is_some() || !self.is_due && !is_again {
            return false;
        }
        self.again_ns = self.is_due.then(|| now_ns.saturating_add(AGREED_NS));
        self.is_due = false;
        self.held = Some(VecDeque::new());
        true
    }

    /// Takes a message that is published: the one that is returned is to be handled now, others after the answers.
    /// Messages keep their order, also beyond the bound.
    pub fn hold(&mut self, message: T) -> Option<T> {
        let Some(held) = &mut self.held else {
            return Some(message);
        };
        held.push_back(message);
        (held.len() > MOST_HELD).then(|| held.pop_front()).flatten()
    }

    /// After the answers were handled, or when none comes any more: the next message to be handled. Without one the
    /// question is closed.
    pub fn next_held(&mut self) -> Option<T> {
        let next = self.held.as_mut()?.pop_front();
        if next.is_none() {
            self.held = None;
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asks, and has its answer at once.
    fn asks(renewal: &mut Renewal<u8>, now_ns: u64) -> bool {
        let is_due = renewal.take_due(now_ns);
        assert_eq!(renewal.next_held(), None);
        is_due
    }

    #[test]
    fn each_cause_is_followed_by_two_questions() {
        let mut renewal = Renewal::default();
        assert!(!asks(&mut renewal, 0), "no question without a link");
        renewal.link(true);
        assert!(asks(&mut renewal, 1) && !asks(&mut renewal, 2));
        renewal.link(true);
        assert!(!asks(&mut renewal, AGREED_NS));
        assert!(asks(&mut renewal, AGREED_NS + 1) && !asks(&mut renewal, 2 * AGREED_NS + 2));
        renewal.joined();
        renewal.link(false);
        assert!(!asks(&mut renewal, 3 * AGREED_NS));
        renewal.link(true);
        assert!(asks(&mut renewal, 3 * AGREED_NS));
        renewal.joined();
        assert!(asks(&mut renewal, 3 * AGREED_NS + 2));
        assert!(!asks(&mut renewal, 4 * AGREED_NS), "the later cause counts");
        assert!(asks(&mut renewal, 4 * AGREED_NS + 2));
    }

    #[test]
    fn what_comes_meanwhile_waits_for_the_answers() {
        let mut renewal = Renewal::default();
        renewal.link(true);
        assert_eq!(renewal.hold(1), Some(1));
        assert!(renewal.take_due(0));
        assert_eq!(renewal.hold(2), None);
        assert_eq!(renewal.hold(3), None);
        renewal.joined();
        assert!(!renewal.take_due(1), "one question at a time");
        assert_eq!(renewal.next_held(), Some(2));
        assert_eq!(renewal.hold(4), None, "still open");
        assert_eq!(
            [renewal.next_held(), renewal.next_held()],
            [Some(3), Some(4)]
        );
        assert_eq!(renewal.next_held(), None);
        assert_eq!(renewal.hold(4), Some(4));
        assert!(renewal.take_due(2));
        let waiting = (0..2 * MOST_HELD).filter(|_| renewal.hold(5).is_none());
        assert_eq!(waiting.count(), MOST_HELD);
    }

    #[test]
    fn a_flood_keeps_its_order() {
        let mut renewal = Renewal::default();
        renewal.link(true);
        assert!(renewal.take_due(0));
        let flood = 0..2 * MOST_HELD;
        let mut handled: Vec<usize> = flood.clone().filter_map(|n| renewal.hold(n)).collect();
        handled.extend(std::iter::from_fn(|| renewal.next_held()));
        assert!(handled.into_iter().eq(flood));
    }
}
