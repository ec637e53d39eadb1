//! How well a site explains the views: the best pose of each body at each instant, and what its views cost then.

use std::collections::{BTreeMap, BTreeSet};

use sextant_geometry::planar_pose::tag_poses;
use sextant_geometry::{Pose, tag_corners_in_tag};

use crate::pose_fit::{MOST_COST, Spread, Term, best_of};
use crate::site::{Instant, NominalSite, SiteCamera, SiteTag, View};

/// The poses that each view's corners allow, `camera_from_tag`: both branches of the planar ambiguity.
#[derive(Debug, Clone)]
pub(crate) struct Branches(Vec<Vec<Vec<Pose>>>);

/// What the views of some instants cost with a site's models.
#[derive(Debug, Clone)]
pub(crate) struct Explained {
    /// By instant and view.
    pub costs: Vec<Vec<f64>>,
}

/// A view that costs more contradicts the site: its coordinates are off by more than two standard deviations.
const CONTRADICTS: f64 = 0.4 * MOST_COST;

/// Whether a view of such a cost contradicts the site.
pub(crate) fn contradicts(cost: f64) -> bool {
    cost > CONTRADICTS
}

impl Branches {
    pub fn new(site: &NominalSite, instants: &[Instant]) -> Self {
        let of_views = |instant: &Instant| {
            let views = instant.views.iter();
            views.map(|view| branches(site, view)).collect()
        };
        Self(instants.iter().map(of_views).collect())
    }

    /// Anew for the views that are concerned by a change of lenses or sizes.
    pub fn renewed(
        &self,
        site: &NominalSite,
        instants: &[Instant],
        is_concerned: impl Fn(&View) -> bool,
    ) -> Self {
        let mut anew = self.clone();
        for (of_instant, instant) in anew.0.iter_mut().zip(instants) {
            for (own, view) in of_instant.iter_mut().zip(&instant.views) {
                if is_concerned(view) {
                    *own = branches(site, view);
                }
            }
        }
        anew
    }

    /// `camera_from_tag` by the corners of a view.
    pub fn by_corners(&self, instant: usize, view: usize) -> &[Pose] {
        &self.0[instant][view]
    }

    /// Those of one instant, by view.
    pub fn of_instant(&self, instant: usize) -> &[Vec<Pose>] {
        &self.0[instant]
    }
}

fn branches(site: &NominalSite, view: &View) -> Vec<Pose> {
    let camera = site.cameras[view.camera].as_ref();
    camera.map_or_else(Vec::new, |camera| {
        let poses = tag_poses(
            &camera.lens,
            &view.corners_at(camera.clock_s),
            site.tags[view.tag].size_m,
        );
        poses.iter().map(|pose| pose.camera_from_tag).collect()
    })
}

/// A view's term for the pose of its body.
pub(crate) fn body_term<'a>(camera: &'a SiteCamera, tag: &SiteTag, view: &View) -> Term<'a> {
    Term {
        lens: &camera.lens,
        outer: camera.world_from_camera.inverse(),
        points: tag_corners_in_tag(tag.size_m).map(|corner| tag.body_from_tag * corner),
        corners: view.corners_at(camera.clock_s),
        whitening: spread(camera, tag, view).whitening(&view.corners),
    }
}

/// Variances of the corners of a view: by the detector, and by errors of camera and tag that are no mistake.
fn spread(camera: &SiteCamera, tag: &SiteTag, view: &View) -> Spread {
    let px_per_m = edge_px(view) / tag.size_m;
    let focal_px = camera.lens.intrinsics().fx;
    let turned_px = camera.sigma.orientation_rad * focal_px;
    let nearer = camera.sigma.position_m * px_per_m / focal_px;
    let by_tag = spread_by_tag(tag, view);
    Spread {
        shift: by_tag.shift + (camera.sigma.position_m * px_per_m).powi(2) + turned_px.powi(2),
        turn: by_tag.turn + camera.sigma.orientation_rad.powi(2),
        scale: by_tag.scale + nearer.powi(2),
        ..by_tag
    }
}

/// The same of the views of one camera, which its own errors move together.
fn spread_by_tag(tag: &SiteTag, view: &View) -> Spread {
    let edge_px = edge_px(view);
    let tilted_px = tag.sigma.orientation_rad * edge_px;
    Spread {
        own: view.sigma_px.powi(2) + FLOOR_PX.powi(2) + tilted_px.powi(2),
        shift: (tag.sigma.position_m * edge_px / tag.size_m).powi(2),
        turn: tag.sigma.orientation_rad.powi(2),
        scale: SIZE_SIGMA.powi(2),
    }
}

/// Edge of a tag in the image, px, by its diagonals.
fn edge_px(view: &View) -> f64 {
    let [a, b, c, d] = &view.corners;
    0.5 * ((c - a).norm() + (d - b).norm()) * std::f64::consts::FRAC_1_SQRT_2
}

/// Standard deviation of what no model knows, px.
const FLOOR_PX: f64 = 0.5;
/// Standard deviation of the logarithm of a size that is no mistake.
const SIZE_SIGMA: f64 = 0.01;

impl Explained {
    /// By the poses of each instant's views, each from its own best start.
    pub fn new(site: &NominalSite, instants: &[Instant], branches: &Branches) -> Self {
        let fits = instants.iter().zip(&branches.0);
        let costs = fits.map(|(instant, branches)| costs(site, instant, branches));
        Self {
            costs: costs.collect(),
        }
    }

    /// Anew for the instants of which a view is concerned; the others are as they were.
    pub fn renewed(
        &self,
        site: &NominalSite,
        instants: &[Instant],
        branches: &Branches,
        is_concerned: impl Fn(&View) -> bool,
    ) -> Self {
        let mut anew = self.clone();
        for (index, instant) in instants.iter().enumerate() {
            if instant.views.iter().any(&is_concerned) {
                anew.costs[index] = costs(site, instant, &branches.0[index]);
            }
        }
        anew
    }

    /// The sum of all costs.
    pub fn total(&self) -> f64 {
        self.costs.iter().flatten().sum()
    }

    /// The average cost of the views that do not contradict; zero without one.
    pub fn agreeing_cost(&self) -> f64 {
        let costs = self.costs.iter().flatten();
        let agreeing = costs.filter(|cost| !contradicts(**cost));
        let (sum, n_views) = agreeing.fold((0.0, 0.0), |(sum, n), cost| (sum + cost, n + 1.0));
        sum / f64::max(n_views, 1.0)
    }

    /// The views that contradict, with their instants.
    pub fn contradicting<'a>(
        &'a self,
        instants: &'a [Instant],
    ) -> impl Iterator<Item = (usize, &'a View)> {
        let of_instant = |(index, (instant, costs)): (usize, (&'a Instant, &'a Vec<f64>))| {
            let views = instant.views.iter().zip(costs);
            let wrong = views.filter(|(_, cost)| contradicts(**cost));
            wrong.map(move |(view, _)| (index, view))
        };
        instants
            .iter()
            .zip(&self.costs)
            .enumerate()
            .flat_map(of_instant)
    }
}

/// What each view of an instant costs: against the pose by all of them, and against the other views of its camera
/// alone, whatever is wrong with the camera's place.
fn costs(site: &NominalSite, instant: &Instant, branches: &[Vec<Pose>]) -> Vec<f64> {
    let pose = pose_by(site, instant, branches, |_| true, body_term);
    let mut costs = against(site, instant, pose, body_term);
    for camera in cameras(instant.views.iter()) {
        let is_own = |view: &View| view.camera == camera;
        if instant.views.iter().filter(|view| is_own(view)).count() > 1 {
            let pose = pose_by(site, instant, branches, is_own, term_by_tag);
            let among_own = against(site, instant, pose, term_by_tag);
            let own = instant.views.iter().map(is_own);
            for ((cost, among_own), is_own) in costs.iter_mut().zip(among_own).zip(own) {
                if is_own {
                    *cost = cost.max(among_own);
                }
            }
        }
    }
    costs
}

/// A view's term against others of its camera.
fn term_by_tag<'a>(camera: &'a SiteCamera, tag: &SiteTag, view: &View) -> Term<'a> {
    Term {
        whitening: spread_by_tag(tag, view).whitening(&view.corners),
        ..body_term(camera, tag, view)
    }
}

/// How a view becomes a term.
type MakeTerm<'s> = fn(&'s SiteCamera, &SiteTag, &View) -> Term<'s>;

/// The pose of an instant by the views that are used; `None` where none is.
fn pose_by<'s>(
    site: &'s NominalSite,
    instant: &Instant,
    branches: &[Vec<Pose>],
    is_used: impl Fn(&View) -> bool,
    make_term: MakeTerm<'s>,
) -> Option<Pose> {
    let pairs = instant.views.iter().zip(branches);
    let used = pairs.filter(|(view, _)| is_used(view));
    let used = used.filter_map(|(view, branches)| {
        let camera = site.cameras[view.camera].as_ref()?;
        Some((camera, &site.tags[view.tag], view, branches))
    });
    let used: Vec<_> = used.collect();
    let terms = used.iter();
    let terms = terms.map(|(camera, tag, view, _)| make_term(camera, tag, view));
    let terms: Vec<Term<'_>> = terms.collect();
    let starts = used.iter().flat_map(|(camera, tag, _, branches)| {
        let tag_from_body = tag.body_from_tag.inverse();
        let branches = branches.iter();
        branches.map(move |branch| camera.world_from_camera * branch * tag_from_body)
    });
    best_of(&terms, starts).map(|(pose, _)| pose)
}

/// Squares of the distances of expected and seen corners at the pose that explains most views, px², by view; `None`
/// where a view can't be seen so.
pub(crate) fn squares_px(site: &NominalSite, instant: &Instant) -> Vec<Option<f64>> {
    let branches = Branches::new(site, std::slice::from_ref(instant));
    let pose = pose_by(site, instant, branches.of_instant(0), |_| true, body_term);
    let square = |view: &View| {
        let camera = site.cameras[view.camera].as_ref()?;
        body_term(camera, &site.tags[view.tag], view).square_px(&pose?)
    };
    instant.views.iter().map(square).collect()
}

/// What each view of an instant costs at a pose.
fn against<'s>(
    site: &'s NominalSite,
    instant: &Instant,
    pose: Option<Pose>,
    make_term: MakeTerm<'s>,
) -> Vec<f64> {
    let cost = |view: &View| {
        let camera = site.cameras[view.camera].as_ref();
        let term = camera.map(|camera| make_term(camera, &site.tags[view.tag], view));
        let term = term.zip(pose);
        term.map_or(MOST_COST, |(term, pose)| term.cost(&pose))
    };
    instant.views.iter().map(cost).collect()
}

/// The poses of all bodies by the views that are used; `None` where none is.
pub(crate) fn poses_by(
    site: &NominalSite,
    instants: &[Instant],
    branches: &Branches,
    is_used: impl Fn(&View) -> bool,
) -> Vec<Option<Pose>> {
    let poses = instants.iter().zip(&branches.0);
    let poses = poses.map(|(instant, own)| pose_by(site, instant, own, &is_used, body_term));
    poses.collect()
}

/// The poses of a body by the views of each camera alone.
pub(crate) fn poses_by_camera(
    site: &NominalSite,
    instant: &Instant,
    branches: &[Vec<Pose>],
) -> BTreeMap<usize, Pose> {
    let cameras = cameras(instant.views.iter()).into_iter();
    let pose = |camera: usize| {
        let is_own = |view: &View| view.camera == camera;
        let pose = pose_by(site, instant, branches, is_own, body_term)?;
        Some((camera, pose))
    };
    cameras.filter_map(pose).collect()
}

/// The cameras of some views.
fn cameras<'a>(views: impl Iterator<Item = &'a View>) -> BTreeSet<usize> {
    views.map(|view| view.camera).collect()
}
