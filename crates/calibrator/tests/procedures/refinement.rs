//! A site in ordinary use: what is off a little is found, what is right stays, and nothing that is not known is made up.

use crate::scene::{Lack, Noise, SHARP, carried, image, rig, wand};
use nalgebra::{Isometry3, Vector3};
use sextant_calibrator::refinement::{Change, Finding, Part, Refinement, RefinementOptions};
use sextant_estimator::{ImageObservation, ObjectModel, Rig};
use sextant_geometry::{Pose, se3};

/// What is, and what people believe.
struct Site {
    truth: Rig,
    object: ObjectModel,
    rig: Rig,
    model: ObjectModel,
    /// From one camera's shutter to the next.
    stagger_s: f64,
}

impl Site {
    fn perfect() -> Self {
        Self {
            truth: rig(),
            object: wand(),
            rig: rig(),
            model: wand(),
            stagger_s: 0.0,
        }
    }

    fn with_camera_off(by: &Pose) -> Self {
        let mut cameras = rig().cameras().to_vec();
        let pose = cameras[2].world_from_camera.unwrap();
        cameras[2].world_from_camera = Some(pose * by);
        Self {
            rig: Rig::new(cameras).unwrap(),
            ..Self::perfect()
        }
    }

    fn refinement(&self) -> Refinement {
        let objects = std::slice::from_ref(&self.model);
        Refinement::new(&self.rig, objects, RefinementOptions::default())
    }

    /// Four images of each camera every two seconds, of an object somewhere at each time; what was changed.
    fn used(&mut self, minutes: u32, lack: Lack, path: &dyn Fn(f64) -> Pose) -> Vec<Finding> {
        let mut noise = Noise::seeded(7);
        let mut refinement = self.refinement();
        let mut findings = Vec::new();
        for moment in 0..30 * minutes {
            for seen in self.moment(2.0 * f64::from(moment), lack, path, &mut noise) {
                refinement.handle(&seen);
            }
            if moment == 3 {
                refinement.handle(&self.stamped_wrongly());
            }
            if moment % 30 == 29 {
                let found = refinement.find();
                if let Finding::Better(change) = &found {
                    refinement.accept(change);
                    self.take(change);
                }
                findings.push(found);
            }
        }
        let (gathered, options) = (refinement.gathered(), RefinementOptions::default());
        assert!(gathered.used <= options.most_used && gathered.held_back <= options.most_held_back);
        findings
    }

    fn moment(
        &self,
        seconds: f64,
        lack: Lack,
        path: &dyn Fn(f64) -> Pose,
        noise: &mut Noise,
    ) -> Vec<ImageObservation> {
        let mut images = Vec::new();
        for at in [0.0, 0.033, 0.066, 0.099] {
            for (number, camera) in self.truth.cameras().iter().enumerate() {
                let stamp = seconds + at + self.stagger_s * number as f64;
                let seen = (&self.object, &path(stamp));
                images.push(image(camera, seen, stamp, lack, noise));
            }
        }
        images
    }

    /// A stamp of a camera whose clock is anything.
    fn stamped_wrongly(&self) -> ImageObservation {
        let (camera, mut noise) = (&self.truth.cameras()[0], Noise::seeded(1));
        let mut seen = image(camera, (&self.object, &slowly(0.0)), 0.0, SHARP, &mut noise);
        seen.capture_ns = u64::MAX;
        seen
    }

    fn take(&mut self, change: &Change) {
        self.rig = change.rig(&self.rig).unwrap();
        self.model = change.object(&self.model).unwrap();
    }

    /// Of a camera against the first, metres and radians.
    fn camera_error(&self, at: usize) -> (f64, f64) {
        let relative = |rig: &Rig| {
            let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
            pose(0).inverse() * pose(at)
        };
        let error = se3::difference(&relative(&self.rig), &relative(&self.truth));
        (
            error.fixed_rows::<3>(0).norm(),
            error.fixed_rows::<3>(3).norm(),
        )
    }
}

fn slowly(seconds: f64) -> Pose {
    carried(0.4 * seconds)
}

fn changes(findings: &[Finding]) -> Vec<&Change> {
    let changes = findings.iter().filter_map(|found| match found {
        Finding::Better(change) => Some(change),
        _ => None,
    });
    changes.collect()
}

/// A millimetre and a twentieth of a degree.
fn a_little() -> Pose {
    Isometry3::new(
        Vector3::new(0.6e-3, -0.6e-3, 0.5e-3),
        Vector3::new(0.0005, 0.0005, -0.0005),
    )
}

#[test]
fn a_camera_that_is_a_millimetre_off_comes_back() {
    let mut site = Site::with_camera_off(&a_little());
    let before = site.camera_error(2);
    let findings = site.used(5, SHARP, &slowly);
    let after = site.camera_error(2);
    assert!(
        after.0 < 0.25 * before.0 && after.1 < 0.25 * before.1,
        "{after:?} {findings:?}"
    );
    let changes = changes(&findings);
    assert_eq!(
        changes[0].part,
        Part::Camera(site.rig.cameras()[2].id.clone())
    );
    for change in changes {
        assert!(change.held_back.after_px < change.held_back.before_px);
    }
}

#[test]
fn a_perfect_calibration_stays_over_ten_minutes() {
    let mut site = Site::perfect();
    let findings = site.used(10, SHARP, &slowly);
    assert!(changes(&findings).is_empty(), "{findings:?}");
    assert!(findings.contains(&Finding::Fine), "{findings:?}");
}

#[test]
fn an_object_at_rest_changes_nothing() {
    let mut site = Site::with_camera_off(&a_little());
    let findings = site.used(10, SHARP, &|_| carried(1.0));
    assert!(
        findings.iter().all(|f| *f == Finding::TooLittle),
        "{findings:?}"
    );
}

#[test]
fn wrong_tags_and_noise_do_not_make_it_worse() {
    let lack = Lack {
        sigma_px: 0.4,
        wrong: 0.3,
    };
    let mut perfect = Site::perfect();
    let findings = perfect.used(10, lack, &slowly);
    assert!(changes(&findings).is_empty(), "{findings:?}");
    let mut site = Site::with_camera_off(&a_little());
    let before = site.camera_error(2);
    site.used(10, lack, &slowly);
    let after = site.camera_error(2);
    assert!(
        after.0 <= before.0 && after.1 <= before.1,
        "{before:?} {after:?}"
    );
}

#[test]
fn a_camera_that_was_bumped_is_named_and_left() {
    let mut site = Site::with_camera_off(&Isometry3::new(
        Vector3::new(0.008, 0.0, 0.0),
        Vector3::zeros(),
    ));
    let findings = site.used(5, SHARP, &slowly);
    let bumped = Part::Camera(site.rig.cameras()[2].id.clone());
    let named = |found: &Finding| matches!(found, Finding::TooFar { part, .. } if *part == bumped);
    assert!(findings.iter().any(named), "{findings:?}");
    assert!(changes(&findings).is_empty(), "{findings:?}");
}

#[test]
fn a_tag_that_sits_a_little_elsewhere_is_found() {
    let mut site = Site::perfect();
    site.model = crate::scene::changed(&wand(), |tag| {
        if tag.tag.id == 3 {
            let by = Isometry3::translation(0.0006, -0.0004, 0.0);
            tag.object_from_tag = tag.object_from_tag.map(|pose| pose * by);
        }
    });
    let findings = site.used(5, SHARP, &slowly);
    let changes = changes(&findings);
    assert!(
        matches!(&changes[0].part, Part::Tag { tag, .. } if tag.id == 3),
        "{findings:?}"
    );
    let place = |model: &ObjectModel| model.tags()[3].object_from_tag.unwrap().translation.vector;
    let error = (place(&site.model) - place(&site.object)).norm();
    assert!(error < 0.2e-3, "{error}");
}

#[test]
fn shutters_that_run_free_do_no_harm() {
    let mut perfect = Site::perfect();
    perfect.stagger_s = 0.007;
    let findings = perfect.used(5, SHARP, &slowly);
    assert!(changes(&findings).is_empty(), "{findings:?}");
    let mut site = Site::with_camera_off(&a_little());
    site.stagger_s = 0.007;
    let before = site.camera_error(2);
    let findings = site.used(5, SHARP, &slowly);
    let after = site.camera_error(2);
    assert!(
        after.0 < 0.5 * before.0 && after.1 < 0.5 * before.1,
        "{after:?} {findings:?}"
    );
}
