//! The fusion machine as its users see it, on small scenes with exact truth.

#![allow(clippy::unwrap_used, reason = "a test that fails to unwrap has failed")]

mod ambiguity;
mod arm;
mod arm_scene;
mod changes;
mod clock_step;
mod clocks;
mod contradictions;
mod distortion;
mod false_alarms;
mod far_clocks;
mod fault_naming;
mod fault_reports;
mod faults;
mod floods;
mod imperfect;
mod limits;
mod localisation;
mod misplaced_from_start;
mod order;
mod prediction;
mod process_noise;
mod proposal;
mod scene;
mod shutter;
mod stamina;
mod stated_sigmas;
mod states;
mod uncertainty;
