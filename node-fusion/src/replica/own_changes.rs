//! Changes that this node has decided on, and which nodes have them: what of them is set aside when a network that was
//! divided is whole again.

use crate::models::{Change, ModelsInForce};
use crate::refusals::detail;
use sextant_geometry::se3;
use sextant_proto::{CameraSettings, NodeId};
use sextant_site_model::{Camera, Rig};
use std::collections::{BTreeSet, VecDeque};

/// Most changes that are remembered; the oldest gives way.
const MOST: usize = 64;
/// Most cameras of a rig that are named.
const NAMED: usize = 3;

#[derive(Debug)]
struct OwnChange {
    change: Change,
    /// When it was made, ns since the Unix epoch.
    t_ns: u64,
    /// The nodes that were seen with a version that has it.
    holders: BTreeSet<NodeId>,
}

/// The last changes of each model by this node.
#[derive(Debug, Default)]
pub struct OwnChanges {
    changes: VecDeque<OwnChange>,
}

/// Changes of this node that others have set aside.
#[derive(Debug, Clone, PartialEq)]
pub struct SetAside {
    /// The node whose version is in force.
    pub by: NodeId,
    /// When the last of them was made, ns since the Unix epoch.
    pub t_ns: u64,
    /// What they said.
    pub changes: Vec<Change>,
    /// What differs, English text.
    pub detail: String,
}

impl OwnChanges {
    /// This node has made changes.
    pub fn add(&mut self, changes: &[Change], t_ns: u64) {
        let is_known = |known: &OwnChange| {
            (changes.iter()).any(|change| change.is_about_the_same(&known.change))
        };
        self.changes.retain(|known| !is_known(known));
        self.changes.extend(changes.iter().map(|change| OwnChange {
            change: change.clone(),
            t_ns,
            holders: BTreeSet::new(),
        }));
        let n_too_many = self.changes.len().saturating_sub(MOST);
        self.changes.drain(..n_too_many);
    }

    /// Another node has the models of this one.
    pub fn shared_with(&mut self, node: &NodeId) {
        for known in &mut self.changes {
            if !known.holders.contains(node) {
                known.holders.insert(node.clone());
            }
        }
    }

    /// What a newer version by `author`, which makes `after` of the models `before`, sets aside. All changes are
    /// forgotten then.
    pub fn replaced(
        &mut self,
        author: &NodeId,
        before: &ModelsInForce,
        after: &ModelsInForce,
    ) -> Option<SetAside> {
        let lost: Vec<OwnChange> = std::mem::take(&mut self.changes)
            .into_iter()
            .filter(|own| !own.holders.contains(author))
            .filter(|own| !after.has(&own.change))
            .collect();
        let t_ns = lost.iter().map(|own| own.t_ns).max()?;
        let changes: Vec<Change> = lost.into_iter().map(|own| own.change).collect();
        let words = changes.iter().map(|change| words(change, before, after));
        let detail = detail(&words.collect::<Vec<_>>().join("; "));
        Some(SetAside {
            by: author.clone(),
            t_ns,
            changes,
            detail,
        })
    }
}

/// What a change was about, and how it differs from what is in force now.
fn words(change: &Change, before: &ModelsInForce, after: &ModelsInForce) -> String {
    match change {
        Change::Rig(_) => rig_words(&before.rig, &after.rig),
        Change::Object(model) => match after.objects.iter().any(|one| one.id() == model.id()) {
            true => format!("object {} is another one", model.id()),
            false => format!("object {} is gone", model.id()),
        },
        Change::Removal(id) => format!("object {id} is back"),
        Change::Camera(settings) => settings_words(settings),
    }
}

fn rig_words(before: &Rig, after: &Rig) -> String {
    let different = before.cameras().iter().filter_map(|camera| {
        let words = match after.camera(&camera.id) {
            None => "is gone".to_owned(),
            Some(other) if other == camera => return None,
            Some(other) => camera_words(camera, other),
        };
        Some(format!("camera {} {words}", camera.id))
    });
    let mut different: Vec<String> = different.collect();
    let n_more = different.len().saturating_sub(NAMED);
    different.truncate(NAMED);
    if n_more > 0 {
        different.push(format!("{n_more} more cameras"));
    }
    format!("in the rig {}", different.join(", "))
}

fn camera_words(before: &Camera, after: &Camera) -> String {
    match before.world_from_camera.zip(after.world_from_camera) {
        Some((before, after)) if before != after => {
            let step = se3::difference(&after, &before);
            let (shift_m, turn_rad) = (
                step.fixed_rows::<3>(0).norm(),
                step.fixed_rows::<3>(3).norm(),
            );
            let degrees = turn_rad.to_degrees();
            format!("is {:.1} mm and {degrees:.2} degrees away", shift_m * 1e3)
        }
        _ => "is another one".to_owned(),
    }
}

fn settings_words(settings: &CameraSettings) -> String {
    let values = [
        ("--exposure", settings.exposure_us),
        ("--gain", settings.gain),
        ("--rate", settings.rate_hz),
    ];
    let values = values
        .iter()
        .filter_map(|(name, value)| Some(format!(" {name} {}", (*value)?)));
    let camera = &settings.camera;
    format!("`config set camera {camera}{}`", values.collect::<String>())
}
