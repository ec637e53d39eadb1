//! Any bytes may arrive: decoding them never panics, never takes more memory than the limits say, and never lets a
//! number through that is not finite. Random bytes, random bodies behind a good header, mutated and cut messages, huge
//! lengths.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod samples;

use proptest::prelude::*;
use sextant_proto::limits::{MAX_DECODED_BYTES, MAX_PAYLOAD_BYTES};
use sextant_proto::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, which also knows how much this thread holds and held at most.
struct Counting;

thread_local! {
    static HELD: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
}

fn held(grown: usize, freed: usize) {
    let _ = HELD.try_with(|held| {
        held.set(held.get().wrapping_add(grown).wrapping_sub(freed));
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(held.get())));
    });
}

// SAFETY: every call goes to the system's allocator unchanged; the counters are thread-local cells that never allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        held(layout.size(), 0);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        held(0, layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(memory, layout) }
    }
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Old and new may both be held for a moment.
        held(size, 0);
        held(0, layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn memory_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    HELD.set(1 << 30);
    PEAK.set(1 << 30);
    let result = work();
    (result, PEAK.get() - (1 << 30))
}

fn taken_safely<M: Message>(payload: &[u8]) {
    let (decoded, memory) = memory_of(|| decode::<M>(payload));
    assert!(
        memory <= MAX_DECODED_BYTES,
        "{memory} bytes for a {:?}",
        M::KIND
    );
    if let Ok(message) = decoded {
        message.check().unwrap();
        encode(&message).unwrap();
    }
}

fn every_kind_takes_safely(payload: &[u8]) {
    taken_safely::<Observations>(payload);
    taken_safely::<Preview>(payload);
    taken_safely::<CameraStatus>(payload);
    taken_safely::<CameraSettings>(payload);
    taken_safely::<DetectionReport>(payload);
    taken_safely::<ClockReport>(payload);
    taken_safely::<ConfigAnswer>(payload);
    taken_safely::<ObjectPose>(payload);
    taken_safely::<ObjectTruth>(payload);
    taken_safely::<FusionStatus>(payload);
    taken_safely::<RigConfig>(payload);
    taken_safely::<ObjectConfig>(payload);
    taken_safely::<ObjectLinks>(payload);
    taken_safely::<Proposal>(payload);
    taken_safely::<FusionInputs>(payload);
    taken_safely::<Heartbeat>(payload);
    let (_, memory) = memory_of(|| AnyMessage::decode(payload));
    assert!(memory <= MAX_DECODED_BYTES);
}

fn sample_payloads() -> Vec<Vec<u8>> {
    vec![
        encode(&samples::observations()).unwrap(),
        encode(&samples::preview()).unwrap(),
        encode(&samples::camera_status()).unwrap(),
        encode(&samples::camera_settings()).unwrap(),
        encode(&samples::detection_report()).unwrap(),
        encode(&samples::object_pose()).unwrap(),
        encode(&samples::object_truth()).unwrap(),
        encode(&samples::fusion_status()).unwrap(),
        encode(&samples::clock_report()).unwrap(),
        encode(&samples::config_answer()).unwrap(),
        encode(&samples::rig_config()).unwrap(),
        encode(&samples::object_config()).unwrap(),
        encode(&samples::object_links()).unwrap(),
        encode(&samples::proposal()).unwrap(),
        encode(&samples::fusion_inputs()).unwrap(),
        encode(&samples::heartbeat()).unwrap(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(payload in proptest::collection::vec(any::<u8>(), 0..600)) {
        every_kind_takes_safely(&payload);
    }

    #[test]
    fn a_random_body_behind_a_good_header(
        kind in 0_u8..20,
        body in proptest::collection::vec(prop_oneof![Just(0_u8), Just(0xff), any::<u8>()], 0..4000),
    ) {
        let mut payload = vec![MAGIC, VERSION, kind, 0];
        payload.extend(body);
        every_kind_takes_safely(&payload);
    }

    #[test]
    fn mutated_messages(
        which in 0..MessageKind::ALL.len(),
        cut in 0.0_f64..1.5,
        mutations in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
    ) {
        let mut payload = sample_payloads().swap_remove(which);
        for (place, byte) in mutations {
            let place = place.index(payload.len());
            payload[place] = byte;
        }
        payload.truncate((payload.len() as f64 * cut) as usize);
        every_kind_takes_safely(&payload);
    }
}

#[test]
fn every_single_byte_of_every_message_may_be_wrong() {
    for payload in sample_payloads() {
        for place in 0..payload.len() {
            for wrong in [0, 1, 0x7f, 0x80, 0xff] {
                let mut mutated = payload.clone();
                mutated[place] = wrong;
                every_kind_takes_safely(&mutated);
            }
        }
    }
}

#[test]
fn every_cut_is_damage() {
    for payload in sample_payloads() {
        for length in HEADER_BYTES..payload.len() {
            assert_eq!(
                AnyMessage::decode(&payload[..length]),
                Err(DecodeError::Damaged)
            );
        }
        assert_eq!(
            AnyMessage::decode(&payload[..3]),
            Err(DecodeError::BadMagic)
        );
    }
}

#[test]
fn a_huge_length_reserves_nothing() {
    for kind in MessageKind::ALL {
        let mut payload = vec![MAGIC, VERSION, kind as u8, 0];
        payload.extend([0xff, 0xff, 0xff, 0xff, 0x0f]);
        payload.resize(200, 0xff);
        every_kind_takes_safely(&payload);
    }
    // A rig of more cameras than fit: refused at its length, before the first camera.
    let (decoded, memory) = memory_of(|| {
        decode::<RigConfig>(&[MAGIC, VERSION, MessageKind::RigConfig as u8, 0, 0x81, 0x02])
    });
    assert_eq!(decoded, Err(DecodeError::Damaged));
    assert_eq!(memory, 0);
}

#[test]
fn full_messages_stay_within_the_memory_limit() {
    let mut observations = samples::observations();
    observations.tags = vec![observations.tags[0].clone(); limits::MAX_TAGS];
    taken_safely::<Observations>(&encode(&observations).unwrap());
    let mut preview = samples::preview();
    preview.jpeg = vec![7; limits::MAX_JPEG_BYTES];
    taken_safely::<Preview>(&encode(&preview).unwrap());
    let mut rig = samples::rig_config();
    rig.cameras = vec![rig.cameras[1].clone(); limits::MAX_CAMERAS];
    taken_safely::<RigConfig>(&encode(&rig).unwrap());
    let mut object = samples::object_config();
    object.joints = vec![object.joints[0].clone(); limits::MAX_LINKS];
    object.tags = vec![object.tags[0].clone(); limits::MAX_OBJECT_TAGS];
    taken_safely::<ObjectConfig>(&encode(&object).unwrap());
    let mut links = samples::object_links();
    links.links = vec![links.links[0].clone(); limits::MAX_LINKS];
    links.joints = vec![links.joints[0].clone(); limits::MAX_JOINTS];
    taken_safely::<ObjectLinks>(&encode(&links).unwrap());
    let mut status = samples::fusion_status();
    status.cameras = vec![status.cameras[0].clone(); limits::MAX_CAMERAS];
    status.objects = vec![status.objects[0].clone(); limits::MAX_OBJECTS];
    status.faults = vec![status.faults[4].clone(); limits::MAX_FAULTS];
    taken_safely::<FusionStatus>(&encode(&status).unwrap());
}

#[test]
fn a_megabyte_is_refused_unread() {
    let mut payload = encode(&samples::observations()).unwrap();
    payload.resize(1 << 20, 0);
    let (decoded, memory) = memory_of(|| decode::<Observations>(&payload));
    assert_eq!(decoded, Err(DecodeError::TooLong(1 << 20)));
    assert_eq!(memory, 0);
    assert!(payload.len() > MAX_PAYLOAD_BYTES);
}
