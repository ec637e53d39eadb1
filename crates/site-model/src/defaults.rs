//! Standard deviations of what no file states, each written once: for fusion, self-calibration, diagnosis and every
//! calibration. They reflect how such a number usually comes about. docs/models.md shows [`default_sigmas`].

use sextant_geometry::Lens;

use crate::{LensSigma, PoseSigma};

/// Of the size of a tag, and of the scale that the tags of an object share, as a share of it: printers scale by some
/// tenths of a per cent.
pub const SIZE_SIGMA: f64 = 0.005;
/// Of the scale of a print that images show to be another than its file says, as a share of it: tags are off their
/// places as well.
pub const MISPRINT_SIGMA: f64 = 0.03;
/// Of a focal length that was calibrated on another day, as a share of it.
pub const FOCAL_SIGMA: f64 = 0.003;
/// The same where no other camera checks it.
pub const UNCHECKED_FOCAL_SIGMA: f64 = 0.005;
/// Of each coordinate of the principal point, as a share of the image's width.
pub const CENTRE_SIGMA: f64 = 0.003;
/// Of a distortion, by how far it moves the corners of the image, as a share of the image's width.
pub const DISTORTION_SIGMA: f64 = 0.001;
/// Of the focal length of a lens of which nothing is known, about an estimate from single tags, as a share of it.
pub const UNKNOWN_FOCAL_SIGMA: f64 = 0.3;
/// Of its principal point about the middle of the image, as a share of the image's width.
pub const UNKNOWN_CENTRE_SIGMA: f64 = 0.03;
/// Of its radial distortions, by how far they move the corners of the image, as a share of the image's width.
pub const UNKNOWN_RADIAL_SIGMA: f64 = 0.1;
/// The same of its tangential distortions.
pub const UNKNOWN_TANGENTIAL_SIGMA: f64 = 0.005;
/// Of the offset of a clock, s: clocks of one computer differ by how long cameras take, those of several by how well
/// the network keeps them together.
pub const CLOCK_SIGMA_S: f64 = 0.03;
/// Of the time that a camera takes to read an image out, s.
pub const READOUT_SIGMA_S: f64 = 0.02;
/// How far a board is bent, as a share of its length: paper on a plate, 0.3 to 1 mm on 0.2 to 0.4 m.
pub const BEND_SIGMA: f64 = 0.002;

impl PoseSigma {
    /// Default for a camera that was placed by hand.
    pub const OF_CAMERA: Self = Self {
        position_m: 0.01,
        orientation_rad: 0.01,
    };
    /// Default for a tag that was glued on by hand.
    pub const OF_TAG: Self = Self {
        position_m: 0.001,
        orientation_rad: 0.017,
    };
    /// Default for a tag of a printed board, within its plane.
    pub const OF_PRINT: Self = Self {
        position_m: 0.0001,
        orientation_rad: 0.001,
    };
    /// Default for the pose of a robot's hand.
    pub const OF_HAND: Self = Self {
        position_m: 0.001,
        orientation_rad: 0.002,
    };
}

impl LensSigma {
    /// Default for a lens that was calibrated on another day; `is_checked` says whether another camera checks it.
    pub fn usual(lens: &Lens, is_checked: bool) -> Self {
        let numbers = lens.intrinsics();
        let share = match is_checked {
            true => FOCAL_SIGMA,
            false => UNCHECKED_FOCAL_SIGMA,
        };
        let is_bending = !lens.distortion().is_empty();
        Self {
            focal_px: share * numbers.fx,
            distortion_px: match is_bending {
                true => DISTORTION_SIGMA * 2.0 * numbers.cx,
                false => 0.0,
            },
        }
    }
}

/// A row of the table of default standard deviations.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DefaultSigma {
    /// The number, as files call it.
    pub number: &'static str,
    /// Its standard deviation with its unit.
    pub sigma: String,
    /// How such a number comes about.
    pub as_if: &'static str,
}

impl DefaultSigma {
    fn new(number: &'static str, sigma: String, as_if: &'static str) -> Self {
        Self {
            number,
            sigma,
            as_if,
        }
    }
}

/// All defaults, as docs/models.md shows them.
pub fn default_sigmas() -> Vec<DefaultSigma> {
    let camera = DefaultSigma::new(
        "`world_from_camera`",
        pose_text(PoseSigma::OF_CAMERA),
        "measured by hand",
    );
    let rows = [camera].into_iter();
    let rows = rows.chain(lenses()).chain(objects());
    rows.chain(times_and_robots()).collect()
}

fn lenses() -> [DefaultSigma; 5] {
    let other_day = "calibrated on another day";
    let unknown = format!(
        "{} of the focal length; of the image's width {} for the principal point, {} in its corners for radial and {} \
         in its corners for tangential distortion",
        per_cent(UNKNOWN_FOCAL_SIGMA),
        per_cent(UNKNOWN_CENTRE_SIGMA),
        per_cent(UNKNOWN_RADIAL_SIGMA),
        per_cent(UNKNOWN_TANGENTIAL_SIGMA),
    );
    let distortion = per_cent(DISTORTION_SIGMA);
    [
        DefaultSigma::new("`lens`: focal length", per_cent(FOCAL_SIGMA), other_day),
        DefaultSigma::new(
            "`lens`: focal length of a single camera",
            per_cent(UNCHECKED_FOCAL_SIGMA),
            "the same, and nothing checks it",
        ),
        DefaultSigma::new(
            "`lens`: principal point",
            format!("{} of the image's width", per_cent(CENTRE_SIGMA)),
            "calibrated on another day; to fusion a part of the camera's pose",
        ),
        DefaultSigma::new(
            "`lens`: distortion",
            format!("{distortion} of the image's width, in the image's corners"),
            other_day,
        ),
        DefaultSigma::new(
            "`lens` that no file has",
            unknown,
            "estimated from single tags",
        ),
    ]
}

fn objects() -> [DefaultSigma; 5] {
    let (print, bend) = (pose_text(PoseSigma::OF_PRINT), per_cent(BEND_SIGMA));
    [
        DefaultSigma::new(
            "`object_from_tag`",
            pose_text(PoseSigma::OF_TAG),
            "glued on by hand",
        ),
        DefaultSigma::new(
            "tag of a calibration board",
            format!("{print}; {bend} of the board's length across it"),
            "printed on one sheet, on a plate",
        ),
        DefaultSigma::new("`size`", per_cent(SIZE_SIGMA), "printed"),
        DefaultSigma::new(
            "`scale_sigma` of an object",
            per_cent(SIZE_SIGMA),
            "printed at once",
        ),
        DefaultSigma::new(
            "the same where images show another scale",
            per_cent(MISPRINT_SIGMA),
            "printed to fit a page",
        ),
    ]
}

fn times_and_robots() -> [DefaultSigma; 3] {
    let milliseconds = |seconds: f64| format!("{} ms", seconds * 1e3);
    [
        DefaultSigma::new(
            "clock of a camera",
            milliseconds(CLOCK_SIGMA_S),
            "kept by a network, or not at all",
        ),
        DefaultSigma::new(
            "readout of an image, without `line_delay`",
            milliseconds(READOUT_SIGMA_S),
            "a rolling shutter of unknown kind",
        ),
        DefaultSigma::new(
            "pose of a robot's hand",
            pose_text(PoseSigma::OF_HAND),
            "reported by its controller",
        ),
    ]
}

fn pose_text(sigma: PoseSigma) -> String {
    let (position, orientation) = (sigma.position_m * 1e3, sigma.orientation_rad * 1e3);
    format!("{position} mm, {orientation} mrad")
}

fn per_cent(share: f64) -> String {
    format!("{} %", (share * 1e6).round() / 1e4)
}
