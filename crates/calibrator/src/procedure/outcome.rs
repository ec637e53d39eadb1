//! Result of a procedure: a verdict, a report, and the model to keep.

use super::{LensReport, ProcedureError, ProcedureKind};
use crate::lens::LensCalibration;
use crate::{CalibratedRig, Finding, Grade, LearnReport, LearnedObject, RigReport, Verdict};
use serde::Serialize;
use sextant_site_model::{Camera, CameraId, ObjectModel, Prior, Rig};

/// Result of a procedure.
#[derive(Clone, Debug)]
pub struct ProcedureOutcome {
    /// Which procedure.
    pub kind: ProcedureKind,
    /// Grade and findings.
    pub verdict: Verdict,
    /// How well, in numbers; holds the verdict too.
    pub report: Report,
    /// The model to keep.
    pub product: Product,
}

/// The numbers of one procedure; which one is said by [`ProcedureOutcome::kind`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Report {
    /// Of a lens.
    Lens(LensReport),
    /// Of a rig.
    Rig(RigReport),
    /// Of an object.
    Learn(LearnReport),
}

/// The model to keep.
#[derive(Clone, Debug)]
pub enum Product {
    /// The site's rig with the new lens, or with every camera in its place.
    Rig(Rig),
    /// The object with its tag poses.
    Object(ObjectModel),
}

impl ProcedureOutcome {
    /// What could not be solved and stays as it was, with reasons and remedies; empty where all was.
    pub fn unsolved(&self) -> &[String] {
        match &self.report {
            Report::Lens(_) => &[],
            Report::Rig(report) => &report.unsolved,
            Report::Learn(report) => &report.unsolved,
        }
    }

    /// With findings on images that were left out.
    pub(super) fn with(mut self, left_out: Vec<Finding>) -> Self {
        let in_report = match &mut self.report {
            Report::Lens(report) => &mut report.verdict,
            Report::Rig(report) => &mut report.verdict,
            Report::Learn(report) => &mut report.verdict,
        };
        for finding in left_out {
            in_report.add(Grade::Good, finding);
        }
        self.verdict.clone_from(in_report);
        self
    }

    /// The lens goes into the rig: into its camera, which keeps its pose, or into a new one without.
    pub(super) fn of_lens(
        rig: &Rig,
        camera: &CameraId,
        found: LensCalibration,
    ) -> Result<Self, ProcedureError> {
        Ok(Self {
            kind: ProcedureKind::Lens,
            product: Product::Rig(with_lens(rig, camera, &found)?),
            verdict: found.verdict.clone(),
            report: Report::Lens(LensReport::new(camera, found)),
        })
    }

    pub(super) fn of_rig(found: CalibratedRig) -> Self {
        Self {
            kind: ProcedureKind::Rig,
            verdict: found.report.verdict.clone(),
            report: Report::Rig(found.report),
            product: Product::Rig(found.rig),
        }
    }

    pub(super) fn of_learn(found: LearnedObject) -> Self {
        Self {
            kind: ProcedureKind::Learn,
            verdict: found.report.verdict.clone(),
            report: Report::Learn(found.report),
            product: Product::Object(found.object),
        }
    }
}

fn with_lens(rig: &Rig, camera: &CameraId, found: &LensCalibration) -> Result<Rig, ProcedureError> {
    let mut cameras = rig.cameras().to_vec();
    let pose = rig.camera(camera).and_then(|known| known.world_from_camera);
    let calibrated = Camera {
        lens_prior: Prior::Sigma(found.sigma()),
        ..Camera::new(camera.clone(), found.resolution, found.lens, pose)
    };
    match cameras.iter_mut().find(|known| known.id == *camera) {
        Some(known) => *known = calibrated,
        None => cameras.push(calibrated),
    }
    Ok(Rig::new(cameras)?.holding_on_to(rig))
}
