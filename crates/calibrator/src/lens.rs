//! Calibration of one lens from images of a board of tags in various poses.
//!
//! A [`LensSession`] handles images one by one, reports coverage and where to hold the board next
//! ([`LensSession::progress`]), and solves ([`LensSession::solve`]): initial values from homographies (Z. Zhang, A
//! flexible new technique for camera calibration, 2000), bundle adjustment over pinhole, Brown-Conrady and
//! Kannala-Brandt lenses, the choice between them by cross-validation, and a verdict. Images that do not determine a
//! lens are refused with the cause ([`LensRefusal`]).
//!
//! The board may be partly visible, some tags may be wrong, and the board's scale has no effect: a board that is
//! enlarged as a whole gives the same lens. Pixel (0, 0) is the centre of the top left one.

mod adjust;
mod board;
mod calibration;
mod choice;
mod coverage;
mod fit;
mod hint;
mod homographies;
mod judgement;
mod maps;
mod poses;
mod refusal;
mod session;
mod sigma;
mod start;
mod view;

pub use calibration::LensCalibration;
pub use choice::ModelScore;
pub use coverage::{COLUMNS, ROWS};
pub use hint::{Hint, Place, Side};
pub use maps::{LensMaps, MapCell};
pub use refusal::LensRefusal;
pub use session::{LensOptions, LensProgress, LensSession, Selection, ViewOutcome};
pub(crate) use sigma::lens_sigma;

#[cfg(test)]
mod tests;
