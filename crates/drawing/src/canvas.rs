//! The canvas: areas, lines, text and grey pictures on a colour image.

use crate::Font;
use sextant_recordings::{ColourImage, GreyImage};
use std::ops::Range;

/// Red, green and blue, 0 to 255 each.
pub type Colour = [u8; 3];

/// Width of lines, pixels of the canvas.
const LINE_PX: f32 = 2.0;

/// What is drawn on.
pub struct Canvas {
    image: ColourImage,
}

/// Where a part of a picture lies on a canvas: a point of the picture, (0, 0) at the centre of its first pixel, times
/// `scale`, and so on.
#[derive(Clone, Copy, Debug)]
pub struct CanvasView {
    /// Pixels of the canvas per pixel of the picture.
    pub scale: f32,
    /// Top left corner of the visible part of the image.
    pub from: [f32; 2],
    /// Where that is on the canvas.
    pub to: [f32; 2],
}

impl CanvasView {
    /// A point of the picture on the canvas.
    pub fn at(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let axis = |value: f32, i: usize| (value + 0.5 - self.from[i]) * self.scale + self.to[i];
        [axis(x, 0), axis(y, 1)]
    }

    /// The pixel of the picture that shows at a pixel of the canvas; negative or too great outside the picture.
    fn pixel(&self, value: usize, i: usize) -> isize {
        ((value as f32 + 0.5 - self.to[i]) / self.scale + self.from[i]).floor() as isize
    }
}

impl Canvas {
    /// An area of one colour.
    pub fn new(width: usize, height: usize, colour: Colour) -> Self {
        let pixels = colour.repeat(width * height);
        let image = ColourImage {
            width,
            height,
            pixels,
        };
        Self { image }
    }

    /// The picture with everything drawn so far.
    pub fn image(&self) -> &ColourImage {
        &self.image
    }

    /// A picture in a rectangle of the canvas, its greys in colours.
    pub fn show(
        &mut self,
        picture: &GreyImage,
        view: &CanvasView,
        [columns, rows]: [Range<usize>; 2],
        colour_of: impl Fn(u8) -> Colour,
    ) {
        for y in rows {
            let row = usize::try_from(view.pixel(y, 1)).unwrap_or(usize::MAX);
            for x in columns.clone() {
                let column = usize::try_from(view.pixel(x, 0)).unwrap_or(usize::MAX);
                if column < picture.width && row < picture.height {
                    let grey = picture.pixels[row * picture.width + column];
                    self.blend([x as isize, y as isize], colour_of(grey), 1.0);
                }
            }
        }
    }

    /// A rectangle of one colour.
    pub fn fill(&mut self, [columns, rows]: [Range<usize>; 2], colour: Colour) {
        for y in rows {
            for x in columns.clone() {
                self.blend([x as isize, y as isize], colour, 1.0);
            }
        }
    }

    /// A straight line with soft edges.
    pub fn line(&mut self, a: [f32; 2], b: [f32; 2], colour: Colour) {
        let reach = LINE_PX / 2.0 + 1.0;
        let span = |i: usize, limit: usize| {
            let low = (a[i].min(b[i]) - reach).max(0.0) as isize;
            let high = (a[i].max(b[i]) + reach).min(limit as f32) as isize;
            low..high
        };
        for y in span(1, self.image.height) {
            for x in span(0, self.image.width) {
                let away = distance([x as f32 + 0.5, y as f32 + 0.5], a, b);
                let share = (LINE_PX / 2.0 + 0.5 - away).clamp(0.0, 1.0);
                self.blend([x, y], colour, share);
            }
        }
    }

    /// A closed line through four points.
    pub fn outline(&mut self, corners: [[f32; 2]; 4], colour: Colour) {
        for i in 0..4 {
            self.line(corners[i], corners[(i + 1) % 4], colour);
        }
    }

    /// A cross with arms of a length.
    pub fn cross(&mut self, [x, y]: [f32; 2], arm: f32, colour: Colour) {
        self.line([x - arm, y], [x + arm, y], colour);
        self.line([x, y - arm], [x, y + arm], colour);
    }

    /// A line of text with its top left at a point.
    pub fn write(&mut self, [left, top]: [usize; 2], font: Font, text: &str, colour: Colour) {
        for ([x, y], share) in font.ink(text) {
            self.blend([(left + x) as isize, (top + y) as isize], colour, share);
        }
    }

    /// A line of text centred on a point, on a black box.
    pub fn label(&mut self, [x, y]: [f32; 2], font: Font, text: &str, colour: Colour) {
        const BOX: Colour = [0, 0, 0];
        const MARGIN: usize = 2;
        let [width, height] = font.extent(text);
        let from = |middle: f32, extent: usize| (middle - extent as f32 / 2.0).max(0.0) as usize;
        let (left, top) = (from(x, width), from(y, height));
        let around = |low: usize, extent: usize| low.saturating_sub(MARGIN)..low + extent + MARGIN;
        self.fill([around(left, width), top..top + height], BOX);
        self.write([left, top], font, text, colour);
    }

    /// Another canvas with its top left at a pixel of this.
    pub fn place(&mut self, [left, top]: [usize; 2], part: &Self) {
        let colours = part.image.pixels.chunks_exact(3).enumerate();
        for (i, colour) in colours {
            let (x, y) = (left + i % part.image.width, top + i / part.image.width);
            self.blend(
                [x as isize, y as isize],
                [colour[0], colour[1], colour[2]],
                1.0,
            );
        }
    }

    /// Nothing outside the canvas.
    fn blend(&mut self, [x, y]: [isize; 2], colour: Colour, share: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return;
        };
        if x >= self.image.width || y >= self.image.height {
            return;
        }
        let at = 3 * (y * self.image.width + x);
        for (old, new) in self.image.pixels[at..at + 3].iter_mut().zip(colour) {
            *old = (f32::from(*old) * (1.0 - share) + f32::from(new) * share).round() as u8;
        }
    }
}

/// From a point to the line from a to b.
fn distance(point: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let [px, py] = [point[0] - a[0], point[1] - a[1]];
    let along = ((px * dx + py * dy) / (dx * dx + dy * dy).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (px - along * dx).hypot(py - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_outside_the_canvas_is_not_drawn() {
        let mut canvas = Canvas::new(4, 4, [0; 3]);
        canvas.line([-10.0, -10.0], [-5.0, 20.0], [255; 3]);
        canvas.fill([4..9, 0..9], [255; 3]);
        canvas.label([900.0, -900.0], Font::Body, "far", [255; 3]);
        canvas.line([f32::NAN, 0.0], [f32::INFINITY, 3.0], [255; 3]);
        assert!(canvas.image().pixels.iter().all(|&value| value == 0));
    }

    #[test]
    fn a_pixel_of_the_picture_covers_its_square_of_the_canvas() {
        let picture = GreyImage {
            width: 2,
            height: 1,
            pixels: vec![10, 20],
        };
        let view = CanvasView {
            scale: 2.0,
            from: [0.0, 0.0],
            to: [1.0, 0.0],
        };
        let mut canvas = Canvas::new(6, 2, [0; 3]);
        canvas.show(&picture, &view, [0..6, 0..2], |grey| [grey; 3]);
        let row: Vec<u8> = canvas.image().pixels.chunks(3).map(|p| p[0]).collect();
        assert_eq!(row, [0, 10, 10, 20, 20, 0, 0, 10, 10, 20, 20, 0]);
        assert_eq!(view.at([1.0, 0.0]), [4.0, 1.0]);
    }
}
