//! Fusion with any sequence of inputs: images of good and of damaged corners, clock steps, changed models, any order of
//! times. Every output is finite, and every covariance has a diagonal that is none below zero.

#![no_main]

use arbitrary::{Result, Unstructured};
use nalgebra::{Matrix2, Point2, Point3, UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_site_model::{Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, Rig, TagCorners, TagId};
use sextant_site_report::ObjectEstimate;
use sextant_fuzz as _;
use sextant_geometry::lens::Intrinsics;
use sextant_geometry::{Lens, Pose, tag_corners_in_tag};
use sextant_tag_families::Family;

const START_NS: u64 = 1_700_000_000_000_000_000;
const MOST_INPUTS: usize = 200;
const CAMERAS: usize = 3;
const TAGS: usize = 4;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = run(&mut Unstructured::new(bytes));
});

fn run(bytes: &mut Unstructured<'_>) -> Result<()> {
    let rig = rig();
    let object = object(0.03);
    let options = FusionOptions::default();
    let mut fusion =
        Fusion::new(rig.clone(), vec![object.clone()], options).expect("the models are in order");
    let mut now_ns = START_NS;
    for _ in 0..MOST_INPUTS {
        if bytes.is_empty() {
            break;
        }
        now_ns = now_ns.saturating_add(u64::from(bytes.arbitrary::<u16>()?) * 2_000);
        let input = input(bytes, &rig, &object, now_ns)?;
        fusion.handle(now_ns, input);
        while let Some(output) = fusion.poll_output() {
            if let Output::Pose(estimate) = output {
                check(&estimate);
            }
        }
        let asked_ns = now_ns.saturating_add(u64::from(bytes.arbitrary::<u16>()?) * 10_000);
        if let Some(estimate) = fusion.pose_at(object.id(), asked_ns) {
            check(&estimate);
        }
        let _ = (fusion.faults(), fusion.proposal(), fusion.poll_timeout());
    }
    Ok(())
}

fn check(estimate: &ObjectEstimate) {
    let pose = estimate.world_from_object.to_homogeneous();
    let numbers = pose
        .iter()
        .chain(&estimate.covariance)
        .chain(&estimate.twist);
    assert!(numbers.copied().all(f64::is_finite), "{estimate:?}");
    assert!(
        (0..6).all(|axis| estimate.covariance[(axis, axis)] >= 0.0),
        "{estimate:?}"
    );
}

fn input(
    bytes: &mut Unstructured<'_>,
    rig: &Rig,
    object: &ObjectModel,
    now_ns: u64,
) -> Result<Input> {
    Ok(match bytes.arbitrary::<u8>()? {
        0..220 => Input::Image(image(bytes, rig, object, now_ns)?),
        220..230 => Input::Tick,
        230..236 => Input::ClockStep {
            by_ns: bytes.arbitrary()?,
        },
        236..246 => Input::Rig(rig.clone()),
        _ => Input::Objects(vec![self::object(
            0.02 + f64::from(bytes.arbitrary::<u8>()?) * 1e-4,
        )]),
    })
}

/// Mostly what a camera sees of the object somewhere, so that fusion tracks; now and then any numbers at all.
fn image(
    bytes: &mut Unstructured<'_>,
    rig: &Rig,
    object: &ObjectModel,
    now_ns: u64,
) -> Result<ImageObservation> {
    let camera = &rig.cameras()[bytes.choose_index(rig.cameras().len())?];
    let small = |bytes: &mut Unstructured<'_>| Ok(f64::from(bytes.arbitrary::<i8>()?) / 128.0);
    let place = Vector3::new(
        small(bytes)? * 0.2,
        small(bytes)? * 0.2,
        small(bytes)? * 0.2,
    );
    let turn = Vector3::new(small(bytes)?, small(bytes)?, small(bytes)?);
    let world_from_object = Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn));
    let camera_from_world = camera.world_from_camera.unwrap_or_default().inverse();
    let mut tags = Vec::new();
    for tag in object.tags() {
        let object_from_tag = tag.object_from_tag.unwrap_or_default();
        let camera_from_tag = camera_from_world * world_from_object * object_from_tag;
        let corners = tag_corners_in_tag(tag.size_m)
            .map(|corner: Point3<f64>| camera.lens.project(&(camera_from_tag * corner)));
        let corners = corners.map(|corner| corner.unwrap_or(Point2::new(0.0, 0.0)));
        let mut seen = TagCorners {
            tag: tag.tag,
            corners,
            corner_covariance: [Matrix2::identity() * 0.01; 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        };
        match bytes.arbitrary::<u8>()? {
            0..160 => tags.push(seen),
            160..220 => {}
            220..240 => {
                seen.corners[0] = Point2::new(bytes.arbitrary()?, bytes.arbitrary()?);
                tags.push(seen);
            }
            _ => {
                let [xx, xy, yy] = [bytes.arbitrary()?, bytes.arbitrary()?, bytes.arbitrary()?];
                seen.corner_covariance[1] = Matrix2::new(xx, xy, xy, yy);
                tags.push(seen);
            }
        }
    }
    let capture_ns = match bytes.arbitrary::<u8>()? {
        0..240 => now_ns.saturating_sub(u64::from(bytes.arbitrary::<u16>()?) * 1_000),
        _ => bytes.arbitrary()?,
    };
    let clock_error_ns = match bytes.arbitrary::<u8>()? {
        0..240 => 100_000,
        _ => ImageObservation::CLOCK_ERROR_UNKNOWN,
    };
    Ok(ImageObservation {
        camera: camera.id.clone(),
        capture_ns,
        clock_error_ns,
        exposure_ns: 0,
        resolution: None,
        tags,
    })
}

fn rig() -> Rig {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = |index: usize| {
        let turn = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.3 * index as f64, 0.0);
        let place = turn * Vector3::new(0.0, 0.0, -0.8);
        Camera::new(
            CameraId::new(&format!("cam{index}")).expect("a name"),
            [640, 480],
            Lens::pinhole(intrinsics).expect("a lens"),
            Some(Pose::from_parts(place.into(), turn)),
        )
    };
    Rig::new((0..CAMERAS).map(camera).collect()).expect("a rig")
}

fn object(size_m: f64) -> ObjectModel {
    let tag = |index: usize| {
        let (family, id) = (Family::Tag36h11, index as u32);
        let object_from_tag = Pose::translation(0.05 * index as f64, 0.0, 0.0);
        ObjectTag::new(TagId { family, id }, size_m, Some(object_from_tag))
    };
    let id = ObjectId::new("plate").expect("a name");
    ObjectModel::new(id, (0..TAGS).map(tag).collect()).expect("an object")
}
