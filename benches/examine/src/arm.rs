//! Articulated bodies: trees of links with joints of any kind, three tags a link.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{
    Articulation, Joint, JointId, JointKind, LinkId, ObjectId, ObjectModel, ObjectTag,
};

use crate::models::{made, tag};
use crate::motion::Wave;
use crate::random::Random;

/// How the joints move: middle and swing of each.
pub struct Arm(Vec<(f64, Wave)>);

impl Arm {
    /// World from each link; parents stand before their children.
    pub fn links(&self, model: &ObjectModel, base: Pose, seconds: f64) -> Vec<Pose> {
        let mut links = vec![base];
        let Some(tree) = model.articulation() else {
            return links;
        };
        for link in 1..tree.links().len() {
            let of_parent = tree.joint_of(link).and_then(|joint| {
                let (middle, wave) = &self.0[link - 1];
                let moved = tree.joints()[joint].parent_from_child(middle + wave.at(seconds));
                Some(links.get(tree.parent_of(joint)?)? * moved)
            });
            links.push(of_parent.unwrap_or(base));
        }
        links
    }
}

pub fn arm(id: ObjectId, random: &mut Random) -> (ObjectModel, Arm) {
    let n_links = random.count(2, 4);
    let link = |index: usize| made(LinkId::new(&format!("link{index}")));
    let (mut joints, mut waves, mut tags) = (Vec::new(), Vec::new(), Vec::new());
    for child in 1..n_links {
        let revolute = random.count(0, 3) > 0;
        let (speed, swing) = if revolute { (2.0, 0.5) } else { (0.1, 0.02) };
        let turn = random.direction().scale(0.5);
        joints.push(Joint {
            id: made(JointId::new(&format!("joint{child}"))),
            kind: if revolute {
                JointKind::Revolute
            } else {
                JointKind::Prismatic
            },
            parent: link(random.count(0, child - 1)),
            child: link(child),
            axis: random.direction().into_inner(),
            parent_from_joint: Pose::new(Vector3::new(random.within(0.06, 0.1), 0.0, 0.03), turn),
            // Never reached.
            limits: (random.count(0, 1) == 0).then_some([-4.0 * swing, 4.0 * swing]),
            max_speed: None,
        });
        waves.push((
            0.5 * swing * random.gauss().clamp(-2.0, 2.0),
            Wave::new(speed, [0.2, 0.6], swing, random),
        ));
    }
    for index in 0..n_links {
        let first = 40 + 4 * index as u32;
        for side in 0..4 {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 1.57 * f64::from(side));
            let place = turn * Vector3::new(random.within(0.0, 0.05), 0.0, 0.02);
            tags.push(ObjectTag {
                link: Some(link(index)),
                ..tag(first + side, 0.03, place, turn)
            });
        }
    }
    let tree = made(Articulation::new((0..n_links).map(link).collect(), joints));
    (made(ObjectModel::articulated(id, tree, tags)), Arm(waves))
}
