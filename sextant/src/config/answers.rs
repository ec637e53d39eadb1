//! The answers of a site's fusion nodes to one change.

use anyhow::{anyhow, bail};
use sextant_gateways::site::SiteSession;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure};
use sextant_proto::{ConfigAnswer, KeyRef, NodeId, NodeKind, fingerprint, limits};
use sextant_zenoh_bus::{DropRule, Presence, Subscription};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Answers of others that wait; the oldest give way.
const QUEUE: usize = 256;
/// Tokens of living nodes come within this after the question; the first is waited for longer.
const TOKENS: Duration = Duration::from_millis(500);
/// How long they may take to repeat their last answers.
const ASKED_AGAIN: Duration = Duration::from_millis(100);
/// How long the nodes may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// Waits for the answer of every fusion node that lives.
pub struct Answers<'a> {
    site: &'a SiteSession,
    subscription: Subscription,
    nodes: Vec<NodeId>,
    fingerprint: u64,
    /// What each had answered last before the question: to the same payload, perhaps, but not to this one.
    before: Vec<ConfigAnswer>,
    heard: BTreeMap<NodeId, ConfigAnswer>,
}

impl<'a> Answers<'a> {
    /// Listens from now on for answers to this payload.
    ///
    /// # Errors
    /// No fusion node lives on the site.
    pub fn expect(site: &'a SiteSession, payload: &[u8]) -> anyhow::Result<Self> {
        let key = site.keys.all_config_answers();
        let subscription =
            site.bus
                .subscribe(&key, QUEUE, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)?;
        let nodes = living(site)?;
        if nodes.is_empty() {
            let name = site.keys.site();
            let cause = anyhow!(
                "no fusion node lives on site {name}; start one (`sextant fusion`) or name the site with --site"
            );
            bail!(Failure::new(Exit::Unavailable, cause))
        }
        Ok(Self {
            site,
            subscription,
            nodes,
            fingerprint: fingerprint(payload),
            before: site.latest_within(&key, PATIENCE)?,
            heard: BTreeMap::new(),
        })
    }

    /// One answer of each node, in order of their names.
    ///
    /// # Errors
    /// When one does not answer, naming it.
    pub fn wait(mut self) -> anyhow::Result<Vec<ConfigAnswer>> {
        let deadline = Instant::now() + PATIENCE;
        while let Some(silent) = self
            .nodes
            .iter()
            .find(|node| !self.heard.contains_key(node))
        {
            if self.site.shutdown.is_requested() {
                bail!(Failure::new(Exit::Interrupted, anyhow!("interrupted")));
            }
            if Instant::now() >= deadline {
                let cause = anyhow!(
                    "fusion node {silent} has not answered for {} s; `sextant config get` says what is in force",
                    PATIENCE.as_secs()
                );
                bail!(Failure::new(Exit::Unavailable, cause));
            }
            self.poll()?;
        }
        Ok(self.heard.into_values().collect())
    }

    /// Answers come by themselves; one that came before the network knew of this listener is asked for.
    fn poll(&mut self) -> anyhow::Result<()> {
        let come = self.subscription.recv_timeout(SHUTDOWN_POLL);
        let answers = match come {
            Some(item) => item.decode().into_iter().collect(),
            None => {
                let key = self.site.keys.all_config_answers();
                new_among(self.site.latest_within(&key, ASKED_AGAIN)?, &self.before)
            }
        };
        let ours = |answer: &ConfigAnswer| answer.fingerprint == self.fingerprint;
        for answer in answers.into_iter().filter(ours) {
            self.heard.insert(answer.node.clone(), answer);
        }
        Ok(())
    }
}

/// Those that have been given since. A node that says the very same again is heard by the subscription.
fn new_among(answers: Vec<ConfigAnswer>, before: &[ConfigAnswer]) -> Vec<ConfigAnswer> {
    let is_new = |answer: &ConfigAnswer| !before.contains(answer);
    answers.into_iter().filter(is_new).collect()
}

/// The fusion nodes that live.
fn living(site: &SiteSession) -> anyhow::Result<Vec<NodeId>> {
    let watch = site.bus.watch_alive(&site.keys.all_alive())?;
    let asked = Instant::now();
    let mut nodes = Vec::new();
    let patience = |nodes: &[NodeId]| if nodes.is_empty() { PATIENCE } else { TOKENS };
    while asked.elapsed() < patience(&nodes) && !site.shutdown.is_requested() {
        let Some(Presence::Joined(key)) = watch.recv_timeout(SHUTDOWN_POLL) else {
            continue;
        };
        if let Some(KeyRef::Alive(NodeKind::Fusion, id)) = site.keys.parse(&key)
            && !nodes.contains(&id)
        {
            nodes.push(id);
        }
    }
    Ok(nodes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::Outcome;

    #[test]
    fn what_was_answered_before_is_no_answer_now() {
        let answer = |outcome| ConfigAnswer {
            node: NodeId::new("main").unwrap(),
            key: "config/rig".to_owned(),
            fingerprint: fingerprint(b"rig"),
            outcome,
        };
        let (taken, same) = (answer(Outcome::Taken), answer(Outcome::Same));
        let before = [taken.clone()];
        assert_eq!(new_among(vec![taken], &before), []);
        assert_eq!(new_among(vec![same.clone()], &before), [same]);
    }
}
