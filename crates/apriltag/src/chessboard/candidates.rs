//! Candidates for the inner corners of a chessboard: saddle points of the smoothed image around which black and white
//! alternate.

use super::smoothed::Smoothed;
use crate::quad::Point;
use std::f32::consts::{PI, TAU};

/// Most candidates of an image; the strongest are used.
const MOST: usize = 4000;
/// Least response, in grey levels per square pixel: an ideal corner of 15 grey levels in a slightly blurred image.
const LEAST_RESPONSE: f32 = 0.7;
/// Radii of the rings around a candidate, in pixels: the larger one suffers less from blur and noise, the smaller one
/// fits small squares.
const RINGS_PX: [f32; 2] = [4.5, 3.0];
/// Samples of a ring.
const SAMPLES: usize = 32;
/// Least part of a ring's variance that is symmetric about its centre.
const LEAST_SYMMETRY: f32 = 0.6;
/// Least angle between the edges, in radians.
const LEAST_ANGLE: f32 = 0.3;

/// A candidate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) place: Point,
    /// Unit vectors along the edges. The second follows clockwise after the first by less than half a turn, and the
    /// quadrant between them is bright.
    pub(super) edges: [Point; 2],
    /// Half the difference between bright and dark on the ring, in grey levels.
    pub(super) swing: f32,
}

impl Candidate {
    /// Direction of one of the four edges that leave the corner, in clockwise order from the first.
    pub(super) fn ray(&self, index: usize) -> Point {
        let sign = if index < 2 { 1.0 } else { -1.0 };
        self.edges[index % 2].map(|part| sign * part)
    }
}

/// All candidates of an image, the strongest first.
pub(super) fn candidates(image: &Smoothed) -> Vec<Candidate> {
    let mut peaks = peaks(image);
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    peaks.truncate(MOST);
    let found = peaks.iter().filter_map(|&(place, _)| {
        RINGS_PX
            .into_iter()
            .find_map(|radius_px| Ring::around(image, place, radius_px)?.candidate())
    });
    found.collect()
}

/// Local maxima of the negative determinant of the Hessian matrix, with sub-pixel positions, and their responses.
fn peaks(image: &Smoothed) -> Vec<(Point, f32)> {
    const REACH: usize = 2;
    let (width, height) = (image.width(), image.height());
    let response = responses(image);
    let at = |x: usize, y: usize| response[y * width + x];
    let least = LEAST_RESPONSE * LEAST_RESPONSE;
    let mut peaks = Vec::new();
    for y in REACH..height - REACH {
        for x in REACH..width - REACH {
            let here = at(x, y);
            if here < least {
                continue;
            }
            let is_peak = (y - REACH..=y + REACH).all(|v| {
                let row = &response[v * width + x - REACH..=v * width + x + REACH];
                row.iter().enumerate().all(|(column, &other)| {
                    let is_before = (v, column) < (y, REACH);
                    other < here || (other == here && !is_before)
                })
            });
            if is_peak {
                let place = [
                    x as f32 + vertex([at(x - 1, y), here, at(x + 1, y)]),
                    y as f32 + vertex([at(x, y - 1), here, at(x, y + 1)]),
                ];
                peaks.push((place, here));
            }
        }
    }
    peaks
}

/// Negative determinant of the Hessian matrix at each pixel; zero at the rim.
fn responses(image: &Smoothed) -> Vec<f32> {
    let (width, height) = (image.width(), image.height());
    let mut response = vec![0.0; width * height];
    for y in 1..height - 1 {
        let [above, row, below] = [y - 1, y, y + 1].map(|y| image.row(y));
        for x in 1..width - 1 {
            let xx = row[x - 1] - 2.0 * row[x] + row[x + 1];
            let yy = above[x] - 2.0 * row[x] + below[x];
            let xy = (above[x - 1] + below[x + 1] - above[x + 1] - below[x - 1]) / 4.0;
            response[y * width + x] = xy * xy - xx * yy;
        }
    }
    response
}

/// Offset of the vertex of the parabola through three values one apart, from the middle one.
fn vertex([before, here, after]: [f32; 3]) -> f32 {
    let bend = before - 2.0 * here + after;
    if bend < 0.0 {
        ((before - after) / (2.0 * bend)).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// Greys on a circle around a place, clockwise from the right, minus their mean.
struct Ring {
    place: Point,
    greys: [f32; SAMPLES],
}

impl Ring {
    /// `None` if the circle leaves the image.
    fn around(image: &Smoothed, place: Point, radius_px: f32) -> Option<Self> {
        let mut greys = [0.0; SAMPLES];
        for (i, grey) in greys.iter_mut().enumerate() {
            let (sin, cos) = angle_of(i as f32).sin_cos();
            *grey = image.sample([place[0] + radius_px * cos, place[1] + radius_px * sin])?;
        }
        let mean = greys.iter().sum::<f32>() / SAMPLES as f32;
        Some(Self {
            place,
            greys: greys.map(|grey| grey - mean),
        })
    }

    /// The candidate, if black and white alternate twice and opposite sectors have the same colour.
    fn candidate(&self) -> Option<Candidate> {
        if self.symmetry() < LEAST_SYMMETRY {
            return None;
        }
        let crossings = self.crossings()?;
        let opposite = |i: usize| crossings[i + 2] - crossings[i] - PI;
        if opposite(0).abs().max(opposite(1).abs()) > 0.6 {
            return None;
        }
        let angles = [0, 1].map(|i| crossings[i] + opposite(i) / 2.0);
        let first = ((angles[0] + angles[1]) / 2.0 / TAU * SAMPLES as f32) as usize % SAMPLES;
        let angles = match self.greys[first] > 0.0 {
            true => angles,
            false => [angles[1], angles[0] + PI],
        };
        let between = angles[1] - angles[0];
        let swing = self.greys.iter().map(|grey| grey.abs()).sum::<f32>() / SAMPLES as f32;
        (LEAST_ANGLE..PI - LEAST_ANGLE)
            .contains(&between)
            .then(|| Candidate {
                place: self.place,
                edges: angles.map(|angle| [angle.cos(), angle.sin()]),
                swing,
            })
    }

    /// Correlation of each grey with the opposite one, from -1 to 1.
    fn symmetry(&self) -> f32 {
        let half = SAMPLES / 2;
        let product: f32 = (0..half)
            .map(|i| self.greys[i] * self.greys[i + half])
            .sum();
        let square: f32 = self.greys.iter().map(|grey| grey * grey).sum();
        2.0 * product / square.max(f32::MIN_POSITIVE)
    }

    /// Angles at which the colour changes, ascending, if there are four.
    fn crossings(&self) -> Option<[f32; 4]> {
        let mut crossings = [0.0; 4];
        let mut n = 0;
        for i in 0..SAMPLES {
            let (here, next) = (self.greys[i], self.greys[(i + 1) % SAMPLES]);
            if (here > 0.0) != (next > 0.0) {
                *crossings.get_mut(n)? = angle_of(i as f32 + here / (here - next));
                n += 1;
            }
        }
        (n == 4).then_some(crossings)
    }
}

fn angle_of(sample: f32) -> f32 {
    sample / SAMPLES as f32 * TAU
}
