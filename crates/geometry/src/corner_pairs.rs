//! Covariance of the corners of a tag, as in detections, recordings and messages: of one corner as
//! (xx, xy, yy), and that between two corners as x of the one with x and with y of the other, then y of the one with
//! both; px².

/// The pairs of corners of a tag, in the order of their cross covariances.
pub const CORNER_PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The first pair of corners whose cross covariance is not finite or exceeds their covariances, up to rounding to
/// single precision.
pub fn wrong_corner_pair(own: &[[f32; 3]; 4], shared: &[[f32; 4]; 6]) -> Option<[usize; 2]> {
    let mut pairs = CORNER_PAIRS.into_iter().zip(shared);
    let wrong = pairs.find(|(pair, shared)| !may_share(pair.map(|corner| own[corner]), shared));
    wrong.map(|(pair, _)| pair)
}

/// Written so that NaN may not.
fn may_share(own: [[f32; 3]; 2], shared: &[f32; 4]) -> bool {
    let [one, other] = own.map(|[xx, _, yy]| [f64::from(xx), f64::from(yy)]);
    let most = one.iter().flat_map(|a| other.map(|b| a * b));
    let within = |(&shared, most): (&f32, f64)| {
        f64::from(shared).powi(2) <= most * (1.0 + 1e-5) + f64::from(f32::MIN_POSITIVE)
    };
    shared.iter().zip(most).all(within)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_share_no_more_than_they_have() {
        let own = [[4.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.5, 1.0], [0.0; 3]];
        let with = |pair: usize, shared: [f32; 4]| {
            let mut all = [[0.0; 4]; 6];
            all[pair] = shared;
            wrong_corner_pair(&own, &all)
        };
        assert_eq!(with(0, [2.0, -2.0, 1.0, -1.0]), None);
        assert_eq!(with(0, [2.0, -2.0, 1.1, -1.0]), Some([0, 1]));
        assert_eq!(with(3, [0.0, f32::NAN, 0.0, 0.0]), Some([1, 2]));
        assert_eq!(with(4, [0.0, 0.0, f32::INFINITY, 0.0]), Some([1, 3]));
        assert_eq!(with(5, [0.0, 0.0, 0.0, 1e-3]), Some([2, 3]));
    }
}
