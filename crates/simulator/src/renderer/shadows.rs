//! Shadows that objects cast on the table: darker patches of the backdrop, softened by a lamp of some width.

use crate::model::SolidModel;
use crate::polygon::{Polygon, convex_hull};
use crate::scenario::{Background, Scenario};
use crate::view::PlacedSolid;
use nalgebra::{Point2, Point3, Vector3};

/// The lamp is drawn as this many small ones.
const LAMPS: usize = 3;
/// Half the width of the lamp as seen from the table, as a slope.
const LAMP_WIDTH: f64 = 0.05;
/// A lamp lower than this (sine of its height) casts no shadow.
const LOWEST: f64 = 0.2;

/// Casts shadows on the table at height 0.
pub(super) struct Shadows {
    table: Polygon,
    towards_lamps: [Vector3<f64>; LAMPS],
    strength: f64,
}

/// A patch of the table that one of the lamps doesn't reach.
pub(super) struct Shadow {
    on_table: Polygon,
    /// The share of the light that is missing.
    pub strength: f64,
}

impl Shadow {
    /// In the world.
    pub fn corners(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.on_table.corners().iter().map(|p| Point3::new(p.x, p.y, 0.0))
    }
}

impl Shadows {
    pub fn new(scenario: &Scenario) -> Self {
        let towards_lamp = Vector3::from(scenario.light.towards_lamp).normalize();
        let table = match scenario.background {
            Background::Room { table: [x, y], .. } if towards_lamp.z > LOWEST => rectangle(x / 2.0, y / 2.0),
            _ => Polygon::empty(),
        };
        let beside = |[x, y]: [f64; 2]| towards_lamp + Vector3::new(x, y, 0.0) * LAMP_WIDTH;
        Self {
            table,
            towards_lamps: [[1.0, 0.0], [-0.5, 0.87], [-0.5, -0.87]].map(beside),
            strength: scenario.light.shadow / LAMPS as f64,
        }
    }

    /// The shadows of a solid, one a lamp.
    pub fn of(&self, solid: &SolidModel, placed: &PlacedSolid) -> impl Iterator<Item = Shadow> {
        let wanted = !self.table.corners().is_empty() && self.strength > 0.0;
        let lamps = self.towards_lamps.iter().filter(move |_| wanted);
        lamps.map(move |lamp| {
            let mut cast = Polygon::empty();
            for vertex in &solid.vertices {
                let vertex = placed.world_from_object * vertex;
                let foot = vertex - lamp * (vertex.z.max(0.0) / lamp.z);
                cast.push(foot.xy());
            }
            Shadow {
                on_table: convex_hull(cast.corners_mut()).clipped(&self.table),
                strength: self.strength,
            }
        })
    }
}

fn rectangle(x: f64, y: f64) -> Polygon {
    let corner = |sx: f64, sy: f64| Point2::new(sx * x, sy * y);
    convex_hull(&mut [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}
