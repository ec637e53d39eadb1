//! The DRP against a driver with all its traps.

#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

mod board;

use board::{Board, Event, Fault, circuit_data};
use proptest::prelude::*;
use sextant_drp_circuits::{Circuit, Raster};
use sextant_rza2m::drp::{
    CircuitData, DrpError, Pipeline, PipelineError, SelfTest, Session, requests,
};
use sextant_rza2m::{Accelerated, Cpu, DrpDevice, OnChipLayout, PhysicalMemory, Preprocess};
use sextant_simulator::Random;
use std::time::Duration;

const SIZE: [usize; 2] = [64, 48];
const PIXELS: usize = SIZE[0] * SIZE[1];

fn layout(circuits: &[CircuitData]) -> OnChipLayout {
    let sizes: Vec<usize> = circuits.iter().map(|circuit| circuit.bytes.len()).collect();
    OnChipLayout::plan(PIXELS, &sizes).unwrap()
}

fn accelerated(
    board: &Board,
    circuits: Vec<CircuitData>,
) -> Result<(Accelerated<Board>, Vec<SelfTest>), PipelineError> {
    let layout = layout(&circuits);
    Accelerated::start(board.clone(), &mut board.clone(), circuits, SIZE, layout)
}

fn refusal(board: &Board, circuits: Vec<CircuitData>) -> String {
    accelerated(board, circuits).err().unwrap().to_string()
}

fn image(seed: u32) -> Vec<u8> {
    let mut random = Random::new(seed.into());
    (0..PIXELS).map(|_| random.bits() as u8).collect()
}

/// What models make of an image, one after the other.
fn expected(raw: &[u8], models: &[(Circuit, usize)]) -> Vec<u8> {
    models.iter().fold(raw.to_vec(), |image, (circuit, model)| {
        let mut out = vec![0; PIXELS];
        circuit.models()[*model]
            .run(&Raster::new(&image, SIZE).unwrap(), &mut out)
            .unwrap();
        out
    })
}

fn bayer(model: u8) -> CircuitData {
    circuit_data(Circuit::Bayer2Grayscale, model)
}

#[test]
fn each_interpretation_is_recognised_and_followed() {
    for model in 0..5 {
        let board = Board::new();
        let (mut drp, tests) = accelerated(&board, vec![bayer(model)]).unwrap();
        let standing = Circuit::Bayer2Grayscale.models()[usize::from(model)].standing();
        assert_eq!(tests[0].fitting().unwrap().standing(), standing);
        let (raw, at) = (image(1), 0x8000_0000);
        board.clone().copy_in(at, &raw).unwrap();
        let mut grey = vec![0; PIXELS];
        drp.run(&mut board.clone(), at, &mut grey).unwrap();
        assert_eq!(
            grey,
            expected(&raw, &[(Circuit::Bayer2Grayscale, model.into())])
        );
        assert_eq!(Preprocess::<Board>::fallbacks(&drp), 0);
        assert_eq!(board.violations(), [""; 0]);
    }
}

#[test]
fn circuits_follow_one_another() {
    let board = Board::new();
    let circuits = vec![
        bayer(1),
        circuit_data(Circuit::MedianBlur, 0),
        circuit_data(Circuit::GaussianBlur, 1),
    ];
    let (mut drp, tests) = accelerated(&board, circuits).unwrap();
    assert_eq!(tests.len(), 3);
    let raw = image(2);
    board.clone().copy_in(0x8000_0000, &raw).unwrap();
    let mut grey = vec![0; PIXELS];
    drp.run(&mut board.clone(), 0x8000_0000, &mut grey).unwrap();
    let models = [
        (Circuit::Bayer2Grayscale, 1),
        (Circuit::MedianBlur, 0),
        (Circuit::GaussianBlur, 1),
    ];
    assert_eq!(grey, expected(&raw, &models));
    assert_eq!(Preprocess::<Board>::fallbacks(&drp), 0);
}

/// The other way from a mosaic to grey, which is the same for every order of colours.
#[test]
fn a_gaussian_may_come_first() {
    let board = Board::new();
    let gaussian = circuit_data(Circuit::GaussianBlur, 0);
    let (mut drp, _) = accelerated(&board, vec![gaussian]).unwrap();
    let flat: Vec<u8> = (0..PIXELS)
        .map(|i| [[200, 120], [120, 40]][i / SIZE[0] % 2][i % 2])
        .collect();
    board.clone().copy_in(0x8000_0000, &flat).unwrap();
    let mut grey = vec![0; PIXELS];
    drp.run(&mut board.clone(), 0x8000_0000, &mut grey).unwrap();
    assert_eq!(grey, [120; PIXELS]);
}

#[test]
fn a_circuit_that_follows_no_model_is_refused() {
    let refusal = refusal(&Board::new(), vec![bayer(99)]);
    assert!(
        refusal.starts_with("no model fits: Bayer2Grayscale: interpretation 1"),
        "{refusal}"
    );
    assert!(
        refusal.contains("interpretation 5") && refusal.contains("differs in"),
        "{refusal}"
    );
}

#[test]
fn data_of_another_circuit_is_refused() {
    let mut data = circuit_data(Circuit::MedianBlur, 0);
    data.circuit = Circuit::Bayer2Grayscale;
    assert!(refusal(&Board::new(), vec![data]).starts_with("no model fits"));
}

#[test]
fn unusable_circuits_are_refused_with_a_cause() {
    let mut data = bayer(0);
    data.bytes[0] = 0;
    assert_eq!(
        refusal(&Board::new(), vec![data]),
        "LOAD: the driver answers -2 (wrong format of circuit data)"
    );
    let median = circuit_data(Circuit::MedianBlur, 0);
    for circuits in [
        vec![],
        vec![median.clone()],
        vec![bayer(0), bayer(0)],
        vec![median, bayer(0)],
    ] {
        let refusal = refusal(&Board::new(), circuits);
        assert!(refusal.contains("the first circuit must be"), "{refusal}");
    }
}

#[test]
fn what_a_crashed_process_left_is_unloaded() {
    let board = Board::new();
    let (first, _) = accelerated(&board, vec![bayer(0)]).unwrap();
    drop(first);
    assert!(accelerated(&board, vec![bayer(2)]).is_ok());
    assert_eq!(board.violations(), [""; 0]);
}

#[test]
fn new_data_in_an_old_place_is_what_is_loaded() {
    let board = Board::new();
    for model in [0, 3, 1] {
        let (_, tests) = accelerated(&board, vec![bayer(model)]).unwrap();
        let standing = Circuit::Bayer2Grayscale.models()[usize::from(model)].standing();
        assert_eq!(tests[0].fitting().unwrap().standing(), standing);
    }
    let maps = board
        .0
        .borrow()
        .requests
        .iter()
        .filter(|number| **number == requests::MAP)
        .count();
    assert_eq!(maps, 3);
}

fn session(board: &Board) -> Session<Board> {
    let mut session = Session::open(board.clone()).unwrap();
    board.clone().copy_in(0x8010_0000, &bayer(0).bytes).unwrap();
    session.load(0x8010_0000, 0..6).unwrap();
    session
}

fn is_guarded<T: std::fmt::Debug>(result: Result<T, DrpError>) -> bool {
    matches!(result, Err(DrpError::Guarded { .. }))
}

#[test]
fn harmful_requests_are_not_made() {
    let board = Board::new();
    let mut session = session(&board);
    let before = board.0.borrow().requests.len();
    assert!(
        is_guarded(session.wait(Duration::from_millis(1))),
        "a mask of no tile"
    );
    assert!(
        is_guarded(session.start(6, &[0; 16])),
        "a tile that is not there"
    );
    assert!(is_guarded(session.start(0, &[])), "no parameters");
    assert!(
        is_guarded(session.start(0, &[0; 245])),
        "parameters beyond the driver's buffer"
    );
    assert!(is_guarded(session.load(0x8010_0000, 0..1)), "tiles in use");
    session.clear().unwrap();
    let cleared = board.0.borrow().requests.len();
    assert!(
        is_guarded(session.start(0, &[0; 16])),
        "a tile without a circuit: identifier 0"
    );
    assert!(
        is_guarded(session.load(0x8010_0010, 0..1)),
        "data that is not aligned"
    );
    assert!(
        is_guarded(session.load(0x4000_0000, 0..1)),
        "data outside on-chip memory"
    );
    assert!(
        is_guarded(session.load(0x8010_0000, 5..7)),
        "a seventh tile"
    );
    assert_eq!(
        (cleared - before, board.0.borrow().requests.len()),
        (1, cleared)
    );
    assert_eq!(board.violations(), [""; 0]);
}

#[test]
fn timeouts_stay_within_what_the_driver_can_compute() {
    let board = Board::new();
    let mut session = session(&board);
    let (source, destination) = (0x8000_0000_u32, 0x8008_0000_u32);
    let mut parameters = [source.to_le_bytes(), destination.to_le_bytes()].concat();
    parameters.extend([64, 0, 8, 0, 1, 1, 0, 0]);
    session.start(0, &parameters).unwrap();
    session.wait(Duration::from_secs(3600)).unwrap();
    assert_eq!(board.violations(), [""; 0]);
}

/// The traps are there: a client without a guard runs into each.
#[test]
fn the_fake_has_the_traps() {
    let traps: [(u32, &[u32], &str); 6] = [
        (requests::START, &[0, 16], "for ever"),
        (requests::START, &[1, 249], "stack"),
        (requests::WAIT, &[1, 4295, 0], "overflows"),
        (requests::GETINFO, &[0], "pointer"),
        (requests::MAP, &[0x2000_0000, 64, 0], "null"),
        (0x8004_c12d, &[0x77], ""),
    ];
    for (number, words, violation) in traps {
        let mut board = Board::new();
        let mut ask = |number, words: &[u32]| {
            let mut record = [0xee; requests::RECORD_BYTES];
            for (bytes, word) in record.chunks_exact_mut(4).zip(words) {
                bytes.copy_from_slice(&word.to_le_bytes());
            }
            let is_ok = board.request(number, &mut record).is_ok();
            (is_ok, i32::from_le_bytes(record[..4].try_into().unwrap()))
        };
        ask(requests::INIT, &[]);
        ask(requests::MAP, &[0x2000_0000, 64, 1]);
        let (is_ok, result) = ask(number, words);
        assert!(is_ok);
        let violations = board.violations();
        match violation {
            "" => assert_eq!(result, 0x77, "an unknown request answers nothing"),
            _ => assert!(
                violations.len() == 1 && violations[0].contains(violation),
                "{violations:?}"
            ),
        }
    }
    let mut board = Board::new();
    let mut ask = |number| {
        let mut record = [0; requests::RECORD_BYTES];
        board.request(number, &mut record).unwrap();
        i32::from_le_bytes(record[..4].try_into().unwrap())
    };
    assert_eq!(
        [
            requests::INIT,
            requests::UNINIT,
            requests::INIT,
            requests::UNLOAD
        ]
        .map(&mut ask),
        [0, 0, 0, -9]
    );
    assert_eq!(ask(requests::INACTIVATE), -6);
}

#[test]
fn a_circuit_that_does_not_end_blocks_everything_but_unloading() {
    let board = Board::new();
    let mut session = session(&board);
    board.0.borrow_mut().faults =
        |_, number, _| (number == requests::START).then_some(Fault::Endless);
    session.start(0, &[0; 16]).unwrap();
    assert!(matches!(
        session.wait(Duration::from_millis(5)),
        Err(DrpError::Timeout(_))
    ));
    assert!(is_guarded(session.start(0, &[0; 16])) && is_guarded(session.start(1, &[0; 16])));
    assert!(is_guarded(session.wait(Duration::from_millis(5))));
    session.clear().unwrap();
    assert!(session.load(0x8010_0000, 0..6).is_ok());
}

#[test]
fn a_driver_that_does_not_know_a_request_is_found_out() {
    for unknown in [
        requests::INIT,
        requests::MAP,
        requests::UNLOAD,
        requests::LOAD,
        requests::ACTIVATE,
        requests::START,
        requests::WAIT,
    ] {
        let board = Board::new();
        {
            let mut state = board.0.borrow_mut();
            state.seed = unknown.into();
            state.faults = |_, number, seed| (u64::from(number) == seed).then_some(Fault::Unknown);
        }
        let refusal = refusal(&board, vec![bayer(0)]);
        assert!(
            refusal.contains("no answer that is known"),
            "{unknown:#x}: {refusal}"
        );
    }
}

/// Runs images and asserts that each is right, whoever made it.
fn run_images(drp: &mut Accelerated<Board>, board: &Board, n: u32, model: usize) -> u64 {
    let mut grey = vec![0; PIXELS];
    for i in 0..n {
        let raw = image(i);
        board.clone().copy_in(0x8000_0000, &raw).unwrap();
        drp.run(&mut board.clone(), 0x8000_0000, &mut grey).unwrap();
        assert_eq!(
            grey,
            expected(&raw, &[(Circuit::Bayer2Grayscale, model)]),
            "image {i}"
        );
    }
    Preprocess::<Board>::fallbacks(drp)
}

#[test]
fn every_kind_of_failure_is_taken_over_by_the_cpu_and_recovered_from() {
    for (kind, fault) in [
        Fault::Call,
        Fault::Refused(-9),
        Fault::Unknown,
        Fault::Endless,
        Fault::Late,
        Fault::Idle,
        Fault::Partial,
    ]
    .into_iter()
    .enumerate()
    {
        let board = Board::new();
        let (mut drp, _) = accelerated(&board, vec![bayer(4)]).unwrap();
        {
            let mut state = board.0.borrow_mut();
            // The fourth band of the third image, once.
            state.seed = (state.requests.len() as u64 + 2 * 7 + 3) << 3 | kind as u64;
            state.faults = |place, _, seed| {
                const KINDS: [Fault; 7] = [
                    Fault::Call,
                    Fault::Refused(-9),
                    Fault::Unknown,
                    Fault::Endless,
                    Fault::Late,
                    Fault::Idle,
                    Fault::Partial,
                ];
                (place == seed >> 3).then_some(KINDS[(seed & 7) as usize])
            };
        }
        assert_eq!(run_images(&mut drp, &board, 2, 4), 0);
        let fallbacks = run_images(&mut drp, &board, 100, 4);
        // The image itself and the pause after it; then the DRP works again.
        assert_eq!(fallbacks, 31, "{fault:?}");
        let failure = Preprocess::<Board>::take_failure(&mut drp);
        assert!(failure.is_some() && Preprocess::<Board>::take_failure(&mut drp).is_none());
        assert_eq!(board.violations(), [""; 0]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// Requests fail at random, in every way: no image is wrong, nothing harmful is asked, and the number of requests
    /// stays bounded.
    #[test]
    fn no_failure_spoils_an_image(seed in any::<u64>(), rate in 1_u64..40) {
        let board = Board::new();
        let (mut drp, _) = accelerated(&board, vec![bayer(1)]).unwrap();
        let started = board.0.borrow().requests.len();
        {
            let mut state = board.0.borrow_mut();
            state.seed = seed << 8 | rate;
            state.faults = |place, _, seed| {
                let mut random = Random::from_keys(&[seed, place]);
                (random.below(100) < (seed & 0xff) as usize).then(|| match random.below(7) {
                    0 => Fault::Call,
                    1 => Fault::Refused(-(random.below(11) as i32) - 1),
                    2 => Fault::Unknown,
                    3 => Fault::Endless,
                    4 => Fault::Late,
                    5 => Fault::Idle,
                    _ => Fault::Partial,
                })
            };
        }
        let fallbacks = run_images(&mut drp, &board, 120, 1);
        prop_assert!(fallbacks <= 120);
        let asked = board.0.borrow().requests.len() - started;
        // Seven requests an image; an attempt to recover adds at most fifteen.
        prop_assert!(asked <= 120 * 7 + 40 * 15, "{}", asked);
        prop_assert_eq!(board.violations(), Vec::<String>::new());
    }
}

#[test]
fn attempts_become_rarer_while_they_are_in_vain() {
    let board = Board::new();
    let (mut drp, _) = accelerated(&board, vec![bayer(0)]).unwrap();
    board.0.borrow_mut().faults = |_, _, _| Some(Fault::Call);
    let before = board.0.borrow().requests.len();
    assert_eq!(run_images(&mut drp, &board, 1000, 0), 1000);
    // After 0, 31, 92, 213, 454 and 935 images.
    assert_eq!(board.0.borrow().requests.len() - before, 6);
}

#[test]
fn the_cpu_gives_what_the_likeliest_circuit_gives() {
    let board = Board::new();
    let raw = image(5);
    board.clone().copy_in(0x8000_0000, &raw).unwrap();
    let (mut cpu, mut drp_grey, mut cpu_grey) = (Cpu::new(SIZE), vec![0; PIXELS], vec![0; PIXELS]);
    cpu.run(&mut board.clone(), 0x8000_0000, &mut cpu_grey)
        .unwrap();
    let (mut drp, _) = accelerated(&board, vec![bayer(0)]).unwrap();
    board.clone().copy_in(0x8000_0000, &raw).unwrap();
    drp.run(&mut board.clone(), 0x8000_0000, &mut drp_grey)
        .unwrap();
    assert_eq!(cpu_grey, drp_grey);
    assert!(
        cpu.run(&mut board.clone(), 0x8000_0000, &mut [0; 7])
            .is_err()
    );
}

#[test]
fn bands_of_every_size_agree_with_the_whole_image() {
    for (width, height) in [(16, 8), (20, 10), (64, 50), (128, 480), (640, 478)] {
        let (board, circuits) = (Board::new(), vec![bayer(0)]);
        let layout = OnChipLayout::plan(width * height, &[1000]).unwrap();
        let session = Session::open(board.clone()).unwrap();
        let started = Pipeline::start(
            session,
            &mut board.clone(),
            circuits,
            [width, height],
            layout,
        );
        assert!(started.is_ok(), "{width}x{height}: {:?}", started.err());
        assert!(
            board
                .0
                .borrow()
                .events
                .iter()
                .all(|event| !matches!(event, Event::Pause(_)))
        );
        assert_eq!(board.violations(), [""; 0]);
    }
}
