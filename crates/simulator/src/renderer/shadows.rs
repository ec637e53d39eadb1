//! Shadows of objects on the table: darker patches of the background, softened by the width of the lamp.

use crate::model::Model;
use crate::polygon::{Polygon, convex_hull};
use crate::scenario::{Background, Scenario};
use crate::view::SolidsView;
use nalgebra::{Point2, Point3, Vector3};

/// Number of point lamps that approximate the lamp.
const LAMPS: usize = 4;
/// Half the width of the lamp as seen from the table, as a slope.
const LAMP_WIDTH: f64 = 0.04;
/// Least sine of the lamp's elevation at which shadows are cast.
const LOWEST: f64 = 0.2;

/// Casts shadows onto the table at height 0.
pub(super) struct Shadows {
    table: Polygon,
    towards_lamps: [Vector3<f64>; LAMPS],
    strength: f64,
}

/// A patch of the table that one of the lamps does not reach.
pub(super) struct Shadow {
    on_table: Polygon,
    /// Share of the light that is missing.
    pub strength: f64,
}

impl Shadow {
    /// Outline in the world frame.
    pub fn corners(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.on_table
            .corners()
            .iter()
            .map(|p| Point3::new(p.x, p.y, 0.0))
    }
}

impl Shadows {
    pub fn new(scenario: &Scenario) -> Self {
        let towards_lamp = Vector3::from(scenario.light.towards_lamp).normalize();
        let table = match scenario.background {
            Background::Room { table: [x, y], .. } if towards_lamp.z > LOWEST => {
                rectangle(x / 2.0, y / 2.0)
            }
            _ => Polygon::empty(),
        };
        let beside = |[x, y]: [f64; 2]| towards_lamp + Vector3::new(x, y, 0.0) * LAMP_WIDTH;
        Self {
            table,
            towards_lamps: [[1.0, 0.4], [-0.4, 1.0], [-1.0, -0.4], [0.4, -1.0]].map(beside),
            strength: scenario.light.shadow / LAMPS as f64,
        }
    }

    /// The shadows of an object, one per lamp: of the hull of its solids, so that overlapping solids darken the table
    /// only once.
    pub fn cast<'a>(
        &'a self,
        object: usize,
        model: &'a Model,
        view: &'a SolidsView,
    ) -> impl Iterator<Item = Shadow> + 'a {
        let wanted = !self.table.corners().is_empty() && self.strength > 0.0;
        let lamps = self.towards_lamps.iter().filter(move |_| wanted);
        lamps.map(move |lamp| {
            let mut cast = Polygon::empty();
            for vertex in vertices_of(object, model, view) {
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

/// Corners of an object's solids in the world frame.
fn vertices_of<'a>(
    object: usize,
    model: &'a Model,
    view: &'a SolidsView,
) -> impl Iterator<Item = Point3<f64>> + 'a {
    let solids = model.solids.iter().zip(&view.solids);
    let of_object = solids.filter(move |(solid, _)| solid.object == object);
    of_object
        .flat_map(|(solid, placed)| solid.vertices.iter().map(|v| placed.world_from_object * v))
}

fn rectangle(x: f64, y: f64) -> Polygon {
    let corner = |sx: f64, sy: f64| Point2::new(sx * x, sy * y);
    convex_hull(&mut [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ])
}
