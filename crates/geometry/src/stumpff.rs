//! The Stumpff functions: every coefficient of the exponential maps, without cancellation near zero.
//!
//! `c_k(x) = sum_j (-x)^j / (2j + k)!`, so with `x = angle^2`: `c_0 = cos`, `c_1 = sin/angle`, `c_2 = (1 - cos)/angle^2`,
//! `c_3 = (angle - sin)/angle^3`, ... and `c_{k+2} = (1/k! - c_k) / x` (K. Stumpff, Himmelsmechanik I, 1959).

/// Below this the series is used, above it the recurrence, which loses digits only near zero.
const SERIES_BELOW: f64 = 1.0;
/// At `x = 1` the first term left out is under 1/22!, far below an `f64`'s last digit.
const SERIES_TERMS: usize = 10;

/// `[c_0, c_1, c_2, c_3, c_4, c_5]` at `x = angle^2 >= 0`.
pub(crate) fn stumpff(x: f64) -> [f64; 6] {
    if x < SERIES_BELOW {
        [0, 1, 2, 3, 4, 5].map(|k| series(k, x))
    } else {
        recurrence(x)
    }
}

fn series(k: usize, x: f64) -> f64 {
    let factorial = (1..=k).product::<usize>() as f64;
    let nested = (1..=SERIES_TERMS).rev().fold(1.0, |inner, j| {
        let n = (2 * j + k) as f64;
        1.0 - x / (n * (n - 1.0)) * inner
    });
    nested / factorial
}

fn recurrence(x: f64) -> [f64; 6] {
    let angle = x.sqrt();
    let (sin, cos) = angle.sin_cos();
    let c1 = sin / angle;
    let c2 = (1.0 - cos) / x;
    let c3 = (1.0 - c1) / x;
    let c4 = (0.5 - c2) / x;
    let c5 = (1.0 / 6.0 - c3) / x;
    [cos, c1, c2, c3, c4, c5]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_and_recurrence_meet() {
        for x in [0.9, 1.0, 1.1, 2.0] {
            for (k, &closed) in recurrence(x).iter().enumerate() {
                assert!((series(k, x) - closed).abs() < 1e-14, "c_{k}({x})");
            }
        }
    }

    #[test]
    fn values_at_zero_are_inverse_factorials() {
        assert_eq!(
            stumpff(0.0),
            [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0]
        );
    }
}
