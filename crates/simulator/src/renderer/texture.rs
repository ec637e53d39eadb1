//! Smooth noise for uneven surfaces.

/// Value noise between -1 and 1 with features of size 1, determined by the seed.
pub(super) fn noise(seed: u32, x: f64, y: f64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let (u, v) = (ease(x - left), ease(y - top));
    let corner = |dx: i32, dy: i32| lattice(seed, left as i32 + dx, top as i32 + dy);
    let above = corner(0, 0) * (1.0 - u) + corner(1, 0) * u;
    let below = corner(0, 1) * (1.0 - u) + corner(1, 1) * u;
    above * (1.0 - v) + below * v
}

/// Pseudo-random number between -1 and 1 for each lattice point.
pub(super) fn lattice(seed: u32, x: i32, y: i32) -> f64 {
    let mixed = seed
        ^ (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77).rotate_left(15);
    let mixed = (mixed ^ (mixed >> 16)).wrapping_mul(0x7feb_352d);
    let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x846c_a68b);
    f64::from(mixed ^ (mixed >> 16)) / f64::from(u32::MAX) * 2.0 - 1.0
}

fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_continuous_and_stays_between_its_bounds() {
        let mut last = noise(3, -5.0, 0.3);
        for i in 0..10_000 {
            let here = noise(3, -5.0 + f64::from(i) * 1e-3, 0.3);
            assert!((-1.0..=1.0).contains(&here));
            assert!((here - last).abs() < 4e-3);
            last = here;
        }
    }
}
