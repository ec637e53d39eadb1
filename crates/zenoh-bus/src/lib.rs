//! The site's network: typed publishers and subscribers over zenoh.
