//! Programs that really run: shells that write images.

use std::fs;
use std::time::{Duration, Instant};

use super::*;
use crate::config::CommandLine;
use crate::source::ClockSource;

const PATIENCE: Duration = Duration::from_secs(60);

fn config(script: &str, format: StreamFormat) -> CommandConfig {
    CommandConfig {
        run: CommandLine::Words(["sh", "-c", script].map(str::to_owned).into()),
        format,
        resolution: Some([16, 16]),
        row_length: None,
        latency_ms: None,
    }
}

/// The images of a program until it ends, and how it ended.
fn run(config: &CommandConfig) -> (Vec<Vec<u8>>, SourceError) {
    let shutdown = Shutdown::manual().unwrap();
    let mut camera = open(config, &shutdown).unwrap();
    let mut pixels = vec![0; 16 * 16];
    let mut images = Vec::new();
    let deadline = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < deadline);
        match camera.next(&mut pixels, &shutdown) {
            Ok(Next::Image(capture)) => {
                assert_eq!(capture.sequence, images.len() as u64);
                images.push(pixels.clone());
            }
            Ok(_) => {}
            Err(end) => return (images, end),
        }
    }
}

#[test]
fn a_programs_images_arrive_and_its_end_is_reported_with_its_last_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("frames");
    let frames: Vec<u8> = (0..3).flat_map(|n| vec![n * 40; 16 * 16]).collect();
    fs::write(&file, frames).unwrap();
    let script = format!("cat {0} {0}; echo no more film >&2; exit 3", file.display());
    let (images, end) = run(&config(&script, StreamFormat::Grey));
    let greys: Vec<u8> = images.iter().map(|image| image[255]).collect();
    assert_eq!(greys, [0, 40, 80, 0, 40, 80]);
    let words = end.to_string();
    assert!(
        words.contains("exit status: 3") && words.contains("no more film"),
        "{words}"
    );
    assert_eq!(end.exit, Exit::Unavailable);
}

#[test]
fn images_that_waited_while_this_process_stood_still_are_dropped_and_counted() {
    let shutdown = Shutdown::manual().unwrap();
    let script = "for i in $(seq 400); do head -c 256 /dev/zero; sleep 0.04; done";
    let mut camera = open(&config(script, StreamFormat::Grey), &shutdown).unwrap();
    let mut next = || loop {
        if let Next::Image(capture) = camera.next(&mut [1; 256], &shutdown).unwrap() {
            return (capture, now_ns());
        }
    };
    let (mut before, _) = next();
    for _ in 0..20 {
        (before, _) = next();
    }
    std::thread::sleep(Duration::from_secs(1));
    let resumed_ns = now_ns();
    let (after, _) = next();
    // About 25 images waited in the pipe; the next one to be had is one that was waited for.
    assert!(after.sequence > before.sequence + 5, "{before:?} {after:?}");
    assert!(after.capture_ns > resumed_ns);
    let distances = (0..5).map(|_| next().0.capture_ns).collect::<Vec<_>>();
    assert!(
        distances
            .windows(2)
            .all(|pair| pair[1] - pair[0] > 20_000_000),
        "{distances:?}"
    );
}

#[test]
fn its_images_bear_times_of_arrival() {
    let shutdown = Shutdown::manual().unwrap();
    let mut command = config("head -c 256 /dev/zero; sleep 60", StreamFormat::Grey);
    for latency_ms in [None, Some(1000.0)] {
        command.latency_ms = latency_ms;
        let before_ns = now_ns();
        let mut camera = open(&command, &shutdown).unwrap();
        let capture = loop {
            if let Next::Image(capture) = camera.next(&mut [1; 256], &shutdown).unwrap() {
                break capture;
            }
        };
        assert_eq!(capture.clock, ClockSource::Arrival);
        let latency_ns = latency_ms.map_or(0, |_| 1_000_000_000);
        let arrived_ns = capture.capture_ns + latency_ns;
        assert!((before_ns..=now_ns()).contains(&arrived_ns));
    }
}

#[test]
fn a_stream_may_say_its_own_size() {
    let script = "printf 'YUV4MPEG2 W18 H16 F30:1 Cmono\\nFRAME\\n'; head -c 288 /dev/zero";
    let command = CommandConfig {
        resolution: None,
        ..config(script, StreamFormat::Y4m)
    };
    let camera = open(&command, &Shutdown::manual().unwrap()).unwrap();
    assert_eq!(camera.resolution(), [18, 16]);
    let refused = |script: &str| {
        let command = CommandConfig {
            resolution: None,
            ..config(script, StreamFormat::Y4m)
        };
        open(&command, &Shutdown::manual().unwrap()).err().unwrap()
    };
    let error = refused("echo no stream at all");
    assert!(error.to_string().contains("no YUV4MPEG2 stream"), "{error}");
    let error = refused("printf 'YUV4MPEG2 W8 H8 Cmono\\n'; sleep 60");
    assert!(
        error.to_string().contains("an image of 8x8 pixels"),
        "{error}"
    );
    let error = refused("echo out of order >&2");
    assert!(error.to_string().contains("out of order"), "{error}");
}

#[test]
fn a_program_that_is_not_there_is_wrong_input() {
    let command = CommandConfig {
        run: CommandLine::Text("/nowhere/camera --fast".to_owned()),
        ..config("", StreamFormat::Grey)
    };
    let error = open(&command, &Shutdown::manual().unwrap()).err().unwrap();
    assert_eq!(error.exit, Exit::Input);
    assert!(error.to_string().contains("is it installed"), "{error}");
    assert!(program::locate("sh").is_some() && program::locate("no-such-program").is_none());
}

#[test]
fn a_program_ends_with_its_camera_and_with_all_that_it_started() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pid");
    let script = format!(
        "sleep 60 & echo $! > {}; head -c 256 /dev/zero; wait",
        file.display()
    );
    let shutdown = Shutdown::manual().unwrap();
    let mut camera = open(&config(&script, StreamFormat::Grey), &shutdown).unwrap();
    while camera.next(&mut [0; 256], &shutdown).unwrap() == Next::Nothing {}
    let pid = fs::read_to_string(&file).unwrap();
    drop(camera);
    let deadline = Instant::now() + PATIENCE;
    loop {
        let status = fs::read_to_string(format!("/proc/{}/stat", pid.trim())).unwrap_or_default();
        if status.is_empty() || status.contains(") Z ") {
            break;
        }
        assert!(Instant::now() < deadline, "{status}");
    }
}

#[test]
fn an_endless_line_and_a_closed_error_output_harm_nothing() {
    let script = "head -c 100000 /dev/zero | tr '\\0' x >&2; exec 2>&-; head -c 512 /dev/zero";
    let (images, end) = run(&config(script, StreamFormat::Grey));
    assert_eq!(images.len(), 2);
    assert!(end.to_string().len() < 1000, "{end}");
}
