//! Whether the cameras' clocks can be taken at their word.
//!
//! Cameras that say nothing about their clocks are taken to agree, which most do: synchronised by cable, or on one machine.
//! If one of them is off, its images lie ahead of or behind the motion, always by the same time. Once that is beyond chance
//! the offsets of all clocks that nobody vouches for become part of the state.

use nalgebra::Matrix6;
use sextant_geometry::se3;

use crate::FusionOptions;
use crate::filter::clocks::{ClockPrior, apparent_offset};
use crate::filter::corners::Sight;
use crate::filter::kinematics::Kinematics;
use crate::filter::solve::{Prior, solve};
use crate::site::StatedClock;

/// Most that one image may count, in sigmas: a jolt looks like an offset once.
const MOST_SIGMAS: f64 = 5.0;
/// Share of what is known that each image leaves: an offset that begins later is seen too.
const KEEP: f64 = 0.97;
/// Fewest images that raise a suspicion.
const FEWEST: u32 = 3;
/// Seconds below which an offset is not worth the trouble.
const SMALL_S: f64 = 0.0005;

/// What speaks for one camera's clock being off.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Suspicion {
    /// Sum of apparent offset times information.
    weighted: f64,
    /// Sum of the information in 1/s².
    information: f64,
    images: u32,
}

/// What an object's images tell about the clocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Timing {
    /// Whether the clocks that nobody vouches for are estimated.
    pub open: bool,
    /// By camera index.
    suspicion: Vec<Suspicion>,
    /// By camera index: what an earlier track found out.
    learned: Vec<Option<ClockPrior>>,
}

impl Suspicion {
    fn add(&mut self, offset_s: f64, information: f64) {
        let root = information.sqrt();
        let sigmas = (offset_s * root).clamp(-MOST_SIGMAS, MOST_SIGMAS);
        self.weighted = self.weighted * KEEP + sigmas * root;
        self.information = self.information * KEEP + information;
        self.images += 1;
    }

    fn is_beyond_chance(&self, options: &FusionOptions) -> bool {
        let chi2 = self.weighted.powi(2) / self.information.max(f64::MIN_POSITIVE);
        let large = (self.weighted / self.information).abs() > SMALL_S;
        self.images >= FEWEST && large && chi2 > options.clock_suspicion
    }
}

impl Timing {
    /// What is to be estimated about a clock; `None` where it is taken at its word.
    pub fn clock(
        &self,
        camera_index: usize,
        stated: StatedClock,
        options: &FusionOptions,
    ) -> Option<ClockPrior> {
        let learned = self.learned.get(camera_index).copied().flatten();
        match stated {
            StatedClock::Right => None,
            StatedClock::Within(sigma_s) => learned.or(Some(ClockPrior {
                offset_s: 0.0,
                sigma_s,
            })),
            StatedClock::Unknown if self.open => learned.or(Some(ClockPrior {
                offset_s: 0.0,
                sigma_s: options.unknown_clock_s,
            })),
            StatedClock::Unknown => None,
        }
    }

    /// Takes over what speaks against the clocks.
    pub fn suspicion_of(&mut self, other: Self) {
        self.suspicion = other.suspicion;
    }

    /// Keeps what a track that ends has found out about the clocks.
    pub fn learn(&mut self, state: &Kinematics) {
        for (camera_index, prior) in state.clocks.iter().flat_map(|clocks| clocks.offsets()) {
            if self.learned.len() <= camera_index {
                self.learned.resize(camera_index + 1, None);
            }
            self.learned[camera_index] = Some(prior);
        }
    }

    /// Looks at the images of a camera that is taken at its word, `expected` being the state predicted for them.
    pub fn suspect(
        &mut self,
        expected: &Kinematics,
        sights: &[Sight<'_>],
        options: &FusionOptions,
    ) {
        let Some((offset_s, information)) = apparent(expected, sights, options) else {
            return;
        };
        let camera_index = sights[0].camera_index;
        if self.suspicion.len() <= camera_index {
            self.suspicion
                .resize(camera_index + 1, Suspicion::default());
        }
        let suspicion = &mut self.suspicion[camera_index];
        suspicion.add(offset_s, information);
        self.open |= suspicion.is_beyond_chance(options);
    }
}

/// The offset that would explain best where one camera sees the object, and its information; `None` where the views
/// contradict each other, too.
fn apparent(
    expected: &Kinematics,
    sights: &[Sight<'_>],
    options: &FusionOptions,
) -> Option<(f64, f64)> {
    let covariance = expected.covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let twist = expected.twist;
    let shifted: Matrix6<f64> =
        covariance + twist * twist.transpose() * options.unknown_clock_s.powi(2);
    let prior = Prior {
        pose: expected.pose,
        information: shifted.try_inverse()?,
    };
    let fit = solve(&prior, sights, &expected.pose)?;
    let refused = |sight: &Sight<'_>| {
        sight
            .normal(&fit.pose)
            .is_none_or(|normal| normal.chi2 > options.tag_gate)
    };
    if fit.surprise > options.prediction_gate || sights.iter().any(refused) {
        return None;
    }
    let off = se3::difference(&fit.pose, &expected.pose);
    let pull = fit.corners.information * off + prior.information * off;
    apparent_offset(&pull, &covariance, &fit.corners.information, &twist)
}
