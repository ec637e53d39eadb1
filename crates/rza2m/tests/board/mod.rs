//! An RZ/A2M that is not there: on-chip memory, the camera path's registers, a sensor, and the DRP's driver with its
//! twelve requests and its traps.
//!
//! Written after the driver's source (`drp_linux.c`, `r_dk2_if.c` and `r_dk2_core.c` of renesas-rz/rza2m_drp), from its
//! side: it shares no code with the session. What would crash the real kernel, corrupt its memory or hang the board is
//! a *violation* here.

#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

use sextant_drp_circuits::{Circuit, Raster};
use sextant_rza2m::drp::{CircuitData, requests};
use sextant_rza2m::{DrpDevice, PhysicalMemory, SensorBus};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::rc::Rc;
use std::time::Duration;

pub const BASE: u32 = 0x8000_0000;
pub const SIZE: usize = 4 << 20;
const TILES: usize = 6;

/// What happened to the board, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    Register(u32, u32),
    Sensor(u16, u8),
    Pause(Duration),
}

/// What goes wrong with a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The call fails.
    Call,
    /// The driver answers with an error.
    Refused(i32),
    /// The driver does not know the request: it succeeds and answers nothing.
    Unknown,
    /// START: the circuit never ends.
    Endless,
    /// START: the circuit ends, but writes only after the next request.
    Late,
    /// START: the circuit ends without having written.
    Idle,
    /// START: the circuit ends after half of its rows.
    Partial,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Status {
    Free,
    Loaded,
    Activated,
    Started,
}

/// A range that was mapped: address as the driver sees it, where it was copied from, its size.
#[derive(Debug, Clone, Copy)]
struct Config {
    address: u32,
    copied_from: u32,
    size: u32,
}

#[derive(Debug, Clone)]
struct Job {
    tile: usize,
    /// Circuit and model, as the data said.
    kind: [u8; 2],
    parameters: [u8; 16],
    fault: Option<Fault>,
}

#[derive(Debug)]
pub struct State {
    pub memory: Vec<u8>,
    pub registers: BTreeMap<u32, u32>,
    pub events: Vec<Event>,
    pub sensor: BTreeMap<u16, u8>,
    pub sensor_answers: bool,
    /// What the kernel would not have survived.
    pub violations: Vec<String>,
    /// Requests so far, by number.
    pub requests: Vec<u32>,
    /// Faults of requests to come: a function of the request's place and number.
    pub faults: fn(u64, u32, u64) -> Option<Fault>,
    pub seed: u64,
    init_called: bool,
    is_initialised: bool,
    configs: Vec<Config>,
    ids: [u8; TILES],
    kinds: [[u8; 2]; TILES],
    status: [Status; TILES],
    finished: u8,
    jobs: Vec<Job>,
    late: Vec<Job>,
}

/// Handles to one board.
#[derive(Debug, Clone)]
pub struct Board(pub Rc<RefCell<State>>);

pub fn no_faults(_: u64, _: u32, _: u64) -> Option<Fault> {
    None
}

/// Data of a circuit that follows a model, by its index; one that none describes beyond the last.
pub fn circuit_data(circuit: Circuit, model: u8) -> CircuitData {
    let number = Circuit::ALL.iter().position(|c| *c == circuit).unwrap() as u8;
    let mut bytes = b"FAKE".to_vec();
    bytes.extend([number, model]);
    bytes.resize(1000, 0x5a);
    CircuitData { circuit, bytes }
}

impl Board {
    pub fn new() -> Self {
        // Standby bits are set at reset.
        let registers = BTreeMap::from([
            (0xfcfe_042c, 0xff),
            (0xfcfe_0430, 0xff),
            (0xe803_f004, 0x18),
        ]);
        Self(Rc::new(RefCell::new(State {
            memory: vec![0x77; SIZE],
            registers,
            events: Vec::new(),
            sensor: BTreeMap::from([(0, 0x02), (1, 0x19)]),
            sensor_answers: true,
            violations: Vec::new(),
            requests: Vec::new(),
            faults: no_faults,
            seed: 0,
            init_called: false,
            is_initialised: false,
            configs: Vec::new(),
            ids: [0; TILES],
            kinds: [[0; 2]; TILES],
            status: [Status::Free; TILES],
            finished: 0,
            jobs: Vec::new(),
            late: Vec::new(),
        })))
    }

    pub fn violations(&self) -> Vec<String> {
        self.0.borrow().violations.clone()
    }

    /// Puts an image into the buffer that VIN fills next.
    pub fn deliver(&self, image: &[u8]) {
        let mut state = self.0.borrow_mut();
        let status = state.registers[&0xe803_f004] >> 3 & 3;
        let next = if status == 3 { 0 } else { (status + 1) % 3 };
        let address = (state.registers[&(0xe803_f030 + 4 * next)] - BASE) as usize;
        state.memory[address..][..image.len()].copy_from_slice(image);
        state.registers.insert(0xe803_f004, next << 3);
    }
}

impl State {
    fn violate(&mut self, what: impl Into<String>) {
        self.violations.push(what.into());
    }

    fn range(&self, address: u32, length: usize, alignment: u32) -> io::Result<usize> {
        let offset = address.wrapping_sub(BASE) as usize;
        if offset >= SIZE || length > SIZE - offset || !address.is_multiple_of(alignment) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("{address:#x}"),
            ));
        }
        Ok(offset)
    }

    fn check_clocked(&mut self, address: u32) {
        let stopped = |register, bit: u32| self.registers[&register] & bit != 0;
        let (vin, csi2) = (stopped(0xfcfe_042c, 1 << 6), stopped(0xfcfe_0430, 1 << 5));
        if (address >> 12 == 0xe803f && vin) || (address >> 12 == 0xe8209 && csi2) {
            self.violate(format!("register {address:#x} of a module without a clock"));
        }
    }
}

impl PhysicalMemory for Board {
    fn read_byte(&self, address: u32) -> io::Result<u8> {
        Ok(*self.0.borrow().registers.get(&address).unwrap_or(&0) as u8)
    }

    fn write_byte(&mut self, address: u32, value: u8) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        state.registers.insert(address, value.into());
        state.events.push(Event::Register(address, value.into()));
        Ok(())
    }

    fn read_word(&self, address: u32) -> io::Result<u32> {
        let mut state = self.0.borrow_mut();
        if address < 0xe000_0000 {
            let at = state.range(address, 4, 4)?;
            return Ok(u32::from_le_bytes(
                state.memory[at..][..4].try_into().unwrap(),
            ));
        }
        state.check_clocked(address);
        Ok(*state.registers.get(&address).unwrap_or(&0))
    }

    fn write_word(&mut self, address: u32, value: u32) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        if address < 0xe000_0000 {
            let at = state.range(address, 4, 4)?;
            state.memory[at..][..4].copy_from_slice(&value.to_le_bytes());
            return Ok(());
        }
        state.check_clocked(address);
        state.registers.insert(address, value);
        state.events.push(Event::Register(address, value));
        Ok(())
    }

    fn copy_out(&self, address: u32, bytes: &mut [u8]) -> io::Result<()> {
        let state = self.0.borrow();
        let at = state.range(address, bytes.len(), 8)?;
        bytes.copy_from_slice(&state.memory[at..][..bytes.len()]);
        Ok(())
    }

    fn copy_in(&mut self, address: u32, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        let at = state.range(address, bytes.len(), 8)?;
        state.memory[at..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn pause(&mut self, duration: Duration) {
        self.0.borrow_mut().events.push(Event::Pause(duration));
    }
}

impl SensorBus for Board {
    fn read(&mut self, register: u16) -> io::Result<u8> {
        let state = self.0.borrow();
        if !state.sensor_answers {
            return Err(io::Error::from_raw_os_error(6)); // ENXIO
        }
        Ok(*state.sensor.get(&register).unwrap_or(&0))
    }

    fn write(&mut self, register: u16, value: u8) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        if !state.sensor_answers {
            return Err(io::Error::from_raw_os_error(6));
        }
        state.sensor.insert(register, value);
        state.events.push(Event::Sensor(register, value));
        Ok(())
    }
}

fn word(record: &[u8], index: usize) -> u32 {
    u32::from_le_bytes(record[4 * index..][..4].try_into().unwrap())
}

fn answer(record: &mut [u8], result: i32) {
    record[..4].copy_from_slice(&result.to_le_bytes());
}

impl DrpDevice for Board {
    fn request(&mut self, number: u32, record: &mut requests::Record) -> io::Result<()> {
        let mut state = self.0.borrow_mut();
        let place = state.requests.len() as u64;
        state.requests.push(number);
        let late = std::mem::take(&mut state.late);
        late.iter().for_each(|job| state.compute(job));
        let fault = (state.faults)(place, number, state.seed);
        match fault {
            Some(Fault::Call) => return Err(io::Error::from_raw_os_error(13)),
            Some(Fault::Refused(code)) => {
                answer(record, code);
                return Ok(());
            }
            Some(Fault::Unknown) => return Ok(()),
            _ => {}
        }
        match number {
            requests::INIT => {
                if !state.init_called {
                    (state.init_called, state.is_initialised) = (true, true);
                }
                answer(record, 0);
            }
            requests::UNINIT => {
                state.is_initialised = false;
                answer(record, 0);
            }
            requests::GETVERSION => answer(record, 0x0100),
            requests::GETINFO => state.violate("GETINFO follows a pointer of user space"),
            requests::MAP => state.map(record),
            requests::WAIT => state.wait(record),
            requests::INACTIVATE => answer(record, -6),
            _ if !state.is_initialised => answer(record, -9),
            requests::LOAD => state.load(record),
            requests::UNLOAD => state.unload(record),
            requests::ACTIVATE => state.activate(record),
            requests::START => state.start(record, fault),
            requests::GETSTATUS => {
                let id = record[0];
                let tile = state.ids.iter().position(|i| *i == id && id != 0);
                answer(record, tile.map_or(-1, |tile| state.status[tile] as i32));
            }
            // Unknown: success.
            _ => {}
        }
        Ok(())
    }
}

impl State {
    fn map(&mut self, record: &mut [u8]) {
        let [address, size, copy] = [0, 1, 2].map(|i| word(record, i));
        for config in self
            .configs
            .clone()
            .iter()
            .filter(|config| config.size == size)
        {
            if config.address == address {
                return answer(record, 0);
            }
            if config.copied_from == address {
                if copy == 0 {
                    return self.violate("MAP writes through a null pointer");
                }
                record[4..8].copy_from_slice(&config.address.to_le_bytes());
                return answer(record, 0);
            }
        }
        if self.configs.len() == 32 {
            return answer(record, -6);
        }
        let copied = 0x4040_0000 + (self.configs.len() as u32) * 0x0010_0000;
        let config = if copy == 0 {
            Config {
                address,
                copied_from: 0,
                size,
            }
        } else {
            Config {
                address: copied,
                copied_from: address,
                size,
            }
        };
        self.configs.push(config);
        if copy != 0 {
            record[4..8].copy_from_slice(&copied.to_le_bytes());
        }
        answer(record, 0);
    }

    fn load(&mut self, record: &mut [u8]) {
        let [address, top, pattern] = [0, 1, 2].map(|i| word(record, i));
        record[4..10].copy_from_slice(&self.ids);
        let config = self
            .configs
            .iter()
            .find(|config| address.wrapping_sub(config.address) < config.size);
        let Some(_) = config else {
            return answer(record, -1);
        };
        if !address.is_multiple_of(32) || top == 0 || top & !0x3f != 0 {
            return answer(record, -1);
        }
        let Ok(at) = self.range(address, 6, 32) else {
            return self.violate(format!("circuit data at {address:#x}"));
        };
        let data: [u8; 6] = self.memory[at..][..6].try_into().unwrap();
        let [b'F', b'A', b'K', b'E', circuit, model] = data else {
            return answer(record, -2);
        };
        if pattern != 0 {
            return answer(record, -10);
        }
        let tiles = (0..TILES).filter(|tile| top >> tile & 1 == 1);
        if tiles.clone().any(|tile| self.ids[tile] != 0) {
            return answer(record, -7);
        }
        for tile in tiles {
            self.ids[tile] = 1 << tile;
            self.kinds[tile] = [circuit, model];
            self.status[tile] = Status::Loaded;
        }
        record[4..10].copy_from_slice(&self.ids);
        answer(record, 0);
    }

    fn unload(&mut self, record: &mut [u8]) {
        let id = record[0];
        let targets =
            (0..TILES).filter(|&tile| self.ids[tile] != 0 && (id == 0 || id & self.ids[tile] != 0));
        let targets: Vec<usize> = targets.collect();
        let result = if targets.is_empty() { -1 } else { 0 };
        for tile in targets {
            (self.ids[tile], self.status[tile]) = (0, Status::Free);
            self.jobs.retain(|job| job.tile != tile);
        }
        record[4..10].copy_from_slice(&self.ids);
        answer(record, result);
    }

    fn activate(&mut self, record: &mut [u8]) {
        let (mask, frequency) = (record[0], word(record, 1));
        if frequency != 0 {
            return answer(record, -1);
        }
        let targets = (0..TILES)
            .filter(|tile| self.ids[*tile] & mask != 0 || mask == 0 && self.ids[*tile] != 0);
        let targets: Vec<usize> = targets.collect();
        if targets.is_empty() {
            return answer(record, -1);
        }
        if targets
            .iter()
            .any(|&tile| self.status[tile] != Status::Loaded)
        {
            return answer(record, -9);
        }
        targets
            .iter()
            .for_each(|&tile| self.status[tile] = Status::Activated);
        answer(record, 0);
    }

    fn start(&mut self, record: &mut [u8], fault: Option<Fault>) {
        let (id, size) = (word(record, 0), word(record, 1));
        if id == 0 {
            return self.violate("START looks for tile 0 for ever");
        }
        if size > 248 {
            return self.violate("START reads past the kernel's stack");
        }
        let tile = self.ids.iter().position(|i| u32::from(*i) == id);
        // What ended is forgotten before anything is checked.
        if let Some(tile) = tile {
            self.finished &= !(1 << tile);
        }
        let Some(tile) = tile.filter(|_| size > 0) else {
            return answer(record, -1);
        };
        if self.status[tile] != Status::Activated {
            return answer(record, -9);
        }
        self.status[tile] = Status::Started;
        self.jobs.push(Job {
            tile,
            kind: self.kinds[tile],
            parameters: record[8..24].try_into().unwrap(),
            fault,
        });
        answer(record, 0);
    }

    fn wait(&mut self, record: &mut [u8]) {
        let (mask, timeout) = (word(record, 0) as u8, word(record, 1));
        if timeout >= 4295 {
            self.violate("WAIT overflows its timeout");
        }
        for job in std::mem::take(&mut self.jobs) {
            match job.fault {
                Some(Fault::Endless) => {
                    self.jobs.push(job);
                    continue;
                }
                Some(Fault::Late) => self.late.push(job.clone()),
                Some(Fault::Idle) => {}
                _ => self.compute(&job),
            }
            self.finished |= 1 << job.tile;
            self.status[job.tile] = Status::Activated;
        }
        answer(record, if self.finished & mask == mask { 0 } else { -5 });
    }

    /// What the hardware does: rows beyond the band are read where it does not touch the image's edge.
    fn compute(&mut self, job: &Job) {
        let (source, destination) = (word(&job.parameters, 0), word(&job.parameters, 1));
        let sizes = word(&job.parameters, 2);
        let (width, height) = ((sizes & 0xffff) as usize, (sizes >> 16) as usize);
        let [is_first, is_last] = [job.parameters[12] == 1, job.parameters[13] == 1];
        // Two rows, which keep the Bayer order.
        let (above, below) = (2 * usize::from(!is_first), 2 * usize::from(!is_last));
        let rows = above + height + below;
        let (Ok(from), Ok(to)) = (
            self.range(source - (above * width) as u32, rows * width, 1),
            self.range(destination, height * width, 1),
        ) else {
            return self.violate(format!(
                "a circuit works from {source:#x} to {destination:#x}"
            ));
        };
        let input = self.memory[from..][..rows * width].to_vec();
        let circuit = Circuit::ALL[usize::from(job.kind[0])];
        let [least_width, least_height] = circuit.least_size();
        if width < least_width || height < least_height || width > 1280 || height > 960 {
            return self.violate(format!("{circuit} of {width}x{height}"));
        }
        let model = circuit.models().get(usize::from(job.kind[1]));
        let mut output = vec![0; rows * width];
        let raster = Raster::new(&input, [width, rows]).unwrap();
        model
            .unwrap_or(&circuit.models()[0])
            .run(&raster, &mut output)
            .unwrap();
        if model.is_none() {
            output.iter_mut().for_each(|pixel| *pixel ^= 1);
        }
        let written = if job.fault == Some(Fault::Partial) {
            height / 2
        } else {
            height
        };
        let output = &output[above * width..][..written * width];
        self.memory[to..][..output.len()].copy_from_slice(output);
    }
}
