//! Boards as other tools describe them, and where their tags are.

use super::*;
use crate::read_object;
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

/// Where OpenCV's CharucoBoard((5, 4), 0.04, 0.03, DICT_5X5_100) has its first and last markers and, with the pattern of old, its
/// first one; `getObjPoints` of version 4.10, grown from the marker to the square.
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

#[test]
fn what_is_no_board_is_refused_with_what_would_be_one() {
    let refused = |text: &str| read("b.yaml", text).unwrap_err();
    assert!(refused("cam0: {}").contains("known are Kalibr's target.yaml"));
    let checkerboard = "target_type: 'checkerboard'\ntargetCols: 6\ntargetRows: 7\n";
    assert!(refused(checkerboard).contains("`checkerboard` has no tags"));
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
