//! What may not enter and may not leave, each with its own reason.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod samples;

use sextant_proto::*;
use sextant_site_report::{Fault, Imperfection};

fn observed() -> Vec<u8> {
    encode(&samples::observations()).unwrap()
}

#[test]
fn each_part_of_the_header_has_its_own_error() {
    let with = |place: usize, byte: u8| {
        let mut payload = observed();
        payload[place] = byte;
        decode::<Observations>(&payload).unwrap_err()
    };
    assert_eq!(with(0, 0x54), DecodeError::BadMagic);
    assert_eq!(with(1, 2), DecodeError::ForeignVersion(2));
    let other = DecodeError::WrongKind {
        expected: MessageKind::Observations,
        found: 5,
    };
    assert_eq!(with(2, 5), other);
    assert_eq!(with(3, 1), DecodeError::UnknownFlags(1));
}

#[test]
fn bytes_behind_the_message_are_refused() {
    let mut payload = observed();
    payload.extend([0, 0]);
    assert_eq!(
        decode::<Observations>(&payload),
        Err(DecodeError::TrailingBytes(2))
    );
}

/// The message with one value changed, put into bytes without the sender's check, as a careless or hostile sender
/// would.
fn unchecked(change: impl FnOnce(&mut Observations)) -> Result<Observations, DecodeError> {
    let mut message = samples::observations();
    change(&mut message);
    let header = vec![MAGIC, VERSION, MessageKind::Observations as u8, 0];
    decode(&postcard::to_extend(&message, header).unwrap())
}

#[test]
fn values_out_of_range_neither_enter_nor_leave() {
    type Change = fn(&mut Observations);
    let changes: [(&str, Change); 12] = [
        ("tags[].corners", |m| m.tags[1].corners[2][0] = f32::NAN),
        ("tags[].corners", |m| {
            m.tags[1].corners[2][1] = f32::INFINITY
        }),
        ("tags[].corners", |m| m.tags[0].corners[0][1] = -1e20),
        ("tags[].margin", |m| m.tags[0].margin = f32::NAN),
        ("tags[].corner_covariance", |m| {
            m.tags[0].corner_covariance[3] = [1.0, 2.0, 1.0];
        }),
        ("tags[].corner_cross_covariance", |m| {
            m.tags[1].corner_cross_covariance[5][3] = f32::NAN;
        }),
        ("tags[].corner_cross_covariance", |m| {
            m.tags[0].corner_cross_covariance[2][1] = 0.1;
        }),
        ("tags[].poses[].position", |m| {
            m.tags[0].poses[0].position[1] = f32::NEG_INFINITY;
        }),
        ("tags[].poses[].orientation", |m| {
            m.tags[0].poses[1].orientation = [0.0; 4];
        }),
        ("resolution", |m| m.resolution[1] = 0),
        ("capture_ns", |m| m.capture_ns = u64::MAX),
        ("timing", |m| m.timing.published_ns = u64::MAX),
    ];
    for (field, change) in changes {
        let out_of_range = OutOfRange(field);
        assert_eq!(
            unchecked(change),
            Err(DecodeError::OutOfRange(out_of_range)),
            "{field}"
        );
        let mut message = samples::observations();
        change(&mut message);
        assert_eq!(
            encode(&message),
            Err(EncodeError::OutOfRange(out_of_range)),
            "{field}"
        );
    }
}

#[test]
fn lists_beyond_their_limit_neither_enter_nor_leave() {
    let crowd = |m: &mut Observations| m.tags = vec![m.tags[1].clone(); limits::MAX_TAGS + 1];
    assert_eq!(unchecked(crowd), Err(DecodeError::Damaged));
    let mut message = samples::observations();
    crowd(&mut message);
    assert!(matches!(
        encode(&message),
        Err(EncodeError::OutOfRange(OutOfRange("tags")))
    ));
}

#[test]
fn a_pose_with_a_number_that_is_none_does_not_leave() {
    type Change = fn(&mut ObjectPose);
    let changes: [(&str, Change); 5] = [
        ("position", |m| m.position[0] = f64::NAN),
        ("orientation", |m| m.orientation[0] = f64::NAN),
        ("covariance", |m| m.covariance[5] = f64::INFINITY),
        ("covariance", |m| m.covariance[7] = -1e-9),
        ("twist", |m| m.twist[5] = f64::NAN),
    ];
    for (field, change) in changes {
        let mut message = samples::object_pose();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

#[test]
fn links_and_joints_with_a_number_that_is_none_do_not_leave() {
    type Change = fn(&mut ObjectLinks);
    let changes: [(&str, Change); 7] = [
        ("links[].position", |m| m.links[1].position[2] = f64::NAN),
        ("links[].orientation", |m| m.links[0].orientation = [0.0; 4]),
        ("links[].covariance", |m| m.links[1].covariance[35] = -1e-9),
        ("joints[].value", |m| m.joints[0].value = f64::INFINITY),
        ("joints[].variance", |m| m.joints[0].variance = -1e-9),
        ("joints[].velocity", |m| m.joints[0].velocity = f64::NAN),
        ("joints[].velocity_variance", |m| {
            m.joints[0].velocity_variance = f64::NAN;
        }),
    ];
    for (field, change) in changes {
        let mut message = samples::object_links();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

#[test]
fn a_rig_with_a_value_out_of_range_does_not_leave() {
    type Change = fn(&mut RigConfig);
    let changes: [(&str, Change); 6] = [
        ("cameras", |m| m.cameras = vec![m.cameras[0].clone(); 257]),
        ("cameras[].resolution", |m| {
            m.cameras[0].resolution = [640, 0]
        }),
        ("cameras[].world_from_camera_sigma", |m| {
            m.cameras[1]
                .world_from_camera_sigma
                .as_mut()
                .unwrap()
                .position_m = -1e-9;
        }),
        ("cameras[].lens_sigma", |m| {
            m.cameras[1].lens_sigma.as_mut().unwrap().distortion_px = f64::NAN;
        }),
        ("cameras[].line_delay_s", |m| {
            m.cameras[0].line_delay_s = Some(f64::INFINITY);
        }),
        ("cameras[].exposure", |m| {
            m.cameras[1].exposure.as_mut().unwrap().length_s = -0.5;
        }),
    ];
    for (field, change) in changes {
        let mut message = samples::rig_config();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

#[test]
fn an_object_with_a_value_out_of_range_does_not_leave() {
    type Change = fn(&mut ObjectConfig);
    let changes: [(&str, Change); 12] = [
        ("links", |m| m.links = vec![m.links[0].clone(); 33]),
        ("joints[].axis", |m| m.joints[0].axis[1] = f64::NAN),
        ("joints[].parent_from_joint", |m| {
            m.joints[1].parent_from_joint.orientation = [0.0; 4];
        }),
        ("joints[].limits", |m| {
            m.joints[0].limits = Some([1.0, -1.0])
        }),
        ("joints[].max_speed", |m| m.joints[0].max_speed = Some(0.0)),
        ("tags[].link", |m| m.tags[1].link = Some(3)),
        ("tags[].link", |m| m.tags[1].link = None),
        ("tags[].link", |m| m.links.clear()),
        ("tags", |m| m.tags = vec![m.tags[0].clone(); 1025]),
        ("tags[].size_m", |m| m.tags[0].size_m = 0.0),
        ("tags[].size_sigma_m", |m| {
            m.tags[1].size_sigma_m = Some(-1e-9)
        }),
        ("tags[].object_from_tag_sigma", |m| {
            m.tags[0]
                .object_from_tag_sigma
                .as_mut()
                .unwrap()
                .orientation_rad = f64::NAN;
        }),
    ];
    for (field, change) in changes {
        let mut message = samples::object_config();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

/// A rig and an object as large as the limits allow, with every optional field.
#[test]
fn the_largest_rig_and_the_largest_object_fit_into_a_message() {
    let mut rig = samples::rig_config();
    let mut camera = rig.cameras[1].clone();
    camera.id = "x".repeat(32).parse().unwrap();
    rig.cameras = vec![camera; limits::MAX_CAMERAS];
    assert_eq!(encode(&rig).map(drop), Ok(()));
    let mut object = samples::object_config();
    let mut tag = object.tags[0].clone();
    tag.id = u32::MAX;
    object.tags = vec![tag; limits::MAX_OBJECT_TAGS];
    let link: sextant_site_model::LinkId = "x".repeat(32).parse().unwrap();
    object.links = vec![link; limits::MAX_LINKS];
    object.joints = vec![object.joints[0].clone(); limits::MAX_LINKS];
    assert_eq!(encode(&object).map(drop), Ok(()));
}

#[test]
fn a_refused_message_leaves_the_buffer_empty() {
    let mut buffer = vec![1, 2, 3];
    let mut message = samples::object_pose();
    message.rms_px = f32::NAN;
    assert!(encode_into(&message, &mut buffer).is_err());
    assert!(buffer.is_empty());
}

#[test]
fn every_reason_is_counted_under_its_name() {
    let mut rejections = Rejections::default();
    rejections.count(&DecodeError::BadMagic);
    rejections.count(&DecodeError::ForeignVersion(9));
    rejections.count(&DecodeError::TooLong(1 << 20));
    rejections.count(&DecodeError::Damaged);
    rejections.count(&DecodeError::TrailingBytes(1));
    rejections.count(&DecodeError::OutOfRange(OutOfRange("tags")));
    let expected = Rejections {
        bad_magic: 1,
        foreign_version: 1,
        too_long: 1,
        damaged: 2,
        out_of_range: 1,
        ..Rejections::default()
    };
    assert_eq!(rejections, expected);
    assert_eq!(rejections.total(), 6);
}

#[test]
fn cameras_stand_nearer_than_what_they_see() {
    let mut rig = samples::rig_config();
    let mut pose = samples::object_pose();
    let far = [0.0, -1.0e5, 0.0];
    let too_far = [0.0, -1.1e5, 0.0];
    let mut placed = |position| {
        rig.cameras[0].world_from_camera = Some(PoseConfig {
            position,
            orientation: [0.0, 0.0, 0.0, 1.0],
        });
        encode(&rig).map(drop)
    };
    assert_eq!(placed(far), Ok(()));
    let refused = OutOfRange("cameras[].world_from_camera");
    assert_eq!(placed(too_far), Err(EncodeError::OutOfRange(refused)));
    pose.position = too_far;
    assert!(encode(&pose).is_ok());
}

#[test]
fn a_status_with_a_value_out_of_range_does_not_leave() {
    type Change = fn(&mut FusionStatus);
    let changes: [(&str, Change); 9] = [
        ("faults", |m| m.faults = vec![m.faults[0].clone(); 65]),
        ("faults[].ratio", |m| {
            m.faults[3] = Fault::TagSize {
                object: m.objects[0].object.clone(),
                tag: samples::tag(),
                ratio: f64::NAN,
            };
        }),
        ("imperfections", |m| {
            m.imperfections = vec![m.imperfections[0].clone(); 17];
        }),
        ("imperfections[]", |m| {
            m.imperfections[0] = Imperfection::FocalLengthOff {
                camera: m.cameras[0].camera.clone(),
                ratio: -1.0,
            };
        }),
        ("notices", |m| m.notices = vec![m.notices[0].clone(); 33]),
        ("notices[]", |m| {
            m.notices[0] = Notice::ClockStepped {
                by_s: f64::INFINITY,
            };
        }),
        ("notices[]", |m| {
            m.notices[0] = Notice::NameTaken {
                host: "x".repeat(65),
            };
        }),
        ("notices[]", |m| {
            m.notices[0] = Notice::ChangeRefused {
                key: String::new(),
                sender: None,
                refusal: Refusal::Other {
                    detail: "x".repeat(241),
                },
            };
        }),
        ("cameras[].rate_hz", |m| m.cameras[0].rate_hz = f32::NAN),
    ];
    for (field, change) in changes {
        let mut message = samples::fusion_status();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

#[test]
fn a_proposal_with_a_number_that_is_none_does_not_leave() {
    type Change = fn(&mut Proposal);
    let changes: [(&str, Change); 4] = [
        ("t_ns", |m| m.t_ns = u64::MAX),
        ("objects", |m| {
            m.objects = vec![m.objects[0].clone(); limits::MAX_OBJECTS + 1];
        }),
        ("before_px", |m| m.before_px = f64::NAN),
        ("after_px", |m| m.after_px = -0.5),
    ];
    for (field, change) in changes {
        let mut message = samples::proposal();
        change(&mut message);
        let refused = Err(EncodeError::OutOfRange(OutOfRange(field)));
        assert_eq!(encode(&message), refused, "{field}");
    }
}

#[test]
fn what_a_proposal_carries_is_read_as_what_it_is_or_not_at_all() {
    let proposal = samples::proposal();
    assert_eq!(proposal.rig_config(), Ok(Some(samples::rig_config())));
    assert_eq!(
        proposal.object_configs(),
        Ok(vec![samples::object_config()])
    );
    let mixed = Proposal {
        objects: proposal.rig.clone().into_iter().collect(),
        rig: Some(ModelPayload(b"rig".to_vec())),
        ..proposal
    };
    assert_eq!(mixed.rig_config(), Err(DecodeError::BadMagic));
    let wrong = DecodeError::WrongKind {
        expected: MessageKind::ObjectConfig,
        found: MessageKind::RigConfig as u8,
    };
    assert_eq!(mixed.object_configs(), Err(wrong));
}
