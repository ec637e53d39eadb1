//! Reasons why images do not determine a lens.

use sextant_site_model::TagId;
use thiserror::Error;

/// Why a lens is not calibrated, with a remedy.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LensRefusal {
    /// The board file has no pose of a tag.
    #[error(
        "the board does not say where its tag {tag} sits; print one with `sextant print board` \
         and give the file written with it"
    )]
    Unplaced {
        /// The tag.
        tag: TagId,
    },
    /// A tag whose centre is outside the given resolution.
    #[error(
        "a tag lies at ({x:.0}, {y:.0}), outside of {width} x {height} pixels: the images have \
         another resolution; give it"
    )]
    Resolution {
        /// Column of its centre.
        x: f64,
        /// Row of its centre.
        y: f64,
        /// Given width.
        width: u32,
        /// Given height.
        height: u32,
    },
    /// No image shows the board.
    #[error(
        "none of {images} images shows a tag of the board{}; check family, ids, focus and light",
        others(foreign)
    )]
    NoBoard {
        /// Number of images.
        images: usize,
        /// Other tags that they show.
        foreign: Vec<TagId>,
    },
    /// Too few images show enough of it.
    #[error(
        "only {views} of {images} images show two tags or more of the board; at least {needed} \
         are needed, 30 in many places and tilts are good"
    )]
    TooFew {
        /// Images with enough of the board.
        views: usize,
        /// Number of images.
        images: usize,
        /// Required number.
        needed: usize,
    },
    /// No tilted view: focal length and distance cannot be separated.
    #[error(
        "the board is seen from the front only (tilted by {tilt_deg:.0} degrees at most), so \
         that focal length and distance cannot be separated (it is uncertain by \
         {sigma_percent:.1} %); tilt the board by 30 degrees and more, in every direction"
    )]
    OnlyFrontal {
        /// Largest tilt of all but a tenth of the images.
        tilt_deg: f64,
        /// One standard deviation of the focal length in percent of it.
        sigma_percent: f64,
    },
    /// The lens is poorly determined for another reason.
    #[error(
        "the images do not determine the lens: its focal length is uncertain by \
         {sigma_percent:.1} %; add images near the edges of the picture and with the board tilted"
    )]
    Undetermined {
        /// One standard deviation of the focal length in percent of it.
        sigma_percent: f64,
    },
    /// No lens and no poses explain the corners.
    #[error(
        "no lens explains the corners: {wrong_percent:.0} % of the tags lie elsewhere than the \
         board says; is this the board that was printed, flat and whole?"
    )]
    Unexplained {
        /// Tags that do not fit, percent.
        wrong_percent: f64,
    },
    /// Sizes of tags and distances between them contradict each other.
    #[error(
        "the board's sizes contradict each other: its black squares look {percent:+.1} % larger \
         than the file says, measured by the distances between them; measure a square and the \
         distance of two, and correct the file"
    )]
    Sizes {
        /// How much larger the squares look, percent.
        percent: f64,
    },
}

fn others(foreign: &[TagId]) -> String {
    if foreign.is_empty() {
        return String::new();
    }
    let named: Vec<String> = foreign.iter().take(5).map(ToString::to_string).collect();
    format!(" (they show {})", named.join(", "))
}
