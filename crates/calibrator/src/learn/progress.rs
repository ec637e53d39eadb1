//! Progress of a learning session, and instructions.

use crate::graph::islands;
use crate::image_store::{ImageView, TagSpec};
use crate::session_images::SessionImages;
use crate::verdict::listed;
use nalgebra::Vector3;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A tag's share of the images so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TagProgress {
    /// Family and number, as text.
    pub tag: String,
    /// Images that show it.
    pub images: usize,
    /// Number of the eight directions around its normal from which it was seen; frontal views do not count.
    pub directions: usize,
    /// Index of the group of connected tags.
    pub group: usize,
}

/// Progress of a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearnProgress {
    /// Number of images received.
    pub images: usize,
    /// Images with at least two tags: only these connect tags.
    pub joining: usize,
    /// Every wanted tag.
    pub tags: Vec<TagProgress>,
    /// Progress from 0 to 1; 1 is enough.
    pub complete: f64,
    /// Instruction for the next step, a sentence.
    pub hint: String,
}

impl LearnProgress {
    /// Progress before any tag is known.
    pub(crate) fn nothing_yet() -> Self {
        Self {
            images: 0,
            joining: 0,
            tags: Vec::new(),
            complete: 0.0,
            hint: String::new(),
        }
    }
}

/// Coverage by the images.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    images: usize,
    joining: usize,
    seen: Vec<usize>,
    directions: Vec<[bool; DIRECTIONS]>,
    together: BTreeMap<[usize; 2], usize>,
    /// Few images of each pair of tags, spread over all.
    sample: Vec<ImageView>,
}

const DIRECTIONS: usize = 8;
/// Least angle between normal and line of sight that reveals the tilt of a tag, radians.
const FACE_ON: f64 = 0.2;
/// Sufficient numbers of images of a tag, of directions, and of images of a pair.
const ENOUGH_IMAGES: usize = 12;
const ENOUGH_DIRECTIONS: usize = 3;
const ENOUGH_TOGETHER: usize = 3;

impl Coverage {
    pub(super) fn new(wanted: &[TagSpec]) -> Self {
        Self {
            images: 0,
            joining: 0,
            seen: vec![0; wanted.len()],
            directions: vec![[false; DIRECTIONS]; wanted.len()],
            together: BTreeMap::new(),
            sample: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, view: ImageView) {
        self.images += 1;
        self.joining += usize::from(view.tags.len() > 1);
        if self.add_view(&view) {
            self.sample.push(view);
        }
    }

    /// Whether it shows a pair of tags for the first, second, fourth, eighth ... time.
    fn add_view(&mut self, view: &ImageView) -> bool {
        let mut is_sampled = false;
        for (at, tag) in view.tags.iter().enumerate() {
            self.seen[tag.tag] += 1;
            // Direction of the camera in the tag's frame.
            let camera_in_tag = tag.branches[0].inverse().translation.vector;
            if let Some(direction) = direction(&camera_in_tag) {
                self.directions[tag.tag][direction] = true;
            }
            for other in &view.tags[at + 1..] {
                let pair = [tag.tag.min(other.tag), tag.tag.max(other.tag)];
                let count = self.together.entry(pair).or_default();
                *count += 1;
                is_sampled |= count.is_power_of_two();
            }
        }
        is_sampled
    }

    /// Few images of each pair of tags: about a dozen of thousands.
    pub(super) fn sample(&self) -> &[ImageView] {
        &self.sample
    }

    fn groups(&self, n: usize) -> Vec<usize> {
        let enough = self
            .together
            .iter()
            .filter(|(_, count)| **count >= ENOUGH_TOGETHER);
        islands(n, enough.map(|(&nodes, _)| nodes))
    }

    pub(super) fn progress(&self, images: &SessionImages) -> LearnProgress {
        let groups = self.groups(images.wanted.len());
        let tags = images.wanted.iter().enumerate().map(|(at, w)| TagProgress {
            tag: w.tag.to_string(),
            images: self.seen[at],
            directions: self.directions[at].iter().filter(|d| **d).count(),
            group: groups[at],
        });
        let tags: Vec<TagProgress> = tags.collect();
        LearnProgress {
            images: self.images,
            joining: self.joining,
            complete: complete(&tags),
            hint: self.hint(&tags, images),
            tags,
        }
    }

    fn hint(&self, tags: &[TagProgress], images: &SessionImages) -> String {
        if self.seen.iter().all(|n| *n == 0) {
            return match images.foreign().first() {
                Some(tag) => format!(
                    "Only {tag} is seen, which is not one of the object's tags: check the numbers"
                ),
                None => "Show the object to the camera".to_owned(),
            };
        }
        if let Some((tag, _)) = images
            .doubled()
            .iter()
            .find(|(_, n)| **n >= ENOUGH_TOGETHER)
        {
            return format!("Tag {tag} is there twice: replace one of the two by another number");
        }
        if let Some(hint) = joining_hint(tags) {
            return hint;
        }
        let few = tags.iter().filter(|t| t.images < ENOUGH_IMAGES);
        if let Some(tag) = few.min_by_key(|t| t.images) {
            return format!(
                "Turn {} to the camera and add it there a little longer",
                tag.tag
            );
        }
        let flat = tags.iter().filter(|t| t.directions < ENOUGH_DIRECTIONS);
        if let Some(tag) = flat.min_by_key(|t| t.directions) {
            return format!(
                "Tilt the object to and fro while {} is seen: it was seen from too few sides",
                tag.tag
            );
        }
        "Enough: every tag is joined and seen from several sides".to_owned()
    }
}

/// A rotation that would connect the groups; `None` if there is only one.
pub(super) fn joining_hint(tags: &[TagProgress]) -> Option<String> {
    let groups: BTreeSet<usize> = tags.iter().map(|t| t.group).collect();
    if groups.len() < 2 {
        return None;
    }
    let of_group = |group: usize| tags.iter().filter(move |t| t.group == group);
    let size = |group: &usize| of_group(*group).map(|t| t.images).sum::<usize>();
    let main = *groups
        .iter()
        .max_by_key(|g| (size(g), std::cmp::Reverse(**g)))?;
    let unseen: Vec<&str> = tags
        .iter()
        .filter(|t| t.images == 0)
        .map(|t| t.tag.as_str())
        .collect();
    if !unseen.is_empty() {
        let verb = if unseen.len() > 1 { "come" } else { "comes" };
        return Some(format!(
            "Turn the object until {} {verb} into view together with a tag seen before",
            listed(unseen)
        ));
    }
    let other = *groups
        .iter()
        .filter(|g| **g != main)
        .max_by_key(|g| size(g))?;
    let most = |group: usize| {
        of_group(group)
            .max_by_key(|t| t.images)
            .map(|t| t.tag.clone())
    };
    let (from, to) = (most(main)?, most(other)?);
    Some(format!(
        "Turn the object slowly from {from} towards {to}, so that tags of both sides are in one picture"
    ))
}

/// Mean over the tags of the achieved share of what is sufficient; connections count as much as images and directions.
fn complete(tags: &[TagProgress]) -> f64 {
    let groups: BTreeSet<usize> = tags.iter().map(|t| t.group).collect();
    let part = |have: usize, enough: usize| (have as f64 / enough as f64).min(1.0);
    let of_tag = |t: &TagProgress| {
        0.5 * (part(t.images, ENOUGH_IMAGES) + part(t.directions, ENOUGH_DIRECTIONS))
    };
    let mean = tags.iter().map(of_tag).sum::<f64>() / tags.len().max(1) as f64;
    let joined = 1.0 - (groups.len() - 1) as f64 / tags.len().max(2).saturating_sub(1) as f64;
    0.5 * (mean + joined.max(0.0))
}

/// Index of the eighth around a tag's normal in which a point lies; `None` almost on the normal.
fn direction(point_in_tag: &Vector3<f64>) -> Option<usize> {
    let aside = point_in_tag.xy().norm();
    if aside.atan2(point_in_tag.z) < FACE_ON {
        return None;
    }
    let turn = point_in_tag.y.atan2(point_in_tag.x) / std::f64::consts::TAU + 1.0;
    Some((turn * DIRECTIONS as f64).round() as usize % DIRECTIONS)
}
