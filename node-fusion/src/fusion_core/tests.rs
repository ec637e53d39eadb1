//! The node's turns, by clocks that the test sets.

use super::*;
use crate::outbox::Put;
use nalgebra::{Matrix6, Vector6};
use sextant_estimator::HeldBack;
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_proto::{FusionStatus, Message, ObjectPose, Observations, Timing, decode, encode};
use sextant_site_files::parse_toml;
use sextant_site_model::{Camera, Mount, ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use std::path::Path;

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = 33_333_333;
const DELAY_NS: u64 = 10_000_000;

/// Both clocks of the host, which a test sets.
struct Clock(Moment);

impl Clock {
    fn pass(&mut self, ns: u64) {
        self.0.wall_ns += ns;
        self.0.monotonic_ns += ns;
    }
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

fn models() -> ModelsInForce {
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
    ModelsInForce {
        rig: Rig::new(vec![camera]).unwrap(),
        objects: vec![cube()],
        settings: Default::default(),
    }
}

/// A node, a camera, and what the node has published.
struct Bench {
    core: FusionCore,
    clock: Clock,
    sent: u64,
    unread: u64,
    published: Vec<Put>,
}

impl Bench {
    fn new() -> Self {
        Self::with_models(models())
    }

    fn with_models(models: ModelsInForce) -> Self {
        let text = "site = \"lab\"\nrig = \"rig.toml\"\n";
        let config: FusionConfig = parse_toml(Path::new("fusion.toml"), text, |_| Ok(())).unwrap();
        let initial = InitialState {
            models,
            formers: Formers::default(),
            record: None,
            unwritten: Vec::new(),
            others: Vec::new(),
            clock: ClockQuality::default(),
        };
        let now = Moment {
            wall_ns: 1_800_000_000 * SECOND_NS,
            monotonic_ns: 1000 * SECOND_NS,
        };
        Self {
            core: FusionCore::new(&config, initial, now).unwrap(),
            clock: Clock(now),
            sent: 0,
            unread: 0,
            published: Vec::new(),
        }
    }

    /// An image that was taken so long ago, as a message.
    fn image(&mut self, age_ns: u64) -> Item {
        self.sent += 1;
        let message = Observations {
            camera: north(),
            sequence: self.sent,
            capture_ns: self.clock.0.wall_ns - age_ns,
            exposure_ns: 0,
            clock: sextant_proto::ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        };
        Item {
            key: self.core.keys.observations(&north()),
            payload: Payload::Bytes(encode(&message).unwrap()),
            sender: None,
        }
    }

    /// A turn of the process.
    fn turn(&mut self, item: Option<&Item>) {
        let now = self.clock.0;
        self.core.update_duty(now);
        if let Some(item) = item {
            self.core.observation(item, now);
        }
        self.core.tick(now);
        if self.core.is_report_due(now) {
            let host = HostState {
                unread: self.unread,
                ..HostState::default()
            };
            self.core.report(host, now);
        }
        self.act();
    }

    fn act(&mut self) {
        while let Some(action) = self.core.poll(self.clock.0) {
            if let Action::Publish(Publication::Message(put)) = action {
                self.published.push(put);
            }
        }
    }

    /// Images of a second, each handled as it comes.
    fn run_a_second(&mut self) {
        for _ in 0..30 {
            self.clock.pass(PERIOD_NS);
            let image = self.image(DELAY_NS);
            self.turn(Some(&image));
        }
    }

    fn set_wall(&mut self, by_ns: i64) {
        self.clock.0.wall_ns = self.clock.0.wall_ns.saturating_add_signed(by_ns);
        self.core.clock_stepped(by_ns, self.clock.0);
    }

    /// What has been published of a kind since this was asked last.
    fn messages<M: Message>(&mut self) -> Vec<M> {
        self.act();
        let messages: Vec<M> = (self.published.iter())
            .filter_map(|put| decode(&put.payload).ok())
            .collect();
        self.published
            .retain(|put| decode::<M>(&put.payload).is_err());
        messages
    }

    /// The next status.
    fn status(&mut self) -> FusionStatus {
        self.messages::<FusionStatus>();
        self.clock.pass(SECOND_NS);
        self.turn(None);
        self.messages().pop().unwrap()
    }
}

#[test]
fn after_the_clock_is_set_back_images_are_fused_and_statuses_go_on() {
    let mut bench = Bench::new();
    bench.run_a_second();
    bench.messages::<FusionStatus>();
    bench.set_wall(-(3600 * SECOND_NS as i64));
    bench.run_a_second();
    bench.run_a_second();
    let statuses: Vec<FusionStatus> = bench.messages();
    assert_eq!(statuses.len(), 2, "{statuses:?}");
    let last = bench.status();
    assert_eq!(last.cameras[0].received, 90);
    assert_eq!(last.cameras[0].late, 0);
    assert!(last.cameras[0].last_capture_ns < bench.clock.0.wall_ns);
    assert_eq!(last.uptime_s, 3);
    assert_eq!(last.notices, [Notice::ClockStepped { by_s: -3600.0 }]);
    assert_eq!(bench.core.machine.statistics().cameras[&north()].images, 90);
}

/// One cause, one notice: a network that stood still is distinguished from a node that did.
#[test]
fn observations_that_were_held_up_are_dropped_and_who_was_late_is_shown() {
    for is_node_late in [false, true] {
        let mut bench = Bench::new();
        bench.run_a_second();
        for _ in 0..30 {
            bench.clock.pass(SECOND_NS / 10);
            if !is_node_late {
                bench.turn(None);
            }
        }
        for image in 0..90 {
            let image = bench.image(DELAY_NS + (90 - image) * PERIOD_NS);
            bench.turn(Some(&image));
        }
        let status = bench.status();
        // All but those of the last half second.
        assert_eq!(status.cameras[0].late, 75);
        let [notice] = &status.notices[..] else {
            panic!("{:?}", status.notices)
        };
        let total = match notice {
            Notice::Overload { total, .. } if is_node_late => *total,
            Notice::LateObservations { total, .. } if !is_node_late => *total,
            other => panic!("{other:?}"),
        };
        assert_eq!(total, 75);
        assert_eq!(bench.core.machine.statistics().cameras[&north()].images, 45);
    }
}

#[test]
fn what_was_dropped_unread_is_shown() {
    let mut bench = Bench::new();
    bench.status();
    bench.unread = 1000;
    let overload = Notice::Overload {
        dropped: 1000,
        total: 1000,
    };
    assert_eq!(bench.status().notices, [overload]);
}

fn estimate(now: Moment, x_m: f64, variance: f64) -> ObjectEstimate {
    ObjectEstimate {
        object: cube().id().clone(),
        capture_ns: now.wall_ns,
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
fn a_carrier_of_cameras_is_published_though_no_file_describes_it() {
    let drone = ObjectId::new("drone").unwrap();
    let mut models = models();
    let carried = models.rig.cameras().iter().map(|camera| Camera {
        world_from_camera: None,
        mount: Some(Mount {
            carrier: drone.clone(),
            carrier_from_camera: Pose::identity(),
        }),
        ..camera.clone()
    });
    models.rig = Rig::new(carried.collect()).unwrap();
    let mut bench = Bench::with_models(models);
    bench.status();
    let seen = estimate(bench.clock.0, 1.0, 1e-6);
    bench.core.estimates.push_back(ObjectEstimate {
        object: drone.clone(),
        ..seen
    });
    let published: Vec<ObjectPose> = bench.messages();
    assert_eq!(published[0].object, drone);
    let objects = bench.status().objects;
    assert!(
        objects
            .iter()
            .any(|one| one.object == drone && one.rate_hz > 0.0),
        "{objects:?}"
    );
}

#[test]
fn a_pose_that_cannot_be_encoded_is_dropped_and_counted_and_the_next_is_published() {
    let mut bench = Bench::new();
    bench.status();
    let now = bench.clock.0;
    for estimate in [estimate(now, 2.0e6, 1e-6), estimate(now, 1.0, -1e-12)] {
        bench.core.estimates.push_back(estimate);
    }
    let published: Vec<ObjectPose> = bench.messages();
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
    let mut bench = Bench::new();
    bench.status();
    for held_ns in [0, 3 * SECOND_NS] {
        bench.core.handled_ns = bench.clock.0.monotonic_ns;
        let estimate = estimate(bench.clock.0, 1.0, 1e-6);
        bench.core.estimates.push_back(estimate);
        bench.clock.pass(held_ns);
        bench.act();
    }
    assert_eq!(bench.messages::<ObjectPose>().len(), 1);
    let held_up = Notice::Overload {
        dropped: 1,
        total: 1,
    };
    assert_eq!(bench.status().notices, [held_up]);
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

#[test]
fn a_proposal_is_published_once_said_in_the_status_and_withdrawn_with_the_models() {
    let mut bench = Bench::new();
    bench.messages::<sextant_proto::Proposal>();
    for _ in 0..3 {
        bench.core.propose(Some(refined()), bench.clock.0);
    }
    let proposals: Vec<sextant_proto::Proposal> = bench.messages();
    let [proposal] = &proposals[..] else {
        panic!("one is published");
    };
    assert_eq!(
        (proposal.n_images, proposal.before_px, proposal.after_px),
        (24, 0.92, 0.41)
    );
    let rig = proposal.rig_config().unwrap().unwrap();
    assert_eq!(rig.cameras[0].id, north());
    assert_eq!(proposal.object_configs().unwrap()[0].id, *cube().id());
    let status = bench.core.status.status(
        &mut bench.core.intake,
        &bench.core.machine,
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
    bench.core.apply_changes(&[change], bench.clock.0);
    bench.act();
    bench.published.retain(|put| put.key.ends_with("/proposal"));
    let withdrawn: Vec<sextant_proto::Proposal> = bench.messages();
    assert!(matches!(&withdrawn[..], [none] if none.is_empty()));
}

#[test]
fn a_proposal_is_applied_by_its_number_as_it_was_when_it_was_published() {
    let mut bench = Bench::new();
    bench.status();
    bench.core.propose(Some(refined()), bench.clock.0);
    bench.act();
    let mut newer = refined();
    newer.held_back.n_images += 1;
    newer.rig = None;
    bench.clock.pass(SECOND_NS);
    bench.core.propose(Some(newer), bench.clock.0);
    bench.published.retain(|put| put.key.ends_with("/proposal"));
    let published: Vec<sextant_proto::Proposal> = bench.messages();
    let first = published.iter().find(|it| !it.is_empty()).unwrap();
    let by_number = sextant_proto::Proposal::none(first.node.clone(), first.t_ns);
    let request = |message: &sextant_proto::Proposal| Item {
        key: "sextant/v1/lab/config/models".to_owned(),
        payload: Payload::Bytes(encode(message).unwrap()),
        sender: None,
    };
    bench.core.config(&request(&by_number), bench.clock.0);
    bench.turn(None);
    let in_force = bench.core.replica.models();
    assert_eq!(Some(&in_force.rig), refined().rig.as_ref());
    assert_eq!(in_force.objects, refined().objects);

    bench.clock.pass(60 * SECOND_NS);
    bench.core.config(&request(&by_number), bench.clock.0);
    bench.act();
    let answers: Vec<sextant_proto::ConfigAnswer> = bench.messages();
    let ChangeOutcome::Refused(refusal) = &answers.last().unwrap().outcome else {
        panic!("{answers:?}");
    };
    assert!(refusal.to_string().contains("look at what is proposed now"));
}

#[test]
fn a_node_that_applies_puts_its_proposal_in_force_and_can_go_back() {
    let mut bench = Bench::new();
    bench.core.apply(refined(), bench.clock.0);
    bench.turn(None);
    let in_force = bench.core.replica.models();
    assert_eq!(Some(&in_force.rig), refined().rig.as_ref());
    assert_eq!(in_force.objects, refined().objects);
    let formers = |put: &Put| put.key.ends_with("/former");
    bench.published.retain(formers);
    let last: Vec<sextant_proto::Proposal> = bench.messages();
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
