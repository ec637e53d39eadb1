//! Cameras that keep contradicting a track while others agree.
//!
//! A cause that makes all views of an image wrong is likely to stay, unlike a blow to the body: a further such image
//! costs little. Where more cameras contradict than agree, the track itself is wrong.

/// Cameras that contradict and agree with one hypothesis, by index.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CameraConsistency {
    /// Of whose last image no view was used.
    doubted: Vec<usize>,
    /// The others whose views were used since one came to be doubted.
    agreed: Vec<usize>,
}

impl CameraConsistency {
    /// The cameras of whose last image no view was used, by index.
    pub fn doubted(&self) -> &[usize] {
        &self.doubted
    }

    /// Whether no view of a camera's last image was used.
    pub fn doubts(&self, camera: usize) -> bool {
        self.doubted.contains(&camera)
    }

    /// Whether its images go on to be wrong while others' are right.
    pub fn is_wrong(&self, camera: usize) -> bool {
        self.doubts(camera) && self.agreed.len() >= self.doubted.len()
    }

    /// Whether any camera is doubted.
    pub fn is_in_doubt(&self) -> bool {
        !self.doubted.is_empty()
    }

    /// Records whether a view of an image is used.
    pub fn record(&mut self, camera: usize, is_used: bool) {
        if is_used {
            self.clear(&[camera]);
            if self.is_in_doubt() && !self.agreed.contains(&camera) {
                self.agreed.push(camera);
            }
        } else if !self.doubts(camera) {
            self.doubted.push(camera);
            self.agreed.clear();
        }
    }

    /// These cameras are doubted no more.
    pub fn clear(&mut self, cameras: &[usize]) {
        self.doubted.retain(|camera| !cameras.contains(camera));
        if self.doubted.is_empty() {
            self.agreed.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_goes_on_to_contradict_is_wrong_once_another_agrees() {
        let mut consistency = CameraConsistency::default();
        consistency.record(1, false);
        assert!(consistency.doubts(1) && !consistency.is_wrong(1));
        consistency.record(0, true);
        assert!(consistency.is_wrong(1) && !consistency.is_wrong(0));
        consistency.record(1, true);
        assert_eq!(consistency, CameraConsistency::default());
    }

    #[test]
    fn those_who_are_more_than_those_that_agree_are_not_wrong() {
        let mut consistency = CameraConsistency::default();
        for camera in [1, 2] {
            consistency.record(camera, false);
            consistency.record(0, true);
        }
        assert!(!consistency.is_wrong(1) && !consistency.is_wrong(2));
        consistency.record(3, true);
        assert!(consistency.is_wrong(1) && consistency.is_wrong(2));
    }
}
