//! The configuration as a camera saw it: a linear function of the state.
//!
//! With the offset o of the camera's clock and the rates x of base and joints the camera sees configuration - o x: the
//! state times B = [I, -o I, -x].

use nalgebra::{Cholesky, Const, SMatrix, SVector};

use super::chain::Configuration;
use super::clocks::{Clocks, MOST_CLOCKS};
use super::joints::{JointOwn, WIDTH};
use super::kinematics::{Covariance, Kinematics, symmetric, white_acceleration};
use super::solve::Prior;
use crate::articulation::MOST_JOINTS;

/// What a camera sees of the state.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Observed<const D: usize> {
    /// When the image was taken.
    pub configuration: Configuration,
    pub covariance: SMatrix<f64, D, D>,
    pub with: With<D>,
}

/// Covariance of what is seen with the parts of the state.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct With<const D: usize> {
    /// With (dt, dr, dv, dw).
    pub motion: SMatrix<f64, D, 12>,
    /// With the joints' values and speeds.
    pub joints: SMatrix<f64, D, WIDTH>,
    /// With the clocks' offsets.
    pub clocks: SMatrix<f64, D, MOST_CLOCKS>,
}

/// The first (place 0) or second half (place 1) of motion and joints: configuration or rates.
const CONFIGURATION: usize = 0;
const RATES: usize = 1;

impl<const D: usize> Observed<D> {
    /// What is known about it before; `None` where its covariance is not positive definite.
    pub fn prior(&self) -> Option<Prior<D>> {
        let information = Cholesky::<f64, Const<D>>::new(self.covariance)?.inverse();
        Some(Prior {
            configuration: self.configuration,
            information,
        })
    }
}

impl Kinematics {
    /// The configuration as the camera saw it; its clock is right unless it is part of the state.
    pub fn observed<const D: usize>(&self, camera_index: usize) -> Observed<D> {
        let clocked = self.clocks.as_deref();
        let slot = clocked.and_then(|clocks| Some((clocks, clocks.slot(camera_index)?)));
        match slot {
            Some((clocks, slot)) => self.observed_at_offset(clocks, slot),
            None => self.observed_now(),
        }
    }

    fn observed_now<const D: usize>(&self) -> Observed<D> {
        let with = self.with::<D>(CONFIGURATION);
        let mut covariance = with.columns(CONFIGURATION);
        self.fill_free_places(&mut covariance);
        Observed {
            configuration: self.configuration(),
            covariance,
            with,
        }
    }

    /// Besides B P Bᵀ what is seen is uncertain by the product of the errors of offset and rates, and by what the body may
    /// have done between.
    fn observed_at_offset<const D: usize>(&self, clocks: &Clocks, slot: usize) -> Observed<D> {
        let (offset, rates) = (clocks.offset_s(slot), self.rates::<D>());
        let (now, moving) = (self.with::<D>(CONFIGURATION), self.with::<D>(RATES));
        let mut with = With {
            motion: now.motion
                - moving.motion * offset
                - rates * clocks.cross.column(slot).transpose(),
            joints: now.joints - moving.joints * offset,
            clocks: now.clocks - moving.clocks * offset - rates * clocks.own.row(slot),
        };
        if let Some(joints) = &self.joints {
            with.joints -= rates * joints.with_clocks.column(slot).transpose();
        }
        let linear = with.columns(CONFIGURATION)
            - with.columns(RATES) * offset
            - with.clocks.column(slot) * rates.transpose();
        let product = moving.columns(RATES) * clocks.own[(slot, slot)];
        let apart = offset.hypot(clocks.own[(slot, slot)].max(0.0).sqrt());
        let mut covariance = symmetric(&(linear + product + self.between::<D>(apart)));
        self.fill_free_places(&mut covariance);
        Observed {
            configuration: self.configuration().perturbed(&(rates * -offset)),
            covariance,
            with,
        }
    }

    /// What base and joints may have done of themselves in `dt` seconds.
    fn between<const D: usize>(&self, dt: f64) -> SMatrix<f64, D, D> {
        let noise: Covariance = white_acceleration(dt, self.motion.restlessness());
        let mut between = SMatrix::<f64, D, D>::zeros();
        between
            .fixed_view_mut::<6, 6>(0, 0)
            .copy_from(&noise.fixed_view::<6, 6>(0, 0));
        if let Some(joints) = &self.joints {
            let noise: JointOwn = joints.white_acceleration(dt);
            (0..D - 6).for_each(|place| between[(6 + place, 6 + place)] = noise[(place, place)]);
        }
        between
    }

    /// Twist and speeds.
    pub fn rates<const D: usize>(&self) -> SVector<f64, D> {
        let mut rates = SVector::<f64, D>::zeros();
        rates.fixed_rows_mut::<6>(0).copy_from(&self.twist);
        if let Some(joints) = &self.joints {
            (0..D - 6).for_each(|place| rates[6 + place] = joints.speeds[place]);
        }
        rates
    }

    /// Covariance of the configuration or of the rates with the parts of the state.
    fn with<const D: usize>(&self, half: usize) -> With<D> {
        let mut with = With {
            motion: SMatrix::zeros(),
            joints: SMatrix::zeros(),
            clocks: SMatrix::zeros(),
        };
        with.motion
            .fixed_rows_mut::<6>(0)
            .copy_from(&self.covariance.fixed_rows::<6>(6 * half));
        if let Some(clocks) = &self.clocks {
            with.clocks
                .fixed_rows_mut::<6>(0)
                .copy_from(&clocks.cross.fixed_rows::<6>(6 * half));
        }
        if let Some(joints) = &self.joints {
            with.joints
                .fixed_rows_mut::<6>(0)
                .copy_from(&joints.cross.fixed_rows::<6>(6 * half));
            for place in 0..D - 6 {
                let from = MOST_JOINTS * half + place;
                let row = joints.cross.column(from).transpose();
                with.motion.row_mut(6 + place).copy_from(&row);
                with.joints
                    .row_mut(6 + place)
                    .copy_from(&joints.own.row(from));
                let row = joints.with_clocks.row(from);
                with.clocks.row_mut(6 + place).copy_from(&row);
            }
        }
        with
    }

    /// Places without a joint hang together with nothing and have variance one.
    fn fill_free_places<const D: usize>(&self, covariance: &mut SMatrix<f64, D, D>) {
        let moving = self.joints.as_ref().map_or(0, |joints| joints.moving);
        (6 + moving..D).for_each(|place| covariance[(place, place)] = 1.0);
    }
}

impl<const D: usize> With<D> {
    /// The columns of configuration or rates.
    fn columns(&self, half: usize) -> SMatrix<f64, D, D> {
        let mut columns = SMatrix::<f64, D, D>::zeros();
        columns
            .fixed_columns_mut::<6>(0)
            .copy_from(&self.motion.fixed_columns::<6>(6 * half));
        for place in 0..D - 6 {
            let column = self.joints.column(MOST_JOINTS * half + place);
            columns.column_mut(6 + place).copy_from(&column);
        }
        columns
    }
}
