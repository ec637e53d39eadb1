//! Tracks of many objects go on in parallel, and the result is the same on any number of processors.

use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::{ImageObservation, ObjectModel, ObjectTag, TagId};
use sextant_site_report::ObjectEstimate;

use crate::scene::{Eye, Random, START_NS, cube, path, poses, rig};

const OBJECTS: u32 = 12;

/// A cube with tags of its own.
fn numbered(k: u32) -> ObjectModel {
    let tag = |tag: &ObjectTag| {
        let id = tag.tag.id + 6 * k;
        ObjectTag::new(TagId { id, ..tag.tag }, tag.size_m, tag.object_from_tag)
    };
    let id = format!("cube{k}").parse().unwrap();
    ObjectModel::new(id, cube().tags().iter().map(tag).collect()).unwrap()
}

fn images(objects: &[ObjectModel]) -> Vec<ImageObservation> {
    let (rig, mut random) = (rig(3), Random(3));
    let times = (0..40_u64).flat_map(|n| (0..3).map(move |camera| (camera, n)));
    let image = |(camera, n): (usize, u64)| {
        let time_ns = START_NS + n * 33_333_333 + camera as u64 * 7_000_000;
        let seconds = (time_ns - START_NS) as f64 * 1e-9;
        let seen = objects.iter().zip(0..).map(|(object, k)| {
            let eye = Eye {
                rig: &rig,
                object,
                sigma_px: 0.1,
            };
            let aside = Pose::translation(0.05 * f64::from(k) - 0.3, 0.02 * f64::from(k % 5), 0.0);
            eye.image(camera, time_ns, &(aside * path(seconds)), &mut random)
        });
        let all: Vec<ImageObservation> = seen.collect();
        let tags = all.iter().flat_map(|image| image.tags.clone()).collect();
        ImageObservation {
            tags,
            ..all[0].clone()
        }
    };
    times.map(image).collect()
}

/// On so many threads, with files that are to be adjusted.
fn fused(
    images: &[ImageObservation],
    objects: &[ObjectModel],
    threads: usize,
) -> Vec<ObjectEstimate> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(|| {
        let mut fusion = Fusion::new(rig(3), objects.to_vec(), FusionOptions::default()).unwrap();
        let mut said = Vec::new();
        for image in images {
            fusion.handle(image.capture_ns + 10_000_000, Input::Image(image.clone()));
            said.extend(poses(&mut fusion));
        }
        said
    })
}

#[test]
fn the_poses_of_many_objects_do_not_depend_on_the_number_of_threads() {
    let objects: Vec<ObjectModel> = (0..OBJECTS).map(numbered).collect();
    let images = images(&objects);
    let alone = fused(&images, &objects, 1);
    assert!(alone.len() > 100 * OBJECTS as usize, "{}", alone.len());
    for threads in [2, 7] {
        assert_eq!(
            fused(&images, &objects, threads),
            alone,
            "{threads} threads"
        );
    }
}
