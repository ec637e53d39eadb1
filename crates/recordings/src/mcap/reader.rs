//! Reads a recording from start to end, also one whose end is missing. Nothing is read twice and no index is needed.

use super::{METADATA, RecordingInfo};
use crate::error::RecordingError;
use ::mcap::records::{Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{MAGIC, parse_record};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest record and chunk, compressed or not; a damaged length asks for more.
const MOST_BYTES: usize = 64 << 20;
/// Before each record: its kind and its length.
const HEAD_BYTES: usize = 9;
const DISK: &str = "check the disk";
const REMEDY: &str = "give a recording made by `sextant record` or `sextant convert`";

/// A channel of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedChannel {
    /// A zenoh key for wire payloads.
    pub topic: String,
    /// Encoding of its messages.
    pub encoding: String,
}

/// A message of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedMessage {
    /// Its channel.
    pub channel: Arc<RecordedChannel>,
    /// Arrival at the recorder, ns since the Unix epoch.
    pub arrival_ns: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// How a file ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// As its writer ended it.
    Closed,
    /// In the middle of a record or without a footer: its writer was killed, or it was not copied whole.
    Cut {
        /// Bytes at the end that belong to no whole record of the file.
        lost_bytes: u64,
        /// Messages that were recovered from them: those at the beginning of a chunk.
        recovered: u64,
    },
    /// With a record that is damaged; what follows is not read.
    Damaged {
        /// Where the damage lies: after this many bytes.
        at_byte: u64,
        /// What is wrong.
        cause: String,
        /// Bytes from there on.
        lost_bytes: u64,
    },
}

/// A file that is being read.
pub struct McapReader<R> {
    path: PathBuf,
    file: R,
    length: u64,
    channels: BTreeMap<u16, Arc<RecordedChannel>>,
    info: Option<RecordingInfo>,
    /// Messages of the last chunk.
    waiting: VecDeque<RecordedMessage>,
    /// Bytes of whole records.
    used: u64,
    ending: Option<Ending>,
}

/// What is wrong with a record.
type Flaw = String;

impl McapReader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// A file that is missing or is no MCAP file.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let remedy = "check the path";
        let file = File::open(path).map_err(RecordingError::unreadable(path, remedy))?;
        let length = file
            .metadata()
            .map_err(RecordingError::unreadable(path, remedy))?
            .len();
        Self::begin(BufReader::new(file), length, path)
    }
}

impl<R: Read> McapReader<R> {
    /// Begins to read `length` bytes; `path` is named in errors.
    ///
    /// # Errors
    /// What does not begin as an MCAP file does.
    pub fn begin(mut file: R, length: u64, path: &Path) -> Result<Self, RecordingError> {
        let mut magic = [0; MAGIC.len()];
        let begins = file.read_exact(&mut magic);
        if begins.is_err() || magic != *MAGIC {
            let cause = "this is not an MCAP file";
            return Err(RecordingError::wrong(path, None, cause, REMEDY));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            length,
            channels: BTreeMap::new(),
            info: None,
            waiting: VecDeque::new(),
            used: magic.len() as u64,
            ending: None,
        })
    }

    /// The next message; `None` at the end, however the file ends.
    ///
    /// # Errors
    /// An I/O error.
    pub fn next_message(&mut self) -> Result<Option<RecordedMessage>, RecordingError> {
        while self.waiting.is_empty() && self.ending.is_none() {
            self.ending = self.step()?;
        }
        Ok(self.waiting.pop_front())
    }

    /// What the file says about itself, once its first message was read.
    #[must_use]
    pub fn info(&self) -> Option<&RecordingInfo> {
        self.info.as_ref()
    }

    /// How the file ends, once it was read to its end.
    #[must_use]
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// Why a file that was read to its end has no message, or none of a site.
    #[must_use]
    pub fn emptiness(&self) -> RecordingError {
        let (cause, remedy) = match &self.ending {
            Some(Ending::Cut { .. }) if self.channels.is_empty() => (
                format!(
                    "the file ends after {} bytes, before its first whole message",
                    self.length
                ),
                "copy or save it again",
            ),
            Some(damaged @ Ending::Damaged { .. }) if self.channels.is_empty() => {
                (damaged.to_string(), "copy or save it again")
            }
            Some(Ending::Closed) if self.info.is_some() => (
                "the recording has no messages".to_owned(),
                "record while the site runs",
            ),
            _ => (
                "this MCAP file is no recording of a Sextant site".to_owned(),
                "give one made by `sextant record`",
            ),
        };
        RecordingError::wrong(&self.path, None, cause, remedy)
    }

    fn lost_bytes(&self) -> u64 {
        self.length.saturating_sub(self.used)
    }

    fn damaged(&self, cause: Flaw) -> Ending {
        Ending::Damaged {
            at_byte: self.used,
            cause,
            lost_bytes: self.lost_bytes(),
        }
    }

    /// Takes the next record; how the file ends, where it does.
    fn step(&mut self) -> Result<Option<Ending>, RecordingError> {
        let cut = Ending::Cut {
            lost_bytes: self.lost_bytes(),
            recovered: 0,
        };
        let Some(head) = self.bytes(HEAD_BYTES as u64)? else {
            return Ok(Some(cut));
        };
        let (opcode, length) = head_of(&head).unwrap_or_default();
        if length > self.lost_bytes().saturating_sub(HEAD_BYTES as u64) {
            return Ok(Some(match opcode {
                op::CHUNK => self.recover_chunk()?,
                _ => cut,
            }));
        }
        match opcode {
            op::FOOTER => {
                let last = self.bytes(length.min(1024) + MAGIC.len() as u64)?;
                let is_whole = last.is_some_and(|last| last.ends_with(MAGIC));
                return Ok(Some(if is_whole { Ending::Closed } else { cut }));
            }
            op::CHUNK | op::CHANNEL | op::MESSAGE | op::METADATA => {
                if length > MOST_BYTES as u64 {
                    let cause = format!("a record of {length} bytes, more than are read");
                    return Ok(Some(self.damaged(cause)));
                }
                let Some(record) = self.bytes(length)? else {
                    return Ok(Some(cut));
                };
                let taken = match opcode {
                    op::CHUNK => self.take_chunk(record, whole_chunk()),
                    _ => self.take(opcode, &record),
                };
                if let Err(cause) = taken {
                    return Ok(Some(self.damaged(cause)));
                }
            }
            _ => self.skip(length)?,
        }
        self.used += HEAD_BYTES as u64 + length;
        Ok(None)
    }

    /// So many bytes; `None` where the file ends before. Memory is taken as they come.
    fn bytes(&mut self, n_bytes: u64) -> Result<Option<Vec<u8>>, RecordingError> {
        let mut bytes = Vec::new();
        let read = (&mut self.file).take(n_bytes).read_to_end(&mut bytes);
        let read = read.map_err(RecordingError::unreadable(&self.path, DISK))?;
        Ok((read as u64 == n_bytes).then_some(bytes))
    }

    fn skip(&mut self, n_bytes: u64) -> Result<(), RecordingError> {
        let copied = io::copy(&mut (&mut self.file).take(n_bytes), &mut io::sink());
        copied.map_err(RecordingError::unreadable(&self.path, DISK))?;
        Ok(())
    }

    fn take(&mut self, opcode: u8, record: &[u8]) -> Result<(), Flaw> {
        let taken = match opcode {
            op::CHANNEL => self.take_channel(record),
            op::MESSAGE => self.take_message(record),
            op::METADATA => self.take_metadata(record),
            _ => Some(()),
        };
        taken.ok_or_else(|| format!("a record of kind {opcode:#04x} is malformed"))
    }

    /// Takes the records of a chunk, or of the beginning of one.
    fn take_chunk(&mut self, chunk: Vec<u8>, options: LinearReaderOptions) -> Result<(), Flaw> {
        let mut reader = chunk_reader(chunk, options).ok_or("a chunk is malformed")?;
        let mut n_bytes = 0;
        while let Some(event) = reader.next_event() {
            match event.map_err(|cause| format!("a chunk cannot be read: {cause}"))? {
                LinearReadEvent::ReadRequest(_) => reader.notify_read(0),
                LinearReadEvent::Record { opcode, data } => {
                    n_bytes += HEAD_BYTES + data.len();
                    if n_bytes > MOST_BYTES {
                        return Err("a chunk of more bytes than are read".to_owned());
                    }
                    self.take(opcode, data)?;
                }
            }
        }
        Ok(())
    }

    /// Takes the first messages of a chunk without its end. The checksum is that of the whole chunk and cannot be
    /// tested.
    fn recover_chunk(&mut self) -> Result<Ending, RecordingError> {
        let lost_bytes = self.lost_bytes();
        let mut chunk = Vec::new();
        let read = (&mut self.file)
            .take(MOST_BYTES as u64)
            .read_to_end(&mut chunk);
        read.map_err(RecordingError::unreadable(&self.path, DISK))?;
        // It fails where the bytes end.
        let _ = self.take_chunk(chunk, cut_chunk());
        Ok(Ending::Cut {
            lost_bytes,
            recovered: self.waiting.len() as u64,
        })
    }

    fn take_channel(&mut self, mut record: &[u8]) -> Option<()> {
        let id = u16::from_le_bytes(take_array(&mut record)?);
        let _schema: [u8; 2] = take_array(&mut record)?;
        let channel = RecordedChannel {
            topic: take_text(&mut record)?,
            encoding: take_text(&mut record)?,
        };
        self.channels.entry(id).or_insert_with(|| Arc::new(channel));
        Some(())
    }

    /// A message of an unknown channel means nothing.
    fn take_message(&mut self, record: &[u8]) -> Option<()> {
        let Record::Message { header, data } = parse_record(op::MESSAGE, record).ok()? else {
            return None;
        };
        if let Some(channel) = self.channels.get(&header.channel_id) {
            self.waiting.push_back(RecordedMessage {
                channel: Arc::clone(channel),
                arrival_ns: header.log_time,
                data: data.into_owned(),
            });
        }
        Some(())
    }

    fn take_metadata(&mut self, mut record: &[u8]) -> Option<()> {
        let (name, mut map) = (take_text(&mut record)?, take_bytes(&mut record)?);
        let mut about = BTreeMap::new();
        while !map.is_empty() {
            about.insert(take_text(&mut map)?, take_text(&mut map)?);
        }
        if name == METADATA {
            let mut text = |key: &str| about.remove(key).unwrap_or_default();
            self.info.get_or_insert(RecordingInfo {
                site: text("site"),
                version: text("version"),
            });
        }
        Some(())
    }
}

/// Tests the checksum before the first record.
fn whole_chunk() -> LinearReaderOptions {
    cut_chunk().with_prevalidate_chunk_crcs(true)
}

/// Gives the records up to where the bytes end.
fn cut_chunk() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(MOST_BYTES)
}

/// A reader that has been given a chunk, or its beginning. What follows the chunk's records is left out: the crate
/// would read it as more of them.
fn chunk_reader(chunk: Vec<u8>, options: LinearReaderOptions) -> Option<LinearReader> {
    let mut rest = &*chunk;
    let _times_size_checksum: [u8; 28] = take_array(&mut rest)?;
    let _compression = take_bytes(&mut rest)?;
    let compressed_size = u64::from_le_bytes(take_array(&mut rest)?);
    let length = compressed_size.checked_add((chunk.len() - rest.len()) as u64)?;
    let present = chunk.get(..usize::try_from(length).ok()?);
    let present = present.unwrap_or(&chunk);
    let mut reader = LinearReader::new_with_options(options);
    let (head, body) = reader
        .insert(HEAD_BYTES + present.len())
        .split_at_mut(HEAD_BYTES);
    head[0] = op::CHUNK;
    head[1..].copy_from_slice(&length.to_le_bytes());
    body.copy_from_slice(present);
    reader.notify_read(HEAD_BYTES + present.len());
    Some(reader)
}

/// Kind and length of a record.
fn head_of(mut head: &[u8]) -> Option<(u8, u64)> {
    let [opcode] = take_array(&mut head)?;
    Some((opcode, u64::from_le_bytes(take_array(&mut head)?)))
}

fn take_array<const N: usize>(fields: &mut &[u8]) -> Option<[u8; N]> {
    fields.split_off(..N)?.try_into().ok()
}

/// Bytes with their length in front. The crate's own parser takes as much memory as the length says, 4 GiB for a record
/// of a few bytes.
fn take_bytes<'a>(fields: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = u32::from_le_bytes(take_array(fields)?);
    fields.split_off(..length as usize)
}

fn take_text(fields: &mut &[u8]) -> Option<String> {
    String::from_utf8(take_bytes(fields)?.to_vec()).ok()
}

impl std::fmt::Display for Ending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Closed => write!(f, "the recording was closed"),
            Self::Cut { lost_bytes: 0, .. } => {
                write!(
                    f,
                    "the recording was not closed: what came after its last chunk is lost"
                )
            }
            Self::Cut {
                lost_bytes,
                recovered: 0,
            } => write!(
                f,
                "the recording was not closed: its last {lost_bytes} bytes are incomplete and not used"
            ),
            Self::Cut {
                lost_bytes,
                recovered,
            } => write!(
                f,
                "the recording was not closed: its last {lost_bytes} bytes are a part of a \
                 chunk, of which {recovered} messages could be read"
            ),
            Self::Damaged {
                at_byte,
                cause,
                lost_bytes,
            } => write!(
                f,
                "the recording is damaged after byte {at_byte} ({cause}): the {lost_bytes} bytes \
                 from there on are not used"
            ),
        }
    }
}
