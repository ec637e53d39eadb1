//! The adjustment: Gauss-Newton over the errors of the site and the pose of each keyframe, the poses eliminated (Schur
//! complement).

mod alignment;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use nalgebra::{DMatrix, DVector, SVector, Vector3, Vector6};

use crate::measurement::corners::{CalibratedCamera, ViewNoise, WeightedView, unseen_cost};
use crate::measurement::rolling_shutter::LinkMotion;
use crate::self_calibration::accelerations::Accelerations;
use crate::self_calibration::design_effect::DesignEffect;
use crate::self_calibration::evidence::NOTHING;
use crate::self_calibration::gauge::Gauge;
use crate::self_calibration::keyframes::{Body, Keyframe, KeyframeView, Keyframes};
use crate::self_calibration::normal_equations::{
    EliminationEquations, KeyframeEquations, Solution, Weighting, cost, independence, normal,
};
use crate::self_calibration::parameters::{
    CLASSES, CLOCK, Class, LENS, OF_CAMERA, ParameterLayout, SIZE, Source,
};
use crate::self_calibration::variance_components::Scales;
use crate::self_calibration::view_rows::{PoseRows, square};
use crate::site::ModelledSite;
use crate::site::corrections::{
    CameraCorrection, Corrections, ObjectFrame, ScaleCorrection, TagCorrection,
};
use sextant_site_model::{LensSigma, ObjectTag, PoseSigma};

/// Steps of one adjustment; most begin next to the minimum, those of few keyframes do not.
const STEPS: usize = 4;
const FIRST_STEPS: usize = 12;
const FEW: usize = 8;
/// Coordinates of a view.
const COORDINATES: f64 = 8.0;
/// Median of chi-square with eight degrees of freedom.
const MEDIAN: f64 = 7.34;
/// Most that the logarithm of a size is corrected by.
const MOST_LOG_SIZE: f64 = 0.5;
/// Most that the logarithm of the scale of an object is: beyond any printer's setting it is another mistake.
const MOST_LOG_SCALE: f64 = 0.08;
/// Information that keeps the pose of a keyframe definite, 1/m^2 and 1/rad^2.
const LEAST_INFORMATION: f64 = 1e-6;

/// Step lengths of the backtracking line search, as shares of the Gauss-Newton step (Nocedal and Wright, Numerical
/// Optimization, chapter 3).
const STEP_LENGTHS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.03];

/// The errors of the site as far as they are known.
#[derive(Debug, Clone, Default)]
pub(crate) struct Adjustment {
    errors: BTreeMap<Source, DVector<f64>>,
    scales: Scales,
    /// Factor on the variance of each camera's corners.
    noise: BTreeMap<usize, f64>,
    design_effect: DesignEffect,
    accelerations: Accelerations,
}

/// What one keyframe says of the errors of its cameras and tags, its pose eliminated.
#[derive(Debug, Clone)]
pub(crate) struct LinearisedKeyframe {
    pub time_ns: u64,
    pub layout: ParameterLayout,
    pub information: DMatrix<f64>,
    /// Of half the weighted squares by the errors.
    pub gradient: DVector<f64>,
    /// Half the weighted squared residuals that the pose does not explain, beyond what noise leaves.
    pub misfit: f64,
    /// From the centre of each camera to the body, world axes, m.
    pub arms: BTreeMap<usize, Vector3<f64>>,
    /// Standard deviation of each camera's clock offset, as [`KeyframeView::clock_sigma_s`].
    pub clock_sigmas_s: BTreeMap<usize, f64>,
    /// First coefficient of each camera's distortion that moves the corners of its image by a pixel.
    pub distortions_per_px: BTreeMap<usize, f64>,
}

/// What the cost of an adjustment is evaluated with.
#[derive(Clone, Copy)]
struct CostContext<'a> {
    layout: &'a ParameterLayout,
    site: &'a ModelledSite,
    weighting: Weighting,
}

/// Whitened squares of the views.
type Squares = Vec<f64>;

impl Adjustment {
    /// Adjusts all keyframes; `None` where numbers end.
    pub fn run(&mut self, keyframes: &mut Keyframes, site: &ModelledSite) -> Option<Corrections> {
        let layout = ParameterLayout::of_files(keyframes, site);
        let mut errors = self.gather(&layout);
        let mut last: Option<Solution> = None;
        let steps = if keyframes.len() < FEW {
            FIRST_STEPS
        } else {
            STEPS
        };
        for step_index in 0..steps {
            let cameras = self.models(&layout, &errors, site);
            self.place_tags(keyframes, &layout, &errors, site);
            let squares = self.squares(keyframes.as_slice(), &cameras);
            if step_index == 0 {
                self.learn_noise(keyframes, &cameras);
            }
            let weighting = Weighting {
                excess: excess(&squares),
                design_effect: self.design_effect.0,
            };
            let scales = match &last {
                Some(last) if keyframes.len() >= FEW => self.supported_scales(last, &layout),
                _ => self.scales.0,
            };
            let equations = self.equations(keyframes.as_slice(), &cameras, &layout, weighting);
            let solution = Solution::solve(equations, layout.precision(&scales), &errors)?;
            let context = CostContext {
                layout: &layout,
                site,
                weighting,
            };
            // Scales follow from the errors at a minimum.
            if self.advance(keyframes, &mut errors, &solution, context) {
                let eliminated = &solution.equations.eliminated;
                self.accelerations = self.accelerations.updated(keyframes, eliminated);
                self.scales = self.scales.updated(&layout, &errors, &solution.variances);
            }
            last = Some(solution);
        }
        self.scatter(&layout, &errors);
        let last = last?;
        let left = last.equations.left;
        let determined = |(variance, precision): (&f64, &f64)| 1.0 - variance * precision;
        let determined = last.variances.iter().zip(&last.precision).map(determined);
        self.design_effect.learn(keyframes, determined.sum(), left);
        let evidence = last.evidence(&layout);
        if evidence.excludes_all() {
            return Some(exact(&layout, site));
        }
        let suffices = evidence.suffices(left);
        let corrections = self.corrections(&layout, &errors, last, site)?;
        Some(if suffices {
            corrections.considered()
        } else {
            corrections
        })
    }

    /// The scales, with [`NOTHING`] for the classes whose errors the evidence of a solution excludes.
    fn supported_scales(
        &self,
        solution: &Solution,
        layout: &ParameterLayout,
    ) -> [f64; CLASSES.len()] {
        let mut scales = self.scales.0;
        let evidence = solution.evidence(layout);
        for class in CLASSES
            .into_iter()
            .filter(|class| evidence.excludes(*class))
        {
            scales[class as usize] = NOTHING;
        }
        scales
    }

    /// Goes the step of a solution, or as much of it as lowers the cost (backtracking): where images say little of an
    /// error, its slopes hold for a short way only. Whether it went the whole step.
    fn advance(
        &self,
        keyframes: &mut Keyframes,
        errors: &mut DVector<f64>,
        solution: &Solution,
        context: CostContext<'_>,
    ) -> bool {
        let step = &solution.step;
        let before = self.objective(keyframes, errors, solution, context);
        let own = solution.equations.eliminated.iter();
        let own: Vec<DVector<f64>> = own.map(|own| own.step(step)).collect();
        for share in STEP_LENGTHS {
            let mut trial = keyframes.clone();
            for (keyframe, own) in trial.iter_mut().zip(&own) {
                keyframe.advance((own * share).as_slice());
            }
            let mut moved = &*errors + step * share;
            for at in context.layout.scales.values() {
                moved[*at] = moved[*at].clamp(-MOST_LOG_SCALE, MOST_LOG_SCALE);
            }
            self.place_tags(&mut trial, context.layout, &moved, context.site);
            if self.objective(&trial, &moved, solution, context) <= before {
                (*keyframes, *errors) = (trial, moved);
                return share == 1.0;
            }
        }
        false
    }

    /// Twice the robust cost of all views, with the priors.
    fn objective(
        &self,
        keyframes: &Keyframes,
        errors: &DVector<f64>,
        solution: &Solution,
        context: CostContext<'_>,
    ) -> f64 {
        let cameras = self.models(context.layout, errors, context.site);
        let of_view = |keyframe: &Keyframe, one: &KeyframeView| {
            let rows = self.pose_rows(keyframe, one, &cameras);
            rows.map_or_else(unseen_cost, |rows| cost(&rows, one, context.weighting))
        };
        let of_keyframe = |keyframe: &Keyframe| {
            let views = keyframe.views.iter();
            let path = keyframe
                .path
                .map_or(0.0, |path| self.accelerations.squared_distance(&path));
            path + views.map(|one| of_view(keyframe, one)).sum::<f64>()
        };
        let of_errors = errors.component_mul(&solution.precision).dot(errors);
        of_errors + keyframes.iter().map(of_keyframe).sum::<f64>()
    }

    /// What a keyframe says of the site's errors against the models in force, its own pose eliminated.
    pub fn linearised(&self, mut keyframe: Keyframe, site: &ModelledSite) -> LinearisedKeyframe {
        let cameras = cameras_in_force(&keyframe, site);
        self.minimise(&mut keyframe, &cameras);
        let tags = keyframe.views.iter();
        let tags = tags.map(|one| (one.view.tag, keyframe.body())).collect();
        let layout = ParameterLayout::new(&keyframe.cameras(), &tags, &BTreeSet::new());
        let keyframes = std::slice::from_ref(&keyframe);
        let weighting = Weighting {
            excess: excess(&self.squares(keyframes, &cameras)),
            design_effect: if self.noise.is_empty() {
                1.0
            } else {
                self.design_effect.0
            },
        };
        let equations = self.keyframe_equations(&keyframe, &cameras, &layout, weighting);
        let square = equations.left - equations.eliminated.explained();
        let freedom = COORDINATES * keyframe.views.len() as f64 - keyframe.n_unknowns() as f64;
        let arm = |(camera, one): (&usize, &CalibratedCamera)| {
            (*camera, keyframe.pose.translation.vector - one.centre)
        };
        let clock_sigmas = keyframe.views.iter();
        let clock_sigmas = clock_sigmas.map(|one| (one.camera_index, one.clock_sigma_s));
        let distortion =
            |camera: &usize| Some((*camera, site.file_camera(*camera)?.distortion_per_px()));
        LinearisedKeyframe {
            distortions_per_px: cameras.keys().filter_map(distortion).collect(),
            time_ns: keyframe.time_ns,
            arms: cameras.iter().map(arm).collect(),
            clock_sigmas_s: clock_sigmas.collect(),
            misfit: 0.5 * (square - freedom / weighting.design_effect),
            information: equations.information,
            gradient: equations.gradient,
            layout,
        }
    }

    fn gather(&self, layout: &ParameterLayout) -> DVector<f64> {
        let mut errors = DVector::zeros(layout.len());
        for (source, places) in layout.blocks() {
            if let Some(known) = self.errors.get(&source) {
                errors.rows_mut(places.start, places.len()).copy_from(known);
            }
        }
        errors
    }

    fn scatter(&mut self, layout: &ParameterLayout, errors: &DVector<f64>) {
        let own = |(source, places): (Source, Range<usize>)| {
            (source, errors.rows(places.start, places.len()).into_owned())
        };
        self.errors.extend(layout.blocks().map(own));
    }

    /// The cameras with their errors taken off.
    fn models(
        &self,
        layout: &ParameterLayout,
        errors: &DVector<f64>,
        site: &ModelledSite,
    ) -> BTreeMap<usize, CalibratedCamera> {
        let cameras = layout.cameras.iter().filter_map(|(camera, first)| {
            let correction =
                camera_correction(&errors.fixed_rows::<OF_CAMERA>(*first).into_owned());
            Some((*camera, site.file_camera(*camera)?.corrected(&correction)))
        });
        cameras.collect()
    }

    /// The offsets of some cameras' clocks are not those of before.
    pub fn forget_clocks(&mut self, is_affected: impl Fn(usize) -> bool) {
        for (source, errors) in &mut self.errors {
            if matches!(source, Source::Camera(camera) if is_affected(*camera)) {
                errors[CLOCK] = 0.0;
            }
        }
    }

    /// From now on `by_s` seconds more are subtracted from the timestamps of a camera.
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        if let Some(errors) = self.errors.get_mut(&Source::Camera(camera_index)) {
            errors[CLOCK] -= by_s;
        }
    }

    /// Sets places of tags and clocks by the errors of the site.
    fn place_tags(
        &self,
        keyframes: &mut Keyframes,
        layout: &ParameterLayout,
        errors: &DVector<f64>,
        site: &ModelledSite,
    ) {
        for one in keyframes
            .iter_mut()
            .flat_map(|keyframe| &mut keyframe.views)
        {
            if let Some(first) = layout.cameras.get(&one.camera_index) {
                one.clock_s = errors[first + CLOCK];
            }
            let Some((body, first)) = layout.tags.get(&one.view.tag) else {
                continue;
            };
            if let Some(place) = site.placement(&one.view.tag) {
                let correction = tag_correction(layout, errors, *body, *first, &place.file);
                one.view.set_model(&correction.tag(&place.file));
            }
        }
    }

    /// Factor on the variance of a view's corners.
    fn factor(&self, one: &KeyframeView) -> f64 {
        let own = self.noise.get(&one.camera_index).copied();
        own.unwrap_or(one.noise_factor)
    }

    fn squares(
        &self,
        keyframes: &[Keyframe],
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) -> Squares {
        let mut squares = Vec::new();
        for keyframe in keyframes {
            for one in &keyframe.views {
                let rows = self.pose_rows(keyframe, one, cameras);
                squares.extend(rows.map(|rows| square(&rows)));
            }
        }
        squares
    }

    /// Whitened rows of a view by its pose; `None` where the camera cannot see the tag's face.
    fn pose_rows(
        &self,
        keyframe: &Keyframe,
        one: &KeyframeView,
        cameras: &BTreeMap<usize, CalibratedCamera>,
    ) -> Option<PoseRows> {
        let (weighted, moving) = self.weighted(keyframe, one, cameras)?;
        weighted.pose_rows(&moving)
    }

    /// A view with its camera, and its body as it moves; `None` where the camera cannot see the tag's face.
    fn weighted<'a>(
        &self,
        keyframe: &Keyframe,
        one: &'a KeyframeView,
        cameras: &'a BTreeMap<usize, CalibratedCamera>,
    ) -> Option<(WeightedView<'a>, LinkMotion)> {
        let pose = one.pose(keyframe);
        let camera = cameras.get(&one.camera_index)?;
        let noise = ViewNoise {
            factor: self.factor(one),
            distortion_share: one.distortion_share,
        };
        let weighted = WeightedView::new(one.camera_index, camera, &one.view, noise, None);
        let moving = LinkMotion {
            pose,
            twist: one.view.after_s.map(|_| one.twist),
        };
        weighted.faces(&pose).then_some((weighted, moving))
    }

    fn equations(
        &self,
        keyframes: &[Keyframe],
        cameras: &BTreeMap<usize, CalibratedCamera>,
        layout: &ParameterLayout,
        weighting: Weighting,
    ) -> EliminationEquations {
        let mut equations = EliminationEquations::new(layout);
        for keyframe in keyframes {
            equations.add(self.keyframe_equations(keyframe, cameras, layout, weighting));
        }
        equations
    }

    fn keyframe_equations(
        &self,
        keyframe: &Keyframe,
        cameras: &BTreeMap<usize, CalibratedCamera>,
        layout: &ParameterLayout,
        weighting: Weighting,
    ) -> KeyframeEquations {
        let (own, gradient) = own_priors(keyframe, &self.accelerations);
        let views = keyframe.views.iter().filter_map(|one| {
            let (weighted, moving) = self.weighted(keyframe, one, cameras)?;
            let rows = weighted.all_rows(&moving, &one.twist(keyframe))?;
            Some((one, normal(&rows, one, weighting)))
        });
        KeyframeEquations::new(keyframe, layout, own, gradient, views)
    }

    fn corrections(
        &self,
        layout: &ParameterLayout,
        errors: &DVector<f64>,
        solution: Solution,
        site: &ModelledSite,
    ) -> Option<Corrections> {
        let precision = layout.precision(&self.scales.0);
        let gauge = Gauge::new(layout, &precision, site);
        let relative = gauge.relative(solution.covariance)?;
        let independent = independence(layout, &relative, &solution.equations.eliminated);
        let variance = |at: usize| relative.get(at, at).max(0.0) * independent;
        let pose_sigma = |first: usize| PoseSigma {
            position_m: ((0..3).map(|axis| variance(first + axis)).sum::<f64>() / 3.0).sqrt(),
            orientation_rad: ((3..6).map(|axis| variance(first + axis)).sum::<f64>() / 3.0).sqrt(),
        };
        let unseen = self.unseen_scales(site);
        let [_, of_lenses, _] = unseen;
        let mut corrections = Corrections {
            independence: independent.sqrt(),
            unseen,
            ..Corrections::default()
        };
        for (camera, first) in &layout.cameras {
            let file = site.file_camera(*camera)?;
            let mut one = camera_correction(&errors.fixed_rows::<OF_CAMERA>(*first).into_owned());
            one.sigma = pose_sigma(*first);
            one.lens_sigma = if layout.is_open(first + LENS) || layout.is_open(first + LENS + 1) {
                LensSigma {
                    focal_px: variance(first + LENS).sqrt(),
                    distortion_px: variance(first + LENS + 1).sqrt() / file.distortion_per_px(),
                }
            } else {
                file.lens_sigma.times(of_lenses)
            };
            corrections.cameras.insert(*camera, one);
        }
        for (body, at) in &layout.scales {
            let (log_factor, sigma) = (errors[*at], solution.variances[*at].sqrt());
            let scale = ScaleCorrection { log_factor, sigma };
            corrections.scales.insert(body.0, scale);
        }
        for (tag, (body, first)) in &layout.tags {
            let place = site.placement(tag)?;
            let mut one = tag_correction(layout, errors, *body, *first, &place.file);
            one.sigma = pose_sigma(*first);
            corrections.tags.insert(*tag, one);
            if let Some(covariance) = gauge.frame_covariance(*body) {
                let frame = ObjectFrame {
                    covariance,
                    scale_variance: gauge.scale_variance(site),
                    centre: gauge.centre,
                };
                // The pose that is published is that of the object, or of its first link.
                corrections.frames.entry(body.0).or_insert(frame);
            }
        }
        Some(corrections)
    }

    /// Scales of the errors of cameras, lenses and tags that no keyframe shows.
    fn unseen_scales(&self, site: &ModelledSite) -> [f64; 3] {
        let classes = [Class::CameraPose, Class::Lens, Class::TagPose];
        let [of_cameras, mut of_lenses, of_tags] =
            classes.map(|class| self.scales.0[class as usize]);
        if site.has_one_camera() {
            // However exact the tags are: nothing checks it.
            of_lenses = 1.0;
        }
        [of_cameras, of_lenses, of_tags]
    }
}

/// Information and gradient of a keyframe's own unknowns before its views.
fn own_priors(keyframe: &Keyframe, accelerations: &Accelerations) -> (DMatrix<f64>, DVector<f64>) {
    let n = keyframe.n_unknowns();
    let mut information = DMatrix::identity(n, n) * LEAST_INFORMATION;
    let mut gradient = DVector::zeros(n);
    if let Some(path) = &keyframe.path {
        for axis in 0..6 {
            let precision = accelerations.precision(axis);
            information[(12 + axis, 12 + axis)] = precision;
            gradient[12 + axis] = precision * path.acceleration[axis];
        }
    }
    (information, gradient)
}

/// Nothing is wrong with the files, as far as images show it: not the lens of a camera that no other one checks.
fn exact(layout: &ParameterLayout, site: &ModelledSite) -> Corrections {
    let camera = |camera: &usize| {
        let lens_sigma = if site.has_one_camera() {
            site.file_camera(*camera)?.lens_sigma
        } else {
            LensSigma::NONE
        };
        Some((*camera, CameraCorrection::none(PoseSigma::NONE, lens_sigma)))
    };
    Corrections {
        cameras: layout.cameras.keys().filter_map(camera).collect(),
        tags: layout
            .tags
            .keys()
            .map(|tag| (*tag, TagCorrection::NONE))
            .collect(),
        independence: 1.0,
        ..Corrections::default()
    }
}

/// The cameras of a keyframe as trackers work with them.
fn cameras_in_force(keyframe: &Keyframe, site: &ModelledSite) -> BTreeMap<usize, CalibratedCamera> {
    let posed = |camera: usize| Some((camera, site.cameras().get(camera)?.posed.clone()?));
    keyframe.cameras().into_iter().filter_map(posed).collect()
}

/// By how much all views exceed their noise: a start far off is approached with as much noise, so that no view is an
/// outlier yet.
fn excess(squares: &Squares) -> f64 {
    let mut all: Vec<f64> = squares.clone();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(MEDIAN);
    (median / MEDIAN).max(1.0)
}

fn camera_correction(errors: &SVector<f64, OF_CAMERA>) -> CameraCorrection {
    CameraCorrection {
        step: errors.fixed_rows::<6>(0).into_owned(),
        focal_px: errors[LENS],
        distortion: errors[LENS + 1],
        sigma: PoseSigma::NONE,
        lens_sigma: LensSigma::NONE,
    }
}

/// The errors of a tag, by its body and its first place, together with the scale of its body.
fn tag_correction(
    layout: &ParameterLayout,
    errors: &DVector<f64>,
    body: Body,
    first: usize,
    file: &ObjectTag,
) -> TagCorrection {
    let log_scale = layout.scales.get(&body).map_or(0.0, |at| errors[*at]);
    let mut step: Vector6<f64> = errors.fixed_rows::<6>(first).into_owned();
    if let Some(object_from_tag) = &file.object_from_tag {
        let place = object_from_tag.translation.vector + step.fixed_rows::<3>(0);
        let mut position = step.fixed_rows_mut::<3>(0);
        position += place * log_scale.exp_m1();
    }
    TagCorrection {
        step,
        log_size: errors[first + SIZE].clamp(-MOST_LOG_SIZE, MOST_LOG_SIZE) + log_scale,
        sigma: PoseSigma::NONE,
    }
}
