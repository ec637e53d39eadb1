//! Why something cannot be printed.

use crate::Paper;
use sextant_calibrator::GridError;
use sextant_site_files::BoardError;
use sextant_site_model::{IdError, ObjectError};
use sextant_tag_families::{Board, Family};

/// Why something cannot be printed.
#[derive(Debug, thiserror::Error)]
pub enum SheetError {
    /// What is to be printed is larger than the paper allows, mm.
    #[error(
        "the {what} is {:.0} x {:.0} mm{}, but {} leaves {:.0} x {:.0} mm",
        size[0], size[1], with_white(what), paper.name(), room[0], room[1]
    )]
    TooLarge {
        /// "grid" of tags, or "board".
        what: &'static str,
        /// Width and height.
        size: [f64; 2],
        /// What the paper leaves of width and height.
        room: [f64; 2],
        /// The paper.
        paper: Paper,
    },
    /// A tag is larger than the paper allows, mm.
    #[error(
        "a tag of {edge:.0} mm with its white ring does not fit on {}, which leaves {:.0} x {:.0} mm",
        paper.name(), room[0], room[1]
    )]
    TagTooLarge {
        /// Edge with the white ring.
        edge: f64,
        /// What the paper leaves of width and height.
        room: [f64; 2],
        /// The paper.
        paper: Paper,
    },
    /// A tag is larger than the face of a cube, mm.
    #[error(
        "a tag is {printed:.1} mm wide with its white ring and does not fit on a face of {edge:.1} mm"
    )]
    FaceTooSmall {
        /// Edge of the tag with the white ring.
        printed: f64,
        /// Edge of the cube.
        edge: f64,
    },
    /// The net of a cube is larger than the paper.
    #[error("the net of this cube does not fit on {}", paper.name())]
    NetTooLarge {
        /// Largest edge of a cube, mm.
        largest: f64,
        /// The paper.
        paper: Paper,
    },
    /// A black square of an edge that no tag has, m.
    #[error(
        "{0} is no tag for this paper; it is the edge of the black square in metres, 0.005 to 0.3"
    )]
    Size(f64),
    /// A scale that no printer causes.
    #[error("{0:.3} times what was printed; it is the edge of a black square in metres")]
    Scale(f64),
    /// An id beyond those of the family.
    #[error("{family} has no tag {id}; its ids are 0 to {last}")]
    UnknownTag {
        /// The family.
        family: Family,
        /// The id.
        id: u32,
        /// The last id.
        last: usize,
    },
    /// Tags of a family that exists on boards only.
    #[error("tags of {family} are part of a board")]
    OfBoard {
        /// The family.
        family: Family,
        /// Its boards.
        board: Board,
    },
    /// A board that breaks a rule of its kind.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// A board of Sextant's own that breaks a rule.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Tags that make no object.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// A name that no object can have.
    #[error(transparent)]
    Id(#[from] IdError),
}

fn with_white(what: &str) -> &'static str {
    if what == "grid" {
        " with its white"
    } else {
        ""
    }
}
