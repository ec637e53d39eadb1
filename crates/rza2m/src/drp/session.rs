//! The driver's requests, guarded: what would crash the kernel, corrupt memory or pass for success is never asked for.
//!
//! A session has all six tiles, one circuit a tile (pattern 1-1-1-1-1-1). After anything unexpected only
//! [`Session::clear`] is possible: a circuit that has not ended in time may still write, and its end would pass for
//! that of the next start.

use super::DrpDevice;
use super::requests::{self, RECORD_BYTES, Record};
use crate::on_chip;
use std::io;
use std::ops::Range;
use std::time::Duration;

/// Tiles of the DRP.
pub(crate) const TILES: usize = 6;
/// One circuit a tile.
const PATTERN_OF_SINGLE_TILES: u32 = 0;
/// LOAD refuses data at other addresses.
const DATA_ALIGNMENT: u32 = 32;
/// The driver copies parameters into 256 bytes without looking at their size; its own library allows as many beside the
/// record's head.
const MOST_PARAMETERS: usize = 244;
/// WAIT computes its timeout in 32 bits of ns, and cannot be interrupted.
const LONGEST_WAIT: Duration = Duration::from_millis(4000);
/// What a record holds before the driver writes to it, where nothing else stands.
const UNWRITTEN: u8 = 0xa5;
/// Status of a circuit that may be started.
const ACTIVATED: i32 = 2;
const ARGUMENT: i32 = -1;
const BUSY: i32 = -5;

/// A request that failed, or was not made because it would do harm.
#[derive(Debug, thiserror::Error)]
pub enum DrpError {
    /// The call itself failed.
    #[error("{request}: {cause}")]
    Call {
        /// The request.
        request: &'static str,
        /// Why.
        cause: io::Error,
    },
    /// The driver answered with an error.
    #[error("{request}: the driver answers {code} ({})", meaning(*code))]
    Refused {
        /// The request.
        request: &'static str,
        /// The driver's number.
        code: i32,
    },
    /// The answer is none that the request has.
    #[error(
        "{request}: the driver gives no answer that is known; is it the one of rza2m_drp for Linux 4.19?"
    )]
    Unanswered {
        /// The request.
        request: &'static str,
    },
    /// The circuit did not end.
    #[error("WAIT: no end within {} ms", .0.as_millis())]
    Timeout(Duration),
    /// The request was not made.
    #[error("{request} not made: {why}")]
    Guarded {
        /// The request.
        request: &'static str,
        /// What it would do.
        why: &'static str,
    },
}

fn meaning(code: i32) -> &'static str {
    match code {
        ARGUMENT => "wrong argument",
        -2 => "wrong format of circuit data",
        -3 => "wrong checksum of circuit data",
        -4 => "device",
        BUSY => "busy",
        -6 => "internal",
        -7 => "tiles in use",
        -8 => "operating system",
        -9 => "wrong state",
        -10 => "tile pattern",
        -11 => "stopped",
        -13 => "no memory",
        _ => "unknown",
    }
}

/// The DRP's driver as one process has it open: circuits loaded, tiles running.
#[derive(Debug)]
pub struct Session<D> {
    device: D,
    version: u32,
    /// Identifiers of the circuits that were loaded, by tile; 0 where there is none.
    circuits: [u8; TILES],
    /// Mask of the tiles that have been started and not been waited for.
    running: u8,
    /// Whether the driver's state is what is written here.
    is_known: bool,
}

impl<D: DrpDevice> Session<D> {
    /// Initialises the driver, makes on-chip memory known to it and unloads what a former process left.
    ///
    /// # Errors
    /// Requests that fail.
    pub fn open(device: D) -> Result<Self, DrpError> {
        let mut session = Self {
            device,
            version: 0,
            circuits: [0; TILES],
            running: 0,
            is_known: false,
        };
        session.ask_zero("INIT", requests::INIT, &[])?;
        session.version = session.ask("GETVERSION", requests::GETVERSION, &[])?.0 as u32;
        // Always the same range and never copied: the driver finds an earlier mapping by address and size, and a copy
        // of it would be that of former contents, or of none and written to through a null pointer.
        session.ask_zero("MAP", requests::MAP, &[on_chip::BASE, on_chip::SIZE, 0])?;
        session.clear()?;
        Ok(session)
    }

    /// Version that the DRP's driver reports.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// Unloads every circuit, running or not: the way back from every failure.
    ///
    /// # Errors
    /// A request that fails. Nothing but this is possible then.
    pub fn clear(&mut self) -> Result<(), DrpError> {
        self.is_known = false;
        let (result, record) = self.ask("UNLOAD", requests::UNLOAD, &[0])?;
        match result {
            // The driver refuses to unload nothing.
            0 | ARGUMENT => {}
            code => return Err(refusal("UNLOAD", code)),
        }
        if record[4..4 + TILES] != [0; TILES] {
            return Err(DrpError::Unanswered { request: "UNLOAD" });
        }
        (self.circuits, self.running, self.is_known) = ([0; TILES], 0, true);
        Ok(())
    }

    /// Loads a circuit of one tile, once for each of some tiles, and activates it. `data` is its data's place in
    /// on-chip memory.
    ///
    /// # Errors
    /// Data that the driver refuses, tiles in use, requests that fail.
    pub fn load(&mut self, data: u32, tiles: Range<usize>) -> Result<(), DrpError> {
        let request = "LOAD";
        let guard = |why| Err(DrpError::Guarded { request, why });
        self.check_known(request)?;
        if tiles.is_empty() || tiles.end > TILES {
            return guard("there are six tiles");
        }
        if !data.is_multiple_of(DATA_ALIGNMENT) || data.wrapping_sub(on_chip::BASE) >= on_chip::SIZE
        {
            return guard("circuit data lies in on-chip memory at a multiple of 32");
        }
        if self.circuits[tiles.clone()] != [0; TILES][tiles.clone()] {
            return guard("the tiles are in use");
        }
        let mask = mask(tiles.clone());
        self.is_known = false;
        let words = [data, mask.into(), PATTERN_OF_SINGLE_TILES, 0, 0];
        let record = self.ask_zero(request, requests::LOAD, &words)?;
        // The driver uses identifiers as masks of tiles, and it is by them that it finds which tile has ended.
        for tile in 0..TILES {
            let expected = if tiles.contains(&tile) {
                1 << tile
            } else {
                self.circuits[tile]
            };
            if record[4 + tile] != expected {
                return Err(DrpError::Unanswered { request });
            }
        }
        self.ask_zero("ACTIVATE", requests::ACTIVATE, &[mask.into(), 0])?;
        for tile in tiles {
            let (status, _) = self.ask("GETSTATUS", requests::GETSTATUS, &[1 << tile])?;
            if status != ACTIVATED {
                return Err(refusal("GETSTATUS", status));
            }
            self.circuits[tile] = 1 << tile;
        }
        self.is_known = true;
        Ok(())
    }

    /// Starts the circuit of a tile.
    ///
    /// # Errors
    /// A tile without a circuit or with one that runs, parameters of a size that the driver does not check, a request
    /// that fails.
    pub fn start(&mut self, tile: usize, parameters: &[u8]) -> Result<(), DrpError> {
        let request = "START";
        let guard = |why| Err(DrpError::Guarded { request, why });
        self.check_known(request)?;
        // With the identifier 0 the driver looks for its tile for ever.
        let id = match self.circuits.get(tile) {
            Some(&id) if id != 0 => id,
            _ => return guard("the tile has no circuit"),
        };
        if self.running & id != 0 {
            return guard("the circuit runs already");
        }
        if parameters.is_empty() || parameters.len() > MOST_PARAMETERS {
            return guard("parameters have 1 to 244 bytes");
        }
        let mut record = record(&[id.into(), parameters.len() as u32]);
        record[8..][..parameters.len()].copy_from_slice(parameters);
        self.is_known = false;
        self.call(request, requests::START, &mut record)?;
        zero(request, &record)?;
        self.running |= id;
        self.is_known = true;
        Ok(())
    }

    /// Waits until every circuit that was started has ended.
    ///
    /// # Errors
    /// One that has not within `timeout`, at most 4 s; a request that fails.
    pub fn wait(&mut self, timeout: Duration) -> Result<(), DrpError> {
        let request = "WAIT";
        self.check_known(request)?;
        if self.running == 0 {
            // Of no tile the driver says that it has ended.
            let why = "no circuit was started";
            return Err(DrpError::Guarded { request, why });
        }
        let timeout = timeout.clamp(Duration::from_millis(1), LONGEST_WAIT);
        self.is_known = false;
        let words = [self.running.into(), timeout.as_millis() as u32, 0];
        match self.ask(request, requests::WAIT, &words)?.0 {
            0 => {
                (self.running, self.is_known) = (0, true);
                Ok(())
            }
            BUSY => Err(DrpError::Timeout(timeout)),
            code => Err(refusal(request, code)),
        }
    }

    fn check_known(&self, request: &'static str) -> Result<(), DrpError> {
        let why = "a request before it failed; unload first";
        self.is_known
            .then_some(())
            .ok_or(DrpError::Guarded { request, why })
    }

    /// A request whose answer is 0 where it succeeds.
    fn ask_zero(
        &mut self,
        name: &'static str,
        number: u32,
        words: &[u32],
    ) -> Result<Record, DrpError> {
        let (_, record) = self.ask(name, number, words)?;
        zero(name, &record)?;
        Ok(record)
    }

    /// A request and the first word of its answer.
    fn ask(
        &mut self,
        name: &'static str,
        number: u32,
        words: &[u32],
    ) -> Result<(i32, Record), DrpError> {
        let mut record = record(words);
        self.call(name, number, &mut record)?;
        Ok((first(&record), record))
    }

    fn call(
        &mut self,
        request: &'static str,
        number: u32,
        record: &mut Record,
    ) -> Result<(), DrpError> {
        let called = self.device.request(number, record);
        called.map_err(|cause| DrpError::Call { request, cause })
    }
}

fn record(words: &[u32]) -> Record {
    let mut record = [UNWRITTEN; RECORD_BYTES];
    for (bytes, word) in record.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    record
}

fn first(record: &Record) -> i32 {
    let [a, b, c, d, ..] = *record;
    i32::from_le_bytes([a, b, c, d])
}

fn zero(request: &'static str, record: &Record) -> Result<(), DrpError> {
    match first(record) {
        0 => Ok(()),
        code => Err(refusal(request, code)),
    }
}

fn refusal(request: &'static str, code: i32) -> DrpError {
    if meaning(code) == "unknown" {
        DrpError::Unanswered { request }
    } else {
        DrpError::Refused { request, code }
    }
}

/// The mask of a range of tiles, which is also that of their circuits' identifiers.
fn mask(tiles: Range<usize>) -> u8 {
    tiles.fold(0, |mask, tile| mask | 1 << tile)
}
