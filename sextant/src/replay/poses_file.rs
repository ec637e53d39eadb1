//! The file that poses go to: JSON lines, TUM text, C3D, or an animation in USD or glTF, by its name.

use crate::animation_file::{AnimationFormat, say_left_out};
use anyhow::{Context, bail};
use sextant_pose_files::{AnimationBuilder, c3d};
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::{pose_json, pose_tum};
use sextant_site_files::write_atomically;
use sextant_site_model::{ObjectModel, Rig};
use sextant_site_report::ObjectEstimate;
use std::path::{Path, PathBuf};

/// A file of poses.
pub struct PosesFile {
    path: PathBuf,
    kind: PosesKind,
}

enum PosesKind {
    Lines(fn(&ObjectEstimate) -> String),
    C3d,
    Animation(AnimationFormat),
}

/// What an animation shows beside poses.
pub struct Scene {
    /// The cameras.
    pub rig: Rig,
    /// The objects.
    pub objects: Vec<ObjectModel>,
}

impl PosesFile {
    /// The file of that name.
    ///
    /// # Errors
    /// [`Exit::Usage`] for an unknown file extension.
    pub fn named(path: &Path) -> anyhow::Result<Self> {
        let animation = AnimationFormat::named(path)?.map(PosesKind::Animation);
        let kind = match path.extension().and_then(|e| e.to_str()) {
            Some("jsonl" | "json") => PosesKind::Lines(pose_json),
            Some("tum") => PosesKind::Lines(pose_tum),
            Some("c3d") => PosesKind::C3d,
            _ => animation
                .with_context(|| {
                    format!(
                        "--out {}: the name says no format; let it end with .jsonl, .tum, .c3d, .usda or .glb",
                        path.display()
                    )
                })
                .exit_with(Exit::Usage)?,
        };
        Ok(Self {
            path: path.to_owned(),
            kind,
        })
    }

    /// Whether it has cameras, too, which stand in the world.
    pub fn is_animation(&self) -> bool {
        matches!(self.kind, PosesKind::Animation(_))
    }

    /// Writes the poses, whole or not at all.
    ///
    /// # Errors
    /// An I/O error; [`Exit::Usage`] for TUM text of several objects, which it cannot distinguish, and for what C3D has
    /// no room for; [`Exit::Input`] for an animation without tracked objects.
    pub fn write(&self, poses: &[ObjectEstimate], scene: Scene) -> anyhow::Result<()> {
        let is_tum = self.path.extension().is_some_and(|e| e == "tum");
        if is_tum && poses.iter().any(|pose| pose.object != poses[0].object) {
            let cause = anyhow::anyhow!(
                "--out {}: TUM text has one object only; give one --object, or write .jsonl",
                self.path.display()
            );
            bail!(Failure::new(Exit::Usage, cause));
        }
        let bytes = match self.kind {
            PosesKind::Animation(format) => return self.write_animation(format, poses, scene),
            PosesKind::Lines(line) => poses
                .iter()
                .flat_map(|pose| format!("{}\n", line(pose)).into_bytes())
                .collect(),
            PosesKind::C3d => c3d(poses)
                .with_context(|| format!("--out {}", self.path.display()))
                .exit_with(Exit::Usage)?,
        };
        write_atomically(&self.path, &bytes).context("the poses are lost")
    }

    fn write_animation(
        &self,
        format: AnimationFormat,
        poses: &[ObjectEstimate],
        scene: Scene,
    ) -> anyhow::Result<()> {
        let mut builder = AnimationBuilder::default();
        builder.rig(scene.rig);
        for object in scene.objects {
            builder.object(object);
        }
        for pose in poses {
            builder.estimate(pose);
        }
        let animation = builder
            .finish()
            .with_context(|| format!("--out {}", self.path.display()))
            .exit_with(Exit::Input)?;
        say_left_out(animation.left_out(), &self.path);
        format.write(&animation, &self.path)
    }
}
