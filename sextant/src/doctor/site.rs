//! Checks of the site's network from this machine: router, nodes, names, versions, cameras, tags, faults.

use crate::doctor::Finding;
use crate::doctor::nodes::NamedNode;
use crate::site::SiteArguments;
use crate::words::{self, NodeFinding};
use sextant_gateways::site::SiteSession;
use sextant_process::exit::exit_of;
use sextant_process::host::host_name;
use sextant_process::{Exit, now_ns};
use sextant_proto::{CameraStatus, FusionStatus, NodeId, NodeKind};
use sextant_site_mirror::SiteMirror;
use sextant_site_report::Severity;
use std::collections::BTreeSet;

/// All findings; `nodes` are those whose files are checked.
///
/// # Errors
/// An interruption.
pub fn findings(arguments: &SiteArguments, nodes: &[NamedNode]) -> anyhow::Result<Vec<Finding>> {
    let site = match arguments.open_any() {
        Ok(site) => site,
        Err(error) if exit_of(&error) == Exit::Unavailable => {
            let remedy = "right before the first start; else look at its address and firewall";
            return Ok(vec![Finding::warning(
                "router",
                format!("{error:#}"),
                remedy,
            )]);
        }
        Err(error) if exit_of(&error) == Exit::Input => {
            let remedy = "make keys with `sextant keys add`, or renew them";
            return Ok(vec![Finding::fault("keys", format!("{error:#}"), remedy)]);
        }
        Err(error) => return Err(error),
    };
    let keys = &site.keys;
    let mirror = site.mirror(&[keys.all_camera_statuses(), keys.all_fusion_statuses()])?;
    let view = SiteView::from_mirror(&mirror);
    let mut findings = vec![Finding::ok(
        "router",
        format!("it answers at {}", arguments.connect()),
    )];
    findings.push(view.fusion_nodes(&site)?);
    findings.extend(other_versions(&view));
    findings.extend(foreign_contracts(&view.fusion));
    findings.extend(view.cameras_without_rig());
    findings.extend(view.unknown_tags());
    findings.extend(view.reports());
    findings.extend(
        view.fusion
            .iter()
            .flat_map(|status| ahead(status, now_ns())),
    );
    for (kind, name) in nodes {
        findings.extend(taken_name(&site, *kind, name)?);
    }
    site.bus.close();
    Ok(findings)
}

/// What a site's nodes say of themselves.
struct SiteView<'a> {
    cameras: Vec<&'a CameraStatus>,
    fusion: Vec<&'a FusionStatus>,
    /// Cameras whose nodes are on the network.
    running: BTreeSet<&'a str>,
}

impl<'a> SiteView<'a> {
    fn from_mirror(mirror: &'a SiteMirror) -> Self {
        let cameras = mirror.cameras().map(|(_, camera)| &camera.status);
        let running = mirror.alive(NodeKind::Camera);
        Self {
            cameras: cameras.flatten().map(|status| &status.message).collect(),
            fusion: mirror.statuses().collect(),
            running: running.map(|(id, _)| id.as_str()).collect(),
        }
    }

    /// Reports the number of fusion nodes; without any, the sites that have one.
    fn fusion_nodes(&self, site: &SiteSession) -> anyhow::Result<Finding> {
        let n = self.fusion.len();
        if n > 0 {
            let words = words::count(n, "fusion node");
            return Ok(Finding::ok("site", words));
        }
        let name = site.keys.site();
        let sites: Vec<String> = site
            .other_sites()?
            .iter()
            .map(|site| words::plain(site))
            .collect();
        Ok(match sites.as_slice() {
            [] => Finding::warning(
                "site",
                format!("no fusion node on site {name}"),
                "start one (`sextant fusion`), or name the site with --site",
            ),
            sites => Finding::fault(
                "site",
                format!("no fusion node on site {name}, but on {}", sites.join(", ")),
                "name that site with --site, and with `site` in the file of each node",
            ),
        })
    }

    /// Running cameras that a fusion node ignores, and those of the rig that are not running.
    fn cameras_without_rig(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for status in &self.fusion {
            let cameras = status.cameras.iter();
            let cameras = cameras.map(|intake| intake.camera.as_str());
            let rig: BTreeSet<&str> = cameras.collect();
            for camera in self.running.difference(&rig) {
                let words = format!(
                    "camera {camera} runs, but the rig of {} lacks it",
                    status.node
                );
                let remedy = "add it to the rig file (`sextant config rig` shows how), or \
                    correct `camera` in camera.toml";
                findings.push(Finding::fault("rig", words, remedy));
            }
            for camera in rig.difference(&self.running) {
                let words = format!(
                    "camera {camera} of the rig of {} is not running",
                    status.node
                );
                let remedy = "start its node, and look at its power and network";
                findings.push(Finding::warning("camera", words, remedy));
            }
        }
        findings
    }

    fn unknown_tags(&self) -> impl Iterator<Item = Finding> {
        let intakes = self.fusion.iter().flat_map(|status| &status.cameras);
        intakes
            .filter(|intake| intake.unknown_tags > 0)
            .map(|intake| {
                let (camera, count) = (&intake.camera, intake.unknown_tags);
                Finding::warning(
                    "tags",
                    format!("camera {camera} sees tags of no object ({count} so far)"),
                    &format!(
                        "`sextant echo camera/{camera}/observations` shows its family and id: \
                    add it to an object file, or ignore it"
                    ),
                )
            })
    }

    /// What the nodes report themselves.
    fn reports(&self) -> impl Iterator<Item = Finding> {
        let fusion = self.fusion.iter().flat_map(|status| {
            let findings = words::findings(status).into_iter();
            findings.map(|finding| match finding.severity {
                Severity::Fault => {
                    Finding::warning("site", finding.words, "`sextant top` shows the rest")
                }
                Severity::Information => Finding::ok("site", finding.words),
            })
        });
        let cameras = self.cameras.iter().flat_map(|status| {
            let findings = words::camera_findings(status).into_iter();
            findings.map(
                |NodeFinding {
                     from,
                     severity,
                     words,
                     ..
                 }| {
                    let words = format!("{from}: {words}");
                    match severity {
                        Severity::Fault => Finding::warning("camera node", words, "see its log"),
                        Severity::Information => Finding::ok("camera node", words),
                    }
                },
            )
        });
        fusion.chain(cameras)
    }
}

fn other_versions(view: &SiteView<'_>) -> impl Iterator<Item = Finding> {
    let cameras = view.cameras.iter();
    let cameras = cameras.map(|s| (s.camera.to_string(), s.version.as_str()));
    let fusion = view.fusion.iter();
    let fusion = fusion.map(|s| (s.node.to_string(), s.version.as_str()));
    let versions = cameras.chain(fusion);
    versions.filter_map(|(who, version)| other_version(&who, version))
}

fn other_version(who: &str, version: &str) -> Option<Finding> {
    let ours = env!("CARGO_PKG_VERSION");
    (version != ours).then(|| {
        let words = format!("{who} runs {}, this is {ours}", words::plain(version));
        Finding::warning("version", words, "install one version everywhere")
    })
}

/// Cameras whose messages are of another version of the contract.
fn foreign_contracts(fusion: &[&FusionStatus]) -> impl Iterator<Item = Finding> {
    let intakes = fusion.iter().flat_map(|status| &status.cameras);
    let foreign = intakes.filter(|intake| intake.rejected.foreign_version > 0);
    foreign.map(|intake| {
        let words = format!(
            "camera {} speaks another version of the contract: {} of its messages were refused",
            intake.camera, intake.rejected.foreign_version
        );
        Finding::fault("version", words, "install one version everywhere")
    })
}

/// A node's name that another machine holds.
fn taken_name(
    site: &SiteSession,
    kind: NodeKind,
    name: &NodeId,
) -> anyhow::Result<Option<Finding>> {
    let holders = site
        .bus
        .alive_keys(&format!("{}/*/*", site.keys.holder(kind, name)))?;
    let hosts = holders.iter().filter_map(|key| key.rsplit('/').next());
    let elsewhere = hosts.map(words::plain).find(|host| *host != host_name());
    Ok(elsewhere.map(|host| {
        let kind = kind.as_str();
        Finding::fault(
            "name",
            format!(
                "a {kind} node {name} runs on {host} already, and a second one will be refused"
            ),
            "give this one another name in its file, or stop the other",
        )
    }))
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
