//! From a raw image to the grey one that the detector takes.
//!
//! This is where an accelerator stands, and the only place: of the detector's own first stages (extrema of tiles,
//! thresholds by them, thin dark lines) the library has no circuit, while the conversion that comes before them is one
//! of its circuits.

use crate::drp::{CircuitData, DrpDevice, Pipeline, PipelineError, SelfTest, Session};
use crate::{OnChipLayout, PhysicalMemory};
use sextant_drp_circuits::{Circuit, Model, Raster};
use std::io;

/// Images that the CPU takes over after a failure before the accelerator is tried again: the first number, doubled with
/// each attempt in vain up to the second.
const PAUSE_IMAGES: [u32; 2] = [30, 3000];

/// From a raw image in on-chip memory to a grey one.
pub trait Preprocess<M: PhysicalMemory> {
    /// Makes `grey` of the raw image at the physical address `raw`; both have the size that the preprocessing was made
    /// for.
    ///
    /// # Errors
    /// On-chip memory out of reach, `grey` of another size. An accelerator's failures are none: the CPU takes over.
    fn run(&mut self, memory: &mut M, raw: u32, grey: &mut [u8]) -> io::Result<()>;

    /// Images that the CPU had to make in place of an accelerator.
    fn fallbacks(&self) -> u64 {
        0
    }

    /// An accelerator's failure since the last call, to be logged.
    fn take_failure(&mut self) -> Option<PipelineError> {
        None
    }
}

/// The models of circuits on the CPU: the reference.
#[derive(Debug)]
pub struct Cpu {
    models: Vec<&'static Model>,
    size: [usize; 2],
    /// The image between two models.
    image: Vec<u8>,
}

impl Cpu {
    /// Bayer to grey by the likeliest model.
    pub fn new(size: [usize; 2]) -> Self {
        Self::with_models(Circuit::Bayer2Grayscale.models().iter().take(1), size)
    }

    fn with_models(
        models: impl Iterator<Item = &'static Model>,
        [width, height]: [usize; 2],
    ) -> Self {
        Self {
            models: models.collect(),
            size: [width, height],
            image: vec![0; width * height],
        }
    }
}

impl<M: PhysicalMemory> Preprocess<M> for Cpu {
    fn run(&mut self, memory: &mut M, raw: u32, grey: &mut [u8]) -> io::Result<()> {
        // On-chip memory is read once: it is not cached.
        memory.copy_out(raw, &mut self.image)?;
        for (i, model) in self.models.iter().enumerate() {
            if i > 0 {
                self.image.copy_from_slice(grey);
            }
            Raster::new(&self.image, self.size)
                .and_then(|image| model.run(&image, grey))
                .map_err(|cause| io::Error::new(io::ErrorKind::InvalidInput, cause))?;
        }
        Ok(())
    }
}

/// Whether circuits in this order make a grey image of a raw one.
///
/// # Errors
/// Why not.
pub fn check_order(mut circuits: impl Iterator<Item = Circuit>) -> Result<(), &'static str> {
    let makes_grey = |circuit| matches!(circuit, Circuit::Bayer2Grayscale | Circuit::GaussianBlur);
    if !circuits.next().is_some_and(makes_grey)
        || circuits.any(|circuit| circuit == Circuit::Bayer2Grayscale)
    {
        return Err(
            "the first circuit must be Bayer2Grayscale, or GaussianBlur, which makes (R + 2 G + \
             B) / 4; others may follow",
        );
    }
    Ok(())
}

/// Circuits of the DRP, with the CPU in their place while they fail. Both give the same bytes, by the self-test.
#[derive(Debug)]
pub struct Accelerated<D> {
    pipeline: Pipeline<D>,
    cpu: Cpu,
    /// Images that the CPU takes before the next attempt; none while the DRP works.
    paused: Option<u32>,
    next_pause: u32,
    fallbacks: u64,
    failure: Option<PipelineError>,
}

impl<D: DrpDevice> Accelerated<D> {
    /// Opens a session, loads the circuits and tests them. Gives also what to tell about it.
    ///
    /// # Errors
    /// A first circuit that makes no grey image, and whatever makes the DRP unusable: the caller decides for [`Cpu`]
    /// then.
    pub fn start<M: PhysicalMemory>(
        device: D,
        memory: &mut M,
        circuits: Vec<CircuitData>,
        size: [usize; 2],
        layout: OnChipLayout,
    ) -> Result<(Self, Vec<SelfTest>), PipelineError> {
        check_order(circuits.iter().map(|data| data.circuit))
            .map_err(|why| PipelineError::Circuits(why.to_owned()))?;
        let session = Session::open(device)?;
        let (pipeline, tests) = Pipeline::start(session, memory, circuits, size, layout)?;
        let accelerated = Self {
            cpu: Cpu::with_models(pipeline.models(), size),
            pipeline,
            paused: None,
            next_pause: PAUSE_IMAGES[0],
            fallbacks: 0,
            failure: None,
        };
        Ok((accelerated, tests))
    }

    /// Version that the DRP's driver reports.
    pub fn version(&self) -> u32 {
        self.pipeline.version()
    }

    /// By the DRP, loaded anew where it failed before.
    fn run_circuits<M: PhysicalMemory>(
        &mut self,
        memory: &mut M,
        raw: u32,
        grey: &mut [u8],
    ) -> Result<(), PipelineError> {
        if self.paused.is_some() {
            self.pipeline.recover(memory)?;
        }
        self.pipeline.run(memory, raw, grey)
    }

    /// Whether this image is one that the CPU takes without an attempt.
    fn pauses(&mut self) -> bool {
        match &mut self.paused {
            Some(left) if *left > 0 => {
                *left -= 1;
                true
            }
            _ => false,
        }
    }
}

impl<D: DrpDevice, M: PhysicalMemory> Preprocess<M> for Accelerated<D> {
    fn run(&mut self, memory: &mut M, raw: u32, grey: &mut [u8]) -> io::Result<()> {
        if !self.pauses() {
            match self.run_circuits(memory, raw, grey) {
                Ok(()) => {
                    (self.paused, self.next_pause) = (None, PAUSE_IMAGES[0]);
                    return Ok(());
                }
                Err(failure) => {
                    self.failure = Some(failure);
                    self.paused = Some(self.next_pause);
                    self.next_pause = (self.next_pause * 2).min(PAUSE_IMAGES[1]);
                }
            }
        }
        self.fallbacks += 1;
        self.cpu.run(memory, raw, grey)
    }

    fn fallbacks(&self) -> u64 {
        self.fallbacks
    }

    fn take_failure(&mut self) -> Option<PipelineError> {
        self.failure.take()
    }
}
