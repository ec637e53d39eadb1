//! What goes wrong in a scene, when images show it, and what it is to be named.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ImageObservation, ObjectModel, ObjectTag, Rig, TagId};
use sextant_site_report::Fault;

use crate::models::made;
use crate::motion::{Motion, Wave};
use crate::random::Random;
use crate::scene::{Body, Scene};
use crate::view::information;

/// When a fault begins, s.
pub const CHANGE_S: f64 = 3.0;

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum WrongKind {
    Camera,
    Slip,
    Size,
    Clock,
    Twice,
    Shared,
}

pub const KINDS: [(&str, WrongKind); 6] = [
    ("camera", WrongKind::Camera),
    ("slip", WrongKind::Slip),
    ("size", WrongKind::Size),
    ("clock", WrongKind::Clock),
    ("twice", WrongKind::Twice),
    ("shared", WrongKind::Shared),
];

/// What is wrong.
pub struct Wrong {
    kind: WrongKind,
    pub camera: usize,
    body: usize,
    pub tag: TagId,
    /// What it is, in words.
    pub words: String,
    /// Seconds by which the clock jumps.
    pub jump_s: f64,
}

impl Wrong {
    /// Chooses what goes wrong: a tag that is often seen.
    pub fn choose(kind: WrongKind, scene: &Scene, random: &mut Random) -> Self {
        let body = random.count(0, scene.bodies.len() - 1);
        let mut seen: BTreeMap<TagId, usize> = BTreeMap::new();
        for shot in scene.shots(CHANGE_S, CHANGE_S + 3.0, &mut Random(1)) {
            for tag in shot.image.tags {
                *seen.entry(tag.tag).or_default() += 1;
            }
        }
        let tags = scene.bodies[body].model.tags();
        let often = |tag: &&ObjectTag| seen.get(&tag.tag).is_some_and(|views| *views > 30);
        let often: Vec<TagId> = tags.iter().filter(often).map(|tag| tag.tag).collect();
        let tag = match often.len() {
            0 => tags[0].tag,
            some => often[random.count(0, some - 1)],
        };
        let first = usize::from(kind == WrongKind::Clock);
        let camera = random.count(first, (scene.clocks.len() - 1).max(first));
        let words = String::new();
        Self {
            kind,
            camera,
            body,
            tag,
            words,
            jump_s: 0.0,
        }
    }

    /// Makes it so.
    pub fn come(&mut self, scene: &mut Scene, random: &mut Random) {
        match self.kind {
            WrongKind::Camera => self.bump(scene, random),
            WrongKind::Slip => self.change_tag(
                scene,
                |tag, random| {
                    let angle = random.within(0.0, std::f64::consts::TAU);
                    let by = Pose::translation(0.003 * angle.cos(), 0.003 * angle.sin(), 0.0);
                    tag.object_from_tag = tag.object_from_tag.map(|place| place * by);
                },
                random,
            ),
            WrongKind::Size => self.change_tag(
                scene,
                |tag, random| {
                    tag.size_m *= if random.count(0, 1) == 0 { 0.98 } else { 1.02 };
                },
                random,
            ),
            WrongKind::Clock => {
                let sign = if random.count(0, 1) == 0 { 1.0 } else { -1.0 };
                let by_s = sign * random.log_within(0.005, 0.2);
                scene.clocks[self.camera].offset_s += by_s;
                self.jump_s = by_s;
                self.words = format!("{:.1} ms", by_s * 1e3);
            }
            WrongKind::Twice => self.print_again(scene, random),
            WrongKind::Shared => self.share(scene, random),
        }
    }

    fn bump(&mut self, scene: &mut Scene, random: &mut Random) {
        let about = random.direction();
        let turn = UnitQuaternion::from_axis_angle(&about, 1f64.to_radians());
        let mut cameras = scene.truth.cameras().to_vec();
        let pose = &mut cameras[self.camera].world_from_camera;
        *pose = pose.map(|pose| pose * Pose::from_parts(Vector3::zeros().into(), turn));
        scene.truth = made(Rig::new(cameras));
        self.words = format!("about {:.1} {:.1} {:.1}", about.x, about.y, about.z);
    }

    fn change_tag(
        &self,
        scene: &mut Scene,
        change: impl Fn(&mut ObjectTag, &mut Random),
        random: &mut Random,
    ) {
        let body = &mut scene.bodies[self.body];
        body.model = with_tags(&body.model, |tag| {
            if tag.tag == self.tag {
                change(tag, random);
            }
        });
    }

    /// Another print of the tag lies about.
    fn print_again(&self, scene: &mut Scene, random: &mut Random) {
        let tags = scene.bodies[self.body].model.tags();
        let size_m = tags
            .iter()
            .find(|tag| tag.tag == self.tag)
            .map_or(0.04, |tag| tag.size_m);
        let tag = ObjectTag::new(self.tag, size_m, Some(Pose::identity()));
        let place = Vector3::new(0.15 * random.gauss(), 0.15 * random.gauss(), -0.1);
        scene.bodies.push(Body {
            model: made(ObjectModel::new(
                scene.bodies[self.body].model.id().clone(),
                vec![tag],
            )),
            motion: Motion::Smooth {
                middle: Pose::translation(place.x, place.y, place.z),
                spin: Vector3::zeros(),
                waves: Box::new(std::array::from_fn(|_| {
                    Wave::new(0.0, [0.2, 0.6], 0.0, random)
                })),
            },
            arm: None,
        });
    }

    /// The next body bears it in place of one of its own.
    fn share(&self, scene: &mut Scene, random: &mut Random) {
        let next = (self.body + 1) % scene.bodies.len();
        let place = random.count(0, scene.bodies[next].model.tags().len() - 1);
        let own = scene.bodies[next].model.tags()[place].tag;
        scene.bodies[next].model = with_tags(&scene.bodies[next].model, |tag| {
            if tag.tag == own {
                tag.tag = self.tag;
            }
        });
    }

    /// Whether the images of all cameras within a period tell it, by body.
    pub fn is_evident(
        &self,
        scene: &Scene,
        images: &BTreeMap<usize, ImageObservation>,
        at_s: f64,
    ) -> bool {
        let tags_of = |body: usize| -> BTreeSet<TagId> {
            scene.bodies[body]
                .model
                .tags()
                .iter()
                .map(|tag| tag.tag)
                .collect()
        };
        let sees = |camera: usize, tags: &BTreeSet<TagId>| {
            images
                .get(&camera)
                .is_some_and(|image| image.tags.iter().any(|tag| tags.contains(&tag.tag)))
        };
        let others = |tags: &BTreeSet<TagId>| {
            images
                .keys()
                .filter(|other| **other != self.camera && sees(**other, tags))
                .count()
        };
        let bodies = || (0..scene.bodies.len()).map(|body| (body, tags_of(body)));
        let views = || images.values().flat_map(|image| &image.tags);
        match self.kind {
            WrongKind::Camera => {
                bodies().any(|(_, tags)| sees(self.camera, &tags) && others(&tags) >= 2)
            }
            WrongKind::Clock => bodies().any(|(body, tags)| {
                let place = |s: f64| scene.bodies[body].motion.at(s).translation.vector;
                let speed = (place(at_s + 0.01) - place(at_s)).norm() / 0.01;
                sees(self.camera, &tags) && others(&tags) >= 1 && speed > 0.1
            }),
            WrongKind::Slip | WrongKind::Size => {
                let own = tags_of(self.body);
                let seen: BTreeSet<TagId> = views()
                    .map(|tag| tag.tag)
                    .filter(|tag| own.contains(tag))
                    .collect();
                seen.contains(&self.tag) && seen.len() >= 3
            }
            WrongKind::Twice | WrongKind::Shared => images
                .values()
                .any(|image| image.tags.iter().filter(|tag| tag.tag == self.tag).count() > 1),
        }
    }

    /// What the images of all cameras within a period tell of the offset of its camera's clock, 1/s²: each by itself
    /// and without what is known of the motion, so that it is the least. Of the camera's N and the others' M about a
    /// body with twist v it is vᵀ (N⁻¹ + M⁻¹)⁻¹ v.
    pub fn information(
        &self,
        scene: &Scene,
        images: &BTreeMap<usize, ImageObservation>,
        at_s: f64,
    ) -> f64 {
        const STEP_S: f64 = 1e-3;
        let own = |body: usize| information(scene, self.camera, body, at_s);
        let others = |body: usize| {
            let others = images.keys().filter(|other| **other != self.camera);
            others
                .map(|other| information(scene, *other, body, at_s))
                .sum::<Matrix6<f64>>()
        };
        let offset_information = |body: usize| {
            let (n, m) = (own(body), others(body));
            let at = |s: f64| scene.bodies[body].links(s)[0];
            let v = se3::difference(&at(at_s + STEP_S), &at(at_s)) / STEP_S;
            Some((n * v).dot(&(n + m).cholesky()?.solve(&(m * v))))
        };
        let seen = images.contains_key(&self.camera);
        (0..scene.bodies.len())
            .filter(|_| seen)
            .filter_map(offset_information)
            .sum()
    }

    pub fn is_named_by(&self, scene: &Scene, fault: &Fault) -> bool {
        let own = &scene.truth.cameras()[self.camera].id;
        match (self.kind, fault) {
            (WrongKind::Camera, Fault::CameraMoved { camera }) => camera == own,
            (WrongKind::Slip, Fault::TagMisplaced { tag, .. }) => *tag == self.tag,
            (WrongKind::Size, Fault::TagSize { tag, .. }) => *tag == self.tag,
            (WrongKind::Clock, Fault::ClockOff { camera, .. } | Fault::Untimely { camera, .. }) => {
                camera == own
            }
            (
                WrongKind::Twice | WrongKind::Shared,
                Fault::DuplicateTag { tag, .. } | Fault::TagElsewhere { tag, .. },
            ) => *tag == self.tag,
            _ => false,
        }
    }

    pub fn is_in_doubt_by(&self, scene: &Scene, fault: &Fault) -> bool {
        let own = &scene.truth.cameras()[self.camera].id;
        matches!(fault, Fault::CamerasDisagree { a, b } if self.kind == WrongKind::Camera && (a == own || b == own))
    }
}

fn with_tags(model: &ObjectModel, mut change: impl FnMut(&mut ObjectTag)) -> ObjectModel {
    let mut tags = model.tags().to_vec();
    tags.iter_mut().for_each(&mut change);
    let id = model.id().clone();
    made(match model.articulation() {
        None => ObjectModel::new(id, tags),
        Some(tree) => ObjectModel::articulated(id, tree.clone(), tags),
    })
}
