//! The last status of each node, for `/diagnostics`.

use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_mirror::{Heard, SiteMirror};

use crate::convert::diagnostics::{OK, STALE, value};
use crate::convert::{camera_status, fusion_status};
use crate::messages::{DiagnosticArray, DiagnosticStatus, Header};

/// All nodes, and the bridge itself with these counts.
pub(super) fn report<'a>(
    mirror: &SiteMirror,
    now_ns: u64,
    counts: impl Iterator<Item = (&'a str, u64)>,
) -> DiagnosticArray {
    let cameras = mirror.cameras().filter_map(|(_, one)| one.status.as_ref());
    let cameras = cameras.map(|status| state(status, camera_status, now_ns));
    let fusion = mirror.fusion_nodes();
    let fusion = fusion.filter_map(|(_, one)| one.status.as_ref());
    let fusion = fusion.map(|status| state(status, fusion_status, now_ns));
    let nodes: Vec<DiagnosticStatus> = cameras.chain(fusion).collect();
    let bridge = DiagnosticStatus {
        level: OK,
        name: "sextant: ros2".to_owned(),
        message: format!("{} nodes", nodes.len()),
        hardware_id: String::new(),
        values: counts.map(|(key, count)| value(key, count)).collect(),
    };
    DiagnosticArray {
        header: Header::new(now_ns, ""),
        status: std::iter::once(bridge).chain(nodes).collect(),
    }
}

/// The state of a node, stale once nothing was heard of it for too long.
fn state<T>(
    status: &Heard<T>,
    convert: impl Fn(&T) -> DiagnosticStatus,
    now_ns: u64,
) -> DiagnosticStatus {
    let mut state = convert(&status.message);
    if now_ns.saturating_sub(status.at_ns) > SILENCE_NS {
        state.level = STALE;
        let seconds = SILENCE_NS / 1_000_000_000;
        state.message = format!("no status for more than {seconds} s");
    }
    state
}
