//! Observability: directions of the kept parameters whose standard deviation is a large share of the prior's.

use crate::marginals::KeptCovariance;
use crate::parameter::KeptParameter;
use crate::prior_knowledge::PriorKnowledge;
use nalgebra::{DMatrix, SymmetricEigen};

/// A weakly observable direction of the kept parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakDirection {
    /// Ratio of its standard deviation to the prior's: 1 is unobservable.
    pub part_of_prior: f64,
    /// Its components with their shares, largest first; squared shares sum to at most one, small ones are omitted.
    pub made_of: Vec<(KeptParameter, f64)>,
}

/// Smaller shares are omitted from a direction's description.
const SMALL_SHARE: f64 = 0.1;

/// Weak directions, weakest first.
pub(crate) fn weak_directions(
    covariance: &KeptCovariance,
    prior: &PriorKnowledge,
) -> Vec<WeakDirection> {
    let parameters = covariance.parameters();
    let units: Vec<f64> = parameters.iter().map(|p| prior.unit(p)).collect();
    let matrix = covariance.by_noise();
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
