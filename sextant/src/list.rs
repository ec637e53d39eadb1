//! `sextant list`: nodes, cameras and objects of a site.

use crate::output::{Format, print_line};
use crate::site::{Site, SiteArguments};
use crate::words;
use clap::Args;
use serde::Serialize;
use sextant_proto::{
    CameraStatus, FusionStatus, KeyRef, Message, NodeId, NodeKind, ObjectConfig, SiteId, decode,
    limits,
};
use sextant_site_model::ObjectId;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Timeout of queries for last values.
const ANSWER: Duration = Duration::from_secs(1);

/// Arguments of `sextant list`.
#[derive(Args, Debug)]
#[command(
    after_help = "With --json, one line: {\"site\",\"nodes\":[{\"kind\",\"id\"}],\"cameras\":[status],\"fusion\":[status],\"objects\":[{\"id\",\"tags\"}],
\"skew\":[{\"kind\",\"id\",\"version\",\"expected\"}]}; skew has the nodes whose version is not the fusion node's. Viewers publish no version."
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
    let inventory = Inventory::take(&site)?;
    match format {
        Format::Json => print_line(&inventory.json(&site))?,
        Format::Text => print_line(&inventory.text(&site))?,
    }
    site.bus.close();
    Ok(())
}

#[derive(Serialize)]
struct Line<'a> {
    site: &'a SiteId,
    nodes: Vec<Node<'a>>,
    cameras: &'a [CameraStatus],
    fusion: &'a [FusionStatus],
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

struct Inventory {
    nodes: BTreeSet<(NodeKind, NodeId)>,
    cameras: Vec<CameraStatus>,
    fusion: Vec<FusionStatus>,
    objects: Vec<ObjectConfig>,
}

impl Inventory {
    fn take(site: &Site) -> anyhow::Result<Self> {
        Ok(Self {
            nodes: nodes(site)?,
            cameras: latest(site, &site.keys.all_camera_statuses())?,
            fusion: latest(site, &site.keys.all_fusion_statuses())?,
            objects: latest(site, &site.keys.all_config_objects())?,
        })
    }

    fn json(&self, site: &Site) -> String {
        let nodes = self.nodes.iter();
        let objects = self.objects.iter();
        let line = Line {
            site: site.keys.site(),
            nodes: nodes
                .map(|(kind, id)| Node {
                    kind: kind.as_str(),
                    id,
                })
                .collect(),
            cameras: &self.cameras,
            fusion: &self.fusion,
            objects: objects
                .map(|object| Object {
                    id: &object.id,
                    tags: object.tags.len(),
                })
                .collect(),
            skew: skew(&self.cameras, &self.fusion),
        };
        // Numbers, names and enums: there is nothing that JSON could refuse.
        serde_json::to_string(&line).unwrap_or_default()
    }

    fn text(&self, site: &Site) -> String {
        let mut lines = vec![format!(
            "site {}: {} nodes",
            site.keys.site(),
            self.nodes.len()
        )];
        for (kind, id) in &self.nodes {
            lines.push(match kind {
                NodeKind::Camera => format!("  camera {id:<16} {}", self.camera(id)),
                NodeKind::Fusion => format!("  fusion {id:<16} {}", self.fusion(id)),
                NodeKind::Viewer => format!("  viewer {id}"),
            });
        }
        // Those that stand by have the same objects: the one that publishes an object counts.
        let publishers = self.fusion.iter().filter(|status| status.epoch.is_some());
        let healths = publishers.flat_map(|status| &status.objects);
        let mut healths: Vec<_> = healths.collect();
        healths.sort_by(|one, other| one.rate_hz.total_cmp(&other.rate_hz));
        let healths = healths.into_iter().map(|health| (&health.object, health));
        for (id, health) in healths.collect::<BTreeMap<_, _>>() {
            let tags = self.objects.iter().find(|object| object.id == *id);
            let tags = tags.map_or_else(String::new, |object| {
                words::count(object.tags.len(), "tag") + ", "
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
        } in skew(&self.cameras, &self.fusion)
        {
            let version = words::plain(version);
            let expected = words::plain(expected);
            lines.push(format!(
                "  version skew: {kind} {id} runs {version}, the fusion node {expected}: update it (`sextant deploy` updates cameras)"
            ));
        }
        lines.join("\n")
    }

    fn camera(&self, id: &NodeId) -> String {
        let status = self
            .cameras
            .iter()
            .find(|s| s.camera.as_str() == id.as_str());
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

    fn fusion(&self, id: &NodeId) -> String {
        let status = self.fusion.iter().find(|s| s.node == *id);
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
}

/// Versions are compared with that of the first fusion node.
fn skew<'a>(cameras: &'a [CameraStatus], fusion: &'a [FusionStatus]) -> Vec<Skew<'a>> {
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

fn nodes(site: &Site) -> anyhow::Result<BTreeSet<(NodeKind, NodeId)>> {
    let tokens = site.bus.alive_keys(&site.keys.all_alive())?;
    let nodes = tokens.iter().filter_map(|key| match site.keys.parse(key)? {
        KeyRef::Alive(kind, id) => Some((kind, id)),
        _ => None,
    });
    Ok(nodes.collect())
}

/// Valid last values; `echo` and the status of the fusion node show the invalid ones.
fn latest<M: Message>(site: &Site, expression: &str) -> anyhow::Result<Vec<M>> {
    let items = site
        .bus
        .latest(expression, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
    Ok(items
        .iter()
        .filter_map(|item| decode(item.bytes()?).ok())
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::CameraId;

    fn camera(id: &str, version: &str) -> CameraStatus {
        let camera = CameraId::new(id).unwrap();
        let json = serde_json::json!({
            "camera": camera, "version": version, "host": "h", "captured": 0, "detected": 0, "dropped": 0, "rate_hz": 0.0,
            "detect_ms": [0.0, 0.0], "clock": {"source": "ntp", "error_ns": 0}, "uptime_s": 0, "published": 0, "fallbacks": 0, "brightness": 0.0, "controls": sextant_proto::CameraControls::default(), "notices": [],
        });
        serde_json::from_value(json).unwrap()
    }

    fn fusion(version: &str) -> FusionStatus {
        let none = sextant_proto::Rejections::default();
        let json = serde_json::json!({
            "node": "main", "version": version, "uptime_s": 0, "cameras": [], "foreign": none, "objects": [], "faults": [],
            "faults_left_out": 0, "imperfections": [], "notices": [],
        });
        serde_json::from_value(json).unwrap()
    }

    #[test]
    fn nodes_of_another_version_than_the_fusion_node_are_named() {
        let cameras = [camera("north", "0.1.0"), camera("south", "0.0.9")];
        assert_eq!(skew(&cameras, &[]), []);
        let fusion = [fusion("0.1.0")];
        let found = skew(&cameras, &fusion);
        let south = Skew {
            kind: "camera",
            id: "south",
            version: "0.0.9",
            expected: "0.1.0",
        };
        assert_eq!(found, [south]);
    }
}
