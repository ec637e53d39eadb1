//! A cube to fold from one sheet, with a tag on each face, and the constellation of the folded cube.
//!
//! The origin of the cube's frame is its centre. Seen from outside, the second face of the net's column faces along z,
//! the one above it along y, the one to its right along x; the printed side is outside. Each tag is centred on its face
//! and upright in the net. The tags are in the order +z, +y, -x, +x, -y, -z:
//!
//! ```text
//!        [+y]
//!   [-x] [+z] [+x]
//!        [-y]
//!        [-z]
//! ```

use crate::pdf::{Page, Stroke};
use crate::sheet::{MARGIN, NOTE, RULER, SMALL, Sheet, label_of, length_text, printed_edge};
use crate::{Paper, PrintJob, SheetError, check_size, ids_from};
use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use std::f64::consts::FRAC_PI_2;

/// Width of the glue flaps.
const FLAP: f64 = 8.0;

/// A cube with a tag on each face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cube {
    /// Edge of the cube, m.
    pub edge_m: f64,
    /// Edge of each black square, m.
    pub size_m: f64,
    /// The tags' family.
    pub family: Family,
    /// Id of the first tag; the others follow.
    pub first: u32,
}

/// A face: its position in the net, in edges from the face +z, x right and y up, and how it is folded.
struct Face {
    at: [f64; 2],
    object_from_face: Pose,
}

/// Lays out the cube.
///
/// # Errors
/// Tags larger than the faces, or a net larger than the paper.
pub fn cube(cube: &Cube, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
    let ids = ids_from(cube.family, cube.first, 6)?;
    let (edge, size) = (cube.edge_m * 1e3, cube.size_m * 1e3);
    check_size(size)?;
    let printed = printed_edge(ids[0], size);
    if printed > edge || edge.is_nan() {
        return Err(SheetError::FaceTooSmall { printed, edge });
    }
    let [width, height] = paper.size();
    let largest = ((width - 2.0 * MARGIN) / 3.0).min((height - 2.0 * MARGIN - FLAP) / 4.0);
    if edge > largest {
        return Err(SheetError::NetTooLarge { largest, paper });
    }
    let faces = faces(edge * 1e-3);
    let tags = ids
        .iter()
        .zip(&faces)
        .map(|(&tag, face)| ObjectTag::new(tag, size * 1e-3, Some(face.object_from_face)));
    let model = ObjectModel::new(id.parse()?, tags.collect())?;
    let net = NetLayout {
        edge,
        middle: [width / 2.0, height - MARGIN - 1.5 * edge],
    };
    let page = net.page(paper, &faces, &ids, size);
    Ok(PrintJob {
        title: format!("Sextant cube {id}"),
        pages: vec![page],
        model,
        size,
    })
}

/// The faces in the order of their tags, each hinged to its neighbour in the net.
fn faces(edge: f64) -> [Face; 6] {
    let front = Pose::translation(0.0, 0.0, edge / 2.0);
    let below = front * hinge([0.0, -1.0], edge);
    let face = |x: f64, y: f64, object_from_face: Pose| Face {
        at: [x, y],
        object_from_face,
    };
    [
        face(0.0, 0.0, front),
        face(0.0, 1.0, front * hinge([0.0, 1.0], edge)),
        face(-1.0, 0.0, front * hinge([-1.0, 0.0], edge)),
        face(1.0, 0.0, front * hinge([1.0, 0.0], edge)),
        face(0.0, -1.0, below),
        face(0.0, -2.0, below * hinge([0.0, -1.0], edge)),
    ]
}

/// Pose of the neighbour in direction `[x, y]` in the frame of a face, folded back by a right angle.
fn hinge([x, y]: [f64; 2], edge: f64) -> Pose {
    let outwards = Vector3::new(x, y, 0.0);
    // Turns the neighbour's normal from z to the outside.
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z().cross(&outwards) * FRAC_PI_2);
    let to_hinge = outwards * (edge / 2.0);
    Pose::from_parts((to_hinge + turn * to_hinge).into(), turn)
}

/// The net on the paper: edge length of a face and centre of +z.
struct NetLayout {
    edge: f64,
    middle: [f64; 2],
}

impl NetLayout {
    fn page(&self, paper: Paper, faces: &[Face], ids: &[TagId], size: f64) -> Page {
        let mut sheet = Sheet::new(paper);
        self.outlines(&mut sheet);
        for (&tag, face) in ids.iter().zip(faces) {
            let centre = self.place(face.at);
            sheet.tag(tag, centre, size);
            let low = centre[1] - self.edge / 2.0 + 0.5 * SMALL;
            sheet.text([centre[0] - size / 2.0, low], SMALL, label_of(tag, size));
        }
        let corner = self.place([0.5, -0.5]);
        let x = corner[0] + FLAP + 4.0;
        sheet.notes([x, corner[1] - 8.0], &self.notes(size));
        let ruler_top = corner[1] - 8.0 - 1.35 * NOTE * self.notes(size).len() as f64;
        let ruler = [x, (ruler_top - RULER).max(4.0)];
        sheet.ruler_up(ruler);
        sheet.text([ruler[0] + 6.0, ruler[1] + 1.0], SMALL, "100 mm");
        sheet.into_page()
    }

    /// A point given in edges from the centre of +z.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.middle[0] + x * self.edge,
            self.middle[1] + y * self.edge,
        ]
    }

    fn notes(&self, size: f64) -> [String; 5] {
        [
            format!(
                "Cube of {}, tags of {}.",
                length_text(self.edge),
                length_text(size)
            ),
            "Cut along the full lines,".to_owned(),
            "fold back along the dashed ones.".to_owned(),
            "If the ruler is not 100 mm,".to_owned(),
            "use --measured-size.".to_owned(),
        ]
    }

    fn outlines(&self, sheet: &mut Sheet) {
        let mut side = |stroke, from, to| sheet.line(stroke, &[self.place(from), self.place(to)]);
        for (x, y) in [(-0.5, 0.5), (-0.5, -0.5), (-0.5, -1.5)] {
            side(Stroke::Fold, [x, y], [x + 1.0, y]);
        }
        for x in [-0.5, 0.5] {
            side(Stroke::Fold, [x, -0.5], [x, 0.5]);
        }
        for x in [-1.5, 0.5] {
            side(Stroke::Cut, [x, 0.5], [x + 1.0, 0.5]);
            side(Stroke::Cut, [x, -0.5], [x + 1.0, -0.5]);
        }
        for x in [-1.5, 1.5] {
            side(Stroke::Cut, [x, -0.5], [x, 0.5]);
        }
        side(Stroke::Cut, [-0.5, 1.5], [0.5, 1.5]);
        for y in [0.5, -1.5, -2.5] {
            self.flap(sheet, [-0.5, y], [-0.5, y + 1.0]);
            self.flap(sheet, [0.5, y + 1.0], [0.5, y]);
        }
        self.flap(sheet, [0.5, -2.5], [-0.5, -2.5]);
    }

    /// A glue flap on the edge of a face, on the left of the direction from `from` to `to`.
    fn flap(&self, sheet: &mut Sheet, from: [f64; 2], to: [f64; 2]) {
        let (a, b) = (self.place(from), self.place(to));
        sheet.line(Stroke::Fold, &[a, b]);
        let along = [(b[0] - a[0]) / self.edge, (b[1] - a[1]) / self.edge];
        let out = |p: [f64; 2], inset: f64| {
            [
                p[0] - FLAP * along[1] + inset * along[0],
                p[1] + FLAP * along[0] + inset * along[1],
            ]
        };
        sheet.line(Stroke::Cut, &[a, out(a, FLAP), out(b, -FLAP), b]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    const EDGE: f64 = 0.06;

    /// Corner of a face in the cube's frame, in half edges to the right and up.
    fn corner(face: &Face, x: f64, y: f64) -> Point3<f64> {
        face.object_from_face * Point3::new(x * EDGE / 2.0, y * EDGE / 2.0, 0.0)
    }

    #[test]
    fn faces_look_outwards_along_the_axes() {
        let expected = [
            Vector3::z(),
            Vector3::y(),
            -Vector3::x(),
            Vector3::x(),
            -Vector3::y(),
            -Vector3::z(),
        ];
        for (face, axis) in faces(EDGE).iter().zip(expected) {
            let pose = &face.object_from_face;
            assert!((pose.rotation * Vector3::z() - axis).norm() < 1e-12);
            assert!((pose.translation.vector - axis * EDGE / 2.0).norm() < 1e-12);
        }
    }

    /// Edges that touch in the net, and those joined by flaps, coincide on the cube.
    #[test]
    fn edges_meet_when_folded() {
        let [front, above, left, right, below, back] = faces(EDGE);
        let meets = |a: &Face, ends_a: [[f64; 2]; 2], b: &Face, ends_b: [[f64; 2]; 2]| {
            for ([ax, ay], [bx, by]) in ends_a.into_iter().zip(ends_b) {
                assert!((corner(a, ax, ay) - corner(b, bx, by)).norm() < 1e-12);
            }
        };
        let (nw, ne, se, sw) = ([-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]);
        meets(&front, [nw, ne], &above, [sw, se]);
        meets(&front, [nw, sw], &left, [ne, se]);
        meets(&front, [ne, se], &right, [nw, sw]);
        meets(&front, [sw, se], &below, [nw, ne]);
        meets(&below, [sw, se], &back, [nw, ne]);
        meets(&above, [nw, sw], &left, [nw, ne]);
        meets(&above, [ne, se], &right, [ne, nw]);
        meets(&above, [nw, ne], &back, [sw, se]);
        meets(&left, [nw, sw], &back, [sw, nw]);
        meets(&left, [sw, se], &below, [sw, nw]);
        meets(&right, [ne, se], &back, [se, ne]);
        meets(&right, [sw, se], &below, [ne, se]);
    }
}
