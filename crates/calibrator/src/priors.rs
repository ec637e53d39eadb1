//! Priors of lenses, tag poses and tag sizes, and the scale of their errors at this site.
//!
//! Each number has a prior: the sigma beside it in the file or, without one, a default that reflects how such a number
//! usually comes about. Numbers of one kind share a scale by which their sigmas are multiplied, a variance component
//! that the images determine (the fixed point of D. MacKay, Bayesian interpolation, 1992): with exact files it falls
//! almost to zero, with tags glued on by hand it rises. Without information about a kind, its scale stays one.
//!
//! A scale that falls is the likeliest one, not the only one: few numbers that happen to be near their means say little
//! of the next. Reported deviations therefore go by the largest scale that the images do not exclude.

use nalgebra::{DMatrix, DVector, Point2};
use sextant_adjustment::{Anchor, BundleCamera, BundleSolution, BundleTag, Freedom, KeptParameter};
use sextant_site_model::{
    CENTRE_SIGMA, Camera, DISTORTION_SIGMA, FOCAL_SIGMA, PoseSigma, Prior, SIZE_SIGMA,
    UNKNOWN_CENTRE_SIGMA, UNKNOWN_FOCAL_SIGMA, UNKNOWN_RADIAL_SIGMA, UNKNOWN_TANGENTIAL_SIGMA,
};
use std::collections::BTreeMap;

/// A scale grows by no more than this beyond one, that of lenses by no more than the second, and not at all where the
/// object is held: lenses would take on what is wrong with it.
const MOST_SCALE: [f64; 2] = [30.0, 10.0];
/// Least scale. A scale falls at most by half for every number that the images determine.
const LEAST_SCALE: f64 = 1e-3;
/// Least count of determined numbers to estimate a scale.
const LEAST_DETERMINED: f64 = 1.5;
/// Most fixed-point steps per linearisation, and the change at which they end.
const STEPS: usize = 12;
const SETTLED: f64 = 0.03;

/// Kinds of numbers; each shares a scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    TagPosition,
    TagRotation,
    TagSize,
    Focal,
    Centre,
    Distortion,
    CameraPosition,
    CameraRotation,
    Clock,
    LineDelay,
    Scale,
    Arm,
}

impl Kind {
    /// Whether its scale is one: what single numbers differ by says nothing of others.
    fn has_fixed_scale(self) -> bool {
        matches!(self, Self::Clock | Self::LineDelay | Self::Scale)
    }

    fn from_parameter(parameter: KeptParameter) -> Self {
        match parameter {
            KeptParameter::TagPosition { .. } => Self::TagPosition,
            KeptParameter::TagRotation { .. } => Self::TagRotation,
            KeptParameter::TagSize { .. } => Self::TagSize,
            KeptParameter::Lens { parameter, .. } if parameter < 2 => Self::Focal,
            KeptParameter::Lens { parameter, .. } if parameter < 4 => Self::Centre,
            KeptParameter::Lens { .. } => Self::Distortion,
            KeptParameter::CameraPosition { .. } => Self::CameraPosition,
            KeptParameter::Clock { .. } => Self::Clock,
            KeptParameter::LineDelay { .. } => Self::LineDelay,
            KeptParameter::Scale { .. } => Self::Scale,
            KeptParameter::CameraRotation { .. } => Self::CameraRotation,
            KeptParameter::ArmPosition { .. }
            | KeptParameter::ArmRotation { .. }
            | KeptParameter::ArmDelay => Self::Arm,
        }
    }
}

/// Kind of a number, and whether its prior was given.
type PriorKind = (Kind, bool);

/// The priors of an adjustment and their scales.
#[derive(Clone, Debug, Default)]
pub(crate) struct Priors {
    /// Priors with their given or default sigmas, and whether each was given.
    anchors: Vec<(Anchor, bool)>,
    scales: BTreeMap<PriorKind, f64>,
    /// Whether no scale exceeds one.
    is_bounded: bool,
}

/// One number with a prior, at a solution.
struct Member {
    row: usize,
    error: f64,
    /// Unscaled sigma, given or by default.
    sigma: f64,
    /// The sigma with which the solution was found.
    used: f64,
    kind: PriorKind,
}

impl Priors {
    /// Priors whose sigmas only shrink: where no pose of a tag has a prior, sizes with weak ones would let the common
    /// scale drift.
    pub(crate) fn bounded() -> Self {
        Self {
            is_bounded: true,
            ..Self::default()
        }
    }

    /// Frees the pose of a tag, with its value as the mean of its prior.
    pub(crate) fn free_pose(
        &mut self,
        tags: &mut [BundleTag],
        tag: usize,
        prior: Prior<PoseSigma>,
    ) {
        tags[tag].pose = Freedom::Free;
        let anchor = Anchor::Tag {
            across: 1.0,
            tag,
            object_from_tag: tags[tag].object_from_tag,
            sigma: prior.sigma_or(PoseSigma::OF_TAG),
        };
        self.anchors.push((anchor, prior != Prior::Default));
    }

    /// Frees the size of a tag, with its value as the mean of its prior.
    pub(crate) fn free_size(&mut self, tags: &mut [BundleTag], tag: usize, prior: Prior<f64>) {
        tags[tag].size = Freedom::Free;
        let size_m = tags[tag].size_m;
        let anchor = Anchor::Size {
            tag,
            size_m,
            sigma: prior.sigma_or(SIZE_SIGMA * size_m) / size_m,
        };
        self.anchors.push((anchor, prior != Prior::Default));
    }

    /// Frees the lens of a camera, with its value as the mean of its prior, unless it is exact.
    pub(crate) fn free_lens(
        &mut self,
        cameras: &mut [BundleCamera],
        camera: usize,
        Camera {
            resolution,
            lens_prior,
            ..
        }: &Camera,
    ) {
        if *lens_prior == Prior::Exact {
            return;
        }
        let (fx, sigma) = (cameras[camera].lens.intrinsics().fx, lens_prior.given());
        let width = f64::from(resolution[0]) - 1.0;
        self.free_parameters(
            cameras,
            camera,
            *resolution,
            |parameter, by| match parameter {
                0 | 1 => (
                    sigma.map_or(FOCAL_SIGMA * fx, |s| s.focal_px),
                    sigma.is_some(),
                ),
                2 | 3 => (CENTRE_SIGMA * width, false),
                _ => {
                    let displaced = sigma.map_or(DISTORTION_SIGMA * width, |s| s.distortion_px);
                    (displaced / by, sigma.is_some())
                }
            },
        );
    }

    /// Frees the lens of a camera of which only the image size is known, with its value as the mean of a wide prior.
    pub(crate) fn free_unknown_lens(
        &mut self,
        cameras: &mut [BundleCamera],
        camera: usize,
        resolution: [u32; 2],
    ) {
        let fx = cameras[camera].lens.intrinsics().fx;
        let width = f64::from(resolution[0]) - 1.0;
        self.free_parameters(cameras, camera, resolution, |parameter, by| {
            let sigma = match parameter {
                0 | 1 => UNKNOWN_FOCAL_SIGMA * fx,
                2 | 3 => UNKNOWN_CENTRE_SIGMA * width,
                6 | 7 => UNKNOWN_TANGENTIAL_SIGMA * width / by,
                _ => UNKNOWN_RADIAL_SIGMA * width / by,
            };
            (sigma, true)
        });
    }

    /// Frees the parameters of a lens, with their values as the means of their priors. `sigma` has the standard
    /// deviation of each, none where it is not positive, and whether it is given; from its number, and from the pixels
    /// by which one unit of it moves the image's corner.
    fn free_parameters(
        &mut self,
        cameras: &mut [BundleCamera],
        camera: usize,
        resolution: [u32; 2],
        sigma: impl Fn(usize, f64) -> (f64, bool),
    ) {
        let lens = cameras[camera].lens;
        let fx = lens.intrinsics().fx;
        let [width, height] = resolution.map(|pixels| f64::from(pixels) - 1.0);
        let corner = lens.unproject(&Point2::new(width, height));
        let by_parameter = corner
            .ok()
            .and_then(|ray| lens.parameter_jacobian(&ray.into()));
        for (parameter, value) in lens.parameters().into_iter().enumerate() {
            let by = by_parameter.map_or(fx, |by| by.column(parameter).norm());
            let (sigma, given) = sigma(parameter, by);
            if sigma.is_finite() && sigma > 0.0 {
                cameras[camera].free_lens.0[parameter] = Freedom::Free;
                let anchor = Anchor::Lens {
                    camera,
                    parameter,
                    value,
                    sigma,
                };
                self.anchors.push((anchor, given));
            }
        }
    }

    /// Frees the pose of a camera, with its value as the mean of its prior.
    pub(crate) fn free_camera(
        &mut self,
        cameras: &mut [BundleCamera],
        camera: usize,
        prior: Prior<PoseSigma>,
    ) {
        cameras[camera].pose = Freedom::Free;
        let anchor = Anchor::Camera {
            camera,
            world_from_camera: cameras[camera].world_from_camera,
            sigma: prior.sigma_or(PoseSigma::OF_CAMERA),
        };
        self.anchors.push((anchor, prior != Prior::Default));
    }

    /// Frees the clock of a camera, with its offset as the mean of its prior. The scale of clocks is not estimated.
    pub(crate) fn free_clock(&mut self, cameras: &mut [BundleCamera], camera: usize, sigma_s: f64) {
        cameras[camera].clock = Freedom::Free;
        let anchor = Anchor::Clock {
            camera,
            offset_s: cameras[camera].clock_offset_s,
            sigma: sigma_s,
        };
        self.anchors.push((anchor, true));
    }

    /// Frees the line delay of a camera, with its value as the mean of its prior. The scale of line delays is not
    /// estimated.
    pub(crate) fn free_line_delay(
        &mut self,
        cameras: &mut [BundleCamera],
        camera: usize,
        sigma_s: f64,
    ) {
        cameras[camera].line_delay = Freedom::Free;
        let anchor = Anchor::LineDelay {
            camera,
            line_delay_s: cameras[camera].line_delay_s,
            sigma: sigma_s,
        };
        self.anchors.push((anchor, true));
    }

    /// Anchors with scaled sigmas.
    pub(crate) fn anchors(&self) -> Vec<Anchor> {
        let scaled = self.anchors.iter().map(|(anchor, given)| {
            let kinds: Vec<Kind> = anchor
                .parameters()
                .into_iter()
                .map(Kind::from_parameter)
                .collect();
            let scale = |at: usize| {
                let kind = kinds.get(at).or(kinds.first());
                kind.map_or(1.0, |kind| self.scale((*kind, *given)))
            };
            anchor.scaled(scale(0), scale(3))
        });
        scaled.collect()
    }

    fn scale(&self, kind: PriorKind) -> f64 {
        self.scales.get(&kind).copied().unwrap_or(1.0)
    }

    /// Estimates the scales from a solution; returns the largest change of a logarithm.
    pub(crate) fn learn(&mut self, solution: &BundleSolution) -> f64 {
        let members = self.members(solution);
        if members.is_empty() {
            return 0.0;
        }
        let before = self.scales.clone();
        let (information, pull) = without_priors(solution, &members);
        let limits = self.limits(&members, &information);
        for _ in 0..STEPS {
            let change = self.step(&members, &information, &pull, &limits);
            if change.is_none_or(|change| change < SETTLED) {
                break;
            }
        }
        let changes = self.scales.iter().map(|(kind, scale)| {
            let before = before.get(kind).copied().unwrap_or(1.0);
            (scale / before).ln().abs()
        });
        changes.fold(0.0, f64::max)
    }

    /// The priors by which standard deviations are reported; `None` where they are those of the solution.
    pub(crate) fn reported(&self, solution: &BundleSolution) -> Option<Self> {
        let members = self.members(solution);
        let (information, pull) = without_priors(solution, &members);
        let mut reported = self.clone();
        for (kind, scale) in &self.scales {
            if *scale < 1.0
                && let Some(largest) = self.largest_scale(*kind, &members, &information, &pull)
            {
                reported.scales.insert(*kind, largest.clamp(*scale, 1.0));
            }
        }
        (reported.scales != self.scales).then_some(reported)
    }

    /// The scale with which so small errors of this kind happen in one case of twenty.
    ///
    /// With a scale of one, the share `g` of a number's variance that the images determine is that of its estimate;
    /// with a scale `s` it is `g^2 s^2 + g (1 - g)`, of which the second part is the noise.
    fn largest_scale(
        &self,
        kind: PriorKind,
        members: &[Member],
        information: &DMatrix<f64>,
        pull: &DVector<f64>,
    ) -> Option<f64> {
        let mut usual = self.clone();
        usual.scales.insert(kind, 1.0);
        let factor = usual.with_members(members, information).cholesky()?;
        let covariance = factor.inverse();
        let errors = &covariance * pull;
        let (mut squares, mut shares, mut shares_squared) = (0.0, 0.0, 0.0);
        for Member { row, sigma, .. } in members.iter().filter(|member| member.kind == kind) {
            let share = (1.0 - covariance[(*row, *row)] / sigma.powi(2)).clamp(0.0, 1.0);
            squares += (errors[*row] / sigma).powi(2);
            shares += share;
            shares_squared += share.powi(2);
        }
        let freedom = shares.powi(2) / shares_squared;
        let largest = squares * freedom / least_chi_square(freedom);
        let squared = (largest - (shares - shares_squared)) / shares_squared;
        squared.is_finite().then(|| squared.max(0.0).sqrt())
    }

    /// Whether no pose and no size of a tag has a prior.
    fn holds_tags(&self) -> bool {
        let of_tag = |anchor: &Anchor| matches!(anchor, Anchor::Tag { .. } | Anchor::Size { .. });
        !self.anchors.iter().any(|(anchor, _)| of_tag(anchor))
    }

    fn members(&self, solution: &BundleSolution) -> Vec<Member> {
        let rows = solution.covariance.parameters().iter().enumerate();
        let rows: BTreeMap<KeptParameter, usize> = rows.map(|(row, p)| (*p, row)).collect();
        let anchors = self.anchors.iter().zip(&solution.bundle.anchors);
        let members = anchors.flat_map(|((anchor, given), used)| {
            let (errors, sigmas) = (anchor.error(&solution.bundle), anchor.sigmas());
            let (used, rows) = (used.sigmas(), &rows);
            let parameters = anchor.parameters().into_iter().enumerate();
            parameters.filter_map(move |(at, parameter)| {
                let row = *rows.get(&parameter)?;
                (!Kind::from_parameter(parameter).has_fixed_scale()).then(|| Member {
                    row,
                    error: errors[at],
                    sigma: sigmas[at],
                    used: used[at],
                    kind: (Kind::from_parameter(parameter), *given),
                })
            })
        });
        members.collect()
    }

    /// Lower bound of the scale of each kind that the images inform about.
    fn limits(&self, members: &[Member], information: &DMatrix<f64>) -> BTreeMap<PriorKind, f64> {
        let mut determined: BTreeMap<PriorKind, f64> = BTreeMap::new();
        let unscaled = Self::default();
        let covariance = unscaled.with_members(members, information).cholesky();
        let Some(covariance) = covariance.map(|factor| factor.inverse()) else {
            return determined;
        };
        for member in members {
            let left = covariance[(member.row, member.row)] / member.sigma.powi(2);
            *determined.entry(member.kind).or_default() += 1.0 - left.min(1.0);
        }
        determined.retain(|_, number| *number >= LEAST_DETERMINED);
        for ((_, given), number) in &mut determined {
            *number = if *given {
                1.0
            } else {
                (-*number).exp2().max(LEAST_SCALE)
            };
        }
        determined
    }

    fn with_members(&self, members: &[Member], information: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whole = information.clone();
        for member in members {
            let sigma = member.sigma * self.scale(member.kind);
            whole[(member.row, member.row)] += sigma.powi(-2);
        }
        for row in 0..whole.nrows() {
            whole[(row, row)] *= 1.0 + 1e-12;
            whole[(row, row)] += f64::MIN_POSITIVE;
        }
        whole
    }

    /// One fixed-point step; returns the largest change of a logarithm.
    fn step(
        &mut self,
        members: &[Member],
        information: &DMatrix<f64>,
        pull: &DVector<f64>,
        limits: &BTreeMap<PriorKind, f64>,
    ) -> Option<f64> {
        let covariance = self
            .with_members(members, information)
            .cholesky()?
            .inverse();
        let errors = &covariance * pull;
        let mut sums: BTreeMap<PriorKind, (f64, f64)> = BTreeMap::new();
        for member in members {
            let sum = sums.entry(member.kind).or_default();
            let sigma = member.sigma * self.scale(member.kind);
            sum.0 += (errors[member.row] / member.sigma).powi(2);
            sum.1 += (1.0 - covariance[(member.row, member.row)] / sigma.powi(2)).max(0.0);
        }
        let mut change = 0.0_f64;
        for (kind, (squares, determined)) in sums {
            if let Some(least) = limits.get(&kind) {
                let is_lens = matches!(kind.0, Kind::Focal | Kind::Centre | Kind::Distortion);
                let most = match (is_lens, self.holds_tags()) {
                    _ if self.is_bounded => 1.0,
                    (false, _) => MOST_SCALE[0],
                    (true, false) => MOST_SCALE[1],
                    (true, true) => 1.0,
                };
                let scale = (squares / determined).sqrt().clamp(*least, most);
                change = change.max((scale / self.scale(kind)).ln().abs());
                self.scales.insert(kind, scale);
            }
        }
        Some(change)
    }
}

/// What the images alone say: their information, and this times the errors that they find.
fn without_priors(solution: &BundleSolution, members: &[Member]) -> (DMatrix<f64>, DVector<f64>) {
    let mut information = solution.covariance.information().clone();
    let mut errors = DVector::zeros(information.nrows());
    for member in members {
        errors[member.row] = member.error;
    }
    let pull = &information * errors;
    for member in members {
        // The solution states all information in units of the noise that it found.
        let of_prior = member.used.powi(-2) / solution.variance_factor;
        information[(member.row, member.row)] -= of_prior;
    }
    (information, pull)
}

/// The chi-square below which one case of twenty is, by its degrees of freedom (E. B. Wilson and M. M. Hilferty, The
/// distribution of chi-square, 1931).
fn least_chi_square(freedom: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part - 1.645 * part.sqrt()).max(0.0).powi(3)
}
