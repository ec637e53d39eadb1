//! A recording as an animation: USD as text, or binary glTF.

use crate::animation_file::{AnimationFormat, say_left_out};
use crate::output::{Format, print_line};
use crate::words;
use anyhow::anyhow;
use serde_json::json;
use sextant_pose_files::{Animation, AnimationBuilder};
use sextant_process::{Exit, Failure, WithExit};
use sextant_proto::{AnyMessage, KeyRef, Keys};
use sextant_recordings::mcap::WIRE_ENCODING;
use sextant_recordings::mcap::reader::{Ending, McapReader, RecordedMessage};
use sextant_site_model::{ObjectModel, Rig};
use std::path::Path;

/// Writes the poses of a recording as an animation.
///
/// # Errors
/// [`Exit::Usage`] for a folder, [`Exit::Input`] for a recording that cannot be used or has no poses, and a place that
/// is taken.
pub fn run(
    from: &Path,
    to: &Path,
    animation_format: AnimationFormat,
    format: Format,
) -> anyhow::Result<()> {
    let recording = from.display();
    if from.is_dir() {
        let cause = anyhow!(
            "{recording} is a folder, which has no poses; replay it: sextant replay {recording} \
             --rig rig.toml --object OBJECT.toml --out {}",
            to.display()
        );
        return Err(Failure::new(Exit::Usage, cause).into());
    }
    refuse_taken(to)?;
    let animation = read(from)?;
    animation_format.write(&animation, to)?;
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
    let place = from.display();
    let animation = builder.finish().map_err(|cause| {
        anyhow!("{place}: {cause}; if it has observations, `sextant replay {place} --out FILE.usda` computes poses")
    });
    animation.exit_with(Exit::Input)
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
            say_left_out(left_out, to);
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
