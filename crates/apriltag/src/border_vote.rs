//! Cheap test before anything else: beyond a quad's sides it is brighter than within them (or darker, for a white border),
//! nearly everywhere along them.

use crate::Rejection;
use crate::homography::Homography;
use crate::kernels::{POINTS, Points};
use crate::quad::Quad;
use crate::view::View;

/// Places along each side.
const ALONG: usize = 6;

const BLOCKS: usize = 4 * ALONG / POINTS;

/// Half a module of the families with the narrowest border, as a share of the edge.
const ASIDE: f32 = 1.0 / 16.0;

/// Places of four that may be no steps: an occluded corner, a neighbour's shadow.
const MOST_WRONG: usize = 4 * ALONG / 4;

/// Places on a square of edge 1, just within its sides and just beyond them.
#[derive(Debug)]
pub(crate) struct BorderVote {
    inside: [[Points; 2]; BLOCKS],
    outside: [[Points; 2]; BLOCKS],
    least_step: f32,
}

impl BorderVote {
    /// Asks for steps of a third of the least contrast: a blurred border shows no more half a module beside its edge.
    pub(crate) fn new(min_contrast: u8) -> Self {
        Self {
            inside: places(ASIDE),
            outside: places(-ASIDE),
            least_step: f32::from(min_contrast) / 3.0,
        }
    }

    pub(crate) fn check(&self, view: &View<'_>, quad: &Quad) -> Result<(), Rejection> {
        let map = Homography::square_to_quad(quad, 1.0).ok_or(Rejection::Shape)?;
        let (mut inside, mut outside) = ([[0.0; POINTS]; BLOCKS], [[0.0; POINTS]; BLOCKS]);
        view.sample(&map, &self.inside, &mut inside);
        view.sample(&map, &self.outside, &mut outside);
        let steps = inside.as_flattened().iter().zip(outside.as_flattened());
        let right =
            steps.filter(|(inside, outside)| view.sign() * (*outside - *inside) > self.least_step);
        if right.count() + MOST_WRONG >= 4 * ALONG {
            Ok(())
        } else {
            Err(Rejection::FaintBorder)
        }
    }
}

/// So far within the sides, spread from corner to corner.
fn places(within: f32) -> [[Points; 2]; BLOCKS] {
    let place = |i: usize| {
        let t = 0.1 + 0.8 * (i / 4) as f32 / (ALONG - 1) as f32;
        let far = 1.0 - within;
        [[t, within], [far, t], [t, far], [within, t]][i % 4]
    };
    std::array::from_fn(|block| {
        [0, 1].map(|axis| std::array::from_fn(|i| place(block * POINTS + i)[axis]))
    })
}
