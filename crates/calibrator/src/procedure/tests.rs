//! The face that terminal and page see is the same for all three.

use super::*;
use crate::{Gauge, Grade, Origin};
use nalgebra::{Isometry3, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_site_model::{Camera, ObjectId, ObjectTag, TagCorners, TagId};

fn tag(id: u32) -> TagId {
    let family = Family::Tag36h11;
    TagId { family, id }
}

fn named(name: &str) -> CameraId {
    CameraId::new(name).unwrap()
}

fn pinhole() -> Lens {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 602.0,
        cx: 318.0,
        cy: 241.0,
    };
    Lens::pinhole(intrinsics).unwrap()
}

/// Six tags in two rows, the upper row bent forwards by half a radian.
fn thing() -> ObjectModel {
    let place = |id: u32| {
        let x = 0.06 * (f64::from(id % 3) - 1.0);
        let row = f64::from(id / 3);
        let bend = Vector3::new(0.5 * row, 0.0, 0.0);
        let pose = Isometry3::new(Vector3::new(x, 0.06 * row, 0.015 * row), bend);
        ObjectTag::new(tag(id), 0.05, Some(pose))
    };
    let id = ObjectId::new("thing").unwrap();
    ObjectModel::new(id, (0..6).map(place).collect()).unwrap()
}

/// The object from `at` metres, turned a little otherwise with every step.
fn camera_from_object(step: usize) -> Pose {
    let (way, step) = (step as f64 * 0.7, step as f64);
    let at = Vector3::new(
        0.16 * (way * 1.3).sin(),
        0.12 * (way * 0.9).cos(),
        0.45 + 0.15 * (0.37 * step).sin(),
    );
    let face = Isometry3::rotation(Vector3::new(std::f64::consts::PI, 0.0, 0.0));
    let tilt = Vector3::new(0.6 * way.sin(), 0.6 * (way * 1.7).cos(), 0.3 * way.cos());
    Isometry3::translation(at.x, at.y, at.z) * face * Isometry3::rotation(tilt)
}

fn image(camera: &str, step: usize, camera_from_object: &Pose) -> ImageObservation {
    let object = thing();
    let tags = object.tags().iter().map(|own| {
        let pose = camera_from_object * own.object_from_tag.unwrap();
        let corners =
            tag_corners_in_tag(own.size_m).map(|c| pinhole().project(&(pose * c)).unwrap());
        TagCorners {
            tag: own.tag,
            corners,
            corner_covariance: [nalgebra::Matrix2::zeros(); 4],
            corner_cross_covariance: [nalgebra::Matrix2::zeros(); 6],
        }
    });
    ImageObservation {
        camera: named(camera),
        capture_ns: step as u64 * 33_333_333,
        clock_error_ns: 0,
        exposure_ns: 0,
        resolution: None,
        tags: tags.filter(is_inside).collect(),
    }
}

fn is_inside(seen: &TagCorners) -> bool {
    let mut corners = seen.corners.iter();
    corners.all(|c| (0.0..639.0).contains(&c.x) && (0.0..479.0).contains(&c.y))
}

fn rig() -> Rig {
    let camera = |name: &str| Camera::new(named(name), [640, 480], pinhole(), None);
    Rig::new(vec![camera("a"), camera("b")]).unwrap()
}

fn lens_plan() -> Plan {
    Plan::Lens(LensPlan {
        camera: named("new"),
        board: thing(),
        resolution: [640, 480],
        model: Some(LensModel::Pinhole),
        selection: Selection::New,
    })
}

fn learn_plan() -> Plan {
    let tags = thing();
    Plan::Learn(LearnPlan {
        object: ObjectId::new("learned").unwrap(),
        tags: tags.tags().iter().map(|t| (t.tag, t.size_m)).collect(),
        cameras: vec![named("a")],
        gauge: Gauge::Tag(tag(0)),
        from: None,
    })
}

fn run(plan: Plan, camera: &str) -> Procedure {
    let mut procedure = Procedure::start(rig(), plan).unwrap();
    for step in 0..90 {
        let seen = image(camera, step, &camera_from_object(step));
        procedure.handle(&seen).unwrap();
    }
    procedure
}

#[test]
fn a_lens_is_written_into_the_rig_that_was_there() {
    let procedure = run(lens_plan(), "new");
    let ProgressDetails::Lens(details) = procedure.progress().details else {
        panic!("not a lens");
    };
    assert!(details.views >= 20, "{}", details.views);
    let outcome = procedure.solve().unwrap();
    let Product::Rig(found) = outcome.product else {
        panic!("not a rig");
    };
    let names: Vec<&str> = found.cameras().iter().map(|c| c.id.as_str()).collect();
    assert_eq!(names, ["a", "b", "new"]);
    let lens = found.camera(&named("new")).unwrap().lens.intrinsics();
    assert!((lens.fx - 600.0).abs() < 0.1, "{lens:?}");
}

#[test]
fn an_object_is_sketched_as_it_grows_and_solved() {
    let mut procedure = Procedure::start(rig(), learn_plan()).unwrap();
    let sketch = |procedure: &Procedure| match procedure.progress().details {
        ProgressDetails::Learn(details) => details.sketch,
        _ => panic!("not learning"),
    };
    assert!(sketch(&procedure).is_empty());
    for step in 0..60 {
        let mut seen = image("a", step, &camera_from_object(step));
        if step < 30 {
            seen.tags.retain(|seen| seen.tag.id < 4);
        }
        procedure.handle(&seen).unwrap();
        if step == 29 {
            assert_eq!(sketch(&procedure).len(), 4);
        }
    }
    let progress = procedure.progress();
    assert!(
        progress.is_enough && progress.fraction == 1.0,
        "{progress:?}"
    );
    let object = thing();
    for (drawn, own) in sketch(&procedure).iter().zip(object.tags()) {
        let first = object.tags()[0].object_from_tag.unwrap();
        let own = first.inverse() * own.object_from_tag.unwrap();
        let off = Vector3::from(drawn.position) - own.translation.vector;
        assert!(off.norm() < 0.002, "{} {off:?}", drawn.tag);
    }
    let outcome = procedure.solve().unwrap();
    assert_eq!(outcome.verdict.grade, Grade::Good, "{}", outcome.verdict);
    assert!(matches!(outcome.product, Product::Object(object) if object.tags().len() == 6));
}

#[test]
fn cameras_that_see_the_same_are_placed() {
    let plan = Plan::Rig(RigPlan {
        object: thing(),
        origin: Origin::FirstCamera,
    });
    let mut procedure = Procedure::start(rig(), plan).unwrap();
    let a_from_b = Isometry3::new(Vector3::new(0.1, 0.0, 0.02), Vector3::new(0.0, 0.2, 0.0));
    for step in 0..120 {
        let at = camera_from_object(step);
        procedure.handle(&image("a", step, &at)).unwrap();
        procedure
            .handle(&image("b", step, &(a_from_b.inverse() * at)))
            .unwrap();
    }
    let Product::Rig(found) = procedure.solve().unwrap().product else {
        panic!("not a rig");
    };
    let b = found
        .camera(&named("b"))
        .unwrap()
        .world_from_camera
        .unwrap();
    assert!(
        (b.translation.vector - a_from_b.translation.vector).norm() < 1e-4,
        "{b}"
    );
}

#[test]
fn only_cameras_that_count_are_counted() {
    let procedure = run(learn_plan(), "b");
    assert_eq!(procedure.progress().images, 0);
    assert!(procedure.counts(&named("a")) && !procedure.counts(&named("b")));
    let lens = run(lens_plan(), "a");
    assert_eq!(lens.progress().images, 0);
    assert!(lens.counts(&named("new")) && !lens.counts(&named("a")));
}

#[test]
fn an_image_of_another_resolution_is_refused_and_the_next_is_taken() {
    let mut procedure = Procedure::start(rig(), lens_plan()).unwrap();
    let mut seen = image("new", 0, &camera_from_object(0));
    seen.tags[0]
        .corners
        .iter_mut()
        .for_each(|corner| corner.x += 900.0);
    let refused = procedure.handle(&seen).unwrap_err().to_string();
    assert!(refused.contains("640 x 480"), "{refused}");
    procedure
        .handle(&image("new", 1, &camera_from_object(1)))
        .unwrap();
    assert_eq!(procedure.progress().images, 1);
}

#[test]
fn images_of_another_size_are_left_out_and_said() {
    let of_size = |step: usize, size: [u32; 2]| ImageObservation {
        resolution: Some(size),
        ..image("a", step, &camera_from_object(step))
    };
    let mut procedure = Procedure::start(rig(), learn_plan()).unwrap();
    (0..40).for_each(|step| procedure.handle(&of_size(step, [320, 240])).unwrap());
    let words = "40 images of a were left out, since they have 320 x 240 pixels and not 640 x 480";
    assert_eq!(procedure.progress().images, 0);
    assert!(procedure.progress().hint.contains(words));
    let refused = procedure.solve().unwrap_err().to_string();
    assert!(refused.contains(words), "{refused}");
    // A camera that does not count may have any size.
    let other = ImageObservation {
        camera: named("b"),
        ..of_size(0, [32, 24])
    };
    procedure.handle(&other).unwrap();
    (40..130).for_each(|step| procedure.handle(&of_size(step, [640, 480])).unwrap());
    let outcome = procedure.solve().unwrap();
    assert_eq!(outcome.verdict.grade, Grade::Good, "{}", outcome.verdict);
    let Report::Learn(report) = &outcome.report else {
        panic!("not learning");
    };
    for verdict in [&outcome.verdict, &report.verdict] {
        assert_eq!(verdict.because.len(), 1, "{verdict}");
        assert!(verdict.to_string().contains(words), "{verdict}");
    }
}

#[test]
fn the_report_on_a_lens_says_what_became_of_each_image() {
    let mut procedure = run(lens_plan(), "new");
    for step in 0..90 {
        let mut seen = image("new", step, &camera_from_object(step));
        seen.tags.truncate(if step % 3 == 0 { 6 } else { 1 });
        procedure.handle(&seen).unwrap();
    }
    let Report::Lens(report) = procedure.solve().unwrap().report else {
        panic!("not a lens");
    };
    assert_eq!(report.images, 180);
    let (alike, without_board) = (report.alike, report.without_board);
    assert!(
        without_board >= 60 && alike >= 20,
        "{alike} {without_board}"
    );
    assert_eq!(report.views + alike + without_board, 180);
}
