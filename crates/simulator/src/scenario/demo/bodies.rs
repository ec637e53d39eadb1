//! The objects of the demonstration: four kinds of bodies, none quite like the next, with a tag on most of their faces.

use crate::path::{Path, about};
use crate::random::Random;
use crate::scenario::{SceneObject, SceneTag, Solid};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_tag_families::Family;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Smallest and largest edge of a tag, m.
const TAG_SIZES: [f64; 2] = [0.04, 0.06];
/// A tag is turned in its face by up to this, besides whole quarter turns: people don't stick them on straight.
const CROOKED: f64 = 0.08;
/// The share of the room on a face that a print takes.
const FILL: f64 = 0.86;
/// A print's edge by its tag's size, tag36h11.
const PRINT_BY_SIZE: f64 = 10.0 / 8.0;

/// Where a tag may go: the middle of a face, its normal, a direction in it that is up, and the edge of the room there.
struct Place {
    centre: [f64; 3],
    normal: [f64; 3],
    up: [f64; 3],
    room: f64,
}

/// The object with this index on this path; its tags' numbers are still to be given.
pub(super) fn object(index: usize, path: Path, random: &mut Random) -> SceneObject {
    let albedo = random.between(0.25, 0.6);
    let scale = random.between(0.95, 1.03);
    let (name, body): (&str, fn(f64, f64) -> Body) = match index % 4 {
        0 => ("cuboid", cuboid),
        1 => ("prism", prism),
        2 => ("frustum", frustum),
        _ => ("bracket", bracket),
    };
    let (solids, places) = body(scale, albedo);
    let round = index / 4 + 1;
    SceneObject {
        id: if round == 1 {
            name.into()
        } else {
            format!("{name}-{round}")
        },
        solids,
        tags: places.iter().map(|place| tag(place, random)).collect(),
        path,
    }
}

type Body = (Vec<Solid>, Vec<Place>);

/// A box with six tags.
fn cuboid(scale: f64, albedo: f64) -> Body {
    let [x, y, z] = [0.104, 0.082, 0.09].map(|edge| edge * scale);
    (
        vec![boxed([x, y, z], [0.0; 3], albedo)],
        box_places([x, y, z], [0.0; 3], &[0, 1, 2, 3, 4, 5]),
    )
}

/// A six-sided column with tags on its sides and on top.
fn prism(scale: f64, albedo: f64) -> Body {
    let (radius, half) = (0.075 * scale, 0.041 * scale);
    let corner = |i: usize| {
        let angle = TAU * (i as f64 + 0.5) / 6.0;
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    };
    let polygon: Vec<[f64; 2]> = (0..6).map(corner).collect();
    let inner = radius * libm::cos(TAU / 12.0);
    let side = |i: usize| {
        let (sin, cos) = (
            libm::sin(TAU * i as f64 / 6.0),
            libm::cos(TAU * i as f64 / 6.0),
        );
        Place {
            centre: [inner * cos, inner * sin, 0.0],
            normal: [cos, sin, 0.0],
            up: [0.0, 0.0, 1.0],
            room: radius,
        }
    };
    let places = (0..6)
        .map(side)
        .chain([top_at([0.0, 0.0, half], 1.1 * radius)]);
    (
        vec![Solid::prism(&polygon, [-half, half], 1.0, albedo)],
        places.collect(),
    )
}

/// A pyramid without its top: four slanting sides, top and bottom.
fn frustum(scale: f64, albedo: f64) -> Body {
    let (half_base, half_height, taper) = (0.062 * scale, 0.04 * scale, 0.68);
    let square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
        .map(|c: [f64; 2]| c.map(|x| x * half_base));
    let half_top = half_base * taper;
    let slant = Vector3::new(half_base - half_top, 0.0, 2.0 * half_height).normalize();
    let side = |i: usize| {
        let turn = about(2, FRAC_PI_2 * i as f64);
        // A little below the middle, where the side is wider.
        let share = 0.47;
        let centre = Vector3::new(
            half_base + (half_top - half_base) * share,
            0.0,
            (2.0 * share - 1.0) * half_height,
        );
        Place {
            centre: (turn * centre).into(),
            normal: (turn * Vector3::new(slant.z, 0.0, slant.x)).into(),
            up: (turn * Vector3::new(-slant.x, 0.0, slant.z)).into(),
            room: 0.077 * scale,
        }
    };
    let bottom = Place {
        centre: [0.0, 0.0, -half_height],
        normal: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        room: 2.0 * half_base,
    };
    let ends = [top_at([0.0, 0.0, half_height], 2.0 * half_top), bottom];
    let solid = Solid::prism(&square, [-half_height, half_height], taper, albedo);
    (vec![solid], (0..4).map(side).chain(ends).collect())
}

/// An L of two boxes: a lying one, and one that stands on its end.
fn bracket(scale: f64, albedo: f64) -> Body {
    let edge = 0.076 * scale;
    let (lying, standing) = ([2.0 * edge, edge, edge], [edge; 3]);
    let (at_lying, at_standing) = ([0.0, 0.0, -edge / 2.0], [-edge / 2.0, 0.0, edge / 2.0]);
    let solids = vec![
        boxed(lying, at_lying, albedo),
        boxed(standing, at_standing, 0.85 * albedo),
    ];
    let free_end = Place {
        centre: [edge, 0.0, -edge / 2.0],
        normal: [1.0, 0.0, 0.0],
        up: [0.0, 0.0, 1.0],
        room: edge,
    };
    let mut places = vec![top_at([edge / 2.0, 0.0, 0.0], edge), free_end];
    places.extend(box_places(standing, at_standing, &[0, 1, 2, 3, 5]));
    (solids, places)
}

fn boxed(size: [f64; 3], centre: [f64; 3], albedo: f64) -> Solid {
    Solid::Box {
        size,
        object_from_box: Pose::translation(centre[0], centre[1], centre[2]),
        albedo,
    }
}

/// The middles of some faces of a box: -x, +x, -y, +y, -z, +z.
fn box_places(size: [f64; 3], centre: [f64; 3], faces: &[usize]) -> Vec<Place> {
    let place = |&face: &usize| {
        let (axis, sign) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
        let normal = Vector3::ith(axis, sign);
        let middle = Vector3::from(centre) + normal * (size[axis] / 2.0);
        Place {
            centre: middle.into(),
            normal: normal.into(),
            up: if axis == 2 {
                [0.0, 1.0, 0.0]
            } else {
                [0.0, 0.0, 1.0]
            },
            room: size[(axis + 1) % 3].min(size[(axis + 2) % 3]),
        }
    };
    faces.iter().map(place).collect()
}

fn top_at(centre: [f64; 3], room: f64) -> Place {
    Place {
        centre,
        normal: [0.0, 0.0, 1.0],
        up: [0.0, 1.0, 0.0],
        room,
    }
}

/// A tag in the middle of a place, turned a little, as large as fits.
fn tag(place: &Place, random: &mut Random) -> SceneTag {
    let normal = Vector3::from(place.normal);
    let up = Vector3::from(place.up);
    let axes =
        Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[up.cross(&normal), up, normal]));
    let spin = FRAC_PI_2 * random.below(4) as f64 + random.between(-CROOKED, CROOKED);
    let rotation = UnitQuaternion::from_rotation_matrix(&axes) * about(2, spin);
    let size = (place.room * FILL / PRINT_BY_SIZE).clamp(TAG_SIZES[0], TAG_SIZES[1]);
    // Whole millimetres, as printed.
    let size = (size * 1000.0).floor() / 1000.0;
    let centre = Translation3::from(Point3::from(place.centre).coords);
    let object_from_tag = Pose::from_parts(centre, rotation);
    SceneTag::new(Family::Tag36h11, 0, size, object_from_tag)
}
