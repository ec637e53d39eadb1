//! The procedures on simulated corners: what they reach, what they state, and what they say of broken inputs.

#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

#[path = "procedures/discovery.rs"]
mod discovery;
#[path = "procedures/learn.rs"]
mod learn;
#[path = "procedures/learn_faults.rs"]
mod learn_faults;
#[path = "procedures/rig.rs"]
mod rig;
#[path = "procedures/rig_faults.rs"]
mod rig_faults;
#[path = "procedures/scene.rs"]
mod scene;
#[path = "procedures/site.rs"]
mod site;
#[path = "procedures/site_errors.rs"]
mod site_errors;
#[path = "procedures/site_scene.rs"]
mod site_scene;
