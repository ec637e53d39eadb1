//! Changes of the site that people ask for on the page: made from what is in force, published as the command line does,
//! and answered by the fusion node that publishes the poses.

pub(crate) mod edit;
mod offers;
mod publication;

pub(crate) use offers::{Offer, Offers};
pub(crate) use publication::{Answered, Outgoing, Publication};
