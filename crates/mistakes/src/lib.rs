//! The mistakes that people make at a site, as hypotheses.
//!
//! No figure in a person's file is exact, and small errors of all of them are adjusted jointly. What people get wrong
//! is of another kind: a camera was moved by half a metre or turned, two names were exchanged, a print came out at
//! another scale, a tag was stuck on upside down. Explained as a small error of something else, each of them makes
//! poses wrong by centimetres.
//!
//! [`explain`] takes a [`NominalSite`] and what its cameras saw of bodies at some instants. Where views contradict the
//! site by more than small errors do, each [`Mistake`] is started in closed form (`starts`), the views are explained
//! anew with the values that are right if it was made (`explained`), and the mistake that explains them best is
//! named, unless another explains them nearly as well (`judgement`). Then the rest is looked at for a further one.

mod explained;
mod judgement;
mod mistake;
mod pose_fit;
mod screen;
mod site;
mod starts;

pub use judgement::{Explanation, Found, explain, recognise};
pub use mistake::Mistake;
pub use screen::{Screened, screen, squares_px};
pub use site::{Instant, NominalSite, SiteCamera, SiteTag, View};

#[cfg(test)]
mod tests;
