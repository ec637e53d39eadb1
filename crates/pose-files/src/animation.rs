//! A recorded site as a scene over time: cameras at rest, objects with their tags, and when each object is where.
//! [`crate::write_usda`] and [`crate::glb`] write it.
//!
//! An object is visible while it is tracked or coasting. It is hidden while it is initialising or lost, and where no
//! pose came for [`LONGEST_GAP_NS`]. A landmark without a pose stands where its file says, and a camera that an object
//! carries goes with it. Cameras and tags are as in the last models given. A sample takes up to 200 bytes of memory.

use sextant_geometry::Pose;
use sextant_proto::{EpochFilter, ObjectLinks, ObjectPose};
use sextant_site_model::{Camera, LinkId, ObjectId, ObjectModel, ObjectTag, Rig};
use sextant_site_report::{ObjectEstimate, State};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// An object without a pose for longer than this, ns, is hidden after its last one.
const LONGEST_GAP_NS: u64 = 500_000_000;
/// Highest frame rate of an animation, Hz.
const MAX_RATE_HZ: u64 = 1000;

/// The recording has no pose that could be animated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("it has no pose of an object that was tracked")]
pub struct NoPoses;

/// Collects the models and poses of a recording.
#[derive(Debug, Default)]
pub struct AnimationBuilder {
    rig: Rig,
    models: BTreeMap<ObjectId, ObjectModel>,
    objects: BTreeMap<ObjectId, Samples>,
    epochs: EpochFilter,
    link_epochs: EpochFilter,
}

/// Poses by capture time, ns.
#[derive(Debug, Default)]
struct Samples {
    /// `world_from_object`; `None` where the object is hidden.
    object: BTreeMap<u64, Option<Pose>>,
    /// `world_from_link`.
    links: BTreeMap<LinkId, BTreeMap<u64, Pose>>,
}

impl Samples {
    fn insert(&mut self, t_ns: u64, world_from_object: Pose, state: State) {
        let is_visible = matches!(state, State::Tracking | State::Coasting);
        let sample = is_visible.then_some(world_from_object);
        self.object.insert(t_ns, sample);
    }
}

/// A site over time. Times are ns since the Unix epoch, metres, world with z up.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Cameras that stand in the world, each with `world_from_camera`.
    pub(crate) cameras: Vec<PlacedCamera>,
    /// Objects with a pose, by name.
    pub(crate) objects: Vec<AnimatedObject>,
    /// The first visible pose.
    pub(crate) start_ns: u64,
    /// The end of the last visible interval.
    pub(crate) end_ns: u64,
    /// The usual rate of an object's poses, Hz.
    pub(crate) rate_hz: u64,
    left_out: LeftOut,
}

/// What a recording has and its animation lacks.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Cameras without a pose, and those whose carrier is not in the animation.
    pub cameras: Vec<String>,
    /// Objects that were never tracked.
    pub objects: Vec<String>,
    /// Number of tags without a place on their object.
    pub tags: usize,
}

/// An object with its tags.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AnimatedObject {
    pub id: ObjectId,
    /// The placed tags of the object, or of its base.
    pub tags: Vec<PlacedTag>,
    pub links: Vec<AnimatedLink>,
    /// `world_from_object` while it is visible, in order of time.
    pub intervals: Vec<Interval>,
    /// Cameras that it carries, each with `object_from_camera`.
    pub cameras: Vec<PlacedCamera>,
}

/// A camera at its place in the world or on an object.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedCamera {
    pub camera: Camera,
    pub parent_from_camera: Pose,
}

/// A link other than the base, with its tags.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AnimatedLink {
    pub id: LinkId,
    pub tags: Vec<PlacedTag>,
    /// `object_from_link` by time.
    pub samples: Vec<(u64, Pose)>,
}

/// A tag at its place on an object or link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedTag {
    pub tag: ObjectTag,
    pub parent_from_tag: Pose,
}

/// An object is visible from the first sample until `end_ns`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Interval {
    /// Never empty.
    pub samples: Vec<(u64, Pose)>,
    pub end_ns: u64,
    /// Whether nothing ended it.
    is_open: bool,
}

impl AnimationBuilder {
    /// The cameras, in place of former ones.
    pub fn rig(&mut self, rig: Rig) {
        self.rig = rig;
    }

    /// An object, in place of a former one of that name.
    pub fn object(&mut self, model: ObjectModel) {
        self.models.insert(model.id().clone(), model);
    }

    /// A published pose with its arrival, ns. The last one of a capture time counts; those of a fusion node that
    /// another has replaced do not.
    pub fn pose(&mut self, pose: &ObjectPose, arrival_ns: u64) {
        if self.epochs.admits(&pose.object, pose.epoch, arrival_ns) {
            let samples = self.objects.entry(pose.object.clone()).or_default();
            samples.insert(pose.capture_ns, pose.world_from_object(), pose.state);
        }
    }

    /// An estimate with its links.
    pub fn estimate(&mut self, estimate: &ObjectEstimate) {
        let t_ns = estimate.capture_ns;
        let samples = self.objects.entry(estimate.object.clone()).or_default();
        samples.insert(t_ns, estimate.world_from_object, estimate.state);
        let links = estimate.articulated.iter().flat_map(|all| &all.links);
        for link in links {
            let poses = samples.links.entry(link.link.clone()).or_default();
            poses.insert(t_ns, link.world_from_link);
        }
    }

    /// The links of an articulated object.
    pub fn links(&mut self, links: &ObjectLinks, arrival_ns: u64) {
        let (object, epoch) = (&links.object, links.epoch);
        if !self.link_epochs.admits(object, epoch, arrival_ns) {
            return;
        }
        let samples = self.objects.entry(object.clone()).or_default();
        for link in &links.links {
            let poses = samples.links.entry(link.link.clone()).or_default();
            poses.insert(links.capture_ns, link.world_from_link());
        }
    }

    /// The animation.
    ///
    /// # Errors
    /// Where no object was ever tracked.
    pub fn finish(self) -> Result<Animation, NoPoses> {
        let period_ns = usual_period_ns(&self.objects);
        let mut left_out = LeftOut::default();
        let mut objects = Vec::new();
        let seen: BTreeSet<ObjectId> = self.objects.keys().cloned().collect();
        for (id, samples) in self.objects {
            match animated(&id, &samples, self.models.get(&id), period_ns) {
                Some(object) => objects.push(object),
                None => left_out.objects.push(id.to_string()),
            }
        }
        let unseen = self.models.iter();
        let unseen = unseen.filter(|(id, _)| !seen.contains(*id));
        let (landmarks, unseen): (Vec<_>, Vec<_>) =
            unseen.partition(|(_, model)| model.world_from_object().is_some());
        left_out
            .objects
            .extend(unseen.iter().map(|(id, _)| id.to_string()));
        left_out.tags = self.models.values().map(unplaced_tags).sum();
        let starts = objects.iter().filter_map(AnimatedObject::start_ns);
        let start_ns = starts.min().ok_or(NoPoses)?;
        let ends = objects.iter().filter_map(AnimatedObject::end_ns);
        let end_ns = ends.max().ok_or(NoPoses)?;
        for object in &mut objects {
            object.last_until(end_ns);
        }
        let landmarks = landmarks.into_iter().map(|(_, model)| model);
        objects.extend(landmarks.filter_map(|model| standing(model, start_ns, end_ns)));
        objects.sort_by(|a, b| a.id.cmp(&b.id));
        let mut cameras = Vec::new();
        for camera in self.rig.cameras() {
            let place = place_for(camera, &mut cameras, &mut objects);
            match place {
                Some((place, parent_from_camera)) => place.push(PlacedCamera {
                    camera: camera.clone(),
                    parent_from_camera,
                }),
                None => left_out.cameras.push(camera.id.to_string()),
            }
        }
        Ok(Animation {
            start_ns,
            end_ns,
            rate_hz: (1_000_000_000 + period_ns / 2) / period_ns,
            cameras,
            objects,
            left_out,
        })
    }
}

impl Animation {
    /// What the recording has beside it.
    #[must_use]
    pub fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// Number of cameras and of objects.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        let carried = self.objects.iter().map(|object| object.cameras.len());
        (
            self.cameras.len() + carried.sum::<usize>(),
            self.objects.len(),
        )
    }

    /// From the first pose to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.seconds(self.end_ns)
    }

    /// Seconds since the start.
    pub(crate) fn seconds(&self, t_ns: u64) -> f64 {
        t_ns.saturating_sub(self.start_ns) as f64 * 1e-9
    }
}

impl AnimatedObject {
    fn start_ns(&self) -> Option<u64> {
        Some(self.intervals.first()?.samples.first()?.0)
    }

    fn end_ns(&self) -> Option<u64> {
        self.intervals.last().map(|interval| interval.end_ns)
    }

    /// An object that was not lost stays visible until the end if its last poses are near to it.
    fn last_until(&mut self, end_ns: u64) {
        let last = self.intervals.last_mut().filter(|last| last.is_open);
        if let Some(last) = last.filter(|last| end_ns - last.end_ns <= LONGEST_GAP_NS) {
            last.end_ns = end_ns;
        }
    }

    /// `world_from_object` by time. At the end of an interval the last pose is repeated, so that an object does not
    /// move between its last pose and its disappearance.
    pub fn samples(&self) -> impl Iterator<Item = (u64, Pose)> + Clone {
        self.intervals.iter().flat_map(|interval| {
            let last = interval.samples.last().copied();
            let held = last.filter(|(t_ns, _)| *t_ns < interval.end_ns);
            let held = held.map(|(_, pose)| (interval.end_ns, pose));
            interval.samples.iter().copied().chain(held)
        })
    }

    /// When the object becomes visible or hidden, from the start of the animation on; empty where it is always visible.
    pub fn visibility(&self, animation: &Animation) -> Vec<(u64, bool)> {
        let mut changes = Vec::new();
        if self.start_ns() > Some(animation.start_ns) {
            changes.push((animation.start_ns, false));
        }
        for interval in &self.intervals {
            changes.extend(interval.samples.first().map(|(t_ns, _)| (*t_ns, true)));
            if interval.end_ns < animation.end_ns {
                changes.push((interval.end_ns, false));
            }
        }
        // An interval may begin where the one before ends.
        changes.dedup_by(|later, earlier| {
            let is_replaced = later.0 == earlier.0;
            if is_replaced {
                *earlier = *later;
            }
            is_replaced
        });
        if changes.iter().all(|(_, is_visible)| *is_visible) {
            changes.clear();
        }
        changes
    }
}

/// A camera's frame of OpenGL (x right, y up, looking along -z) in the frame of what it stands on.
pub(crate) fn to_gl_camera(parent_from_camera: &Pose) -> Pose {
    let half_turn = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), PI);
    Pose::from_parts(
        parent_from_camera.translation,
        parent_from_camera.rotation * half_turn,
    )
}

/// Where a camera goes, the world's or its carrier's list, with its pose there.
fn place_for<'a>(
    camera: &Camera,
    world: &'a mut Vec<PlacedCamera>,
    objects: &'a mut [AnimatedObject],
) -> Option<(&'a mut Vec<PlacedCamera>, Pose)> {
    let Some(mount) = &camera.mount else {
        return Some((world, camera.world_from_camera?));
    };
    let carrier = objects
        .iter_mut()
        .find(|object| object.id == mount.carrier)?;
    Some((&mut carrier.cameras, mount.carrier_from_camera))
}

/// A landmark, where its file says.
fn standing(model: &ObjectModel, start_ns: u64, end_ns: u64) -> Option<AnimatedObject> {
    let place = *model.world_from_object()?;
    Some(AnimatedObject {
        id: model.id().clone(),
        tags: placed_tags(model, None),
        links: Vec::new(),
        intervals: vec![Interval {
            samples: vec![(start_ns, place)],
            end_ns,
            is_open: true,
        }],
        cameras: Vec::new(),
    })
}

/// The object while it is visible; `None` where it never is.
fn animated(
    id: &ObjectId,
    samples: &Samples,
    model: Option<&ObjectModel>,
    period_ns: u64,
) -> Option<AnimatedObject> {
    let mut intervals = intervals(&samples.object, period_ns);
    if intervals.is_empty() {
        return None;
    }
    let poses = intervals.iter_mut().flat_map(|i| i.samples.iter_mut());
    make_continuous(poses.map(|(_, pose)| pose));
    let articulation = model.and_then(ObjectModel::articulation);
    let base = articulation.map(|articulation| articulation.links()[articulation.base()].clone());
    let tags = model.map_or(Vec::new(), |model| placed_tags(model, base.as_ref()));
    let links = samples.links.iter();
    let links = links.filter(|(link, _)| base.as_ref() != Some(link));
    let links = links.map(|(link, poses)| AnimatedLink {
        id: link.clone(),
        tags: model.map_or(Vec::new(), |model| placed_tags(model, Some(link))),
        samples: relative(&samples.object, poses),
    });
    let links = links.filter(|link| !link.samples.is_empty()).collect();
    Some(AnimatedObject {
        id: id.clone(),
        tags,
        links,
        intervals,
        cameras: Vec::new(),
    })
}

/// The intervals in which an object is visible.
fn intervals(samples: &BTreeMap<u64, Option<Pose>>, period_ns: u64) -> Vec<Interval> {
    let mut intervals: Vec<Interval> = Vec::new();
    for (&t_ns, pose) in samples {
        let current = intervals.last_mut().filter(|current| current.is_open);
        let current = current.and_then(|current| current.followed_at(t_ns, period_ns));
        match (current, pose) {
            (Some(current), Some(pose)) => {
                current.samples.push((t_ns, *pose));
                current.end_ns = t_ns;
            }
            (Some(current), None) => {
                current.end_ns = t_ns;
                current.is_open = false;
            }
            (None, Some(pose)) => intervals.push(Interval {
                samples: vec![(t_ns, *pose)],
                end_ns: t_ns,
                is_open: true,
            }),
            (None, None) => {}
        }
    }
    if let Some(last) = intervals.last_mut().filter(|last| last.is_open) {
        last.end_ns += period_ns;
    }
    intervals
}

impl Interval {
    /// The interval if a pose of this time belongs to it. Otherwise it ends a usual period after its last pose.
    fn followed_at(&mut self, t_ns: u64, period_ns: u64) -> Option<&mut Self> {
        if t_ns - self.end_ns <= LONGEST_GAP_NS {
            return Some(self);
        }
        self.end_ns += period_ns.min(LONGEST_GAP_NS);
        self.is_open = false;
        None
    }
}

/// `object_from_link` at the times at which both poses are known.
fn relative(object: &BTreeMap<u64, Option<Pose>>, link: &BTreeMap<u64, Pose>) -> Vec<(u64, Pose)> {
    let both = link.iter().filter_map(|(t_ns, world_from_link)| {
        let world_from_object = object.get(t_ns)?.as_ref()?;
        Some((*t_ns, world_from_object.inv_mul(world_from_link)))
    });
    let mut samples: Vec<_> = both.collect();
    make_continuous(samples.iter_mut().map(|(_, pose)| pose));
    samples
}

/// Of both quaternions of a rotation takes the one nearer to that before, so that an interpolation never goes the long
/// way round.
fn make_continuous<'a>(poses: impl Iterator<Item = &'a mut Pose>) {
    let mut former: Option<nalgebra::Quaternion<f64>> = None;
    for pose in poses {
        let quaternion = *pose.rotation.quaternion();
        if former.is_some_and(|former| former.dot(&quaternion) < 0.0) {
            pose.rotation = nalgebra::UnitQuaternion::new_unchecked(-quaternion);
        }
        former = Some(*pose.rotation.quaternion());
    }
}

fn placed_tags(model: &ObjectModel, link: Option<&LinkId>) -> Vec<PlacedTag> {
    let tags = model.tags().iter().filter(|tag| tag.link.as_ref() == link);
    tags.filter_map(|tag| {
        Some(PlacedTag {
            tag: tag.clone(),
            parent_from_tag: place_of(model, tag)?,
        })
    })
    .collect()
}

fn unplaced_tags(model: &ObjectModel) -> usize {
    let tags = model.tags().iter();
    tags.filter(|tag| place_of(model, tag).is_none()).count()
}

/// Where a tag is on its object or link; one alone is the origin.
fn place_of(model: &ObjectModel, tag: &ObjectTag) -> Option<Pose> {
    let is_only = model.tags().len() == 1;
    tag.object_from_tag.or(is_only.then(Pose::identity))
}

/// Median interval between the poses of an object, ns.
fn usual_period_ns(objects: &BTreeMap<ObjectId, Samples>) -> u64 {
    let times = objects.values().map(|samples| samples.object.keys());
    let mut intervals: Vec<u64> = times
        .flat_map(|times| times.clone().skip(1).zip(times).map(|(b, a)| b - a))
        .collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return 1_000_000_000 / 30;
    }
    let median_ns = *intervals.select_nth_unstable(middle).1;
    median_ns.clamp(1_000_000_000 / MAX_RATE_HZ, 1_000_000_000)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};
    use sextant_geometry::{Intrinsics, Lens};
    use sextant_site_model::{CameraId, Mount, TagId};
    use sextant_tag_families::Family;

    pub(crate) const MS: u64 = 1_000_000;
    const START_NS: u64 = 1_800_000_000_000_000_000;

    pub(crate) fn pose(object: &str, t_ms: u64, state: State, turn: f64) -> ObjectPose {
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        ObjectPose {
            object: ObjectId::new(object).unwrap(),
            epoch: 1,
            sequence: t_ms,
            capture_ns: START_NS + t_ms * MS,
            published_ns: START_NS + t_ms * MS,
            state,
            position: [1.0, 2.0, t_ms as f64 * 1e-3],
            orientation: rotation.coords.into(),
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
        }
    }

    pub(crate) fn builder() -> AnimationBuilder {
        let mut builder = AnimationBuilder::default();
        let lens = Lens::pinhole(Intrinsics {
            fx: 600.0,
            fy: 610.0,
            cx: 330.0,
            cy: 230.0,
        });
        let place = Pose::from_parts(
            Translation3::new(0.0, -2.0, 1.0),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -PI / 2.0),
        );
        let camera = |id: &str, place| {
            let lens = lens.clone().unwrap();
            Camera::new(CameraId::new(id).unwrap(), [640, 480], lens, place)
        };
        let cameras = vec![camera("north-1", Some(place)), camera("south", None)];
        builder.rig(Rig::new(cameras).unwrap());
        let tag = |id, place| {
            let family = Family::Tag36h11;
            ObjectTag::new(TagId { family, id }, 0.04, place)
        };
        let tags = vec![
            tag(3, Some(Pose::translation(0.0, 0.0, 0.05))),
            tag(4, None),
        ];
        let id = ObjectId::new("cube").unwrap();
        builder.object(ObjectModel::new(id, tags).unwrap());
        builder
    }

    pub(crate) fn animation(poses: &[ObjectPose]) -> Animation {
        let mut builder = builder();
        for pose in poses {
            builder.pose(pose, pose.capture_ns);
        }
        builder.finish().unwrap()
    }

    fn visibility_ms(animation: &Animation) -> Vec<(u64, bool)> {
        let changes = animation.objects[0].visibility(animation).into_iter();
        let since = |t_ns: u64| (t_ns - animation.start_ns) / MS;
        changes.map(|(t_ns, is)| (since(t_ns), is)).collect()
    }

    #[test]
    fn an_object_is_hidden_while_it_is_lost() {
        let states = [
            (0, State::Tracking),
            (20, State::Coasting),
            (40, State::Lost),
            (60, State::Initialising),
            (80, State::Tracking),
            (100, State::Tracking),
        ];
        let poses = states.map(|(t_ms, state)| pose("cube", t_ms, state, 0.0));
        let animation = animation(&poses);
        assert_eq!(
            visibility_ms(&animation),
            [(0, true), (40, false), (80, true)]
        );
        let samples: Vec<u64> = animation.objects[0]
            .samples()
            .map(|(t_ns, _)| (t_ns - START_NS) / MS)
            .collect();
        assert_eq!(samples, [0, 20, 40, 80, 100, 120]);
        assert_eq!(animation.rate_hz, 50);
        assert_eq!(animation.left_out().cameras, ["south"]);
        assert_eq!(animation.left_out().tags, 1);
    }

    #[test]
    fn an_object_is_hidden_while_no_poses_come() {
        let times = [0, 20, 40, 1040, 1060];
        let poses = times.map(|t_ms| pose("cube", t_ms, State::Tracking, 0.0));
        let animation = animation(&poses);
        assert_eq!(
            visibility_ms(&animation),
            [(0, true), (60, false), (1040, true)]
        );
        let held: Vec<f64> = animation.objects[0]
            .samples()
            .map(|(_, pose)| pose.translation.z)
            .collect();
        assert_eq!(held, [0.0, 0.02, 0.04, 0.04, 1.04, 1.06, 1.06]);
    }

    #[test]
    fn an_object_that_is_always_there_has_no_visibility() {
        let poses = [0, 20, 40].map(|t_ms| pose("cube", t_ms, State::Tracking, 0.0));
        assert_eq!(visibility_ms(&animation(&poses)), []);
    }

    #[test]
    fn quaternions_take_no_long_way() {
        let poses: Vec<_> = (0..100)
            .map(|k| pose("cube", 20 * k, State::Tracking, k as f64 * 0.2))
            .collect();
        let animation = animation(&poses);
        let rotations: Vec<_> = animation.objects[0].samples().collect();
        for pair in rotations.windows(2) {
            let [a, b] = [pair[0].1, pair[1].1].map(|pose| *pose.rotation.quaternion());
            assert!(a.dot(&b) > 0.9, "{a} {b}");
        }
    }

    #[test]
    fn an_older_fusion_node_and_an_earlier_estimate_do_not_count() {
        let at = |x: f64, epoch| {
            let mut pose = pose("cube", 0, State::Tracking, 0.0);
            (pose.position[0], pose.epoch) = (x, epoch);
            pose
        };
        let animation = animation(&[at(1.0, 2), at(2.0, 2), at(3.0, 1)]);
        let x: Vec<f64> = animation.objects[0]
            .samples()
            .map(|(_, pose)| pose.translation.x)
            .collect();
        assert_eq!(x, [2.0, 2.0]);
    }

    #[test]
    fn a_carried_camera_goes_with_its_carrier_and_a_landmark_stands() {
        let mut builder = builder();
        let north = builder.rig.cameras()[0].clone();
        let carried = |id: &str, carrier: &str| Camera {
            id: CameraId::new(id).unwrap(),
            world_from_camera: None,
            mount: Some(Mount {
                carrier: ObjectId::new(carrier).unwrap(),
                carrier_from_camera: Pose::translation(0.1, 0.0, 0.0),
            }),
            ..north.clone()
        };
        let cameras = vec![carried("eye", "cube"), carried("other", "drone"), north];
        builder.rig(Rig::new(cameras).unwrap());
        let family = Family::Tag36h11;
        let alone = ObjectTag::new(TagId { family, id: 9 }, 0.1, None);
        let post = ObjectModel::new(ObjectId::new("post").unwrap(), vec![alone]).unwrap();
        let place = Pose::translation(3.0, 0.0, 0.0);
        builder.object(post.with_world_from_object(Some(place)).unwrap());
        for t_ms in [0, 20, 40] {
            let pose = pose("cube", t_ms, State::Tracking, 0.0);
            builder.pose(&pose, pose.capture_ns);
        }
        let animation = builder.finish().unwrap();
        assert_eq!(animation.left_out().cameras, ["other"]);
        assert_eq!(animation.left_out().objects, Vec::<String>::new());
        assert_eq!(animation.counts(), (2, 2));
        let [cube, post] = animation.objects.as_slice() else {
            panic!("two objects");
        };
        assert_eq!(cube.cameras[0].camera.id.as_str(), "eye");
        assert_eq!(cube.cameras[0].parent_from_camera.translation.x, 0.1);
        assert_eq!(post.samples().next().unwrap().1, place);
        assert_eq!((post.tags.len(), post.visibility(&animation).len()), (1, 0));
    }

    #[test]
    fn a_recording_without_tracked_objects_is_no_animation() {
        let mut builder = builder();
        builder.pose(&pose("cube", 0, State::Lost, 0.0), 0);
        assert_eq!(builder.finish(), Err(NoPoses));
    }

    #[test]
    fn cameras_look_along_their_negative_z_axis() {
        let camera = builder().rig.cameras()[0].clone();
        let theirs = to_gl_camera(&camera.world_from_camera.unwrap());
        let forward = theirs.rotation * -Vector3::z();
        let up = theirs.rotation * Vector3::y();
        assert!((forward - Vector3::y()).norm() < 1e-12, "{forward}");
        assert!((up - Vector3::z()).norm() < 1e-12, "{up}");
    }
}
