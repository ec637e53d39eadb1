//! The record of refinements: a line a change, and the model as it was before it as a file that can be set again.
//!
//! `record.jsonl` in the folder of refinements grows by a line of JSON a change; `<unix ms>-rig.toml` or
//! `<unix ms>-<object>.toml` beside it is what `sextant config set` takes to go back. A change that cannot be recorded is not made.

use crate::models::{Change, Models};
use anyhow::Context;
use serde_json::{Value, json};
use sextant_calibrator::refinement::{Change as Found, Part};
use sextant_geometry::{Pose, PoseParts};
use sextant_site_files::{object_toml, rig_toml, write_atomically};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Where changes are recorded.
#[derive(Debug)]
pub struct Record {
    folder: PathBuf,
}

impl Record {
    /// Records in a folder, which is made when it is first needed.
    pub fn in_folder(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Writes down a change that is about to be made.
    ///
    /// # Errors
    /// What the system refuses, with the file.
    pub fn write(&self, found: &Found, models: &Models, now_ns: u64) -> anyhow::Result<PathBuf> {
        fs::create_dir_all(&self.folder)
            .with_context(|| format!("{}: cannot be made", self.folder.display()))?;
        let former = self.folder.join(name(found, now_ns));
        write_atomically(&former, former_toml(found, models)?.as_bytes())?;
        let line = line(found, &former, now_ns);
        append(&self.folder.join("record.jsonl"), &line)?;
        Ok(former)
    }
}

/// The change of the site's models that a found one asks for.
///
/// # Errors
/// For an object that is not there, and poses that no model can have.
pub fn change_of(found: &Found, models: &Models) -> anyhow::Result<Change> {
    match &found.part {
        Part::Camera(_) => Ok(Change::Rig(found.rig(&models.rig)?)),
        Part::Tag { object: id, .. } => {
            let object = models.objects.iter().find(|object| object.id() == id);
            let object = object.with_context(|| format!("object {id} is not there"))?;
            Ok(Change::Object(found.object(object)?))
        }
    }
}

fn name(found: &Found, now_ns: u64) -> String {
    let ms = now_ns / 1_000_000;
    match &found.part {
        Part::Camera(_) => format!("{ms}-rig.toml"),
        Part::Tag { object, .. } => format!("{ms}-{object}.toml"),
    }
}

fn former_toml(found: &Found, models: &Models) -> anyhow::Result<String> {
    match &found.part {
        Part::Camera(_) => Ok(rig_toml(&models.rig)),
        Part::Tag { object: id, .. } => {
            let object = models.objects.iter().find(|object| object.id() == id);
            let object = object.with_context(|| format!("object {id} is not there"))?;
            Ok(object_toml(object))
        }
    }
}

fn line(found: &Found, former: &Path, now_ns: u64) -> Value {
    let held = &found.held_back;
    json!({
        "t_ns": now_ns,
        "what": found.part.to_string(),
        "before": pose(&found.before),
        "after": pose(&found.after),
        "sigma_m": found.sigma.position_m,
        "sigma_rad": found.sigma.orientation_rad,
        "held_back": {
            "moments": held.moments, "before_px": held.before_px, "after_px": held.after_px, "gain": held.gain, "t": held.t,
        },
        "former": former.display().to_string(),
    })
}

fn pose(pose: &Pose) -> Value {
    let parts = PoseParts::from(pose);
    json!({ "position": parts.position, "orientation": parts.orientation })
}

fn append(file: &Path, line: &Value) -> anyhow::Result<()> {
    let mut open = OpenOptions::new();
    let opened = open.create(true).append(true).open(file);
    let written = opened.and_then(|mut open| {
        // One write, so that a reader sees whole lines.
        open.write_all(format!("{line}\n").as_bytes())?;
        open.sync_data()
    });
    written.with_context(|| format!("{}: cannot be written", file.display()))
}
