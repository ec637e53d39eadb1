//! `sextant list`: nodes, cameras and objects of a site.

use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use clap::Args;
use serde::Serialize;
use sextant_proto::{CameraStatus, FusionStatus, NodeId, NodeKind, SiteId};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::ObjectId;

/// Arguments of `sextant list`.
#[derive(Args, Debug)]
#[command(
    after_help = "With --json, one line: {\"site\",\"nodes\":[{\"kind\",\"id\"}],\"cameras\":[status],
\"fusion\":[status],\"objects\":[{\"id\",\"tags\"}],\"skew\":[{\"kind\",\"id\",\"version\",\"expected\"}]}; skew has the
nodes whose version is not the fusion node's. Viewers publish no version."
)]
pub struct ListArguments {
    #[command(flatten)]
    site: SiteArguments,
}

/// Runs `sextant list`.
///
/// # Errors
/// No router.
pub fn run(arguments: &ListArguments, format: Format) -> anyhow::Result<()> {
    let site = arguments.site.open()?;
    let keys = &site.keys;
    let mirror = site.mirror(&[
        keys.all_camera_statuses(),
        keys.all_fusion_statuses(),
        keys.all_config_objects(),
    ])?;
    let listing = Listing {
        site: keys.site(),
        mirror: &mirror,
    };
    match format {
        Format::Json => print_line(&listing.json())?,
        Format::Text => print_line(&listing.text())?,
    }
    site.bus.close();
    Ok(())
}

#[derive(Serialize)]
struct Line<'a> {
    site: &'a SiteId,
    nodes: Vec<Node<'a>>,
    cameras: Vec<&'a CameraStatus>,
    fusion: Vec<&'a FusionStatus>,
    objects: Vec<Object<'a>>,
    skew: Vec<Skew<'a>>,
}

#[derive(Serialize)]
struct Node<'a> {
    kind: &'static str,
    id: &'a NodeId,
}

#[derive(Serialize)]
struct Object<'a> {
    id: &'a ObjectId,
    tags: usize,
}

/// A node of another version than the fusion node.
#[derive(Debug, PartialEq, Serialize)]
struct Skew<'a> {
    kind: &'static str,
    id: &'a str,
    version: &'a str,
    expected: &'a str,
}

struct Listing<'a> {
    site: &'a SiteId,
    mirror: &'a SiteMirror,
}

impl Listing<'_> {
    fn json(&self) -> String {
        let nodes = self.mirror.nodes();
        let (cameras, fusion) = (self.cameras(), self.fusion());
        let objects = self.mirror.configs();
        let line = Line {
            site: self.site,
            nodes: nodes
                .map(|(kind, id, _)| Node {
                    kind: kind.as_str(),
                    id,
                })
                .collect(),
            skew: skew(&cameras, &fusion),
            cameras,
            fusion,
            objects: objects
                .map(|object| Object {
                    id: &object.id,
                    tags: object.tags.len(),
                })
                .collect(),
        };
        // Numbers, names and enums: there is nothing that JSON could refuse.
        serde_json::to_string(&line).unwrap_or_default()
    }

    fn cameras(&self) -> Vec<&CameraStatus> {
        let statuses = self.mirror.cameras().map(|(_, camera)| &camera.status);
        statuses.flatten().map(|status| &status.message).collect()
    }

    fn fusion(&self) -> Vec<&FusionStatus> {
        self.mirror.statuses().collect()
    }

    fn text(&self) -> String {
        let (cameras, fusion) = (self.cameras(), self.fusion());
        let n_nodes = self.mirror.nodes().count();
        let mut lines = vec![format!("site {}: {n_nodes} nodes", self.site)];
        for (kind, id, _) in self.mirror.nodes() {
            lines.push(match kind {
                NodeKind::Camera => format!("  camera {id:<16} {}", camera_words(&cameras, id)),
                NodeKind::Fusion => format!("  fusion {id:<16} {}", fusion_words(&fusion, id)),
                NodeKind::Viewer => format!("  viewer {id}"),
            });
        }
        for (id, health) in self.mirror.healths() {
            let object = self.mirror.object(id);
            let config = object.and_then(|object| object.config.as_ref());
            let tags = config.map_or_else(String::new, |config| {
                words::count(config.tags.len(), "tag") + ", "
            });
            let state = words::state(health.state);
            let rate_hz = health.rate_hz;
            lines.push(format!(
                "  object {id:<16} {tags}{state}, {rate_hz:.1} poses/s"
            ));
        }
        for Skew {
            kind,
            id,
            version,
            expected,
        } in skew(&cameras, &fusion)
        {
            let version = words::plain(version);
            let expected = words::plain(expected);
            lines.push(format!(
                "  version skew: {kind} {id} runs {version}, the fusion node {expected}: update \
                 it (`sextant deploy` updates cameras)"
            ));
        }
        lines.join("\n")
    }
}

fn camera_words(cameras: &[&CameraStatus], id: &NodeId) -> String {
    let status = cameras.iter().find(|s| s.camera.as_str() == id.as_str());
    status.map_or_else(
        || "no status yet".into(),
        |status| {
            format!(
                "{} on {}, {:.1} images/s, {} dropped",
                words::plain(&status.version),
                words::plain(&status.host),
                status.rate_hz,
                status.dropped
            )
        },
    )
}

fn fusion_words(fusion: &[&FusionStatus], id: &NodeId) -> String {
    let status = fusion.iter().find(|s| s.node == *id);
    status.map_or_else(
        || "no status yet".into(),
        |status| {
            let duty = status.epoch.map_or(", stands by", |_| "");
            format!(
                "{}, {} cameras, {} objects{duty}",
                words::plain(&status.version),
                status.cameras.len(),
                status.objects.len()
            )
        },
    )
}

/// Versions are compared with that of the first fusion node.
fn skew<'a>(cameras: &[&'a CameraStatus], fusion: &[&'a FusionStatus]) -> Vec<Skew<'a>> {
    let Some(expected) = fusion.first().map(|status| status.version.as_str()) else {
        return Vec::new();
    };
    let cameras = cameras
        .iter()
        .map(|status| ("camera", status.camera.as_str(), &status.version));
    let fusion = fusion
        .iter()
        .map(|status| ("fusion", status.node.as_str(), &status.version));
    let others = cameras
        .chain(fusion)
        .filter(|(_, _, version)| *version != expected);
    let skew = |(kind, id, version): (_, _, &'a String)| Skew {
        kind,
        id,
        version,
        expected,
    };
    others.map(skew).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::CameraId;

    fn camera(id: &str, version: &str) -> CameraStatus {
        let camera = CameraId::new(id).unwrap();
        let json = serde_json::json!({
            "camera": camera, "version": version, "host": "h", "captured": 0,
            "detected": 0, "dropped": 0, "rate_hz": 0.0,
            "detect_ms": [0.0, 0.0], "clock": {"source": "ntp", "error_ns": 0}, "uptime_s": 0,
            "published": 0, "fallbacks": 0, "brightness": 0.0,
            "controls": sextant_proto::CameraControls::default(), "notices": [],
        });
        serde_json::from_value(json).unwrap()
    }

    fn fusion(version: &str) -> FusionStatus {
        let none = sextant_proto::Rejections::default();
        let json = serde_json::json!({
            "node": "main", "version": version, "uptime_s": 0,
            "cameras": [], "foreign": none, "objects": [], "faults": [],
            "faults_left_out": 0, "imperfections": [], "notices": [],
        });
        serde_json::from_value(json).unwrap()
    }

    #[test]
    fn nodes_of_another_version_than_the_fusion_node_are_named() {
        let cameras = [camera("north", "0.1.0"), camera("south", "0.0.9")];
        assert_eq!(skew(&cameras.each_ref(), &[]), []);
        let fusion = [fusion("0.1.0")];
        let found = skew(&cameras.each_ref(), &fusion.each_ref());
        let south = Skew {
            kind: "camera",
            id: "south",
            version: "0.0.9",
            expected: "0.1.0",
        };
        assert_eq!(found, [south]);
    }
}
