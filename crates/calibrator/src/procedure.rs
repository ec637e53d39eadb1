//! A common interface of the procedures: start with a plan, handle images, report progress, solve.
//!
//! Terminal and page display all of them in the same way: number of images, progress, the next instruction, and typed
//! details that serialise. Recorded and live images are treated alike. Frames and units are those of the sessions
//! ([`LensSession`], [`RigSession`], [`LearnSession`]).

mod lens_report;
mod outcome;
mod progress;

pub use lens_report::{HeldOut, LensReport, Uncertainty};
pub use outcome::{ProcedureOutcome, Product, Report};
pub use progress::{LearnDetails, LensDetails, Progress, ProgressDetails, RigDetails};

use crate::board_layout::{LayoutCheck, OtherLayout};
use crate::lens::{LensOptions, LensRefusal, LensSession, Selection};
use crate::verdict::listed;
use crate::{
    DiscoveryPlan, DiscoverySession, Finding, LearnError, LearnPlan, LearnSession, RigError,
    RigPlan, RigSession,
};
use serde::Serialize;
use sextant_geometry::LensModel;
use sextant_site_model::{CameraId, ImageObservation, ObjectModel, Rig};
use sextant_tag_families::Family;
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// A lens to be calibrated.
#[derive(Clone, Debug)]
pub struct LensPlan {
    /// Whose lens; only its images count. It need not be in the rig.
    pub camera: CameraId,
    /// The board of tags, as printed.
    pub board: ObjectModel,
    /// Width and height of the camera's pictures.
    pub resolution: [u32; 2],
    /// The lens model; `None` selects it by cross-validation.
    pub model: Option<LensModel>,
    /// Which images are kept: [`Selection::New`] for a stream.
    pub selection: Selection,
}

/// What is to be found.
#[derive(Clone, Debug)]
pub enum Plan {
    /// A camera's lens, with a board.
    Lens(LensPlan),
    /// Where every camera is, with an object that is carried.
    Rig(RigPlan),
    /// Where an object's tags sit.
    Learn(LearnPlan),
    /// Which tags an object has, and where they sit.
    Discover(DiscoveryPlan),
}

impl Plan {
    /// The families of the tags that it looks for.
    pub fn families(&self) -> BTreeSet<Family> {
        let of_object = |object: &ObjectModel| -> BTreeSet<Family> {
            object.tags().iter().map(|tag| tag.tag.family).collect()
        };
        match self {
            Self::Lens(plan) => of_object(&plan.board),
            Self::Rig(plan) => {
                let mut families = of_object(&plan.object);
                families.extend(plan.origin.tags().iter().map(|(tag, _)| tag.family));
                families
            }
            Self::Learn(plan) => {
                let mut families: BTreeSet<Family> =
                    plan.tags.iter().map(|(tag, _)| tag.family).collect();
                families.extend(plan.from.iter().flat_map(of_object));
                families
            }
            Self::Discover(plan) => plan.families.iter().copied().collect(),
        }
    }
}

/// What a procedure calibrates or learns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ProcedureKind {
    /// A camera's lens.
    Lens,
    /// The cameras' poses.
    Rig,
    /// An object's tags, named or discovered.
    Learn,
}

/// Why a procedure cannot begin, go on or end; each names its cause and a remedy.
#[derive(Clone, Debug, Error)]
pub enum ProcedureError {
    /// Of a lens.
    #[error(transparent)]
    Lens(#[from] LensRefusal),
    /// The images show a board of another layout.
    #[error(transparent)]
    Layout(#[from] OtherLayout),
    /// Of a rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// Of an object.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// Another one, where images were left out.
    #[error("{cause}; {}", listed(left_out))]
    LeftOut {
        /// The other one.
        cause: Box<ProcedureError>,
        /// Which images, and why.
        left_out: Vec<Finding>,
    },
    /// The new lens makes no valid rig.
    #[error("the rig with the new lens: {0}")]
    Result(#[from] sextant_site_model::RigError),
}

/// A procedure under way.
#[derive(Clone, Debug)]
pub struct Procedure {
    rig: Rig,
    session: Session,
    layout: Option<LayoutCheck>,
    other_sizes: BTreeMap<CameraId, OtherSize>,
}

/// Images of a camera that have another size.
#[derive(Clone, Copy, Debug)]
struct OtherSize {
    images: usize,
    /// Of the last one.
    size: [u32; 2],
}

#[derive(Clone, Debug)]
enum Session {
    Lens(Box<LensSession>, CameraId),
    Rig(Box<RigSession>),
    Learn(Box<LearnSession>),
    Discover(Box<DiscoverySession>),
}

impl Procedure {
    /// Starts a session without images. The rig is the site's: a found lens goes into it, a rig's cameras and lenses
    /// and those that learning sees with are taken from it. For a lens it may be empty.
    ///
    /// # Errors
    /// A plan that no images can satisfy.
    pub fn start(rig: Rig, plan: Plan) -> Result<Self, ProcedureError> {
        let layout = match &plan {
            Plan::Lens(plan) => LayoutCheck::for_board(&plan.board),
            Plan::Rig(plan) => LayoutCheck::for_board(&plan.object),
            Plan::Learn(_) | Plan::Discover(_) => None,
        };
        let session = match plan {
            Plan::Lens(plan) => {
                let options = LensOptions {
                    resolution: plan.resolution,
                    model: plan.model,
                    selection: plan.selection,
                };
                let session = LensSession::new(&plan.board, options)?;
                Session::Lens(Box::new(session), plan.camera)
            }
            Plan::Rig(plan) => Session::Rig(Box::new(RigSession::new(rig.clone(), plan)?)),
            Plan::Learn(plan) => Session::Learn(Box::new(LearnSession::new(rig.clone(), plan)?)),
            Plan::Discover(plan) => {
                Session::Discover(Box::new(DiscoverySession::new(rig.clone(), plan)?))
            }
        };
        Ok(Self {
            rig,
            session,
            layout,
            other_sizes: BTreeMap::new(),
        })
    }

    /// Which one it is.
    pub fn kind(&self) -> ProcedureKind {
        match self.session {
            Session::Lens(..) => ProcedureKind::Lens,
            Session::Rig(_) => ProcedureKind::Rig,
            Session::Learn(_) | Session::Discover(_) => ProcedureKind::Learn,
        }
    }

    /// Whether images of a camera are used.
    pub fn counts(&self, camera: &CameraId) -> bool {
        match &self.session {
            Session::Lens(_, own) => own == camera,
            Session::Rig(_) => self.rig.camera(camera).is_some(),
            Session::Learn(session) => session.counts(camera),
            Session::Discover(session) => session.counts(camera),
        }
    }

    /// Width and height of the images of a camera that counts.
    fn expected_size(&self, camera: &CameraId) -> Option<[u32; 2]> {
        match &self.session {
            Session::Lens(session, own) => (own == camera).then_some(session.resolution()),
            _ if self.counts(camera) => Some(self.rig.camera(camera)?.resolution),
            _ => None,
        }
    }

    /// Images that were left out, and why; by camera.
    pub fn left_out(&self) -> Vec<Finding> {
        let others = self.other_sizes.iter();
        let findings = others.filter_map(|(camera, other)| {
            Some(Finding::OtherSize {
                camera: camera.clone(),
                images: other.images,
                size: other.size,
                expected: self.expected_size(camera)?,
            })
        });
        findings.collect()
    }

    /// Takes an image in; one of a camera that does not count is passed over. One that says that it is of another size
    /// than the lens is for is counted and left out ([`Self::left_out`]).
    ///
    /// # Errors
    /// An image that shows the plan to be wrong, such as one with tags beyond its border. It is not taken in, others
    /// may follow.
    pub fn handle(&mut self, image: &ImageObservation) -> Result<(), ProcedureError> {
        let expected = self.expected_size(&image.camera);
        if let (Some(size), Some(expected)) = (image.resolution, expected)
            && size != expected
        {
            let other = self.other_sizes.entry(image.camera.clone());
            let other = other.or_insert(OtherSize { images: 0, size });
            (other.images, other.size) = (other.images + 1, size);
            return Ok(());
        }
        let image = &self.rig.timed(image.clone());
        if let Some(layout) = &mut self.layout {
            layout.observe(image);
        }
        match &mut self.session {
            Session::Lens(session, camera) if image.camera == *camera => {
                session.handle(image)?;
            }
            Session::Lens(..) => {}
            Session::Rig(session) => session.handle(image),
            Session::Learn(session) => session.handle(image),
            Session::Discover(session) => session.handle(image),
        }
        Ok(())
    }

    /// How far it is and what to do next. Milliseconds of work: for every look of a person, not for every image.
    pub fn progress(&self) -> Progress {
        let mut progress = self.session_progress();
        let left_out = self.left_out();
        if !left_out.is_empty() {
            progress.hint = format!("{} ({})", progress.hint, listed(&left_out));
        }
        progress
    }

    fn session_progress(&self) -> Progress {
        match &self.session {
            Session::Lens(session, _) => Progress::of_lens(&session.progress()),
            Session::Rig(session) => Progress::of_rig(session.progress()),
            Session::Learn(session) => Progress::of_learn(session.progress(), session.sketch()),
            Session::Discover(session) => {
                Progress::of_learn(session.progress(), session.sketch()).with(session.found())
            }
        }
    }

    /// The result. The procedure stays as it is: more images and another solution may follow. Seconds of work.
    ///
    /// # Errors
    /// What keeps these images from giving a result, with its cause.
    pub fn solve(&self) -> Result<ProcedureOutcome, ProcedureError> {
        let left_out = self.left_out();
        match self.solve_session() {
            Ok(outcome) => Ok(outcome.with(left_out)),
            Err(cause) if left_out.is_empty() => Err(cause),
            Err(cause) => Err(ProcedureError::LeftOut {
                cause: Box::new(cause),
                left_out,
            }),
        }
    }

    fn solve_session(&self) -> Result<ProcedureOutcome, ProcedureError> {
        if let Some(layout) = &self.layout {
            layout.check()?;
        }
        match &self.session {
            Session::Lens(session, camera) => {
                ProcedureOutcome::of_lens(&self.rig, camera, session.solve()?)
            }
            Session::Rig(session) => Ok(ProcedureOutcome::of_rig(session.solve()?)),
            Session::Learn(session) => Ok(ProcedureOutcome::of_learn(session.solve()?)),
            Session::Discover(session) => Ok(ProcedureOutcome::of_learn(session.solve()?)),
        }
    }
}

#[cfg(test)]
mod tests;
