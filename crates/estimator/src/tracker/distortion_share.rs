//! Share of the distortion bias in a camera's corners: 1 where the detector fits a homography to the distorted tag, 0
//! where its corners are the very points that the lens shows.
//!
//! No detector reports it, so it is estimated from the residuals of all views as a mean weighted by information. It
//! starts at 1: whoever finds corners fits lines or homographies, and the little noise of such corners makes half a
//! bias matter.

/// Information before anything is seen: of a deviation of one half.
const FAITH: f64 = 4.0;
/// Information that is remembered: a hundredth of the bias is below all noise.
const MEMORY: f64 = 1e4;

/// Estimate of the share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct DistortionShare {
    /// Of information times share.
    sum: f64,
    information: f64,
}

impl DistortionShare {
    /// Between none and all.
    pub fn share(self) -> f64 {
        ((self.sum + FAITH) / (self.information + FAITH)).clamp(0.0, 1.0)
    }

    /// Updates the share with the score of a view: slope and information about the share that was allowed for.
    pub fn learn(&mut self, allowed: f64, [slope, information]: [f64; 2]) {
        if slope.is_finite() && information.is_finite() {
            let keep = (1.0 - information / MEMORY).clamp(0.0, 1.0);
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
