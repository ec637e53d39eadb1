//! Start values of joints of which little is known, from the links that are seen.
//!
//! The search goes outwards from a link whose pose is accepted (the anchor). Where one joint lies between it and a link
//! that is seen, each branch of that link's largest view gives the joint's value; where two do, the first is tried over
//! its range; further ones keep their values. The views of the link decide. The fit refines these starts.

use nalgebra::Vector3;
use sextant_geometry::Pose;

use crate::filter::state::ObjectState;
use crate::kinematics::chain::KinematicChain;
use crate::kinematics::configuration::{Configuration, Rates, Values};
use crate::measurement::corners::WeightedView;
use crate::measurement::planar_poses::{branches, largest};
use sextant_site_model::{Joint, JointKind, MOST_JOINTS};

/// Values of a joint that are tried.
const TRIALS: usize = 16;
/// rad or m (one sigma) from which on the prediction of a joint may lead to a wrong minimum.
const VAGUE: f64 = 0.15;
/// m to either side within which a slide without limits is looked for.
const REACH: f64 = 1.0;

/// Configuration by one branch of a view: its link at that pose, the joints by the other links.
pub(crate) fn by_branch(
    weighted: &WeightedView<'_>,
    world_from_link: &Pose,
    views: &[WeightedView<'_>],
) -> Configuration {
    let Some(chain_link) = &weighted.view.chain_link else {
        return Configuration::rigid(world_from_link);
    };
    let search = Search {
        chain: &chain_link.chain,
        views,
        anchor: chain_link.link,
        world_from_anchor: *world_from_link,
        values: middle(&chain_link.chain),
        known: [false; MOST_JOINTS],
    };
    let found = search.finished();
    let base = chain_link.chain.articulation.base();
    let mut chain_links = views
        .iter()
        .filter_map(|weighted| weighted.view.chain_link.as_ref());
    if chain_links.any(|chain_link| chain_link.link == base) {
        chain_link.chain.rooted(&found, base)
    } else {
        found
    }
}

/// Where the joints that are only vaguely known would be by the views; `None` where all are known well.
pub(crate) fn start(prior: &ObjectState, views: &[WeightedView<'_>]) -> Option<Configuration> {
    let joints = prior.joints.as_ref()?;
    let known = std::array::from_fn(|slot| slot >= joints.moving || joints.sigma(slot) < VAGUE);
    let vague = |weighted: &WeightedView<'_>| {
        let chain_link = weighted.view.chain_link.as_ref();
        let way = chain_link.map(|chain_link| joints.chain.between(joints.root, chain_link.link));
        way.is_some_and(|way| way.iter().any(|slot| !known[*slot]))
    };
    views.iter().any(vague).then(|| {
        let search = Search {
            chain: &joints.chain,
            views,
            anchor: joints.root,
            world_from_anchor: prior.pose,
            values: joints.values,
            known,
        };
        search.finished()
    })
}

struct Search<'a> {
    chain: &'a KinematicChain,
    views: &'a [WeightedView<'a>],
    anchor: usize,
    world_from_anchor: Pose,
    values: Values,
    known: [bool; MOST_JOINTS],
}

impl Search<'_> {
    /// The configuration with all links that are seen, the nearest first.
    fn finished(mut self) -> Configuration {
        let links = self
            .views
            .iter()
            .filter_map(|weighted| weighted.view.chain_link.as_ref());
        let mut links: Vec<usize> = links.map(|chain_link| chain_link.link).collect();
        links.sort_by_key(|link| (self.chain.between(self.anchor, *link).len(), *link));
        links.dedup();
        for link in links {
            let mut open = self.chain.between(self.anchor, link);
            open.retain(|slot| !self.known[*slot]);
            self.choose(link, &open);
            open.iter().for_each(|slot| self.known[*slot] = true);
        }
        self.at(&self.values)
    }

    fn at(&self, values: &Values) -> Configuration {
        Configuration {
            root: self.anchor,
            pose: self.world_from_anchor,
            joints: *values,
            rates: Rates::default(),
        }
    }

    /// Chooses the open values between the anchor and a link.
    fn choose(&mut self, link: usize, open: &[usize]) {
        let Some((last, before)) = open.split_last() else {
            return;
        };
        let candidates = self.candidates(link);
        let mut best = (f64::INFINITY, self.values);
        for values in self.trials(before.last().copied()) {
            for candidate in &candidates {
                let mut values = values;
                if let Some(value) = self.value_by(*last, link, candidate, &values) {
                    values[*last] = value;
                }
                let cost = self.cost(link, &values);
                if cost < best.0 {
                    best = (cost, values);
                }
            }
        }
        self.values = best.1;
    }

    /// The values with one of them over its range.
    fn trials(&self, slot: Option<usize>) -> Vec<Values> {
        let Some((slot, joint)) =
            slot.and_then(|slot| Some((slot, self.chain.moving().nth(slot)?)))
        else {
            return vec![self.values];
        };
        let [lowest, highest] = range(joint);
        let trial = |index: usize| {
            let mut values = self.values;
            values[slot] = lowest + (highest - lowest) * (index as f64 + 0.5) / TRIALS as f64;
            values
        };
        (0..TRIALS).map(trial).collect()
    }

    fn views(&self, link: usize) -> impl Iterator<Item = &WeightedView<'_>> {
        self.views.iter().filter(move |weighted| {
            weighted
                .view
                .chain_link
                .as_ref()
                .is_some_and(|chain_link| chain_link.link == link)
        })
    }

    /// `world_from_link` by each branch of the link's largest view.
    fn candidates(&self, link: usize) -> Vec<Pose> {
        largest(self.views(link)).map(branches).unwrap_or_default()
    }

    fn cost(&self, link: usize, values: &Values) -> f64 {
        let at = self.at(values);
        self.views(link).map(|weighted| weighted.chi2(&at)).sum()
    }

    /// The value of the last joint on the way to a link that is at a pose, the others having theirs.
    fn value_by(&self, slot: usize, link: usize, pose: &Pose, values: &Values) -> Option<f64> {
        let (parent, child) = self.chain.ends(slot)?;
        let joint = self.chain.moving().nth(slot)?;
        let near = self.at(values);
        let far = Configuration {
            root: link,
            pose: *pose,
            joints: *values,
            rates: Rates::default(),
        };
        let (of_parent, of_child) = if self.chain.hangs_on(link, slot) {
            (near, far)
        } else {
            (far, near)
        };
        let world_from_parent = self.chain.world_from_link(&of_parent, parent);
        let world_from_child = self.chain.world_from_link(&of_child, child);
        Some(nearest_value(
            joint,
            &(world_from_parent.inverse() * world_from_child),
        ))
    }
}

/// The middle of each range.
fn middle(chain: &KinematicChain) -> Values {
    let mut values = Values::zeros();
    for (slot, joint) in chain.moving().enumerate() {
        let [lowest, highest] = range(joint);
        values[slot] = 0.5 * (lowest + highest);
    }
    values
}

fn range(joint: &Joint) -> [f64; 2] {
    let endless = match joint.kind {
        JointKind::Prismatic => [-REACH, REACH],
        _ => [-std::f64::consts::PI, std::f64::consts::PI],
    };
    joint.limits.unwrap_or(endless)
}

/// The possible value at which the joint's motion comes nearest to the one seen: of a turn its part about the axis (the
/// twist of the swing-twist decomposition), of a shift its part along it.
fn nearest_value(joint: &Joint, parent_from_child: &Pose) -> f64 {
    let motion = joint.parent_from_joint.inverse() * parent_from_child;
    let value = match joint.kind {
        JointKind::Prismatic => joint.axis.dot(&motion.translation.vector),
        _ => {
            let turn: Vector3<f64> = motion.rotation.imag();
            let angle = 2.0 * joint.axis.dot(&turn).atan2(motion.rotation.w);
            let [lowest, highest] = range(joint);
            let middle = 0.5 * (lowest + highest);
            let turns = ((middle - angle) / std::f64::consts::TAU).round();
            angle + turns * std::f64::consts::TAU
        }
    };
    match joint.limits {
        Some([lowest, highest]) => value.clamp(lowest, highest),
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::{JointId, LinkId};

    fn joint(kind: JointKind, limits: Option<[f64; 2]>) -> Joint {
        Joint {
            id: JointId::new("joint").unwrap(),
            kind,
            parent: LinkId::new("parent").unwrap(),
            child: LinkId::new("child").unwrap(),
            axis: Vector3::new(0.0, 0.6, 0.8),
            parent_from_joint: Pose::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.3, -0.2, 1.0)),
            limits,
            max_speed: None,
        }
    }

    #[test]
    fn the_value_of_a_motion_is_found_again() {
        for kind in [JointKind::Revolute, JointKind::Prismatic] {
            for value in [-2.5, -0.3, 0.0, 0.7, 3.0] {
                let joint = joint(kind, None);
                let found = nearest_value(&joint, &joint.parent_from_child(value));
                assert!((found - value).abs() < 1e-12, "{kind:?} {value}: {found}");
            }
        }
    }

    #[test]
    fn the_value_lies_within_limits_even_beyond_half_a_turn() {
        let joint = joint(JointKind::Revolute, Some([2.0, 5.0]));
        let found = |value: f64| nearest_value(&joint, &joint.parent_from_child(value));
        assert!((found(4.5) - 4.5).abs() < 1e-12);
        assert_eq!(found(5.2), 5.0);
        assert_eq!(found(1.9), 2.0);
    }
}
