//! Ideal observations: the corners of visible tags, projected exactly and moved by noise of known size.
//!
//! For tests of what comes after detection, without an image. Pixels with (0, 0) at the centre of the top left one;
//! corners top left, top right, bottom right, bottom left of the black square.

use crate::model::Model;
use crate::optics::Optics;
use crate::random::Random;
use crate::scenario::{Scenario, ScenarioError, SceneCamera, SceneObject, SceneTag};
use crate::view::{PlacedSolid, SolidsView, normalised_polygon};
use nalgebra::{Point2, Point3, Vector2};
use sextant_geometry::{Pose, tag_corners_in_tag};
use sextant_tag_families::Family;

/// Rounds in which row and time of a corner settle; each brings them nearer by the way in rows of a line delay, a
/// hundredth.
const ROUNDS: usize = 4;

/// A tag that a camera sees.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedTag {
    /// Index of the object in the scenario.
    pub object: usize,
    /// Family of the tag.
    pub family: Family,
    /// Its number.
    pub id: u32,
    /// Corners of its black square in the image, px.
    pub corners: [Point2<f64>; 4],
}

/// Which tags count as visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visibility {
    /// The shortest edge of the square in the image, px. A detector needs about 1.5 px a module.
    pub min_edge_px: f64,
    /// How far the corners must stay from the image's border, px.
    pub margin_px: f64,
    /// Whether other solids hide tags behind them.
    pub occlusion: Occlusion,
}

/// Whether solids hide tags behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occlusion {
    /// A tag of which a part is hidden isn't seen.
    Respected,
    /// Tags are seen through other solids.
    Ignored,
}

impl Default for Visibility {
    fn default() -> Self {
        Self {
            min_edge_px: 12.0,
            margin_px: 2.0,
            occlusion: Occlusion::Respected,
        }
    }
}

/// Observes a scenario from any of its cameras.
pub struct Observer {
    scenario: Scenario,
    model: Model,
    view: SolidsView,
    visibility: Visibility,
}

impl Observer {
    /// An observer of a scenario.
    ///
    /// # Errors
    /// A scenario that can't be simulated.
    pub fn new(scenario: &Scenario, visibility: Visibility) -> Result<Self, ScenarioError> {
        scenario.validate()?;
        let model = Model::new(scenario);
        Ok(Self {
            scenario: scenario.clone(),
            view: SolidsView::new(&model),
            model,
            visibility,
        })
    }

    /// The tags that a camera sees at a true time, by object and tag in the scenario's order; each corner coordinate
    /// with normal noise of `corner_sigma_px`. A camera that doesn't exist sees nothing.
    pub fn observe(
        &mut self,
        camera: usize,
        true_ns: u64,
        corner_sigma_px: f64,
        random: &mut Random,
    ) -> Vec<ObservedTag> {
        let Some(camera) = self.scenario.cameras.get(camera) else {
            return Vec::new();
        };
        self.view
            .place(&self.model, &camera.world_from_camera.inverse(), true_ns);
        let mut seen = Vec::new();
        for (object, scene_object) in self.scenario.objects.iter().enumerate() {
            for tag in 0..scene_object.tags.len() {
                seen.extend(self.tag(camera, object, tag, true_ns));
            }
        }
        for corner in seen.iter_mut().flat_map(|tag| &mut tag.corners) {
            *corner += Vector2::new(random.normal(), random.normal()) * corner_sigma_px;
        }
        seen
    }

    fn tag(
        &self,
        camera: &SceneCamera,
        object: usize,
        index: usize,
        true_ns: u64,
    ) -> Option<ObservedTag> {
        let tag = &self.scenario.objects[object].tags[index];
        let (placed, face) = self.carrier(object, index)?;
        if !placed.in_view() || !placed.faces_camera(face) || self.hidden(placed, tag) {
            return None;
        }
        let camera_from_object = |after_s: f64| {
            if after_s == 0.0 {
                return placed.camera_from_object;
            }
            let row_ns = true_ns.saturating_add_signed((after_s * 1e9).round() as i64);
            let world_from_object = self.model.paths[object].world_from_object(row_ns);
            camera.world_from_camera.inverse() * world_from_object
        };
        let corners = project(camera, camera_from_object, tag)?;
        self.large_enough(camera, &corners).then_some(ObservedTag {
            object,
            family: tag.family,
            id: tag.id,
            corners,
        })
    }

    /// The solid and the face that carry a tag.
    fn carrier(&self, object: usize, tag: usize) -> Option<(&PlacedSolid, usize)> {
        let solids = self.model.solids.iter().zip(&self.view.solids);
        let mut of_object = solids.filter(|(solid, _)| solid.object == object);
        of_object.find_map(|(solid, placed)| {
            let print = solid.prints.iter().find(|print| print.tag == tag)?;
            Some((placed, print.face))
        })
    }

    /// True where another solid hides part of the print with its white margin.
    fn hidden(&self, placed: &PlacedSolid, tag: &SceneTag) -> bool {
        if self.visibility.occlusion == Occlusion::Ignored {
            return false;
        }
        let camera_from_tag = placed.camera_from_object * tag.true_object_from_tag();
        let sheet = tag_corners_in_tag(tag.printed_size()).map(|corner| camera_from_tag * corner);
        let sheet = normalised_polygon(sheet.into_iter());
        let hides = |&hider: &usize| sheet.clipped(&self.view.solids[hider].outline).area() > 0.0;
        placed.hiders.iter().any(hides)
    }

    fn large_enough(&self, camera: &SceneCamera, corners: &[Point2<f64>; 4]) -> bool {
        let Visibility {
            min_edge_px,
            margin_px,
            ..
        } = self.visibility;
        let [width, height] = camera.resolution.map(f64::from);
        let inside = |c: &Point2<f64>| {
            c.x >= margin_px
                && c.y >= margin_px
                && c.x <= width - 1.0 - margin_px
                && c.y <= height - 1.0 - margin_px
        };
        let edge = |i: usize| (corners[(i + 1) % 4] - corners[i]).norm();
        corners.iter().all(inside) && (0..4).all(|i| edge(i) >= min_edge_px)
    }
}

/// Where a camera sees the corners of a tag, each when its row is taken; `camera_from_object` by seconds after the
/// capture time.
fn project(
    camera: &SceneCamera,
    camera_from_object: impl Fn(f64) -> Pose,
    tag: &SceneTag,
) -> Option<[Point2<f64>; 4]> {
    let mut corners = [Point2::origin(); 4];
    let optics = Optics::from_camera(camera);
    for (corner, point) in corners.iter_mut().zip(tag.corners_in_object()) {
        let seen_after = |after_s: f64| optics.project(&(camera_from_object(after_s) * point));
        *corner = seen_after(0.0)?;
        if camera.line_delay_s != 0.0 {
            // The row says when, and when says the row.
            for _ in 0..ROUNDS {
                *corner = seen_after(camera.row_after_s(corner.y))?;
            }
        }
    }
    Some(corners)
}

impl SceneObject {
    /// The corners of a tag's black square in the world at a true time; none for a tag that the object lacks.
    pub fn tag_corners_in_world(&self, tag: usize, true_ns: u64) -> Option<[Point3<f64>; 4]> {
        let tag = self.tags.get(tag)?;
        let world_from_object = self.world_from_object(true_ns);
        Some(
            tag.corners_in_object()
                .map(|corner| world_from_object * corner),
        )
    }
}
