//! What the images do not determine: directions of the kept parameters whose deviation is a good part of what anybody would
//! have guessed without images.

use super::covariance::KeptCovariance;
use super::layout::KeptParameter;
use super::state::Bundle;
use nalgebra::{DMatrix, SymmetricEigen};

/// How uncertain things are before any image, one sigma: the units in which directions are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorKnowledge {
    /// A camera's position, metres. Default 3.
    pub camera_position_m: f64,
    /// A camera's or a tag's attitude, radians. Default 1.
    pub rotation: f64,
    /// A focal length or a principal point, as a part of the focal length. Default 0.3.
    pub lens: f64,
    /// A distortion coefficient. Default 1.
    pub distortion: f64,
    /// A clock, seconds. Default 1.
    pub clock_s: f64,
    /// A tag's position on the object, metres. Default 0.5.
    pub tag_position_m: f64,
    /// A tag's size, as a part of it. Default 0.3.
    pub tag_size: f64,
    /// A direction whose deviation exceeds this part of the prior is weak. Default 0.05: 15 cm or 3 degrees of a camera.
    pub weak_part: f64,
}

impl Default for PriorKnowledge {
    fn default() -> Self {
        Self {
            camera_position_m: 3.0,
            rotation: 1.0,
            lens: 0.3,
            distortion: 1.0,
            clock_s: 1.0,
            tag_position_m: 0.5,
            tag_size: 0.3,
            weak_part: 0.05,
        }
    }
}

impl PriorKnowledge {
    pub(super) fn sigma(&self, bundle: &Bundle, parameter: &KeptParameter) -> f64 {
        match *parameter {
            KeptParameter::CameraPosition { .. } => self.camera_position_m,
            KeptParameter::CameraRotation { .. } | KeptParameter::TagRotation { .. } => {
                self.rotation
            }
            KeptParameter::Lens { camera, parameter } if parameter < 4 => {
                self.lens * bundle.cameras[camera].lens.intrinsics().fx
            }
            KeptParameter::Lens { .. } => self.distortion,
            KeptParameter::Clock { .. } => self.clock_s,
            KeptParameter::TagPosition { .. } => self.tag_position_m,
            KeptParameter::TagSize { .. } => self.tag_size,
        }
    }

    fn unit(&self, parameter: &KeptParameter) -> f64 {
        match *parameter {
            KeptParameter::CameraPosition { .. } => self.camera_position_m,
            KeptParameter::CameraRotation { .. } | KeptParameter::TagRotation { .. } => {
                self.rotation
            }
            // A lens of 1000 pixels stands for all: only the order matters for comparing directions.
            KeptParameter::Lens { parameter, .. } if parameter < 4 => self.lens * 1000.0,
            KeptParameter::Lens { .. } => self.distortion,
            KeptParameter::Clock { .. } => self.clock_s,
            KeptParameter::TagPosition { .. } => self.tag_position_m,
            KeptParameter::TagSize { .. } => self.tag_size,
        }
    }
}

/// A direction of the kept parameters that the images hardly determine.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakDirection {
    /// Its deviation as a part of the prior's: 1 is not determined at all.
    pub part_of_prior: f64,
    /// What it is made of, largest share first; squared shares add up to at most one, small ones are left out.
    pub made_of: Vec<(KeptParameter, f64)>,
}

/// Shares below this are left out of a direction's description.
const SMALL_SHARE: f64 = 0.1;

/// Weakest first.
pub(super) fn weak_directions(
    covariance: &KeptCovariance,
    prior: &PriorKnowledge,
) -> Vec<WeakDirection> {
    let parameters = covariance.parameters();
    let units: Vec<f64> = parameters.iter().map(|p| prior.unit(p)).collect();
    let matrix = covariance.matrix();
    let n = units.len();
    let largest = (0..n).map(|at| matrix[(at, at)].sqrt() / units[at]);
    if largest.fold(0.0, f64::max) <= prior.weak_part / (n.max(1) as f64).sqrt() {
        return Vec::new(); // no direction can be longer than all axes together
    }
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] / (units[i] * units[j]));
    let eigen = SymmetricEigen::new(scaled);
    let mut weak: Vec<WeakDirection> = (0..n)
        .filter_map(|at| {
            let part = eigen.eigenvalues[at].max(0.0).sqrt();
            let direction = eigen.eigenvectors.column(at);
            (part > prior.weak_part).then(|| WeakDirection {
                part_of_prior: part,
                made_of: made_of(parameters, direction.iter().copied()),
            })
        })
        .collect();
    weak.sort_by(|a, b| b.part_of_prior.total_cmp(&a.part_of_prior));
    weak
}

fn made_of(
    parameters: &[KeptParameter],
    direction: impl Iterator<Item = f64>,
) -> Vec<(KeptParameter, f64)> {
    let shares = parameters.iter().copied().zip(direction);
    let mut shares: Vec<_> = shares.filter(|(_, s)| s.abs() >= SMALL_SHARE).collect();
    shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    shares
}
