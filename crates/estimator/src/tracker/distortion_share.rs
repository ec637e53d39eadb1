//! How much of the bow of a bending lens a camera's corners have: all of it where its detector fits a homography to the bent
//! tag, nothing where its corners are the very points that the lens shows.
//!
//! Nobody states it, so it is learned from the residuals of all views: a mean weighed by information. It begins with all of it: whoever finds corners
//! in pictures fits lines or homographies, and the little noise of such corners makes half a bow matter.

/// Information before anything is seen: of a deviation of one half.
const FAITH: f64 = 4.0;
/// Information that is remembered: a hundredth of the bow is below all noise.
const MEMORY: f64 = 1e4;

/// What residuals say of the share.
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

    /// Takes in what a view's residuals say where a share was allowed for: slope and information about more of it.
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
