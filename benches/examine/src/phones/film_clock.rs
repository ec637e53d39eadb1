//! When the film of each camera began by the times that the browser gave its images, at the start and at the end of a
//! recording.
//!
//! Chromium shows every image of a film, each at least a period after the last one: a film falls behind wherever the
//! machine has no time for it, and never catches up. Then its camera's clock is not constant, and poses are off for a
//! reason that no real camera has.

use sextant_proto::Observations;
use sextant_recordings::mcap::site_recording::Timed;
use sextant_simulator::{Scenario, SceneCamera};

/// Length of start and end, ns.
const PART_NS: u64 = 10_000_000_000;
/// Images with which it is sought in each.
const MOST_IMAGES: usize = 60;
const STEPS_NS: [u64; 4] = [20_000_000, 2_000_000, 200_000, 20_000];
/// Squared distance as which a corner counts at most, px^2.
const MOST_SQUARE: f64 = 25.0;

/// Prints a line a camera: when its film began, relative to the first one's, and by how much it fell behind.
pub fn print(scenario: &Scenario, observations: &[Timed<Observations>]) {
    let mut first_ns = None;
    for camera in &scenario.cameras {
        let own = observations.iter().map(|timed| &timed.item);
        let own = own.filter(|image| image.camera.as_str() == camera.id && !image.tags.is_empty());
        let mut own: Vec<&Observations> = own.collect();
        own.sort_by_key(|image| image.capture_ns);
        let (Some(first), Some(last)) = (own.first(), own.last()) else {
            continue;
        };
        let [until_ns, from_ns] = [first.capture_ns + PART_NS, last.capture_ns - PART_NS];
        let n_first = own.partition_point(|image| image.capture_ns < until_ns);
        let n_last = own.partition_point(|image| image.capture_ns < from_ns);
        let half_ns = period_ns(scenario) / 2;
        let start_ns = began_ns(
            scenario,
            camera,
            &own[..n_first],
            first.capture_ns - half_ns,
            half_ns,
        );
        let end_ns = began_ns(scenario, camera, &own[n_last..], start_ns, half_ns);
        let ms_after = |ns: u64, before_ns: u64| ns.wrapping_sub(before_ns) as i64 as f64 * 1e-6;
        println!(
            "{}: its film began after {:+.2} ms, and fell {:.2} ms behind",
            camera.id,
            ms_after(start_ns, *first_ns.get_or_insert(start_ns)),
            ms_after(end_ns, start_ns)
        );
    }
}

/// The period of all paths and films, ns.
pub fn period_ns(scenario: &Scenario) -> u64 {
    let periods = scenario.objects.iter().map(|object| object.path.period_s);
    (periods.fold(0.0, f64::max) * 1e9) as u64
}

/// Sought within a reach about a time, ns.
fn began_ns(
    scenario: &Scenario,
    camera: &SceneCamera,
    images: &[&Observations],
    near_ns: u64,
    reach_ns: u64,
) -> u64 {
    let step = images.len().div_ceil(MOST_IMAGES).max(1);
    let some: Vec<&Observations> = images.iter().step_by(step).copied().collect();
    let (mut best_ns, mut reach_ns) = (near_ns, reach_ns);
    for step_ns in STEPS_NS {
        let times = (best_ns - reach_ns..=best_ns + reach_ns).step_by(step_ns as usize);
        let costs = times.map(|began_ns| (cost(scenario, camera, &some, began_ns), began_ns));
        let least = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        (best_ns, reach_ns) = (least.map_or(best_ns, |(_, at_ns)| at_ns), step_ns);
    }
    best_ns
}

/// Sum of the squared distances of corners from where they are in the film, px^2.
fn cost(scenario: &Scenario, camera: &SceneCamera, images: &[&Observations], began_ns: u64) -> f64 {
    let camera_from_world = camera.world_from_camera.inverse();
    let mut sum = 0.0;
    for image in images {
        let film_ns = image.capture_ns.saturating_sub(began_ns);
        for seen in &image.tags {
            let objects = scenario.objects.iter();
            let tag = objects
                .flat_map(|object| object.tags.iter().map(move |tag| (object, tag)))
                .find(|(_, tag)| (tag.family, tag.id) == (seen.family, seen.id));
            let Some((object, tag)) = tag else { continue };
            for (corner, at) in tag.corners_in_object().iter().zip(seen.corners) {
                let [x, y] = at.map(f64::from);
                let row_ns = (camera.row_after_s(y) * 1e9) as i64;
                let world_from_object =
                    object.world_from_object(film_ns.saturating_add_signed(row_ns));
                let pixel = camera.project(&(camera_from_world * world_from_object * corner));
                let square = pixel.map_or(MOST_SQUARE, |pixel| {
                    (pixel.x - x).powi(2) + (pixel.y - y).powi(2)
                });
                sum += square.min(MOST_SQUARE);
            }
        }
    }
    sum
}
