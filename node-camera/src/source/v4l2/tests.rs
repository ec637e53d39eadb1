//! The camera against a device of software.

use std::collections::BTreeMap;

use sextant_process::clock::monotonic_ns;

use super::device::ControlKind::{Boolean, Integer, Menu};
use super::fake::{FakeDevice, FakeImage, Offered, control};
use super::*;
use crate::source::ClockSource;

const SIZE: [u32; 2] = [32, 16];
const MONOTONIC: u32 = 0x2000;
const START_OF_EXPOSURE: u32 = 0x10000;

fn config() -> V4l2Config {
    V4l2Config {
        device: "/dev/fake".into(),
        resolution: SIZE,
        format: None,
        rate_hz: None,
        exposure_us: None,
        gain: None,
        readout_us: None,
        controls: BTreeMap::new(),
    }
}

fn start(device: &FakeDevice) -> V4l2Camera<FakeDevice> {
    start_with(device, &config()).unwrap()
}

fn start_with(
    device: &FakeDevice,
    config: &V4l2Config,
) -> Result<V4l2Camera<FakeDevice>, SourceError> {
    V4l2Camera::start(device.clone(), config)
}

fn refusal(device: &FakeDevice, config: &V4l2Config) -> String {
    start_with(device, config).err().unwrap().to_string()
}

fn grey(sequence: u32) -> FakeImage {
    FakeImage {
        bytes: vec![sequence as u8; 32 * 16],
        sequence,
        flags: MONOTONIC,
        timestamp: [1, 0],
    }
}

/// Takes one image.
fn next(camera: &mut V4l2Camera<FakeDevice>) -> Result<(Next, Vec<u8>), SourceError> {
    let mut pixels = vec![0; 32 * 16];
    let shutdown = Shutdown::manual().unwrap();
    let next = camera.next(&mut pixels, &shutdown)?;
    Ok((next, pixels))
}

fn sequence(camera: &mut V4l2Camera<FakeDevice>) -> Option<u64> {
    match next(camera).unwrap() {
        (Next::Image(capture), _) => Some(capture.sequence),
        _ => None,
    }
}

#[test]
fn what_is_no_camera_is_refused_with_a_remedy() {
    let refusal = |path: &str| {
        let config = V4l2Config {
            device: path.into(),
            ..config()
        };
        open(&config).err().unwrap().to_string()
    };
    assert!(refusal("/dev/video-none").contains("is it plugged in?"));
    assert!(refusal("/dev/null").contains("is it a camera?"));
}

#[test]
fn images_of_every_raw_layout_arrive() {
    let cases: [(&[u8; 4], usize, u32); 5] = [
        (b"GREY", 1, 0),
        (b"GREY", 1, 7),
        (b"YUYV", 2, 6),
        (b"Y10 ", 2, 0),
        (b"NV12", 1, 0),
    ];
    for (fourcc, bytes_a_pixel, padding) in cases {
        for api in [Api::SinglePlanar, Api::MultiPlanar] {
            let device = FakeDevice::with(&[(*fourcc, SIZE, 30)], |state| {
                (state.api, state.padding) = (api, padding);
            });
            let mut camera = start(&device);
            let row = 32 * bytes_a_pixel + padding as usize;
            device.push(FakeImage {
                bytes: (0..row * 16 * 2).map(|n| (n % row) as u8).collect(),
                ..grey(0)
            });
            let (taken, pixels) = next(&mut camera).unwrap();
            assert!(matches!(taken, Next::Image(_)));
            let expected = |x: usize| match fourcc {
                b"YUYV" => (2 * x) as u8,
                b"Y10 " => ((2 * x + ((2 * x + 1) << 8)) >> 2) as u8,
                _ => x as u8,
            };
            for (n, pixel) in pixels.iter().enumerate() {
                assert_eq!(*pixel, expected(n % 32), "{fourcc:?} {n}");
            }
        }
    }
}

#[test]
fn the_best_format_that_is_fast_enough_is_chosen() {
    let chosen = |offered: &[Offered], config: &V4l2Config| {
        let device = FakeDevice::new(offered);
        Setup::choose(&device, config).unwrap().format.fourcc
    };
    let offered = [
        (*b"MJPG", SIZE, 60),
        (*b"YUYV", SIZE, 10),
        (*b"H264", SIZE, 90),
    ];
    assert_eq!(chosen(&offered, &config()), *b"YUYV");
    let fast = |rate_hz| V4l2Config {
        rate_hz: Some(rate_hz),
        ..config()
    };
    assert_eq!(chosen(&offered, &fast(10.0)), *b"YUYV");
    assert_eq!(chosen(&offered, &fast(30.0)), *b"MJPG");
    assert_eq!(chosen(&offered, &fast(100.0)), *b"YUYV");
    let stated = V4l2Config {
        format: Some("MJPG".to_owned()),
        ..config()
    };
    assert_eq!(chosen(&offered, &stated), *b"MJPG");
}

#[test]
fn a_camera_that_lists_nothing_is_asked_for_each_format() {
    let device = FakeDevice::with(&[(*b"UYVY", SIZE, 30)], |state| state.lists = false);
    assert_eq!(
        Setup::choose(&device, &config()).unwrap().format.fourcc,
        *b"UYVY"
    );
}

#[test]
fn what_a_camera_does_not_have_is_refused_with_what_it_has() {
    let offered = [
        (*b"YUYV", [640, 480], 30),
        (*b"YUYV", [320, 240], 30),
        (*b"MJPG", [1280, 720], 30),
    ];
    let words = refusal(&FakeDevice::new(&offered), &config());
    assert!(words.contains("no 32x16 image"), "{words}");
    assert!(
        words.contains("YUYV 640x480 320x240; MJPG 1280x720"),
        "{words}"
    );
    let stated = V4l2Config {
        format: Some("GREY".to_owned()),
        ..config()
    };
    let words = refusal(&FakeDevice::new(&offered), &stated);
    assert!(words.contains("no 32x16 image in GREY"), "{words}");
    let words = refusal(&FakeDevice::new(&[(*b"H264", SIZE, 30)]), &config());
    assert!(words.contains("it has H264 only"), "{words}");
    assert!(refusal(&FakeDevice::new(&[]), &config()).contains("does not say what it has"));
}

#[test]
fn lost_and_damaged_images_leave_gaps() {
    let device = FakeDevice::new(&[(*b"GREY", SIZE, 30)]);
    let mut camera = start(&device);
    device.push(grey(5));
    device.push(FakeImage {
        flags: MONOTONIC | FLAG_ERROR,
        ..grey(6)
    });
    device.push(FakeImage {
        bytes: vec![0; 100],
        ..grey(7)
    });
    device.push(grey(10));
    let sequences: Vec<_> = (0..4).map(|_| sequence(&mut camera)).collect();
    assert_eq!(sequences, [Some(0), None, None, Some(5)]);
}

#[test]
fn buffers_go_round_for_ever() {
    let device = FakeDevice::new(&[(*b"GREY", SIZE, 30)]);
    let mut camera = start(&device);
    for number in 0..100 {
        device.push(grey(number));
        let (_, pixels) = next(&mut camera).unwrap();
        assert_eq!(pixels[0], number as u8);
    }
    assert_eq!(sequence(&mut camera), None);
    drop(camera);
    assert!(!device.state.is_streaming.get());
}

#[test]
fn a_drivers_stamp_becomes_the_middle_of_the_exposure() {
    let device = FakeDevice::with(&[(*b"GREY", SIZE, 30)], |state| {
        let exposure = control(0x009a_0902, "Exposure Time, Absolute", Integer, [1, 500]);
        state.controls.get_mut().push(exposure);
    });
    let config = V4l2Config {
        exposure_us: Some(10_000),
        readout_us: Some(20_000),
        ..config()
    };
    let mut camera = start_with(&device, &config).unwrap();
    let now_ns = monotonic_ns();
    let timestamp = [
        (now_ns / 1_000_000_000) as i64,
        (now_ns % 1_000_000_000 / 1000) as i64,
    ];
    for flags in [MONOTONIC, MONOTONIC | START_OF_EXPOSURE] {
        device.push(FakeImage {
            flags,
            timestamp,
            ..grey(0)
        });
    }
    let mut captures = Vec::new();
    for _ in 0..2 {
        let (Next::Image(capture), _) = next(&mut camera).unwrap() else {
            panic!("no image")
        };
        assert_eq!(capture.exposure_ns, 10_000_000);
        assert_ne!(capture.clock, ClockSource::Arrival);
        captures.push(capture.capture_ns as i64);
    }
    let apart_ns = captures[1] - captures[0];
    assert!((apart_ns - 30_000_000).abs() < 5_000_000, "{apart_ns}");
}

#[test]
fn without_a_drivers_stamp_the_time_is_that_of_arrival() {
    let device = FakeDevice::new(&[(*b"GREY", SIZE, 30)]);
    let mut camera = start(&device);
    device.push(FakeImage {
        flags: 0,
        ..grey(0)
    });
    let (Next::Image(capture), _) = next(&mut camera).unwrap() else {
        panic!("no image")
    };
    assert_eq!(capture.clock, ClockSource::Arrival);
    assert!(capture.clock_error_ns >= 200_000_000);
}

#[test]
fn a_camera_that_vanishes_or_changes_ends_as_unavailable() {
    for failure in [libc::ENODEV, libc::EIO] {
        let device = FakeDevice::new(&[(*b"GREY", SIZE, 30)]);
        let mut camera = start(&device);
        device.state.failure.set(Some(failure));
        let error = next(&mut camera).unwrap_err();
        assert_eq!(error.exit, Exit::Unavailable);
        let unplugged = error.to_string().contains("it was unplugged");
        assert_eq!(unplugged, failure == libc::ENODEV, "{error}");
    }
    let device = FakeDevice::new(&[(*b"GREY", SIZE, 30)]);
    let mut camera = start(&device);
    device.state.is_changed.set(true);
    assert_eq!(next(&mut camera).unwrap_err().exit, Exit::Unavailable);
}

fn webcam() -> FakeDevice {
    FakeDevice::with(&[(*b"GREY", SIZE, 30)], |state| {
        *state.controls.get_mut() = vec![
            control(0x0098_0913, "Gain", Integer, [0, 64]),
            control(0x009a_0901, "Auto Exposure", Menu, [0, 3]),
            control(0x009a_0902, "Exposure Time, Absolute", Integer, [1, 500]),
            control(0x009a_0903, "Exposure, Dynamic Framerate", Boolean, [0, 1]),
            control(0x009a_090a, "Focus, Absolute", Integer, [0, 250]),
            control(0x009a_090c, "Focus, Automatic Continuous", Boolean, [0, 1]),
        ];
    })
}

#[test]
fn switches_are_set_before_what_they_free() {
    let device = webcam();
    let config = V4l2Config {
        rate_hz: Some(30.0),
        exposure_us: Some(4_000),
        gain: Some(200),
        controls: [
            ("focus_absolute".to_owned(), 12),
            ("focus_automatic_continuous".to_owned(), 0),
        ]
        .into(),
        ..config()
    };
    let camera = start_with(&device, &config).unwrap();
    let controls = camera.controls().unwrap();
    assert_eq!(controls.gain.value, Some(64.0));
    assert_eq!(controls.rate_hz.range, Some([30.0; 2]));
    let set = device.state.set.borrow();
    let place = |wanted: (u32, i32)| set.iter().position(|done| *done == wanted).unwrap();
    assert!(place((0x009a_0901, 1)) < place((0x009a_0902, 40)));
    assert!(place((0x009a_090c, 0)) < place((0x009a_090a, 12)));
    place((0x009a_0903, 0));
    // Beyond the range: the nearest.
    place((0x0098_0913, 64));
    let rate_hz = device.state.interval.get().unwrap().rate_hz().unwrap();
    assert!((rate_hz - 30.0).abs() < 1e-6);
}

#[test]
fn a_control_that_is_wrong_is_named() {
    let with = |name: &str, value| V4l2Config {
        controls: [(name.to_owned(), value)].into(),
        ..config()
    };
    let words = refusal(&webcam(), &with("fokus", 0));
    assert!(
        words.contains("source.controls.fokus") && words.contains("focus_absolute"),
        "{words}"
    );
    let words = refusal(&webcam(), &with("focus_absolute", 999));
    assert!(words.contains("999 is not from 0 to 250"), "{words}");
}

#[test]
fn settings_change_while_the_camera_runs() {
    let device = webcam();
    let mut camera = start(&device);
    let changed = |change: fn(&mut V4l2Config)| {
        let mut config = config();
        change(&mut config);
        SourceConfig::V4l2(config)
    };
    let outcome = camera.reconfigure(&changed(|config| config.exposure_us = Some(2_000)));
    assert_eq!(outcome.unwrap(), Reconfigured::Done);
    assert_eq!(device.state.set.borrow().last(), Some(&(0x009a_0902, 20)));
    device.push(grey(0));
    let (Next::Image(capture), _) = next(&mut camera).unwrap() else {
        panic!("no image")
    };
    assert_eq!(capture.exposure_ns, 2_000_000);
    let exposure = |camera: &V4l2Camera<FakeDevice>| camera.controls().unwrap().exposure_us;
    assert_eq!(exposure(&camera).value, Some(2000.0));
    assert_eq!(exposure(&camera).range, Some([100.0, 50_000.0]));
    camera.reconfigure(&changed(|_| {})).unwrap();
    let automatic = (0x009a_0901, 0);
    assert_eq!(device.state.set.borrow().last(), Some(&automatic));
    assert_eq!(exposure(&camera).value, None);
    let wrong = camera.reconfigure(&changed(|config| {
        config.controls.insert("fokus".to_owned(), 1);
    }));
    assert!(wrong.is_err());
    for (change, expected) in [
        (
            changed(|config| config.rate_hz = Some(60.0)),
            Reconfigured::NeedsReopening,
        ),
        (
            changed(|config| config.resolution = [64, 16]),
            Reconfigured::NeedsRestart,
        ),
        (SourceConfig::images("/r"), Reconfigured::NeedsRestart),
    ] {
        assert_eq!(camera.reconfigure(&change).unwrap(), expected);
    }
}

#[test]
fn a_probe_lists_everything_and_writes_a_file_that_is_right() {
    let device = FakeDevice::with(
        &[
            (*b"MJPG", [1280, 720], 60),
            (*b"MJPG", [1280, 720], 30),
            (*b"MJPG", [1920, 1080], 30),
            (*b"YUYV", [1280, 720], 10),
            (*b"YUYV", [640, 480], 30),
            (*b"H264", [1280, 720], 90),
        ],
        |state| state.controls = webcam().state.controls.clone(),
    );
    let camera = probe::describe(&device, Path::new("/dev/fake"))
        .unwrap()
        .unwrap();
    let text = camera.to_string();
    for part in [
        "Fake Camera",
        "1280x720  60 30",
        "H264 (not read here)",
        "gain = 0",
        "1: Manual Mode",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let toml = camera.first_config().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("camera.toml");
    std::fs::write(&file, &toml).unwrap();
    let read = crate::CameraNodeConfig::read(&file).unwrap();
    let expected = V4l2Config {
        resolution: [1280, 720],
        format: Some("MJPG".to_owned()),
        rate_hz: Some(30.0),
        controls: [("focus_automatic_continuous".to_owned(), 0)].into(),
        ..config()
    };
    assert_eq!(read.source, SourceConfig::V4l2(expected), "{toml}");
}

#[test]
fn what_captures_nothing_is_no_camera() {
    let mut identity = FakeDevice::new(&[]).identity().unwrap();
    assert!(api_of(&identity).is_ok());
    identity.abilities = CAP_VIDEO_CAPTURE;
    assert!(api_of(&identity).unwrap_err().contains("does not stream"));
    identity.abilities = CAP_STREAMING;
    assert!(api_of(&identity).unwrap_err().contains("does not capture"));
}
