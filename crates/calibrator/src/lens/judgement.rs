//! Verdict on a lens calibration.

use super::maps::LensMaps;
use crate::verdict::{Finding, Grade, Verdict};

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

/// The verdict for these maps and this share of outlier tags.
pub(super) fn verdict_of(maps: &LensMaps, wrong_part: f64) -> Verdict {
    let mut verdict = Verdict::new();
    uncertainty(&mut verdict, maps);
    coverage(&mut verdict, maps);
    systematic(&mut verdict, maps);
    if wrong_part > WRONG {
        verdict.add(Grade::Good, Finding::BoardOutliers { share: wrong_part });
    }
    verdict
}

fn uncertainty(verdict: &mut Verdict, maps: &LensMaps) {
    let (mean_px, worst_px, shown) = maps.uncertainty();
    if mean_px > GOOD_PX {
        let grade = if mean_px > USABLE_PX {
            Grade::Poor
        } else {
            Grade::Usable
        };
        verdict.add(grade, Finding::UncertainLens { mean_px, worst_px });
    }
    if shown < 1.0 {
        let share = 1.0 - shown;
        verdict.add(Grade::Usable, Finding::NoRays { share });
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
        verdict.add(grade, Finding::Uncovered { covered });
    }
}

fn systematic(verdict: &mut Verdict, maps: &LensMaps) {
    let px = maps.systematic_px();
    if px > SYSTEMATIC_PX {
        let grade = if px > 3.0 * SYSTEMATIC_PX {
            Grade::Poor
        } else {
            Grade::Usable
        };
        verdict.add(grade, Finding::SystematicResiduals { px });
    }
}
