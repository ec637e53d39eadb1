//! The record of refinements: a line a change, and the model as it was before it as a file that can be set again.
//!
//! `record.jsonl` in the folder of refinements has a line of JSON for each of the last thousand changes; `<unix ms>-rig.toml` or
//! `<unix ms>-<object>.toml` beside it is what `sextant config set` takes to go back. A change that cannot be recorded is not made.

use crate::models::{Change, Models};
use anyhow::Context;
use serde_json::{Value, json};
use sextant_calibrator::refinement::{Change as Found, Part};
use sextant_geometry::{Pose, PoseParts};
use sextant_process::whole_lines::write_line;
use sextant_site_files::{object_toml, rig_toml, write_atomically};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Most changes on record; the oldest give way.
const MOST: usize = 1000;

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
        let file = self.folder.join("record.jsonl");
        if let Err(cause) = append(&file, &line(found, &former, now_ns)) {
            let _ = fs::remove_file(&former);
            return Err(cause);
        }
        if let Err(cause) = self.drop_oldest(&file) {
            tracing::warn!("the record of refinements can't be shortened: {cause:#}");
        }
        Ok(former)
    }

    /// Lets the record keep its newest lines, and the files that these name.
    fn drop_oldest(&self, file: &Path) -> anyhow::Result<()> {
        let text = fs::read_to_string(file)?;
        let lines: Vec<&str> = text.lines().collect();
        let (dropped, kept) = lines.split_at(lines.len().saturating_sub(MOST));
        if dropped.is_empty() {
            return Ok(());
        }
        write_atomically(file, format!("{}\n", kept.join("\n")).as_bytes())?;
        for former in dropped.iter().filter_map(|line| former_name(line)) {
            let _ = fs::remove_file(self.folder.join(former));
        }
        Ok(())
    }
}

/// The file that a line names, if it has such a name as [`name`] gives.
fn former_name(line: &str) -> Option<String> {
    let line: Value = serde_json::from_str(line).ok()?;
    let former = Path::new(line.get("former")?.as_str()?);
    let name = former.file_name()?.to_str()?;
    let (ms, _) = name.strip_suffix(".toml")?.split_once('-')?;
    ms.parse::<u64>().ok().map(|_| name.to_owned())
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
    let opened = open.create(true).read(true).append(true).open(file);
    let written = opened.and_then(|mut open| {
        cut_fragment(&mut open)?;
        write_line(&open, format!("{line}\n").as_bytes())?;
        open.sync_data()
    });
    written.with_context(|| format!("{}: cannot be written", file.display()))
}

/// Removes what a power cut left of a last line; one that lacks nothing but its line feed gets that.
fn cut_fragment(file: &mut File) -> io::Result<()> {
    let mut text = Vec::new();
    file.read_to_end(&mut text)?;
    let whole = text
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |at| at + 1);
    let last = &text[whole..];
    if last.is_empty() {
        Ok(())
    } else if serde_json::from_slice::<Value>(last).is_ok() {
        write_line(file, b"\n")
    } else {
        file.set_len(whole as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record in a folder of its own, with a line and a file for each of these numbers.
    fn recorded(numbers: std::ops::Range<usize>) -> (tempfile::TempDir, Record, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let record = Record::in_folder(folder.path().to_owned());
        let file = folder.path().join("record.jsonl");
        let mut text = String::new();
        for number in numbers {
            let former = folder.path().join(format!("{number}-rig.toml"));
            fs::write(&former, "").unwrap();
            text += &format!("{}\n", json!({ "former": former }));
        }
        fs::write(&file, text).unwrap();
        (folder, record, file)
    }

    #[test]
    fn the_oldest_changes_give_way_with_their_files_and_with_no_other() {
        let (folder, record, file) = recorded(0..MOST + 3);
        let path = |name: &str| folder.path().join(name);
        fs::write(path("notes.toml"), "").unwrap();
        let planted = json!({ "former": path("notes.toml") });
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, format!("{planted}\nno json\n{text}")).unwrap();
        record.drop_oldest(&file).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        assert_eq!(text.lines().count(), MOST);
        assert!(text.starts_with(&json!({ "former": path("3-rig.toml") }).to_string()));
        assert!(!path("2-rig.toml").exists());
        assert!(path("3-rig.toml").exists() && path("notes.toml").exists());
        record.drop_oldest(&file).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), text);
    }

    #[test]
    fn half_a_line_of_a_power_cut_goes_and_a_whole_one_stays() {
        let (_folder, _, file) = recorded(0..1);
        let whole = fs::read_to_string(&file).unwrap();
        let line = json!({ "t_ns": 1 });
        for (left, kept) in [("{\"t_ns\": 1", ""), ("{\"t_ns\": 0}", "{\"t_ns\": 0}\n")] {
            fs::write(&file, format!("{whole}{left}")).unwrap();
            append(&file, &line).unwrap();
            let expected = format!("{whole}{kept}{line}\n");
            assert_eq!(fs::read_to_string(&file).unwrap(), expected);
        }
    }
}
