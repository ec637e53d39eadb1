//! The objects of a scenario made ready for pictures: faces with planes, and what each tag prints on its face.
//!
//! Made once from a valid scenario; object frames, metres. Light is not known here: prints are steps of albedo.

use crate::path::Path;
use crate::polygon::{Polygon, convex_hull};
use crate::scenario::{Displacement, Face, Scenario, SceneObject, SceneTag, Solid};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use sextant_geometry::Pose;
use sextant_tag_families::{BorderColour, Family, module_is_white};

/// Share of the light that white paper sends back.
pub(crate) const PAPER: f64 = 0.9;
/// Share of the light that printer's black sends back.
pub(crate) const INK: f64 = 0.06;
/// Flat strips of which a bent sheet is made: each is off the cylinder by the sagitta / STRIPS^2, 8 um of 2 mm.
const STRIPS: usize = 16;

/// All solids of all objects.
pub(crate) struct Model {
    pub paths: Vec<Path>,
    pub solids: Vec<SolidModel>,
}

/// A convex solid with its prints.
pub(crate) struct SolidModel {
    /// Index of its object in the scenario.
    pub object: usize,
    pub vertices: Vec<Point3<f64>>,
    pub faces: Vec<Face>,
    pub albedo: f64,
    pub prints: Vec<Print>,
}

/// A tag on a face.
pub(crate) struct Print {
    /// Index of the tag in its object.
    pub tag: usize,
    /// Index of the face in its solid.
    pub face: usize,
    /// Whether the sheet lies in the face as its file says; else it may jut out, and what does is cut off.
    pub is_flush: bool,
    /// In the order of printing: the whole sheet first.
    pub areas: Vec<Area>,
}

/// A convex part of a print; it changes the albedo of what lies below it by `step`.
pub(crate) struct Area {
    pub corners: Vec<Point3<f64>>,
    pub step: f64,
    /// Of an area that isn't in the face's plane.
    pub facet: Option<Facet>,
}

/// The plane of a strip of bent paper.
#[derive(Clone, Copy)]
pub(crate) struct Facet {
    /// Unit vector out of the paper, in the object's frame.
    pub normal: Vector3<f64>,
    /// Albedo of the face that the area covers: 0 for ink, which covers paper of its own strip.
    pub face_albedo: f64,
}

impl Model {
    pub fn new(scenario: &Scenario) -> Self {
        let objects = scenario.objects.iter().enumerate();
        Self {
            paths: scenario
                .objects
                .iter()
                .map(|object| object.path.clone())
                .collect(),
            solids: objects
                .flat_map(|(index, object)| solids_of(index, object))
                .collect(),
        }
    }
}

fn solids_of(index: usize, object: &SceneObject) -> Vec<SolidModel> {
    let mut solids: Vec<SolidModel> = object
        .solids
        .iter()
        .map(|solid| SolidModel::new(index, solid))
        .collect();
    for (tag_index, tag) in object.tags.iter().enumerate() {
        if let Some((solid, face)) = object.face_of(tag) {
            let areas = areas_of(tag, solids[solid].albedo);
            solids[solid].prints.push(Print {
                tag: tag_index,
                face,
                is_flush: tag.curl.sagitta == 0.0 && tag.glue_error == Displacement::default(),
                areas,
            });
        }
    }
    solids
}

impl SolidModel {
    fn new(object: usize, solid: &Solid) -> Self {
        Self {
            object,
            vertices: solid.vertices(),
            faces: solid.faces(),
            albedo: solid.albedo(),
            prints: Vec::new(),
        }
    }
}

/// A rectangle of modules: columns and rows from `start` up to and without `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Modules {
    start: [usize; 2],
    end: [usize; 2],
}

/// The sheet, the black square where the family has one, and every module that is unlike what lies below it.
fn areas_of(tag: &SceneTag, albedo_below: f64) -> Vec<Area> {
    let data = tag.family.data();
    let (total, margin) = (usize::from(data.total_width), data.margin() as usize);
    let square = Modules {
        start: [margin; 2],
        end: [margin + usize::from(data.border_width); 2],
    };
    let sheet = Modules {
        start: [0; 2],
        end: [total; 2],
    };
    let black_square = matches!(data.border, BorderColour::Black);
    let mut areas = area(tag, sheet, PAPER - albedo_below, albedo_below);
    if black_square {
        areas.extend(area(tag, square, INK - PAPER, 0.0));
    }
    let base_is_white = |x, y| !(black_square && square.holds(x, y));
    for run in runs(tag.family, tag.id, total, base_is_white) {
        let white = module_is_white(tag.family, tag.id, run.start[0], run.start[1]);
        let step = if white { PAPER - INK } else { INK - PAPER };
        areas.extend(area(tag, run, step, 0.0));
    }
    areas
}

impl Modules {
    fn holds(&self, x: usize, y: usize) -> bool {
        (self.start[0]..self.end[0]).contains(&x) && (self.start[1]..self.end[1]).contains(&y)
    }
}

/// Runs of modules in a row that differ from their base and are alike among themselves.
fn runs(
    family: Family,
    id: u32,
    total: usize,
    base_is_white: impl Fn(usize, usize) -> bool,
) -> Vec<Modules> {
    let mut runs: Vec<Modules> = Vec::new();
    for y in 0..total {
        for x in 0..total {
            let white = module_is_white(family, id, x, y);
            if white == base_is_white(x, y) {
                continue;
            }
            match runs.last_mut() {
                Some(run)
                    if run.start[1] == y
                        && run.end[0] == x
                        && module_is_white(family, id, run.start[0], y) == white =>
                {
                    run.end[0] = x + 1;
                }
                _ => runs.push(Modules {
                    start: [x, y],
                    end: [x + 1, y + 1],
                }),
            }
        }
    }
    runs
}

/// A rectangle of modules: one area where the sheet is flat, one a strip where it is bent.
fn area(tag: &SceneTag, modules: Modules, step: f64, face_albedo: f64) -> Vec<Area> {
    let data = tag.family.data();
    let module = tag.true_size() / f64::from(data.border_width);
    let half = f64::from(data.total_width) / 2.0;
    // Modules run right and down, the tag frame right and up.
    let corner = |x: usize, y: usize| [(x as f64 - half) * module, (half - y as f64) * module];
    let Modules {
        start: [left, top],
        end: [right, bottom],
    } = modules;
    let corners = [
        corner(left, top),
        corner(right, top),
        corner(right, bottom),
        corner(left, bottom),
    ];
    if tag.curl.sagitta != 0.0 {
        return bent(tag, &corners.map(Point2::from), step, face_albedo);
    }
    let object_from_tag = tag.true_object_from_tag();
    let in_object = corners.map(|[x, y]| object_from_tag * Point3::new(x, y, 0.0));
    vec![Area {
        corners: in_object.to_vec(),
        step,
        facet: None,
    }]
}

/// The strips of a rectangle of bent paper.
fn bent(tag: &SceneTag, corners: &[Point2<f64>; 4], step: f64, face_albedo: f64) -> Vec<Area> {
    let edge = tag.printed_size();
    let half = tag.curl.half_width(edge);
    let along = Vector2::new(libm::cos(tag.curl.direction), libm::sin(tag.curl.direction));
    let across = Vector2::new(-along.y, along.x);
    let flat = convex_hull(&mut corners.clone());
    let strip = |index: usize| {
        let border = |i: usize| (2.0 * i as f64 / STRIPS as f64 - 1.0) * half;
        let (start, end) = (border(index), border(index + 1));
        let window = |u: f64, v: f64| Point2::from(along * u + across * v);
        let mut window =
            [(start, -edge), (end, -edge), (end, edge), (start, edge)].map(|(u, v)| window(u, v));
        let part = flat.clipped(&convex_hull(&mut window));
        let on_arc = |u: f64, v: f64| tag.sheet_point((along * u + across * v).into());
        let in_object = |corner: &Point2<f64>| {
            let (u, v) = (corner.coords.dot(&along), corner.coords.dot(&across));
            let share = (u - start) / (end - start);
            let from = on_arc(start, v);
            from + (on_arc(end, v) - from) * share
        };
        let normal = (on_arc(end, 0.0) - on_arc(start, 0.0))
            .cross(&(on_arc(start, edge) - on_arc(start, 0.0)));
        strip_area(
            &part,
            in_object,
            step,
            Facet {
                normal: normal.normalize(),
                face_albedo,
            },
        )
    };
    (0..STRIPS).filter_map(strip).collect()
}

fn strip_area(
    part: &Polygon,
    in_object: impl Fn(&Point2<f64>) -> Point3<f64>,
    step: f64,
    facet: Facet,
) -> Option<Area> {
    (part.area() > 0.0).then(|| Area {
        corners: part.corners().iter().map(in_object).collect(),
        step,
        facet: Some(facet),
    })
}

/// Light on a surface with this normal (world axes): ambient plus the lamp by Lambert's law.
pub(crate) fn light_on(
    light: &crate::scenario::Light,
    world_from_object: &Pose,
    normal: &Vector3<f64>,
) -> f64 {
    let towards_lamp = Vector3::from(light.towards_lamp).normalize();
    let facing = (world_from_object.rotation * normal).dot(&towards_lamp);
    light.ambient + light.lamp * facing.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_a_tag_add_up_to_its_picture() {
        for family in Family::ALL {
            let tag = SceneTag::new(family, 5, 0.08, Pose::identity());
            let areas = areas_of(&tag, 0.4);
            let data = family.data();
            let total = usize::from(data.total_width);
            for y in 0..total {
                for x in 0..total {
                    let centre = area(
                        &tag,
                        Modules {
                            start: [x, y],
                            end: [x + 1, y + 1],
                        },
                        0.0,
                        0.0,
                    );
                    let centre = &centre[0].corners;
                    let centre = nalgebra::center(&centre[0], &centre[2]);
                    let inside = |a: &&Area| {
                        (a.corners[0].x..a.corners[1].x).contains(&centre.x)
                            && (a.corners[2].y..a.corners[0].y).contains(&centre.y)
                    };
                    let albedo: f64 =
                        0.4 + areas.iter().filter(inside).map(|a| a.step).sum::<f64>();
                    let expected = if module_is_white(family, 5, x, y) {
                        PAPER
                    } else {
                        INK
                    };
                    assert!(
                        (albedo - expected).abs() < 1e-12,
                        "{family} module ({x}, {y})"
                    );
                }
            }
        }
    }

    #[test]
    fn every_tag_of_the_demo_is_printed() {
        let scenario = Scenario::demo(4, 12, 3);
        let model = Model::new(&scenario);
        let printed: usize = model.solids.iter().map(|solid| solid.prints.len()).sum();
        let tags: usize = scenario
            .objects
            .iter()
            .map(|object| object.tags.len())
            .sum();
        assert_eq!(printed, tags);
    }
}
