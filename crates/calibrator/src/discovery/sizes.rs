//! Sizes of the tags of a discovered object: given, or by comparison with a given one.

use super::DiscoveryPlan;
use super::rigidity::Joint;
use crate::verdict::listed;
use sextant_site_model::TagId;
use std::collections::BTreeMap;

/// Relative difference up to which a size equals the given one: before the adjustment, sizes are known to about a
/// hundredth.
const SAME: f64 = 0.04;
/// Assumed if no size is given, to have something to show, metres.
const PLACEHOLDER_M: f64 = 0.04;

/// The sizes of an object's tags.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sizes {
    tags: Vec<Size>,
    are_known: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Size {
    tag: TagId,
    size_m: f64,
    is_stated: bool,
}

impl Sizes {
    /// From the sizes in the plan and the ratios of the tags.
    pub(super) fn from_ratios(
        plan: &DiscoveryPlan,
        tags: &[TagId],
        joints: &[([TagId; 2], Joint)],
    ) -> Self {
        let relative = compared(tags, joints);
        let own = |tag: TagId| plan.sizes.iter().find(|(t, _)| *t == tag).map(|(_, s)| *s);
        let unit = unit(plan, &relative, own);
        let size = |&tag: &TagId| {
            let compared_m =
                relative.get(&tag).copied().unwrap_or(1.0) * unit.unwrap_or(PLACEHOLDER_M);
            let usual = plan.size_m.filter(|s| (compared_m / s - 1.0).abs() < SAME);
            let stated = own(tag).or(usual);
            Size {
                tag,
                size_m: stated.unwrap_or(compared_m),
                is_stated: stated.is_some(),
            }
        };
        Self {
            tags: tags.iter().map(size).collect(),
            are_known: unit.is_some(),
        }
    }

    pub(super) fn are_known(&self) -> bool {
        self.are_known
    }

    pub(super) fn contains(&self, tag: TagId) -> bool {
        self.tags.iter().any(|size| size.tag == tag)
    }

    /// The tags for a [`crate::LearnPlan`].
    pub(super) fn tags(&self) -> Vec<(TagId, f64)> {
        self.tags.iter().map(|s| (s.tag, s.size_m)).collect()
    }

    /// Whether both have the same tags with similar sizes.
    pub(super) fn are_nearly(&self, other: &Self) -> bool {
        let near =
            |(a, b): (&Size, &Size)| a.tag == b.tag && (a.size_m / b.size_m).ln().abs() < SAME;
        self.tags.len() == other.tags.len() && self.tags.iter().zip(&other.tags).all(near)
    }

    /// Corrects unknown sizes by the ratio of each estimated to its assumed size; returns the largest relative change.
    pub(super) fn correct(&mut self, ratios: &[f64]) -> f64 {
        let all = || self.tags.iter().zip(ratios);
        let stated = all().filter(|(size, _)| size.is_stated);
        let stated: Vec<f64> = stated.map(|(_, ratio)| *ratio).collect();
        let scale = stated.iter().sum::<f64>() / stated.len().max(1) as f64;
        let mut largest: f64 = 0.0;
        for (size, ratio) in self.tags.iter_mut().zip(ratios) {
            let change = ratio / scale;
            if !size.is_stated && change.is_finite() && change > 0.0 {
                size.size_m *= change;
                largest = largest.max((change - 1.0).abs());
            }
        }
        largest
    }

    /// The estimated sizes, metres.
    pub(super) fn solved(&self) -> Vec<(String, f64)> {
        let solved = self.tags.iter().filter(|size| !size.is_stated);
        solved.map(|s| (s.tag.to_string(), s.size_m)).collect()
    }

    /// The ratios of the sizes in words, if no size is known.
    pub(super) fn in_words(&self) -> String {
        let Some(first) = self.tags.first() else {
            return String::new();
        };
        let part = |size: &Size| size.size_m / first.size_m;
        let others: Vec<&Size> = self.tags[1..]
            .iter()
            .filter(|size| (part(size) - 1.0).abs() >= SAME)
            .collect();
        let names = listed(self.tags.iter().map(|size| size.tag));
        if others.is_empty() {
            return format!("{names} move as one and are equally large");
        }
        let words = others.iter().map(|size| {
            format!(
                "{} is {:.2} times as large as {}",
                size.tag,
                part(size),
                first.tag
            )
        });
        format!("{names} move as one; {}", listed(words))
    }
}

/// The relative size of 1 in metres, if a given size determines it.
fn unit(
    plan: &DiscoveryPlan,
    relative: &BTreeMap<TagId, f64>,
    own: impl Fn(TagId) -> Option<f64>,
) -> Option<f64> {
    let stated = relative
        .iter()
        .filter_map(|(tag, part)| Some(own(*tag)? / part));
    let mut stated: Vec<f64> = stated.collect();
    stated.sort_by(f64::total_cmp);
    if let Some(middle) = stated.get(stated.len() / 2) {
        return Some(*middle);
    }
    // The given size is that of most tags.
    let usual = plan.size_m?;
    let alike = |part: &f64| {
        let near = relative
            .values()
            .filter(|other| (*other / part).ln().abs() < SAME);
        near.count()
    };
    let common = relative.values().max_by_key(|part| alike(part))?;
    let near = relative
        .values()
        .filter(|other| (*other / common).ln().abs() < SAME);
    let mut near: Vec<f64> = near.copied().collect();
    near.sort_by(f64::total_cmp);
    Some(usual / near[near.len() / 2])
}

/// Size of every tag relative to the first, along the joints with the most views.
fn compared(tags: &[TagId], joints: &[([TagId; 2], Joint)]) -> BTreeMap<TagId, f64> {
    let mut sorted: Vec<&([TagId; 2], Joint)> = joints.iter().collect();
    sorted.sort_by_key(|(_, joint)| std::cmp::Reverse(joint.views));
    let mut known: BTreeMap<TagId, f64> = tags.first().map(|tag| (*tag, 1.0)).into_iter().collect();
    while let Some((tag, part)) =
        sorted
            .iter()
            .find_map(|([a, b], joint)| match (known.get(a), known.get(b)) {
                (Some(part), None) => Some((*b, part * joint.ratio)),
                (None, Some(part)) => Some((*a, part / joint.ratio)),
                _ => None,
            })
    {
        known.insert(tag, part);
    }
    known
}
