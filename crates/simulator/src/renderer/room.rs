//! The room around the objects: a table at height 0, a floor, walls, furniture and items. World frame, metres.
//!
//! Maps a ray to position, albedo and normal of the surface that it hits. Everything is static, and the same seed gives
//! every camera the same room.

use super::decals::Decal;
use super::texture::{lattice, noise};
use crate::random::{Random, key_of_name};
use crate::scenario::{Background, Scenario};
use nalgebra::{Point2, Point3, Vector2, Vector3};

const FLOOR_Z: f64 = -0.74;
const CEILING_Z: f64 = 2.0;
/// Half the edge lengths of the room in x and y.
const HALF_ROOM: [f64; 2] = [3.4, 2.9];
const TABLE_THICKNESS: f64 = 0.035;
const LEG: f64 = 0.05;
const PLANK: f64 = 0.16;
/// Items on the table and in the room at clutter 1.
const MAX_ON_TABLE: f64 = 11.0;
const MAX_ON_FLOOR: f64 = 9.0;
const MAX_ON_WALLS: f64 = 14.0;

/// The static background.
pub(super) enum Room {
    /// A uniform grey level.
    Plain { level: f64 },
    /// Table, floor and walls.
    Furnished(FurnishedRoom),
}

/// A room with items in it.
pub(super) struct FurnishedRoom {
    half_table: Vector2<f64>,
    on_table: Vec<Decal>,
    on_walls: [Vec<Decal>; 4],
    blocks: Vec<Block>,
}

/// An axis-aligned cuboid.
struct Block {
    min: Point3<f64>,
    max: Point3<f64>,
    albedo: f64,
}

/// The surface that a ray hits.
pub(super) struct RayHit {
    pub point: Point3<f64>,
    pub normal: Vector3<f64>,
    pub albedo: f64,
}

/// A ray with the reciprocals of its direction.
struct Ray {
    origin: Point3<f64>,
    direction: Vector3<f64>,
    reciprocal: Vector3<f64>,
}

impl Room {
    pub fn new(scenario: &Scenario) -> Self {
        match scenario.background {
            Background::Plain { level } => Self::Plain { level },
            Background::Room { table, clutter } => {
                let mut random = Random::from_keys(&[scenario.seed, key_of_name("room")]);
                Self::Furnished(FurnishedRoom::new(
                    Vector2::from(table) / 2.0,
                    clutter,
                    &mut random,
                ))
            }
        }
    }
}

impl FurnishedRoom {
    fn new(half_table: Vector2<f64>, clutter: f64, random: &mut Random) -> Self {
        let count = |most: f64| (most * clutter).round() as usize;
        let on_table = (0..count(MAX_ON_TABLE))
            .map(|_| Decal::on_table(random, half_table * 0.8))
            .collect();
        let on_wall = |random: &mut Random, half_length: f64| {
            let reach = Vector2::new(half_length * 0.85, 0.5);
            let n = count(MAX_ON_WALLS / 4.0);
            (0..n).map(|_| Decal::on_wall(random, reach)).collect()
        };
        let [x, y] = HALF_ROOM;
        let on_walls = [y, y, x, x].map(|half_length| on_wall(random, half_length));
        let mut blocks = table_blocks(&half_table);
        blocks.extend((0..count(MAX_ON_FLOOR)).map(|_| Block::on_floor(random)));
        Self {
            half_table,
            on_table,
            on_walls,
            blocks,
        }
    }

    /// First surface along a ray; `direction` has length 1.
    pub fn cast(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> RayHit {
        let ray = Ray::new(origin, direction);
        let hits = self
            .blocks
            .iter()
            .enumerate()
            .filter_map(|(i, block)| Some((ray.enters(block)?, i)));
        match hits.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((way, block)) => self.on_block(ray.at(way), block),
            None => self.on_shell(&ray),
        }
    }

    fn on_block(&self, point: Point3<f64>, index: usize) -> RayHit {
        let block = &self.blocks[index];
        let normal = block.normal_at(&point);
        let albedo = if index == 0 && normal.z > 0.5 {
            self.table_top(&point.xy())
        } else {
            block.albedo
                * (1.0 + 0.05 * noise(index as u32, point.x * 9.0 + point.z * 4.0, point.y * 9.0))
        };
        RayHit {
            point,
            normal,
            albedo,
        }
    }

    fn table_top(&self, point: &Point2<f64>) -> f64 {
        let lying = self
            .on_table
            .iter()
            .rev()
            .find_map(|decal| decal.albedo(point));
        lying.unwrap_or_else(|| {
            let edge = (self.half_table - point.coords.abs()).min();
            let grain = 0.05 * noise(1, point.x * 4.0, point.y * 90.0)
                + 0.05 * noise(2, point.x * 1.5, point.y * 14.0);
            let rim = if edge < 0.012 { -0.12 } else { 0.0 };
            0.58 + grain + rim
        })
    }

    /// Floor, walls and ceiling seen from inside.
    fn on_shell(&self, ray: &Ray) -> RayHit {
        let limits = Vector3::new(
            HALF_ROOM[0],
            HALF_ROOM[1],
            if ray.direction.z < 0.0 {
                FLOOR_Z
            } else {
                CEILING_Z
            },
        );
        let way = |axis: usize| {
            let limit = if axis < 2 {
                limits[axis].copysign(ray.direction[axis])
            } else {
                limits.z
            };
            let way = (limit - ray.origin[axis]) * ray.reciprocal[axis];
            if way > 0.0 { way } else { f64::INFINITY }
        };
        let ways = [way(0), way(1), way(2)];
        let axis = if ways[2] <= ways[0].min(ways[1]) {
            2
        } else {
            usize::from(ways[1] < ways[0])
        };
        let point = ray.at(ways[axis].min(1e3));
        let mut normal = Vector3::zeros();
        normal[axis] = -ray.direction[axis].signum();
        let albedo = match (axis, normal.z > 0.0) {
            (2, true) => floor(&point.xy()),
            (2, false) => 0.7,
            _ => self.wall(axis, normal[axis] > 0.0, &point),
        };
        RayHit {
            point,
            normal,
            albedo,
        }
    }

    fn wall(&self, axis: usize, far: bool, point: &Point3<f64>) -> f64 {
        let along = if axis == 0 { point.y } else { point.x };
        let place = Point2::new(along, point.z - 0.6);
        let hanging = self.on_walls[axis * 2 + usize::from(far)].iter().rev();
        let above_floor = point.z - FLOOR_Z;
        hanging
            .map(|decal| decal.albedo(&place))
            .find_map(|albedo| albedo)
            .unwrap_or({
                if above_floor < 0.09 {
                    0.85
                } else {
                    0.66 + 0.03 * noise(5, along * 2.0, point.z * 2.0)
                        + 0.015 * noise(6, along * 40.0, point.z * 40.0)
                }
            })
    }
}

/// Planks of unequal tone with dark joints.
fn floor(point: &Point2<f64>) -> f64 {
    let row = (point.y / PLANK).floor();
    let along = point.x / 1.1 + 0.37 * lattice(7, row as i32, 0);
    let plank = along.floor();
    let joint = (point.y / PLANK - row) < 0.025 || (along - plank) < 0.004;
    if joint {
        return 0.12;
    }
    let tone = 0.4 + 0.06 * lattice(8, row as i32, plank as i32);
    tone + 0.03 * noise(9 + row as u32, point.x * 5.0, point.y * 60.0)
}

/// Top first, then the legs.
fn table_blocks(half: &Vector2<f64>) -> Vec<Block> {
    let top = Block {
        min: Point3::new(-half.x, -half.y, -TABLE_THICKNESS),
        max: Point3::new(half.x, half.y, 0.0),
        albedo: 0.4,
    };
    let leg = |(sx, sy): (f64, f64)| {
        let (x, y) = (sx * (half.x - 2.0 * LEG), sy * (half.y - 2.0 * LEG));
        Block {
            min: Point3::new(x - LEG / 2.0, y - LEG / 2.0, FLOOR_Z),
            max: Point3::new(x + LEG / 2.0, y + LEG / 2.0, -TABLE_THICKNESS),
            albedo: 0.2,
        }
    };
    let legs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(leg);
    std::iter::once(top).chain(legs).collect()
}

impl Block {
    /// A crate or cabinet near the walls, away from the table and the cameras.
    fn on_floor(random: &mut Random) -> Self {
        let along_x = random.chance(0.5);
        let side = if random.chance(0.5) { 1.0 } else { -1.0 };
        let half = Vector2::new(random.between(0.15, 0.4), random.between(0.15, 0.35));
        let centre = if along_x {
            Vector2::new(random.between(-3.0, 3.0), side * (HALF_ROOM[1] - half.y))
        } else {
            Vector2::new(side * (HALF_ROOM[0] - half.x), random.between(-2.5, 2.5))
        };
        let (low, high) = (centre - half, centre + half);
        Self {
            min: Point3::new(low.x, low.y, FLOOR_Z),
            max: Point3::new(high.x, high.y, FLOOR_Z + random.between(0.25, 1.0)),
            albedo: random.between(0.12, 0.75),
        }
    }

    /// The face on which a point of the surface lies.
    fn normal_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        let mut nearest = (f64::INFINITY, Vector3::z());
        for axis in 0..3 {
            for (limit, sign) in [(self.min[axis], -1.0), (self.max[axis], 1.0)] {
                let distance = (point[axis] - limit).abs();
                if distance < nearest.0 {
                    nearest = (distance, Vector3::ith(axis, sign));
                }
            }
        }
        nearest.1
    }
}

impl Ray {
    fn new(origin: &Point3<f64>, direction: &Vector3<f64>) -> Self {
        // Zero components would make 0 / 0 below.
        let direction = direction.map(|d| if d.abs() < 1e-12 { 1e-12 } else { d });
        Self {
            origin: *origin,
            direction,
            reciprocal: direction.map(f64::recip),
        }
    }

    fn at(&self, way: f64) -> Point3<f64> {
        self.origin + self.direction * way
    }

    /// Distance at which the ray enters a block.
    fn enters(&self, block: &Block) -> Option<f64> {
        let to_min = (block.min - self.origin).component_mul(&self.reciprocal);
        let to_max = (block.max - self.origin).component_mul(&self.reciprocal);
        let enter = to_min.inf(&to_max).max();
        let leave = to_min.sup(&to_max).min();
        (enter > 0.0 && enter < leave).then_some(enter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_meets_something_of_the_room() {
        let mut random = Random::new(1);
        let room = FurnishedRoom::new(Vector2::new(0.7, 0.6), 1.0, &mut random);
        for _ in 0..10_000 {
            let origin = Point3::new(
                random.between(-3.0, 3.0),
                random.between(-2.5, 2.5),
                random.between(0.1, 1.9),
            );
            let direction = Vector3::from_fn(|_, _| random.normal()).normalize();
            let hit = room.cast(&origin, &direction);
            assert!((0.0..=1.0).contains(&hit.albedo));
            assert!(hit.normal.dot(&direction) <= 0.0);
            assert!(hit.point.coords.norm() < 10.0);
        }
    }

    #[test]
    fn table_lies_at_height_zero() {
        let room = FurnishedRoom::new(Vector2::new(0.7, 0.6), 0.5, &mut Random::new(1));
        let hit = room.cast(&Point3::new(0.1, 0.2, 1.0), &-Vector3::z());
        assert!(hit.point.z.abs() < 1e-12);
        assert_eq!(hit.normal, Vector3::z());
    }
}
