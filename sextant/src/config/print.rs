//! `sextant config KIND`: documented example files.

use crate::output::{Format, print_line};
use clap::ValueEnum;
use serde_json::json;

/// Kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum ConfigKind {
    /// The cameras of a site.
    Rig,
    /// An object and its tags.
    Object,
    /// A camera node.
    Camera,
    /// A fusion node.
    Fusion,
    /// A router.
    Router,
    /// A viewer bridge.
    Viewer,
}

impl ConfigKind {
    /// Its name on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rig => "rig",
            Self::Object => "object",
            Self::Camera => "camera",
            Self::Fusion => "fusion",
            Self::Router => "router",
            Self::Viewer => "viewer",
        }
    }

    /// Example file with every key, its default and its meaning.
    pub fn example(self) -> &'static str {
        match self {
            Self::Rig => include_str!("rig.toml"),
            Self::Object => include_str!("object.toml"),
            Self::Camera => include_str!("camera.toml"),
            Self::Fusion => include_str!("fusion.toml"),
            Self::Router => include_str!("router.toml"),
            Self::Viewer => include_str!("viewer.toml"),
        }
    }
}

/// Prints the example of a kind.
///
/// # Errors
/// A closed standard output.
pub fn run(kind: ConfigKind, format: Format) -> anyhow::Result<()> {
    let text = kind.example();
    match format {
        Format::Text => print_line(text.trim_end())?,
        Format::Json => print_line(&json!({"kind": kind.word(), "toml": text}).to_string())?,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::router::RouterConfig;
    use node_camera::{CameraNodeConfig, DetectionConfig, PreviewConfig};
    use node_fusion::FusionConfig;
    use node_viewer_bridge::ViewerConfig;
    use serde::de::DeserializeOwned;
    use sextant_iceoryx_images::IceoryxOptions;
    use sextant_site_files::{parse_object, parse_rig, parse_toml};
    use sextant_zenoh_bus::{BusOptions, Mode, Profile, SecurityOptions};
    use std::path::Path;

    fn read<T: DeserializeOwned>(kind: ConfigKind) -> T {
        parse_toml(Path::new("example"), kind.example(), |_| Ok(())).unwrap()
    }

    /// The network of an example states every default in words.
    fn is_default(network: &BusOptions, mode: Mode) {
        let expected = BusOptions {
            mode,
            connect: network.connect.clone(),
            listen: network.listen.clone(),
            ..BusOptions::default()
        };
        assert_eq!(*network, expected);
    }

    #[test]
    fn models_are_sound() {
        let rig = parse_rig(Path::new("rig.toml"), ConfigKind::Rig.example()).unwrap();
        assert_eq!(rig.cameras().len(), 2);
        let object = parse_object(Path::new("object.toml"), ConfigKind::Object.example()).unwrap();
        assert_eq!(object.tags().len(), 2);
    }

    #[test]
    fn nodes_state_their_defaults() {
        let camera: CameraNodeConfig = read(ConfigKind::Camera);
        assert_eq!(camera.detection, DetectionConfig::default());
        assert_eq!(camera.preview, PreviewConfig::default());
        assert_eq!(camera.shared_memory, IceoryxOptions::default());
        is_default(&camera.network, Mode::Client);
        assert_eq!(camera.security, SecurityOptions::default());
        assert_eq!(
            camera.network.connect_endpoints(Profile::Demo),
            BusOptions::default().connect_endpoints(Profile::Demo)
        );

        let minimal = "site = \"demo\"\nrig = \"rig.toml\"\nobjects = [\"object.toml\"]\n";
        let default: FusionConfig = parse_toml(Path::new("f"), minimal, |_| Ok(())).unwrap();
        let fusion: FusionConfig = read(ConfigKind::Fusion);
        assert_eq!(fusion.node, default.node);
        assert_eq!(fusion.refinement, default.refinement);
        assert_eq!(fusion.max_age_s, default.max_age_s);
        assert_eq!(fusion.network.listen, default.network.listen);
        is_default(&fusion.network, default.network.mode);
        assert_eq!(fusion.security, SecurityOptions::default());

        let router: RouterConfig = read(ConfigKind::Router);
        is_default(&router.network, BusOptions::default().mode);
        assert_eq!(router.security, SecurityOptions::default());

        let default: ViewerConfig =
            parse_toml(Path::new("v"), "site = \"demo\"", |_| Ok(())).unwrap();
        let viewer: ViewerConfig = read(ConfigKind::Viewer);
        assert_eq!((viewer.node, viewer.listen), (default.node, default.listen));
        assert_eq!(viewer.host_names, default.host_names);
        is_default(&viewer.network, Mode::Client);
        assert_eq!(viewer.security, SecurityOptions::default());
    }
}
