//! The last keyframes of a site, each linearised at the models in force, and what they say jointly of the site's
//! errors.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::self_calibration::adjustment::LinearisedKeyframe;
use crate::self_calibration::keyframes::Body;
use crate::self_calibration::parameters::{ParameterLayout, Source};
use sextant_site_model::TagId;

/// Most keyframes; the oldest go.
pub(crate) const MAX_KEYFRAMES: usize = 90;
/// Most cameras and tags whose errors are tested at a time: those that contradict most.
const MOST_SOURCES: usize = 16;
/// Information that keeps the test of a single source definite.
const LEAST_INFORMATION: f64 = 1.0;

/// The last keyframes, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Window(VecDeque<LinearisedKeyframe>);

/// Normal equations of the errors of cameras and tags in a window.
pub(crate) struct WindowEquations {
    pub layout: ParameterLayout,
    pub information: DMatrix<f64>,
    /// Of half the squares by the errors.
    pub gradient: DVector<f64>,
    /// Half the squared residuals beyond what noise leaves.
    pub misfit: f64,
    /// From each camera to the body that it saw last, world axes, m.
    pub arms: BTreeMap<usize, Vector3<f64>>,
    /// Standard deviation of each camera's clock offset where it is estimated, s; 0 where the clock is taken to be
    /// right.
    pub clock_sigmas_s: BTreeMap<usize, f64>,
    /// As [`LinearisedKeyframe::distortions_per_px`].
    pub distortions_per_px: BTreeMap<usize, f64>,
}

impl Window {
    /// Takes a keyframe in; those older than `window_ns` before it go.
    pub fn push(&mut self, keyframe: LinearisedKeyframe, window_ns: u64) {
        let oldest_ns = keyframe.time_ns.saturating_sub(window_ns);
        self.0.retain(|one| one.time_ns >= oldest_ns);
        if self.0.len() >= MAX_KEYFRAMES {
            self.0.pop_front();
        }
        self.0.push_back(keyframe);
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Drops the keyframes that a camera is part of: its timestamps mean something else now.
    pub fn forget_camera(&mut self, camera: usize) {
        self.0
            .retain(|one| !one.layout.cameras.contains_key(&camera));
    }

    /// Logarithm of the likelihood ratio of the strongest source, all others being exact: an upper bound of what a test
    /// can find.
    pub fn strongest_pull(&self) -> f64 {
        self.pulls().values().copied().fold(0.0, f64::max)
    }

    /// Half the squares that constant errors of each source alone explain.
    fn pulls(&self) -> BTreeMap<Source, f64> {
        let mut sums: BTreeMap<Source, (DMatrix<f64>, DVector<f64>)> = BTreeMap::new();
        for one in &self.0 {
            for (source, places) in one.layout.blocks() {
                let (first, width) = (places.start, places.len());
                let (information, gradient) = sums.entry(source).or_insert_with(|| {
                    let least = DMatrix::identity(width, width) * LEAST_INFORMATION;
                    (least, DVector::zeros(width))
                });
                *information += one.information.view((first, first), (width, width));
                *gradient += one.gradient.rows(first, width);
            }
        }
        let pull = |(source, (information, gradient)): (Source, (DMatrix<f64>, DVector<f64>))| {
            let factor = information.cholesky()?;
            Some((source, 0.5 * gradient.dot(&factor.solve(&gradient))))
        };
        sums.into_iter().filter_map(pull).collect()
    }

    /// The joint equations of the sources that contradict most.
    pub fn equations(&self) -> WindowEquations {
        let layout = self.layout();
        let mut equations = WindowEquations {
            information: DMatrix::zeros(layout.len(), layout.len()),
            gradient: DVector::zeros(layout.len()),
            misfit: 0.0,
            arms: BTreeMap::new(),
            clock_sigmas_s: BTreeMap::new(),
            distortions_per_px: BTreeMap::new(),
            layout,
        };
        self.0.iter().for_each(|one| equations.add(one));
        equations
    }

    fn layout(&self) -> ParameterLayout {
        let tags = self.0.iter().flat_map(|one| &one.layout.tags);
        let bodies: BTreeMap<TagId, Body> = tags.map(|(tag, (body, _))| (*tag, *body)).collect();
        let mut sources: Vec<(Source, f64)> = self.pulls().into_iter().collect();
        sources.sort_by(|a, b| b.1.total_cmp(&a.1));
        sources.truncate(MOST_SOURCES);
        let (mut cameras, mut tags) = (BTreeSet::new(), BTreeMap::new());
        for (source, _) in sources {
            match source {
                Source::Camera(camera) => drop(cameras.insert(camera)),
                Source::Tag(tag) => drop(tags.insert(tag, bodies[&tag])),
                Source::Scale(_) => {}
            }
        }
        ParameterLayout::new(&cameras, &tags, &BTreeSet::new())
    }
}

impl WindowEquations {
    fn add(&mut self, one: &LinearisedKeyframe) {
        let places: BTreeMap<Source, Range<usize>> = self.layout.blocks().collect();
        let known = one.layout.blocks();
        let known = known.filter_map(|(source, from)| Some((places.get(&source)?.start, from)));
        let own: Vec<(usize, Range<usize>)> = known.collect();
        for (to, from) in &own {
            let mut gradient = self.gradient.rows_mut(*to, from.len());
            gradient += one.gradient.rows(from.start, from.len());
            for (column, from_column) in &own {
                let size = (from.len(), from_column.len());
                let mut block = self.information.view_mut((*to, *column), size);
                block += one.information.view((from.start, from_column.start), size);
            }
        }
        self.misfit += one.misfit;
        self.arms.extend(&one.arms);
        self.clock_sigmas_s.extend(&one.clock_sigmas_s);
        self.distortions_per_px.extend(&one.distortions_per_px);
    }
}
