//! The last status of each node, for `/diagnostics`.

use std::collections::BTreeMap;

use sextant_proto::limits;

use crate::convert::diagnostics::{OK, STALE, value};
use crate::messages::{DiagnosticArray, DiagnosticStatus, Header};

/// A node that said nothing for so long is stale; after a while more it is forgotten.
const STALE_NS: u64 = 5_000_000_000;
const FORGOTTEN_NS: u64 = 300_000_000_000;
/// Most nodes: the cameras of a rig, and as many others.
const MOST_NODES: usize = 2 * limits::MAX_CAMERAS;

/// The last status of each node by its name, with its time.
#[derive(Debug, Default)]
pub(super) struct Health {
    nodes: BTreeMap<String, (u64, DiagnosticStatus)>,
}

impl Health {
    /// Keeps the state of a node, if there is one.
    pub(super) fn keep(&mut self, now_ns: u64, status: Option<DiagnosticStatus>) {
        let Some(status) = status else { return };
        if self.nodes.len() < MOST_NODES || self.nodes.contains_key(&status.name) {
            self.nodes.insert(status.name.clone(), (now_ns, status));
        }
    }

    /// All nodes, and the bridge itself with these counts.
    pub(super) fn report<'a>(
        &mut self,
        now_ns: u64,
        counts: impl Iterator<Item = (&'a str, u64)>,
    ) -> DiagnosticArray {
        self.nodes
            .retain(|_, (since_ns, _)| now_ns.saturating_sub(*since_ns) < FORGOTTEN_NS);
        let bridge = DiagnosticStatus {
            level: OK,
            name: "sextant: ros2".to_owned(),
            message: format!("{} nodes", self.nodes.len()),
            hardware_id: String::new(),
            values: counts.map(|(key, count)| value(key, count)).collect(),
        };
        let nodes = self.nodes.values();
        let nodes = nodes.map(|(since_ns, status)| {
            let mut status = status.clone();
            if now_ns.saturating_sub(*since_ns) >= STALE_NS {
                status.level = STALE;
                status.message = "no status for more than 5 s".to_owned();
            }
            status
        });
        DiagnosticArray {
            header: Header::new(now_ns, ""),
            status: std::iter::once(bridge).chain(nodes).collect(),
        }
    }
}
