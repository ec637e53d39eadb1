//! Sites that are calibrated from nothing but sizes.

use crate::scene::tag;
use crate::site_errors::SiteErrors;
use crate::site_scene::{SimulatedSite, SiteKind, site};
use sextant_calibrator::{
    CalibratedSite, Finding, Grade, MeasuredDistance, SiteError, SitePlan, SiteSession,
};
use sextant_site_model::ImageObservation;

const SHORT: SiteKind = SiteKind {
    seconds: 24.0,
    rate_hz: 10.0,
    ..SiteKind::TRIGGERED
};

fn solved(plan: SitePlan, images: &[ImageObservation]) -> Result<CalibratedSite, SiteError> {
    let mut session = SiteSession::new(plan)?;
    images.iter().for_each(|image| session.handle(image));
    session.solve()
}

fn calibrated(truth: &SimulatedSite) -> CalibratedSite {
    solved(truth.plan(), &truth.images).unwrap()
}

#[test]
fn unknown_lenses_objects_and_cameras_are_found() {
    for seed in [40, 41] {
        let truth = site(SHORT, seed);
        let found = calibrated(&truth);
        let errors = SiteErrors::measure(&found, &truth);
        assert!(
            errors.camera_mm < 2.0 && errors.camera_deg < 0.1,
            "{errors:?}"
        );
        assert!(errors.focal_percent < 0.1, "{errors:?}");
        assert!(errors.tag_mm < 0.2 && errors.tag_deg < 0.2, "{errors:?}");
        assert!(
            errors.camera_sigmas < 3.0 && errors.focal_sigmas < 3.5,
            "{errors:?}"
        );
        assert_eq!(found.report.world, "camera a");
    }
}

#[test]
fn free_running_cameras_get_their_clocks() {
    let kind = SiteKind {
        seconds: 24.0,
        rate_hz: 15.0,
        ..SiteKind::FREE
    };
    let truth = site(kind, 42);
    let found = calibrated(&truth);
    let errors = SiteErrors::measure(&found, &truth);
    assert!(!found.report.synchronised);
    assert!(
        errors.camera_mm < 3.0 && errors.camera_deg < 0.15,
        "{errors:?}"
    );
    assert!(
        errors.camera_sigmas < 3.0 && errors.focal_percent < 0.2,
        "{errors:?}"
    );
    assert!(
        errors.clock_ms < 0.3 && errors.clock_sigmas < 4.0,
        "{errors:?}"
    );
}

#[test]
fn static_tags_are_the_world_and_distances_the_scale() {
    let truth = site(
        SiteKind {
            n_still: 2,
            ..SHORT
        },
        43,
    );
    let found = calibrated(&truth);
    assert!(["tag36h11:30", "tag36h11:31"].contains(&found.report.world.as_str()));
    let room = found
        .objects
        .iter()
        .find(|object| object.id().as_str() == "room");
    assert_eq!(room.unwrap().tags().len(), 2);
    // All prints are 1 % larger than given, as a measured distance shows.
    let place = |at: usize| truth.objects[0].tags()[at].object_from_tag.unwrap();
    let apart = (place(0).translation.vector - place(1).translation.vector).norm();
    let mut plan = truth.plan();
    plan.size_m /= 1.01;
    plan.world = Some(tag(31));
    plan.distances = vec![MeasuredDistance {
        tags: [tag(0), tag(1)],
        distance_m: apart,
        sigma_m: 1e-5,
    }];
    let found = solved(plan, &truth.images).unwrap();
    assert_eq!(found.report.world, "tag36h11:31");
    assert!(
        (found.report.scale_factor - 1.01).abs() < 0.002,
        "{:?}",
        found.report
    );
    assert!(found.report.scale_sigma < 0.001);
    assert!(SiteErrors::measure(&found, &truth).camera_mm < 3.0);
}

#[test]
fn what_was_too_little_is_named() {
    let truth = site(SHORT, 44);
    let last = truth.rig.cameras()[3].id.clone();
    let mut images = truth.images.clone();
    for (n, image) in images.iter_mut().enumerate() {
        // The body is only before the first camera, and of the cube the last camera sees nothing.
        let is_first = image.camera == truth.rig.cameras()[0].id;
        image.tags.retain(|seen| is_first || seen.tag.id < 10);
        if image.camera == last {
            image.tags.clear();
        }
        // A tag that shows up by itself.
        if let (true, Some(lone)) = (n % 7 == 0, truth.images[n].tags.last()) {
            let mut lone = lone.clone();
            lone.tag = tag(77);
            if is_first {
                image.tags = vec![lone];
            }
        }
    }
    let found = solved(truth.plan(), &images).unwrap();
    let verdict = &found.report.verdict;
    let has = |wanted: fn(&Finding) -> bool| verdict.because.iter().any(wanted);
    assert!(
        has(|f| matches!(f, Finding::UnsharedObject(_))),
        "{verdict}"
    );
    assert!(
        has(|f| matches!(f, Finding::UnassignedTags(_))),
        "{verdict}"
    );
    assert!(
        found
            .report
            .unsolved
            .iter()
            .any(|cause| cause.contains("camera d"))
    );
    // Nothing is known of a camera that saw nothing, its lens neither.
    assert!(found.rig.camera(&last).is_none());
    assert_eq!(found.report.cameras.len(), 3);
}

#[test]
fn what_cannot_give_a_site_is_refused_with_its_cause() {
    let truth = site(
        SiteKind {
            seconds: 5.0,
            ..SHORT
        },
        45,
    );
    let refused = |plan: SitePlan, images: &[ImageObservation]| {
        solved(plan, images).err().map(|error| error.to_string())
    };
    let mut blind = truth.images.clone();
    blind.iter_mut().for_each(|image| image.tags.clear());
    let error = refused(truth.plan(), &blind).unwrap();
    assert!(error.contains("none shows a tag"), "{error}");
    let error = refused(truth.plan(), &truth.images[..1]).unwrap();
    assert!(
        error.contains("none of them moved") || error.contains("shows a tag"),
        "{error}"
    );
    let plan = SitePlan {
        world: Some(tag(3)),
        ..truth.plan()
    };
    let error = refused(plan, &truth.images).unwrap();
    assert!(error.contains("it moves"), "{error}");
    let apart = MeasuredDistance {
        tags: [tag(0), tag(12)],
        distance_m: 0.1,
        sigma_m: 0.001,
    };
    let plan = SitePlan {
        distances: vec![apart],
        ..truth.plan()
    };
    let error = refused(plan, &truth.images).unwrap();
    assert!(error.contains("move relative to each other"), "{error}");
}

#[test]
fn given_sizes_that_contradict_each_other_are_named_with_their_ratio() {
    let truth = site(SHORT, 46);
    let mut plan = truth.plan();
    let wrong = truth.objects[0]
        .tags()
        .iter()
        .map(|tag| (tag.tag, 0.82 * tag.size_m));
    plan.sizes = wrong.collect();
    let found = solved(plan, &truth.images).unwrap();
    let verdict = &found.report.verdict;
    assert_eq!(verdict.grade, Grade::Poor);
    let contradiction = verdict.because.iter().find_map(|finding| match finding {
        Finding::SizesContradict { object, by, ratio } => {
            Some((object.clone(), by.clone(), *ratio))
        }
        _ => None,
    });
    let (object, by, ratio) = contradiction.unwrap();
    let ratio = if object < by { ratio } else { 1.0 / ratio };
    assert!((ratio * 0.82 - 1.0).abs() < 0.02, "{object} {by} {ratio}");
}
