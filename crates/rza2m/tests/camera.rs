//! The camera path against a board that checks order and values.

#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

mod board;

use board::{Board, Event};
use sextant_rza2m::{Camera, CameraError, CameraSettings, Frame, OnChipLayout, PhysicalMemory};
use std::time::Duration;

const MS: u64 = 1_000_000;
const SETTINGS: CameraSettings = CameraSettings {
    resolution: [640, 480],
    rate_hz: None,
    exposure_us: 5000,
    gain: 4.0,
};

fn layout() -> OnChipLayout {
    OnChipLayout::plan(640 * 480, &[]).unwrap()
}

fn start(board: &Board, settings: CameraSettings) -> Result<Camera<Board>, CameraError> {
    Camera::start(&mut board.clone(), board.clone(), &layout(), settings)
}

/// A started camera and a sensor that sends images of a period.
struct Running {
    board: Board,
    camera: Camera<Board>,
    period_ns: u64,
    now_ns: u64,
    sent: u64,
}

impl Running {
    fn new(settings: CameraSettings, period_ns: u64) -> Self {
        let board = Board::new();
        let camera = start(&board, settings).unwrap();
        Self {
            board,
            camera,
            period_ns,
            now_ns: 1_000_000 * MS,
            sent: 0,
        }
    }

    /// A millisecond, with what the sensor sends in it, and a poll.
    fn poll(&mut self) -> Option<Frame> {
        self.pass(1);
        self.camera.poll(&self.board, self.now_ns).unwrap()
    }

    /// Milliseconds without a poll.
    fn pass(&mut self, ms: u64) {
        self.now_ns += ms * MS;
        while (self.sent + 1) * self.period_ns <= self.now_ns - 1_000_000 * MS {
            self.sent += 1;
            self.board.deliver(&self.sent.to_le_bytes());
        }
    }

    fn next(&mut self) -> Frame {
        (0..10_000).find_map(|_| self.poll()).unwrap()
    }

    /// When the newest image was complete.
    fn sent_ns(&self) -> u64 {
        1_000_000 * MS + self.sent * self.period_ns
    }
}

#[test]
fn modules_are_set_up_in_their_order() {
    let board = Board::new();
    start(&board, SETTINGS).unwrap();
    let events = board.0.borrow().events.clone();
    let registers = |from: usize| {
        let events = events[from..].iter();
        events.filter_map(|event| match event {
            Event::Register(register, value) => Some((*register, *value)),
            _ => None,
        })
    };
    // Clocks first: VIN is module 66, the receiver 75.
    assert_eq!(
        registers(0).take(2).collect::<Vec<_>>(),
        [(0xfcfe_042c, 0xbf), (0xfcfe_0430, 0xdf)]
    );
    let place = |event: Event| events.iter().rposition(|e| *e == event).unwrap();
    let order = [
        place(Event::Register(0xe803_f008, 0)),           // VIN stops
        place(Event::Sensor(0x0103, 1)),                  // sensor reset
        place(Event::Pause(Duration::from_millis(10))),   // and time for it
        place(Event::Sensor(0x0114, 1)),                  // two lanes
        place(Event::Sensor(0x018c, 8)),                  // RAW8
        place(Event::Pause(Duration::from_millis(5))),    // receiver in reset
        place(Event::Register(0xe820_9010, 0x011e_802a)), // data type RAW8
        place(Event::Register(0xe820_9008, 0x0003_0013)), // receiver on
        place(Event::Pause(Duration::from_millis(25))),
        place(Event::Register(0xe820_9038, 0xc0)),
        place(Event::Sensor(0x0100, 1)), // images from here on
        place(Event::Register(0xe803_f030, 0x8000_0000)), // into three buffers
        place(Event::Register(0xe803_f034, 0x8004_b000)),
        place(Event::Register(0xe803_f038, 0x8009_6000)),
        place(Event::Register(0xe803_f000, 0x3004_000b)), // VIN on
        place(Event::Register(0xe803_f008, 2)),           // continuously
    ];
    assert!(order.is_sorted(), "{order:?}");
    assert_eq!(order[15], events.len() - 1);
    assert_eq!(board.violations(), [""; 0]);
    // A gain of 4 is the demonstration's register value.
    assert_eq!(board.0.borrow().sensor[&0x0157], 0xc0);
}

#[test]
fn exposure_and_rate_are_set_in_lines_of_the_measured_period() {
    // 1080 lines in 27 ms: 25 us a line.
    let mut running = Running::new(
        CameraSettings {
            rate_hz: Some(20.0),
            ..SETTINGS
        },
        27 * MS,
    );
    while running.board.0.borrow().sensor.get(&0x0160) == Some(&0x04) {
        assert_eq!(running.poll(), None);
    }
    let pair = |register: u16| {
        let sensor = &running.board.0.borrow().sensor;
        u16::from_be_bytes([sensor[&register], sensor[&(register + 1)]])
    };
    assert!(pair(0x0160).abs_diff(2000) < 10, "{}", pair(0x0160));
    assert!(pair(0x015a).abs_diff(200) < 2, "{}", pair(0x015a));
}

#[test]
fn the_time_of_an_image_is_the_middle_of_its_middle_rows_exposure() {
    let mut running = Running::new(SETTINGS, 27 * MS);
    for _ in 0..50 {
        let frame = running.next();
        // 480 rows of 25 us and 5 ms of exposure.
        let expected_ns = running.sent_ns() - (12_000_000 + 5_000_000) / 2;
        assert!(
            frame.exposed_ns.abs_diff(expected_ns) < 600_000,
            "{}",
            frame.exposed_ns.abs_diff(expected_ns)
        );
        assert!(frame.exposure_ns.abs_diff(5_000_000) < 30_000);
        assert_eq!(frame.tolerance_ns, MS / 2);
    }
    assert!((running.camera.rate_hz().unwrap() - 1000.0 / 27.0).abs() < 0.1);
}

#[test]
fn each_image_is_handed_over_once_from_the_buffer_that_holds_it() {
    let mut running = Running::new(SETTINGS, 20 * MS);
    let first = running.next();
    assert_eq!(first.number, 0);
    for number in 1..40 {
        let frame = running.next();
        assert_eq!(frame.number, number);
        let mut image = [0; 8];
        running.board.copy_out(frame.address, &mut image).unwrap();
        assert_eq!(u64::from_le_bytes(image), running.sent);
    }
}

#[test]
fn images_that_pass_during_a_pause_are_counted_as_lost() {
    let mut running = Running::new(SETTINGS, 20 * MS);
    let (mut last, mut sent) = (running.next().number, running.sent);
    for pause_ms in [25, 45, 90, 130, 210, 20] {
        running.pass(pause_ms);
        let frame = running.next();
        assert_eq!(frame.number - last, running.sent - sent);
        (last, sent) = (frame.number, running.sent);
    }
}

#[test]
fn an_image_that_is_overwritten_while_it_is_read_is_found_out() {
    let mut running = Running::new(SETTINGS, 20 * MS);
    let is_whole = |running: &Running, frame: &Frame| {
        running
            .camera
            .is_whole(&running.board, frame, running.now_ns)
            .unwrap()
    };
    for (pause_ms, whole) in [(0, true), (25, true), (45, false), (62, false), (65, false)] {
        let frame = running.next();
        running.pass(pause_ms);
        assert_eq!(is_whole(&running, &frame), whole, "after {pause_ms} ms");
    }
}

#[test]
fn a_missing_sensor_is_named_with_a_remedy() {
    let board = Board::new();
    board.0.borrow_mut().sensor_answers = false;
    let refusal = start(&board, SETTINGS).unwrap_err().to_string();
    assert!(
        refusal.contains("0x10") && refusal.contains("ribbon cable"),
        "{refusal}"
    );
    // Nothing was touched.
    assert!(board.0.borrow().events.is_empty());
    let board = Board::new();
    board.0.borrow_mut().sensor.insert(1, 0x33);
    assert!(
        start(&board, SETTINGS)
            .unwrap_err()
            .to_string()
            .contains("0x0233")
    );
}

#[test]
fn a_sensor_without_images_is_named_after_two_seconds() {
    let board = Board::new();
    let mut camera = start(&board, SETTINGS).unwrap();
    for ms in 0..=2000 {
        assert_eq!(camera.poll(&board, ms * MS).unwrap(), None);
    }
    let error = camera.poll(&board, 2001 * MS).unwrap_err();
    assert!(matches!(error, CameraError::NoImage), "{error}");
}

#[test]
fn a_vin_that_does_not_stop_is_refused() {
    let board = Board::new();
    board.0.borrow_mut().registers.insert(0xe803_f004, 1);
    assert!(matches!(start(&board, SETTINGS), Err(CameraError::Busy)));
}

#[test]
fn settings_out_of_range_are_refused() {
    for settings in [
        CameraSettings {
            resolution: [640, 481],
            ..SETTINGS
        },
        CameraSettings {
            resolution: [650, 480],
            ..SETTINGS
        },
        CameraSettings {
            resolution: [832, 480],
            ..SETTINGS
        },
        CameraSettings {
            resolution: [0, 0],
            ..SETTINGS
        },
        CameraSettings {
            rate_hz: Some(f64::NAN),
            ..SETTINGS
        },
        CameraSettings {
            exposure_us: 0,
            ..SETTINGS
        },
        CameraSettings {
            gain: f64::NAN,
            ..SETTINGS
        },
    ] {
        assert!(
            matches!(
                start(&Board::new(), settings),
                Err(CameraError::Settings(_))
            ),
            "{settings:?}"
        );
    }
}

#[test]
fn stopping_leaves_sensor_and_modules_at_rest() {
    let board = Board::new();
    let mut camera = start(&board, SETTINGS).unwrap();
    camera.stop(&mut board.clone()).unwrap();
    let state = board.0.borrow();
    assert_eq!(state.sensor[&0x0100], 0);
    assert_eq!(
        [0xe803_f008, 0xe820_9008].map(|register| state.registers[&register]),
        [0, 0]
    );
    assert_eq!(state.registers[&0xe803_f000] & 1, 0);
}
