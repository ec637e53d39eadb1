//! The demo's site on disk: a temporary folder with every file of a site, removed at the end.
//!
//! A lock on a file in a folder marks it as in use. An unlocked folder is left over from a killed demo: the next
//! demo of the same user removes it, with the shared memory that its processes left. Since anybody can create entries
//! in the temporary folder, only this user's own folders with a demo's name are removed, and no link is followed.

use crate::simulate::{models::bodies, site_files};
use anyhow::Context;
use node_camera::{CameraNodeConfig, SourceConfig};
use node_fusion::{FusionConfig, Refinement, ShardingConfig};
use node_viewer_bridge::ViewerConfig;
use sextant_estimator::FusionOptions;
use sextant_iceoryx_images::{
    IceoryxOptions, ImagesError, Leftovers, open_own_folder, remove_dead,
};
use sextant_proto::{NodeId, SiteId};
use sextant_simulator::Scenario;
use sextant_site_files::write_toml;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{BusOptions, SecurityOptions};
use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const PREFIX: &str = "sextant-demo-";
const LOCK: &str = "lock";
/// The folder of shared memory may have 40 bytes, of which the demo's name takes up to 24.
const LONGEST_PARENT: usize = 16;
/// Time in which a killed process releases its shared memory.
const ENDING: Duration = Duration::from_secs(1);

/// Addresses of the demo's parts.
pub struct Addresses<'a> {
    /// The site.
    pub site: &'a SiteId,
    /// The router's endpoint.
    pub router: &'a str,
    /// Where the page is served.
    pub page: std::net::SocketAddr,
}

/// The folder; dropping it removes it.
pub struct SiteFolder {
    root: PathBuf,
    cameras: Vec<CameraId>,
    shared_memory: IceoryxOptions,
    _lock: File,
}

impl SiteFolder {
    /// Writes every file that the nodes of this site read.
    pub fn create(scenario: &Scenario, addresses: &Addresses) -> anyhow::Result<Self> {
        let parent = parent_folder();
        remove_leftovers(&parent);
        let folder =
            Self::empty(&parent, scenario).context("the demo's temporary folder can't be made")?;
        folder.write_models(scenario)?;
        folder.write_configs(scenario, addresses)?;
        Ok(folder)
    }

    fn empty(parent: &Path, scenario: &Scenario) -> anyhow::Result<Self> {
        let root = parent.join(format!("{PREFIX}{}", std::process::id()));
        let lock = make_held(&root)?;
        fs::create_dir(root.join("logs"))?;
        let ids = |names: Vec<&String>| {
            names
                .into_iter()
                .map(|name| CameraId::new(name))
                .collect::<Result<Vec<_>, _>>()
        };
        Ok(Self {
            cameras: ids(scenario.cameras.iter().map(|camera| &camera.id).collect())?,
            shared_memory: shared_memory_of(&root),
            root,
            _lock: lock,
        })
    }

    fn write_models(&self, scenario: &Scenario) -> anyhow::Result<()> {
        site_files::write(&self.root, scenario)?;
        write_toml(&self.root.join("scenario.toml"), scenario)?;
        Ok(())
    }

    fn write_configs(&self, scenario: &Scenario, addresses: &Addresses) -> anyhow::Result<()> {
        let network = BusOptions::client_of(addresses.router);
        let fusion = FusionConfig {
            site: addresses.site.clone(),
            node: NodeId::new("fusion")?,
            rig: "rig.toml".into(),
            objects: bodies(scenario)
                .map(|body| format!("{}.toml", body.id()).into())
                .collect(),
            cameras: "cameras.toml".into(),
            keep_changes: false,
            max_age_s: FusionOptions::default().window_s,
            refinement: Refinement::default(),
            sharding: ShardingConfig::default(),
            network: network.clone(),
            security: SecurityOptions::default(),
        };
        write_toml(&self.fusion_config(), &fusion)?;
        let viewer = ViewerConfig {
            https: false,
            site: addresses.site.clone(),
            node: NodeId::new("viewer")?,
            listen: addresses.page,
            host_names: Vec::new(),
            folder: Some(".".into()),
            webhook: None,
            network: network.clone(),
            security: SecurityOptions::default(),
        };
        write_toml(&self.viewer_config(), &viewer)?;
        for camera in &self.cameras {
            let source = SourceConfig::simulator("scenario.toml");
            let config = CameraNodeConfig::new(
                addresses.site.clone(),
                camera.clone(),
                source,
                network.clone(),
                self.shared_memory.clone(),
            );
            write_toml(&self.camera_config(camera), &config)?;
        }
        Ok(())
    }

    /// The cameras of the demo's rig.
    pub fn cameras(&self) -> &[CameraId] {
        &self.cameras
    }

    /// Folder of the nodes' logs.
    pub fn logs(&self) -> PathBuf {
        self.root.join("logs")
    }

    /// The fusion node's configuration.
    pub fn fusion_config(&self) -> PathBuf {
        self.root.join("fusion.toml")
    }

    /// The viewer bridge's configuration.
    pub fn viewer_config(&self) -> PathBuf {
        self.root.join("viewer.toml")
    }

    /// A camera node's configuration.
    pub fn camera_config(&self, camera: &CameraId) -> PathBuf {
        self.root.join(format!("camera-{camera}.toml"))
    }
}

impl Drop for SiteFolder {
    fn drop(&mut self) {
        remove_site(&self.root, &self.shared_memory);
    }
}

/// The folder is locked from the moment it has its final name: otherwise another starting demo would consider it
/// abandoned.
fn make_held(root: &Path) -> io::Result<File> {
    let name = root.file_name().unwrap_or_default().to_string_lossy();
    let nascent = root.with_file_name(format!(".{name}"));
    // Left by a process with the same id that was killed.
    let _ = fs::remove_dir_all(&nascent);
    DirBuilder::new().mode(0o700).create(&nascent)?;
    let lock = File::create(nascent.join(LOCK))?;
    lock.try_lock()?;
    fs::rename(&nascent, root)?;
    Ok(lock)
}

/// The temporary folder, unless its name is too long for the sockets in it.
fn parent_folder() -> PathBuf {
    let parent = std::env::temp_dir();
    if parent.as_os_str().len() <= LONGEST_PARENT {
        parent
    } else {
        PathBuf::from("/tmp")
    }
}

/// Prefix of this demo's names in shared memory, so that several demos can run at the same time.
fn shared_memory_of(root: &Path) -> IceoryxOptions {
    let name = root.file_name().unwrap_or_default().to_string_lossy();
    let number = name.strip_prefix(PREFIX).unwrap_or("0");
    IceoryxOptions {
        root: root.join("i"),
        prefix: format!("sx{number}_"),
    }
}

/// Folders that no running demo holds.
fn remove_leftovers(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else {
        return;
    };
    for root in entries.flatten().map(|entry| entry.path()) {
        if is_a_demos(&root)
            && let Some(_lock) = take_abandoned(&root)
        {
            tracing::info!(folder = %root.display(), "removing what a killed demo left");
            remove_site(&root, &shared_memory_of(&root));
        }
    }
}

/// Whether a folder has a name made by [`SiteFolder`]: the prefix and a process id.
fn is_a_demos(root: &Path) -> bool {
    let name = root.file_name().unwrap_or_default().to_string_lossy();
    let number = name.strip_prefix(PREFIX);
    number.is_some_and(|number| {
        number
            .parse::<u32>()
            .is_ok_and(|id| id.to_string() == number)
    })
}

/// Takes the lock of this user's folder if it is free. A folder without a lock file is being removed and is
/// ignored.
fn take_abandoned(root: &Path) -> Option<File> {
    open_own_folder(root).ok()?;
    let path = root.join(LOCK);
    // Opening anything but a plain file could block for ever.
    if !fs::symlink_metadata(&path).ok()?.is_file() {
        return None;
    }
    let lock = File::open(path).ok()?;
    lock.try_lock().is_ok().then_some(lock)
}

/// Removes the folder last: without it, nobody would find the rest of the shared memory.
fn remove_site(root: &Path, shared_memory: &IceoryxOptions) {
    let cause = match remove_all_dead(shared_memory) {
        Ok(left) if left.alive + left.failed == 0 => match fs::remove_dir_all(root) {
            Ok(()) => return,
            Err(cause) if cause.kind() == io::ErrorKind::NotFound => return,
            Err(cause) => cause.to_string(),
        },
        Ok(left) => format!("its shared memory is still in use: {left:?}"),
        Err(cause) => cause.to_string(),
    };
    tracing::warn!(folder = %root.display(), %cause, "a demo's folder stays; the next demo tries again");
}

/// Waits for processes that are ending: a killed one releases its memory a little later.
fn remove_all_dead(shared_memory: &IceoryxOptions) -> Result<Leftovers, ImagesError> {
    let deadline = Instant::now() + ENDING;
    loop {
        let left = remove_dead(shared_memory)?;
        if left.alive == 0 || Instant::now() >= deadline {
            return Ok(left);
        }
        std::thread::sleep(ENDING / 50);
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::sync::atomic::{AtomicBool, Ordering};

    use sextant_iceoryx_images::ImageSubscriber;

    use super::*;

    /// A parent folder, a demo's folder in it, and its lock file.
    fn left() -> (tempfile::TempDir, PathBuf, File) {
        let parent = tempfile::tempdir_in("/tmp").unwrap();
        let root = parent.path().join(format!("{PREFIX}0"));
        fs::create_dir(&root).unwrap();
        let lock = File::create(root.join(LOCK)).unwrap();
        (parent, root, lock)
    }

    #[test]
    fn what_somebody_still_uses_waits_for_the_next_demo() {
        let (parent, root, _) = left();
        let user = ImageSubscriber::open(&shared_memory_of(&root), "north").unwrap();
        remove_leftovers(parent.path());
        assert!(root.is_dir());
        drop(user);
        remove_leftovers(parent.path());
        assert!(!root.exists());
    }

    #[test]
    fn what_no_demo_can_have_made_stays() {
        for name in ["Notes", "notes", "007", "-1", ""] {
            let (parent, root, _) = left();
            let notes = root.with_file_name(format!("{PREFIX}{name}"));
            fs::rename(&root, &notes).unwrap();
            remove_leftovers(parent.path());
            assert!(notes.is_dir(), "{name}");
        }
    }

    #[test]
    fn what_others_planted_stays() {
        let (parent, root, _) = left();
        let precious = parent.path().join("precious");
        fs::rename(&root, &precious).unwrap();
        symlink(&precious, &root).unwrap();
        remove_leftovers(parent.path());
        assert!(precious.join(LOCK).is_file() && fs::symlink_metadata(&root).is_ok());

        let (parent, root, _) = left();
        fs::set_permissions(&root, fs::Permissions::from_mode(0o777)).unwrap();
        remove_leftovers(parent.path());
        assert!(root.is_dir());
    }

    #[test]
    fn a_lock_that_is_no_file_holds_nobody_up() {
        let (parent, root, _) = left();
        let lock = root.join(LOCK);
        fs::remove_file(&lock).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(&lock).unwrap();
        remove_leftovers(parent.path());
        fs::remove_file(&lock).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&lock).status();
        assert!(made.unwrap().success());
        remove_leftovers(parent.path());
        assert!(root.is_dir());
    }

    #[test]
    fn a_demo_that_starts_is_not_taken_for_abandoned() {
        let parent = tempfile::tempdir_in("/tmp").unwrap();
        let root = parent.path().join(format!("{PREFIX}0"));
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    remove_leftovers(parent.path());
                }
            });
            let made = (0..500).all(|_| {
                let lock = make_held(&root);
                let made = lock.is_ok() && fs::create_dir(root.join("logs")).is_ok();
                fs::remove_dir_all(&root).is_ok() && made
            });
            is_over.store(true, Ordering::Relaxed);
            assert!(made);
        });
    }

    #[test]
    fn a_living_demo_keeps_its_folder() {
        let (parent, root, lock) = left();
        lock.try_lock().unwrap();
        remove_leftovers(parent.path());
        assert!(root.is_dir());
    }
}
