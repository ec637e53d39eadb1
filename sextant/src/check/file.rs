//! Check of one file, whose kind is recognised by its contents.

use super::Found;
use super::cross_checks::CrossChecks;
use super::dataset;
use crate::config::ConfigKind;
use crate::{simulate, words};
use anyhow::{Context, bail};
use node_camera::CameraNodeConfig;
use node_fusion::FusionConfig;
use node_viewer_bridge::{Protection, ViewerConfig};
use serde_json::Value;
use sextant_process::now_ns;
use sextant_proto::{ObjectConfig, RigConfig, encode};
use sextant_recordings::DetectionsLine;
use sextant_recordings::mcap::is_mcap_file;
use sextant_sheets::length_text;
use sextant_site_files::{
    Carried, assumptions, is_foreign, read_board, read_object, read_rig, read_robot, read_text,
    read_toml,
};
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_zenoh_bus::{Profile, Security};
use std::path::Path;

/// Checks a file, and the files that it names.
///
/// # Errors
/// What is wrong with it.
pub fn check(path: &Path, stated: Option<ConfigKind>, together: &mut CrossChecks) -> Found {
    if path.extension().is_some_and(|e| e == "jsonl") {
        let lines = DetectionsLine::read_file(path)?;
        return Ok(("detections", format!("{} images", lines.len())));
    }
    if is_mcap_file(path) {
        return dataset::check_mcap(path, together);
    }
    let kind = match stated {
        Some(kind) => kind,
        None if is_foreign(path, &read_text(path)?) => {
            match read_board(path, &ObjectId::new("board")?)? {
                Some(_) => ConfigKind::Object,
                None => ConfigKind::Rig,
            }
        }
        None => {
            let content: Value = read_toml(path)?;
            if content.get("seed").is_some() {
                return Ok(("scenario", scenario(path)?));
            }
            if content.get("base_from_world").is_some() {
                return Ok(("robot", robot(path)?));
            }
            recognised(path, &content)?
        }
    };
    let summary = match kind {
        ConfigKind::Rig => rig(path, together)?,
        ConfigKind::Object => object(path, together)?,
        ConfigKind::Camera => camera(path)?,
        ConfigKind::Fusion => fusion(path)?,
        ConfigKind::Router => router(path)?,
        ConfigKind::Viewer => viewer(path)?,
    };
    let assumed = assumptions(path)?;
    let all: Vec<String> = std::iter::once(summary).chain(assumed).collect();
    Ok((kind.word(), all.join("; ")))
}

fn robot(path: &Path) -> anyhow::Result<String> {
    let robot = read_robot(path)?;
    let carried = match &robot.carried {
        None => "nothing on its hand".to_owned(),
        Some(Carried::Object(id, _)) => format!("object {id} on its hand"),
        Some(Carried::Camera(id, _)) => format!("camera {id} on its hand"),
    };
    let metres = robot.base_from_world.pose.translation.vector.norm();
    Ok(format!("the world {metres:.3} m from its base, {carried}"))
}

fn recognised(path: &Path, content: &Value) -> anyhow::Result<ConfigKind> {
    kind_of(content).with_context(|| {
        format!(
            "{}: this is no rig, object or node configuration that is known; state what it shall be with --kind",
            path.display()
        )
    })
}

/// The kind whose characteristic keys a file has.
fn kind_of(content: &Value) -> Option<ConfigKind> {
    let has = |key: &str| content.get(key).is_some();
    let lists = |key: &str| content.get(key).is_some_and(Value::is_array);
    let endpoints = content.pointer("/network/listen").and_then(Value::as_array);
    let listens = endpoints.is_some_and(|endpoints| !endpoints.is_empty());
    if lists("camera") {
        Some(ConfigKind::Rig)
    } else if lists("tag") {
        Some(ConfigKind::Object)
    } else if has("source") || has("camera") {
        Some(ConfigKind::Camera)
    } else if has("rig") || has("objects") {
        Some(ConfigKind::Fusion)
    } else if listens && !has("listen") {
        Some(ConfigKind::Router)
    } else if has("listen") || has("site") {
        Some(ConfigKind::Viewer)
    } else if has("id") {
        Some(ConfigKind::Object)
    } else {
        None
    }
}

fn rig(path: &Path, together: &mut CrossChecks) -> anyhow::Result<String> {
    let rig = read_rig(path)?;
    encode(&RigConfig::from(&rig)).with_context(|| path.display().to_string())?;
    let cameras = rig.cameras();
    let uncalibrated = cameras.iter().filter(|camera| !camera.is_placed());
    let summary = format!(
        "{} cameras{}",
        cameras.len(),
        missing(uncalibrated.count(), uncalibrated_remedy(cameras.len()))
    );
    together.rig(path, rig);
    Ok(summary)
}

fn object(path: &Path, together: &mut CrossChecks) -> anyhow::Result<String> {
    let object = read_object(path)?;
    encode(&ObjectConfig::from(&object)).with_context(|| path.display().to_string())?;
    let tags = object.tags();
    let unlearned = tags.iter().filter(|tag| tag.object_from_tag.is_none());
    let n_unlearned = unlearned.count();
    let remedy = match tags.len() {
        1 => "not learned: it is the object's frame",
        n if n == n_unlearned => {
            "not learned: it can't be tracked until `sextant learn` has placed them"
        }
        _ => "not learned: they take no part until `sextant learn` has placed them",
    };
    let summary = format!(
        "\"{}\" with {}{}{}{}",
        object.id(),
        words::count(tags.len(), "tag"),
        sizes(&object),
        extent(&object),
        missing(n_unlearned, remedy)
    );
    together.object(object);
    Ok(summary)
}

/// Edge from which a tag is large enough to ask about, m.
const LARGE_M: f64 = 2.0;

/// The sizes of tags, and a question where they are implausible.
fn sizes(object: &ObjectModel) -> String {
    let sizes = || object.tags().iter().map(|tag| tag.size_m);
    let least = sizes().fold(f64::INFINITY, f64::min);
    let most = sizes().fold(0.0, f64::max);
    let range = match least == most {
        true => format!(" of {}", length_text(most * 1e3)),
        false => format!(
            " of {} to {}",
            length_text(least * 1e3),
            length_text(most * 1e3)
        ),
    };
    match most < LARGE_M {
        true => range,
        false => format!("{range} (tags of {most} m are unusual: sizes are metres)"),
    }
}

/// Distances from the origin from which the places of tags are large enough to ask about: m, and sizes of a tag.
const FAR_M: f64 = 10.0;
const FAR_SIZES: f64 = 300.0;

/// A question where places of tags are implausible.
fn extent(object: &ObjectModel) -> String {
    let tags = object.tags().iter();
    let placed = tags.filter_map(|tag| Some((tag.object_from_tag?, tag.size_m)));
    let far = placed.filter_map(|(place, size_m)| {
        let distance_m = place.translation.vector.norm();
        (distance_m > FAR_M && distance_m > FAR_SIZES * size_m).then_some(distance_m)
    });
    match far.reduce(f64::max) {
        None => String::new(),
        Some(most) => {
            format!(" (a tag {most:.0} m from the origin is unusual: positions are metres)")
        }
    }
}

fn uncalibrated_remedy(n_cameras: usize) -> &'static str {
    match n_cameras {
        1 => "not calibrated: the world is its frame",
        _ => "not calibrated: they take no part until `sextant calibrate rig` has placed them",
    }
}

fn missing(count: usize, what: &str) -> String {
    match count {
        0 => String::new(),
        count => format!(" ({count} {what})"),
    }
}

fn camera(path: &Path) -> anyhow::Result<String> {
    let config = CameraNodeConfig::read(path)?;
    let protection = config
        .protection()
        .with_context(|| path.display().to_string())?;
    Ok(format!(
        "\"{}\" of site \"{}\"{}",
        config.camera,
        config.site,
        protected(&protection)?
    ))
}

fn fusion(path: &Path) -> anyhow::Result<String> {
    let config: FusionConfig = read_toml(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let protection = config.protection(folder);
    let protection = protection.with_context(|| path.display().to_string())?;
    let sound = config.check().map_err(anyhow::Error::msg);
    sound.with_context(|| path.display().to_string())?;
    let mut together = CrossChecks::default();
    rig(&folder.join(&config.rig), &mut together)?;
    for file in &config.objects {
        object(&folder.join(file), &mut together)?;
    }
    if let Some(complaint) = together.complaints().first() {
        bail!("{}: {complaint}", path.display());
    }
    Ok(format!(
        "\"{}\" of site \"{}\", {} objects{}",
        config.node,
        config.site,
        config.objects.len(),
        protected(&protection)?
    ))
}

/// The profile of a node, unless it is that of a demo; a certificate that has expired is wrong.
fn protected(security: &Security) -> anyhow::Result<String> {
    let now_s = now_ns() / 1_000_000_000;
    let warning = security.warning(now_s).unwrap_or_default();
    if security.has_expired(now_s) {
        bail!(warning);
    }
    let warning = if warning.is_empty() {
        warning
    } else {
        format!(" ({warning})")
    };
    Ok(match security.profile() {
        Profile::Demo => String::new(),
        profile => format!(", security profile {}{warning}", profile.name()),
    })
}

fn scenario(path: &Path) -> anyhow::Result<String> {
    let scenario = simulate::read(path)?;
    Ok(format!(
        "{} cameras, {} objects",
        scenario.cameras.len(),
        scenario.objects.len()
    ))
}

fn router(path: &Path) -> anyhow::Result<String> {
    let (node, network, security) = crate::router::read(path)?;
    Ok(format!(
        "\"{node}\" on {}{}",
        network.listen.join(", "),
        protected(&security)?
    ))
}

fn viewer(path: &Path) -> anyhow::Result<String> {
    let config: ViewerConfig = read_toml(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let protection = Protection::load(&config, folder);
    let protection = protection.with_context(|| path.display().to_string())?;
    Ok(format!(
        "\"{}\" of site \"{}\" on {}{}",
        config.node,
        config.site,
        config.listen,
        protected(&protection.network)?
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_simulator::Scenario;
    use sextant_site_files::parse_toml;

    #[test]
    fn a_scenario_is_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scenario.toml");
        sextant_site_files::write_toml(&path, &Scenario::demo(2, 1, 1)).unwrap();
        let found = check(&path, None, &mut CrossChecks::default()).unwrap();
        assert_eq!(found, ("scenario", "2 cameras, 1 objects".to_owned()));
    }

    #[test]
    fn files_of_other_tools_are_recognised_and_right() {
        let folder = tempfile::tempdir().unwrap();
        let ost = "image_width: 640\nimage_height: 480\n\
            camera_matrix: {rows: 3, cols: 3, data: [610.0, 0.0, 322.0, 0.0, 609.0, 241.0, 0.0, 0.0, 1.0]}\n";
        let grid =
            "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n";
        let giant = "id = \"giant\"\n[[tag]]\nfamily = \"tag36h11\"\nid = 0\nsize = 88.0\n";
        let found = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            check(&path, None, &mut CrossChecks::default())
        };
        assert_eq!(found("ost.toml", ost).unwrap().0, "rig");
        let (word, summary) = found("grid.yaml", grid).unwrap();
        assert_eq!(
            (word, &*summary),
            ("object", "\"grid\" with 36 tags of 88 mm")
        );
        let (_, summary) = found("giant.toml", giant).unwrap();
        assert!(summary.contains("sizes are metres"), "{summary}");
        let far = giant.replace(
            "88.0",
            "0.04\nobject_from_tag = { position = [0, 0, 30], orientation = [0, 0, 0, 1] }",
        );
        let (_, summary) = found("far.toml", &far).unwrap();
        assert!(summary.contains("a tag 30 m from the origin"), "{summary}");
        let millimetres = grid.replace("0.088", "88");
        let error = found("grid.yaml", &millimetres).unwrap_err().to_string();
        assert!(error.contains("are these millimetres?"), "{error}");
    }

    #[test]
    fn every_example_is_recognised_and_right() {
        use ConfigKind::{Camera, Fusion, Object, Rig, Viewer};
        let folder = tempfile::tempdir().unwrap();
        for kind in [Rig, Object, Camera, Fusion, Viewer] {
            let path = folder.path().join(format!("{}.toml", kind.word()));
            std::fs::write(&path, kind.example()).unwrap();
            let content: Value = parse_toml(&path, kind.example(), |_| Ok(())).unwrap();
            assert_eq!(kind_of(&content), Some(kind));
            let (word, _) = check(&path, None, &mut CrossChecks::default()).unwrap();
            assert_eq!(word, kind.word());
        }
    }
}
