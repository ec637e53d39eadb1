//! Profiles across a side, and their steepest points.
//!
//! Profiles are processed in parallel, as many as a vector holds points.

use super::Crossing;
use crate::homography::{Homography, POINTS, Points};
use crate::kernels::{sample, vectorised};
use crate::quad::{Point, Quad, distance, mean_edge};
use crate::view::ImageView;

/// Step along the profiles, in pixels.
const STEP_PX: f32 = 0.5;

/// Most steps on either side of an edge.
const MAX_STEPS: usize = 8;

/// Steps around the steepest point over which its position is averaged: the extent of a blur of 0.7 px.
const STEEP_STEPS: usize = 3;

/// Most groups of profiles along a side: beyond this, lens distortion limits the accuracy of a line.
pub(super) const MAX_GROUPS: usize = 3;

const MAX_SAMPLES: usize = 2 * MAX_STEPS + 1;

/// Modules along the border of the most common family, for estimates.
const USUAL_MODULES: f32 = 8.0;

/// Profiles perpendicular to a side.
pub(super) struct Profiles {
    n_groups: usize,
    /// Extent on either side.
    n_steps: usize,
}

impl Profiles {
    /// A few, no longer than a module.
    pub(super) fn coarse(quad: &Quad) -> Self {
        let module_px = mean_edge(quad) / USUAL_MODULES;
        Self::new(quad, (0.75 * module_px).clamp(1.5, 4.0), 1)
    }

    /// As many as possible.
    pub(super) fn fine(quad: &Quad) -> Self {
        Self::new(quad, 2.0, MAX_GROUPS)
    }

    /// At most one per pixel.
    fn new(quad: &Quad, reach_px: f32, most_groups: usize) -> Self {
        Self {
            n_groups: (mean_edge(quad) as usize / POINTS).clamp(1, most_groups),
            n_steps: ((reach_px / STEP_PX) as usize).clamp(STEEP_STEPS, MAX_STEPS),
        }
    }

    /// Crossings of an edge and the profiles over a line from a to b with this normal; weight 0 where they leave the
    /// image.
    pub(super) fn find_crossings<'a>(
        &self,
        view: &ImageView<'_>,
        a: Point,
        b: Point,
        [nx, ny]: Point,
        out: &'a mut [[Crossing; POINTS]; MAX_GROUPS],
    ) -> &'a mut [Crossing] {
        let way = [b[0] - a[0], b[1] - a[1]];
        // u along the side, from 0 to 1; v across it in pixels.
        let map = Homography {
            origin: a,
            m: [way[0], nx, 0.0, way[1], ny, 0.0, 0.0, 0.0],
        };
        let length = distance(a, b);
        let n_samples = 2 * self.n_steps + 1;
        let out = &mut out[..self.n_groups];
        for (group, crossings) in out.iter_mut().enumerate() {
            let along = self.along(group);
            let away = |step: usize| (step as f32 - self.n_steps as f32) * STEP_PX;
            let places: [_; MAX_SAMPLES] = std::array::from_fn(|k| [along, [away(k); POINTS]]);
            let mut greys = [[0.0; POINTS]; MAX_SAMPLES];
            let greys = &mut greys[..n_samples];
            sample(view.image, &map, &places, greys.as_flattened_mut());
            let [beyond, weight] = vectorised(|| steepest(greys, view.sign()));
            let found = |lane: usize| Crossing {
                along: (along[lane] - 0.5) * length,
                beyond: beyond[lane],
                weight: weight[lane],
            };
            *crossings = std::array::from_fn(|lane| match weight[lane] {
                0.0 => Crossing::default(),
                _ => found(lane),
            });
        }
        out.as_flattened_mut()
    }

    /// Away from the ends of a side, where the blur of adjacent sides reaches.
    fn along(&self, group: usize) -> Points {
        const END: f32 = 1.0 / 12.0;
        let spacing = (1.0 - 2.0 * END) / (self.n_groups * POINTS) as f32;
        std::array::from_fn(|lane| END + spacing * ((group * POINTS + lane) as f32 + 0.5))
    }
}

/// Distances of the steepest rises from the centres of profiles, and their heights; none where a profile leaves the
/// image.
#[inline(always)]
fn steepest(profiles: &[Points], sign: f32) -> [Points; 2] {
    let last = profiles.len() - 1;
    let middle = (last / 2) as f32;
    let rise = |k: usize| -> Points {
        std::array::from_fn(|lane| sign * (profiles[k + 1][lane] - profiles[k - 1][lane]))
    };
    let (mut peak, mut highest) = ([middle; POINTS], rise(last / 2));
    for k in 1..last {
        let here = rise(k);
        for lane in 0..POINTS {
            let higher = here[lane] > highest[lane];
            highest[lane] = if higher { here[lane] } else { highest[lane] };
            peak[lane] = if higher { k as f32 } else { peak[lane] };
        }
    }
    let (mut sum, mut moment) = ([0.0; POINTS], [0.0; POINTS]);
    for k in 1..last {
        let here = rise(k);
        for lane in 0..POINTS {
            let near = (k as f32 - peak[lane]).abs() <= STEEP_STEPS as f32;
            let steep = near && here[lane] > 0.0;
            let rise = if steep { here[lane] } else { 0.0 };
            sum[lane] += rise;
            moment[lane] += rise * (k as f32 - middle);
        }
    }
    let within = |lane: usize| !(profiles[0][lane] + profiles[last][lane]).is_nan();
    [
        std::array::from_fn(|lane| moment[lane] / sum[lane] * STEP_PX),
        std::array::from_fn(|lane| if within(lane) { sum[lane] } else { 0.0 }),
    ]
}
