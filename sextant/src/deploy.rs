//! `sextant deploy`: camera nodes on boards, over the system's ssh.

mod progress;

use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use anyhow::{anyhow, bail, ensure};
use clap::Args;
use progress::Progress;
use sextant_fleet::{
    DeployOutcome, Deployment, Desired, Health, HostJob, PackageFolder, Report, Sources, Ssh,
    Target,
};
use sextant_gateways::site::SiteSession;
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Where packages are, seen from the working folder and from that of the program.
const PACKAGES: [&str; 2] = ["target/package", "packages"];

/// Arguments of `sextant deploy`.
#[derive(Args, Debug)]
#[command(
    after_help = "For example: sextant deploy pi@north.lab pi@10.0.0.7=south --authority site-keys --connect
quic/fusion.lab:7447 --keys site-keys/ada With --json, a line a host: {\"host\",\"camera\",\"outcome\",\"from\",\"to\",
\"changes\":[],\"cause\",\"log\":[],\"notices\":[]} with outcome new, unchanged, planned (--dry-run), rolled-back (as
before again), untouched (nothing was changed), unreachable, interrupted or broken. Exit codes: 0 every host has what it
shall have; 1 a host failed; 2 wrong usage; 3 a file, a key or the packages are wrong, no host was asked; 4 a host or
the site could not be reached, all others are well; 130 interrupted, every host is as it was or new. docs/fleet.md has
the rest."
)]
pub struct DeployArguments {
    /// Hosts with a camera each. Without =CAMERA it is the first part of the host's name.
    #[arg(required = true, value_name = "[USER@]HOST[=CAMERA]")]
    targets: Vec<Target>,
    /// Folder with a camera-CAMERA.toml for each camera. Where a file is missing a minimal one is written: name, router
    /// and keys.
    #[arg(long, value_name = "DIR", default_value = ".")]
    config: PathBuf,
    /// Folder of `sextant keys`; each host gets the keys in DIR/CAMERA.
    #[arg(long, value_name = "DIR")]
    authority: Option<PathBuf>,
    /// The router as hosts reach it, for configurations that are written; by default that of --connect.
    #[arg(long, value_name = "ENDPOINT")]
    router: Option<String>,
    /// Folder of packages; by default target/package, or packages beside this program.
    #[arg(long, value_name = "DIR")]
    packages: Option<PathBuf>,
    /// Configuration of ssh in place of ~/.ssh/config.
    #[arg(long, value_name = "FILE")]
    ssh_config: Option<PathBuf>,
    /// How long the site may take to see a camera after its start, in seconds.
    #[arg(long, value_name = "S", default_value_t = 60, value_parser = clap::value_parser!(u64).range(5..=3600))]
    timeout: u64,
    /// Hosts at a time.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..=64))]
    parallel: u8,
    /// Say what would be done.
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant deploy`.
///
/// # Errors
/// Wrong files before a host is asked; afterwards whatever became of a host that is not what it shall be.
pub fn run(arguments: &DeployArguments, format: Format) -> anyhow::Result<()> {
    let (packages, desired) = read(arguments).exit_with(Exit::Input)?;
    let site = match arguments.dry_run {
        true => None,
        false => Some(arguments.site.open()?),
    };
    let shutdown = match &site {
        Some(site) => site.shutdown.clone(),
        None => Shutdown::install()?,
    };
    let reports = deploy(arguments, &packages, &desired, site.as_ref(), &shutdown)?;
    for report in &reports {
        say(report, format)?;
    }
    if let Some(site) = site {
        site.bus.close();
    }
    verdict(&reports)
}

/// What can be wrong before any host is asked.
fn read(arguments: &DeployArguments) -> anyhow::Result<(PackageFolder, Vec<Desired>)> {
    let mut cameras = BTreeSet::new();
    for target in &arguments.targets {
        ensure!(
            cameras.insert(&target.camera),
            "camera {} is named twice: name the camera of each host, HOST=CAMERA",
            target.camera
        );
    }
    let packages = PackageFolder::open(&package_folder(arguments))?;
    let site = arguments.site.site();
    let sources = Sources {
        folder: &arguments.config,
        authority: arguments.authority.as_deref(),
        site: &site,
        router: arguments
            .router
            .as_deref()
            .unwrap_or(arguments.site.connect()),
    };
    let desired = arguments
        .targets
        .iter()
        .map(|target| Desired::read(&target.camera, &sources));
    Ok((packages, desired.collect::<Result<_, _>>()?))
}

fn package_folder(arguments: &DeployArguments) -> PathBuf {
    let [here, beside] = PACKAGES;
    let program = std::env::current_exe().unwrap_or_default();
    let beside = program.parent().unwrap_or(Path::new("")).join(beside);
    match &arguments.packages {
        Some(folder) => folder.clone(),
        None if beside.is_dir() => beside,
        None => here.into(),
    }
}

fn deploy(
    arguments: &DeployArguments,
    packages: &PackageFolder,
    desired: &[Desired],
    site: Option<&SiteSession>,
    shutdown: &Shutdown,
) -> anyhow::Result<Vec<Report>> {
    let targets = &arguments.targets;
    let health = Health::new(targets.iter().map(|target| target.camera.clone()).collect());
    let progress = Progress::new(targets.iter().map(|target| target.host.clone()));
    let on_step = |host: usize, step: &str| progress.say(host, step);
    let deployment = Deployment {
        packages,
        health: site.map(|_| &health),
        timeout: Duration::from_secs(arguments.timeout),
        on_step: &on_step,
        notices_of: |status| {
            let findings = words::camera_findings(status).into_iter();
            findings.map(|finding| finding.words).collect()
        },
        shutdown,
    };
    let jobs = targets.iter().zip(desired).enumerate();
    let jobs: Vec<HostJob<'_>> = jobs
        .map(|(number, (target, desired))| HostJob {
            number,
            target,
            desired,
            ssh: Ssh {
                config: arguments.ssh_config.clone(),
                host: target.host.clone(),
            },
        })
        .collect();
    Ok(sextant_fleet::deploy(
        &deployment,
        &jobs,
        site,
        &health,
        arguments.parallel,
    )?)
}

fn say(report: &Report, format: Format) -> anyhow::Result<()> {
    match format {
        Format::Json => print_line(&serde_json::to_string(report)?)?,
        Format::Text => {
            print_line(&format!(
                "{} (camera {}): {}",
                report.host,
                report.camera,
                report.words()
            ))?;
            for line in &report.log {
                print_line(&format!("    | {line}"))?;
            }
            for notice in &report.notices {
                print_line(&format!("    note: {notice}"))?;
            }
        }
    }
    Ok(())
}

fn verdict(reports: &[Report]) -> anyhow::Result<()> {
    let with = |wanted: &[DeployOutcome]| {
        let hosts = reports
            .iter()
            .filter(|report| wanted.contains(&report.outcome));
        hosts
            .map(|report| report.host.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let failed = with(&[
        DeployOutcome::RolledBack,
        DeployOutcome::Untouched,
        DeployOutcome::Broken,
    ]);
    let unreachable = with(&[DeployOutcome::Unreachable]);
    let interrupted = with(&[DeployOutcome::Interrupted]);
    let is_interrupted = !interrupted.is_empty()
        || reports
            .iter()
            .any(|report| report.cause.as_deref() == Some("interrupted"));
    if is_interrupted {
        bail!(Failure::new(Exit::Interrupted, anyhow!("interrupted")));
    }
    if !failed.is_empty() {
        bail!("not deployed: {failed}");
    }
    if !unreachable.is_empty() {
        bail!(Failure::new(
            Exit::Unavailable,
            anyhow!("not reached: {unreachable}")
        ));
    }
    Ok(())
}
