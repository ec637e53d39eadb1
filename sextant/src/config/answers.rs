//! The answer of a site to one change.

use anyhow::{anyhow, bail};
use sextant_gateways::site::SiteSession;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure};
use sextant_proto::{ConfigAnswer, NodeKind, fingerprint, limits};
use sextant_zenoh_bus::{DropRule, Subscription};
use std::time::{Duration, Instant};

/// Answers of others that wait; the oldest give way.
const QUEUE: usize = 256;
/// How long the fusion nodes may take to repeat their last answers.
const ASKED_AGAIN: Duration = Duration::from_millis(100);
/// After so long the change is asked for again: the fusion node that decides may just have been replaced.
const AGAIN: Duration = Duration::from_secs(2);
/// How long the answer may take: the disk of the fusion node may be slow.
const PATIENCE: Duration = Duration::from_secs(15);

/// Waits for the answer of the fusion node that publishes the poses.
pub struct AwaitedAnswer<'a> {
    site: &'a SiteSession,
    subscription: Subscription,
    fingerprint: u64,
    /// What each node had answered last before the question: to the same payload, perhaps, but not to this one.
    before: Vec<ConfigAnswer>,
}

impl<'a> AwaitedAnswer<'a> {
    /// Listens from now on for the answer to this payload.
    ///
    /// # Errors
    /// No fusion node lives on the site.
    pub fn expect(site: &'a SiteSession, payload: &[u8]) -> anyhow::Result<Self> {
        let key = site.keys.all_config_answers();
        let subscription =
            site.bus
                .subscribe(&key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)?;
        let mirror = site.mirror(&[])?;
        if mirror.alive(NodeKind::Fusion).next().is_none() {
            let name = site.keys.site();
            let cause = anyhow!(
                "no fusion node lives on site {name}; start one (`sextant fusion`) or name the site with --site"
            );
            bail!(Failure::new(Exit::Unavailable, cause))
        }
        Ok(Self {
            site,
            subscription,
            fingerprint: fingerprint(payload),
            before: site.latest(&key)?,
        })
    }

    /// The answer. `ask` publishes the change, and again after a while without one.
    ///
    /// # Errors
    /// When there is none.
    pub fn wait(self, ask: impl Fn() -> anyhow::Result<()>) -> anyhow::Result<ConfigAnswer> {
        ask()?;
        let begun = Instant::now();
        let mut asks_again = true;
        loop {
            if self.site.shutdown.is_requested() {
                bail!(Failure::new(Exit::Interrupted, anyhow!("interrupted")));
            }
            if let Some(answer) = self.poll()? {
                return Ok(answer);
            }
            if begun.elapsed() >= PATIENCE {
                let cause = anyhow!(
                    "no fusion node has answered for {} s; `sextant config get` says what is in force",
                    PATIENCE.as_secs()
                );
                bail!(Failure::new(Exit::Unavailable, cause));
            }
            if asks_again && begun.elapsed() >= AGAIN {
                asks_again = false;
                ask()?;
            }
        }
    }

    /// Answers come by themselves; one that came before the network knew of this listener is asked for.
    fn poll(&self) -> anyhow::Result<Option<ConfigAnswer>> {
        let come = self.subscription.recv_timeout(SHUTDOWN_POLL);
        let answers = match come {
            Some(item) => item.decode().into_iter().collect(),
            None => {
                let key = self.site.keys.all_config_answers();
                new_among(self.site.latest_within(&key, ASKED_AGAIN)?, &self.before)
            }
        };
        let ours = |answer: &ConfigAnswer| answer.fingerprint == self.fingerprint;
        Ok(answers.into_iter().find(ours))
    }
}

/// Those that have been given since. A node that says the very same again is heard by the subscription.
fn new_among(answers: Vec<ConfigAnswer>, before: &[ConfigAnswer]) -> Vec<ConfigAnswer> {
    let is_new = |answer: &ConfigAnswer| !before.contains(answer);
    answers.into_iter().filter(is_new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ChangeOutcome, NodeId};

    #[test]
    fn what_was_answered_before_is_no_answer_now() {
        let answer = |outcome| ConfigAnswer {
            node: NodeId::new("main").unwrap(),
            key: "config/rig".to_owned(),
            fingerprint: fingerprint(b"rig"),
            outcome,
            followers: vec![],
            behind: vec![],
        };
        let (taken, same) = (answer(ChangeOutcome::Taken), answer(ChangeOutcome::Same));
        let before = [taken.clone()];
        assert_eq!(new_among(vec![taken], &before), []);
        assert_eq!(new_among(vec![same.clone()], &before), [same]);
    }
}
