//! The calibration of one lens: a board of tags held before the camera in many ways, and what its corners say.
//!
//! A [`LensSession`] takes images one by one, says how well they cover the picture and where to hold the board next
//! ([`LensSession::progress`]), and solves ([`LensSession::solve`]): a first guess from homographies (Z. Zhang, A flexible new
//! technique for camera calibration, 2000), bundle adjustment over pinhole, Brown-Conrady and Kannala-Brandt lenses, the choice
//! among them by how well each foretells images that it was not fitted to, and a verdict in words. A set that cannot give a
//! lens is refused with its cause ([`LensRefusal`]).
//!
//! The board may be seen in part, wrong tags may be among the right ones, and the board's scale has no say: a board that is
//! enlarged as a whole gives the same lens. Pixels as everywhere, (0, 0) at the centre of the top left one.

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
