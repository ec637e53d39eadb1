//! `sextant config`: documented files to begin with, and the rig and the objects of a running site.

mod answers;
mod camera;
mod change;
mod get;
mod print;
mod refinement;

use crate::output::Format;
use crate::site::SiteArguments;
use clap::{Args, Subcommand};
pub use print::ConfigKind;
use refinement::{RevertTarget, Run};
use sextant_proto::NodeId;
use sextant_site_model::{CameraId, ObjectId};
use std::path::PathBuf;

/// Arguments of `sextant config`.
#[derive(Args, Debug)]
#[command(after_help = "For example: sextant config camera > camera.toml
             sextant config get object cube > cube.toml; edit it; sextant config set object cube.toml
             sextant config set camera north --exposure 4ms --rate 30; sextant config set camera north --exposure file
             sextant config apply-refinement --dry-run; sextant config apply-refinement; sextant config revert
With --json, one line per value: a file {\"kind\",\"toml\"}; the changes of apply-refinement and revert
{\"node\",\"held_back\":{\"n_images\",\"before_px\",\"after_px\"},\"changes\":[{\"what\",\"by\":{\"position_m\",
\"orientation_rad\"},\"ratio\":{\"of\",\"value\"}}],\"added\"}, or an answer
{\"node\",\"key\",\"outcome\",\"words\",\"refusal\"} with outcome taken (until the fusion node ends), kept (also in its
files), same (nothing changed) or refused (exit code 1); of a camera {\"camera\",
\"controls\":{\"exposure_us\":{\"wanted\",\"value\",\"range\"},\"gain\",\"rate_hz\",\"outcome\"},\"brightness\",
\"rate_hz\"} with outcome none, applied, adjusted or refused (exit code 1).")]
pub struct ConfigArguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Print a documented rig file: the cameras of a site.
    Rig,
    /// Print a documented object file: an object and its tags.
    Object,
    /// Print a documented configuration of a camera node.
    Camera,
    /// Print a documented configuration of a fusion node.
    Fusion,
    /// Print a documented configuration of a router.
    Router,
    /// Print a documented configuration of a viewer bridge.
    Viewer,
    /// Print the rig or an object of a running site as a file, or the settings of a camera.
    Get(GetArguments),
    /// Change the rig, an object or the settings of a camera of a running site.
    Set(SetArguments),
    /// Remove an object from a running site.
    Remove(RemoveArguments),
    /// Apply the refined calibration that a fusion node proposes.
    ApplyRefinement {
        /// The fusion node whose proposal it is; by default the first that has one.
        #[arg(long, value_name = "NAME")]
        node: Option<NodeId>,
        /// Show the changes without applying them.
        #[arg(long)]
        dry_run: bool,
        #[command(flatten)]
        site: SiteArguments,
    },
    /// Revert the last change of a running site; a second time reverts the reversion.
    Revert(RevertArguments),
}

/// What to get from the running site.
#[derive(Args, Debug)]
pub struct GetArguments {
    #[command(subcommand)]
    what: GetTarget,
}

#[derive(Subcommand, Debug)]
enum GetTarget {
    /// The cameras.
    Rig {
        #[command(flatten)]
        site: SiteArguments,
    },
    /// An object.
    Object {
        /// Its name.
        id: ObjectId,
        #[command(flatten)]
        site: SiteArguments,
    },
    /// Exposure, gain and rate of a camera: in force, possible and set by the site.
    Camera {
        /// Its name.
        id: CameraId,
        #[command(flatten)]
        site: SiteArguments,
    },
}

/// What to set on the running site.
#[derive(Args, Debug)]
pub struct SetArguments {
    #[command(subcommand)]
    what: SetTarget,
}

#[derive(Subcommand, Debug)]
enum SetTarget {
    /// Replace the rig by that of a file.
    Rig {
        /// The rig file.
        file: PathBuf,
        #[command(flatten)]
        site: SiteArguments,
    },
    /// Add the object of a file, or replace the one with its id.
    Object {
        /// The object file.
        file: PathBuf,
        #[command(flatten)]
        site: SiteArguments,
    },
    /// Set exposure, gain and rate of a camera, at once.
    Camera(camera::SetCamera),
}

/// What to remove from the running site.
#[derive(Args, Debug)]
pub struct RemoveArguments {
    #[command(subcommand)]
    what: RemoveTarget,
}

#[derive(Subcommand, Debug)]
enum RemoveTarget {
    /// An object.
    Object {
        /// Its name.
        id: ObjectId,
        #[command(flatten)]
        site: SiteArguments,
    },
}

/// Which change of the running site to take back.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct RevertArguments {
    #[command(subcommand)]
    what: Option<RevertScope>,
    #[command(flatten)]
    last: LastArguments,
}

/// Arguments of `sextant config revert`, by default for the rig and all objects that changed within ten seconds of the
/// last change.
#[derive(Args, Debug)]
pub struct LastArguments {
    /// To what this fusion node had, as the notice of a change that was set aside says; by default that of the node
    /// that publishes.
    #[arg(long, value_name = "NODE")]
    to: Option<NodeId>,
    /// Show the changes without applying them.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    site: SiteArguments,
}

#[derive(Subcommand, Debug)]
enum RevertScope {
    /// The last change of the rig, however long ago.
    Rig {
        #[command(flatten)]
        how: LastArguments,
    },
    /// The last change of an object, however long ago.
    Object {
        /// Its name.
        id: ObjectId,
        #[command(flatten)]
        how: LastArguments,
    },
}

impl RevertArguments {
    fn run(&self, format: Format) -> anyhow::Result<()> {
        let (what, how) = match &self.what {
            None => (RevertTarget::Last, &self.last),
            Some(RevertScope::Rig { how }) => (RevertTarget::Rig, how),
            Some(RevertScope::Object { id, how }) => (RevertTarget::Object(id.clone()), how),
        };
        refinement::revert(
            &what,
            how.to.as_ref(),
            Run::dry(how.dry_run),
            &how.site,
            format,
        )
    }
}

/// Runs `sextant config`.
///
/// # Errors
/// No router or no fusion node, a wrong file, a refused change.
pub fn run(arguments: &ConfigArguments, format: Format) -> anyhow::Result<()> {
    match &arguments.command {
        Command::Rig => print::run(ConfigKind::Rig, format),
        Command::Object => print::run(ConfigKind::Object, format),
        Command::Camera => print::run(ConfigKind::Camera, format),
        Command::Fusion => print::run(ConfigKind::Fusion, format),
        Command::Router => print::run(ConfigKind::Router, format),
        Command::Viewer => print::run(ConfigKind::Viewer, format),
        Command::Get(GetArguments { what }) => match what {
            GetTarget::Rig { site } => get::rig(site, format),
            GetTarget::Object { id, site } => get::object(id, site, format),
            GetTarget::Camera { id, site } => camera::get(id, site, format),
        },
        Command::Set(SetArguments { what }) => match what {
            SetTarget::Rig { file, site } => change::set_rig(file, site, format),
            SetTarget::Object { file, site } => change::set_object(file, site, format),
            SetTarget::Camera(arguments) => camera::set(arguments, format),
        },
        Command::Remove(RemoveArguments { what }) => match what {
            RemoveTarget::Object { id, site } => change::remove_object(id, site, format),
        },
        Command::ApplyRefinement {
            node,
            dry_run,
            site,
        } => refinement::apply(node.as_ref(), Run::dry(*dry_run), site, format),
        Command::Revert(arguments) => arguments.run(format),
    }
}
