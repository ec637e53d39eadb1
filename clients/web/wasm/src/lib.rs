//! The detector and the encoder of its messages in a browser, as WebAssembly: what `clients/web/sextant.ts` calls.
//!
//! - [`vision`]: grey pixels to tags, poses, light and sharpness.
//! - [`messages`]: tags and statistics as payloads of the network's contract.
//! - [`abi`]: both as functions of numbers, for JavaScript.
//!
//! Knows no camera, no clock and no connection. Each module instance has one [`vision::Vision`]; workers have an
//! instance each.

pub mod abi;
pub mod messages;
pub mod vision;
