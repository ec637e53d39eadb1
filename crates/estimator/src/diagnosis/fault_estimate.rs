//! What one camera or one tag may be accused of, and what speaks for it.

use nalgebra::{Vector1, Vector6};

use crate::diagnosis::recursive_estimate::Guess;

/// Evidence that is worth watching all images.
pub(crate) const ALERT: f64 = 5.0;
/// Share of squared residuals that may be left; by a clock several times as much, since motion is taken to be uniform for its offset and its
/// velocity counts where one sigma is up to a fifth of it.
const REST: f64 = 0.03;
const REST_OF_CLOCK: f64 = 0.15;
/// Views after which one counts 1/e: a tag is seen by several cameras.
const MEMORY: f64 = 30.0;
const MEMORY_OF_TAG: f64 = 60.0;
/// Half the squared sigmas of an error beyond which it is not as is stated: of six numbers one in 10⁸ by chance.
const UNLIKELY: f64 = 25.0;
/// Sigmas of what is possible: metres and radians of a camera, of a tag; share of a size; seconds.
const CAMERA: [f64; 2] = [0.1, 0.1];
const PLACE: [f64; 2] = [0.02, 0.2];
const SIZE: f64 = 0.1;
const CLOCK: f64 = 0.1;

/// What a camera or a tag may be accused of: an error of one parameter, its clock's offset or its size, or a displacement.
#[derive(Debug)]
pub(crate) struct Accused {
    pub simple: Guess<1>,
    pub whole: Guess<6>,
    /// Shares of squared residuals that either may leave.
    rests: [f64; 2],
}

impl Accused {
    pub fn camera() -> Self {
        Self {
            simple: Guess::new(Vector1::new(CLOCK), MEMORY),
            whole: Guess::new(usual(CAMERA), MEMORY),
            rests: [REST_OF_CLOCK, REST],
        }
    }

    pub fn tag() -> Self {
        Self {
            simple: Guess::new(Vector1::new(SIZE), MEMORY_OF_TAG),
            whole: Guess::new(usual(PLACE), MEMORY_OF_TAG),
            rests: [REST; 2],
        }
    }

    /// What either explains, if errors as large as is stated do not.
    pub fn strengths(&self) -> [f64; 2] {
        let stated = self.whole.strength_of_stated();
        let is_likely = |own: f64| stated > 0.0 && own < stated + UNLIKELY;
        let strengths = [self.simple.strength(), self.whole.strength()];
        strengths.map(|own| if is_likely(own) { 0.0 } else { own })
    }

    /// Whether nothing but either is needed.
    pub fn explain(&self) -> [bool; 2] {
        let [simple, whole] = self.rests;
        [self.simple.explains(simple), self.whole.explains(whole)]
    }

    /// It begins to contradict.
    pub fn unsettle(&mut self) {
        if self.strengths()[1] < ALERT {
            self.whole.unsettle();
            self.simple.unsettle();
        }
    }
}

fn usual([metres, radians]: [f64; 2]) -> Vector6<f64> {
    Vector6::new(metres, metres, metres, radians, radians, radians)
}
