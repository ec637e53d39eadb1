//! Saddle points with sub-pixel accuracy: crossings of two edges where black and white squares alternate.
//!
//! Input: an image, an approximate position, directions of the edges, and the radius within which nothing else is
//! visible. Output: position and covariance, or `None` where the image contains something else.
//!
//! Grey is mean + swing E(a) E(b), where a and b are the distances from the two edges in standard deviations of the
//! blur and E is the odd step response of the blur. Gauss-Newton on seven parameters: position (2), directions of the
//! edges (2), blur, mean and swing. Where black squares do not touch, a white line of known width lies along either
//! edge, between the product of both step responses of each black square. Tone curve, glare and spreading ink move
//! edges but not the saddle, since they act equally on both sides.

use crate::Image;
use crate::quad::{Point, distance};
use nalgebra::{SMatrix, SVector};

const PARAMETERS: usize = 7;

type Vector = SVector<f32, PARAMETERS>;
type Matrix = SMatrix<f32, PARAMETERS, PARAMETERS>;

/// Least radius with enough pixels for all parameters, and the largest, beyond which lenses bend edges.
pub(crate) const RADIUS_PX: [f32; 2] = [2.2, 5.0];

/// Largest residual of a saddle, as a share of the swing: sharp images leave 0.15; where three of the four quadrants
/// have one colour, the best fit leaves 1.4.
const MOST_RESIDUAL: f32 = 0.3;

/// Range of the swing as a share of half the tag's contrast. A fit to something else often has a much larger swing and
/// a wide blur.
const SWING: std::ops::RangeInclusive<f32> = 0.5..=1.6;

/// Largest blur of a saddle, as a share of the radius: with more, no flat area is left within the radius.
const MOST_BLUR: f32 = 0.4;

/// Additional standard deviation of a saddle's position, in pixels: edges are not quite straight.
const FLOOR_PX: f32 = 0.005;

/// Standard deviation of rounding to whole grey levels.
const ROUNDING: f32 = 0.29;

/// Initial guess of a saddle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guess {
    pub(crate) place: Point,
    /// Directions of the edges, of any length; the quadrant between them is the brighter one where the swing is
    /// positive.
    pub(crate) edges: [Point; 2],
    /// Grey of that quadrant minus that of its neighbours; negative where it is darker.
    pub(crate) step: f32,
    /// Radius within which nothing else is visible, in pixels.
    pub(crate) radius_px: f32,
    /// Distance of black squares from the edges, in pixels: half the width of a white line between them, 0 where they
    /// touch.
    pub(crate) gap_px: f32,
}

/// Position of a saddle, in pixels, and its covariance (xx, xy, yy).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saddle {
    pub(crate) place: Point,
    pub(crate) covariance: [f32; 3],
}

/// Finds the saddle, if there is one.
#[inline(always)]
pub(crate) fn find(image: &Image<'_>, guess: &Guess) -> Option<Saddle> {
    const MOST_STEPS: usize = 8;
    const REST_PX: f32 = 0.01;
    // Where edges fall exactly between pixels the first position is already right, and only the blur is not.
    const BLUR_REST_PX: f32 = 0.1;
    let mut model = Model::start(guess)?;
    let mut window = Window::around(image, guess.place, guess.radius_px)?;
    for _ in 0..MOST_STEPS {
        let step = window.equations(&model).solve()?;
        let before = model;
        model = model.after(&step);
        if distance(model.place, guess.place) > guess.radius_px {
            return None;
        }
        window = Window::around(image, model.place, guess.radius_px)?;
        let sharpened_px = (model.blur_px - before.blur_px).abs();
        if step[0].hypot(step[1]) < REST_PX && sharpened_px < BLUR_REST_PX {
            break;
        }
    }
    let equations = window.equations(&model);
    let residual = equations.residual()?;
    let is_saddle = SWING.contains(&(2.0 * model.swing / guess.step))
        && model.blur_px < MOST_BLUR * guess.radius_px
        && residual < MOST_RESIDUAL * model.swing.abs()
        && model.is_plausible(guess);
    let by_noise = equations.matrix.cholesky()?.inverse() * residual.max(ROUNDING).powi(2);
    let floor = FLOOR_PX * FLOOR_PX;
    let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|at| by_noise[at]);
    let covariance = [xx + floor, xy, yy + floor];
    let is_known = covariance.iter().all(|value| value.is_finite()) && xx + yy < 0.5;
    (is_saddle && is_known).then_some(Saddle {
        place: model.place,
        covariance,
    })
}

/// The pixels around a position.
struct Window<'a> {
    image: &'a Image<'a>,
    place: Point,
    radius_px: f32,
}

impl<'a> Window<'a> {
    /// `None` where the image ends within them.
    fn around(image: &'a Image<'a>, place: Point, radius_px: f32) -> Option<Self> {
        let [width, height] = [image.width(), image.height()].map(|size| (size - 1) as f32);
        let within = |at: f32, last: f32| at >= radius_px && at <= last - radius_px;
        (within(place[0], width) && within(place[1], height)).then_some(Self {
            image,
            place,
            radius_px,
        })
    }

    #[inline(always)]
    fn equations(&self, model: &Model) -> SaddleEquations {
        let mut equations = SaddleEquations::default();
        let [x, y] = self.place;
        let squared = self.radius_px * self.radius_px;
        let span = |at: f32| (at - self.radius_px).ceil() as usize..=(at + self.radius_px) as usize;
        for row in span(y) {
            let greys = self.image.row(row);
            for column in span(x) {
                let at = [column as f32, row as f32];
                if (at[0] - x).powi(2) + (at[1] - y).powi(2) <= squared {
                    let (grey, derivatives) = model.grey(at);
                    equations.add(&derivatives, f32::from(greys[column]) - grey);
                }
            }
        }
        equations
    }
}

#[derive(Clone, Copy, Debug)]
struct Model {
    place: Point,
    /// Directions of the edges, in radians.
    angles: [f32; 2],
    blur_px: f32,
    mean: f32,
    swing: f32,
    gap_px: f32,
}

/// The saddle's shape, from -1 to 1, and its derivatives with respect to the distances from both edges and the blur.
struct Shape {
    value: f32,
    by_a: f32,
    by_b: f32,
    by_blur: f32,
}

impl Model {
    fn start(guess: &Guess) -> Option<Self> {
        const USUAL_BLUR_PX: f32 = 0.8;
        let angles = guess.edges.map(|[x, y]| y.atan2(x));
        // Mean and swing are linear parameters: the first step finds them.
        let model = Self {
            place: guess.place,
            angles,
            blur_px: USUAL_BLUR_PX,
            mean: 128.0,
            swing: guess.step / 2.0,
            gap_px: guess.gap_px,
        };
        angles
            .iter()
            .all(|angle| angle.is_finite())
            .then_some(model)
    }

    /// Grey at a pixel, and its derivatives with respect to position (2), angles (2), blur, mean and swing.
    #[inline(always)]
    fn grey(&self, [x, y]: Point) -> (f32, Vector) {
        let away = [x - self.place[0], y - self.place[1]];
        // The second edge is traversed in the opposite direction, so that the product is positive between the two.
        let [a, b] = [0, 1].map(|edge| {
            let (sin, cos) = self.angles[edge].sin_cos();
            let turn = if edge == 0 { 1.0 } else { -1.0 };
            let normal = [-sin * turn, cos * turn];
            let beyond = normal[0] * away[0] + normal[1] * away[1];
            let along = (cos * away[0] + sin * away[1]) * turn;
            (normal, beyond, along)
        });
        let shape = match self.gap_px > 0.0 {
            true => self.gapped(a.1, b.1),
            false => self.touching(a.1, b.1),
        };
        let swing = self.swing;
        let (by_a, by_b) = (swing * shape.by_a, swing * shape.by_b);
        let derivatives = [
            -(by_a * a.0[0] + by_b * b.0[0]),
            -(by_a * a.0[1] + by_b * b.0[1]),
            -by_a * a.2,
            -by_b * b.2,
            swing * shape.by_blur,
            1.0,
            shape.value,
        ];
        (self.mean + swing * shape.value, Vector::from(derivatives))
    }

    /// Black squares that touch: the product of both edges' step responses.
    #[inline(always)]
    fn touching(&self, a: f32, b: f32) -> Shape {
        let [(step_a, slope_a), (step_b, slope_b)] = [a, b].map(|at| {
            let (step, slope) = step(at / self.blur_px);
            (step, slope / self.blur_px)
        });
        let (by_a, by_b) = (slope_a * step_b, step_a * slope_b);
        Shape {
            value: step_a * step_b,
            by_a,
            by_b,
            by_blur: -(by_a * a + by_b * b) / self.blur_px,
        }
    }

    /// Black squares apart from each other: each is the product of the step responses of its own edges.
    fn gapped(&self, a: f32, b: f32) -> Shape {
        let sign = self.swing.signum();
        // Black lies where both have the same sign.
        let across = -sign * b;
        let mut shape = Shape {
            value: 1.0,
            by_a: 0.0,
            by_b: 0.0,
            by_blur: 0.0,
        };
        for side in [1.0, -1.0] {
            let [(at_a, in_a, slope_a), (at_b, in_b, slope_b)] = [a, across].map(|at| {
                let inside = side * at - self.gap_px;
                let (step, slope) = step(inside / self.blur_px);
                (inside, 1.0 + step, slope / self.blur_px)
            });
            // Half the share of black, of which white has none.
            shape.value -= in_a * in_b / 2.0;
            shape.by_a -= side * slope_a * in_b / 2.0;
            shape.by_b += sign * side * in_a * slope_b / 2.0;
            shape.by_blur += (slope_a * at_a * in_b + in_a * slope_b * at_b) / 2.0 / self.blur_px;
        }
        Shape {
            value: sign * shape.value,
            by_a: sign * shape.by_a,
            by_b: sign * shape.by_b,
            by_blur: sign * shape.by_blur,
        }
    }

    fn after(&self, step: &Vector) -> Self {
        const MOST_PX: f32 = 1.0;
        const MOST_TURN: f32 = 0.2;
        let moved = |at: f32, by: f32, most: f32| at + by.clamp(-most, most);
        Self {
            place: [0, 1].map(|axis| moved(self.place[axis], step[axis], MOST_PX)),
            angles: [0, 1].map(|edge| moved(self.angles[edge], step[2 + edge], MOST_TURN)),
            blur_px: moved(self.blur_px, step[4], 0.3).clamp(0.3, 4.0),
            mean: self.mean + step[5],
            swing: self.swing + step[6],
            gap_px: self.gap_px,
        }
    }

    /// Whether the directions of the edges are close to the expected ones.
    fn is_plausible(&self, guess: &Guess) -> bool {
        const MOST_TURN_SINE: f32 = 0.4;
        let turned = |edge: usize| {
            let [x, y] = guess.edges[edge];
            let (sin, cos) = self.angles[edge].sin_cos();
            (x * sin - y * cos) / x.hypot(y)
        };
        (0..2).all(|edge| turned(edge).abs() < MOST_TURN_SINE)
    }
}

/// Step response of the blur, from -1 to 1, approximately the error function of x / sqrt 2; and its slope.
#[inline(always)]
fn step(x: f32) -> (f32, f32) {
    // tanh(0.798 (x + 0.0447 x^3)) by its continued fraction.
    const SCALE: f32 = 0.797_884_6;
    const CUBE: f32 = 0.044_715;
    const END: f32 = 3.0;
    let x = x.clamp(-4.0, 4.0);
    let inner = (SCALE * (x + CUBE * x * x * x)).clamp(-END, END);
    let square = inner * inner;
    let step = inner * (27.0 + square) / (27.0 + 9.0 * square);
    let slope = (1.0 - step * step) * SCALE * (1.0 + 3.0 * CUBE * x * x);
    (step, slope.max(0.0))
}

#[derive(Default)]
struct SaddleEquations {
    matrix: Matrix,
    vector: Vector,
    squares: f32,
    n: usize,
}

impl SaddleEquations {
    #[inline(always)]
    fn add(&mut self, derivatives: &Vector, residual: f32) {
        self.matrix.syger(1.0, derivatives, derivatives, 1.0);
        self.vector.axpy(residual, derivatives, 1.0);
        self.squares += residual * residual;
        self.n += 1;
    }

    fn solve(&self) -> Option<Vector> {
        Some(self.damped().cholesky()?.solve(&self.vector))
    }

    fn damped(&self) -> Matrix {
        let mut matrix = self.matrix;
        for i in 0..PARAMETERS {
            matrix[(i, i)] *= 1.0 + 1e-4;
        }
        matrix
    }

    /// Standard deviation of the residuals, in grey levels.
    fn residual(&self) -> Option<f32> {
        let spare = self.n.checked_sub(PARAMETERS).filter(|spare| *spare > 0)?;
        Some((self.squares / spare as f32).sqrt())
    }
}
