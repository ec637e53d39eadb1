//! What happened to the node itself in the last seconds. Each kind of notice is logged once when it begins, and shown
//! until some seconds after it ended.

use sextant_proto::Notice;

/// How long a notice is shown after it was last added, ns.
const SHOWN_NS: u64 = 10_000_000_000;
/// Most notices shown at a time; further ones are passed over.
const MOST: usize = 16;

/// The notices of the last seconds.
#[derive(Debug, Default)]
pub struct Notices {
    shown: Vec<Shown>,
}

#[derive(Debug)]
struct Shown {
    at_ns: u64,
    notice: Notice,
}

impl Notices {
    /// Adds a notice in place of an earlier one about the same thing; `now_ns` is monotonic.
    pub fn add(&mut self, notice: Notice, now_ns: u64) {
        self.forget(now_ns);
        let at_ns = now_ns;
        let mut shown = self.shown.iter_mut();
        if let Some(known) = shown.find(|known| is_same(&known.notice, &notice)) {
            *known = Shown { at_ns, notice };
        } else if self.shown.len() < MOST {
            tracing::warn!("{notice}");
            self.shown.push(Shown { at_ns, notice });
        }
    }

    /// Whether the node was late itself lately.
    pub fn has_overload(&mut self, now_ns: u64) -> bool {
        self.forget(now_ns);
        let mut shown = self.shown.iter();
        shown.any(|shown| matches!(shown.notice, Notice::Overload { .. }))
    }

    /// Drops what was said about late cameras: it was the node that was late.
    pub fn drop_late(&mut self) {
        self.shown.retain(|shown| {
            !matches!(
                shown.notice,
                Notice::LateObservations { .. } | Notice::CamerasSlow { .. }
            )
        });
    }

    /// What is shown at `now_ns`, the longest shown first.
    pub fn notices(&mut self, now_ns: u64) -> Vec<Notice> {
        self.forget(now_ns);
        self.shown
            .iter()
            .map(|shown| shown.notice.clone())
            .collect()
    }

    fn forget(&mut self, now_ns: u64) {
        self.shown
            .retain(|shown| now_ns.saturating_sub(shown.at_ns) < SHOWN_NS);
    }
}

/// Whether two notices are of one kind, and of one camera where they name one.
fn is_same(one: &Notice, other: &Notice) -> bool {
    match (one, other) {
        (
            Notice::LateObservations { camera, .. },
            Notice::LateObservations { camera: second, .. },
        ) => camera == second,
        _ => std::mem::discriminant(one) == std::mem::discriminant(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_notice_of_a_kind_is_shown_for_some_seconds() {
        let overload = |total| Notice::Overload { dropped: 1, total };
        let step = Notice::ClockStepped { by_s: 2.0 };
        let mut notices = Notices::default();
        notices.add(overload(3), 10);
        notices.add(overload(5), 20);
        notices.add(step.clone(), 30);
        assert_eq!(notices.notices(40), [overload(5), step.clone()]);
        assert_eq!(notices.notices(20 + SHOWN_NS), [step]);
        assert!(notices.notices(30 + SHOWN_NS).is_empty());
    }

    #[test]
    fn cameras_have_notices_of_their_own_in_bounded_number() {
        let mut notices = Notices::default();
        for n in 0..10 * MOST {
            let camera = format!("c{n}").parse().unwrap();
            notices.add(Notice::LateObservations { camera, total: 1 }, 10);
        }
        assert_eq!(notices.notices(10).len(), MOST);
    }
}
