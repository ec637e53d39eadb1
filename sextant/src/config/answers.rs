//! The answers of a site's fusion nodes to one change.

use crate::site::Site;
use anyhow::{anyhow, bail};
use sextant_process::{Exit, Failure};
use sextant_proto::{ConfigAnswer, KeyRef, NodeId, NodeKind, fingerprint, limits};
use sextant_zenoh_bus::{DropRule, Item, Presence, Subscription};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Answers of others that wait; the oldest give way.
const QUEUE: usize = 256;
/// Tokens of living nodes come within this after the question.
const TOKENS: Duration = Duration::from_millis(500);
/// How long the nodes may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// How long one look for answers takes, and how late a Ctrl-C is heard.
const GLANCE: Duration = Duration::from_millis(100);

/// Waits for the answer of every fusion node that lives.
pub struct Answers<'a> {
    site: &'a Site,
    subscription: Subscription,
    nodes: Vec<NodeId>,
    fingerprint: u64,
    heard: BTreeMap<NodeId, ConfigAnswer>,
}

impl<'a> Answers<'a> {
    /// Listens from now on for answers to this payload.
    ///
    /// # Errors
    /// No fusion node lives on the site.
    pub fn expect(site: &'a Site, payload: &[u8]) -> anyhow::Result<Self> {
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
            self.look()?;
        }
        Ok(self.heard.into_values().collect())
    }

    /// Answers come by themselves; one that came before the network knew of this listener is asked for.
    fn look(&mut self) -> anyhow::Result<()> {
        match self.subscription.recv_timeout(GLANCE) {
            Some(item) => self.take(&item),
            None => {
                let key = self.site.keys.all_config_answers();
                let last = self
                    .site
                    .bus
                    .latest(&key, limits::MAX_PAYLOAD_BYTES, GLANCE)?;
                last.iter().for_each(|item| self.take(item));
            }
        }
        Ok(())
    }

    fn take(&mut self, item: &Item) {
        if let Ok(answer) = item.decode::<ConfigAnswer>()
            && answer.fingerprint == self.fingerprint
        {
            self.heard.insert(answer.node.clone(), answer);
        }
    }
}

/// The fusion nodes that live.
fn living(site: &Site) -> anyhow::Result<Vec<NodeId>> {
    let watch = site.bus.watch_alive(&site.keys.all_alive())?;
    let deadline = Instant::now() + TOKENS;
    let mut nodes = Vec::new();
    while Instant::now() < deadline && !site.shutdown.is_requested() {
        let Some(Presence::Joined(key)) = watch.recv_timeout(GLANCE) else {
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
