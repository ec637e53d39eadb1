//! The node's turns on a network of its own, by a clock that the test sets.

use super::*;
use nalgebra::{Matrix6, Vector6};
use sextant_estimator::HeldBack;
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_proto::{FusionStatus, Notice, ObjectPose, Observations, Timing};
use sextant_site_files::parse_toml;
use sextant_site_model::{Camera, ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_site_report::{ObjectEstimate, State};
use sextant_tag_families::Family;
use sextant_zenoh_bus::{BusOptions, Publisher, Qos};
use std::cell::Cell;

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = 33_333_333;
const DELAY_NS: u64 = 10_000_000;

thread_local! {
    static READING: Cell<Reading> = const {
        Cell::new(Reading {
            wall_ns: 1_800_000_000 * SECOND_NS,
            monotonic_ns: 1000 * SECOND_NS,
        })
    };
}

fn pass(ns: u64) {
    let Reading {
        wall_ns,
        monotonic_ns,
    } = READING.get();
    READING.set(Reading {
        wall_ns: wall_ns + ns,
        monotonic_ns: monotonic_ns + ns,
    });
}

fn set_wall(by_ns: i64) {
    let Reading {
        wall_ns,
        monotonic_ns,
    } = READING.get();
    READING.set(Reading {
        wall_ns: wall_ns.saturating_add_signed(by_ns),
        monotonic_ns,
    });
}

fn north() -> CameraId {
    CameraId::new("north").unwrap()
}

fn cube() -> ObjectModel {
    let tag = ObjectTag::new(
        TagId {
            family: Family::Tag36h11,
            id: 1,
        },
        0.04,
        Some(Pose::identity()),
    );
    ObjectModel::new(ObjectId::new("cube").unwrap(), vec![tag]).unwrap()
}

fn models() -> Models {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = Camera::new(
        north(),
        [640, 480],
        Lens::pinhole(intrinsics).unwrap(),
        Some(Pose::identity()),
    );
    Models {
        rig: Rig::new(vec![camera]).unwrap(),
        objects: vec![cube()],
        settings: Default::default(),
    }
}

/// A node, and a camera of one test.
struct Bench<'a> {
    node: FusionNode<'a>,
    camera: Publisher<Observations>,
    statuses: Subscription,
    poses: Subscription,
    sent: u64,
}

fn router() -> Bus {
    Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap()
}

impl<'a> Bench<'a> {
    fn new(bus: &'a Bus) -> Self {
        let text = "site = \"lab\"\nrig = \"rig.toml\"\n";
        let config: FusionConfig = parse_toml(Path::new("fusion.toml"), text, |_| Ok(())).unwrap();
        let models = models();
        let (rig, objects) = (models.rig.clone(), models.objects.clone());
        let machine = Fusion::new(rig, objects, FusionOptions::default()).unwrap();
        let keys = Keys::of(config.site.clone());
        let replica = Replica::new(config.node.clone(), models, Formers::default(), None, false);
        let clock = SteadyClock::new(|| READING.get());
        let listen = |key: &str| {
            bus.subscribe(key, 10_000, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
                .unwrap()
        };
        Self {
            statuses: listen(&keys.all_fusion_statuses()),
            poses: listen(&keys.all_poses()),
            camera: bus
                .publisher(&keys.observations(&north()), Qos::Config)
                .unwrap(),
            node: FusionNode::open(bus, &config, machine, replica, clock).unwrap(),
            sent: 0,
        }
    }

    /// An image that was taken so long ago.
    fn send(&mut self, age_ns: u64) {
        self.sent += 1;
        let message = Observations {
            camera: north(),
            sequence: self.sent,
            capture_ns: READING.get().wall_ns - age_ns,
            exposure_ns: 0,
            clock: sextant_proto::ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        };
        self.camera.put(&message).unwrap();
    }

    /// Images of a second, each handled as it comes.
    fn run_a_second(&mut self) {
        for _ in 0..30 {
            pass(PERIOD_NS);
            self.send(DELAY_NS);
            self.node.turn().unwrap();
        }
    }

    /// The statuses that were published since this was asked last.
    fn statuses(&mut self) -> Vec<FusionStatus> {
        let items = std::iter::from_fn(|| self.statuses.try_recv());
        items.map(|item| item.decode().unwrap()).collect()
    }

    /// The next status.
    fn status(&mut self) -> FusionStatus {
        self.statuses();
        pass(SECOND_NS);
        self.node.turn().unwrap();
        self.statuses().pop().unwrap()
    }
}

#[test]
fn after_the_clock_is_set_back_images_are_fused_and_statuses_go_on() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    bench.run_a_second();
    bench.statuses();
    set_wall(-(3600 * SECOND_NS as i64));
    bench.run_a_second();
    bench.run_a_second();
    let statuses = bench.statuses();
    assert_eq!(statuses.len(), 2, "{statuses:?}");
    let last = bench.status();
    assert_eq!(last.cameras[0].received, 90);
    // The one that was under way.
    assert!(last.cameras[0].late <= 1, "{last:?}");
    assert!(last.cameras[0].last_capture_ns < READING.get().wall_ns);
    assert_eq!(last.uptime_s, 3);
    assert_eq!(last.notices, [Notice::ClockStepped { by_s: -3600.0 }]);
    assert_eq!(bench.node.machine.statistics().cameras[&north()].images, 89);
}

#[test]
fn observations_that_were_held_up_are_dropped_and_shown() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    bench.run_a_second();
    pass(3 * SECOND_NS);
    for image in 0..90 {
        bench.send(DELAY_NS + (90 - image) * PERIOD_NS);
        bench.node.turn().unwrap();
    }
    let status = bench.status();
    // All but those of the last half second.
    assert_eq!(status.cameras[0].late, 75);
    let late = Notice::LateObservations {
        camera: north(),
        total: 75,
    };
    assert!(status.notices.contains(&late), "{:?}", status.notices);
    assert_eq!(bench.node.machine.statistics().cameras[&north()].images, 45);
}

#[test]
fn a_flood_drops_the_oldest_and_is_shown() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    (0..QUEUE + 1000).for_each(|_| bench.send(DELAY_NS));
    let status = bench.status();
    let is_overload = |notice: &Notice| matches!(notice, Notice::Overload { .. });
    let overload = status.notices.iter().find(|notice| is_overload(notice));
    assert!(overload.is_some(), "{:?}", status.notices);
    assert!(bench.node.observations.counts().dropped >= 1000);
}

fn estimate(x_m: f64, variance: f64) -> ObjectEstimate {
    ObjectEstimate {
        object: cube().id().clone(),
        capture_ns: READING.get().wall_ns,
        world_from_object: Pose::translation(x_m, 0.0, 0.0),
        covariance: Matrix6::from_diagonal(&Vector6::new(1e-6, variance, 1e-6, 1e-6, 1e-6, 1e-6)),
        twist: Vector6::zeros(),
        state: State::Tracking,
        cameras: 1,
        tags: 1,
        rms_px: 0.1,
        articulated: None,
    }
}

#[test]
fn a_pose_that_cannot_be_encoded_is_dropped_and_counted_and_the_next_is_published() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    bench.status();
    let now_ns = READING.get().wall_ns;
    let mut publish = |estimate| bench.node.publishers.pose(&estimate, 1, now_ns).unwrap();
    assert!(!publish(estimate(2.0e6, 1e-6)));
    assert!(publish(estimate(1.0, -1e-12)));
    let published = std::iter::from_fn(|| bench.poses.try_recv());
    let published: Vec<ObjectPose> = published.map(|item| item.decode().unwrap()).collect();
    assert_eq!(published.len(), 1);
    assert_eq!(
        (published[0].sequence, published[0].covariance[7]),
        (1, 0.0)
    );
    let status = bench.status();
    let [Notice::Unpublished { total: 1, detail }] = &status.notices[..] else {
        panic!("{:?}", status.notices);
    };
    let cause = "sextant/v1/lab/object/cube/pose: `position` is out of range";
    assert!(detail.ends_with(cause), "{detail}");
}

#[test]
fn a_pose_that_was_held_up_is_not_published_as_if_it_were_current() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    bench.status();
    bench.node.turned_ns = READING.get().monotonic_ns;
    bench.node.publish_pose(&estimate(1.0, 1e-6)).unwrap();
    pass(3 * SECOND_NS);
    bench.node.publish_pose(&estimate(1.0, 1e-6)).unwrap();
    let published = std::iter::from_fn(|| bench.poses.try_recv());
    assert_eq!(published.count(), 1);
    let status = bench.status();
    let [Notice::Unpublished { total: 1, detail }] = &status.notices[..] else {
        panic!("{:?}", status.notices);
    };
    assert!(detail.contains("held up for 3.0 s"), "{detail}");
}

fn refined() -> Proposal {
    let mut cameras = models().rig.cameras().to_vec();
    cameras[0].world_from_camera = Some(Pose::translation(0.002, 0.0, 0.0));
    let mut tags = cube().tags().to_vec();
    tags[0].object_from_tag = Some(Pose::translation(0.0, 0.001, 0.0));
    Proposal {
        rig: Some(Rig::new(cameras).unwrap()),
        objects: vec![ObjectModel::new(cube().id().clone(), tags).unwrap()],
        held_back: HeldBack {
            n_images: 24,
            before_px: 0.92,
            after_px: 0.41,
        },
    }
}

fn messages<M: sextant_proto::Message>(subscription: &Subscription) -> Vec<M> {
    let items = std::iter::from_fn(|| subscription.try_recv());
    items.map(|item| item.decode().unwrap()).collect()
}

#[test]
fn a_proposal_is_published_once_said_in_the_status_and_withdrawn_with_the_models() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    let listen = |key: &str| {
        bus.subscribe(key, 100, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
            .unwrap()
    };
    let proposals = listen(&bench.node.keys.all_proposals());
    for _ in 0..3 {
        bench.node.propose(Some(refined())).unwrap();
    }
    let [proposal] = &messages::<sextant_proto::Proposal>(&proposals)[..] else {
        panic!("one is published");
    };
    assert_eq!(
        (proposal.n_images, proposal.before_px, proposal.after_px),
        (24, 0.92, 0.41)
    );
    let rig = proposal.rig_config().unwrap().unwrap();
    assert_eq!(rig.cameras[0].id, north());
    assert_eq!(proposal.object_configs().unwrap()[0].id, *cube().id());
    let status = bench.node.status.status(
        &mut bench.node.intake,
        &bench.node.machine,
        Losses::default(),
        1,
    );
    let proposed = Notice::RefinementProposed {
        n_images: 24,
        before_px: 0.92,
        after_px: 0.41,
    };
    assert_eq!(status.notices, [proposed]);

    let change = Change::Removal(cube().id().clone());
    bench.node.put_in_force(&[change]).unwrap();
    let withdrawn: Vec<sextant_proto::Proposal> = messages(&proposals);
    assert!(matches!(&withdrawn[..], [none] if none.is_empty()));
}

#[test]
fn a_node_that_applies_puts_its_proposal_in_force_and_can_go_back() {
    let bus = router();
    let mut bench = Bench::new(&bus);
    let formers = bus
        .subscribe(
            &bench.node.keys.all_formers(),
            100,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )
        .unwrap();
    bench.node.apply(refined());
    bench.node.care_for_models().unwrap();
    let in_force = bench.node.replica.models();
    assert_eq!(Some(&in_force.rig), refined().rig.as_ref());
    assert_eq!(in_force.objects, refined().objects);
    let last: Vec<sextant_proto::Proposal> = messages(&formers);
    let last = last.last().unwrap();
    let before = models();
    assert_eq!(last.rig_config(), Ok(Some((&before.rig).into())));
    assert_eq!(last.object_configs(), Ok(vec![(&before.objects[0]).into()]));
}

#[test]
fn refinement_is_one_word_and_the_former_table_is_refused_with_the_line() {
    let read = |more: &str| {
        let text = format!("site = \"lab\"\nrig = \"rig.toml\"\n{more}\n");
        parse_toml::<FusionConfig>(Path::new("fusion.toml"), &text, |_| Ok(()))
    };
    for (word, wanted) in [
        ("", Refinement::Propose),
        ("refinement = \"off\"", Refinement::Off),
        ("refinement = \"apply\"", Refinement::Apply),
    ] {
        assert_eq!(read(word).unwrap().refinement, wanted);
    }
    for wrong in ["[refinement]\nenabled = true", "refinement = \"on\""] {
        let refused = read(wrong).unwrap_err().to_string();
        assert!(
            refused.contains("fusion.toml:") && refused.contains("propose"),
            "{refused}"
        );
    }
}
