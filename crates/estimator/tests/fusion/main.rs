//! The fusion machine as its users see it, on small scenes with exact truth.

mod ambiguity;
mod changes;
mod clocks;
mod faults;
mod order;
mod scene;
mod states;
mod uncertainty;
