//! The Stumpff functions: every coefficient of the exponential maps, without cancellation near zero.
//!
//! `c_k(x) = sum_j (-x)^j / (2j + k)!`, so with `x = angle^2`: `c_0 = cos`, `c_1 = sin/angle`,
//! `c_2 = (1 - cos)/angle^2`, `c_3 = (angle - sin)/angle^3`, ... and `c_{k+2} = (1/k! - c_k) / x` (K. Stumpff,
//! Himmelsmechanik I, 1959).

/// Below this the series is used, above it the recurrence, which loses digits only near zero.
const SERIES_BELOW: f64 = 1.0;
/// At `x = 1` the first term left out is under 1/22!, far below an `f64`'s last digit.
const SERIES_TERMS: usize = 9;

/// `(-1)^j / (2j + 4)!` and `(-1)^j / (2j + 5)!`.
const C4: [f64; SERIES_TERMS] = inverse_factorials(4);
const C5: [f64; SERIES_TERMS] = inverse_factorials(5);

const fn inverse_factorials(k: usize) -> [f64; SERIES_TERMS] {
    let mut terms = [0.0; SERIES_TERMS];
    let (mut factorial, mut n) = (1.0, 1);
    let mut j = 0;
    while j < SERIES_TERMS {
        while n <= 2 * j + k {
            factorial *= n as f64;
            n += 1;
        }
        terms[j] = if j % 2 == 0 { 1.0 } else { -1.0 } / factorial;
        j += 1;
    }
    terms
}

/// `[c_0, c_1, c_2, c_3, c_4, c_5]` at `x = angle^2 >= 0`.
pub(crate) fn stumpff(x: f64) -> [f64; 6] {
    if x < SERIES_BELOW {
        series(x)
    } else {
        recurrence(x)
    }
}

/// The last two by their series, the others downwards from them: `c_k = 1/k! - x c_{k+2}`, which loses nothing here.
fn series(x: f64) -> [f64; 6] {
    let nested =
        |terms: &[f64; SERIES_TERMS]| terms.iter().rev().fold(0.0, |inner, term| inner * x + term);
    let (c4, c5) = (nested(&C4), nested(&C5));
    let (c2, c3) = (0.5 - x * c4, 1.0 / 6.0 - x * c5);
    [1.0 - x * c2, 1.0 - x * c3, c2, c3, c4, c5]
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
                assert!((series(x)[k] - closed).abs() < 1e-14, "c_{k}({x})");
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
