//! Boards as other tools describe them, and where their tags are.

use super::*;
use crate::{assumptions, read_object};
use nalgebra::Point3;
use sextant_geometry::tag_corners_in_tag;
use std::fs;

/// As Kalibr's own example.
const TARGET: &str = "target_type: 'aprilgrid' #gridtype
tagCols: 6               #number of apriltags
tagRows: 6               #number of apriltags
tagSize: 0.088           #size of apriltag, edge to edge [m]
tagSpacing: 0.3          #ratio of space between tags to tagSize
";

const MULTICAL: &str = "boards:
  charuco_16x22:
    _type_: charuco
    size: [16, 22]
    aruco_dict: 4X4_1000
    square_length: 0.025
    marker_length: 0.01875
    min_rows: 3
    min_points: 20
";

/// As Kalibr's own example.
const CHECKERBOARD: &str = "target_type: 'checkerboard' #gridtype
targetCols: 6               #number of internal chessboard corners
targetRows: 7               #number of internal chessboard corners
rowSpacingMeters: 0.06      #size of one chessboard square [m]
colSpacingMeters: 0.06      #size of one chessboard square [m]
";

const GRID: &str = "markersX: 3\nmarkersY: 2\nmarkerLength: 0.04\nmarkerSeparation: 0.01\ndictionary: DICT_4X4_50\n";

/// As in anipose's documentation.
const ANIPOSE: &str = "[calibration]
# checkerboard / charuco / aruco
board_type = \"charuco\"
board_size = [6, 5]
board_marker_bits = 4
board_marker_dict_number = 50
board_marker_length = 3 # mm
board_square_side_length = 4 # mm
fisheye = false

[triangulation]
cam_regex = 'cam([1-9])'
";

fn read(name: &str, text: &str) -> Result<ObjectModel, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let root = format!("{}/", folder.path().display());
    read_object(&path).map_err(|error| error.to_string().replace(&root, ""))
}

/// Corners of a tag of a board, metres in its frame.
fn corners(board: &ObjectModel, id: u32) -> [Point3<f64>; 4] {
    let tag = board.tags().iter().find(|tag| tag.tag.id == id).unwrap();
    tag_corners_in_tag(tag.size_m).map(|corner| tag.object_from_tag.unwrap() * corner)
}

fn assert_near(is: Point3<f64>, expected: [f64; 3]) {
    assert!(
        (is - Point3::from(expected)).norm() < 1e-12,
        "{is} {expected:?}"
    );
}

#[test]
fn kalibrs_target_has_its_origin_at_the_lower_left_of_its_first_tag() {
    let board = read("Target 1.yaml", TARGET).unwrap();
    assert_eq!((board.id().as_str(), board.tags().len()), ("target_1", 36));
    assert!(
        board
            .tags()
            .iter()
            .all(|tag| tag.tag.family == Family::Tag36h11b2)
    );
    let [upper_left, _, _, lower_left] = corners(&board, 0);
    assert_near(lower_left, [0.0; 3]);
    assert_near(upper_left, [0.0, 0.088, 0.0]);
    assert_near(corners(&board, 1)[3], [0.1144, 0.0, 0.0]);
    assert_near(corners(&board, 6)[3], [0.0, 0.1144, 0.0]);
}

#[test]
fn squares_of_an_april_grid_touch_its_tags_corners() {
    let grid = AprilGrid {
        columns: 2,
        rows: 1,
        size_m: 0.02,
        spacing: 0.25,
        first: 5,
    };
    let squares: Vec<[f64; 2]> = grid.squares().collect();
    let expected = [
        [-5.0, -5.0],
        [20.0, -5.0],
        [45.0, -5.0],
        [-5.0, 20.0],
        [20.0, 20.0],
        [45.0, 20.0],
    ];
    for (is, expected) in squares.iter().zip(expected) {
        assert!((is[0] * 1e3 - expected[0]).hypot(is[1] * 1e3 - expected[1]) < 1e-9);
    }
    assert_eq!((squares.len(), grid.square_m()), (6, 0.005));
    let ids: Vec<u32> = grid.tags().map(|(tag, _)| tag.id).collect();
    assert_eq!(ids, [5, 6]);
}

/// Where OpenCV's CharucoBoard((5, 4), 0.04, 0.03, DICT_5X5_100) has its first and last markers and, with the pattern
/// of old, its first one; `getObjPoints` of version 4.10, grown from the marker to the square.
#[test]
fn squares_of_a_charuco_board_lie_where_opencv_has_them() {
    let text = "squaresX: 5\nsquaresY: 4\nsquareLength: 0.04\nmarkerLength: 0.03\ndictionary: DICT_5X5_100\n";
    let board = read("board.yml", text).unwrap();
    assert_eq!(board.tags().len(), 10);
    assert!(
        board
            .tags()
            .iter()
            .all(|tag| tag.tag.family == Family::Charuco5x5With100)
    );
    let [upper_left, upper_right, _, lower_left] = corners(&board, 0);
    assert_near(upper_left, [0.04, 0.0, 0.0]);
    assert_near(upper_right, [0.08, 0.0, 0.0]);
    assert_near(lower_left, [0.04, 0.04, 0.0]);
    assert_near(corners(&board, 9)[2], [0.2, 0.16, 0.0]);
    let legacy = read("board.yml", &format!("{text}legacyPattern: true\n")).unwrap();
    assert_near(corners(&legacy, 0)[0], [0.0; 3]);
    let numbered = text.replace("DICT_5X5_100", "5");
    assert_eq!(read("board.yml", &numbered).unwrap(), board);
}

#[test]
fn multicals_boards_are_read() {
    let board = read("boards.yaml", MULTICAL).unwrap();
    assert_eq!((board.tags().len(), board.tags()[0].size_m), (176, 0.025));
    assert_eq!(board.tags()[0].tag.family, Family::Charuco4x4With1000);
}

/// Where OpenCV's GridBoard((3, 2), 0.04, 0.01, DICT_4X4_50) has its markers: `getObjPoints` of version 5.0.
#[test]
fn markers_of_a_grid_lie_where_opencv_has_them() {
    let board = read("grid.yaml", GRID).unwrap();
    assert_eq!(board.tags().len(), 6);
    assert_eq!(board.tags()[0].tag.family, Family::Aruco4x4With50);
    assert_near(corners(&board, 0)[0], [0.0; 3]);
    assert_near(corners(&board, 1)[0], [0.05, 0.0, 0.0]);
    assert_near(corners(&board, 3)[2], [0.04, 0.09, 0.0]);
    // OpenCV draws AprilTags upside down.
    let april = GRID.replace("DICT_4X4_50", "DICT_APRILTAG_36h11");
    let board = read("grid.yaml", &april).unwrap();
    assert_eq!(board.tags()[0].tag.family, Family::Tag36h11);
    assert_near(corners(&board, 0)[2], [0.0; 3]);
    let numbered = GRID.replace("DICT_4X4_50", "20");
    assert_eq!(read("grid.yaml", &numbered).unwrap(), board);
}

#[test]
fn a_chessboard_is_described_by_its_inner_corners() {
    let text = "id = \"target\"\nkind = \"chessboard\"\ncolumns = 6\nrows = 7\nsize = 0.06\n";
    let board = read("board.toml", text).unwrap();
    assert_eq!((board.id().as_str(), board.tags().len()), ("target", 30));
    assert_near(corners(&board, 0)[0], [0.0; 3]);
    assert_near(corners(&board, 64)[1], [0.06, 0.06, 0.0]);
    assert_eq!(read("Target.yaml", CHECKERBOARD).unwrap(), board);
    let chessboard = Chessboard::from_object(&board).unwrap();
    assert_eq!(
        (chessboard.columns, chessboard.rows, chessboard.square_m),
        (6, 7, 0.06)
    );
    assert!(!chessboard.is_symmetric());
    for (from, to, expected) in [
        (
            "\"chessboard\"",
            "\"chesboard\"",
            "board.toml:2:8: kind: unknown variant `chesboard`",
        ),
        (
            "rows = 7",
            "rows = 1",
            "board.toml:3:11: columns: a chessboard has 3 to 65 inner corners",
        ),
        ("rows = 7", "rwos = 7", "did you mean `rows`?"),
        ("size = 0.06", "size = 0", "board.toml:5:8: size: "),
    ] {
        let message = read("board.toml", &text.replace(from, to)).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn aniposes_boards_are_read_in_millimetres() {
    let board = read("config.toml", ANIPOSE).unwrap();
    assert_eq!((board.id().as_str(), board.tags().len()), ("config", 15));
    assert_near(corners(&board, 0)[0], [0.004, 0.0, 0.0]);
    let checkerboard = ANIPOSE.replace("\"charuco\"", "\"checkerboard\"");
    let board = read("config.toml", &checkerboard).unwrap();
    assert_eq!(Chessboard::from_object(&board).unwrap().columns, 6);
    let grid = ANIPOSE.replace("\"charuco\"", "\"aruco\"");
    let message = read("config.toml", &grid).unwrap_err();
    assert!(
        message.starts_with("config.toml:3:14: calibration.board_type: "),
        "{message}"
    );
    assert!(
        message.contains("needs `board_marker_separation_length`"),
        "{message}"
    );
    let grid = grid.replace("fisheye", "board_marker_separation_length = 1\nfisheye");
    assert_near(
        corners(&read("config.toml", &grid).unwrap(), 1)[0],
        [0.004, 0.0, 0.0],
    );
    let other = ANIPOSE.replace("bits = 4", "bits = 9");
    let message = read("config.toml", &other).unwrap_err();
    assert!(
        message.contains("board_marker_bits: there is no dictionary of 50 markers of 9 x 9 bits"),
        "{message}"
    );
}

#[test]
fn what_is_no_board_is_refused_with_what_would_be_one() {
    let refused = |text: &str| read("b.yaml", text).unwrap_err();
    assert!(refused("cam0: {}").contains("known are Kalibr's target.yaml"));
    let circles = "target_type: 'circlegrid'\ntargetCols: 6\ntargetRows: 7\n";
    assert!(refused(circles).contains("`circlegrid` is not supported; known are aprilgrid"));
    let uneven = CHECKERBOARD.replace("rowSpacingMeters: 0.06", "rowSpacingMeters: 0.05");
    assert!(refused(&uneven).starts_with("b.yaml: rowSpacingMeters: the spacing of rows"));
    let few = CHECKERBOARD.replace("targetRows: 7", "targetRows: 2");
    assert!(refused(&few).contains("not 6 x 2; inner corners are one fewer than squares"));
    let touching = GRID.replace("markerSeparation: 0.01", "markerSeparation: 0");
    assert!(refused(&touching).contains("leaves no white between the markers"));
    let unknown = GRID.replace("DICT_4X4_50", "DICT_8X8_50");
    assert!(refused(&unknown).contains("DICT_ARUCO_ORIGINAL"));
    let without = TARGET.replace("tagRows: 6", "");
    assert!(refused(&without).starts_with("b.yaml: tagrows: it is missing"));
    let narrow = TARGET.replace("tagSpacing: 0.3", "tagSpacing: 0.1");
    assert!(refused(&narrow).contains("a spacing of 0.1 is outside 0.15 to 1"));
    let large = TARGET.replace("tagRows: 6", "tagRows: 99");
    assert!(refused(&large).contains("tags up to 593, but tag36h11b2 ends with 586"));
    let other = MULTICAL.replace("4X4_1000", "APRILTAG_36h11");
    assert!(refused(&other).contains("known are DICT_4X4_50 to DICT_7X7_1000"));
    let wide = MULTICAL.replace("0.01875", "0.024");
    assert!(refused(&wide).contains("markers of 0.96 of a square are outside"));
    assert!(refused(&MULTICAL.replace("0.025", "25")).contains("markers of 0.00"));
}

#[test]
fn a_board_in_millimetres_is_a_question() {
    let refused = |text: &str| read("b.yaml", text).unwrap_err();
    let millimetres = TARGET.replace("0.088 ", "88 ");
    assert_eq!(
        refused(&millimetres),
        "b.yaml: tags with an edge of 88 m: are these millimetres?; write metres, such as 0.088 for 88 mm"
    );
    let chessboard = CHECKERBOARD.replace("0.06 ", "60 ");
    assert!(refused(&chessboard).contains("an edge of 60 m: are these millimetres?"));
}

#[test]
fn a_bundle_of_apriltag_ros_is_an_object() {
    let tags = "standalone_tags: [{id: 10, size: 0.15}]\ntag_bundles:\n  [{name: 'plate', layout: [
        {id: 0, size: 0.05, x: 0.0, y: 0.0, z: 0.0, qw: 1.0, qx: 0.0, qy: 0.0, qz: 0.0},
        {id: 4, size: 0.05, x: 0.06, y: -0.06, z: 0.0, qw: 1.0, qx: 0.0, qy: 0.0, qz: 0.0}]}]\n";
    let object = read("tags.yaml", tags).unwrap();
    assert_eq!(object.tags().len(), 2);
    assert_near(corners(&object, 4)[0], [0.035, -0.035, 0.0]);
    let two = tags.replace("}]}]\n", "}]}, {name: wand, layout: []}]\n");
    let error = read("tags.yaml", &two).unwrap_err();
    assert!(
        error.contains("it describes 2 objects: plate, wand; leave one bundle"),
        "{error}"
    );
    let turned = tags.replacen("qw: 1.0", "qw: 2.0", 1);
    let error = read("tags.yaml", &turned).unwrap_err();
    assert!(error.contains("layout[0].qw: the quaternion"), "{error}");
}

/// A tag with WPILib's x out of its face, here towards +x of the field: its right edge lies towards +y, its upper edge
/// towards +z.
#[test]
fn a_field_of_wpilib_is_an_object() {
    let field = r#"{"tags": [{"ID": 1, "pose": {"translation": {"x": 4.0, "y": 0.24, "z": 1.35},
        "rotation": {"quaternion": {"W": 1.0, "X": 0.0, "Y": 0.0, "Z": 0.0}}}}], "field": {"length": 10.0, "width": 6.0}}"#;
    let object = read("field.json", field).unwrap();
    let half = 0.1651 / 2.0;
    let [upper_left, upper_right, ..] = corners(&object, 1);
    assert_near(upper_left, [4.0, 0.24 - half, 1.35 + half]);
    assert_near(upper_right, [4.0, 0.24 + half, 1.35 + half]);
    let normal = object.tags()[0].object_from_tag.unwrap() * nalgebra::Vector3::z();
    assert!((normal - nalgebra::Vector3::x()).norm() < 1e-12);
    assert!(object.world_from_object().is_some());
    let error = read("field.json", &field.replace("\"ID\": 1", "\"ID\": 9999")).unwrap_err();
    assert!(
        error.contains("tags[0].ID: tag36h11 has no such tag"),
        "{error}"
    );
}

#[test]
fn a_field_of_wpilib_is_written_as_it_is_read() {
    let tag = |id: u32, pose: Pose| {
        let family = Family::Tag36h11;
        ObjectTag::new(TagId { family, id }, 0.1651, Some(pose))
    };
    let turned = UnitQuaternion::from_euler_angles(0.3, -1.2, 2.0);
    let pose = Pose::from_parts(Translation3::new(15.0, 0.25, 1.4), turned);
    let tags = vec![tag(1, pose), tag(2, Pose::translation(1.0, 2.0, 1e-9))];
    let object = ObjectModel::new("field".parse().unwrap(), tags.clone()).unwrap();
    let text = field_layout(&object, [16.541, 8.069]).unwrap();
    let again = read("field.json", &text).unwrap();
    for (found, tag) in again.tags().iter().zip(&tags) {
        assert_eq!((found.tag, found.size_m), (tag.tag, tag.size_m));
        let apart = found
            .object_from_tag
            .unwrap()
            .inv_mul(&tag.object_from_tag.unwrap());
        assert!(apart.translation.vector.norm() + apart.rotation.angle() < 1e-12);
    }

    let refused = |tags: Vec<ObjectTag>, field_m: [f64; 2]| {
        let object = ObjectModel::new("field".parse().unwrap(), tags).unwrap();
        field_layout(&object, field_m).unwrap_err().cause
    };
    let mut other = tag(3, pose);
    other.size_m = 0.2;
    assert!(refused(vec![tags[0].clone(), other], [1.0, 1.0]).contains("one family and size"));
    let mut unplaced = tag(3, pose);
    unplaced.object_from_tag = None;
    assert!(refused(vec![unplaced], [1.0, 1.0]).contains("no tag has a place"));
    assert!(refused(tags, [0.0, f64::NAN]).contains("no area"));
}

/// The field of 2023 has tag16h5 of 6 inches, that of 2024 tag36h11 of 6.5 inches; what no field of FRC says is
/// assumed, and said.
#[test]
fn the_family_of_a_fields_tags_follows_from_the_field_or_is_said() {
    let field = |last: u32, [length, width]: [f64; 2], more: &str| {
        let tag = |id: u32| {
            format!(
                r#"{{"ID": {id}, "pose": {{"translation": {{"x": {id}.0, "y": 0.2, "z": 1.3}},
                "rotation": {{"quaternion": {{"W": 1.0, "X": 0.0, "Y": 0.0, "Z": 0.0}}}}}}}}"#
            )
        };
        let tags: Vec<String> = [1, last].map(tag).into();
        format!(
            r#"{{"tags": [{}], {more} "field": {{"length": {length}, "width": {width}}}}}"#,
            tags.join(", ")
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("field.json");
    let check = |text: String, family: Family, size_m: f64, said: &str| {
        fs::write(&file, &text).unwrap();
        let object = read_object(&file).unwrap();
        let tag = &object.tags()[0];
        assert_eq!((tag.tag.family, tag.size_m), (family, size_m));
        let assumed = assumptions(&file).unwrap().join("; ");
        assert!(assumed.contains(said), "{assumed}");
        assert_eq!(assumed.is_empty(), said.is_empty(), "{assumed}");
    };
    let of_2023 = [16.54175, 8.0137];
    check(field(8, of_2023, ""), Family::Tag16h5, 0.1524, "in 2023");
    check(field(16, [16.541, 8.211], ""), Family::Tag36h11, 0.1651, "");
    let own = field(8, [4.0, 3.0], "");
    check(own, Family::Tag36h11, 0.1651, "tag36h11 of 165.1 mm");
    let named = field(8, of_2023, r#""family": "tag36h11", "tagSize": 0.2,"#);
    check(named, Family::Tag36h11, 0.2, "");
    let bundle = "tag_bundles: [{name: a, layout: [{id: 0, size: 0.05}]}]\n".to_owned();
    check(bundle.clone(), Family::Tag36h11, 0.05, "family: tag16h5");
    check(
        format!("family: tag25h9\n{bundle}"),
        Family::Tag25h9,
        0.05,
        "",
    );
}
