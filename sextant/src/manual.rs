//! `sextant manual DIR`: what a package has beside the programs, made from their command lines: `DIR/man/*.1`, and completions for three shells in
//! `DIR/bash`, `DIR/zsh` and `DIR/fish`.

use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate_to};
use node_camera::ProgramArguments;
use sextant_process::{Exit, WithExit};
use std::fs;
use std::path::{Path, PathBuf};

/// What a person may choose of `manual`.
#[derive(Args, Debug)]
pub struct ManualArguments {
    /// The folder, made when missing.
    folder: PathBuf,
}

/// Writes the files of `sextant`, whose command line is given, and of `node-camera`.
///
/// # Errors
/// A folder that cannot be written.
pub fn run(arguments: &ManualArguments, sextant: clap::Command) -> anyhow::Result<()> {
    let folder = &arguments.folder;
    let programs = [sextant, ProgramArguments::command()];
    let written = programs
        .into_iter()
        .try_for_each(|program| write(program, folder));
    written
        .with_context(|| format!("cannot write into {}", folder.display()))
        .exit_with(Exit::Input)
}

fn write(mut program: clap::Command, folder: &Path) -> std::io::Result<()> {
    let name = program.get_name().to_owned();
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        let folder = folder.join(shell.to_string());
        fs::create_dir_all(&folder)?;
        generate_to(shell, &mut program, &name, folder)?;
    }
    let pages = folder.join("man");
    fs::create_dir_all(&pages)?;
    clap_mangen::generate_to(program, pages)
}
