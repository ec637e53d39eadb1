//! `sextant completions SHELL`, and `sextant manual DIR`: what a package has beside the programs, made from their
//! command lines: `DIR/man/*.1`, and completions for three shells in `DIR/bash`, `DIR/zsh` and `DIR/fish`.

use crate::output::print_line;
use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate, generate_to};
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

/// Arguments of `sextant completions`.
#[derive(Args, Debug)]
#[command(after_help = "bash: source <(sextant completions bash), in ~/.bashrc
zsh:  sextant completions zsh > a folder of $fpath, named _sextant
fish: sextant completions fish > ~/.config/fish/completions/sextant.fish
The Debian packages install completions and manual pages; `sextant manual DIR` writes both for other systems.")]
pub struct CompletionsArguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completions of `sextant`, whose command line is given.
///
/// # Errors
/// A closed output.
pub fn completions(
    arguments: &CompletionsArguments,
    mut sextant: clap::Command,
) -> anyhow::Result<()> {
    let name = sextant.get_name().to_owned();
    let mut script = Vec::new();
    generate(arguments.shell, &mut sextant, name, &mut script);
    print_line(String::from_utf8_lossy(&script).trim_end())?;
    Ok(())
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
