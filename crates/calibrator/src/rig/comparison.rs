//! Comparison of two explanations of the same images.

use sextant_adjustment::{Bundle, BundleOptions};

/// Most instants used for a comparison; more cost time and add little.
pub(crate) const MOST_INSTANTS: usize = 300;
/// One explanation is clearly better than another if it leaves less than its error divided by this.
pub(crate) const BETTER: f64 = 1.5;

/// Options of every adjustment of a rig.
pub(crate) fn options() -> BundleOptions {
    BundleOptions::default()
}

/// Residuals of two explanations of the same images, by camera: sums of robust squares, in units of the noise of the
/// explanation with the smaller residuals. Cameras beyond the first `n` are the second halves of those.
pub(crate) fn left_by(one: &Bundle, other: &Bundle, n: usize) -> [Vec<f64>; 2] {
    let squares = [one, other].map(|bundle| {
        let mut squares = vec![Vec::new(); n];
        for residual in bundle.residuals() {
            squares[bundle.images[residual.image].camera % n].push(residual.chi_square);
        }
        squares
            .iter_mut()
            .for_each(|own| own.sort_by(f64::total_cmp));
        squares
    });
    let median = |own: &Vec<f64>| own.get(own.len() / 2).copied().unwrap_or(1.0);
    let unit = |at: usize| median(&squares[0][at]).min(median(&squares[1][at]));
    let units: Vec<f64> = (0..n).map(unit).collect();
    squares.each_ref().map(|squares| {
        let cameras = squares.iter().zip(&units);
        let sums = cameras.map(|(own, unit)| {
            let kernel = options().kernel;
            own.iter().map(|square| kernel.rho(square / unit)).sum()
        });
        sums.collect()
    })
}
