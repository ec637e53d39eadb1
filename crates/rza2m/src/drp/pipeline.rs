//! Circuits one after the other, each on its share of the six tiles, from an image in on-chip memory to another there.
//!
//! The driver does not say whether a circuit succeeded, only that it ended. So before each start some words of the
//! output are set to what they must not become, and compared with the model afterwards, among them the last of each
//! band: a circuit that wrote nothing, only part, or an earlier image is found. A wrong pixel elsewhere is not.

use super::self_test::{self, N_PATTERNS};
use super::session::TILES;
use super::{DrpDevice, DrpError, SelfTest, Session};
use crate::{OnChipLayout, PhysicalMemory};
use sextant_drp_circuits::{Band, Bands, Circuit, Model, Raster, SizeError};
use std::io;
use std::ops::Range;
use std::time::Duration;

/// An image takes a few milliseconds (the vendor gives 0.4 ms for 1280x768 and six tiles); one that takes as long as
/// this has failed.
const TIMEOUT: Duration = Duration::from_millis(100);
/// Words of each band that are checked.
const SPOTS_IN_BAND: usize = 8;
/// Pixels in a word.
const WORD: usize = 4;

/// A circuit and its data, as the user's file has it.
#[derive(Debug, Clone)]
pub struct CircuitData {
    /// The circuit.
    pub circuit: Circuit,
    /// Its configuration data.
    pub bytes: Vec<u8>,
}

/// Why an image has not been processed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// A request.
    #[error(transparent)]
    Drp(#[from] DrpError),
    /// On-chip memory.
    #[error("on-chip memory: {0}")]
    Memory(#[from] io::Error),
    /// An image of another size.
    #[error(transparent)]
    Size(#[from] SizeError),
    /// Circuits that cannot be used.
    #[error("{0}")]
    Circuits(String),
    /// The circuit follows none of its models.
    #[error("no model fits: {0}")]
    NoModel(SelfTest),
    /// A circuit ended without having written what it should.
    #[error("{circuit} ended, but the row {row} of its output is not what it should be")]
    Output {
        /// The circuit.
        circuit: Circuit,
        /// The row.
        row: usize,
    },
}

/// Circuits, loaded and tested.
#[derive(Debug)]
pub struct Pipeline<D> {
    session: Session<D>,
    stages: Vec<Stage>,
    size: [usize; 2],
    layout: OnChipLayout,
    /// Images so far: each is checked at other spots.
    n_images: u32,
}

#[derive(Debug)]
struct Stage {
    circuit: Circuit,
    bytes: Vec<u8>,
    tiles: Range<usize>,
    model: &'static Model,
}

/// A word of an output: the column of its first pixel and its row.
type Spot = [usize; 2];

impl<D: DrpDevice> Pipeline<D> {
    /// Loads the circuits, compares each with its models on fixed patterns, and keeps to the ones that fit. Gives also
    /// what to tell about it.
    ///
    /// # Errors
    /// No circuits or too many, an image too small for one, requests that fail, a circuit that no model fits.
    pub fn start(
        session: Session<D>,
        memory: &mut impl PhysicalMemory,
        circuits: Vec<CircuitData>,
        size: [usize; 2],
        layout: OnChipLayout,
    ) -> Result<(Self, Vec<SelfTest>), PipelineError> {
        let n_circuits = circuits.len();
        if !(1..=TILES).contains(&n_circuits) || layout.circuit_data.len() != n_circuits {
            return Err(PipelineError::Circuits(format!(
                "{n_circuits} circuits, but 1 to {TILES} are possible"
            )));
        }
        let stages = circuits
            .into_iter()
            .enumerate()
            .map(|(i, CircuitData { circuit, bytes })| {
                let [width, height] = circuit.least_size();
                if size[0] < width || size[1] < height || !size[0].is_multiple_of(WORD) {
                    return Err(PipelineError::Circuits(format!(
                        "{circuit} takes images of at least {width}x{height} pixels"
                    )));
                }
                Ok(Stage {
                    circuit,
                    bytes,
                    tiles: i * TILES / n_circuits..(i + 1) * TILES / n_circuits,
                    model: &circuit.models()[0],
                })
            });
        let mut pipeline = Self {
            session,
            stages: stages.collect::<Result<_, _>>()?,
            size,
            layout,
            n_images: 0,
        };
        pipeline.load(memory)?;
        let mut tests = Vec::with_capacity(n_circuits);
        for i in 0..n_circuits {
            let models = pipeline.stages[i].circuit.models();
            let test = pipeline.test(memory, i, models.iter(), N_PATTERNS)?;
            match test.fitting() {
                Some(model) => pipeline.stages[i].model = model,
                None => return Err(PipelineError::NoModel(test)),
            }
            tests.push(test);
        }
        Ok((pipeline, tests))
    }

    /// The models that the circuits follow, in their order.
    pub fn models(&self) -> impl Iterator<Item = &'static Model> + Clone {
        self.stages.iter().map(|stage| stage.model)
    }

    /// Version that the DRP's driver reports.
    pub fn version(&self) -> u32 {
        self.session.version()
    }

    /// Processes the image at `raw` and copies the result out.
    ///
    /// # Errors
    /// Requests that fail, output that was not written, or `grey` of another size. Nothing in `grey` is valid then, and
    /// [`Self::recover`] comes next.
    pub fn run(
        &mut self,
        memory: &mut impl PhysicalMemory,
        raw: u32,
        grey: &mut [u8],
    ) -> Result<(), PipelineError> {
        Raster::new(grey, self.size)?;
        let mut at = raw;
        for i in 0..self.stages.len() {
            let output = self.layout.outputs[i % 2];
            self.run_stage(memory, i, at, output)?;
            at = output;
        }
        memory.copy_out(at, grey)?;
        Ok(())
    }

    /// Loads everything anew after a failure and tests it with one pattern, by the models found at the start.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn recover(&mut self, memory: &mut impl PhysicalMemory) -> Result<(), PipelineError> {
        self.session.clear()?;
        self.load(memory)?;
        for i in 0..self.stages.len() {
            let model = self.stages[i].model;
            let test = self.test(memory, i, std::iter::once(model), 1)?;
            if test.fitting().is_none() {
                return Err(PipelineError::NoModel(test));
            }
        }
        Ok(())
    }

    fn load(&mut self, memory: &mut impl PhysicalMemory) -> Result<(), PipelineError> {
        for (stage, data) in self.stages.iter().zip(&self.layout.circuit_data) {
            memory.copy_in(*data, &stage.bytes)?;
            self.session.load(*data, stage.tiles.clone())?;
        }
        Ok(())
    }

    fn test(
        &mut self,
        memory: &mut impl PhysicalMemory,
        stage: usize,
        models: impl Iterator<Item = &'static Model>,
        n_patterns: usize,
    ) -> Result<SelfTest, PipelineError> {
        let [width, height] = self.size;
        let mut input = vec![0; width * height];
        let (mut found, mut expected) = (input.clone(), input.clone());
        let mut test = SelfTest::new(self.stages[stage].circuit, models);
        let output = self.layout.outputs[0];
        for pattern in 0..n_patterns {
            self_test::draw(pattern, width, &mut input);
            memory.copy_in(self.layout.test_input, &input)?;
            // Not the circuit's output by chance: that of no model is the complement of the input everywhere.
            input
                .iter()
                .zip(&mut found)
                .for_each(|(pixel, found)| *found = !pixel);
            memory.copy_in(output, &found)?;
            self.start_and_wait(stage, self.layout.test_input, output)?;
            memory.copy_out(output, &mut found)?;
            for trial in &mut test.trials {
                trial
                    .model
                    .run(&Raster::new(&input, self.size)?, &mut expected)?;
                trial.difference.add(&found, &expected);
            }
        }
        Ok(test)
    }

    /// One circuit on the whole image, with its spots checked.
    fn run_stage(
        &mut self,
        memory: &mut impl PhysicalMemory,
        stage: usize,
        input: u32,
        output: u32,
    ) -> Result<(), PipelineError> {
        let Stage { circuit, model, .. } = self.stages[stage];
        let [width, _] = self.size;
        let address = |[x, y]: Spot| output + (y * width + x) as u32;
        self.n_images = self.n_images.wrapping_add(1);
        let spots = self
            .bands(stage)
            .flat_map(|(tile, band)| spots(self.n_images, tile, &band, width));
        let spots: [Option<Spot>; TILES * SPOTS_IN_BAND] = first_of(spots);
        let mut expected = [0_u32; TILES * SPOTS_IN_BAND];
        for (spot, expected) in spots.iter().flatten().zip(&mut expected) {
            *expected = self.expect(memory, model, input, *spot)?;
            memory.write_word(address(*spot), !*expected)?;
        }
        self.start_and_wait(stage, input, output)?;
        for (spot, expected) in spots.iter().flatten().zip(expected) {
            if memory.read_word(address(*spot))? != expected {
                let row = spot[1];
                return Err(PipelineError::Output { circuit, row });
            }
        }
        Ok(())
    }

    /// What a model makes of the pixels of a word.
    fn expect(
        &self,
        memory: &impl PhysicalMemory,
        model: &Model,
        input: u32,
        [x, y]: Spot,
    ) -> Result<u32, PipelineError> {
        let [width, height] = self.size;
        // Three words of three rows hold all that its windows see.
        let mut words = [[0; 3 * WORD]; 3];
        for (dy, row) in words.iter_mut().enumerate() {
            let y = (y + dy).saturating_sub(1).min(height - 1);
            for (dx, word) in row.chunks_exact_mut(WORD).enumerate() {
                let x = (x + dx * WORD).saturating_sub(WORD).min(width - WORD);
                let value = memory.read_word(input + (y * width + x) as u32)?;
                word.copy_from_slice(&value.to_le_bytes());
            }
        }
        let read = |column: usize, row: usize| words[row + 1 - y][column + WORD - x];
        let pixels = std::array::from_fn(|i| model.pixel(self.size, [x + i, y], read));
        Ok(u32::from_le_bytes(pixels))
    }

    /// Starts a circuit on every band and waits for all.
    fn start_and_wait(&mut self, stage: usize, input: u32, output: u32) -> Result<(), DrpError> {
        let [width, _] = self.size;
        for (tile, band) in self.bands(stage) {
            let offset = (band.top * width) as u32;
            let parameters = parameters(input + offset, output + offset, width, &band);
            self.session.start(tile, &parameters)?;
        }
        self.session.wait(TIMEOUT)
    }

    /// Each band of the image and the tile that it is for.
    fn bands(&self, stage: usize) -> impl Iterator<Item = (usize, Band)> + use<D> {
        let Stage { circuit, tiles, .. } = &self.stages[stage];
        let bands = Bands::new(*circuit, self.size[1], tiles.len());
        tiles.clone().zip(bands)
    }
}

/// The record that every circuit here takes: source and destination, width and height, whether the band holds the first
/// and the last row. Source: renesas-rz/rza2m_drp, `drp-lib/drp_lib/*/*.h`.
fn parameters(source: u32, destination: u32, width: usize, band: &Band) -> [u8; 16] {
    let mut record = [0; 16];
    record[0..4].copy_from_slice(&source.to_le_bytes());
    record[4..8].copy_from_slice(&destination.to_le_bytes());
    record[8..10].copy_from_slice(&(width as u16).to_le_bytes());
    record[10..12].copy_from_slice(&(band.height as u16).to_le_bytes());
    (record[12], record[13]) = (band.is_first.into(), band.is_last.into());
    record
}

/// Words of a band to check: some in its first row, the last of its last row, and others that change from image to
/// image.
fn spots(image: u32, tile: usize, band: &Band, width: usize) -> impl Iterator<Item = Spot> + use<> {
    let Band { top, height, .. } = *band;
    let n_words = width / WORD;
    (0..SPOTS_IN_BAND).map(move |i| {
        // Multiplicative hash (Knuth, The Art of Computer Programming, volume 3, section 6.4).
        let seed = image.wrapping_mul(TILES as u32 * SPOTS_IN_BAND as u32)
            + (tile * SPOTS_IN_BAND + i) as u32;
        let hash = seed.wrapping_mul(2_654_435_769);
        let column = ((hash >> 16) as usize % n_words) * WORD;
        let row = top + (hash & 0xffff) as usize % height;
        match i {
            0 => [column, top],
            1 => [(n_words - 1) * WORD, top + height - 1],
            _ => [column, row],
        }
    })
}

fn first_of<const N: usize>(items: impl Iterator<Item = Spot>) -> [Option<Spot>; N] {
    let mut items = items.fuse();
    std::array::from_fn(|_| items.next())
}
