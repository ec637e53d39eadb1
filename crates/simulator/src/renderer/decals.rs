//! Flat items on the table or on a wall: sheets of text, mats, boards, books. Seeded and static.

use super::texture::lattice;
use crate::random::Random;
use nalgebra::{Point2, Vector2};

/// A flat item on a surface, in the two coordinates of the surface, m.
pub(super) struct Decal {
    centre: Point2<f64>,
    half: Vector2<f64>,
    /// Cosine and sine of its rotation.
    turn: [f64; 2],
    pattern: Pattern,
}

/// What is drawn on it; lengths in m, tones as reflectances.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pattern {
    /// Lines of words on paper.
    Text { line: f64 },
    /// Light lines on a dark mat.
    Mat { tone: f64, raster: f64 },
    /// A board of light and dark squares.
    Squares { edge: f64 },
    /// Keys on a dark ground.
    Keys { pitch: f64 },
    /// A cover with a title and a frame.
    Book { tone: f64 },
    /// A picture in a frame.
    Poster { tone: f64 },
}

impl Decal {
    /// A random item for a table, within `reach` of the surface's origin.
    pub fn on_table(random: &mut Random, reach: Vector2<f64>) -> Self {
        let pattern = match random.below(10) {
            0..=3 => Pattern::Text { line: 0.007 },
            4 => Pattern::Mat {
                tone: random.between(0.12, 0.3),
                raster: 0.02,
            },
            5 => Pattern::Squares { edge: 0.025 },
            6 => Pattern::Keys { pitch: 0.019 },
            _ => Pattern::Book {
                tone: random.between(0.1, 0.7),
            },
        };
        let half = match pattern {
            Pattern::Text { .. } => Vector2::new(0.105, 0.148),
            Pattern::Mat { .. } => Vector2::new(0.15, 0.11),
            Pattern::Squares { edge } => Vector2::new(edge * 4.0, edge * 3.0),
            Pattern::Keys { pitch } => Vector2::new(pitch * 7.5, pitch * 2.5),
            _ => Vector2::new(random.between(0.05, 0.09), random.between(0.08, 0.13)),
        };
        Self::placed(random, reach, half, pattern)
    }

    /// A random item for a wall.
    pub fn on_wall(random: &mut Random, reach: Vector2<f64>) -> Self {
        let tone = random.between(0.1, 0.85);
        let half = Vector2::new(random.between(0.2, 0.5), random.between(0.25, 0.6));
        let mut decal = Self::placed(random, reach, half, Pattern::Poster { tone });
        decal.turn = [1.0, 0.0];
        decal
    }

    fn placed(
        random: &mut Random,
        reach: Vector2<f64>,
        half: Vector2<f64>,
        pattern: Pattern,
    ) -> Self {
        let angle = random.between(-3.2, 3.2);
        Self {
            centre: Point2::new(
                random.between(-reach.x, reach.x),
                random.between(-reach.y, reach.y),
            ),
            half,
            turn: [libm::cos(angle), libm::sin(angle)],
            pattern,
        }
    }

    /// Reflectance at a point of the surface, if the item covers it.
    pub fn albedo(&self, point: &Point2<f64>) -> Option<f64> {
        let [cos, sin] = self.turn;
        let d = point - self.centre;
        let local = Vector2::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x);
        let inside = local.x.abs() < self.half.x && local.y.abs() < self.half.y;
        inside.then(|| self.pattern.albedo(&(local + self.half), &self.half))
    }
}

impl Pattern {
    /// Reflectance at a point relative to the lower left corner of the item.
    fn albedo(self, at: &Vector2<f64>, half: &Vector2<f64>) -> f64 {
        let rim =
            at.x.min(at.y)
                .min(2.0 * half.x - at.x)
                .min(2.0 * half.y - at.y);
        match self {
            Self::Text { line } => text(at, rim, line),
            Self::Mat { tone, raster } => {
                let on_line = (at.x / raster).fract() < 0.06 || (at.y / raster).fract() < 0.06;
                if on_line && rim > 0.01 {
                    tone + 0.3
                } else {
                    tone
                }
            }
            Self::Squares { edge } => {
                let even = (cell(at.x, edge) + cell(at.y, edge)) % 2 == 0;
                if even { 0.78 } else { 0.12 }
            }
            Self::Keys { pitch } => {
                let on_key = (at.x / pitch).fract() > 0.18 && (at.y / pitch).fract() > 0.18;
                if on_key { 0.24 } else { 0.1 }
            }
            Self::Book { tone } => {
                let title = (at.y / half.y - 1.45).abs() < 0.12 && rim > 0.3 * half.x;
                if title || (rim - 0.008).abs() < 0.001 {
                    0.8 - 0.6 * tone
                } else {
                    tone
                }
            }
            Self::Poster { tone } => poster(at, rim, half, tone),
        }
    }
}

/// Words of unequal length; the last line of a paragraph is short.
fn text(at: &Vector2<f64>, rim: f64, line: f64) -> f64 {
    let row = cell(at.y, line);
    let letter = cell(at.x, 0.003);
    let paragraph = 6 + (row / 8) % 3;
    let last_line = row % paragraph == 1;
    let printed = rim > 0.02
        && (at.y / line).fract() < 0.4
        && lattice(11, letter, row) > -0.68
        && row % paragraph != 0
        && !(last_line && at.x > 0.12);
    if printed { 0.3 } else { 0.86 }
}

fn poster(at: &Vector2<f64>, rim: f64, half: &Vector2<f64>, tone: f64) -> f64 {
    if rim < 0.02 {
        return 0.15;
    }
    let (x, y) = (at.x / half.x, at.y / half.y);
    let sun = (x - 1.3) * (x - 1.3) + (y - 1.4) * (y - 1.4) < 0.06;
    let hills = y < 0.7 + 0.2 * libm::sin(3.0 * x) + 0.1 * libm::sin(7.0 * x + 1.0);
    match (sun, hills) {
        (_, true) => 0.6 * tone,
        (true, false) => 0.9,
        (false, false) => 0.3 + 0.5 * tone,
    }
}

fn cell(x: f64, edge: f64) -> i32 {
    (x / edge).floor() as i32
}
