//! Recorded poses and sites as files of other tools.
//!
//! - [`Animation`], [`AnimationBuilder`]: a recorded site as a scene over time; [`write_usda`] and [`glb`] write it as
//!   USD and glTF.
//! - [`c3d()`]: recorded poses for biomechanics.
//!
//! Input is what fusion reports: metres, x y z w, world with z up. Nothing here opens a file.

mod animation;
mod c3d;
mod gltf;
mod usd;

pub use animation::{Animation, AnimationBuilder, LeftOut, NoPoses};
pub use c3d::{C3dError, c3d};
pub use gltf::{TooManyPoses, glb};
pub use usd::write_usda;

/// The nearest finite `f32`.
fn narrowed(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}
