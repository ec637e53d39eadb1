//! Recordings through the very detector and estimator that run live.
//!
//! A replay gives one pose per object and capture time: the estimate after the last image of exactly that capture time.
//! The same recording gives the same poses, bit for bit.
//!
//! - [`replay_folder`]: images or detections of a folder, in order of arrival, with [`ReplayModels`] from files.
//! - [`Plan`], [`replay_plan`]: a site's recording in one file, as its fusion node processed it; [`LiveComparison`]
//!   with the poses that were published live.
//! - [`observation`], [`TagFinder`], [`in_order`]: recorded images as observations, by several threads, for a replay
//!   and other uses.
//!
//! Nothing here prints; a [`ReplayObserver`] follows a replay and may slow it down to the recorded pace.

mod finder;
mod ledger;
mod live;
mod models;
mod observation;
mod ordered;
mod pass;
mod plan;
mod replay;

pub use finder::{
    ChessboardSearch, NothingSought, PartialViews, TagFinder, detected_tags, image_of,
};
pub use live::LiveComparison;
pub use models::{ModelsError, ReplayModels, read_objects};
pub use observation::{ObservationError, observation};
pub use ordered::in_order;
pub use pass::ReplayObserver;
pub use plan::{Order, Plan, PlanError, Replacement, Run};
pub use replay::{CameraCounts, ReplayError, Replayed, replay_folder, replay_plan};
