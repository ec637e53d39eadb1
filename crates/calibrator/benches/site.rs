//! What the calibration of a site from nothing reaches, on simulated recordings: a line a seed with the largest errors
//! and how many reported standard deviations they are.
//!
//! `cargo bench -p sextant-calibrator --bench site -- [triggered|free|rolling] [first seed] [seeds]`.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a program that measures may panic and print, and takes what it needs of the tests' scenes"
)]

#[path = "../tests/procedures/scene.rs"]
mod scene;
#[path = "../tests/procedures/site_errors.rs"]
mod site_errors;
#[path = "../tests/procedures/site_scene.rs"]
mod site_scene;

use sextant_calibrator::SiteSession;
use site_errors::SiteErrors;
use site_scene::{SiteKind, site};
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let number = |at: usize, usual: u64| {
        let text = arguments.get(at);
        text.and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let kinds = [
        ("triggered", SiteKind::TRIGGERED),
        ("free", SiteKind::FREE),
        (
            "rolling",
            SiteKind {
                readout_s: 0.015,
                ..SiteKind::FREE
            },
        ),
        (
            "rolling30",
            SiteKind {
                readout_s: 0.030,
                ..SiteKind::FREE
            },
        ),
        (
            "triggered15",
            SiteKind {
                readout_s: 0.015,
                ..SiteKind::TRIGGERED
            },
        ),
        (
            "triggered30",
            SiteKind {
                readout_s: 0.030,
                ..SiteKind::TRIGGERED
            },
        ),
        (
            "still",
            SiteKind {
                n_still: 3,
                ..SiteKind::TRIGGERED
            },
        ),
    ];
    println!(
        "kind         seed   cameras mm    deg sigmas   focal % sigmas   tags mm    deg   clock \
         ms sigmas   line delay % sigmas   seconds"
    );
    for (name, kind) in kinds {
        if arguments
            .first()
            .is_some_and(|wanted| wanted != name && wanted != "all")
        {
            continue;
        }
        let first = number(1, 0);
        for seed in first..first + number(2, 4) {
            let truth = site(kind, seed);
            let mut session = SiteSession::new(truth.plan()).unwrap();
            let start = Instant::now();
            truth.images.iter().for_each(|image| session.handle(image));
            match session.solve() {
                Err(error) => println!("{name:12} {seed:4}   {error}"),
                Ok(found) => {
                    let errors = SiteErrors::measure(&found, &truth);
                    println!(
                        "{name:12} {seed:4} {:12.3} {:6.3} {:6.2} {:9.3} {:6.2} {:9.3} {:6.3} \
                         {:10.3} {:6.2} {:14.2} {:6.2} {:9.1}",
                        errors.camera_mm,
                        errors.camera_deg,
                        errors.camera_sigmas,
                        errors.focal_percent,
                        errors.focal_sigmas,
                        errors.tag_mm,
                        errors.tag_deg,
                        errors.clock_ms,
                        errors.clock_sigmas,
                        errors.line_delay_percent,
                        errors.line_delay_sigmas,
                        start.elapsed().as_secs_f64()
                    );
                    if std::env::var("WORDS").is_ok() {
                        println!("{}", found.report.verdict);
                        for c in &found.report.cameras {
                            println!("{c:?}");
                        }
                        for c in &found.report.objects {
                            println!("{c:?}");
                        }
                    }
                }
            }
        }
    }
}
