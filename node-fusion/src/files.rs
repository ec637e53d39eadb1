//! The files that the models came from, and those that accepted changes go to.
//!
//! A file is replaced atomically, and only by another version of what is in it; former versions stay beside it as
//! `<name>.former`, `<name>.former.2` and so on. A new object gets the file `objects/<object>.toml` beside
//! `fusion.toml`, whose list of objects follows; everything else in `fusion.toml` stays as it is. `fusion.toml.version`
//! says which version of the models the files hold: files that were edited since are of no version. While a change is
//! written, `fusion.toml.change` holds all of it: see [`crate::journal`].

use crate::camera_settings;
use crate::config::FusionConfig;
use crate::formers::{Former, Formers};
use crate::journal::{Journal, RecordText};
use crate::models::{Change, ModelsInForce};
use crate::replica::{KeepJob, ModelsRecord};
use sextant_process::{Exit, WithExit};
use sextant_proto::limits;
use sextant_site_files::{
    FileError, assumptions, former_of, keep_object, keep_rig, object_file, read_object, read_rig,
    read_text, read_toml, retire_object, with_value, write_keeping_former, write_toml,
};
use sextant_site_model::ObjectId;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Where the models are kept.
#[derive(Debug)]
pub struct ModelFiles {
    config: PathBuf,
    journal: Journal,
    folder: PathBuf,
    rig: PathBuf,
    settings: PathBuf,
    /// As `fusion.toml` names them, with what is in them.
    objects: Vec<(PathBuf, ObjectId)>,
    /// Where objects were that may come back.
    removed: Vec<(PathBuf, ObjectId)>,
    /// A change that was interrupted and cannot be completed now: it is in force all the same.
    interrupted: Option<KeepJob>,
}

impl ModelFiles {
    /// Reads the models that a configuration names, and completes a change that was interrupted.
    ///
    /// # Errors
    /// [`Exit::Input`] for a file that is missing or wrong.
    pub fn read(
        config_file: &Path,
        config: &FusionConfig,
    ) -> anyhow::Result<(Self, ModelsInForce)> {
        let folder = config_file.parent().unwrap_or(Path::new(".")).to_owned();
        let files = config.objects.iter().chain([&config.rig]);
        for file in files.map(|file| folder.join(file)) {
            for assumed in assumptions(&file).exit_with(Exit::Input)? {
                tracing::warn!("{}: {assumed}", file.display());
            }
        }
        let rig = read_rig(&folder.join(&config.rig)).exit_with(Exit::Input)?;
        let (mut files, mut objects) = (Vec::new(), Vec::new());
        for file in &config.objects {
            let object = read_object(&folder.join(file)).exit_with(Exit::Input)?;
            files.push((file.clone(), object.id().clone()));
            objects.push(object);
        }
        let mut files = Self {
            config: config_file.to_owned(),
            journal: Journal::new(config_file),
            folder,
            rig: config.rig.clone(),
            settings: config.cameras.clone(),
            objects: files,
            removed: Vec::new(),
            interrupted: None,
        };
        let settings = camera_settings::read(&files.folder.join(&files.settings));
        let settings = settings.exit_with(Exit::Input)?;
        let models = ModelsInForce {
            rig,
            objects,
            settings,
        };
        let models = files.complete_interrupted(models)?;
        Ok((files, models))
    }

    /// The models after a change that was interrupted, which is completed.
    fn complete_interrupted(&mut self, models: ModelsInForce) -> anyhow::Result<ModelsInForce> {
        let Some(job) = self.journal.interrupted().exit_with(Exit::Input)? else {
            return Ok(models);
        };
        let after = models.changed(&job.changes).exit_with(Exit::Input)?;
        let version = job.record.state.version.as_ref();
        let (counter, author) = (
            version.map(|version| version.counter),
            version.map(|version| version.author.as_str()),
        );
        match self.write(&job).and_then(|()| self.journal.end()) {
            Ok(()) => tracing::warn!(
                counter,
                author,
                "this node was ended in the middle of a change of its files: the change is completed"
            ),
            Err(cause) => {
                tracing::error!(
                    counter,
                    author,
                    "this node was ended in the middle of a change of its files: the change is in force, and not in \
                     all files yet: {cause:#}"
                );
                self.interrupted = Some(job);
            }
        }
        Ok(after.unwrap_or(models))
    }

    /// The former versions beside the files, as of the time when these replaced them. What cannot be read is left out.
    pub fn formers(&self) -> Formers {
        let rig = former(&self.folder.join(&self.rig), read_rig);
        let objects = self.objects.iter().filter_map(|(file, id)| {
            let former = former(&self.folder.join(file), read_object)?;
            (former.model.id() == id).then(|| (id.clone(), former))
        });
        Formers {
            rig,
            objects: objects.collect(),
        }
    }

    /// The version of the models that was written last; none where none was, or it cannot be read.
    pub fn record(&self) -> Option<ModelsRecord> {
        if let Some(job) = &self.interrupted {
            return Some(job.record.clone());
        }
        let file = self.record_file();
        if !file.exists() {
            return None;
        }
        let record: RecordText = read_toml(&file)
            .inspect_err(|cause| tracing::warn!("the files count as edited: {cause:#}"))
            .ok()?;
        Some(record.into())
    }

    /// What is in force and not in the files.
    pub fn unwritten(&self) -> Vec<Change> {
        let interrupted = self.interrupted.as_ref();
        interrupted.map_or(Vec::new(), |job| job.changes.clone())
    }

    fn record_file(&self) -> PathBuf {
        let mut name = self.config.as_os_str().to_owned();
        name.push(".version");
        name.into()
    }

    /// Writes changes to the files, all or none, and then the version of the models that the files hold. A process that
    /// ends meanwhile leaves a journal behind, by which the next one completes them; and so does a job without
    /// [`KeepJob::undo`] that fails, whose changes are in force.
    ///
    /// # Errors
    /// What the system refuses, and a file in the way that is something else.
    pub fn keep_all(&mut self, job: &KeepJob) -> Result<(), FileError> {
        if job.changes.is_empty() {
            return self.keep_record(&job.record);
        }
        self.journal.begin(job)?;
        let kept = self.write(job);
        if kept.is_err() {
            for change in &job.undo {
                if let Err(cause) = self.keep(change) {
                    tracing::error!("what was written before cannot be taken back: {cause:#}");
                }
            }
            if job.undo.is_empty() {
                return kept;
            }
        }
        let ended = self.journal.end();
        kept.and(ended)
    }

    fn write(&mut self, job: &KeepJob) -> Result<(), FileError> {
        job.changes
            .iter()
            .try_for_each(|change| self.keep(change))?;
        self.keep_record(&job.record)
    }

    fn keep_record(&self, record: &ModelsRecord) -> Result<(), FileError> {
        if record.state.version.is_none() && record.newer.is_none() {
            return Ok(());
        }
        write_toml(&self.record_file(), &RecordText::from(record))
    }

    /// Writes a change to the files.
    fn keep(&mut self, change: &Change) -> Result<(), FileError> {
        match change {
            Change::Rig(rig) => keep_rig(&self.folder.join(&self.rig), rig),
            Change::Object(model) => {
                let known = self.objects.iter().find(|(_, id)| id == model.id());
                let former = self.removed.iter().find(|(_, id)| id == model.id());
                let name = known.or(former).map(|(name, _)| name.clone());
                let name = name.unwrap_or_else(|| object_file(model.id()));
                let is_new = known.is_none();
                keep_object(&self.folder.join(&name), model)?;
                if is_new {
                    let mut objects = self.objects.clone();
                    objects.push((name, model.id().clone()));
                    self.list(objects)?;
                }
                Ok(())
            }
            Change::Camera(settings) => {
                camera_settings::keep(&self.folder.join(&self.settings), settings)
            }
            Change::Removal(id) => {
                let (gone, left) = self.objects.iter().cloned().partition(|(_, of)| of == id);
                self.list(left)?;
                let gone: Vec<(PathBuf, ObjectId)> = gone;
                gone.iter()
                    .try_for_each(|(name, id)| retire_object(&self.folder.join(name), id))?;
                self.removed.retain(|(_, known)| known != id);
                self.removed.extend(gone);
                self.removed.truncate(limits::MAX_OBJECTS);
                Ok(())
            }
        }
    }

    /// Writes the list of objects into `fusion.toml`.
    fn list(&mut self, objects: Vec<(PathBuf, ObjectId)>) -> Result<(), FileError> {
        let names = objects.iter().map(|(name, _)| quoted(name));
        let list = format!("[{}]", names.collect::<Vec<_>>().join(", "));
        let text = with_value(&self.config, &read_text(&self.config)?, "objects", &list)?;
        write_keeping_former(&self.config, text.as_bytes())?;
        self.objects = objects;
        Ok(())
    }
}

fn former<M>(file: &Path, read: impl Fn(&Path) -> Result<M, FileError>) -> Option<Former<M>> {
    let former = former_of(file);
    if !former.exists() {
        return None;
    }
    let modified = std::fs::metadata(file).and_then(|data| data.modified());
    let since = modified.ok()?.duration_since(UNIX_EPOCH).ok()?;
    match read(&former) {
        Ok(model) => Some(Former {
            model,
            changed_ns: u64::try_from(since.as_nanos()).ok()?,
        }),
        Err(cause) => {
            tracing::warn!("`sextant config revert` cannot take it back: {cause:#}");
            None
        }
    }
}

/// A path as a TOML string: of the two forms the one without escapes where it can be.
fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    if text.contains(['\'', '\n']) {
        format!("{text:?}")
    } else if text.contains(['"', '\\']) {
        format!("'{text}'")
    } else {
        format!("\"{text}\"")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Payloads;
    use sextant_proto::{ModelsState, ModelsVersion, NodeId};
    use sextant_site_files::{parse_object, parse_rig};
    use std::fs;

    const RIG: &str = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\n\
        lens = { model = \"pinhole\", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5 }\n";

    fn object_text(id: &str, tag: u32) -> String {
        format!("# mine\nid = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n")
    }

    fn change(id: &str, tag: u32) -> Change {
        Change::Object(parse_object(Path::new("o"), &object_text(id, tag)).unwrap())
    }

    struct SiteFolder(tempfile::TempDir);

    impl SiteFolder {
        fn new() -> Self {
            let site = Self(tempfile::tempdir().unwrap());
            let text = "# the lab\nsite = \"lab\"\nrig = \"rig.toml\"\n\
                objects = [\"things/cube.toml\"]\nkeep_changes = true\n";
            fs::create_dir(site.path("things")).unwrap();
            for (name, text) in [
                ("rig.toml", RIG),
                ("things/cube.toml", &object_text("cube", 1)),
                ("fusion.toml", text),
            ] {
                fs::write(site.path(name), text).unwrap();
            }
            site
        }

        fn path(&self, name: &str) -> PathBuf {
            self.0.path().join(name)
        }

        fn read(&self) -> (ModelFiles, ModelsInForce) {
            let file = self.path("fusion.toml");
            let config: FusionConfig = read_toml(&file).unwrap();
            ModelFiles::read(&file, &config).unwrap()
        }

        /// The models after a restart, and those that a change made.
        fn kept(&self, change: &Change) -> (ModelsInForce, ModelsInForce) {
            let (mut files, models) = self.read();
            let changed = models
                .changed(std::slice::from_ref(change))
                .unwrap()
                .unwrap();
            files.keep(change).unwrap();
            (self.read().1, changed)
        }
    }

    #[test]
    fn what_is_kept_is_there_after_a_restart() {
        let site = SiteFolder::new();
        let two = RIG.to_owned() + &RIG.replace("north", "south");
        let rig = Change::Rig(parse_rig(Path::new("r"), &two).unwrap());
        let removal = Change::Removal(ObjectId::new("cube").unwrap());
        let north = sextant_proto::CameraSettings {
            gain: Some(2.0),
            ..sextant_proto::CameraSettings::none("north".parse().unwrap())
        };
        let camera = Change::Camera(north);
        for change in [rig, change("cube", 7), change("ball", 8), removal, camera] {
            let (after_restart, made) = site.kept(&change);
            assert_eq!(after_restart, made, "{change:?}");
        }
        let text = fs::read_to_string(site.path("fusion.toml")).unwrap();
        assert!(text.starts_with("# the lab\n"), "{text}");
    }

    #[test]
    fn files_are_of_a_version_until_they_are_edited() {
        let site = SiteFolder::new();
        let (mut files, models) = site.read();
        assert_eq!(files.record(), None);
        let change = change("cube", 7);
        let after = models
            .changed(std::slice::from_ref(&change))
            .unwrap()
            .unwrap();
        let record = ModelsRecord {
            state: ModelsState {
                version: Some(ModelsVersion {
                    counter: 3,
                    t_ns: 1_800_000_000_000_000_000,
                    author: NodeId::new("spare").unwrap(),
                }),
                fingerprint: Payloads::encode(&after).fingerprint(),
            },
            newer: None,
        };
        let job = |changes: Vec<Change>| KeepJob {
            undo: after.changes_to(&models),
            record: record.clone(),
            changes,
        };
        files.keep_all(&job(vec![change.clone()])).unwrap();
        let (files, read) = site.read();
        assert_eq!(files.record(), Some(record.clone()));
        assert_eq!(
            Payloads::encode(&read).fingerprint(),
            record.state.fingerprint
        );
        fs::write(site.path("rig.toml"), RIG.replace("600.0", "601.0")).unwrap();
        let (mut files, edited) = site.read();
        assert_ne!(
            Payloads::encode(&edited).fingerprint(),
            record.state.fingerprint
        );

        // One of two files cannot be written: neither is changed.
        fs::write(site.path("fusion.toml.version"), "counter = 3\n").unwrap();
        assert_eq!(files.record(), None);
        fs::create_dir(site.path("cameras.toml")).unwrap();
        let north = sextant_proto::CameraSettings::none("north".parse().unwrap());
        let settings = sextant_proto::CameraSettings {
            gain: Some(2.0),
            ..north
        };
        let before = fs::read_to_string(site.path("things/cube.toml")).unwrap();
        let removed =
            Change::Object(parse_object(Path::new("o"), &object_text("cube", 9)).unwrap());
        let failing = KeepJob {
            changes: vec![removed, Change::Camera(settings)],
            undo: vec![change],
            record,
        };
        files.keep_all(&failing).unwrap_err();
        let cube = || fs::read_to_string(site.path("things/cube.toml")).unwrap();
        assert_eq!(cube(), before);
        assert_eq!(files.record(), None);

        // Nor where the record cannot be written.
        fs::remove_file(site.path("fusion.toml.version")).unwrap();
        fs::create_dir(site.path("fusion.toml.version")).unwrap();
        let failing = KeepJob {
            changes: failing.changes[..1].to_vec(),
            ..failing
        };
        files.keep_all(&failing).unwrap_err();
        assert_eq!(cube(), before);

        // A removed object comes back where it was.
        fs::remove_dir(site.path("fusion.toml.version")).unwrap();
        let removal = Change::Removal(ObjectId::new("cube").unwrap());
        for change in [removal, failing.undo[0].clone()] {
            files.keep(&change).unwrap();
        }
        assert_eq!(cube(), before);
    }

    /// A process may end before any of the steps of a change: the next one has all of it or nothing.
    #[test]
    fn an_interrupted_change_is_completed_at_the_next_start() {
        let two = RIG.to_owned() + &RIG.replace("north", "south");
        let rig = Change::Rig(parse_rig(Path::new("r"), &two).unwrap());
        let removal = Change::Removal(ObjectId::new("cube").unwrap());
        let north = sextant_proto::CameraSettings {
            rate_hz: Some(29.97),
            ..sextant_proto::CameraSettings::none("north".parse().unwrap())
        };
        let changes = vec![
            removal,
            rig,
            change("ball", 1),
            change("fusion", 7),
            Change::Camera(north),
        ];
        for n_written in 0..=changes.len() {
            let site = SiteFolder::new();
            let (mut files, models) = site.read();
            let after = models.changed(&changes).unwrap().unwrap();
            let job = KeepJob {
                changes: changes.clone(),
                undo: after.changes_to(&models),
                record: ModelsRecord {
                    state: ModelsState {
                        version: Some(ModelsVersion {
                            counter: 3,
                            t_ns: 1,
                            author: NodeId::new("main").unwrap(),
                        }),
                        fingerprint: Payloads::encode(&after).fingerprint(),
                    },
                    newer: None,
                },
            };
            files.journal.begin(&job).unwrap();
            for change in &changes[..n_written] {
                files.keep(change).unwrap();
            }
            for _ in 0..2 {
                let (files, models) = site.read();
                assert_eq!(models, after, "after {n_written}");
                assert_eq!(files.record(), Some(job.record.clone()));
                assert!(!site.path("fusion.toml.change").exists());
            }
        }
        let site = SiteFolder::new();
        fs::write(site.path("fusion.toml.change"), "half").unwrap();
        let config: FusionConfig = read_toml(&site.path("fusion.toml")).unwrap();
        let refused = ModelFiles::read(&site.path("fusion.toml"), &config).unwrap_err();
        assert!(
            format!("{refused:#}").contains("remove this file"),
            "{refused:#}"
        );
    }

    #[test]
    fn the_former_files_are_kept() {
        let site = SiteFolder::new();
        site.kept(&change("cube", 7));
        let former = fs::read_to_string(site.path("things/cube.toml.former")).unwrap();
        assert_eq!(former, object_text("cube", 1));
        site.kept(&Change::Removal(ObjectId::new("cube").unwrap()));
        assert!(!site.path("things/cube.toml").exists());
        let former = fs::read_to_string(site.path("things/cube.toml.former")).unwrap();
        assert!(former.contains("id = 7"), "{former}");
    }

    /// Objects are named freely over the network, also like the node's own files.
    #[test]
    fn an_object_of_any_name_leaves_all_other_files_alone() {
        let site = SiteFolder::new();
        let mut mine = Vec::new();
        for name in ["viewer.toml", "camera.toml", "rig.toml"] {
            if name != "rig.toml" {
                fs::write(site.path(name), "site = \"lab\"\n").unwrap();
            }
            mine.push((name, fs::read_to_string(site.path(name)).unwrap()));
        }
        for (tag, name) in (10..).zip(["fusion", "viewer", "rig", "camera"]) {
            let object = change(name, tag);
            let (after_restart, made) = site.kept(&object);
            assert_eq!(after_restart, made, "{name}");
            let (after_restart, made) = site.kept(&change(name, tag + 100));
            assert_eq!(after_restart, made, "{name}");
            assert!(site.path(&format!("objects/{name}.toml")).exists());
        }
        for (name, text) in mine {
            assert_eq!(fs::read_to_string(site.path(name)).unwrap(), text, "{name}");
        }
        let text = fs::read_to_string(site.path("fusion.toml")).unwrap();
        assert!(text.starts_with("# the lab\nsite = \"lab\"\n"), "{text}");
    }

    #[test]
    fn a_file_that_is_no_object_is_not_replaced() {
        let site = SiteFolder::new();
        let (mut files, _) = site.read();
        fs::create_dir(site.path("objects")).unwrap();
        for name in ["objects/ball.toml", "things/cube.toml"] {
            fs::write(site.path(name), "mine\n").unwrap();
        }
        for id in ["ball", "cube"] {
            let refusal = files.keep(&change(id, 7)).unwrap_err();
            assert!(
                refusal.to_string().contains("is left as it is"),
                "{refusal}"
            );
        }
        for name in ["objects/ball.toml", "things/cube.toml"] {
            assert_eq!(fs::read_to_string(site.path(name)).unwrap(), "mine\n");
        }
    }

    #[test]
    fn an_unwritable_file_is_a_refusal() {
        let site = SiteFolder::new();
        let (mut files, _) = site.read();
        fs::remove_dir_all(site.path("things")).unwrap();
        fs::write(site.path("things"), "a file").unwrap();
        assert!(files.keep(&change("cube", 7)).is_err());
    }

    #[test]
    fn paths_are_quoted_so_that_they_are_read_back() {
        for path in [
            "a.toml",
            "it's.toml",
            "say \"x\".toml",
            "back\\slash",
            "tab\t.toml",
        ] {
            let text = format!("p = {}", quoted(Path::new(path)));
            let table: toml_text::Table = toml_text::read(&text);
            assert_eq!(table.p, path);
        }
    }

    mod toml_text {
        #[derive(serde::Deserialize)]
        pub struct Table {
            pub p: String,
        }

        pub fn read(text: &str) -> Table {
            sextant_site_files::parse_toml(std::path::Path::new("t"), text, |_| Ok(())).unwrap()
        }
    }
}
