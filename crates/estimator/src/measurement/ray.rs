//! Rays from cameras into the world.

use nalgebra::Vector3;

/// From a camera's centre through a point of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    pub origin: Vector3<f64>,
    /// A unit vector.
    pub direction: Vector3<f64>,
}

impl Ray {
    /// Distance of a point before the camera from the ray, in metres.
    pub fn distance(&self, point: &Vector3<f64>) -> Option<f64> {
        let arm = point - self.origin;
        let along = arm.dot(&self.direction);
        (along > 0.0).then(|| (arm - self.direction * along).norm())
    }
}
