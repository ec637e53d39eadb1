//! Verdict on a lens calibration.

use super::maps::LensMaps;
use crate::verdict::{Grade, Verdict};

/// Largest mean standard deviation over the image of a good lens, pixels.
const GOOD_PX: f64 = 0.15;
/// Largest mean standard deviation of a usable lens, pixels.
const USABLE_PX: f64 = 0.5;
/// Largest systematic error of a good lens, pixels.
const SYSTEMATIC_PX: f64 = 0.15;
/// Least coverage of a good result.
const COVERAGE: f64 = 0.7;
/// Share of outlier tags that is reported.
const WRONG: f64 = 0.05;

/// Of the maps and of the part of the tags that were left out.
pub(super) fn verdict_of(maps: &LensMaps, wrong_part: f64) -> Verdict {
    let mut verdict = Verdict::new();
    uncertainty(&mut verdict, maps);
    coverage(&mut verdict, maps);
    systematic(&mut verdict, maps);
    if wrong_part > WRONG {
        let percent = 100.0 * wrong_part;
        let because = format!(
            "{percent:.0} % of the tags lay elsewhere than the board says and were left out"
        );
        verdict.add(Grade::Good, because);
    }
    verdict
}

fn uncertainty(verdict: &mut Verdict, maps: &LensMaps) {
    let (mean, largest, shown) = maps.uncertainty();
    if mean > GOOD_PX {
        let grade = if mean > USABLE_PX {
            Grade::Poor
        } else {
            Grade::Usable
        };
        let because = format!(
            "the lens is uncertain by {mean:.2} px over the picture, by {largest:.1} px where it is worst; add images"
        );
        verdict.add(grade, because);
    }
    if shown < 1.0 {
        let percent = 100.0 * (1.0 - shown);
        let because = format!(
            "the model ends within the picture, {percent:.0} % of it have no rays; add images there or try kannala-brandt"
        );
        verdict.add(Grade::Usable, because);
    }
}

fn coverage(verdict: &mut Verdict, maps: &LensMaps) {
    let covered = maps.coverage();
    if covered < COVERAGE {
        let grade = if covered < COVERAGE / 2.0 {
            Grade::Poor
        } else {
            Grade::Usable
        };
        let percent = 100.0 * covered;
        let because = format!(
            "only {percent:.0} % of the picture was covered; add the board near its edges too"
        );
        verdict.add(grade, because);
    }
}

fn systematic(verdict: &mut Verdict, maps: &LensMaps) {
    let off = maps.systematic_px();
    if off > SYSTEMATIC_PX {
        let grade = if off > 3.0 * SYSTEMATIC_PX {
            Grade::Poor
        } else {
            Grade::Usable
        };
        let because = format!(
            "corners are off by {off:.2} px in parts of the picture: the board is not flat, or the lens needs another model"
        );
        verdict.add(grade, because);
    }
}
