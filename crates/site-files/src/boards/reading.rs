//! Descriptions of boards as other tools write them: Kalibr's `target.yaml`, multical's `boards`, and the arguments of
//! OpenCV's `CharucoBoard` and `GridBoard` in a YAML or JSON file; and places of tags ([`layouts`]).
//!
//! Keys count as OpenCV, Python and C++ spell them: `squareLength`, `square_length` and `squarelength` are one.

use super::{AprilGrid, BoardError, CharucoBoard, Chessboard, MarkerGrid, UpperLeft, layouts};
use crate::error::{Complaint, FileError, InvalidFile};
use crate::foreign::parse_document;
use crate::read::read_text;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_tag_families::Family;
use std::path::Path;
use yaml_serde::Value;

/// The board that another tool's file describes, under the id; nothing where the file describes none.
///
/// # Errors
/// A file that is missing, malformed, or describes a board that is none here.
pub fn read_board(path: &Path, id: &ObjectId) -> Result<Option<ObjectModel>, FileError> {
    parse_board(path, &read_text(path)?, id)
}

/// As [`read_board`], of a text at hand; `path` is for the messages.
pub(crate) fn parse_board(
    path: &Path,
    text: &str,
    id: &ObjectId,
) -> Result<Option<ObjectModel>, FileError> {
    let document = parse_document(path, text)?;
    let described =
        || description(&document).map(|description| BoardMapping(description).board(id));
    let Some(board) = layouts::object(&document, id).or_else(described) else {
        return Ok(None);
    };
    let board = board.map_err(|complaint| InvalidFile::with_all(path, complaint))?;
    Ok(Some(board))
}

/// Edge from which the tags of a board are no metres, m.
const IMPLAUSIBLE_M: f64 = 1.0;

/// Refuses a board of giants: its lengths are in another unit.
fn plausible(board: ObjectModel) -> Result<ObjectModel, Complaint> {
    let sizes = board.tags().iter().map(|tag| tag.size_m);
    let largest = sizes.fold(0.0, f64::max);
    if largest < IMPLAUSIBLE_M {
        return Ok(board);
    }
    let cause = format!("tags with an edge of {largest} m: are these millimetres?");
    let remedy = format!("write metres, such as {} for {largest} mm", largest * 1e-3);
    Err(Complaint::new("", cause, remedy))
}

/// What describes a board: all of the document, or one of multical's `boards`.
fn description(document: &Value) -> Option<&Value> {
    let is_board = |value: &Value| {
        let described = BoardMapping(value);
        let keys = ["squarelength", "tagspacing", "markerseparation"];
        described.kind().is_some() || described.find(&keys).is_some()
    };
    let boards = document.get("boards").and_then(Value::as_mapping);
    let of_several = boards.and_then(|boards| boards.values().find(|board| is_board(board)));
    of_several.or(is_board(document).then_some(document))
}

/// A mapping that describes a board.
struct BoardMapping<'a>(&'a Value);

impl<'a> BoardMapping<'a> {
    /// The value of the first of these keys, which are in small letters and without underscores.
    fn find(&self, keys: &[&str]) -> Option<(&'a str, &'a Value)> {
        let entries = self.0.as_mapping()?.iter();
        let spelled = |key: &Value| key.as_str().map(|key| key.to_lowercase().replace('_', ""));
        entries
            .filter(|(_, value)| !value.is_null())
            .find(|(key, _)| spelled(key).is_some_and(|key| keys.contains(&key.as_str())))
            .and_then(|(key, value)| Some((key.as_str()?, value)))
    }

    /// What the file calls the kind of board.
    fn kind(&self) -> Option<&'a str> {
        self.find(&["targettype", "type", "kind"])
            .and_then(|(_, kind)| kind.as_str())
    }

    fn board(&self, id: &ObjectId) -> Result<ObjectModel, Complaint> {
        let has = |key: &str| self.find(&[key]).is_some();
        let described = match () {
            () if has("tagspacing") => "aprilgrid",
            () if has("markerseparation") => "aruco",
            () => "charuco",
        };
        let id = id.clone();
        let board = match self.kind().unwrap_or(described) {
            "aprilgrid" => self.april_grid()?.object(id),
            "charuco" => self.charuco()?.object(id),
            "aruco" | "gridboard" | "grid" => self.marker_grid()?.object(id),
            "checkerboard" | "chessboard" => self.chessboard()?.object(id),
            other => {
                return Err(Complaint::new(
                    "",
                    format!("a target of the type `{other}` is not supported"),
                    "known are aprilgrid, charuco, aruco and checkerboard; print one: `sextant print charuco`",
                ));
            }
        };
        board.map_err(|error| complaint(&error)).and_then(plausible)
    }

    fn april_grid(&self) -> Result<AprilGrid, Complaint> {
        let [columns, rows] = self.grid(&["tagcols"], &["tagrows"])?;
        Ok(AprilGrid {
            columns,
            rows,
            size_m: self.number(&["tagsize", "taglength"])?,
            spacing: self.number(&["tagspacing"])?,
            first: self.whole(&["codeoffset", "startid"])?.unwrap_or(0),
        })
    }

    fn charuco(&self) -> Result<CharucoBoard, Complaint> {
        let [columns, rows] = self.grid(&["squaresx"], &["squaresy"])?;
        let is_legacy = self.find(&["legacypattern"]).is_some_and(|(_, value)| {
            value.as_bool().unwrap_or(false) || value.as_i64().is_some_and(|number| number != 0)
        });
        Ok(CharucoBoard {
            columns,
            rows,
            square_m: self.number(&["squarelength"])?,
            marker_m: self.number(&["markerlength"])?,
            family: self.dictionary("charuco")?,
            first: self.whole(&["arucooffset"])?.unwrap_or(0),
            // The pattern of old differs where rows are even.
            upper_left: match is_legacy && rows % 2 == 0 {
                true => UpperLeft::Marker,
                false => UpperLeft::Black,
            },
        })
    }

    fn marker_grid(&self) -> Result<MarkerGrid, Complaint> {
        let [columns, rows] = self.grid(&["markersx"], &["markersy"])?;
        Ok(MarkerGrid {
            columns,
            rows,
            marker_m: self.number(&["markerlength"])?,
            separation_m: self.number(&["markerseparation"])?,
            family: self.dictionary("aruco")?,
            first: self.whole(&["firstmarker", "arucooffset"])?.unwrap_or(0),
        })
    }

    fn chessboard(&self) -> Result<Chessboard, Complaint> {
        let [columns, rows] = self.grid(&["targetcols", "columns"], &["targetrows", "rows"])?;
        let keys = ["colspacingmeters", "squarelength", "squaresize"];
        let square_m = self.number(&keys)?;
        if let Some((key, value)) = self.find(&["rowspacingmeters"])
            && value.as_f64() != Some(square_m)
        {
            let cause = "the spacing of rows is not that of columns";
            return Err(Complaint::new(
                key,
                cause,
                "a chessboard has squares; measure one",
            ));
        }
        Ok(Chessboard {
            columns,
            rows,
            square_m,
        })
    }

    /// Columns and rows, each by itself or both as `size`.
    fn grid(&self, columns: &[&str], rows: &[&str]) -> Result<[u16; 2], Complaint> {
        if let Some((key, size)) = self.find(&["size"]) {
            let counts: Option<Vec<u16>> = size.as_sequence().and_then(|size| {
                let counts = size.iter().map(|count| count.as_u64()?.try_into().ok());
                counts.collect()
            });
            let both = counts.and_then(|counts| counts.try_into().ok());
            return both.ok_or_else(|| Complaint::new(key, "these are no columns and rows", ""));
        }
        let count = |keys: &[&str]| {
            let count = self.whole(keys)?.ok_or_else(|| missing(keys))?;
            u16::try_from(count)
                .map_err(|_| Complaint::new(keys[0], format!("{count} are too many"), ""))
        };
        Ok([count(columns)?, count(rows)?])
    }

    fn number(&self, keys: &[&str]) -> Result<f64, Complaint> {
        let (key, value) = self.find(keys).ok_or_else(|| missing(keys))?;
        let number = value.as_f64().filter(|number| number.is_finite());
        number.ok_or_else(|| {
            Complaint::new(
                key,
                "this is no finite number",
                "write metres, of a spacing a share",
            )
        })
    }

    fn whole(&self, keys: &[&str]) -> Result<Option<u32>, Complaint> {
        let Some((key, value)) = self.find(keys) else {
            return Ok(None);
        };
        // OpenCV writes whole numbers, others 6.0.
        let number = value
            .as_f64()
            .filter(|n| n.fract() == 0.0 && (0.0..=1e6).contains(n));
        let number = number.ok_or_else(|| Complaint::new(key, "this is no whole number", ""))?;
        Ok(Some(number as u32))
    }

    /// The family of a dictionary: `DICT_5X5_100`, `5X5_100`, or OpenCV's number of it.
    fn dictionary(&self, kind: &str) -> Result<Family, Complaint> {
        let keys = [
            "dictionary",
            "arucodict",
            "arucodictionary",
            "dictionaryname",
            "dict",
        ];
        let (key, value) = self.find(&keys).ok_or_else(|| missing(&keys))?;
        let by_number = value.as_u64().and_then(by_number);
        let name = by_number
            .or(value.as_str().map(str::to_lowercase))
            .unwrap_or_default();
        let name = name
            .trim_start_matches("cv2.aruco.")
            .trim_start_matches("dict_")
            .replace('_', "-");
        let of_markers = match (kind, name.as_str()) {
            ("aruco", "aruco-original") => Some("aruco-original".to_owned()),
            ("aruco", "aruco-mip-36h12") => Some("aruco-mip-36h12".to_owned()),
            ("aruco", april) => april
                .strip_prefix("apriltag-")
                .map(|bits| format!("tag{bits}")),
            _ => None,
        };
        let family = of_markers.unwrap_or_else(|| format!("{kind}{name}"));
        family.parse().map_err(|_| {
            let cause = format!("there is no dictionary `{name}` here");
            let known = match kind {
                "aruco" => {
                    "known are DICT_4X4_50 to DICT_7X7_1000, DICT_ARUCO_ORIGINAL, \
                 DICT_ARUCO_MIP_36h12 and DICT_APRILTAG_36h11, 36h10, 25h9 and 16h5"
                }
                _ => "known are DICT_4X4_50 to DICT_7X7_1000",
            };
            Complaint::new(key, cause, known)
        })
    }
}

/// Name of a dictionary by OpenCV's number.
fn by_number(number: u64) -> Option<String> {
    const OTHERS: [&str; 6] = [
        "aruco_original",
        "apriltag_16h5",
        "apriltag_25h9",
        "apriltag_36h10",
        "apriltag_36h11",
        "aruco_mip_36h12",
    ];
    let number = usize::try_from(number).ok()?;
    let bits = 4 + number / 4;
    match number.checked_sub(16) {
        Some(other) => OTHERS.get(other).map(|name| (*name).to_owned()),
        None => Some(format!(
            "{bits}x{bits}_{}",
            [50, 100, 250, 1000][number % 4]
        )),
    }
}

fn missing(keys: &[&str]) -> Complaint {
    Complaint::new(
        keys[0],
        "it is missing",
        "a board has columns, rows, lengths in metres and, with ArUco's markers, a dictionary",
    )
}

fn complaint(error: &BoardError) -> Complaint {
    let remedy = match error {
        BoardError::Object(_) => "write lengths in metres",
        _ => "",
    };
    Complaint::new("", error.to_string(), remedy)
}
