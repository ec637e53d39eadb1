//! Descriptions of boards as other tools write them: Kalibr's `target.yaml`, multical's `boards`, and the arguments of OpenCV's
//! `CharucoBoard` in a YAML or JSON file.
//!
//! Keys count as OpenCV, Python and C++ spell them: `squareLength`, `square_length` and `squarelength` are one.

use super::{AprilGrid, BoardError, CharucoBoard, UpperLeft};
use crate::error::{Complaint, FileError, InvalidFile};
use crate::foreign::parse_yaml;
use crate::read::read_text;
use sextant_estimator::{ObjectId, ObjectModel};
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
    let document = parse_yaml(path, text)?;
    let Some(description) = description(&document) else {
        return Ok(None);
    };
    let board = BoardMapping(description).board(id);
    Ok(Some(board.map_err(|complaint| {
        InvalidFile::with_all(path, complaint)
    })?))
}

/// What describes a board: all of the document, or one of multical's `boards`.
fn description(document: &Value) -> Option<&Value> {
    let is_board = |value: &Value| {
        let described = BoardMapping(value);
        described.kind().is_some() || described.find(&["squarelength", "tagspacing"]).is_some()
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
        self.find(&["targettype", "type"])
            .and_then(|(_, kind)| kind.as_str())
    }

    fn board(&self, id: &ObjectId) -> Result<ObjectModel, Complaint> {
        let is_grid = self.find(&["tagspacing"]).is_some();
        let kind = self
            .kind()
            .unwrap_or(if is_grid { "aprilgrid" } else { "charuco" });
        let board = match kind {
            "aprilgrid" => self.april_grid()?.object(id.clone()),
            "charuco" => self.charuco()?.object(id.clone()),
            other => {
                return Err(Complaint::new(
                    "",
                    format!(
                        "a target of the type `{other}` has no tags that say which corner is which"
                    ),
                    "print an aprilgrid or a ChArUco board: `sextant print aprilgrid`, `sextant print charuco`",
                ));
            }
        };
        board.map_err(|error| complaint(&error))
    }

    fn april_grid(&self) -> Result<AprilGrid, Complaint> {
        let [columns, rows] = self.grid(["tagcols"], ["tagrows"])?;
        Ok(AprilGrid {
            columns,
            rows,
            size_m: self.number(&["tagsize", "taglength"])?,
            spacing: self.number(&["tagspacing"])?,
            first: self.whole(&["codeoffset", "startid"])?.unwrap_or(0),
        })
    }

    fn charuco(&self) -> Result<CharucoBoard, Complaint> {
        let [columns, rows] = self.grid(["squaresx"], ["squaresy"])?;
        let is_legacy = self.find(&["legacypattern"]).is_some_and(|(_, value)| {
            value.as_bool().unwrap_or(false) || value.as_i64().is_some_and(|number| number != 0)
        });
        Ok(CharucoBoard {
            columns,
            rows,
            square_m: self.number(&["squarelength"])?,
            marker_m: self.number(&["markerlength"])?,
            family: self.dictionary()?,
            first: self.whole(&["arucooffset"])?.unwrap_or(0),
            // The pattern of old differs where rows are even.
            upper_left: match is_legacy && rows % 2 == 0 {
                true => UpperLeft::Marker,
                false => UpperLeft::Black,
            },
        })
    }

    /// Columns and rows, each by itself or both as `size`.
    fn grid(&self, columns: [&str; 1], rows: [&str; 1]) -> Result<[u16; 2], Complaint> {
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
        Ok([count(&columns)?, count(&rows)?])
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
    fn dictionary(&self) -> Result<Family, Complaint> {
        let keys = [
            "dictionary",
            "arucodict",
            "arucodictionary",
            "dictionaryname",
            "dict",
        ];
        let (key, value) = self.find(&keys).ok_or_else(|| missing(&keys))?;
        let by_number = value.as_u64().and_then(|number| {
            let bits = 4 + number / 4;
            let tags = [50, 100, 250, 1000][(number % 4) as usize];
            (bits <= 7).then(|| format!("{bits}x{bits}_{tags}"))
        });
        let name = by_number
            .or(value.as_str().map(str::to_lowercase))
            .unwrap_or_default();
        let name = name
            .trim_start_matches("cv2.aruco.")
            .trim_start_matches("dict_")
            .replace('_', "-");
        format!("charuco{name}").parse().map_err(|_| {
            let cause = format!("there is no dictionary `{name}` here");
            Complaint::new(key, cause, "known are DICT_4X4_50 to DICT_7X7_1000")
        })
    }
}

fn missing(keys: &[&str]) -> Complaint {
    Complaint::new(
        keys[0],
        "it is missing",
        "a board has columns, rows, sizes and, with ArUco's markers, a dictionary",
    )
}

fn complaint(error: &BoardError) -> Complaint {
    let remedy = match error {
        BoardError::Object(_) => "write lengths in metres",
        _ => "",
    };
    Complaint::new("", error.to_string(), remedy)
}
