//! What the motions of a hand leave undetermined: without two axes of rotation, shifts of the base and of what the hand
//! carries cannot be separated (R. Tsai, R. Lenz, A new technique for fully autonomous and efficient 3D robotics
//! hand/eye calibration, 1989, section III).

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use sextant_adjustment::Hand;
use sextant_geometry::so3;

/// How a hand turned among its poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Turns {
    /// Hardly at all; the largest angle, rad.
    None(f64),
    /// About one axis of the hand only.
    OneAxis(Vector3<f64>),
    /// About two axes or more.
    Enough,
}

/// Root mean squares of turns that are too few, rad: three degrees.
const LITTLE: f64 = 0.05;

/// How the hand turned, by the spread of the rotation vectors from a middle pose.
pub(super) fn turns<'a>(hands: impl Iterator<Item = &'a Hand> + Clone) -> Turns {
    let Some(first) = hands.clone().next() else {
        return Turns::None(0.0);
    };
    let vectors = |origin: &nalgebra::UnitQuaternion<f64>| {
        let origin = origin.inverse();
        let turns = hands.clone();
        let turns = turns.map(move |hand| so3::log(&(origin * hand.base_from_hand.rotation)));
        turns.collect::<Vec<Vector3<f64>>>()
    };
    let n = hands.clone().count() as f64;
    let first = first.base_from_hand.rotation;
    let mean = vectors(&first).iter().sum::<Vector3<f64>>() / n;
    let vectors = vectors(&(first * so3::exp(&mean)));
    let mean = vectors.iter().sum::<Vector3<f64>>() / n;
    let spread: Matrix3<f64> = vectors
        .iter()
        .map(|turn| (turn - mean) * (turn - mean).transpose())
        .sum();
    let eigen = SymmetricEigen::new(spread / n);
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [largest, second] = [axes[0], axes[1]].map(|k| eigen.eigenvalues[k].max(0.0).sqrt());
    match (largest > LITTLE, second > LITTLE) {
        (false, _) => Turns::None(largest),
        (true, false) => Turns::OneAxis(eigen.eigenvectors.column(axes[0]).into()),
        (true, true) => Turns::Enough,
    }
}

/// An axis in words: the name of a coordinate axis where it is within ten degrees, else its numbers.
pub(super) fn axis_in_words(axis: &Vector3<f64>) -> String {
    let named = ["x", "y", "z"].into_iter().zip(axis.iter());
    let near = named.into_iter().find(|(_, part)| part.abs() > 0.985);
    match near {
        Some((name, _)) => format!("its {name} axis"),
        None => format!("its axis ({:.2}, {:.2}, {:.2})", axis.x, axis.y, axis.z),
    }
}
