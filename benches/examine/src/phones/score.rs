//! Poses of a recording against the truth of the films.
//!
//! Time of a film: ns from its first image. A learned object has a frame of its own; tags are what it shares with the
//! true one, so that the motion between both frames is the one that fits the poses of its tags best.

use super::film_clock;
use anyhow::{Context, ensure};
use sextant_evaluation::{Alignment, PosePairs, compare, reference};
use sextant_geometry::Pose;
use sextant_proto::State;
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_recordings::tum_line;
use sextant_simulator::{Scenario, SceneObject};
use sextant_site_files::{read_object, read_toml};
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Step of the search for the time when films began, ns: objects move by some millimetres meanwhile.
const STEP_NS: u64 = 20_000_000;
/// Poses with which it searches.
const MOST_POSES: usize = 400;
/// Times of the truth that is written are so far apart, ns: a millionth of a metre off between them.
const TRUTH_STEP_NS: u64 = 2_000_000;
/// An object counts as covered in a slot of this length with a tracked pose, ns.
const SLOT_NS: u64 = 33_333_333;
const NO_COVARIANCE: [f64; 36] = [0.0; 36];

/// An object as it was learned, with the true one.
struct Learned<'a> {
    id: ObjectId,
    truth: &'a SceneObject,
    true_from_learned: Pose,
}

/// Prints when the films of a recording began.
///
/// # Errors
/// Files that cannot be read.
pub fn clocks(folder: &Path, recording: &Path) -> anyhow::Result<()> {
    let scenario: Scenario = read_toml(&folder.join("scenario.toml"))?;
    film_clock::print(&scenario, &SiteRecording::read(recording)?.observations);
    Ok(())
}

/// Writes the truth and prints the errors of each object.
///
/// # Errors
/// Files that cannot be read or written, and a recording without tracked poses of these objects.
pub fn score(folder: &Path, site: &Path, recording: &Path) -> anyhow::Result<()> {
    let scenario: Scenario = read_toml(&folder.join("scenario.toml"))?;
    let objects = learned(site, &scenario)?;
    let recording = SiteRecording::read(recording)?;
    let poses = recording.poses.iter();
    let tracked = poses.filter(|pose| pose.state == State::Tracking);
    let mut poses: Vec<ObjectEstimate> = tracked.map(ObjectEstimate::from).collect();
    poses.retain(|pose| objects.iter().any(|object| object.id == pose.object));
    poses.sort_by_key(|pose| pose.capture_ns);
    let (Some(first), Some(last)) = (poses.first(), poses.last()) else {
        anyhow::bail!("no tracked pose of an object of {}", site.display());
    };
    let span_ns = [first.capture_ns, last.capture_ns];
    let began_ns = film_began(&poses, &objects, film_clock::period_ns(&scenario));
    film_clock::print(&scenario, &recording.observations);
    let truths = write_truths(&folder.join("truth"), &objects, began_ns, span_ns)?;
    let ids: BTreeSet<ObjectId> = objects.iter().map(|object| object.id.clone()).collect();
    let references = reference::read(&truths, &ids)?;
    for found in compare(&poses, &references, Alignment::Rigid) {
        let own = poses.iter().filter(|pose| pose.object == found.object);
        let times = own.map(|pose| pose.capture_ns);
        println!(
            "{}: {} poses, {:.2} mm rms, {:.2} median, {:.2} 95 %, {:.1} most; {:.3} deg rms, \
             {:.3} median, {:.3} 95 %; NEES {:.1}, inside 95 % {:.3}, covered {:.3}",
            found.object,
            found.compared,
            found.position_mm.rms,
            found.position_mm.median,
            found.position_mm.p95,
            found.position_mm.max,
            found.attitude_deg.rms,
            found.attitude_deg.median,
            found.attitude_deg.p95,
            found.nees,
            found.within_95,
            coverage(times, span_ns),
        );
    }
    Ok(())
}

/// The objects of a site's folder that share tags with true ones.
fn learned<'a>(site: &Path, scenario: &'a Scenario) -> anyhow::Result<Vec<Learned<'a>>> {
    let files = fs::read_dir(site).with_context(|| site.display().to_string())?;
    let mut files: Vec<PathBuf> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    files.sort();
    let is_object = |file: &&PathBuf| {
        let name = file.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with("object-") && name.ends_with(".toml"))
    };
    let mut found = Vec::new();
    for file in files.iter().filter(is_object) {
        let model = read_object(file)?;
        let truths = scenario.objects.iter();
        found.extend(truths.filter_map(|truth| Learned::compare(&model, truth)));
    }
    ensure!(!found.is_empty(), "{}: no object", site.display());
    Ok(found)
}

impl<'a> Learned<'a> {
    fn compare(model: &ObjectModel, truth: &'a SceneObject) -> Option<Self> {
        let mut tags = PosePairs::default();
        for own in model.tags() {
            let mut all = truth.tags.iter();
            let true_tag = all.find(|tag| (tag.family, tag.id) == (own.tag.family, own.tag.id));
            if let (Some(pose), Some(true_tag)) = (own.object_from_tag, true_tag) {
                tags.add(0, &pose, &NO_COVARIANCE, &true_tag.object_from_tag);
            }
        }
        let learned_from_true = PosePairs::alignment([&tags].into_iter())?;
        let errors = tags.errors(&learned_from_true)?;
        println!(
            "{}: tags of {} off by {:.2} mm and {:.3} deg rms",
            model.id(),
            truth.id,
            errors.position_m * 1e3,
            errors.attitude_rad.to_degrees()
        );
        Some(Self {
            id: model.id().clone(),
            truth,
            true_from_learned: learned_from_true.inverse(),
        })
    }

    fn world_from_learned(&self, film_ns: u64) -> Pose {
        self.truth.world_from_object(film_ns) * self.true_from_learned
    }
}

/// When the films began, ns since the Unix epoch, at most a period before the first pose.
fn film_began(poses: &[ObjectEstimate], objects: &[Learned], period_ns: u64) -> u64 {
    let some: Vec<&ObjectEstimate> = poses
        .iter()
        .step_by(poses.len().div_ceil(MOST_POSES))
        .collect();
    let first_ns = some[0].capture_ns;
    let cost = |began_ns: &u64| residual_m(&some, objects, *began_ns);
    let least = |from_ns: u64, to_ns: u64, step_ns: u64| {
        let times = (from_ns..=to_ns).step_by(step_ns as usize);
        let costs = times.map(|began_ns| (cost(&began_ns), began_ns));
        costs
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(from_ns, |(_, began_ns)| began_ns)
    };
    let mut step_ns = STEP_NS;
    let mut began_ns = least(first_ns - period_ns, first_ns, step_ns);
    while step_ns > 10_000 {
        let next_ns = step_ns / 10;
        began_ns = least(began_ns - step_ns, began_ns + step_ns, next_ns);
        step_ns = next_ns;
    }
    began_ns
}

/// Root mean square of positions after the best motion between the worlds, m.
fn residual_m(poses: &[&ObjectEstimate], objects: &[Learned], began_ns: u64) -> f64 {
    let mut pairs = PosePairs::default();
    for pose in poses {
        let object = objects.iter().find(|object| object.id == pose.object);
        if let Some(object) = object {
            let film_ns = pose.capture_ns.saturating_sub(began_ns);
            let truth = object.world_from_learned(film_ns);
            pairs.add(0, &pose.world_from_object, &NO_COVARIANCE, &truth);
        }
    }
    let errors =
        PosePairs::alignment([&pairs].into_iter()).and_then(|motion| pairs.errors(&motion));
    errors.map_or(f64::INFINITY, |errors| errors.position_m)
}

/// Writes the true poses of each object in the recording's time.
fn write_truths(
    folder: &Path,
    objects: &[Learned],
    began_ns: u64,
    [first_ns, last_ns]: [u64; 2],
) -> anyhow::Result<Vec<PathBuf>> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let write = |object: &Learned| {
        let times = (first_ns..last_ns + TRUTH_STEP_NS).step_by(TRUTH_STEP_NS as usize);
        let lines = times.map(|t_ns| {
            let truth = object.world_from_learned(t_ns.saturating_sub(began_ns));
            tum_line(t_ns, &truth) + "\n"
        });
        let file = folder.join(format!("{}.tum", object.id));
        fs::write(&file, lines.collect::<String>()).with_context(|| file.display().to_string())?;
        Ok(file)
    };
    objects.iter().map(write).collect()
}

/// Share of the slots between two times that have one of these.
fn coverage(times: impl Iterator<Item = u64>, [first_ns, last_ns]: [u64; 2]) -> f64 {
    let slots: BTreeSet<u64> = times.map(|t_ns| (t_ns - first_ns) / SLOT_NS).collect();
    slots.len() as f64 / ((last_ns - first_ns) / SLOT_NS + 1) as f64
}

#[cfg(test)]
mod tests {
    use super::super::scene::{Wanted, scenario};
    use super::*;
    use nalgebra::Vector3;
    use sextant_site_model::{ObjectTag, TagId};

    #[test]
    fn the_beginning_of_films_is_found_in_another_world() {
        let wanted = Wanted {
            seed: 3,
            resolution: [640, 480],
            seconds: 60,
        };
        let scenario = scenario(&wanted);
        let frame = Pose::new(Vector3::new(0.02, 0.01, 0.0), Vector3::new(0.0, 0.3, 0.0));
        let model = |truth: &SceneObject| {
            let tags = truth.tags.iter().map(|tag| {
                let (family, id) = (tag.family, tag.id);
                let place = frame * tag.object_from_tag;
                ObjectTag::new(TagId { family, id }, tag.size, Some(place))
            });
            let id = ObjectId::new(&format!("object-{}", truth.tags[0].id)).unwrap();
            ObjectModel::new(id, tags.collect()).unwrap()
        };
        let truths = scenario.objects.iter();
        let objects = truths.map(|truth| Learned::compare(&model(truth), truth).unwrap());
        let objects: Vec<Learned> = objects.collect();
        let began_ns = 1_000_000_012_345_678;
        let world = Pose::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.5, 0.1, -2.0));
        let poses = (0..600).map(|n| {
            let film_ns = 20_000_000_000 + n * 33_333_333;
            let object = &objects[n as usize % 2];
            ObjectEstimate {
                object: object.id.clone(),
                capture_ns: began_ns + film_ns,
                world_from_object: world * object.world_from_learned(film_ns),
                covariance: Default::default(),
                twist: Default::default(),
                state: State::Tracking,
                cameras: 2,
                tags: 4,
                rms_px: 0.0,
                articulated: None,
            }
        });
        let poses: Vec<_> = poses.collect();
        let found_ns = film_began(&poses, &objects, 60_000_000_000);
        assert!(found_ns.abs_diff(began_ns) < 20_000, "{found_ns}");
    }
}
