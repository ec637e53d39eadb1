//! Detection, image by image, on one thread, as a whole, by stages, and as a sequence of images; with the feature
//! `peer` also AprilTag's own detector in C.

use criterion::Criterion;
use sextant_apriltag::{Detector, Image, Options, Refinement, Stage, Tracker};
use sextant_benches::{HEIGHT, Picture, StageClock, WIDTH, pictures};
use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    let pictures = pictures()?;
    bench(
        &mut criterion,
        "sextant",
        Refinement::Photometric,
        &pictures,
    )?;
    bench(
        &mut criterion,
        "sextant, edges only",
        Refinement::Edges,
        &pictures,
    )?;
    bench_tracking(&mut criterion, &pictures)?;
    bench_stages(&mut criterion, &pictures)?;
    #[cfg(feature = "peer")]
    bench_peer(&mut criterion, &pictures);
    criterion.final_summary();
    Ok(())
}

fn bench(
    criterion: &mut Criterion,
    title: &str,
    refinement: Refinement,
    pictures: &[Picture],
) -> Result<(), Box<dyn Error>> {
    let mut detector = Detector::new(Options {
        refinement,
        ..Options::default()
    })?;
    let mut group = criterion.benchmark_group(title);
    for picture in pictures {
        let image = Image::new(&picture.pixels, WIDTH, HEIGHT, WIDTH)?;
        group.bench_function(picture.name, |bencher| {
            bencher.iter(|| detector.detect(black_box(&image)).len());
        });
    }
    Ok(())
}

/// The same image again and again, so that all of its tags are where they were.
fn bench_tracking(criterion: &mut Criterion, pictures: &[Picture]) -> Result<(), Box<dyn Error>> {
    let mut group = criterion.benchmark_group("sextant, tracking");
    for picture in pictures {
        let mut tracker = Tracker::new(Options::default())?;
        let image = Image::new(&picture.pixels, WIDTH, HEIGHT, WIDTH)?;
        group.bench_function(picture.name, |bencher| {
            bencher.iter(|| tracker.detect(black_box(&image)).len());
        });
    }
    Ok(())
}

fn bench_stages(criterion: &mut Criterion, pictures: &[Picture]) -> Result<(), Box<dyn Error>> {
    let mut detector = Detector::new(Options::default())?;
    for stage in Stage::ALL {
        let mut group = criterion.benchmark_group(format!("sextant, stage {stage:?}"));
        group
            .sample_size(20)
            .measurement_time(Duration::from_secs(1));
        for picture in pictures {
            let image = Image::new(&picture.pixels, WIDTH, HEIGHT, WIDTH)?;
            group.bench_function(picture.name, |bencher| {
                bencher.iter_custom(|n| {
                    let mut time = Duration::ZERO;
                    for _ in 0..n {
                        let mut clock = StageClock::start();
                        detector.detect_observed(black_box(&image), &mut clock);
                        time += clock.time(stage);
                    }
                    // A stage that an image does not need takes no time, which criterion can't draw.
                    time.max(Duration::from_nanos(n))
                });
            });
        }
    }
    Ok(())
}

#[cfg(feature = "peer")]
fn bench_peer(criterion: &mut Criterion, pictures: &[Picture]) {
    for (title, min_contrast) in [("AprilTag C", 5), ("AprilTag C, contrast 20", 20)] {
        let mut peer = sextant_benches::Peer::new(min_contrast);
        let mut group = criterion.benchmark_group(title);
        group.sample_size(20);
        for picture in pictures {
            group.bench_function(picture.name, |bencher| {
                bencher.iter(|| peer.detect(black_box(&picture.pixels), WIDTH));
            });
        }
    }
}
