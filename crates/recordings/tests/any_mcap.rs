//! MCAP files that are cut anywhere, damaged anywhere, or no recordings at all.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mcap::MAGIC;
use proptest::prelude::*;
use sextant_estimator::{CameraId, ObjectId, State};
use sextant_proto::{Keys, ObjectPose, encode};
use sextant_recordings::compressed_image::RecordedImage;
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::reader::{Ending, McapReader, RecordedMessage};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_recordings::mcap::writer::McapWriter;
use std::path::Path;
use std::sync::OnceLock;

fn info() -> RecordingInfo {
    RecordingInfo {
        site: "lab".to_owned(),
        version: "1.2.3".to_owned(),
    }
}

fn pose(sequence: u64) -> ObjectPose {
    let mut covariance = [0.0; 36];
    covariance.iter_mut().step_by(7).for_each(|v| *v = 1e-6);
    ObjectPose {
        object: ObjectId::new("cube").unwrap(),
        epoch: 1,
        sequence,
        capture_ns: 1_800_000_000_000_000_000 + sequence,
        published_ns: 1_800_000_000_000_000_000,
        state: State::Tracking,
        position: [1.0, 2.0, sequence as f64],
        orientation: [0.0, 0.0, 0.0, 1.0],
        covariance,
        twist: [0.0; 6],
        cameras: 2,
        tags: 3,
        rms_px: 0.1,
    }
}

/// A recording of some poses and images in several chunks.
fn recording() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| {
        let keys = Keys::new("lab").unwrap();
        let mut writer = McapWriter::begin(Vec::new(), Path::new("a.mcap"), &info()).unwrap();
        for sequence in 0..6 {
            let pose = pose(sequence);
            let payload = encode(&pose).unwrap();
            let key = keys.pose(&pose.object);
            writer
                .write_payload(&key, &payload, 100 + sequence)
                .unwrap();
            let image = RecordedImage {
                camera: CameraId::new("north").unwrap(),
                capture_ns: pose.capture_ns,
                png: vec![7; 50],
            };
            writer.write_image(&image, 100 + sequence).unwrap();
            if sequence % 2 == 1 {
                writer.flush().unwrap();
            }
        }
        writer.finish().unwrap()
    })
}

fn read(bytes: &[u8]) -> Option<(Vec<RecordedMessage>, Ending)> {
    let mut reader = McapReader::begin(bytes, bytes.len() as u64, Path::new("a.mcap")).ok()?;
    let mut messages = Vec::new();
    while let Some(message) = reader.next_message().unwrap() {
        messages.push(message);
    }
    Some((messages, reader.ending().unwrap().clone()))
}

#[test]
fn a_recording_comes_back_as_it_was_written() {
    let (messages, ending) = read(recording()).unwrap();
    assert_eq!(ending, Ending::Closed);
    // Each pose has a transform and an ellipsoid beside it.
    assert_eq!(messages.len(), 6 * 4);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    std::fs::write(&path, recording()).unwrap();
    let site = SiteRecording::read(&path).unwrap();
    assert_eq!(site.info, info());
    assert_eq!(site.poses, (0..6).map(pose).collect::<Vec<_>>());
    assert_eq!(site.images.values().sum::<u64>(), 6);
    assert_eq!(site.rejected, 0);
}

#[test]
fn a_recording_that_is_cut_anywhere_gives_what_stands_before() {
    let whole = recording();
    let (all, _) = read(whole).unwrap();
    let mut fewest = 0;
    for length in 8..whole.len() {
        let (messages, ending) = read(&whole[..length]).unwrap();
        assert!(matches!(ending, Ending::Cut { .. }), "{length}: {ending}");
        assert_eq!(messages, all[..messages.len()], "{length}");
        assert!(messages.len() >= fewest, "{length}");
        fewest = messages.len();
    }
    assert_eq!(fewest, all.len());
    for length in 0..8 {
        assert!(read(&whole[..length]).is_none());
    }
}

#[test]
fn a_recording_that_is_cut_within_its_first_chunk_gives_the_messages_before() {
    let keys = Keys::new("lab").unwrap();
    let mut writer = McapWriter::begin(Vec::new(), Path::new("a.mcap"), &info()).unwrap();
    for sequence in 0..500 {
        let pose = pose(sequence);
        let payload = encode(&pose).unwrap();
        writer
            .write_payload(&keys.pose(&pose.object), &payload, 100 + sequence)
            .unwrap();
    }
    let whole = writer.finish().unwrap();
    let (all, _) = read(&whole).unwrap();
    let cut = &whole[..whole.len() / 2];
    let (messages, ending) = read(cut).unwrap();
    assert!(messages.len() > 100, "{}", messages.len());
    assert_eq!(messages, all[..messages.len()]);
    let Ending::Cut { recovered, .. } = ending else {
        panic!("{ending}")
    };
    assert_eq!(recovered, messages.len() as u64);
}

#[test]
fn what_is_no_recording_of_a_site_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    std::fs::write(&path, &recording()[..20]).unwrap();
    let error = SiteRecording::read(&path).unwrap_err().to_string();
    assert!(error.ends_with("a.mcap: the file ends after 20 bytes, before its first whole message; copy or save it again"), "{error}");
    std::fs::write(&path, b"#timestamp,filename\n").unwrap();
    let error = SiteRecording::read(&path).unwrap_err().to_string();
    assert!(error.ends_with("a.mcap: this is not an MCAP file; give a recording made by `sextant record` or `sextant convert`"), "{error}");
    let footer = [&[2, 20, 0, 0, 0, 0, 0, 0, 0][..], &[0; 20]].concat();
    std::fs::write(&path, [MAGIC, &footer, MAGIC].concat()).unwrap();
    let error = SiteRecording::read(&path).unwrap_err().to_string();
    assert!(
        error.contains("no recording of a Sextant site; give"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_to_an_end(tail in proptest::collection::vec(any::<u8>(), 0..400)) {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(tail);
        read(&bytes);
    }

    #[test]
    fn a_damaged_recording_is_read_to_an_end(at in 0_usize..100_000, with in any::<[u8; 3]>()) {
        let mut bytes = recording().to_vec();
        let at = 8 + at % (bytes.len() - 11);
        bytes[at..at + 3].copy_from_slice(&with);
        let (messages, _) = read(&bytes).unwrap();
        prop_assert!(messages.len() <= 10_000);
    }
}
