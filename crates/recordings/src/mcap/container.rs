//! The container that is being written (<https://mcap.dev/spec>): chunks with their indexes, then the summary. Knows nothing of what messages mean.

use super::bytes::Fields;
use super::{LZ4, MAGIC, opcode};
use lz4_flex::frame::{BlockSize, FrameEncoder, FrameInfo};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Bytes of a chunk before compression, unless it is flushed earlier.
const CHUNK_BYTES: usize = 1 << 20;

/// A file that is being written.
pub(super) struct Container<W> {
    out: W,
    /// Bytes written.
    offset: u64,
    chunk: Chunk,
    /// Schemas and channels, repeated in the summary.
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
    /// Chunk and metadata indexes.
    indexes: Vec<Vec<u8>>,
    n_chunks: u32,
    n_metadata: u32,
    /// Messages by channel.
    messages: BTreeMap<u16, u64>,
    times_ns: Option<[u64; 2]>,
}

/// Records that are not written yet.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    /// Time and offset of each message, by channel.
    messages: BTreeMap<u16, Vec<[u64; 2]>>,
    times_ns: Option<[u64; 2]>,
}

/// A channel.
pub(super) struct NewChannel<'a> {
    pub(super) schema: u16,
    pub(super) topic: &'a str,
    pub(super) encoding: &'a str,
    pub(super) metadata: &'a BTreeMap<String, String>,
}

/// What stands before a message's bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct MessageHeader {
    pub(super) channel: u16,
    pub(super) sequence: u32,
    pub(super) log_ns: u64,
    pub(super) publish_ns: u64,
}

fn widened(times_ns: Option<[u64; 2]>, time_ns: u64) -> Option<[u64; 2]> {
    let [first, last] = times_ns.unwrap_or([time_ns; 2]);
    Some([first.min(time_ns), last.max(time_ns)])
}

impl<W: Write> Container<W> {
    pub(super) fn begin(out: W, library: &str) -> io::Result<Self> {
        let mut container = Self {
            out,
            offset: 0,
            chunk: Chunk::default(),
            schemas: Vec::new(),
            channels: Vec::new(),
            indexes: Vec::new(),
            n_chunks: 0,
            n_metadata: 0,
            messages: BTreeMap::new(),
            times_ns: None,
        };
        container.put(&MAGIC)?;
        let header = Fields::default().text("").text(library);
        container.put(&header.record(opcode::HEADER))?;
        Ok(container)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.offset += bytes.len() as u64;
        Ok(())
    }

    pub(super) fn metadata(
        &mut self,
        name: &str,
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        self.end_chunk()?;
        let record = Fields::default().text(name).map(metadata);
        let record = record.record(opcode::METADATA);
        let index = Fields::default()
            .u64(self.offset)
            .u64(record.len() as u64)
            .text(name);
        self.indexes.push(index.record(opcode::METADATA_INDEX));
        self.n_metadata += 1;
        self.put(&record)
    }

    /// Adds a schema; its number.
    pub(super) fn schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> u16 {
        let id = self.schemas.len() as u16 + 1;
        let record = Fields::default().u16(id).text(name).text(encoding);
        let record = record.bytes(data).record(opcode::SCHEMA);
        self.chunk.records.extend(&record);
        self.schemas.push(record);
        id
    }

    /// Adds a channel; its number.
    pub(super) fn channel(&mut self, channel: &NewChannel<'_>) -> u16 {
        let id = self.channels.len() as u16;
        let record = Fields::default().u16(id).u16(channel.schema);
        let record = record.text(channel.topic).text(channel.encoding);
        let record = record.map(channel.metadata).record(opcode::CHANNEL);
        self.chunk.records.extend(&record);
        self.channels.push(record);
        id
    }

    pub(super) fn message(&mut self, header: MessageHeader, data: &[u8]) -> io::Result<()> {
        let place = [header.log_ns, self.chunk.records.len() as u64];
        let record = Fields::default().u16(header.channel).u32(header.sequence);
        let record = record.u64(header.log_ns).u64(header.publish_ns).raw(data);
        self.chunk.records.extend(record.record(opcode::MESSAGE));
        let places = self.chunk.messages.entry(header.channel).or_default();
        places.push(place);
        self.chunk.times_ns = widened(self.chunk.times_ns, header.log_ns);
        self.times_ns = widened(self.times_ns, header.log_ns);
        *self.messages.entry(header.channel).or_default() += 1;
        if self.chunk.records.len() >= CHUNK_BYTES {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// Writes what waits.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        self.end_chunk()?;
        self.out.flush()
    }

    fn end_chunk(&mut self) -> io::Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        if chunk.records.is_empty() {
            return Ok(());
        }
        // Small blocks: of a chunk without its end those before the cut are read.
        let blocks = FrameInfo::new().block_size(BlockSize::Max64KB);
        let mut compressor = FrameEncoder::with_frame_info(blocks, Vec::new());
        compressor.write_all(&chunk.records)?;
        let compressed = compressor.finish().map_err(io::Error::other)?;
        let [first_ns, last_ns] = chunk.times_ns.unwrap_or_default();
        let record = Fields::default()
            .u64(first_ns)
            .u64(last_ns)
            .u64(chunk.records.len() as u64)
            .u32(crc32fast::hash(&chunk.records))
            .text(LZ4)
            .u64(compressed.len() as u64)
            .raw(&compressed)
            .record(opcode::CHUNK);
        let (chunk_at, chunk_bytes) = (self.offset, record.len() as u64);
        self.put(&record)?;
        let (indexes_at, mut places) = (self.offset, Fields::default());
        for (channel, messages) in &chunk.messages {
            places = places.u16(*channel).u64(self.offset);
            let flat = messages.iter().flatten();
            let flat: Vec<u8> = flat.flat_map(|number| number.to_le_bytes()).collect();
            let index = Fields::default().u16(*channel).bytes(&flat);
            self.put(&index.record(opcode::MESSAGE_INDEX))?;
        }
        let index = Fields::default()
            .u64(first_ns)
            .u64(last_ns)
            .u64(chunk_at)
            .u64(chunk_bytes)
            .bytes(places.as_bytes())
            .u64(self.offset - indexes_at)
            .text(LZ4)
            .u64(compressed.len() as u64)
            .u64(chunk.records.len() as u64);
        self.indexes.push(index.record(opcode::CHUNK_INDEX));
        self.n_chunks += 1;
        Ok(())
    }

    /// Writes the summary and the end; what the file was written to.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.end_chunk()?;
        // No check of the data section, which a chunk each has.
        self.put(&Fields::default().u32(0).record(opcode::DATA_END))?;
        let (summary_at, statistics) = (self.offset, self.statistics());
        let records = [
            std::mem::take(&mut self.schemas),
            std::mem::take(&mut self.channels),
            vec![statistics],
            std::mem::take(&mut self.indexes),
        ];
        for record in records.into_iter().flatten() {
            self.put(&record)?;
        }
        let footer = Fields::default().u64(summary_at).u64(0).u32(0);
        self.put(&footer.record(opcode::FOOTER))?;
        self.put(&MAGIC)?;
        self.out.flush()?;
        Ok(self.out)
    }

    fn statistics(&self) -> Vec<u8> {
        let counts = self.messages.iter();
        let by_channel = counts.fold(Fields::default(), |fields, (channel, n_messages)| {
            fields.u16(*channel).u64(*n_messages)
        });
        let [first_ns, last_ns] = self.times_ns.unwrap_or_default();
        let record = Fields::default()
            .u64(self.messages.values().sum())
            .u16(self.schemas.len() as u16)
            .u32(self.channels.len() as u32)
            .u32(0)
            .u32(self.n_metadata)
            .u32(self.n_chunks)
            .u64(first_ns)
            .u64(last_ns)
            .bytes(by_channel.as_bytes());
        record.record(opcode::STATISTICS)
    }
}
