//! The fusion machine as its users see it, on small scenes with exact truth.

#![allow(clippy::unwrap_used, reason = "a test that fails to unwrap has failed")]

mod ambiguity;
mod arm;
mod arm_scene;
mod bent;
mod changes;
mod clock_step;
mod clocks;
mod contradictions;
mod far_clocks;
mod faults;
mod floods;
mod health;
mod imperfect;
mod innocent;
mod lasting;
mod limits;
mod naming;
mod order;
mod prediction;
mod proposal;
mod restless;
mod scene;
mod shutter;
mod stamina;
mod standing;
mod states;
mod uncertainty;
