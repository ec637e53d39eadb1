//! Many hosts at a time.

use crate::health::Health;
use crate::host::{Deployment, HostJob, Report};
use sextant_gateways::SiteSession;
use sextant_process::Shutdown;
use sextant_zenoh_bus::BusError;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Why there are no reports.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The site's session is closed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The system refuses a pipe.
    #[error(transparent)]
    System(#[from] io::Error),
    /// A bug.
    #[error("the collector of statuses panicked")]
    Panic,
}

/// Deploys to hosts, `parallel` at a time, while `health` collects what the site sees; reports in the order of the
/// jobs.
///
/// # Errors
/// See [`RunError`]. What becomes of a host is in its report.
pub fn deploy(
    deployment: &Deployment<'_>,
    jobs: &[HostJob<'_>],
    site: Option<&SiteSession>,
    health: &Health,
    parallel: u8,
) -> Result<Vec<Report>, RunError> {
    let (next, reports) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(number) else { return };
            let report = deployment.run(job);
            reports
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push((number, report));
        }
    };
    let done = Shutdown::manual()?;
    std::thread::scope(|scope| -> Result<(), RunError> {
        let collector = site.map(|site| scope.spawn(|| health.collect(site, &done)));
        let workers: Vec<_> = (0..parallel).map(|_| scope.spawn(work)).collect();
        workers.into_iter().for_each(|worker| drop(worker.join()));
        done.request();
        match collector.map(std::thread::ScopedJoinHandle::join) {
            Some(Ok(collected)) => Ok(collected?),
            Some(Err(_)) => Err(RunError::Panic),
            None => Ok(()),
        }
    })?;
    let mut reports = reports.into_inner().unwrap_or_else(PoisonError::into_inner);
    reports.sort_by_key(|(number, _)| *number);
    Ok(reports.into_iter().map(|(_, report)| report).collect())
}
