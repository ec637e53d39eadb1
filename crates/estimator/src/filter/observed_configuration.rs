//! The configuration as a camera saw it: a linear function of the state.
//!
//! With the offset o of the camera's clock and the rates x of base and joints the camera sees configuration - o x: the
//! state times B = [I, -o I, -x]. Where its shutter rolls it sees the rates as well.

use nalgebra::{Cholesky, Const, SMatrix, SVector};

use crate::filter::clock_states::ClockStates;
use crate::filter::covariance::{
    Covariance, CrossCovariance, JointOwn, symmetric, white_acceleration,
};
use crate::filter::least_squares::Prior;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::{Configuration, joint_places, rates_at};
use sextant_site_model::MOST_JOINTS;

/// Camera and time spread of an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObservationTime {
    pub camera_index: usize,
    /// Mean distance of the rows that show the object from the capture time, s: acceleration within it makes the
    /// observation uncertain.
    pub apart_s: f64,
}

/// The configuration that a camera sees.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObservedConfiguration<const D: usize> {
    /// When the image was taken.
    pub configuration: Configuration,
    pub covariance: SMatrix<f64, D, D>,
    pub with: CrossCovariance<D>,
}

/// The first (place 0) or second half (place 1) of motion and joints: configuration or rates.
const CONFIGURATION: usize = 0;
const RATES: usize = 1;

impl<const D: usize> ObservedConfiguration<D> {
    /// What is known about it before; `None` where its covariance is not positive definite.
    pub fn prior(&self) -> Option<Prior<D>> {
        let information = Cholesky::<f64, Const<D>>::new(self.covariance)?.inverse();
        Some(Prior {
            configuration: self.configuration,
            information,
        })
    }

    /// Squared Mahalanobis distance of a configuration; `None` as with [`Self::prior`].
    pub fn nis(&self, at: &Configuration) -> Option<f64> {
        let off = at.difference::<D>(&self.configuration);
        let root = Cholesky::<f64, Const<D>>::new(self.covariance)?.unpack();
        Some(root.solve_lower_triangular(&off)?.norm_squared())
    }
}

impl ObjectState {
    /// The configuration as the camera saw it; its clock is right unless it is part of the state.
    pub fn observed<const D: usize>(&self, camera_index: usize) -> ObservedConfiguration<D> {
        self.observed_from(ObservationTime {
            camera_index,
            apart_s: 0.0,
        })
    }

    /// Where the camera sees root and joints by the estimated offset of its clock.
    pub fn configuration_seen_by(&self, camera_index: usize) -> Configuration {
        let clocks = self.clocks.as_deref();
        let offset = clocks.and_then(|clocks| Some(clocks.offset_s(clocks.slot(camera_index)?)));
        let step = self.rates::<{ 6 + MOST_JOINTS }>() * -offset.unwrap_or(0.0);
        self.configuration().perturbed(&step)
    }

    pub fn observed_from<const D: usize>(
        &self,
        observation_time: ObservationTime,
    ) -> ObservedConfiguration<D> {
        let clocked = self.clocks.as_deref();
        let slot =
            clocked.and_then(|clocks| Some((clocks, clocks.slot(observation_time.camera_index)?)));
        match slot {
            Some((clocks, slot)) => self.observed_at_offset(clocks, slot, observation_time.apart_s),
            None => self.observed_now(observation_time.apart_s),
        }
    }

    fn observed_now<const D: usize>(&self, apart_s: f64) -> ObservedConfiguration<D> {
        let with = self.seen::<D>();
        let mut covariance = with.columns(CONFIGURATION, 0);
        if let Some(first) = rates_at(D) {
            covariance += with.columns(RATES, first);
        }
        if apart_s != 0.0 {
            covariance += self.between::<D>(apart_s);
        }
        self.fill_free_places(&mut covariance);
        ObservedConfiguration {
            configuration: self.configuration(),
            covariance,
            with,
        }
    }

    /// Adds to B P Bᵀ the product of the errors of offset and rates, and the acceleration in between.
    fn observed_at_offset<const D: usize>(
        &self,
        clocks: &ClockStates,
        slot: usize,
        apart_s: f64,
    ) -> ObservedConfiguration<D> {
        let (offset, rates) = (clocks.offset_s(slot), self.rates::<D>());
        let (now, moving) = (self.seen::<D>(), self.with::<D>(RATES, 0));
        let mut with = CrossCovariance {
            motion: now.motion
                - moving.motion * offset
                - rates * clocks.cross.column(slot).transpose(),
            joints: now.joints - moving.joints * offset,
            clocks: now.clocks - moving.clocks * offset - rates * clocks.own.row(slot),
        };
        if let Some(joints) = &self.joints {
            with.joints -= rates * joints.with_clocks.column(slot).transpose();
        }
        let mut linear = with.columns(CONFIGURATION, 0)
            - with.columns(RATES, 0) * offset
            - with.clocks.column(slot) * rates.transpose();
        if let Some(first) = rates_at(D) {
            linear += with.columns(RATES, first);
        }
        let product = moving.columns(RATES, 0) * clocks.own[(slot, slot)];
        let apart = offset.hypot(clocks.own[(slot, slot)].max(0.0).sqrt());
        let between = self.between::<D>(apart.hypot(apart_s));
        let mut covariance = symmetric(&(linear + product + between));
        self.fill_free_places(&mut covariance);
        ObservedConfiguration {
            configuration: self.configuration().perturbed(&(rates * -offset)),
            covariance,
            with,
        }
    }

    /// Covariance of the motion by white acceleration in `dt` seconds.
    fn between<const D: usize>(&self, dt: f64) -> SMatrix<f64, D, D> {
        let noise: Covariance = white_acceleration(dt, self.motion.process_noise_psd(dt));
        let mut between = SMatrix::<f64, D, D>::zeros();
        between
            .fixed_view_mut::<6, 6>(0, 0)
            .copy_from(&noise.fixed_view::<6, 6>(0, 0));
        if let Some(joints) = &self.joints {
            let noise: JointOwn = joints.white_acceleration(dt, self.motion.persistence(dt));
            (0..joint_places(D))
                .for_each(|place| between[(6 + place, 6 + place)] = noise[(place, place)]);
        }
        between
    }

    /// Twist and speeds, in the places of the configuration.
    pub fn rates<const D: usize>(&self) -> SVector<f64, D> {
        let mut rates = SVector::<f64, D>::zeros();
        rates.fixed_rows_mut::<6>(0).copy_from(&self.twist);
        if let Some(joints) = &self.joints {
            (0..joint_places(D)).for_each(|place| rates[6 + place] = joints.speeds[place]);
        }
        rates
    }

    /// Covariance of the observed configuration with the parts of the state, without clock offsets.
    fn seen<const D: usize>(&self) -> CrossCovariance<D> {
        let mut seen = self.with::<D>(CONFIGURATION, 0);
        if let Some(first) = rates_at(D) {
            let rates = self.with::<D>(RATES, first);
            seen.motion += rates.motion;
            seen.joints += rates.joints;
            seen.clocks += rates.clocks;
        }
        seen
    }

    /// Covariance of the configuration or of the rates with the parts of the state, in the places from `first` on.
    fn with<const D: usize>(&self, half: usize, first: usize) -> CrossCovariance<D> {
        let mut with = CrossCovariance {
            motion: SMatrix::zeros(),
            joints: SMatrix::zeros(),
            clocks: SMatrix::zeros(),
        };
        with.motion
            .fixed_rows_mut::<6>(first)
            .copy_from(&self.covariance.fixed_rows::<6>(6 * half));
        if let Some(clocks) = &self.clocks {
            with.clocks
                .fixed_rows_mut::<6>(first)
                .copy_from(&clocks.cross.fixed_rows::<6>(6 * half));
        }
        if let Some(joints) = &self.joints {
            with.joints
                .fixed_rows_mut::<6>(first)
                .copy_from(&joints.cross.fixed_rows::<6>(6 * half));
            for place in 0..joint_places(D) {
                let (from, to) = (MOST_JOINTS * half + place, first + 6 + place);
                let row = joints.cross.column(from).transpose();
                with.motion.row_mut(to).copy_from(&row);
                with.joints.row_mut(to).copy_from(&joints.own.row(from));
                let row = joints.with_clocks.row(from);
                with.clocks.row_mut(to).copy_from(&row);
            }
        }
        with
    }

    /// Unused joint places are uncorrelated and have variance one.
    fn fill_free_places<const D: usize>(&self, covariance: &mut SMatrix<f64, D, D>) {
        let moving = self.joints.as_ref().map_or(0, |joints| joints.moving);
        for first in std::iter::once(0).chain(rates_at(D)) {
            (moving..joint_places(D)).for_each(|joint| {
                let place = first + 6 + joint;
                covariance[(place, place)] = 1.0;
            });
        }
    }
}

impl<const D: usize> CrossCovariance<D> {
    /// The columns of configuration or rates, in the places from `first` on.
    fn columns(&self, half: usize, first: usize) -> SMatrix<f64, D, D> {
        let mut columns = SMatrix::<f64, D, D>::zeros();
        columns
            .fixed_columns_mut::<6>(first)
            .copy_from(&self.motion.fixed_columns::<6>(6 * half));
        for place in 0..joint_places(D) {
            let column = self.joints.column(MOST_JOINTS * half + place);
            columns.column_mut(first + 6 + place).copy_from(&column);
        }
        columns
    }
}
