//! Which model a circuit follows, found by running it on fixed patterns.

use sextant_drp_circuits::{Circuit, Model};
use std::fmt;

/// How a circuit's output differed from a model's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Difference {
    /// Pixels compared.
    pub compared: u64,
    /// Pixels that differ.
    pub differing: u64,
    /// Greatest difference, grey levels.
    pub greatest: u8,
}

/// The comparison of a circuit with one of its models.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// The model.
    pub model: &'static Model,
    /// How the circuit differed from it.
    pub difference: Difference,
}

/// The comparison of a circuit with its models.
#[derive(Debug, Clone)]
pub struct SelfTest {
    /// The circuit.
    pub circuit: Circuit,
    /// Each of its models.
    pub trials: Vec<Trial>,
}

impl Difference {
    pub(super) fn add(&mut self, found: &[u8], expected: &[u8]) {
        self.compared += found.len() as u64;
        for (found, expected) in found.iter().zip(expected) {
            self.differing += u64::from(found != expected);
            self.greatest = self.greatest.max(found.abs_diff(*expected));
        }
    }
}

impl SelfTest {
    pub(super) fn new(circuit: Circuit, models: impl Iterator<Item = &'static Model>) -> Self {
        let difference = Difference::default();
        let trials = models.map(|model| Trial { model, difference });
        Self {
            circuit,
            trials: trials.collect(),
        }
    }

    /// The first model that no pixel contradicts.
    pub fn fitting(&self) -> Option<&'static Model> {
        let mut trials = self.trials.iter();
        let fits =
            |trial: &&Trial| trial.difference.compared > 0 && trial.difference.differing == 0;
        trials.find(fits).map(|trial| trial.model)
    }
}

impl fmt::Display for SelfTest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.circuit)?;
        for (i, Trial { model, difference }) in self.trials.iter().enumerate() {
            let separator = if i == 0 { "" } else { ";" };
            write!(f, "{separator} {} ({}) ", model.standing(), model.formula())?;
            let Difference {
                compared,
                differing,
                greatest,
            } = difference;
            match differing {
                0 => write!(f, "fits")?,
                _ => write!(
                    f,
                    "differs in {differing} of {compared} pixels by up to {greatest}"
                )?,
            }
        }
        Ok(())
    }
}

/// Patterns of a size; each tells models apart that another may not.
pub(super) const N_PATTERNS: usize = 4;

/// Fills an image with a pattern.
pub(super) fn draw(pattern: usize, width: usize, pixels: &mut [u8]) {
    let mut noise = 0x9e37_79b9_u32;
    let mut random = || {
        // xorshift32 (Marsaglia 2003, "Xorshift RNGs").
        noise ^= noise << 13;
        noise ^= noise >> 17;
        noise ^= noise << 5;
        (noise >> 24) as u8
    };
    for (i, pixel) in pixels.iter_mut().enumerate() {
        let (x, y) = (i % width, i / width);
        *pixel = match pattern {
            // Every value beside every other.
            0 => random(),
            // Extremes, where sums are greatest.
            1 => u8::MAX * ((x / 3 + y / 5) % 2) as u8,
            // Single pixels, which show each weight by itself; 7 and 5 are prime to 2, so that each colour has its
            // turn.
            2 => u8::MAX * u8::from(x % 7 == 3 && y % 5 == 2),
            // Slopes and faint noise, like a scene.
            _ => ((x + 2 * y) / 4 % 240) as u8 + random() / 32,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_drp_circuits::Raster;

    /// Were two models equal on the patterns, the self-test could not tell which one a circuit follows.
    #[test]
    fn the_patterns_tell_all_models_apart() {
        const SIZE: [usize; 2] = [64, 48];
        let outputs = |model: &Model| {
            (0..N_PATTERNS)
                .flat_map(|pattern| {
                    let (mut pixels, mut output) = ([0; 64 * 48], [0; 64 * 48]);
                    draw(pattern, SIZE[0], &mut pixels);
                    let input = Raster::new(&pixels, SIZE).unwrap();
                    model.run(&input, &mut output).unwrap();
                    output
                })
                .collect::<Vec<u8>>()
        };
        let models: Vec<Vec<u8>> = Circuit::ALL
            .iter()
            .flat_map(|circuit| circuit.models())
            .map(outputs)
            .collect();
        for (i, a) in models.iter().enumerate() {
            assert!(models[..i].iter().all(|b| a != b), "model {i}");
        }
    }

    #[test]
    fn nothing_fits_without_a_comparison() {
        let circuit = Circuit::MedianBlur;
        let mut test = SelfTest::new(circuit, circuit.models().iter());
        assert!(test.fitting().is_none());
        test.trials[0].difference.add(&[1, 2], &[1, 2]);
        assert!(test.fitting().is_some());
        test.trials[0].difference.add(&[1, 2], &[1, 9]);
        assert!(test.fitting().is_none());
        assert_eq!(
            test.to_string(),
            "MedianBlur: exact (median of 3x3) differs in 1 of 4 pixels by up to 7"
        );
    }
}
