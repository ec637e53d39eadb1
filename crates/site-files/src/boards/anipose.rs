//! The board of an anipose project: the table `[calibration]` of its `config.toml`. Lengths are in millimetres.

use super::{CharucoBoard, Chessboard, MarkerGrid, UpperLeft};
use crate::error::Complaint;
use serde::Deserialize;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_tag_families::Family;

/// Keys of other tables and of other steps of anipose are passed over.
#[derive(Deserialize)]
pub(crate) struct AniposeFile {
    calibration: Calibration,
}

#[derive(Deserialize)]
struct Calibration {
    board_type: String,
    /// Of a checkerboard its inner corners, otherwise squares or markers.
    board_size: [u16; 2],
    board_marker_bits: Option<u32>,
    board_marker_dict_number: Option<u32>,
    board_marker_length: Option<f64>,
    board_marker_separation_length: Option<f64>,
    board_square_side_length: Option<f64>,
}

impl AniposeFile {
    pub(crate) fn object(&self, id: &ObjectId) -> Result<ObjectModel, Complaint> {
        let board = &self.calibration;
        let [columns, rows] = board.board_size;
        let id = id.clone();
        let object = match board.board_type.to_lowercase().as_str() {
            "checkerboard" => Chessboard {
                columns,
                rows,
                square_m: board.square_m()?,
            }
            .object(id),
            "charuco" => CharucoBoard {
                columns,
                rows,
                square_m: board.square_m()?,
                marker_m: board.marker_m()?,
                family: board.family("charuco")?,
                first: 0,
                upper_left: UpperLeft::Black,
            }
            .object(id),
            "aruco" => MarkerGrid {
                columns,
                rows,
                marker_m: board.marker_m()?,
                separation_m: metres(
                    "board_marker_separation_length",
                    board.board_marker_separation_length,
                )?,
                family: board.family("aruco")?,
                first: 0,
            }
            .object(id),
            other => {
                let cause = format!("there is no board `{other}`");
                return Err(wrong(
                    "board_type",
                    cause,
                    "known are charuco, aruco and checkerboard",
                ));
            }
        };
        object.map_err(|error| {
            wrong(
                "board_type",
                error.to_string(),
                "check sizes and lengths; anipose has millimetres",
            )
        })
    }
}

impl Calibration {
    fn square_m(&self) -> Result<f64, Complaint> {
        metres("board_square_side_length", self.board_square_side_length)
    }

    fn marker_m(&self) -> Result<f64, Complaint> {
        metres("board_marker_length", self.board_marker_length)
    }

    /// The family of a dictionary of so many markers of so many bits.
    fn family(&self, kind: &str) -> Result<Family, Complaint> {
        let bits = self
            .board_marker_bits
            .ok_or_else(|| missing("board_marker_bits"))?;
        let markers = self
            .board_marker_dict_number
            .ok_or_else(|| missing("board_marker_dict_number"))?;
        format!("{kind}{bits}x{bits}-{markers}")
            .parse()
            .map_err(|_| {
                let cause =
                    format!("there is no dictionary of {markers} markers of {bits} x {bits} bits");
                wrong(
                    "board_marker_bits",
                    cause,
                    "bits are 4 to 7, markers 50, 100, 250 or 1000",
                )
            })
    }
}

fn metres(key: &str, length_mm: Option<f64>) -> Result<f64, Complaint> {
    let length_mm = length_mm.ok_or_else(|| missing(key))?;
    Ok(length_mm * 1e-3)
}

fn missing(key: &str) -> Complaint {
    wrong(
        "board_type",
        format!("a board of this type needs `{key}`"),
        "add the key",
    )
}

fn wrong(key: &str, cause: String, remedy: &str) -> Complaint {
    Complaint::new(format!("calibration.{key}"), cause, remedy)
}
