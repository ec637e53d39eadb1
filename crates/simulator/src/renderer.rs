//! Images of a scenario: one renderer per camera, one image per call.
//!
//! Input: a true capture time (middle of the exposure of the middle row). Output: 8-bit grey pixels, a function of
//! seed, camera and time. Coverage is exact, without supersampling: outlines are convex polygons in normalised
//! coordinates, hidden parts are removed by inclusion and exclusion, lens distortion bends the rest, and coverage adds
//! up in the pixels. Static parts are drawn once. The heap stops growing after the first images.

mod backdrop;
mod bayer;
mod canvas;
mod decals;
mod disk;
#[cfg(test)]
mod exactness;
mod exposure;
mod jpeg;
mod motion;
mod psf;
mod regions;
mod room;
mod sensor;
mod shadows;
mod still;
mod texture;

use crate::model::{Area, Model, SolidModel, light_on};
use crate::optics::Optics;
use crate::polygon::{Polygon, convex_hull};
use crate::scenario::{Light, Scenario, ScenarioError, SceneCamera};
use crate::view::{PlacedSolid, SolidsView, normalised_polygon};
use backdrop::Backdrop;
use bayer::Demosaic;
use canvas::{Canvas, Layer, Occluders};
use exposure::Exposure;
use jpeg::Jpeg;
use regions::Regions;
use sensor::Sensor;
use sextant_geometry::Pose;
use shadows::Shadows;
use still::StaticRenderer;

/// The buffer does not fit the camera's resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the image needs {expected} bytes, but {given} were given")]
pub struct WrongImageSize {
    /// Expected length: width times height.
    pub expected: usize,
    /// Length of the buffer.
    pub given: usize,
}

/// Draws the images of one camera of a scenario.
pub struct Renderer {
    scene: Scene,
    view: SolidsView,
    shadows: Shadows,
    canvas: Canvas,
    regions: Regions,
    backdrop: Backdrop,
    sensor: Sensor,
    demosaic: Option<Demosaic>,
    jpeg: Option<Jpeg>,
}

/// What is constant from image to image.
struct Scene {
    camera: SceneCamera,
    optics: Optics,
    camera_from_world: Pose,
    light: Light,
    model: Model,
}

impl Renderer {
    /// A renderer for the camera with this index. Draws the background, which takes a fraction of a second.
    ///
    /// # Errors
    /// A scenario that cannot be simulated, or a camera that it lacks.
    pub fn new(scenario: &Scenario, camera: usize) -> Result<Self, ScenarioError> {
        scenario.validate()?;
        let Some(camera) = scenario.cameras.get(camera) else {
            return Err(ScenarioError::NoSuchCamera(camera));
        };
        let model = Model::new(scenario);
        let still = StaticRenderer::new(scenario, camera);
        let mut sharp = still.draw();
        let exposure = Exposure::metered(camera, &sharp);
        exposure.apply(&mut sharp);
        let mut field = still.field();
        exposure.apply(&mut field);
        let camera = &exposure.camera;
        Ok(Self {
            view: SolidsView::new(&model),
            shadows: Shadows::new(scenario),
            canvas: Canvas::new(camera),
            regions: Regions::new(camera.resolution, model.solids.len() + model.paths.len()),
            backdrop: Backdrop::new(camera, field, sharp),
            sensor: Sensor::new(scenario, camera),
            demosaic: Demosaic::for_camera(camera),
            jpeg: Jpeg::for_camera(camera),
            scene: Scene {
                optics: Optics::from_camera(camera),
                camera: camera.clone(),
                camera_from_world: camera.world_from_camera.inverse(),
                light: scenario.light,
                model,
            },
        })
    }

    /// The camera of these images, with the exposure and noise that auto exposure has chosen.
    pub fn camera(&self) -> &SceneCamera {
        &self.scene.camera
    }

    /// Draws the image taken at `true_capture_ns` (middle of the exposure), row by row without gaps.
    ///
    /// # Errors
    /// A buffer that does not fit the camera's resolution.
    pub fn render(&mut self, true_capture_ns: u64, image: &mut [u8]) -> Result<(), WrongImageSize> {
        let [width, height] = self.scene.camera.resolution;
        let (expected, given) = (width as usize * height as usize, image.len());
        if given != expected {
            return Err(WrongImageSize { expected, given });
        }
        self.draw(true_capture_ns);
        self.sensor
            .expose(self.backdrop.frame(), true_capture_ns, image);
        self.backdrop.restore(&self.regions);
        if let Some(demosaic) = &mut self.demosaic {
            demosaic.apply(image);
        }
        if let Some(jpeg) = &mut self.jpeg {
            jpeg.apply(image);
        }
        Ok(())
    }

    /// Draws the light that reaches the sensor into the background's frame.
    fn draw(&mut self, true_capture_ns: u64) {
        self.regions.clear();
        let instants = motion::instants(&self.scene, true_capture_ns);
        for (true_ns, rows) in (0..instants.total()).map(|k| instants.at(k)) {
            self.canvas.keep_to(rows);
            self.view
                .place(&self.scene.model, &self.scene.camera_from_world, true_ns);
            for object in 0..self.scene.model.paths.len() {
                self.draw_shadow(object, instants.weight());
            }
            for solid in 0..self.view.solids.len() {
                self.draw_solid(solid, instants.weight());
            }
        }
        self.regions.finish(self.backdrop.reach());
        self.backdrop.compose(&mut self.canvas, &self.regions);
    }

    fn draw_shadow(&mut self, object: usize, weight: f64) {
        let Self {
            scene,
            view,
            shadows,
            canvas,
            ..
        } = self;
        for shadow in shadows.cast(object, &scene.model, view) {
            let in_camera = shadow
                .corners()
                .map(|corner| scene.camera_from_world * corner);
            let outline = normalised_polygon(in_camera);
            let hiders = Occluders::new(view, &view.in_view);
            let bounds = canvas.paint(Layer::Opacity, &outline, hiders, shadow.strength * weight);
            self.regions
                .include(scene.model.solids.len() + object, &bounds);
        }
    }

    fn draw_solid(&mut self, solid: usize, weight: f64) {
        let (model, placed) = (&self.scene.model.solids[solid], &self.view.solids[solid]);
        if !placed.in_view() {
            return;
        }
        let hiders = Occluders::new(&self.view, &placed.hiders);
        let bounds = self
            .canvas
            .paint(Layer::Opacity, &placed.outline, hiders, weight);
        self.regions.include(solid, &bounds);
        for face in (0..model.faces.len()).filter(|&face| placed.faces_camera(face)) {
            let normal = &model.faces[face].normal;
            let light = weight * light_on(&self.scene.light, &placed.world_from_object, normal);
            draw_face(&mut self.canvas, model, placed, hiders, face, light);
            draw_displaced(
                &mut self.canvas,
                &self.scene,
                solid,
                placed,
                hiders,
                face,
                weight,
            );
        }
    }
}

/// A face and its prints, in the light that falls on it.
fn draw_face(
    canvas: &mut Canvas,
    model: &SolidModel,
    placed: &PlacedSolid,
    hiders: Occluders,
    face: usize,
    light: f64,
) {
    let project = |corners: &mut dyn Iterator<Item = nalgebra::Point3<f64>>| {
        normalised_polygon(corners.map(|corner| placed.camera_from_object * corner))
    };
    let corners = &model.faces[face].corners;
    let outline = project(&mut corners.iter().map(|&corner| model.vertices[corner]));
    canvas.paint(Layer::Colour, &outline, hiders, light * model.albedo);
    let areas = model
        .prints
        .iter()
        .filter(|print| print.face == face && print.is_flush)
        .flat_map(|print| &print.areas);
    for area in areas {
        let outline = project(&mut area.corners.iter().copied());
        canvas.paint(Layer::Colour, &outline, hiders, light * area.step);
    }
}

/// Prints that are glued on crookedly or bent, clipped to the outline of the face.
fn draw_displaced(
    canvas: &mut Canvas,
    scene: &Scene,
    solid: usize,
    placed: &PlacedSolid,
    hiders: Occluders,
    face: usize,
    weight: f64,
) {
    let model = &scene.model.solids[solid];
    let is_displaced = |print: &&crate::model::Print| print.face == face && !print.is_flush;
    let mut prints = model.prints.iter().filter(is_displaced).peekable();
    if prints.peek().is_none() {
        return;
    }
    let in_camera = |corner: &nalgebra::Point3<f64>| placed.camera_from_object * corner;
    let corners = model.faces[face].corners.iter();
    let mut outline = normalised_polygon(corners.map(|&i| in_camera(&model.vertices[i])));
    let window = convex_hull(outline.corners_mut());
    let light_of = |normal| weight * light_on(&scene.light, &placed.world_from_object, normal);
    let face_light = light_of(&model.faces[face].normal);
    for area in prints.flat_map(|print| &print.areas) {
        let light = match &area.facet {
            None => face_light * area.step,
            Some(facet) if is_seen(area, &facet.normal, placed) => {
                let reflected = area.step + facet.face_albedo;
                light_of(&facet.normal) * reflected - face_light * facet.face_albedo
            }
            Some(_) => continue,
        };
        let outline: Polygon = normalised_polygon(area.corners.iter().map(in_camera));
        canvas.paint(Layer::Colour, &outline.clipped(&window), hiders, light);
    }
}

/// Whether the camera sees the front of a strip of paper.
fn is_seen(area: &Area, normal: &nalgebra::Vector3<f64>, placed: &PlacedSolid) -> bool {
    let pose = &placed.camera_from_object;
    let corner = area.corners.first().map(|corner| pose * corner);
    corner.is_some_and(|corner| (pose.rotation * normal).dot(&corner.coords) < 0.0)
}
