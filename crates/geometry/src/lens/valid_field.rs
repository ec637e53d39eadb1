//! How far off its axis a lens can be inverted: the first zero of a polynomial, and the inverse of a monotone function.

/// Normalised radius (tangent of the angle off the axis) at which every field ends, 89.4 degrees: no tag can be read
/// beyond, and all numbers stay finite.
pub(super) const MAX_RADIUS: f64 = 100.0;

/// A field ends where the distorted radius grows less than this per normalised radius: there a pixel has no information
/// about the direction any more. Range 0 (the fold itself) to 1; the field loses about a thousandth to it.
pub(super) const MIN_SLOPE: f64 = 1e-3;

/// The smallest `x` in (0, `end`] with `p(x) <= 0`, else `end`. `p(x) = sum coefficients[i] x^i`, `p(0) > 0`.
pub(super) fn first_zero(coefficients: &[f64], end: f64) -> f64 {
    zeros(coefficients, end).into_iter().next().unwrap_or(end)
}

/// All zeros in (0, `end`), ascending: between two neighbouring zeros of its derivative a polynomial is monotone, so
/// each such interval holds at most one, which bisection finds.
fn zeros(coefficients: &[f64], end: f64) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let mut stops = zeros(&derivative(coefficients), end);
    stops.push(end);
    let mut start = 0.0;
    let mut found = Vec::new();
    for stop in stops {
        found.extend(zero_between(coefficients, start, stop));
        start = stop;
    }
    found
}

fn zero_between(coefficients: &[f64], mut low: f64, mut high: f64) -> Option<f64> {
    let sign_low = evaluate(coefficients, low) > 0.0;
    if sign_low == (evaluate(coefficients, high) > 0.0) {
        return None;
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Some(low);
        }
        if (evaluate(coefficients, middle) > 0.0) == sign_low {
            low = middle;
        } else {
            high = middle;
        }
    }
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    let powers = (1..coefficients.len()).map(|i| i as f64);
    coefficients[1..]
        .iter()
        .zip(powers)
        .map(|(c, i)| c * i)
        .collect()
}

fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The `x` in [0, `end`] with `f(x) = target`, where `f` gives value and slope and grows from
/// `f(0) = 0`; `end` where it does not get that far. Newton's method, bisecting whenever it would
/// leave the bracket; its last step is at most `last_step` of `x`, and its error that of the next.
pub(super) fn invert_monotone(
    f: impl Fn(f64) -> (f64, f64),
    target: f64,
    end: f64,
    last_step: f64,
) -> f64 {
    let (mut low, mut high) = (0.0, end);
    let mut x = target.min(end);
    for _ in 0..MAX_STEPS {
        let (value, slope) = f(x);
        let error = value - target;
        let newton = x - error / slope;
        if (newton - x).abs() <= last_step * x {
            return newton.clamp(low, high);
        }
        if error > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let inside = newton > low && newton < high;
        x = if inside { newton } else { 0.5 * (low + high) };
    }
    x
}

/// Bisection alone needs about sixty steps for all bits of an `f64`; Newton's method in general five.
const MAX_STEPS: usize = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_zero_is_the_smallest() {
        // (1 - x)(2 - x)(3 - x) = 6 - 11 x + 6 x^2 - x^3
        assert!((first_zero(&[6.0, -11.0, 6.0, -1.0], 10.0) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_polynomial_without_zeros_lasts_to_the_end() {
        assert_eq!(first_zero(&[1.0, 0.0, 1.0], 7.0), 7.0);
        assert_eq!(first_zero(&[1.0], 7.0), 7.0);
    }

    #[test]
    fn a_zero_is_never_passed_over() {
        // A dip that a coarse scan would miss.
        let dip = 1e-6;
        let p = [1.0 - dip, -2.0, 1.0]; // (x - 1)^2 - dip
        assert!((first_zero(&p, 100.0) - (1.0 - dip.sqrt())).abs() < 1e-9);
    }

    #[test]
    fn a_monotone_function_is_inverted_to_the_last_digits() {
        let cubic = |x: f64| (x + x * x * x, 1.0 + 3.0 * x * x);
        for x in [0.0, 1e-12, 0.3, 1.0, 7.0] {
            assert!(
                (invert_monotone(cubic, cubic(x).0, 10.0, 1e-9) - x).abs() <= 4e-16 * (1.0 + x)
            );
        }
        assert_eq!(invert_monotone(cubic, 1e9, 10.0, 1e-9), 10.0);
    }
}
