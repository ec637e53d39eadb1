//! How noisy a camera's corners are, against what was stated: estimated from the residuals that remain after each update.
//!
//! A residual after the update is smaller than the noise by the share of it that the pose took up. Of the four shifts (or
//! turns) of a view's edges the redundancy r = 4 - tr(L P⁺) is left (Förstner 1979, reliability of blocks). Outliers must not
//! pass for noise: the weights of Student's t are those with which the variance is to be averaged (the EM step of Lange,
//! Little, Taylor 1989, sec. 4).

use super::bowed::Bowed;
use super::update::Taken;
use crate::FusionOptions;
use crate::filter::corners::Sight;
use crate::filter::edges::NoiseFactors;
use crate::filter::normal::NoiseSource;

/// What a source of the stated noise is worth.
struct Trust {
    /// Degrees of freedom as which it counts.
    faith: f64,
    /// Bounds of the factor on its variance.
    bounds: (f64, f64),
}

/// A detector's own figures come from its fit; they are off by the same factor for long.
const DETECTOR: Trust = Trust {
    faith: 30.0,
    bounds: (0.1, 25.0),
};

/// Detectors differ by a factor of ten, so that the usual noise gives way within a few views: from 0.003 to 3 px.
const NOBODY: Trust = Trust {
    faith: 4.0,
    bounds: (0.001, 1000.0),
};

/// By [`index_of`].
const TRUSTS: [&Trust; 2] = [&DETECTOR, &NOBODY];

fn index_of(source: NoiseSource) -> usize {
    match source {
        NoiseSource::Detector => 0,
        NoiseSource::Nobody => 1,
    }
}

/// The noise of all cameras' corners, by camera index.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Noise(Vec<CameraNoise>);

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct CameraNoise {
    shift: Variance,
    turn: Variance,
    bowed: Bowed,
}

/// What the residuals say of a factor on a stated variance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Variance {
    chi2: f64,
    redundancy: f64,
    /// Logarithm of the factor, weighed by the degrees of freedom: a prior that is ten times too large would rule a mean for
    /// long. As each source's bounds have it; kept, since every view asks it of every camera.
    weighed: [f64; 2],
}

impl Variance {
    fn weighed_by(&self, trust: &Trust) -> f64 {
        let factor = self.chi2 / self.redundancy.max(f64::MIN_POSITIVE);
        self.redundancy * factor.clamp(trust.bounds.0, trust.bounds.1).ln()
    }

    fn learn(&mut self, ratio: f64, redundancy: f64, memory: f64) {
        let keep = (1.0 - redundancy / memory).clamp(0.0, 1.0);
        self.chi2 = self.chi2 * keep + ratio * redundancy;
        self.redundancy = self.redundancy * keep + redundancy;
        self.weighed = TRUSTS.map(|trust| self.weighed_by(trust));
    }
}

/// What all cameras show, by [`index_of`] a source: logarithms of the factors, drawn to one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Usual {
    shift: [f64; 2],
    turn: [f64; 2],
}

fn usual(all: impl Iterator<Item = Variance>) -> [f64; 2] {
    let (mut sums, mut redundancy) = ([0.0; 2], 0.0);
    for variance in all {
        sums = [0, 1].map(|source| sums[source] + variance.weighed[source]);
        redundancy += variance.redundancy;
    }
    [0, 1].map(|source| sums[source] / (redundancy + TRUSTS[source].faith))
}

/// A camera's own factor, drawn to what all show.
fn factor(usual: &[f64; 2], own: Variance, source: usize) -> f64 {
    let faith = TRUSTS[source].faith;
    let logarithm = (own.weighed[source] + faith * usual[source]) / (own.redundancy + faith);
    logarithm.exp()
}

impl Noise {
    pub fn usual(&self) -> Usual {
        Usual {
            shift: usual(self.0.iter().map(|camera| camera.shift)),
            turn: usual(self.0.iter().map(|camera| camera.turn)),
        }
    }

    pub fn factors(&self, camera_index: usize, source: NoiseSource, usual: &Usual) -> NoiseFactors {
        let source = index_of(source);
        let own = self.0.get(camera_index).copied().unwrap_or_default();
        NoiseFactors {
            shift: factor(&usual.shift, own.shift, source),
            turn: factor(&usual.turn, own.turn, source),
        }
    }

    /// How much of the bow a camera's corners have.
    pub fn bowed(&self, camera_index: usize) -> f64 {
        let own = self.0.get(camera_index).copied().unwrap_or_default();
        own.bowed.share()
    }

    /// Takes a view in, whether it took part or was refused: else a noise underestimated at the start would stay so.
    pub fn learn(&mut self, sight: &Sight<'_>, taken: &Taken, options: &FusionOptions) {
        if self.0.len() <= sight.camera_index {
            self.0
                .resize(sight.camera_index + 1, CameraNoise::default());
        }
        let camera = &mut self.0[sight.camera_index];
        let memory = 0.5 * options.noise_memory;
        // Against what the residuals were whitened with.
        let ratio = |kind: usize| taken.scale[kind] / taken.redundancy[kind];
        let (shift, turn) = (ratio(0) * sight.noise.shift, ratio(1) * sight.noise.turn);
        camera.shift.learn(shift, taken.redundancy[0], memory);
        camera.turn.learn(turn, taken.redundancy[1], memory);
        camera.bowed.learn(sight.bowed, taken.more_bow);
    }
}
