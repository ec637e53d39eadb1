//! Objects as written, read and refused.

use super::*;
use sextant_site_model::Prior;

const GOOD: &str = r#"
id = "cube"
[[tag]]
family = "tag36h11"
id = 3
size = 0.04
object_from_tag = { position = [0, 0, 0.03], orientation = [0, 0, 0, 1] }

[[tag]]
family = "tag36h11"
id = 4
size = 0.0401234567890123
"#;

fn parsed(text: &str) -> Result<ObjectModel, String> {
    parse_object(Path::new("cube.toml"), text).map_err(|error| error.to_string())
}

#[test]
fn the_designs_file_is_read() {
    let object = parsed(GOOD).unwrap();
    assert_eq!(object.id().as_str(), "cube");
    let [first, second] = object.tags() else {
        panic!("two tags")
    };
    assert_eq!((first.tag.id, first.size_m), (3, 0.04));
    assert_eq!(first.object_from_tag.unwrap().translation.z, 0.03);
    assert_eq!(second.object_from_tag, None);
}

#[test]
fn what_is_written_is_read_back_exactly() {
    let object = parsed(GOOD).unwrap();
    assert_eq!(parsed(&object_toml(&object)).unwrap(), object);
}

#[test]
fn how_well_a_tags_place_is_known_may_be_stated() {
    let stated =
        "[0, 0, 0, 1] }\nobject_from_tag_sigma = { position = 0.0002, orientation = 0.003 }";
    let object = parsed(&GOOD.replacen("[0, 0, 0, 1] }", stated, 1)).unwrap();
    let sigma = |index: usize| object.tags()[index].pose_prior.given();
    assert_eq!(sigma(0).map(|sigma| sigma.orientation_rad), Some(0.003));
    assert_eq!(sigma(1), None);
    assert_eq!(parsed(&object_toml(&object)).unwrap(), object);
    for (wrong, expected) in [
        (
            stated.replace("0.003", "3.0"),
            "tag[0].object_from_tag_sigma: ",
        ),
        (
            stated.replace("object_from_tag_s", "link_from_tag_s"),
            "write `object_from_tag_sigma`",
        ),
    ] {
        let message = parsed(&GOOD.replacen("[0, 0, 0, 1] }", &wrong, 1)).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_simulated_object_is_exact() {
    let object = parsed(&format!("exact = true{GOOD}")).unwrap();
    for tag in object.tags() {
        assert_eq!(tag.size_prior, Prior::Exact);
        assert_eq!(tag.pose_prior, Prior::Exact);
    }
    assert_eq!(parsed(&object_toml(&object)).unwrap(), object);
}

#[test]
fn how_well_frame_and_scale_are_known_may_be_stated() {
    let stated = "frame_sigma = { position = 0.0005, orientation = 0.004 }\nscale_sigma = 0.001";
    let object = parsed(&format!("{stated}{GOOD}")).unwrap();
    let frame = object.frame_sigma().unwrap();
    assert_eq!((frame.position_m, frame.orientation_rad), (0.0005, 0.004));
    assert_eq!(object.scale_sigma(), Some(0.001));
    assert_eq!(parsed(&object_toml(&object)).unwrap(), object);
    for (sigma, key) in [("0.004", "frame_sigma"), ("0.001", "scale_sigma")] {
        let wrong = stated.replacen(sigma, "nan", 1);
        let message = parsed(&format!("{wrong}{GOOD}")).unwrap_err();
        assert!(
            message.contains(&format!("{key}: object cube")),
            "{message}"
        );
    }
}

#[test]
fn the_sigma_of_a_size_is_read_in_metres() {
    let given = GOOD.replacen("size = 0.04\n", "size = 0.04\nsize_sigma = 0.0002\n", 1);
    let object = parsed(&given).unwrap();
    assert_eq!(object.tags()[0].size_prior, Prior::Sigma(0.0002));
    assert_eq!(parsed(&object_toml(&object)).unwrap(), object);
    let message = parsed(&given.replace("0.0002", "0.5")).unwrap_err();
    assert!(message.contains("tag[0].size_sigma"), "{message}");
}

#[test]
fn wrong_objects_are_refused_with_line_key_and_remedy() {
    for (from, to, expected) in [
        (
            "id = 4",
            "id = 3",
            "cube.toml:11:6: tag[1].id: tag36h11:3 is there already, on line 5; each tag may be used once",
        ),
        (
            "size = 0.04\n",
            "size = 0\n",
            "cube.toml:6:8: tag[0].size: ",
        ),
        (
            "size = 0.04\n",
            "size = -0.04\n",
            "cube.toml:6:8: tag[0].size: ",
        ),
        (
            "size = 0.04\n",
            "size = nan\n",
            "cube.toml:6:8: tag[0].size: ",
        ),
        ("size = 0.04\n", "size = inf\n", "write it in metres"),
        (
            "size = 0.04\n",
            "size = \"4cm\"\n",
            "cube.toml:6:8: tag[0].size: invalid type: string",
        ),
        (
            "size = 0.04\n",
            "",
            "tag[0]: missing field `size`; add `size = ...`",
        ),
        (
            "id = 3",
            "id = 587",
            "cube.toml:5:6: tag[0].id: tag36h11 has no tag 587; its ids are 0 to 586",
        ),
        (
            "id = 3",
            "id = -1",
            "cube.toml:5:6: tag[0].id: invalid value: integer `-1`",
        ),
        ("id = \"cube\"", "id = \"my cube\"", "cube.toml:2:6: id: "),
        (
            "tag36h11",
            "tag36h111",
            "cube.toml:4:10: tag[0].family: unknown variant `tag36h111`",
        ),
        ("tag36h11", "tag36h111", "did you mean `tag36h11`?"),
        ("size", "siez", "did you mean `size`?"),
        (
            "[0, 0, 0.03]",
            "[0, inf, 0.03]",
            "cube.toml:7:32: tag[0].object_from_tag.position: ",
        ),
        (
            "[0, 0, 0, 1]",
            "[0, 0, 0, 0]",
            "cube.toml:7:60: tag[0].object_from_tag.orientation: this is no unit quaternion, its length is 0",
        ),
        ("[0, 0, 0, 1]", "[0, nan, 0, 1]", "its length is NaN"),
    ] {
        assert!(GOOD.contains(from));
        let message = parsed(&GOOD.replacen(from, to, 1)).unwrap_err();
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
}

#[test]
fn an_object_without_tags_is_refused() {
    let message = parsed("id = \"cube\"\n").unwrap_err();
    assert!(message.starts_with("cube.toml:1:6: id: the object has no tag"));
}
