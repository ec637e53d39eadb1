//! Painting through the lens: convex outlines in normalised coordinates become coverage in pixels.

use super::regions::Rectangle;
use crate::coverage::Coverage;
use crate::optics::Optics;
use crate::polygon::{Bounds, Polygon};
use crate::scenario::SceneCamera;
use crate::view::SolidsView;
use nalgebra::{Point2, Vector2};
use std::ops::Range;

/// Largest deviation of a curved edge from the straight pieces that replace it, px.
const STRAIGHT_PX: f64 = 0.002;
/// Most bisections of one edge.
const MAX_CUTS: u32 = 6;
/// Bisections to find where an edge leaves the field of view of the lens.
const FIELD_HALVINGS: u32 = 30;

/// A layer into which outlines are painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// Light from objects.
    Colour,
    /// Share of the background's light that is hidden.
    Opacity,
}

/// Solids that hide parts of what is painted.
#[derive(Clone, Copy)]
pub(super) struct Occluders<'a> {
    view: &'a SolidsView,
    solids: &'a [usize],
}

impl<'a> Occluders<'a> {
    pub fn new(view: &'a SolidsView, solids: &'a [usize]) -> Self {
        Self { view, solids }
    }

    /// Outline of the first hider, and the hiders after it.
    fn split(self) -> Option<(&'a Polygon, &'a Bounds, Self)> {
        let (&first, rest) = self.solids.split_first()?;
        let solid = &self.view.solids[first];
        Some((
            &solid.outline,
            &solid.bounds,
            Self {
                solids: rest,
                ..self
            },
        ))
    }
}

/// Coverage of the pixels of one image while it is painted.
pub(super) struct Canvas {
    colour: Coverage,
    opacity: Coverage,
    image: Bounds,
    pen: Pen,
}

impl Canvas {
    pub fn new(camera: &SceneCamera) -> Self {
        let [width, height] = camera.resolution.map(|n| n as usize);
        Self {
            colour: Coverage::new(width, height),
            opacity: Coverage::new(width, height),
            image: Bounds::around(&[Point2::origin(), Point2::new(width as f64, height as f64)]),
            pen: Pen::new(camera),
        }
    }

    /// Restricts painting to these rows.
    pub fn keep_to(&mut self, rows: Range<usize>) {
        self.colour.keep_to(rows.clone());
        self.opacity.keep_to(rows);
    }

    /// Adds `weight` where the outline is visible. Returns bounds of the changed pixels, with (0, 0) at the corner of
    /// the image.
    pub fn paint(
        &mut self,
        layer: Layer,
        outline: &Polygon,
        hiders: Occluders,
        weight: f64,
    ) -> Bounds {
        let bounds = self.fill(layer, outline, weight);
        self.take_off(layer, outline, hiders, weight);
        bounds
    }

    /// Inclusion and exclusion: subtracts what each hider hides, and adds back what it hides together with later ones.
    fn take_off(&mut self, layer: Layer, outline: &Polygon, mut hiders: Occluders, weight: f64) {
        let bounds = outline.bounds();
        while let Some((hider, hider_bounds, rest)) = hiders.split() {
            hiders = rest;
            if !hider_bounds.overlaps(&bounds) {
                continue;
            }
            let hidden = outline.clipped(hider);
            if hidden.corners().len() > 2 {
                self.fill(layer, &hidden, -weight);
                self.take_off(layer, &hidden, rest, -weight);
            }
        }
    }

    fn fill(&mut self, layer: Layer, outline: &Polygon, weight: f64) -> Bounds {
        let pixels = self.pen.trace(outline);
        let bounds = Bounds::around(pixels);
        if bounds.overlaps(&self.image) {
            let coverage = match layer {
                Layer::Colour => &mut self.colour,
                Layer::Opacity => &mut self.opacity,
            };
            coverage.fill(pixels, weight as f32);
        }
        bounds
    }

    /// Takes the painted values of a row of a rectangle: light, and the hidden share of the background.
    pub fn take_row(
        &mut self,
        y: usize,
        rectangle: &Rectangle,
        colour: &mut [f32],
        opacity: &mut [f32],
    ) {
        let [start, end] = rectangle.columns();
        self.colour.take_row(y, start, end, colour);
        self.opacity.take_row(y, start, end, opacity);
    }
}

/// Draws outlines through the lens.
struct Pen {
    optics: Optics,
    traced: Vec<Point2<f64>>,
}

/// End of an edge: normalised coordinates, and pixels where the lens images it.
#[derive(Clone, Copy)]
struct End {
    normalised: Point2<f64>,
    pixel: Option<Point2<f64>>,
}

impl Pen {
    fn new(camera: &SceneCamera) -> Self {
        Self {
            optics: Optics::from_camera(camera),
            traced: Vec::with_capacity(256),
        }
    }

    /// The outline in pixels, (0, 0) at the corner of the image, cut straight where it leaves the field of view of the
    /// lens.
    fn trace(&mut self, outline: &Polygon) -> &[Point2<f64>] {
        self.traced.clear();
        let Some(&last) = outline.corners().last() else {
            return &self.traced;
        };
        let mut from = self.end(last);
        for &corner in outline.corners() {
            let to = self.end(corner);
            self.trace_edge(from, to);
            from = to;
        }
        &self.traced
    }

    fn end(&self, normalised: Point2<f64>) -> End {
        let to_corner = Vector2::new(0.5, 0.5);
        End {
            normalised,
            pixel: self
                .optics
                .distort(&normalised)
                .map(|pixel| pixel + to_corner),
        }
    }

    fn trace_edge(&mut self, from: End, to: End) {
        match (from.pixel, to.pixel) {
            (Some(_), Some(_)) => self.bend(from, to, MAX_CUTS),
            (Some(_), None) => {
                let leaves = self.field_border(from, to);
                self.bend(from, leaves, MAX_CUTS);
            }
            (None, Some(_)) => {
                let enters = self.field_border(to, from);
                self.traced.extend(enters.pixel);
                self.bend(enters, to, MAX_CUTS);
            }
            (None, None) => {}
        }
    }

    /// Adds the edge after `from` up to `to`, in as many pieces as lens distortion requires.
    fn bend(&mut self, from: End, to: End, cuts: u32) {
        let (Some(a), Some(b)) = (from.pixel, to.pixel) else {
            return;
        };
        if cuts > 0 && !self.optics.is_straight() {
            let middle = self.end(nalgebra::center(&from.normalised, &to.normalised));
            // Only the distance from the straight line matters, not the position along it.
            let off_line = middle.pixel.map_or(0.0, |m| (b - a).perp(&(m - a)).abs());
            if off_line > STRAIGHT_PX * (b - a).norm() {
                self.bend(from, middle, cuts - 1);
                self.bend(middle, to, cuts - 1);
                return;
            }
        }
        self.traced.push(b);
    }

    /// Last point of the edge within the field of view.
    fn field_border(&self, inside: End, outside: End) -> End {
        let (mut inside, mut outside) = (inside, outside);
        for _ in 0..FIELD_HALVINGS {
            let middle = self.end(nalgebra::center(&inside.normalised, &outside.normalised));
            if middle.pixel.is_some() {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}
