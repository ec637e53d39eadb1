//! Free-D (Vinten Radamec, message D1), the pose of a camera for virtual studios: 29 bytes of fixed-point numbers,
//! big-endian.
//!
//! X is to the right, y forward, z up. Pan 0 looks along y; it grows to the right, tilt upwards, roll clockwise as the
//! camera sees it. Of an object Sextant's x is the optical axis, y is left and z up; of the world likewise.

use sextant_proto::ObjectPose;

const POSITION: u8 = 0xd1;
const CHECKSUM_OF: u8 = 0x40;
const STEPS_PER_DEGREE: f64 = 32_768.0;
const STEPS_PER_METRE: f64 = 64_000.0;

/// What a message says beside the pose.
#[derive(Debug, Clone, Copy)]
pub struct FreeDCamera {
    /// Number of the camera.
    pub id: u8,
    /// Raw numbers of the lens, 24 bits each.
    pub zoom: u32,
    /// As `zoom`.
    pub focus: u32,
}

/// The message D1 of a camera.
#[must_use]
pub fn freed_position(pose: &ObjectPose, camera: &FreeDCamera) -> [u8; 29] {
    let [forward, left, up] = pose.position;
    let angles = camera_angles_deg(pose).map(|angle| steps(angle * STEPS_PER_DEGREE));
    let places = [-left, forward, up].map(|place| steps(place * STEPS_PER_METRE));
    let lens = [camera.zoom, camera.focus].map(|raw| raw.min(0xff_ffff) as i32);
    let numbers = angles.into_iter().chain(places).chain(lens);
    let mut message = [0; 29];
    message[..2].copy_from_slice(&[POSITION, camera.id]);
    for (place, number) in message[2..26].chunks_exact_mut(3).zip(numbers) {
        place.copy_from_slice(&number.to_be_bytes()[1..]);
    }
    let sum = message
        .iter()
        .fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    message[28] = CHECKSUM_OF.wrapping_sub(sum);
    message
}

/// Pan to the right, tilt upwards and roll clockwise of a camera whose optical axis is the object's x axis, degrees.
pub(crate) fn camera_angles_deg(pose: &ObjectPose) -> [f64; 3] {
    let rotation = pose.world_from_object().rotation.to_rotation_matrix();
    let r = rotation.matrix();
    let pan = (-r[(1, 0)]).atan2(r[(0, 0)]);
    let tilt = r[(2, 0)].clamp(-1.0, 1.0).asin();
    let roll = r[(2, 1)].atan2(r[(2, 2)]);
    [pan, tilt, roll].map(f64::to_degrees)
}

/// The nearest number of 24 bits.
fn steps(value: f64) -> i32 {
    value.round().clamp(-8_388_608.0, 8_388_607.0) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};
    use sextant_site_model::ObjectId;
    use sextant_site_report::State;

    fn message(rotation: UnitQuaternion<f64>, position: [f64; 3]) -> [i32; 8] {
        let q = rotation.quaternion();
        let pose = ObjectPose {
            object: ObjectId::new("camera").unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 1,
            published_ns: 1,
            state: State::Tracking,
            position,
            orientation: [q.i, q.j, q.k, q.w],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        };
        let camera = FreeDCamera {
            id: 7,
            zoom: 0x12_3456,
            focus: u32::MAX,
        };
        let bytes = freed_position(&pose, &camera);
        assert_eq!(bytes[..2], [0xd1, 7]);
        let sum = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        assert_eq!(sum, 0x40);
        std::array::from_fn(|n| {
            let at = 2 + 3 * n;
            i32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0]) >> 8
        })
    }

    fn about(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::new(axis * degrees.to_radians())
    }

    #[test]
    fn right_up_and_clockwise_are_positive() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let degree = 32_768;
        // Right by 30, then up by 20, then clockwise by 10 degrees.
        let rotation = about(z, -30.0) * about(y, -20.0) * about(x, 10.0);
        let numbers = message(rotation, [2.0, -1.0, 0.5]);
        assert_eq!(numbers[..3], [30 * degree, 20 * degree, 10 * degree]);
        assert_eq!(numbers[3..6], [64_000, 128_000, 32_000]);
        assert_eq!(numbers[6..], [0x12_3456, -1]);
    }

    #[test]
    fn places_beyond_the_range_end_at_it() {
        let numbers = message(UnitQuaternion::identity(), [1e6, 1e6, -0.5]);
        assert_eq!(numbers[3..6], [-8_388_608, 8_388_607, -32_000]);
    }
}
