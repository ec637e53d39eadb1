//! Which cameras go on to contradict while others agree.
//!
//! What makes all views of an image wrong is likely to stay, as a body that is hit anew each time is not: a further such image
//! costs little. But where more cameras contradict than agree, it is the track that is wrong.

/// Cameras by index, as one attitude has them.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CameraConsistency {
    /// Of whose last image no view took part.
    doubted: Vec<usize>,
    /// The others that took part since one came to be doubted.
    agreed: Vec<usize>,
}

impl CameraConsistency {
    /// Whether the last image of a camera took no part.
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

    /// Notes whether a view of an image took part.
    pub fn note(&mut self, camera: usize, part: bool) {
        if part {
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
        let mut standing = CameraConsistency::default();
        standing.note(1, false);
        assert!(standing.doubts(1) && !standing.is_wrong(1));
        standing.note(0, true);
        assert!(standing.is_wrong(1) && !standing.is_wrong(0));
        standing.note(1, true);
        assert_eq!(standing, CameraConsistency::default());
    }

    #[test]
    fn those_who_are_more_than_those_that_agree_are_not_wrong() {
        let mut standing = CameraConsistency::default();
        for camera in [1, 2] {
            standing.note(camera, false);
            standing.note(0, true);
        }
        assert!(!standing.is_wrong(1) && !standing.is_wrong(2));
        standing.note(3, true);
        assert!(standing.is_wrong(1) && standing.is_wrong(2));
    }
}
