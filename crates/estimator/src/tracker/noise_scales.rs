//! Noise of each camera's corners, as a factor on the variance that its detector reports: estimated from the residuals
//! that remain after each update.
//!
//! The pose takes up a share of the noise. Of the eight coordinates of a view the redundancy r = 8 - tr(L P⁺) is left
//! (Förstner 1979, reliability of blocks). Outliers must not pass for noise: the variance is averaged with the weights
//! of Student's t (the EM step of Lange, Little, Taylor 1989, sec. 4). Such an average is slow where the noise differs
//! by far, since no view weighs much. Where the detector reports no noise, each view therefore gives a scoring step on
//! the logarithm, with the information that a view of Student's t has of its scale (ibid., sec. 3).
//!
//! Share of the distortion bias in a camera's corners: 1 where the detector fits a homography to the distorted tag, 0
//! where its corners are the very points that the lens shows. No detector reports it, so it is estimated from the
//! residuals of all views as a mean weighted by information. It starts at 1: whoever finds corners fits lines or
//! homographies, and the little noise of such corners makes half a bias matter.

use crate::FusionOptions;
use crate::measurement::corners::WeightedView;
use crate::measurement::rolling_shutter::LinkMotion;
use crate::measurement::view_equations::NoiseSource;
use crate::tracker::hypothesis::ViewOutcome;

/// Prior of the factor for a source of the reported noise.
struct Trust {
    /// Degrees of freedom as which it counts.
    faith: f64,
    /// Bounds of the factor on its variance.
    bounds: (f64, f64),
}

/// A detector's own figures come from its fit; they are off by the same factor for long.
const DETECTOR: Trust = Trust {
    faith: 60.0,
    bounds: (0.1, 25.0),
};

/// Detectors differ by a factor of ten, so that the usual noise gives way within a few views: from 0.003 to 3 px.
const NOBODY: Trust = Trust {
    faith: 8.0,
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
pub(crate) struct NoiseScales(Vec<CameraNoiseScales>);

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct CameraNoiseScales {
    variance: VarianceScale,
    distortion_share: DistortionShare,
}

/// Estimate of a factor on a reported variance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct VarianceScale {
    chi2: f64,
    /// Of the factor, by steps of scoring.
    logarithm: f64,
    redundancy: f64,
    /// Logarithm of the factor by [`index_of`] a source, weighed by the degrees of freedom: a prior that is ten times
    /// too large would rule a mean for long. Within each source's bounds; kept, since every view asks it of every
    /// camera.
    weighed: [f64; 2],
}

/// Of a view's corners.
const COORDINATES: f64 = 8.0;

/// 8 over the mean of 13 x / (5 + x) where x is of chi-square with 8 degrees of freedom: what the weights of views
/// without reported noise take from Gaussian residuals.
const OF_GAUSSIAN: f64 = 1.06;
/// Information of eight Gaussian residuals on the logarithm of their scale over that of such a view: (5 + 10) / 5.
const STEEPNESS: f64 = 3.0;

impl VarianceScale {
    fn weighed(&self) -> [f64; 2] {
        let mean = self.chi2 / self.redundancy.max(f64::MIN_POSITIVE);
        let logarithms = [mean.max(f64::MIN_POSITIVE).ln(), self.logarithm];
        [0, 1].map(|source| {
            let (least, most) = TRUSTS[source].bounds;
            self.redundancy * logarithms[source].clamp(least.ln(), most.ln())
        })
    }

    /// Takes a view in that was whitened with a factor; its residuals are of `ratio` times that variance.
    fn learn(&mut self, factor: f64, ratio: f64, redundancy: f64, memory: f64) {
        let keep = (1.0 - redundancy / memory).clamp(0.0, 1.0);
        self.chi2 = self.chi2 * keep + factor * ratio * redundancy;
        self.redundancy = self.redundancy * keep + redundancy;
        let step = STEEPNESS * (OF_GAUSSIAN * ratio - 1.0);
        self.logarithm += (factor.ln() + step - self.logarithm) * redundancy / self.redundancy;
        self.weighed = self.weighed();
    }
}

/// What all cameras show, by [`index_of`] a source: logarithms of the factors, drawn to one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PooledScales([f64; 2]);

fn usual(all: impl Iterator<Item = VarianceScale>) -> [f64; 2] {
    let (mut sums, mut redundancy) = ([0.0; 2], 0.0);
    for variance in all {
        sums = [0, 1].map(|source| sums[source] + variance.weighed[source]);
        redundancy += variance.redundancy;
    }
    [0, 1].map(|source| sums[source] / (redundancy + TRUSTS[source].faith))
}

/// Factor of a camera, drawn towards that of all cameras.
fn factor(usual: &[f64; 2], own: VarianceScale, source: usize) -> f64 {
    let faith = TRUSTS[source].faith;
    let logarithm = (own.weighed[source] + faith * usual[source]) / (own.redundancy + faith);
    logarithm.exp()
}

impl NoiseScales {
    pub fn usual(&self) -> PooledScales {
        PooledScales(usual(self.0.iter().map(|camera| camera.variance)))
    }

    /// Factor on the variance of a camera's corners.
    pub fn factor(
        &self,
        camera_index: usize,
        source: NoiseSource,
        PooledScales(usual): &PooledScales,
    ) -> f64 {
        let own = self.0.get(camera_index).copied().unwrap_or_default();
        factor(usual, own.variance, index_of(source))
    }

    /// Whether the residuals of a view at a pose of its link are within the largest noise that there can be.
    pub fn can_explain(weighted: &WeightedView<'_>, link: &LinkMotion) -> bool {
        let (_, most) = TRUSTS[index_of(weighted.view.noise_source)].bounds;
        let square = weighted.normal(link).map(|normal| normal.square());
        square.is_some_and(|square| square * weighted.noise < COORDINATES * most)
    }

    /// Share of the distortion bias in a camera's corners.
    pub fn distortion_share(&self, camera_index: usize) -> f64 {
        let own = self.0.get(camera_index).copied().unwrap_or_default();
        own.distortion_share.share()
    }

    /// Takes a view in, whether it took part or was refused: else a noise underestimated at the start would stay so.
    pub fn learn(
        &mut self,
        weighted: &WeightedView<'_>,
        outcome: &ViewOutcome,
        options: &FusionOptions,
    ) {
        if self.0.len() <= weighted.camera_index {
            self.0
                .resize(weighted.camera_index + 1, CameraNoiseScales::default());
        }
        let camera = &mut self.0[weighted.camera_index];
        let ratio = outcome.weighted_square / outcome.redundancy;
        let memory = options.noise_memory;
        camera
            .variance
            .learn(weighted.noise, ratio, outcome.redundancy, memory);
        camera
            .distortion_share
            .learn(weighted.distortion_share, outcome.distortion_score);
    }
}

/// Information before anything is seen: of a deviation of one half.
const SHARE_FAITH: f64 = 4.0;
/// Information that is remembered: a hundredth of the bias is below all noise.
const SHARE_MEMORY: f64 = 1e4;

/// Estimate of the share of the distortion bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct DistortionShare {
    /// Of information times share.
    sum: f64,
    information: f64,
}

impl DistortionShare {
    /// Between none and all.
    pub fn share(self) -> f64 {
        ((self.sum + SHARE_FAITH) / (self.information + SHARE_FAITH)).clamp(0.0, 1.0)
    }

    /// Updates the share with the score of a view: slope and information about the share that was allowed for.
    pub fn learn(&mut self, allowed: f64, [slope, information]: [f64; 2]) {
        if slope.is_finite() && information.is_finite() {
            let keep = (1.0 - information / SHARE_MEMORY).clamp(0.0, 1.0);
            self.sum = self.sum * keep + slope + allowed * information;
            self.information = self.information * keep + information;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_whole_until_residuals_tell() {
        let mut distortion_share = DistortionShare::default();
        assert_eq!(distortion_share.share(), 1.0);
        for _ in 0..1000 {
            let allowed = distortion_share.share();
            distortion_share.learn(allowed, [-allowed, 1.0]);
        }
        assert!(distortion_share.share() < 0.01);
        distortion_share.learn(0.5, [f64::NAN, 1.0]);
        assert!(distortion_share.share().is_finite());
    }
}
