//! Colour pictures for reports: a canvas with lines, areas and text, and the parts that several pictures share.
//!
//! Coordinates are pixels of the canvas with (0, 0) at the top left *edge*, x right, y down.

mod canvas;
mod legend;
mod text;

pub use canvas::{Canvas, CanvasView, Colour};
pub use legend::{LegendLine, legend_height, legend_width, write_legend};
pub use text::{Font, wrapped};

/// Colour of the background.
pub const GROUND: Colour = [24, 26, 30];
/// Colour of text on [`GROUND`].
pub const INK: Colour = [235, 235, 235];
/// Text of less weight.
pub const FAINT: Colour = [165, 168, 175];
