//! Zones: boxes and spheres of the world, as `zones.toml` and the clients write them, and how deep a point lies in one.

use nalgebra::{Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use sextant_proto::NodeId;
use sextant_site_files::Complaint;

/// Zones that a bridge keeps.
pub(crate) const MAX_ZONES: usize = 64;
/// Farthest coordinate and longest edge, m.
const FARTHEST_M: f64 = 1e5;
/// Shortest edge and radius, m.
const SMALLEST_M: f64 = 1e-3;

/// The file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ZonesFile {
    #[serde(default, rename = "zone")]
    pub(crate) zones: Vec<Zone>,
}

/// A part of the world with a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Zone {
    Box {
        name: String,
        /// Its middle in the world, m.
        centre: [f64; 3],
        /// Lengths of its edges, m.
        size: [f64; 3],
        /// By how much it is turned about the vertical axis, degrees.
        #[serde(default)]
        yaw_deg: f64,
    },
    Sphere {
        name: String,
        centre: [f64; 3],
        /// m.
        radius: f64,
    },
}

/// How a point lies to a zone's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Depth {
    /// Distance from the surface, m; negative outside.
    pub(crate) depth: f64,
    /// Unit vector of the world along which the depth grows fastest.
    pub(crate) inward: Vector3<f64>,
}

impl Zone {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Box { name, .. } | Self::Sphere { name, .. } => name,
        }
    }

    /// Checks names, ranges and finiteness.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        NodeId::new(self.name()).map_err(|error| Fault::new("name", error))?;
        let (centre, lengths, field) = match self {
            Self::Box { centre, size, .. } => (centre, size.to_vec(), "size"),
            Self::Sphere { centre, radius, .. } => (centre, vec![*radius], "radius"),
        };
        if !centre.iter().all(|value| value.abs() <= FARTHEST_M) {
            return Err(Fault::new(
                "centre",
                "three numbers within 100 km, in metres",
            ));
        }
        let is_length = |value: &f64| (SMALLEST_M..=FARTHEST_M).contains(value);
        if !lengths.iter().all(is_length) {
            return Err(Fault::new(field, "from 1 mm to 100 km, in metres"));
        }
        match self {
            Self::Box { yaw_deg, .. } if yaw_deg.is_nan() || yaw_deg.abs() > 360.0 => {
                Err(Fault::new("yaw_deg", "from -360 to 360 degrees"))
            }
            _ => Ok(()),
        }
    }

    /// How deep a point of the world lies in the zone.
    pub(crate) fn depth_of(&self, point: &Vector3<f64>) -> Depth {
        match self {
            Self::Sphere { centre, radius, .. } => {
                let from_centre = point - Vector3::from(*centre);
                let distance = from_centre.norm();
                Depth {
                    depth: radius - distance,
                    inward: -unit_or_up(&from_centre),
                }
            }
            Self::Box {
                centre,
                size,
                yaw_deg,
                ..
            } => {
                let world_from_box =
                    Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_deg.to_radians());
                let local = world_from_box.inverse() * (point - Vector3::from(*centre));
                let Depth { depth, inward } = depth_in_box(&local, &(Vector3::from(*size) / 2.0));
                Depth {
                    depth,
                    inward: world_from_box * inward,
                }
            }
        }
    }
}

/// Signed distance from a box about the origin.
fn depth_in_box(point: &Vector3<f64>, half: &Vector3<f64>) -> Depth {
    let beyond = point.abs() - half;
    let outside = beyond.map(|value| value.max(0.0));
    if outside.norm() > 0.0 {
        let away = outside.zip_map(point, f64::copysign);
        return Depth {
            depth: -outside.norm(),
            inward: -away.normalize(),
        };
    }
    let nearest = beyond.imax();
    let mut inward = Vector3::zeros();
    inward[nearest] = -1.0_f64.copysign(point[nearest]);
    Depth {
        depth: -beyond[nearest],
        inward,
    }
}

fn unit_or_up(vector: &Vector3<f64>) -> Vector3<f64> {
    vector.try_normalize(0.0).unwrap_or_else(Vector3::z)
}

/// What is wrong with a zone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) field: &'static str,
    pub(crate) cause: String,
}

impl Fault {
    fn new(field: &'static str, cause: impl std::fmt::Display) -> Self {
        Self {
            field,
            cause: format!("{field}: {cause}"),
        }
    }
}

impl ZonesFile {
    /// Checks every zone, and that no name is there twice.
    pub(crate) fn check(&self) -> Result<(), Complaint> {
        let at = |index: usize, field: &str, cause: String| {
            Complaint::new(format!("zone[{index}].{field}"), cause, "")
        };
        if self.zones.len() > MAX_ZONES {
            let cause = format!("more than {MAX_ZONES} zones");
            return Err(Complaint::new("zone", cause, "remove some"));
        }
        for (index, zone) in self.zones.iter().enumerate() {
            zone.check()
                .map_err(|fault| at(index, fault.field, fault.cause))?;
            if self.zones[..index]
                .iter()
                .any(|other| other.name() == zone.name())
            {
                let cause = format!("there is another zone \"{}\"", zone.name());
                return Err(at(index, "name", cause));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(yaw_deg: f64) -> Zone {
        Zone::Box {
            name: "dock".to_owned(),
            centre: [1.0, 0.0, 0.0],
            size: [2.0, 1.0, 1.0],
            yaw_deg,
        }
    }

    #[test]
    fn depth_is_the_distance_from_the_surface() {
        let ball = Zone::Sphere {
            name: "ball".to_owned(),
            centre: [0.0, 0.0, 1.0],
            radius: 0.5,
        };
        for (zone, point, expected) in [
            (&ball, [0.0, 0.0, 1.0], 0.5),
            (&ball, [0.0, 0.0, 0.0], -0.5),
            (&block(0.0), [1.0, 0.0, 0.0], 0.5),
            (&block(0.0), [1.9, 0.0, 0.0], 0.1),
            (&block(0.0), [3.0, 0.0, 0.0], -1.0),
            (&block(0.0), [5.0, 4.5, 0.0], -5.0),
            (&block(90.0), [1.0, 0.9, 0.0], 0.1),
        ] {
            let depth = zone.depth_of(&point.into()).depth;
            assert!((depth - expected).abs() < 1e-12, "{point:?}: {depth}");
        }
    }

    /// Against differences of the depth itself.
    #[test]
    fn the_inward_direction_is_the_gradient_of_the_depth() {
        let zone = block(30.0);
        for point in [
            [1.2, 0.3, 0.1],
            [2.4, 0.9, -0.2],
            [-1.0, 2.0, 3.0],
            [0.4, -0.1, 0.45],
        ] {
            let point = Vector3::from(point);
            let Depth { depth, inward } = zone.depth_of(&point);
            let ahead = zone.depth_of(&(point + inward * 1e-4)).depth;
            assert!((ahead - depth - 1e-4).abs() < 1e-9, "{point}");
        }
    }

    #[test]
    fn wrong_zones_are_refused_by_field() {
        let sphere = |name: &str, radius| Zone::Sphere {
            name: name.to_owned(),
            centre: [0.0; 3],
            radius,
        };
        for (zone, field) in [
            (sphere("The Dock", 1.0), "name"),
            (sphere("dock", 0.0), "radius"),
            (sphere("dock", f64::NAN), "radius"),
            (block(f64::INFINITY), "yaw_deg"),
        ] {
            assert_eq!(zone.check().unwrap_err().field, field);
        }
        let twice = ZonesFile {
            zones: vec![sphere("a", 1.0), sphere("a", 2.0)],
        };
        assert!(twice.check().is_err());
        assert!(block(30.0).check().is_ok());
    }
}
