//! Putting in force the refined calibration that a fusion node proposes, and taking the last change of the site back.

use crate::config::change::change;
use crate::config::get::nobody;
use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use anyhow::{Context, anyhow, bail};
use serde_json::{Value, json};
use sextant_gateways::site::SiteSession;
use sextant_geometry::{Pose, se3};
use sextant_process::{Exit, Failure};
use sextant_proto::{FusionStatus, ModelPayload, NodeId, ObjectConfig, Proposal, RigConfig};
use sextant_site_model::{Camera, ObjectId, ObjectModel, ObjectTag, Rig};

/// Whether a change is made, or only shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// It is shown and made.
    Real,
    /// It is shown.
    Dry,
}

impl Run {
    /// Dry if `--dry-run` is given.
    pub fn dry(dry_run: bool) -> Self {
        if dry_run { Self::Dry } else { Self::Real }
    }
}

/// What is to be taken back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RevertTarget {
    /// Whatever changed last.
    Last,
    /// The last change of the rig.
    Rig,
    /// The last change of an object.
    Object(ObjectId),
}

/// Applies the proposal of a node, of the first that has one where none is named.
///
/// # Errors
/// No proposal, no answer, a refusal.
pub fn apply(
    node: Option<&NodeId>,
    run: Run,
    site: &SiteArguments,
    format: Format,
) -> anyhow::Result<()> {
    let site = site.open()?;
    let key = node.map_or_else(
        || site.keys.all_proposals(),
        |node| site.keys.proposal(node),
    );
    let proposal = first(&site, &key)?.ok_or_else(|| {
        let cause = anyhow!(
            "no refined calibration is proposed: the images so far are explained as well by what \
             is in force (or `refinement` in fusion.toml is not \"propose\")"
        );
        Failure::new(Exit::Fault, cause)
    })?;
    let models = RefinedModels::decode(proposal.clone())?;
    let mut summary = models.summary(&site)?;
    summary.node = Some(proposal.node.clone());
    summary.held_back = Some(proposal);
    print_line(&summary.line(format))?;
    let named = RefinedModels {
        proposal: number_of(&models.proposal),
        ..models
    };
    named.set(&site, run, format)
}

/// The request to apply a proposal: it names it, and the node applies what it has.
fn number_of(proposal: &Proposal) -> Proposal {
    Proposal::none(proposal.node.clone(), proposal.t_ns)
}

/// Takes a change back: what was in force before it is set again. With `of`, what this node had before its last change,
/// else the one that publishes.
///
/// # Errors
/// Nothing to revert, no answer, a refusal.
pub fn revert(
    what: &RevertTarget,
    of: Option<&NodeId>,
    run: Run,
    site: &SiteArguments,
    format: Format,
) -> anyhow::Result<()> {
    let site = site.open()?;
    let node = of.cloned().map_or_else(|| publisher(&site), Ok)?;
    let models = match what {
        RevertTarget::Last => {
            let last = first(&site, &site.keys.former(&node))?;
            last.map(RefinedModels::decode).transpose()?
        }
        RevertTarget::Rig => {
            let former: Vec<RigConfig> = site.latest(&site.keys.former_rig(&node))?;
            let former = former.into_iter().next();
            former
                .map(|rig| RefinedModels::new(node.clone(), Some(rig), None))
                .transpose()?
        }
        RevertTarget::Object(id) => {
            let key = site.keys.former_object(&node, id);
            let former: Vec<ObjectConfig> = site.latest(&key)?;
            let former = former.into_iter().next();
            former
                .map(|object| RefinedModels::new(node.clone(), None, Some(object)))
                .transpose()?
        }
    };
    let Some(models) = models else {
        let of = match what {
            RevertTarget::Last => String::new(),
            RevertTarget::Rig => " of the rig".to_owned(),
            RevertTarget::Object(id) => format!(" of object {id}"),
        };
        let cause = anyhow!(
            "no change{of} is known that could be taken back (without `keep_changes` a fusion \
             node knows those since its start)"
        );
        bail!(Failure::new(Exit::Fault, cause))
    };
    print_line(&models.summary(&site)?.line(format))?;
    models.set(&site, run, format)
}

/// The fusion node that publishes the poses, and knows what was in force before; any other one where none does at the
/// moment.
fn publisher(site: &SiteSession) -> anyhow::Result<NodeId> {
    let statuses: Vec<FusionStatus> = site.latest(&site.keys.all_fusion_statuses())?;
    let newest = statuses.into_iter().max_by_key(|status| status.epoch);
    let Some(newest) = newest else {
        bail!(Failure::new(Exit::Unavailable, nobody(site)))
    };
    Ok(newest.node)
}

/// The first proposal of anything.
fn first(site: &SiteSession, key: &str) -> anyhow::Result<Option<Proposal>> {
    let all: Vec<Proposal> = site.latest(key)?;
    if all.is_empty() {
        bail!(Failure::new(Exit::Unavailable, nobody(site)))
    }
    Ok(all.into_iter().find(|proposal| !proposal.is_empty()))
}

/// What is to be set.
struct RefinedModels {
    rig: Option<RigConfig>,
    objects: Vec<ObjectConfig>,
    /// The message that asks for them.
    proposal: Proposal,
}

impl RefinedModels {
    fn new(
        node: NodeId,
        rig: Option<RigConfig>,
        object: Option<ObjectConfig>,
    ) -> anyhow::Result<Self> {
        let payload = object.as_ref().map(ModelPayload::encode).transpose()?;
        let proposal = Proposal {
            rig: rig.as_ref().map(ModelPayload::encode).transpose()?,
            objects: payload.into_iter().collect(),
            ..Proposal::none(node, 0)
        };
        let objects = object.into_iter().collect();
        Ok(Self {
            rig,
            objects,
            proposal,
        })
    }

    fn decode(proposal: Proposal) -> anyhow::Result<Self> {
        let node = &proposal.node;
        let unreadable = || format!("fusion node {node} published something unreadable");
        Ok(Self {
            rig: proposal.rig_config().with_context(unreadable)?,
            objects: proposal.object_configs().with_context(unreadable)?,
            proposal,
        })
    }

    /// Differences from the models in force.
    fn summary(&self, site: &SiteSession) -> anyhow::Result<RefinementSummary> {
        let mut summary = RefinementSummary::default();
        let in_force: Vec<RigConfig> = site.latest(&site.keys.config_rig())?;
        if let Some((after, before)) = self.rig.as_ref().zip(in_force.first()) {
            summary.compare_rigs(&Rig::try_from(before)?, &Rig::try_from(after)?);
        }
        for after in &self.objects {
            let key = site.keys.config_object(&after.id);
            let in_force: Vec<ObjectConfig> = site.latest(&key)?;
            let after = ObjectModel::try_from(after)?;
            match in_force.first() {
                Some(before) => summary.compare_objects(&ObjectModel::try_from(before)?, &after),
                None => summary.added.push(after.id().clone()),
            }
        }
        Ok(summary)
    }

    /// Puts all of it in force, or nothing.
    fn set(&self, site: &SiteSession, run: Run, format: Format) -> anyhow::Result<()> {
        if run == Run::Dry {
            return Ok(());
        }
        let key = site.keys.config_models();
        change(site, &key, &self.proposal, format)
    }
}

/// What changes, and by how much.
#[derive(Default)]
struct RefinementSummary {
    node: Option<NodeId>,
    held_back: Option<Proposal>,
    moves: Vec<Move>,
    added: Vec<ObjectId>,
}

/// One camera or tag.
struct Move {
    what: String,
    /// m and rad; none where there is no pose before or after.
    by: Option<(f64, f64)>,
    /// What else, by its name, after over before.
    ratio: (&'static str, f64),
}

/// Ratios nearer to one than this are not shown.
const SHOWN_RATIO: f64 = 5e-5;

impl RefinementSummary {
    fn compare_rigs(&mut self, before: &Rig, after: &Rig) {
        for camera in after.cameras() {
            let model = |one: &Camera| (one.resolution, one.lens, one.world_from_camera);
            let known = before.camera(&camera.id);
            let Some(known) = known.filter(|known| model(known) != model(camera)) else {
                continue;
            };
            let focal = |camera: &Camera| camera.lens.intrinsics().fx;
            self.moves.push(Move {
                what: format!("camera {}", camera.id),
                by: displacement(known.world_from_camera, camera.world_from_camera),
                ratio: ("focal length", focal(camera) / focal(known)),
            });
        }
    }

    fn compare_objects(&mut self, before: &ObjectModel, after: &ObjectModel) {
        for tag in after.tags() {
            let place = |one: &ObjectTag| (one.size_m, one.object_from_tag);
            let mut known = before.tags().iter();
            let Some(known) =
                known.find(|known| known.tag == tag.tag && place(known) != place(tag))
            else {
                continue;
            };
            self.moves.push(Move {
                what: format!("tag {} of object {}", tag.tag, after.id()),
                by: displacement(known.object_from_tag, tag.object_from_tag),
                ratio: ("size", tag.size_m / known.size_m),
            });
        }
    }

    fn line(&self, format: Format) -> String {
        match format {
            Format::Json => self.json().to_string(),
            Format::Text => self.text(),
        }
    }

    fn json(&self) -> Value {
        let moves = self.moves.iter().map(|one| {
            let (name, ratio) = one.ratio;
            let by = one.by.map(|(position_m, orientation_rad)| {
                json!({"position_m": position_m, "orientation_rad": orientation_rad})
            });
            json!({"what": one.what, "by": by, "ratio": {"of": name, "value": ratio}})
        });
        let held_back = self.held_back.as_ref().map(|proposal| {
            json!({
                "n_images": proposal.n_images, "before_px": proposal.before_px, "after_px": proposal.after_px,
            })
        });
        json!({
            "node": self.node, "held_back": held_back, "changes": moves.collect::<Vec<_>>(), "added": self.added,
        })
    }

    fn text(&self) -> String {
        let mut lines: Vec<String> = self.moves.iter().map(Move::text).collect();
        lines.extend(
            self.added
                .iter()
                .map(|id| format!("object {id} comes back")),
        );
        if lines.is_empty() {
            lines.push("cameras and tags stay where they are".to_owned());
        }
        if let Some(proposal) = &self.held_back {
            let images = words::count(proposal.n_images as usize, "held-back image");
            lines.push(format!(
                "{images}: {:.3} px before, {:.3} px after (fusion node {})",
                proposal.before_px, proposal.after_px, proposal.node
            ));
        }
        lines.join("\n")
    }
}

impl Move {
    fn text(&self) -> String {
        let mut text = match self.by {
            Some((position_m, orientation_rad)) => format!(
                "{}: {:.2} mm, {:.3} degrees",
                self.what,
                position_m * 1e3,
                orientation_rad.to_degrees()
            ),
            None => format!("{}: no pose before or after", self.what),
        };
        let (name, ratio) = self.ratio;
        if (ratio - 1.0).abs() > SHOWN_RATIO {
            text.push_str(&format!(", {name} {:+.2} %", (ratio - 1.0) * 100.0));
        }
        text
    }
}

fn displacement(before: Option<Pose>, after: Option<Pose>) -> Option<(f64, f64)> {
    let step = se3::difference(&after?, &before?);
    Some((
        step.fixed_rows::<3>(0).norm(),
        step.fixed_rows::<3>(3).norm(),
    ))
}
