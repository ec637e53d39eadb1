//! Checks of the site's network from this machine: router, nodes, versions, faults.

use crate::doctor::Finding;
use crate::site::{Site, SiteArguments};
use crate::words;
use sextant_process::exit::exit_of;
use sextant_process::{Exit, now_ns};
use sextant_proto::{CameraStatus, FusionStatus, Message, limits};
use std::time::Duration;

/// Timeout of queries for last values.
const ANSWER: Duration = Duration::from_secs(1);

/// All findings.
///
/// # Errors
/// An interruption.
pub fn findings(arguments: &SiteArguments) -> anyhow::Result<Vec<Finding>> {
    let site = match arguments.open() {
        Ok(site) => site,
        Err(error) if exit_of(&error) == Exit::Unavailable => {
            let remedy = "right before the first start; else look at its address and firewall";
            return Ok(vec![Finding::warning(
                "router",
                format!("{error:#}"),
                remedy,
            )]);
        }
        Err(error) => return Err(error),
    };
    let mut findings = vec![Finding::ok("router", "it answers")];
    let cameras: Vec<CameraStatus> = latest(&site, &site.keys.all_camera_statuses())?;
    let fusion: Vec<FusionStatus> = latest(&site, &site.keys.all_fusion_statuses())?;
    findings.push(fusion_nodes(&site, &fusion));
    let said = cameras
        .iter()
        .map(|s| (s.camera.to_string(), s.version.as_str()));
    let said = said.chain(
        fusion
            .iter()
            .map(|s| (s.node.to_string(), s.version.as_str())),
    );
    findings.extend(said.filter_map(|(who, version)| other_version(&who, version)));
    findings.extend(
        fusion
            .iter()
            .flat_map(words::findings)
            .map(|finding| Finding::warning("site", finding, "`sextant top` shows the rest")),
    );
    findings.extend(cameras.iter().flat_map(|status| {
        let said = status.messages.iter();
        said.map(|m| {
            Finding::warning(
                "camera node",
                format!("{}: {}", status.camera, words::plain(m)),
                "see its log",
            )
        })
    }));
    findings.extend(fusion.iter().flat_map(|status| ahead(status, now_ns())));
    site.bus.close();
    Ok(findings)
}

fn fusion_nodes(site: &Site, fusion: &[FusionStatus]) -> Finding {
    match fusion.len() {
        0 => Finding::warning(
            "site",
            format!("no fusion node on site {}", site.keys.site()),
            "start one (`sextant fusion`), or name the site with --site",
        ),
        n => Finding::ok(
            "site",
            format!("{n} fusion node{}", if n == 1 { "" } else { "s" }),
        ),
    }
}

fn other_version(who: &str, version: &str) -> Option<Finding> {
    let ours = env!("CARGO_PKG_VERSION");
    (version != ours).then(|| {
        let words = format!("{who} runs {}, this is {ours}", words::plain(version));
        Finding::warning("version", words, "install one version everywhere")
    })
}

/// Cameras whose newest image is of the future: their clock, or this machine's, is wrong.
fn ahead(status: &FusionStatus, now_ns: u64) -> Vec<Finding> {
    let ahead = status
        .cameras
        .iter()
        .filter(|camera| camera.last_capture_ns > now_ns);
    ahead
        .map(|camera| {
            let seconds = (camera.last_capture_ns - now_ns) as f64 * 1e-9;
            let words = format!(
                "camera {} is {seconds:.3} s ahead of this machine",
                camera.camera
            );
            Finding::warning("clock", words, "let both follow one clock (chrony)")
        })
        .collect()
}

fn latest<M: Message>(site: &Site, key: &str) -> anyhow::Result<Vec<M>> {
    let items = site.bus.latest(key, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
    Ok(items.iter().filter_map(|item| item.decode().ok()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_version_is_named() {
        assert_eq!(other_version("north", env!("CARGO_PKG_VERSION")), None);
        let finding = other_version("north", "0.0.9").unwrap();
        assert!(format!("{finding:?}").contains("north runs 0.0.9"));
    }
}
