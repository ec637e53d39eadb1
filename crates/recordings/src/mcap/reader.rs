//! Reads a recording from start to end, also one whose end is missing. Nothing is read twice and no index is needed.

use super::bytes::Cursor;
use super::{LZ4, MAGIC, METADATA, RecordingInfo, opcode};
use crate::error::RecordingError;
use lz4_flex::frame::FrameDecoder;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest record and chunk, compressed or not; a damaged length asks for more.
const MOST_BYTES: u64 = 64 << 20;
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

/// A record of the file, or its end.
enum Step {
    Record(u8, Vec<u8>),
    /// One that is passed over.
    Skipped,
    End(Ending),
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
        if begins.is_err() || magic != MAGIC {
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
            match self.step()? {
                Step::Record(opcode, record) => {
                    let at_byte = self.used;
                    self.used += 9 + record.len() as u64;
                    if let Err(cause) = self.take(opcode, &record) {
                        self.used = at_byte;
                        self.ending = Some(self.damaged(cause));
                    }
                }
                Step::Skipped => {}
                Step::End(ending) => self.ending = Some(ending),
            }
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

    /// The next record.
    fn step(&mut self) -> Result<Step, RecordingError> {
        let cut = Ending::Cut {
            lost_bytes: self.lost_bytes(),
            recovered: 0,
        };
        let Some(head) = self.bytes(9)? else {
            return Ok(Step::End(cut));
        };
        let mut fields = Cursor(&head);
        let (opcode, length) = (fields.u8().unwrap_or(0), fields.u64().unwrap_or(0));
        if length > self.lost_bytes().saturating_sub(9) {
            return match opcode {
                opcode::CHUNK => Ok(Step::End(self.recover_chunk()?)),
                _ => Ok(Step::End(cut)),
            };
        }
        match opcode {
            opcode::FOOTER => {
                let last = self.bytes(length.min(1024) + MAGIC.len() as u64)?;
                let is_whole = last.is_some_and(|last| last.ends_with(&MAGIC));
                Ok(Step::End(if is_whole { Ending::Closed } else { cut }))
            }
            opcode::CHUNK | opcode::CHANNEL | opcode::MESSAGE | opcode::METADATA => {
                if length > MOST_BYTES {
                    let cause = format!("a record of {length} bytes, more than are read");
                    return Ok(Step::End(self.damaged(cause)));
                }
                let record = self.bytes(length)?;
                Ok(record.map_or(Step::End(cut), |record| Step::Record(opcode, record)))
            }
            _ => {
                self.skip(length)?;
                self.used += 9 + length;
                Ok(Step::Skipped)
            }
        }
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
        let fields = Cursor(record);
        let taken = match opcode {
            opcode::CHUNK => return self.take_chunk(fields),
            opcode::CHANNEL => self.take_channel(fields),
            opcode::MESSAGE => self.take_message(fields),
            opcode::METADATA => self.take_metadata(fields),
            _ => Some(()),
        };
        taken.ok_or_else(|| format!("a record of kind {opcode:#04x} is malformed"))
    }

    fn take_chunk(&mut self, fields: Cursor<'_>) -> Result<(), Flaw> {
        let records = records_of(fields)?;
        let mut rest = Cursor(&records);
        while !rest.0.is_empty() {
            let (opcode, fields) = rest.record().ok_or("a chunk ends within a record")?;
            if opcode != opcode::CHUNK {
                self.take(opcode, fields.0)?;
            }
        }
        Ok(())
    }

    /// Takes the first messages of a chunk without its end. The checksum is that of the whole chunk and cannot be tested.
    fn recover_chunk(&mut self) -> Result<Ending, RecordingError> {
        let lost_bytes = self.lost_bytes();
        let mut record = Vec::new();
        let read = (&mut self.file).take(MOST_BYTES).read_to_end(&mut record);
        read.map_err(RecordingError::unreadable(&self.path, DISK))?;
        let (mut fields, mut records) = (Cursor(&record), Vec::new());
        if let Some(head) = ChunkHead::read(&mut fields) {
            // It fails where the bytes end.
            let _ = head.decompress(fields.0, &mut records);
        }
        let mut rest = Cursor(&records);
        while let Some((opcode, fields)) = rest.record() {
            if opcode == opcode::CHUNK || self.take(opcode, fields.0).is_err() {
                break;
            }
        }
        Ok(Ending::Cut {
            lost_bytes,
            recovered: self.waiting.len() as u64,
        })
    }

    fn take_channel(&mut self, mut fields: Cursor<'_>) -> Option<()> {
        let (id, _schema) = (fields.u16()?, fields.u16()?);
        let channel = RecordedChannel {
            topic: fields.text()?,
            encoding: fields.text()?,
        };
        self.channels.entry(id).or_insert_with(|| Arc::new(channel));
        Some(())
    }

    /// A message of an unknown channel means nothing.
    fn take_message(&mut self, mut fields: Cursor<'_>) -> Option<()> {
        let (channel, _sequence) = (fields.u16()?, fields.u32()?);
        let (arrival_ns, _publish_ns) = (fields.u64()?, fields.u64()?);
        if let Some(channel) = self.channels.get(&channel) {
            self.waiting.push_back(RecordedMessage {
                channel: Arc::clone(channel),
                arrival_ns,
                data: fields.0.to_vec(),
            });
        }
        Some(())
    }

    fn take_metadata(&mut self, mut fields: Cursor<'_>) -> Option<()> {
        let (name, mut about) = (fields.text()?, fields.map()?);
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

/// What stands before the compressed records of a chunk.
struct ChunkHead {
    /// Bytes of its records.
    size: u64,
    crc: u32,
    compression: String,
    /// Bytes of its records, compressed.
    compressed_size: u64,
}

impl ChunkHead {
    fn read(fields: &mut Cursor<'_>) -> Option<Self> {
        let _times_ns = (fields.u64()?, fields.u64()?);
        Some(Self {
            size: fields.u64()?,
            crc: fields.u32()?,
            compression: fields.text()?,
            compressed_size: fields.u64()?,
        })
    }

    /// Appends the records to `records`, after an error those before it.
    fn decompress(&self, bytes: &[u8], records: &mut Vec<u8>) -> Result<(), Flaw> {
        if self.size > MOST_BYTES {
            return Err(format!(
                "a chunk of {} bytes, more than are read",
                self.size
            ));
        }
        match self.compression.as_str() {
            "" => records.extend(bytes),
            LZ4 => {
                let mut decompressed = FrameDecoder::new(bytes).take(self.size + 1);
                let read = decompressed.read_to_end(records);
                read.map_err(|cause| format!("a chunk cannot be decompressed: {cause}"))?;
            }
            other => return Err(format!("chunks are compressed with {other:?}, not lz4")),
        }
        Ok(())
    }
}

/// The records of a chunk, decompressed and checked.
fn records_of(mut fields: Cursor<'_>) -> Result<Vec<u8>, Flaw> {
    let mut parts = || {
        let head = ChunkHead::read(&mut fields)?;
        let bytes = fields.take(usize::try_from(head.compressed_size).ok()?)?;
        Some((head, bytes))
    };
    let (head, bytes) = parts().ok_or("a chunk is malformed")?;
    let mut records = Vec::new();
    head.decompress(bytes, &mut records)?;
    if records.len() as u64 != head.size {
        return Err("a chunk is not as long as it says".to_owned());
    }
    if head.crc != 0 && head.crc != crc32fast::hash(&records) {
        return Err("the checksum of a chunk is wrong".to_owned());
    }
    Ok(records)
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
                "the recording was not closed: its last {lost_bytes} bytes are a part of a chunk, of which {recovered} messages could be read"
            ),
            Self::Damaged {
                at_byte,
                cause,
                lost_bytes,
            } => write!(
                f,
                "the recording is damaged after byte {at_byte} ({cause}): the {lost_bytes} bytes from there on are not used"
            ),
        }
    }
}
