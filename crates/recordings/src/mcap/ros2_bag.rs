//! A bag of ROS 2: a folder with one MCAP file of profile `ros2`, and `metadata.yaml` in the layout of rosbag2 version
//! 5, which Humble and all later releases read. Messages are CDR, schemas `ros2msg`; channels have the quality of
//! service by which `ros2 bag play` publishes.

use super::writer::unwritable;
use crate::error::RecordingError;
use ::mcap::records::MessageHeader;
use ::mcap::{Compression, McapResult, WriteOptions, Writer};
use sextant_ros2::{
    Durability, MESSAGE_ENCODING, Outgoing, Qos, Reliability, SCHEMA_ENCODING, Topic,
};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A bag that is being written.
pub struct Ros2Bag {
    folder: PathBuf,
    file_name: String,
    file: Writer<BufWriter<File>>,
    channels: BTreeMap<Topic, Channel>,
    first_ns: u64,
    last_ns: u64,
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    id: u16,
    messages: u32,
}

impl Ros2Bag {
    /// Begins a bag in an empty folder.
    ///
    /// # Errors
    /// An I/O error.
    pub fn begin(folder: &Path, version: &str) -> Result<Self, RecordingError> {
        let name = folder.file_name().unwrap_or("bag".as_ref());
        let file_name = format!("{}_0.mcap", name.to_string_lossy());
        let path = folder.join(&file_name);
        let options = WriteOptions::new()
            .profile("ros2")
            .compression(Some(Compression::Lz4))
            .library(format!("sextant {version}"));
        let file = File::create(&path).map_err(::mcap::McapError::Io);
        let file = file.and_then(|file| options.create(BufWriter::new(file)));
        Ok(Self {
            file: file.map_err(|cause| unwritable(&path, cause))?,
            folder: folder.to_owned(),
            file_name,
            channels: BTreeMap::new(),
            first_ns: u64::MAX,
            last_ns: 0,
        })
    }

    /// Writes a message that arrived at `arrival_ns`.
    ///
    /// # Errors
    /// An I/O error.
    pub fn write(&mut self, message: &Outgoing, arrival_ns: u64) -> Result<(), RecordingError> {
        let written = self.write_message(message, arrival_ns);
        written.map_err(|cause| unwritable(&self.folder, cause))
    }

    fn write_message(&mut self, message: &Outgoing, arrival_ns: u64) -> McapResult<()> {
        let channel = match self.channels.get_mut(&message.topic) {
            Some(channel) => channel,
            None => {
                let channel = self.add_channel(&message.topic)?;
                self.channels
                    .entry(message.topic.clone())
                    .or_insert(channel)
            }
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.messages,
            log_time: arrival_ns,
            publish_time: arrival_ns,
        };
        channel.messages += 1;
        self.first_ns = self.first_ns.min(arrival_ns);
        self.last_ns = self.last_ns.max(arrival_ns);
        self.file.write_to_known_channel(&header, &message.payload)
    }

    fn add_channel(&mut self, topic: &Topic) -> McapResult<Channel> {
        let definition = topic.kind.definition();
        let schema = self.file.add_schema(
            topic.kind.type_name(),
            SCHEMA_ENCODING,
            definition.as_bytes(),
        )?;
        let metadata = BTreeMap::from([
            (
                "offered_qos_profiles".to_owned(),
                profiles(topic.kind.qos()),
            ),
            ("topic_type_hash".to_owned(), topic.kind.type_hash()),
        ]);
        let id = self
            .file
            .add_channel(schema, &topic.name, MESSAGE_ENCODING, &metadata)?;
        Ok(Channel { id, messages: 0 })
    }

    /// Completes the file and writes `metadata.yaml`; returns how many messages each topic has.
    ///
    /// # Errors
    /// An I/O error.
    pub fn finish(mut self) -> Result<Vec<(Topic, u32)>, RecordingError> {
        let path = self.folder.join("metadata.yaml");
        let finished = self.file.finish().and_then(|_| {
            fs::write(&path, self.metadata())?;
            Ok(())
        });
        finished.map_err(|cause| unwritable(&self.folder, cause))?;
        let channels = self.channels.into_iter();
        Ok(channels
            .map(|(topic, channel)| (topic, channel.messages))
            .collect())
    }

    fn metadata(&self) -> String {
        let total: u64 = self.channels.values().map(|c| u64::from(c.messages)).sum();
        let first_ns = self.first_ns.min(self.last_ns);
        let duration_ns = self.last_ns - first_ns;
        // A quoted string of JSON is one of YAML.
        let file = serde_json::json!(self.file_name);
        let topics = self.channels.iter();
        let topics: String = topics
            .map(|(topic, channel)| topic_metadata(topic, channel))
            .collect();
        format!(
            "rosbag2_bagfile_information:
  version: 5
  storage_identifier: mcap
  duration:
    nanoseconds: {duration_ns}
  starting_time:
    nanoseconds_since_epoch: {first_ns}
  message_count: {total}
  topics_with_message_count:{topics}
  compression_format: \"\"
  compression_mode: \"\"
  relative_file_paths:
    - {file}
  files:
    - path: {file}
      starting_time:
        nanoseconds_since_epoch: {first_ns}
      duration:
        nanoseconds: {duration_ns}
      message_count: {total}
"
        )
    }
}

fn topic_metadata(topic: &Topic, channel: &Channel) -> String {
    format!(
        "
    - topic_metadata:
        name: {}
        type: {}
        serialization_format: cdr
        offered_qos_profiles: {}
      message_count: {}",
        topic.name,
        topic.kind.type_name(),
        serde_json::json!(profiles(topic.kind.qos())),
        channel.messages
    )
}

/// A list of one profile in YAML, by the numbers of rmw; the longest time of rmw stands for no limit.
fn profiles(qos: Qos) -> String {
    let reliability = match qos.reliability {
        Reliability::Reliable => 1,
        Reliability::BestEffort => 2,
    };
    let durability = match qos.durability {
        Durability::TransientLocal => 1,
        Durability::Volatile => 2,
    };
    const FOREVER: &str = "\n    sec: 9223372036\n    nsec: 854775807";
    format!(
        "- history: 1
  depth: {}
  reliability: {reliability}
  durability: {durability}
  deadline:{FOREVER}
  lifespan:{FOREVER}
  liveliness: 1
  liveliness_lease_duration:{FOREVER}
  avoid_ros_namespace_conventions: false",
        qos.depth
    )
}
