//! Everything that a rig file or an object file can say survives the way over the network, digit for digit: file,
//! model, message, bytes and back to the text of a file.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use proptest::option::of;
use proptest::prelude::*;
use sextant_proto::{ObjectConfig, RigConfig, decode, encode};
use sextant_site_files::{object_toml, parse_object, parse_rig, rig_toml};
use sextant_site_model::{ObjectModel, Rig};
use std::path::Path;

/// The text of a rig file after its rig was sent and received.
fn sent_rig(text: &str) -> String {
    let rig = parse_rig(Path::new("rig.toml"), text).unwrap();
    let payload = encode(&RigConfig::from(&rig)).unwrap();
    let received = Rig::try_from(&decode::<RigConfig>(&payload).unwrap()).unwrap();
    assert_eq!(received, rig);
    rig_toml(&received)
}

/// The text of an object file after its object was sent and received.
fn sent_object(text: &str) -> String {
    let object = parse_object(Path::new("object.toml"), text).unwrap();
    let payload = encode(&ObjectConfig::from(&object)).unwrap();
    let received = ObjectModel::try_from(&decode::<ObjectConfig>(&payload).unwrap()).unwrap();
    assert_eq!(received, object);
    object_toml(&received)
}

/// A line of the file, or nothing.
fn line(key: &str, value: Option<String>) -> String {
    value.map_or_else(String::new, |value| format!("{key} = {value}\n"))
}

fn pose() -> impl Strategy<Value = String> {
    let position = prop::array::uniform3(-100.0..100.0_f64);
    let direction = prop::array::uniform4(-1.0..1.0_f64);
    let direction = direction.prop_filter("too short for a direction", |q| {
        q.iter().map(|x| x * x).sum::<f64>() > 0.01
    });
    (position, direction).prop_map(|(position, q)| {
        let [x, y, z, w] = q;
        let unit = nalgebra::Quaternion::new(w, x, y, z).normalize();
        let orientation = [unit.i, unit.j, unit.k, unit.w];
        format!("{{ position = {position:?}, orientation = {orientation:?} }}")
    })
}

fn pose_sigma() -> impl Strategy<Value = String> {
    (0.0..1.0_f64, 0.0..1.0_f64).prop_map(|(position, orientation)| {
        format!("{{ position = {position:?}, orientation = {orientation:?} }}")
    })
}

fn lens() -> impl Strategy<Value = String> {
    let focal = (100.0..2000.0_f64, 100.0..2000.0_f64);
    let numbers = (focal, 0.0..640.0_f64, 0.0..480.0_f64).prop_map(|((fx, fy), cx, cy)| {
        format!("fx = {fx:?}, fy = {fy:?}, cx = {cx:?}, cy = {cy:?}")
    });
    let model = prop_oneof![
        Just(("pinhole", String::new())),
        prop::array::uniform5(-1e-3..1e-3_f64)
            .prop_map(|k| ("brown-conrady", format!(", distortion = {k:?}"))),
        prop::array::uniform4(-1e-3..1e-3_f64)
            .prop_map(|k| ("kannala-brandt", format!(", distortion = {k:?}"))),
    ];
    (numbers, model).prop_map(|(numbers, (model, distortion))| {
        format!("{{ model = \"{model}\", {numbers}{distortion} }}")
    })
}

fn exposure() -> impl Strategy<Value = String> {
    let stamp = prop::sample::select(vec!["", "stamp = \"start\"\n", "stamp = \"end\"\n"]);
    let given = (0.0..1.0_f64, stamp);
    of(given).prop_map(|given| {
        given.map_or_else(String::new, |(length_s, stamp)| {
            format!("exposure = {length_s:?}\n{stamp}")
        })
    })
}

/// A camera's table but for its id.
fn camera() -> impl Strategy<Value = String> {
    let lens_sigma = (0.0..100.0_f64, 0.0..100.0_f64).prop_map(|(focal, distortion)| {
        format!("{{ focal = {focal:?}, distortion = {distortion:?} }}")
    });
    let line_delay = (1e-9..2e-4_f64, any::<bool>()).prop_map(|(delay_s, is_from_below)| {
        let sign = if is_from_below { -1.0 } else { 1.0 };
        format!("{:?}", sign * delay_s)
    });
    (
        (2..5000_u32, 2..500_u32),
        lens(),
        of(lens_sigma),
        of(pose()),
        of(pose_sigma()),
        of(line_delay),
        exposure(),
    )
        .prop_map(
            |((width, height), lens, lens_sigma, pose, pose_sigma, line_delay, exposure)| {
                [
                    format!("resolution = [{width}, {height}]\nlens = {lens}\n"),
                    line("lens_sigma", lens_sigma),
                    line("world_from_camera", pose),
                    line("world_from_camera_sigma", pose_sigma),
                    line("line_delay", line_delay),
                    exposure,
                ]
                .concat()
            },
        )
}

fn rig() -> impl Strategy<Value = String> {
    prop::collection::vec(camera(), 1..4).prop_map(|cameras| {
        let cameras = cameras.iter().enumerate();
        let tables = cameras.map(|(n, camera)| format!("[[camera]]\nid = \"c{n}\"\n{camera}\n"));
        tables.collect()
    })
}

/// A tag's table but for its family and id; `link` is the line that names its link, on an object of links.
fn tag(link: Option<&'static str>) -> impl Strategy<Value = String> {
    let outer = link.map_or("object", |_| "link");
    let size = (0.01..1.0_f64, of(0.0..1.0_f64));
    (size, of(pose()), of(pose_sigma())).prop_map(move |((size_m, share), pose, sigma)| {
        let size_sigma = share.map(|share| format!("{:?}", share * size_m));
        [
            format!("size = {size_m:?}\n"),
            line("size_sigma", size_sigma),
            link.unwrap_or_default().to_owned(),
            line(&format!("{outer}_from_tag"), pose),
            line(&format!("{outer}_from_tag_sigma"), sigma),
        ]
        .concat()
    })
}

fn tags(link: Option<&'static str>) -> impl Strategy<Value = String> {
    let families = prop::sample::select(vec!["tag36h11", "tag25h9", "aruco4x4-50"]);
    prop::collection::vec((families, tag(link)), 1..4).prop_map(|tags| {
        let tags = tags.iter().enumerate();
        let tables = tags.map(|(id, (family, tag))| {
            format!("\n[[tag]]\nfamily = \"{family}\"\nid = {id}\n{tag}")
        });
        tables.collect()
    })
}

/// A joint that turns or slides, between the links of [`arm`].
fn moving_joint() -> impl Strategy<Value = String> {
    let kind = prop::sample::select(vec!["revolute", "prismatic"]);
    let axis = prop::sample::select(vec!["[0.0, 0.0, 1.0]", "[0.0, 0.6, -0.8]"]);
    let limits = (-3.0..0.0_f64, 0.1..3.0_f64).prop_map(|(low, high)| format!("{:?}", [low, high]));
    let speed = (0.1..10.0_f64).prop_map(|speed| format!("{speed:?}"));
    (kind, axis, pose(), of(limits), of(speed)).prop_map(|(kind, axis, origin, limits, speed)| {
        [
            "\n[[joint]]\nid = \"elbow\"\n".to_owned(),
            format!("kind = \"{kind}\"\nparent = \"upper\"\nchild = \"lower\"\n"),
            format!("axis = {axis}\norigin = {origin}\n"),
            line("limits", limits),
            line("max_speed", speed),
        ]
        .concat()
    })
}

/// An object of three links: a joint that moves, and one that is fixed.
fn arm() -> impl Strategy<Value = String> {
    (moving_joint(), pose(), tags(Some("link = \"lower\"\n"))).prop_map(|(elbow, origin, tags)| {
        let links = ["upper", "lower", "cover"].map(|link| format!("\n[[link]]\nid = \"{link}\"\n"));
        let fixed = format!(
            "\n[[joint]]\nid = \"weld\"\nkind = \"fixed\"\nparent = \"lower\"\nchild = \"cover\"\norigin = {origin}\n"
        );
        format!("id = \"arm\"\n{}{elbow}{fixed}{tags}", links.concat())
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_rig_file_comes_back_digit_for_digit(text in rig()) {
        prop_assert_eq!(sent_rig(&text), text);
    }

    #[test]
    fn a_rigid_objects_file_comes_back_digit_for_digit(tags in tags(None)) {
        let text = format!("id = \"cube\"\n{tags}");
        prop_assert_eq!(sent_object(&text), text);
    }

    #[test]
    fn an_articulated_objects_file_comes_back_digit_for_digit(text in arm()) {
        prop_assert_eq!(sent_object(&text), text);
    }

    /// `exact = true` travels as standard deviations of zero, so that the file that comes back lists these instead.
    #[test]
    fn exact_files_stay_exact(rig in rig(), tags in tags(None)) {
        let rig = format!("exact = true\n{rig}");
        let back = sent_rig(&rig);
        prop_assert_eq!(sent_rig(&back), back.clone());
        let first = parse_rig(Path::new("rig.toml"), &rig).unwrap();
        prop_assert_eq!(parse_rig(Path::new("rig.toml"), &back).unwrap(), first);
        let object = format!("id = \"cube\"\nexact = true\n{tags}");
        let back = sent_object(&object);
        let first = parse_object(Path::new("object.toml"), &object).unwrap();
        prop_assert_eq!(parse_object(Path::new("object.toml"), &back).unwrap(), first);
    }
}
