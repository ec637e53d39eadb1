//! Where the objects of the demonstration go: on one or two rings above the table, each with a wobble of its own.
//!
//! Neighbours on a ring keep their distance because they share its period; the rings are far enough apart.

use crate::path::{Path, Wave};
use crate::random::Random;
use std::f64::consts::{FRAC_PI_2, TAU};

/// One round, s.
const PERIOD_S: f64 = 7.5;
/// Distance of neighbours: two objects' radii and their wobbles, m.
const SPACING_M: f64 = 0.27;
/// How far an object leaves its ring, m.
const WOBBLE_M: f64 = 0.018;
/// Mean height above the table, m.
const HEIGHT_M: f64 = 0.18;
/// The most objects on one ring.
const ONE_RING: usize = 6;
/// Objects on the inner of two rings.
const INNER: usize = 3;

/// The space in which the objects move.
pub(super) struct Arena {
    n_objects: usize,
    /// Nothing comes nearer to the middle than this, m.
    clear_m: f64,
}

struct Ring {
    radius: f64,
    first_phase: f64,
    n_objects: usize,
    /// 1 is counter-clockwise from above.
    sense: f64,
}

impl Arena {
    pub fn new(n_objects: usize) -> Self {
        Self::about(0.0, n_objects)
    }

    /// About something in the middle that reaches so far, m.
    pub fn about(clear_m: f64, n_objects: usize) -> Self {
        Self { n_objects, clear_m }
    }

    pub fn n_objects(&self) -> usize {
        self.n_objects
    }

    /// Where the cameras stand, from the middle of the arena, m.
    pub fn camera_distance(&self) -> f64 {
        (0.92 + 0.95 * self.radius()).clamp(1.2, 1.5)
    }

    /// The focal length that fills the image with the arena.
    pub fn focal_px(&self) -> f64 {
        (245.0 * self.camera_distance() / (self.radius() * 0.85 + 0.06)).clamp(540.0, 930.0)
    }

    /// Half the width of what the objects fill.
    fn radius(&self) -> f64 {
        self.ring_of(0).0.radius + 0.12
    }

    pub fn path(&self, object: usize, random: &mut Random) -> Path {
        let (ring, place) = self.ring_of(object);
        let phase = ring.first_phase + TAU * place as f64 / ring.n_objects as f64;
        let (order, wobble) = (2 + random.below(2) as u32, random.between(0.0, TAU));
        // Backwards round the ring is forwards with y mirrored.
        let circle = |quarter: f64, sense: f64| {
            Wave::still(0.0)
                .and(1, sense * ring.radius, phase + quarter)
                .and(order, WOBBLE_M, wobble + quarter)
        };
        let mut swing = |amplitude: f64| {
            let order = 1 + random.below(2) as u32;
            Wave::still(0.0).and(order, amplitude, random.between(0.0, TAU))
        };
        let mut z = swing(0.03);
        z.mean = HEIGHT_M;
        let (yaw, pitch, roll) = (swing(0.25), swing(0.28), swing(0.28));
        Path {
            period_s: PERIOD_S,
            turns: [1, -1, 2, -2, 1, -1][random.below(6)],
            position: [circle(FRAC_PI_2, 1.0), circle(0.0, ring.sense), z],
            yaw,
            pitch,
            roll,
            joints: Vec::new(),
            events: Vec::new(),
        }
    }

    /// An object's ring and its place on it; object 0 is on the outermost.
    fn ring_of(&self, object: usize) -> (Ring, usize) {
        let (outer, inner) = if self.n_objects <= ONE_RING {
            (self.n_objects, 0)
        } else {
            (self.n_objects - INNER, INNER)
        };
        let clear = |radius: f64| match self.clear_m {
            0.0 => radius,
            clear_m => radius.max(clear_m + SPACING_M / 2.0),
        };
        if object < outer {
            let around = spaced_radius(outer);
            let radius = if inner > 0 {
                around.max(clear(spaced_radius(inner)) + SPACING_M)
            } else {
                clear(around)
            };
            return (ring(radius, outer, 1.0), object);
        }
        let radius = clear(spaced_radius(inner));
        (ring(radius, inner, -1.0), object - outer)
    }
}

fn ring(radius: f64, n_objects: usize, sense: f64) -> Ring {
    Ring {
        radius,
        first_phase: 0.4,
        n_objects,
        sense,
    }
}

/// The radius at which n objects keep their distance.
fn spaced_radius(n_objects: usize) -> f64 {
    match n_objects {
        0 | 1 => 0.14,
        n => SPACING_M / 2.0 / libm::sin(TAU / 2.0 / n as f64),
    }
}
