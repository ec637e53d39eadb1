//! A recording as an animation: USD as text, or binary glTF.

use crate::output::{Format, print_line};
use crate::words;
use anyhow::{Context, anyhow};
use serde_json::json;
use sextant_pose_formats::{Animation, AnimationBuilder, glb, write_usda};
use sextant_process::{Exit, Failure, WithExit};
use sextant_proto::{AnyMessage, KeyRef, Keys};
use sextant_recordings::mcap::WIRE_ENCODING;
use sextant_recordings::mcap::reader::{Ending, McapReader, RecordedMessage};
use sextant_site_files::Replacement;
use sextant_site_model::{ObjectModel, Rig};
use std::io::{BufWriter, Write};
use std::path::Path;

/// A format of animations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnimationFormat {
    /// USD as text.
    Usda,
    /// Binary glTF.
    Glb,
}

impl AnimationFormat {
    /// The format that a file's name says; `None` where it says no animation.
    ///
    /// # Errors
    /// [`Exit::Usage`] for other forms of the formats.
    pub fn named(path: &Path) -> anyhow::Result<Option<Self>> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        let remedy = match ending {
            Some("usda") => return Ok(Some(Self::Usda)),
            Some("glb") => return Ok(Some(Self::Glb)),
            Some("usd" | "usdc" | "usdz") => {
                "USD is written as text: let the name end with .usda; `usdcat` of USD converts it"
            }
            Some("gltf") => "glTF is written as one binary file: let the name end with .glb",
            _ => return Ok(None),
        };
        let cause = anyhow!("{}: {remedy}", path.display());
        Err(Failure::new(Exit::Usage, cause).into())
    }
}

/// Writes the poses of a recording as an animation.
///
/// # Errors
/// [`Exit::Usage`] for a folder, [`Exit::Input`] for a recording that cannot be used or has no poses, and a place that is taken.
pub fn run(
    from: &Path,
    to: &Path,
    animation_format: AnimationFormat,
    format: Format,
) -> anyhow::Result<()> {
    let recording = from.display();
    if from.is_dir() {
        let cause = anyhow!(
            "{recording} is a folder, which has no poses; give a recording of `sextant record`"
        );
        return Err(Failure::new(Exit::Usage, cause).into());
    }
    refuse_taken(to)?;
    let animation = read(from)?;
    write(&animation, animation_format, to)?;
    report(&animation, to, format)
}

fn refuse_taken(to: &Path) -> anyhow::Result<()> {
    if to.symlink_metadata().is_ok() {
        let cause = anyhow!("{}: the file exists; choose a new name", to.display());
        return Err(Failure::new(Exit::Input, cause).into());
    }
    Ok(())
}

/// Reads models and poses, message by message.
fn read(from: &Path) -> anyhow::Result<Animation> {
    let mut reader = McapReader::open(from).exit_with(Exit::Input)?;
    let mut builder = AnimationBuilder::default();
    let mut keys = None;
    while let Some(message) = reader.next_message().exit_with(Exit::Input)? {
        if keys.is_none() {
            keys = reader.info().and_then(|info| Keys::new(&info.site).ok());
        }
        let key = keys
            .as_ref()
            .and_then(|keys| keys.parse(&message.channel.topic));
        if let Some(key) = key.filter(|_| message.channel.encoding == WIRE_ENCODING) {
            // What is damaged, or of another version, is left out.
            let _ = take(&mut builder, &key, &message);
        }
    }
    reader
        .info()
        .ok_or_else(|| reader.emptiness())
        .exit_with(Exit::Input)?;
    if let Some(ending) = reader.ending().filter(|ending| **ending != Ending::Closed) {
        eprintln!("{}: {ending}", from.display());
    }
    let animation = builder.finish();
    let remedy = "record a site while its fusion node publishes poses";
    animation
        .with_context(|| format!("{}: {remedy}", from.display()))
        .exit_with(Exit::Input)
}

/// `None` for a message that is not what its key promises.
fn take(builder: &mut AnimationBuilder, key: &KeyRef, message: &RecordedMessage) -> Option<()> {
    if !matches!(
        key,
        KeyRef::ConfigRig | KeyRef::ConfigObject(_) | KeyRef::Pose(_) | KeyRef::Links(_)
    ) {
        return Some(());
    }
    let content = AnyMessage::decode(&message.data).ok()?;
    match (key, content) {
        (KeyRef::ConfigRig, AnyMessage::RigConfig(rig)) => builder.rig(Rig::try_from(&rig).ok()?),
        (KeyRef::ConfigObject(id), AnyMessage::ObjectConfig(object))
            if object.id == *id && !object.is_removal() =>
        {
            builder.object(ObjectModel::try_from(&object).ok()?);
        }
        (KeyRef::Pose(id), AnyMessage::ObjectPose(pose)) if pose.object == *id => {
            builder.pose(&pose, message.arrival_ns);
        }
        (KeyRef::Links(id), AnyMessage::ObjectLinks(links)) if links.object == *id => {
            builder.links(&links, message.arrival_ns);
        }
        _ => {}
    }
    Some(())
}

fn write(animation: &Animation, format: AnimationFormat, to: &Path) -> anyhow::Result<()> {
    let place = || format!("{}", to.display());
    let replacement = Replacement::begin(to)
        .with_context(place)
        .exit_with(Exit::Input)?;
    let mut out = BufWriter::new(replacement.file());
    match format {
        AnimationFormat::Usda => write_usda(animation, &mut out).with_context(place)?,
        AnimationFormat::Glb => {
            let bytes = glb(animation).with_context(place).exit_with(Exit::Input)?;
            out.write_all(&bytes).with_context(place)?;
        }
    }
    out.flush().with_context(place)?;
    drop(out);
    replacement.commit().with_context(place)?;
    Ok(())
}

fn report(animation: &Animation, to: &Path, format: Format) -> anyhow::Result<()> {
    let (cameras, objects) = animation.counts();
    let (seconds, left_out) = (animation.duration_s(), animation.left_out());
    let line = match format {
        Format::Json => json!({
            "to": to,
            "cameras": cameras,
            "objects": objects,
            "seconds": seconds,
            "left_out": {
                "cameras": left_out.cameras,
                "objects": left_out.objects,
                "tags": left_out.tags,
            },
        })
        .to_string(),
        Format::Text => {
            let place = to.display();
            for (names, cause) in [
                (&left_out.cameras, "their poses are unknown"),
                (&left_out.objects, "they were never tracked"),
            ] {
                if !names.is_empty() {
                    eprintln!("{place}: without {}: {cause}", names.join(", "));
                }
            }
            if left_out.tags > 0 {
                let tags = words::count(left_out.tags, "tag");
                eprintln!("{place}: without {tags}: no place on their object is known");
            }
            let (cameras, objects) = (
                words::count(cameras, "camera"),
                words::count(objects, "object"),
            );
            format!("{place}: {cameras}, {objects}, {seconds:.1} s")
        }
    };
    Ok(print_line(&line)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_says_the_format() {
        let named = |name: &str| AnimationFormat::named(Path::new(name));
        assert_eq!(named("a.usda").unwrap(), Some(AnimationFormat::Usda));
        assert_eq!(named("a.glb").unwrap(), Some(AnimationFormat::Glb));
        assert_eq!(named("a.mcap").unwrap(), None);
        for (name, remedy) in [("a.usdc", ".usda"), ("a.usd", ".usda"), ("a.gltf", ".glb")] {
            let error = named(name).unwrap_err().to_string();
            assert!(error.contains(remedy), "{error}");
        }
    }

    #[test]
    fn what_cannot_be_animated_is_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let to = folder.path().join("a.glb");
        let refused = |from: &Path| {
            let error = run(from, &to, AnimationFormat::Glb, Format::Text).unwrap_err();
            assert!(!to.exists());
            format!("{error:#}")
        };
        assert!(refused(folder.path()).contains("which has no poses"));
        let text = folder.path().join("text.mcap");
        std::fs::write(&text, "text").unwrap();
        assert!(refused(&text).contains("not an MCAP file"));
    }
}
