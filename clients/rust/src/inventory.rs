//! What a site has: cameras, objects, nodes.

use crate::site::{camera_id, object_id};
use crate::{Error, Site, State};
use sextant_proto::{
    CameraConfig, CameraStatus, FusionStatus, KeyRef, NodeKind, ObjectConfig, limits,
};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, ObjectId};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// How long nodes may take to answer what they published last.
const ANSWER: Duration = Duration::from_secs(1);
/// Pause between two looks for a fusion node that still starts.
const PAUSE: Duration = Duration::from_millis(200);

/// An object of the site.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Its name.
    pub id: String,
    /// How much its pose can be trusted; none before a fusion node's first status.
    pub state: Option<State>,
    /// Poses per second over the last seconds.
    pub rate_hz: f32,
    /// Its tags, links and joints.
    pub config: ObjectConfig,
}

/// A camera of the site.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Its name.
    pub id: String,
    /// Whether its node runs.
    pub is_alive: bool,
    /// Its lens and pose in the rig; none of a camera that the rig lacks.
    pub config: Option<CameraConfig>,
    /// What its node reports; none while it does not run.
    pub status: Option<CameraStatus>,
}

/// A process of the site.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Node {
    /// What it does.
    pub kind: NodeKind,
    /// Its name.
    pub id: String,
}

impl Site {
    /// The objects, by name. Blocks for a second at most.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn objects(&self) -> Result<Vec<Object>, Error> {
        let keys = [
            self.keys.all_fusion_statuses(),
            self.keys.all_config_objects(),
        ];
        let mirror = self.mirror(&keys)?;
        let healths = mirror.healths();
        let described = mirror.configs().map(|config| {
            let health = healths.get(&config.id);
            Object {
                id: config.id.to_string(),
                state: health.map(|health| health.state),
                rate_hz: health.map_or(0.0, |health| health.rate_hz),
                config: config.clone(),
            }
        });
        Ok(described.collect())
    }

    /// The cameras of the rig and those whose node runs, by name. Blocks for a few seconds at most.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn cameras(&self) -> Result<Vec<Camera>, Error> {
        let keys = [self.keys.config_rig(), self.keys.all_camera_statuses()];
        let mirror = self.mirror(&keys)?;
        let nodes = self.nodes()?.into_iter();
        let alive = nodes.filter(|node| node.kind == NodeKind::Camera);
        let alive: BTreeSet<String> = alive.map(|node| node.id).collect();
        let rig = mirror.rig().into_iter().flat_map(|rig| &rig.cameras);
        let rig = rig.map(|camera| camera.id.to_string());
        let heard = mirror.cameras().map(|(id, _)| id.to_string());
        let ids: BTreeSet<String> = rig.chain(heard).chain(alive.iter().cloned()).collect();
        let camera = |id: String| {
            let known = CameraId::new(&id).ok();
            let config = known.as_ref().and_then(|id| mirror.camera_config(id));
            let camera = known.as_ref().and_then(|id| mirror.camera(id));
            let status = camera.and_then(|camera| camera.status.as_ref());
            Camera {
                is_alive: alive.contains(&id),
                config: config.cloned(),
                status: status.map(|status| status.message.clone()),
                id,
            }
        };
        Ok(ids.into_iter().map(camera).collect())
    }

    /// The processes that run. Blocks for a second at most.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn nodes(&self) -> Result<Vec<Node>, Error> {
        let tokens = self.bus.alive_keys(&self.keys.all_alive())?;
        let nodes = tokens.iter().filter_map(|key| match self.keys.parse(key)? {
            KeyRef::Alive(kind, id) => Some(Node {
                kind,
                id: id.to_string(),
            }),
            _ => None,
        });
        let mut nodes: Vec<Node> = nodes.collect();
        nodes.sort();
        nodes.dedup();
        Ok(nodes)
    }

    /// The newest status of each fusion node: cameras, objects, faults and notices. Blocks for a second at most.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn statuses(&self) -> Result<Vec<FusionStatus>, Error> {
        let mirror = self.mirror(&[self.keys.all_fusion_statuses()])?;
        Ok(mirror.statuses().cloned().collect())
    }

    /// The object of that name. While no fusion node runs, this waits for one: it may still start.
    pub(crate) fn known_object(&self, object: &str) -> Result<ObjectId, Error> {
        let id = object_id(object)?;
        let deadline = Instant::now() + self.timeout;
        loop {
            let known = self.mirror(&[self.keys.config_object(&id)])?;
            if known.configs().next().is_some() {
                return Ok(id);
            }
            let known = self.objects()?;
            if !known.is_empty() {
                return Err(Error::UnknownObject {
                    object: object.to_owned(),
                    site: self.name().to_owned(),
                    known: known.into_iter().map(|object| object.id).collect(),
                });
            }
            if Instant::now() >= deadline {
                return Err(self.no_objects(object));
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn no_objects(&self, object: &str) -> Error {
        let site = self.name().to_owned();
        let nodes = self.nodes().unwrap_or_default();
        if nodes.iter().any(|node| node.kind == NodeKind::Fusion) {
            return Error::UnknownObject {
                object: object.to_owned(),
                site,
                known: Vec::new(),
            };
        }
        Error::NoFusion {
            others: self.other_sites(),
            site,
        }
    }

    /// The camera of that name.
    pub(crate) fn known_camera(&self, camera: &str) -> Result<CameraId, Error> {
        let id = camera_id(camera)?;
        let cameras = self.cameras()?;
        if cameras.iter().any(|known| known.id == camera) {
            return Ok(id);
        }
        Err(Error::UnknownCamera {
            camera: camera.to_owned(),
            site: self.name().to_owned(),
            known: cameras.into_iter().map(|camera| camera.id).collect(),
        })
    }

    /// Sites of the same router that have nodes, this one under another version of the contract included. A protected
    /// router names none.
    fn other_sites(&self) -> Vec<String> {
        let tokens = self.bus.alive_keys("sextant/*/*/alive/*/*");
        let tokens = tokens.unwrap_or_default();
        let mut sites: Vec<String> = tokens.iter().filter_map(|key| site_of(key)).collect();
        sites.sort();
        sites.dedup();
        sites
    }

    /// The site as its nodes answer: their last messages under these keys. Those that break the contract are left out.
    fn mirror(&self, keys: &[String]) -> Result<SiteMirror, Error> {
        let mut mirror = SiteMirror::default();
        for key in keys {
            let items = self.bus.latest(key, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
            for item in &items {
                if let Some(key) = self.keys.parse(&item.key) {
                    let _ = mirror.handle(0, &key, item.sender.as_deref(), item.try_bytes());
                }
            }
        }
        Ok(mirror)
    }
}

/// `demo` of `sextant/v1/demo/...`, `demo (v2)` of another version.
fn site_of(key: &str) -> Option<String> {
    let mut chunks = key.split('/').skip(1);
    let (version, site) = (chunks.next()?, chunks.next()?);
    let own = format!("v{}", sextant_proto::VERSION);
    Some(if version == own {
        site.to_owned()
    } else {
        format!("{site} ({version})")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_site_of_another_version_says_so() {
        let found = [
            "sextant/v1/demo/alive/fusion/f",
            "sextant/v2/hall/alive/fusion/f",
            "x",
        ];
        assert_eq!(
            found.map(site_of),
            [Some("demo".into()), Some("hall (v2)".into()), None]
        );
    }
}
