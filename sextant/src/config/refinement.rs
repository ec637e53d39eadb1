//! Putting in force the refined calibration that a fusion node proposes, and taking the last change of the site back.

use crate::config::change::{change, request};
use crate::config::get::nobody;
use crate::config::order::in_order;
use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use anyhow::{Context, anyhow, bail};
use serde_json::{Value, json};
use sextant_gateways::site::SiteSession;
use sextant_geometry::{Pose, se3};
use sextant_process::{Exit, Failure, exit_of};
use sextant_proto::{NodeId, ObjectConfig, Proposal, RigConfig};
use sextant_site_model::{Camera, ObjectId, ObjectModel, ObjectTag, Rig};
use std::collections::BTreeMap;

/// Whether a change is made, or only shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// It is shown and made.
    Real,
    /// It is shown.
    Dry,
}

impl Run {
    /// From `--dry-run`.
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
            "no refined calibration is proposed: the images so far are explained as well by what is in force (or `refinement` in fusion.toml is not \"propose\")"
        );
        Failure::new(Exit::Fault, cause)
    })?;
    let models = Models::of(&proposal)?;
    let mut summary = models.summary(&site)?;
    summary.node = Some(proposal.node.clone());
    summary.held_back = Some(proposal);
    print_line(&summary.line(format))?;
    models.set(&site, run, format)
}

/// Takes a change back: what was in force before it is set again.
///
/// # Errors
/// Nothing to revert, no answer, a refusal.
pub fn revert(
    what: &RevertTarget,
    run: Run,
    site: &SiteArguments,
    format: Format,
) -> anyhow::Result<()> {
    let site = site.open()?;
    let models = match what {
        RevertTarget::Last => {
            let last = first(&site, &site.keys.all_formers())?;
            last.as_ref().map(Models::of).transpose()?
        }
        RevertTarget::Rig => {
            let former: Vec<RigConfig> = site.latest(&site.keys.all_former_rigs())?;
            former.into_iter().next().map(Models::rig)
        }
        RevertTarget::Object(id) => {
            let former: Vec<ObjectConfig> = site.latest(&site.keys.all_former_objects(id))?;
            former.into_iter().next().map(Models::object)
        }
    };
    let Some(models) = models else {
        if site
            .latest::<Proposal>(&site.keys.all_formers())?
            .is_empty()
        {
            bail!(Failure::new(Exit::Unavailable, nobody(&site)))
        }
        let of = match what {
            RevertTarget::Last => String::new(),
            RevertTarget::Rig => " of the rig".to_owned(),
            RevertTarget::Object(id) => format!(" of object {id}"),
        };
        let cause = anyhow!(
            "no change{of} is known that could be taken back (without `keep_changes` a fusion node knows those since its start)"
        );
        bail!(Failure::new(Exit::Fault, cause))
    };
    print_line(&models.summary(&site)?.line(format))?;
    models.set(&site, run, format)
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
#[derive(Default)]
struct Models {
    rig: Option<RigConfig>,
    objects: Vec<ObjectConfig>,
}

impl Models {
    fn rig(rig: RigConfig) -> Self {
        let (rig, objects) = (Some(rig), Vec::new());
        Self { rig, objects }
    }

    fn object(object: ObjectConfig) -> Self {
        let (rig, objects) = (None, vec![object]);
        Self { rig, objects }
    }

    fn of(proposal: &Proposal) -> anyhow::Result<Self> {
        let models = proposal.rig_config().and_then(|rig| {
            let objects = proposal.object_configs()?;
            Ok(Self { rig, objects })
        });
        let node = &proposal.node;
        models.with_context(|| format!("fusion node {node} published something unreadable"))
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

    /// Sets everything, or sets back what was set before a refusal or a missing answer. The error says what is in force then.
    fn set(&self, site: &SiteSession, run: Run, format: Format) -> anyhow::Result<()> {
        if run == Run::Dry {
            return Ok(());
        }
        let former = Self::in_force(site)?;
        let mut tried = Self::default();
        let set = self.set_each(site, &former.by_id(), &mut tried, format);
        let Err(refusal) = set else { return Ok(()) };
        let set_back = former.restore(site, &tried, format);
        let exit = match exit_of(&refusal) {
            Exit::Fault if set_back.is_err() => Exit::Unavailable,
            exit => exit,
        };
        let state = match set_back {
            Ok(()) => "not applied: the site is as it was before".to_owned(),
            Err(cause) => format!(
                "not applied as a whole, and not all of it could be set back ({cause:#}): {}",
                self.end_state(site, &former)
            ),
        };
        Err(Failure::new(exit, refusal.context(state)).into())
    }

    /// What the nodes that answer have in force, of all that was to be set.
    fn end_state(&self, site: &SiteSession, former: &Self) -> String {
        const REMEDY: &str =
            "see `sextant config get rig` and `get object`; `sextant config revert` takes it back";
        let now = match Self::in_force(site) {
            Ok(now) if now.rig.is_some() => now,
            _ => {
                return format!(
                    "what is in force is unknown while no fusion node answers; {REMEDY}"
                );
            }
        };
        let state = |is_set: bool, is_former: bool| match (is_set, is_former) {
            (_, true) => "as before",
            (true, false) => "changed",
            (false, false) => "neither as before nor as wanted",
        };
        let rig = self.rig.iter().map(|rig| {
            let (is_set, is_former) = (now.rig.as_ref() == Some(rig), now.rig == former.rig);
            format!("the rig is {}", state(is_set, is_former))
        });
        let (now, former) = (now.by_id(), former.by_id());
        let objects = self.objects.iter().map(|object| {
            let there = now.get(&object.id);
            let is_set = there.map_or(object.is_removal(), |there| there == object);
            let is_former = there == former.get(&object.id);
            format!("object {} is {}", object.id, state(is_set, is_former))
        });
        let states: Vec<String> = rig.chain(objects).collect();
        format!("{}; {REMEDY}", states.join(", "))
    }

    fn by_id(&self) -> BTreeMap<ObjectId, ObjectConfig> {
        let objects = self.objects.iter();
        objects
            .map(|object| (object.id.clone(), object.clone()))
            .collect()
    }

    /// The rig and the objects of the site.
    fn in_force(site: &SiteSession) -> anyhow::Result<Self> {
        let rigs: Vec<RigConfig> = site.latest(&site.keys.config_rig())?;
        let objects: Vec<ObjectConfig> = site.latest(&site.keys.all_config_objects())?;
        Ok(Self {
            rig: rigs.into_iter().next(),
            objects: objects
                .into_iter()
                .filter(|object| !object.is_removal())
                .collect(),
        })
    }

    /// Sets all, up to the first that is refused or not answered; that one is the last of those `tried`.
    fn set_each(
        &self,
        site: &SiteSession,
        in_force: &BTreeMap<ObjectId, ObjectConfig>,
        tried: &mut Self,
        format: Format,
    ) -> anyhow::Result<()> {
        if let Some(rig) = &self.rig {
            tried.rig = Some(rig.clone());
            change(site, &site.keys.config_rig(), rig, format)?;
        }
        for object in in_order(in_force, &self.objects) {
            tried.objects.retain(|other| other.id != object.id);
            tried.objects.push(object.clone());
            change(site, &site.keys.config_object(&object.id), &object, format)?;
        }
        Ok(())
    }

    /// Sets back what was tried. A change that no node answered may yet be taken, and what sets it back is taken after it: where an answer is
    /// missing again, the rest is sent all the same.
    fn restore(&self, site: &SiteSession, tried: &Self, format: Format) -> anyhow::Result<()> {
        let in_force = self.by_id();
        let mut now = in_force.clone();
        let mut wanted = Vec::new();
        for object in &tried.objects {
            let removal = || ObjectConfig::removal(object.id.clone());
            wanted.push(in_force.get(&object.id).cloned().unwrap_or_else(removal));
            match object.is_removal() {
                true => drop(now.remove(&object.id)),
                false => drop(now.insert(object.id.clone(), object.clone())),
            }
        }
        let mut set_back = Ok(());
        if let Some(rig) = tried.rig.as_ref().and(self.rig.as_ref()) {
            set_back = change(site, &site.keys.config_rig(), rig, format);
        }
        for object in in_order(&now, &wanted) {
            let key = site.keys.config_object(&object.id);
            match &set_back {
                Ok(()) => set_back = change(site, &key, &object, format),
                Err(_) => request(site, &key, &object)?,
            }
        }
        set_back
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
