//! MCAP files that are cut anywhere, damaged anywhere, or no recordings at all.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mcap::records::op;
use mcap::{Compression, MAGIC, MessageStream, Summary, WriteOptions};
use proptest::prelude::*;
use sextant_proto::{Keys, ObjectPose, encode};
use sextant_recordings::compressed_image::RecordedImage;
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::reader::{Ending, McapReader, RecordedMessage};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_recordings::mcap::writer::McapWriter;
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::State;
use std::io::Cursor;
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
    // Each pose has a transform, itself in Foxglove's schema, its quality and an ellipsoid beside it.
    assert_eq!(messages.len(), 6 * 6);
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

/// What another tool makes of a recording: its messages, written anew in an order of their sequence numbers, eight in a
/// chunk.
fn rewritten(options: WriteOptions, order: impl Fn(u32) -> u32) -> Vec<u8> {
    let mut messages: Vec<_> = MessageStream::new(recording())
        .unwrap()
        .map(Result::unwrap)
        .collect();
    messages.sort_by_key(|message| order(message.sequence));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let summary = Summary::read(recording()).unwrap().unwrap();
    for index in &summary.metadata_indexes {
        let metadata = mcap::read::metadata(recording(), index).unwrap();
        writer.write_metadata(&metadata).unwrap();
    }
    for (n, message) in messages.iter().enumerate() {
        writer.write(message).unwrap();
        if n % 8 == 7 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn a_recording_that_another_tool_has_rewritten_gives_the_same_messages() {
    let (expected, _) = read(recording()).unwrap();
    let options = || WriteOptions::new().compression(None);
    let ways = [
        options().compression(Some(Compression::Zstd)),
        options().compression(Some(Compression::Lz4)),
        options(),
        options().use_chunks(false),
        options()
            .emit_summary_records(false)
            .emit_summary_offsets(false),
        options()
            .calculate_chunk_crcs(false)
            .compression(Some(Compression::Zstd)),
        options()
            .emit_message_indexes(false)
            .compression(Some(Compression::Lz4)),
    ];
    for way in ways {
        let file = rewritten(way.clone(), |_| 0);
        assert_eq!(
            read(&file).unwrap(),
            (expected.clone(), Ending::Closed),
            "{way:?}"
        );
        // Chunks in the reverse order of their times.
        let file = rewritten(way.clone(), |sequence| u32::MAX - sequence);
        let (mut messages, ending) = read(&file).unwrap();
        assert_ne!(messages, expected);
        messages.sort_by_key(|message| message.arrival_ns);
        assert_eq!(
            (messages, ending),
            (expected.clone(), Ending::Closed),
            "{way:?}"
        );
    }
}

#[test]
fn a_file_that_another_tool_has_rewritten_opens_where_it_is_cut() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let whole = rewritten(WriteOptions::new().compression(compression), |_| 0);
        let (all, _) = read(&whole).unwrap();
        for length in 8..whole.len() {
            let (messages, ending) = read(&whole[..length]).unwrap();
            assert!(matches!(ending, Ending::Cut { .. }), "{length}: {ending}");
            assert_eq!(messages, all[..messages.len()], "{length}");
        }
    }
}

/// A record whose length may be a lie.
fn record(opcode: u8, length: u64, fields: &[&[u8]]) -> Vec<u8> {
    [&[opcode][..], &length.to_le_bytes(), &fields.concat()].concat()
}

/// A frame of LZ4 with one block that is not compressed.
fn lz4(bytes: &[u8]) -> Vec<u8> {
    let size = (bytes.len() as u32 | 1 << 31).to_le_bytes();
    [
        &[4, 0x22, 0x4d, 0x18, 0x60, 0x40, 0x82][..],
        &size,
        bytes,
        &[0; 4],
    ]
    .concat()
}

/// A frame of zstd with one block that is not compressed.
fn zstd(bytes: &[u8]) -> Vec<u8> {
    let block = (bytes.len() as u32) << 3 | 1;
    let head = [0x28, 0xb5, 0x2f, 0xfd, 0x20, bytes.len() as u8];
    [&head[..], &block.to_le_bytes()[..3], bytes].concat()
}

/// A chunk with these sizes in its head.
fn chunk(size: u64, crc: u32, compression: &str, compressed_size: u64, records: &[u8]) -> Vec<u8> {
    let fields = [
        &[0; 16][..],
        &size.to_le_bytes(),
        &crc.to_le_bytes(),
        &(compression.len() as u32).to_le_bytes(),
        compression.as_bytes(),
        &compressed_size.to_le_bytes(),
        records,
    ];
    record(op::CHUNK, fields.concat().len() as u64, &fields)
}

#[test]
fn lengths_that_are_lies_take_no_memory() {
    let huge = u32::MAX.to_le_bytes();
    let message = record(op::MESSAGE, 22, &[&[0; 22]]);
    let endless = record(op::MESSAGE, 1 << 60, &[&[0; 22]]);
    let longest = record(op::MESSAGE, u64::MAX, &[&[0; 22]]);
    let mut files = vec![
        longest.clone(),
        record(op::SCHEMA, 6, &[&[1, 0], &huge]),
        record(op::CHANNEL, 8, &[&[0; 4], &huge]),
        record(op::METADATA, 4, &[&huge]),
        record(op::METADATA, 12, &[&[0; 4], &huge, &huge]),
        record(op::ATTACHMENT, 2, &[&[0; 2]]),
        record(op::CHUNK, 32, &[&[0; 28], &huge]),
        record(op::CHUNK, 1 << 60, &[&[0; 28], &huge]),
        // Bytes behind the records of a chunk, among which its last record ends.
        chunk(31, 0, "", 9, &message),
        record(op::CHUNK, 1 << 60, &[&chunk(31, 0, "", 9, &message)[9..]]),
    ];
    for compression in ["", "lz4", "zstd", "xz"] {
        for crc in [0, 1] {
            for records in [&message, &endless, &longest] {
                let compressed = match compression {
                    "lz4" => lz4(records),
                    "zstd" => zstd(records),
                    _ => records.clone(),
                };
                for size in [0, records.len() as u64, 1 << 60, u64::MAX] {
                    for compressed_size in [0, compressed.len() as u64, 1 << 60, u64::MAX] {
                        files.push(chunk(size, crc, compression, compressed_size, &compressed));
                    }
                }
            }
        }
    }
    for file in files {
        let bytes = [MAGIC, &file].concat();
        let memory = allocation_counter::measure(|| {
            read(&bytes);
        });
        assert!(memory.bytes_max < 1 << 20, "{memory:?} for {file:?}");
    }
}

#[test]
fn a_chunk_of_a_few_bytes_that_becomes_a_terabyte_is_given_up() {
    // Blocks of zstd that repeat a zero 2^17 times, and so records of kind 0 without a byte.
    let block = (1_u32 << 20 | 2).to_le_bytes();
    let block = [&block[..3], &[0]].concat();
    let frame = [&[0x28, 0xb5, 0x2f, 0xfd, 0, 0x70][..], &block.repeat(1000)].concat();
    let bomb = chunk(1 << 40, 0, "zstd", frame.len() as u64, &frame);
    let (messages, ending) = read(&[MAGIC, &bomb].concat()).unwrap();
    assert!(messages.is_empty());
    assert!(
        ending.to_string().contains("more bytes than are read"),
        "{ending}"
    );
}

#[test]
fn what_is_no_recording_of_a_site_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    std::fs::write(&path, &recording()[..20]).unwrap();
    let error = SiteRecording::read(&path).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "a.mcap: the file ends after 20 bytes, before its first whole \
        message; copy or save it again"
        ),
        "{error}"
    );
    std::fs::write(&path, b"#timestamp,filename\n").unwrap();
    let error = SiteRecording::read(&path).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "a.mcap: this is not an MCAP file; give a recording made by `sextant \
        record` or `sextant convert`"
        ),
        "{error}"
    );
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
