//! Repeats one detection, to be counted by callgrind or timed at its best: `repeat write DIR` makes the images,
//! `repeat DETECTOR FILE N` works on one of them, DETECTOR being sextant, edges,
//! tracking (best mean of nine images, a round of its scan), stages (best of each), raw (grey made of the image as a
//! Bayer mosaic, which comes before detection on an RZ/A2M), or with the feature `peer` c or c20.

use sextant_apriltag::{Detector, Image, Options, Refinement, Stage, Tracker};
use sextant_benches::{HEIGHT, StageClock, WIDTH, pictures};
use sextant_drp_circuits::{Circuit, Raster};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

type RunResult = Result<(), Box<dyn Error>>;

fn main() -> RunResult {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", folder] => write(Path::new(folder)),
        [detector, file, n] => repeat(detector, &fs::read(file)?, n.parse()?),
        _ => Err("repeat write DIR | repeat sextant|edges|tracking|stages|raw|c|c20 FILE N".into()),
    }
}

/// Bare pixels, a file an image.
fn write(folder: &Path) -> RunResult {
    fs::create_dir_all(folder)?;
    for picture in pictures()? {
        let name = picture.name.replace(", ", "-").replace(' ', "-");
        fs::write(folder.join(name), picture.pixels)?;
    }
    Ok(())
}

fn repeat(detector: &str, pixels: &[u8], n: u32) -> RunResult {
    match detector {
        "sextant" => ours(Refinement::Photometric, pixels, n),
        "edges" => ours(Refinement::Edges, pixels, n),
        "tracking" => tracking(pixels, n),
        "stages" => stages(pixels, n),
        "raw" => raw(pixels, n),
        #[cfg(feature = "peer")]
        "c" | "c20" => {
            let mut peer = sextant_benches::Peer::new(if detector == "c" { 5 } else { 20 });
            print_best(n, || peer.detect(pixels, WIDTH));
            Ok(())
        }
        _ => Err(format!("no detector named {detector} was built").into()),
    }
}

fn ours(refinement: Refinement, pixels: &[u8], n: u32) -> RunResult {
    let mut detector = Detector::new(Options {
        refinement,
        ..Options::default()
    })?;
    let image = Image::new(pixels, WIDTH, HEIGHT, WIDTH)?;
    print_best(n, || detector.detect(&image).len());
    Ok(())
}

/// Each image is processed in nine variants, one after the other.
fn tracking(pixels: &[u8], n: u32) -> RunResult {
    const ROUND: u32 = 9;
    let mut tracker = Tracker::new(Options::default())?;
    let image = Image::new(pixels, WIDTH, HEIGHT, WIDTH)?;
    let (mut best, mut tags) = (Duration::MAX, tracker.detect(&image).len());
    for _ in 0..n.div_ceil(ROUND) {
        let start = Instant::now();
        for _ in 0..ROUND {
            tags = tracker.detect(&image).len();
        }
        best = best.min(start.elapsed() / ROUND);
    }
    print(tags, n, best);
    Ok(())
}

fn stages(pixels: &[u8], n: u32) -> RunResult {
    let mut detector = Detector::new(Options::default())?;
    let image = Image::new(pixels, WIDTH, HEIGHT, WIDTH)?;
    let mut best = [Duration::MAX; Stage::ALL.len()];
    for _ in 0..n {
        let mut clock = StageClock::start();
        detector.detect_observed(&image, &mut clock);
        for (best, stage) in best.iter_mut().zip(Stage::ALL) {
            *best = (*best).min(clock.time(stage));
        }
    }
    for (best, stage) in best.iter().zip(Stage::ALL) {
        print!("{stage:?} {:.1} us  ", best.as_secs_f64() * 1e6);
    }
    println!();
    Ok(())
}

fn raw(pixels: &[u8], n: u32) -> RunResult {
    let model = &Circuit::Bayer2Grayscale.models()[0];
    let mosaic = Raster::new(pixels, [WIDTH, HEIGHT])?;
    let mut grey = vec![0; pixels.len()];
    let mut outcome = Ok(());
    print_best(n, || {
        outcome = model.run(&mosaic, &mut grey);
        0
    });
    Ok(outcome?)
}

fn print_best(n: u32, mut detect: impl FnMut() -> usize) {
    let (mut best, mut tags) = (Duration::MAX, 0);
    for _ in 0..n {
        let start = Instant::now();
        tags = detect();
        best = best.min(start.elapsed());
    }
    print(tags, n, best);
}

fn print(tags: usize, n: u32, best: Duration) {
    println!(
        "{tags} tags, best of {n}: {:.1} us",
        best.as_secs_f64() * 1e6
    );
}
