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

/// From where and when a state is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObservationTime {
    pub camera_index: usize,
    /// Seconds from the capture time to the rows that show it, on the whole. The rates lead there; by what the body may have
    /// done of itself between, what is seen is uncertain.
    pub apart_s: f64,
}

/// What a camera sees of the state.
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

    /// The configuration as the camera saw it if its clock's offset is what it is thought to be, however uncertain that is.
    pub fn observed_on_time<const D: usize>(
        &self,
        camera_index: usize,
    ) -> ObservedConfiguration<D> {
        let clocked = self.clocks.as_deref();
        let offset = clocked.and_then(|clocks| Some(clocks.offset_s(clocks.slot(camera_index)?)));
        let mut observed = self.observed_now::<D>(0.0);
        if let Some(offset) = offset {
            let step = self.rates::<D>() * -offset;
            observed.configuration = observed.configuration.perturbed(&step);
        }
        observed
    }

    pub fn observed_from<const D: usize>(
        &self,
        vantage: ObservationTime,
    ) -> ObservedConfiguration<D> {
        let clocked = self.clocks.as_deref();
        let slot = clocked.and_then(|clocks| Some((clocks, clocks.slot(vantage.camera_index)?)));
        match slot {
            Some((clocks, slot)) => self.observed_at_offset((clocks, slot), vantage.apart_s),
            None => self.observed_now(vantage.apart_s),
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

    /// Besides B P Bᵀ what is seen is uncertain by the product of the errors of offset and rates, and by what the body may
    /// have done between.
    fn observed_at_offset<const D: usize>(
        &self,
        (clocks, slot): (&ClockStates, usize),
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

    /// What base and joints may have done of themselves in `dt` seconds.
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

    /// Covariance of what is seen, all clocks being right, with the parts of the state.
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

    /// Places without a joint hang together with nothing and have variance one.
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
