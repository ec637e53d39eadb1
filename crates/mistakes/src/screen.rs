//! Whether one instant contradicts a site.

use crate::explained::{self, Branches, Explained, contradicts, poses_by_camera};
use crate::site::{Instant, NominalSite};
use sextant_geometry::se3;
use sextant_site_model::PoseSigma;

/// What the views of an instant say of a site.
#[derive(Debug, Clone, PartialEq)]
pub struct Screened {
    /// By view: whether it contradicts the pose that explains most views.
    pub is_contradicting: Vec<bool>,
    /// What a view costs on average: half its squared residuals in units of their standard deviations, bounded.
    pub mean_cost: f64,
    /// How far the poses of the body by single cameras differ at most, m and rad; zero where nothing contradicts.
    pub apart: PoseSigma,
}

impl Screened {
    /// Whether any view contradicts.
    pub fn is_any(&self) -> bool {
        self.is_contradicting.contains(&true)
    }

    /// Whether a camera contradicts by most of its views; `None` where it has none.
    pub fn of_camera(&self, instant: &Instant, camera: usize) -> Option<bool> {
        let views = instant.views.iter().zip(&self.is_contradicting);
        let own = views.filter(|(view, _)| view.camera == camera);
        let (n_wrong, n_views) = own.fold((0, 0), |(n_wrong, n_views), (_, is_wrong)| {
            (n_wrong + usize::from(*is_wrong), n_views + 1)
        });
        (n_views > 0).then_some(2 * n_wrong > n_views)
    }
}

/// Compares the views of one instant with a site, errors of a usual size allowed for.
#[must_use]
pub fn screen(site: &NominalSite, instant: &Instant) -> Screened {
    let one = std::slice::from_ref(instant);
    let branches = Branches::new(site, one);
    let explained = Explained::new(site, one, &branches);
    let n_views = instant.views.len().max(1) as f64;
    let mut screened = Screened {
        mean_cost: explained.total() / n_views,
        is_contradicting: explained.costs[0]
            .iter()
            .map(|cost| contradicts(*cost))
            .collect(),
        apart: PoseSigma::NONE,
    };
    if screened.is_any() {
        screened.apart = apart(site, instant, &branches);
    }
    screened
}

/// How a site explains the views of an instant: squares of the distances of expected and seen corners, px², by view;
/// `None` where a view can't be seen as it was.
#[must_use]
pub fn squares_px(site: &NominalSite, instant: &Instant) -> Vec<Option<f64>> {
    explained::squares_px(site, instant)
}

/// How far the poses of a body by single cameras differ at most, m and rad.
fn apart(site: &NominalSite, instant: &Instant, branches: &Branches) -> PoseSigma {
    let poses = poses_by_camera(site, instant, branches.of_instant(0));
    let mut apart = PoseSigma::NONE;
    for (index, pose) in poses.values().enumerate() {
        for other in poses.values().skip(index + 1) {
            let step = se3::difference(pose, other);
            apart = PoseSigma {
                position_m: apart.position_m.max(step.fixed_rows::<3>(0).norm()),
                orientation_rad: apart.orientation_rad.max(step.fixed_rows::<3>(3).norm()),
            };
        }
    }
    apart
}
