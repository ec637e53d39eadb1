//! Which fault explains what a window of images contradicts: the one that all alternatives fall far behind.
//!
//! Every camera and every tag of a window is tried with one parameter (clock offset, size) and with six (pose). A fault
//! is named if its likelihood ratio is high, if it explains much of the contradiction, and if no fault of another
//! source explains nearly as much. Two cameras that explain the same contradict each other. Then the fault is taken as
//! known, and the rest is tested for a further one.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::FaultHypothesis;
use crate::diagnosis::fault_model::clock::ClockFault;
use crate::diagnosis::fault_model::lens::LensFault;
use crate::diagnosis::likelihood_ratio::{Gain, LikelihoodRatio};
use crate::diagnosis::window::WindowEquations;
use crate::self_calibration::parameters::{CLASSES, CLOCK, LENS, SIZE};
use crate::site::ModelledSite;
use sextant_site_model::PoseSigma;

/// Most faults at a time.
const MOST_FAULTS: usize = 4;
/// Logarithm of the likelihood that a parameter gains by fitting noise, by Schwarz's criterion for some hundred
/// coordinates.
const PER_PARAMETER: f64 = 2.5;
/// Cameras that must be in the window for the reference clock to be tested: of two it is right by definition.
const CAMERAS_FOR_REFERENCE: usize = 3;
/// Share of its standard deviation by hand to which no pose is known better: sites warm up, are cleaned and touched.
const LEAST_SIGMA: f64 = 0.03;
/// Factor on the standard deviations that self-calibration leaves: corrections are never as good as their covariance.
const OPTIMISM: f64 = 1.5;
/// Standard deviation of the logarithm of a tag's size that is no fault.
const SIZE_SIGMA: f64 = 0.001;
/// Standard deviation of a focal length and of the displacement of an image's corners that are no fault, px.
const LENS_SIGMA_PX: f64 = 0.1;
/// Standard deviation of a clock offset that is no fault, s.
const CLOCK_SIGMA_S: f64 = 0.0003;
/// Share of a moved camera's likelihood ratio that its clock must explain to be a likely cause as well.
const CLOCK_SHARE: f64 = 0.2;

/// A fault that is named.
#[derive(Debug, Clone)]
pub(crate) struct NamedFault {
    /// Since when it explains most, ns.
    pub since_ns: u64,
    /// The other camera, where it is one of two.
    pub or: Option<usize>,
    /// Whether the camera's clock hardly explains the contradiction.
    pub is_timely: bool,
    /// The likeliest parameters.
    pub parameters: DVector<f64>,
}

/// The faults named so far.
#[derive(Debug, Default)]
pub(crate) struct Isolation {
    pub named: BTreeMap<FaultHypothesis, NamedFault>,
    /// Logarithm of the likelihood ratio of the likeliest fault that is not named.
    pub suspicion: f64,
    /// Faults that explain most but are not confirmed, and since when, ns.
    pending: BTreeMap<FaultHypothesis, u64>,
}

/// What one camera or tag explains.
struct Candidate {
    hypothesis: FaultHypothesis,
    gain: Gain,
    /// Logarithm of the likelihood ratio without what its parameters gain by noise.
    score: f64,
    is_timely: bool,
}

/// A window under test.
struct Test<'a> {
    equations: &'a WindowEquations,
    /// Inverse variances of the errors, the named faults free.
    precision: DVector<f64>,
    reference: usize,
    options: &'a DiagnosisOptions,
}

impl Isolation {
    /// Tests a window. Returns the cameras whose clocks are off, which are not named: their offsets are estimated.
    pub fn judge(
        &mut self,
        now_ns: u64,
        equations: &WindowEquations,
        site: &ModelledSite,
        options: &DiagnosisOptions,
    ) -> Vec<usize> {
        let mut test = Test {
            precision: known_precision(equations, site),
            reference: site.reference(),
            equations,
            options,
        };
        // Which of two cameras it is may show in any window.
        let pairs = self.named.iter().filter(|(_, named)| named.or.is_some());
        let pairs: Vec<_> = pairs
            .map(|(fault, named)| (*fault, named.since_ns))
            .collect();
        self.pending.extend(pairs);
        self.named.retain(|_, named| named.or.is_none());
        self.confirm(&mut test);
        self.suspicion = 0.0;
        let mut clocks = Vec::new();
        let mut pending = std::mem::take(&mut self.pending);
        let confirmation_ns = (options.confirmation_s * 1e9) as u64;
        for _ in 0..MOST_FAULTS {
            let Some((candidate, or)) = self.next(&test) else {
                break;
            };
            let since_ns = pending.remove(&candidate.hypothesis).unwrap_or(now_ns);
            if now_ns < since_ns.saturating_add(confirmation_ns) {
                self.pending.insert(candidate.hypothesis, since_ns);
                break;
            }
            if let FaultHypothesis::Clock(ClockFault { camera }) = candidate.hypothesis {
                clocks.push(camera);
            } else {
                let named = NamedFault {
                    since_ns,
                    or,
                    is_timely: candidate.is_timely,
                    parameters: candidate.gain.parameters,
                };
                self.named.insert(candidate.hypothesis, named);
            }
            test.free(&candidate.hypothesis);
        }
        clocks
    }

    /// Drops the named faults that the window speaks for no more, and frees the others.
    fn confirm(&mut self, test: &mut Test<'_>) {
        let shown: Vec<FaultHypothesis> = self.named.keys().copied().collect();
        let shown = shown.into_iter().filter(|one| test.moved(one).is_some());
        let shown: Vec<FaultHypothesis> = shown.collect();
        for hypothesis in &shown {
            let others = test.with_free(shown.iter().filter(|one| *one != hypothesis));
            let gain = others
                .ratio()
                .and_then(|ratio| others.gain(&ratio, hypothesis));
            match gain.filter(|gain| gain.odds > test.options.cleared_odds) {
                Some(gain) => {
                    if let Some(named) = self.named.get_mut(hypothesis) {
                        named.parameters = gain.parameters;
                    }
                }
                None => drop(self.named.remove(hypothesis)),
            }
        }
        let left: Vec<FaultHypothesis> = self.named.keys().copied().collect();
        left.iter().for_each(|one| test.free(one));
    }

    /// The next fault that stands out, with the other camera where it is one of two.
    fn next(&mut self, test: &Test<'_>) -> Option<(Candidate, Option<usize>)> {
        let options = test.options;
        let ratio = test.ratio()?;
        let mut candidates = test.candidates(&ratio);
        candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
        let best = candidates.first()?;
        self.suspicion = self.suspicion.max(best.score);
        let misfit = test.equations.misfit - ratio.explained;
        if best.score < options.named_odds
            || best.gain.odds
                < best.hypothesis.model().explains() * options.explained_share * misfit
        {
            return None;
        }
        let margin = options
            .margin_odds
            .max(options.margin_share * best.gain.odds);
        let least = best.score - margin;
        let n_close = candidates.partition_point(|one| one.score > least);
        candidates.truncate(n_close);
        let (candidate, or) = chosen(candidates, test.reference)?;
        // What one named fault leaves is too little to tell that two cameras contradict each other.
        let is_clear = or.is_none() || self.named.is_empty();
        let parameters = &candidate.gain.parameters;
        let model = candidate.hypothesis.model();
        let is_worth = model.is_worth_naming(parameters, test.equations, options);
        let is_new = !self.named.contains_key(&candidate.hypothesis);
        (is_worth && is_new && is_clear).then_some((candidate, or))
    }
}

/// Of candidates that explain about the same: the only one, or one of two cameras, with the other.
fn chosen(candidates: Vec<Candidate>, reference: usize) -> Option<(Candidate, Option<usize>)> {
    let mut all = candidates.into_iter();
    let first = all.next()?;
    let Some(second) = all.next() else {
        return Some((first, None));
    };
    let camera = |one: &Candidate| one.hypothesis.camera();
    let (a, b) = camera(&first).zip(camera(&second))?;
    if all.next().is_some() {
        return None;
    }
    let is_clock = |one: &Candidate| matches!(one.hypothesis, FaultHypothesis::Clock(_));
    match (is_clock(&first), is_clock(&second)) {
        (false, false) if a > b => Some((second, Some(a))),
        (false, false) => Some((first, Some(b))),
        (true, true) if a == reference => Some((second, None)),
        (true, _) => Some((first, None)),
        (false, true) => Some((second, None)),
    }
}

/// Inverse variances of the errors as far as they are known.
fn known_precision(equations: &WindowEquations, site: &ModelledSite) -> DVector<f64> {
    let mut layout = equations.layout.clone();
    let own = |sigma: Option<PoseSigma>, usual: PoseSigma| {
        let own = sigma.unwrap_or(PoseSigma::NONE).times(OPTIMISM);
        let least = usual.times(LEAST_SIGMA);
        PoseSigma {
            position_m: own.position_m.max(least.position_m),
            orientation_rad: own.orientation_rad.max(least.orientation_rad),
        }
    };
    for (camera, first) in &equations.layout.cameras {
        layout.set_pose(
            *first,
            own(site.camera_sigma(*camera), PoseSigma::OF_CAMERA),
        );
        let estimated = equations.clock_sigmas_s.get(camera).copied();
        let sigma_s = estimated.unwrap_or(0.0).max(CLOCK_SIGMA_S);
        layout.set(first + CLOCK, &[sigma_s]);
        let lens = site.lens_sigma(*camera).times(OPTIMISM);
        let per_px = equations.distortions_per_px.get(camera).copied();
        let sigmas = [
            lens.focal_px.max(LENS_SIGMA_PX),
            lens.distortion_px.max(LENS_SIGMA_PX) * per_px.unwrap_or(0.0),
        ];
        layout.set(first + LENS, &sigmas);
    }
    for (tag, (_, first)) in &equations.layout.tags {
        layout.set_pose(
            *first,
            own(
                site.placement(tag).and_then(|place| place.sigma),
                PoseSigma::OF_TAG,
            ),
        );
        layout.set(first + SIZE, &[SIZE_SIGMA]);
    }
    layout.precision(&[1.0; CLASSES.len()])
}

impl<'a> Test<'a> {
    fn moved(&self, hypothesis: &FaultHypothesis) -> Option<Vec<Vec<usize>>> {
        hypothesis.model().moved(self.equations)
    }

    /// Takes a fault as known.
    fn free(&mut self, hypothesis: &FaultHypothesis) {
        let moved = self.moved(hypothesis).unwrap_or_default();
        for (places, sigma) in moved.into_iter().zip(hypothesis.model().prior()) {
            for at in places {
                self.precision[at] = sigma.powi(-2);
            }
        }
    }

    fn with_free<'h>(&self, all: impl Iterator<Item = &'h FaultHypothesis>) -> Test<'a> {
        let mut test = Test {
            precision: self.precision.clone(),
            ..*self
        };
        all.for_each(|one| test.free(one));
        test
    }

    fn ratio(&self) -> Option<LikelihoodRatio> {
        let WindowEquations {
            information,
            gradient,
            ..
        } = self.equations;
        LikelihoodRatio::new(information, gradient, self.precision.clone())
    }

    fn gain(&self, ratio: &LikelihoodRatio, hypothesis: &FaultHypothesis) -> Option<Gain> {
        ratio.gain(&self.moved(hypothesis)?, hypothesis.model().prior())
    }

    /// What each camera and tag explains, by its clock or its size alone if that does nearly as well as its pose.
    fn candidates(&self, ratio: &LikelihoodRatio) -> Vec<Candidate> {
        let layout = &self.equations.layout;
        let cameras = layout.cameras.keys().copied();
        let cameras = cameras.map(FaultHypothesis::camera_kinds);
        let tags = layout.tags.keys().copied().map(FaultHypothesis::tag_kinds);
        let candidate = |[simple, whole]: [FaultHypothesis; 2]| {
            let gain = self.gain(ratio, &whole)?;
            let is_reference = simple
                == FaultHypothesis::Clock(ClockFault {
                    camera: self.reference,
                });
            let is_tested = !is_reference || layout.cameras.len() >= CAMERAS_FOR_REFERENCE;
            let simple_gain = self.gain(ratio, &simple).filter(|_| is_tested);
            let by_simple = simple_gain.as_ref().map_or(0.0, |own| own.odds);
            let is_timely = by_simple < CLOCK_SHARE * gain.odds;
            let allowed = self.options.margin_odds + simple.model().unexplained() * gain.odds;
            let simple_gain = simple_gain.filter(|own| own.odds > gain.odds - allowed);
            let (hypothesis, gain) = match simple_gain {
                Some(own) => (simple, own),
                None => (whole, gain),
            };
            let score = gain.odds - PER_PARAMETER * gain.parameters.len() as f64;
            Some(Candidate {
                hypothesis,
                gain,
                score,
                is_timely,
            })
        };
        let lens = |camera: &usize| {
            let hypothesis = FaultHypothesis::Lens(LensFault { camera: *camera });
            let gain = self.gain(ratio, &hypothesis)?;
            Some(Candidate {
                score: gain.odds - PER_PARAMETER * gain.parameters.len() as f64,
                hypothesis,
                gain,
                is_timely: true,
            })
        };
        let lenses = layout.cameras.keys().filter_map(lens);
        cameras
            .chain(tags)
            .filter_map(candidate)
            .chain(lenses)
            .collect()
    }
}
