//! Tunable parameters and their ranges.

use crate::Refinement;
use sextant_tag_families::Family;

/// Tunables of a [`crate::Detector`].
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Families to detect; at least one, each once. Default: `tag36h11`. Each further one costs a decoding of every
    /// quad and adds its own rate of false detections.
    pub families: Vec<Family>,
    /// Most bit errors corrected, 0 to 2 (default 2), and never more than the distance and size of the family allow. As
    /// in AprilTag, false detections become likely beyond 2.
    pub max_hamming: u8,
    /// Shortest edge of a tag in pixels, 6 to 1000 (default 8). Below 8 a module of `tag36h11` is narrower than a pixel
    /// and unreadable; raise it to save time if all tags are close.
    pub min_edge_px: f32,
    /// Least difference between black and white in grey levels, 4 to 128 (default 20). Lower finds tags behind haze or
    /// glare and costs time wherever there is texture.
    pub min_contrast: u8,
    /// Least difference between black and white in dim images, where almost nothing is bright enough for
    /// `min_contrast`, 4 to 128 (default 8) and never more than `min_contrast`. Below it, rounding to whole grey levels
    /// destroys a tag. In dim images it is at least eight standard deviations of the noise.
    pub min_dim_contrast: u8,
    /// Least difference between black and white in standard deviations of the image's noise, 3 to 20 (default 6.5: the
    /// range of the 144 pixels around a tile exceeds it in one flat tile of 25).
    pub min_contrast_in_sigma: f32,
    /// Least decision margin in grey levels, 0 to 100 (default 4). False detections have small margins.
    pub min_margin: f32,
    /// Whether tags are printed inverted, white for black and black for white (default: no). Around a tag lies black
    /// then, where others have white paper. Costs a pass over the image.
    pub inverted: bool,
    /// How corners are refined (default: photometric).
    pub refinement: Refinement,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            families: vec![Family::Tag36h11],
            max_hamming: 2,
            min_edge_px: 8.0,
            min_contrast: 20,
            min_dim_contrast: 8,
            min_contrast_in_sigma: 6.5,
            min_margin: 4.0,
            inverted: false,
            refinement: Refinement::default(),
        }
    }
}

/// Which option is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// No family is configured.
    #[error("no tag family to look for; name at least one")]
    NoFamily,
    /// The squares of a chessboard, which have no codes.
    #[error("squares of a {0} have no codes; look for the board itself")]
    NoCodes(Family),
    /// A family is configured twice.
    #[error("the family {0} is named twice")]
    FamilyTwice(Family),
    /// A value is out of range.
    #[error("{key} = {value} is outside {min} to {max}")]
    OutOfRange {
        /// Name of the option.
        key: &'static str,
        /// The configured value.
        value: f32,
        /// Least value.
        min: f32,
        /// Greatest value.
        max: f32,
    },
}

impl Options {
    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        if self.families.is_empty() {
            return Err(OptionsError::NoFamily);
        }
        if let Some(family) = self.families.iter().find(|f| !f.data().has_codes()) {
            return Err(OptionsError::NoCodes(*family));
        }
        let twice = |i: &usize| self.families[..*i].contains(&self.families[*i]);
        if let Some(i) = (0..self.families.len()).find(twice) {
            return Err(OptionsError::FamilyTwice(self.families[i]));
        }
        let in_sigma = self.min_contrast_in_sigma;
        let ranges = [
            ("max_hamming", f32::from(self.max_hamming), 0.0, 2.0),
            ("min_edge_px", self.min_edge_px, 6.0, 1000.0),
            ("min_contrast", f32::from(self.min_contrast), 4.0, 128.0),
            (
                "min_dim_contrast",
                f32::from(self.min_dim_contrast),
                4.0,
                128.0,
            ),
            ("min_contrast_in_sigma", in_sigma, 3.0, 20.0),
            ("min_margin", self.min_margin, 0.0, 100.0),
        ];
        let is_outside = |&(_, value, min, max): &(_, f32, f32, f32)| !(min..=max).contains(&value);
        match ranges.into_iter().find(is_outside) {
            Some((key, value, min, max)) => Err(OptionsError::OutOfRange {
                key,
                value,
                min,
                max,
            }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_within_their_ranges() {
        assert_eq!(Options::default().check(), Ok(()));
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let error = Options {
            min_edge_px: f32::NAN,
            ..Options::default()
        }
        .check()
        .unwrap_err();
        assert!(error.to_string().starts_with("min_edge_px"));
        let twice = Options {
            families: vec![Family::Tag36h11; 2],
            ..Options::default()
        };
        assert_eq!(
            twice.check(),
            Err(OptionsError::FamilyTwice(Family::Tag36h11))
        );
        let board = Options {
            families: vec![Family::Tag36h11, Family::Chessboard],
            ..Options::default()
        };
        let error = board.check().unwrap_err().to_string();
        assert!(error.contains("chessboard have no codes"), "{error}");
    }
}
