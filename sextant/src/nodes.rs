//! `sextant fusion|viewer`: the nodes, in this one program.

use clap::Args;
use sextant_process::{Shutdown, logging};
use std::path::PathBuf;

/// What a person may choose of a node.
#[derive(Args, Debug)]
pub struct NodeArguments {
    /// The node's configuration (`sextant config` prints one).
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

/// Runs a fusion node until a signal.
///
/// # Errors
/// As [`node_fusion::run`].
pub fn fusion(arguments: &NodeArguments) -> anyhow::Result<()> {
    logging::init("fusion");
    node_fusion::run(&arguments.config, &Shutdown::install()?)
}

/// Runs a viewer bridge until a signal.
///
/// # Errors
/// As [`node_viewer_bridge::run`].
pub fn viewer(arguments: &NodeArguments) -> anyhow::Result<()> {
    logging::init("viewer");
    node_viewer_bridge::run(&arguments.config, &Shutdown::install()?)
}
