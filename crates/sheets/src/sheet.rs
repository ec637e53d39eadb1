//! A sheet of paper under construction: tags in true size, rulers, notes. Millimetres from the lower left corner.

use crate::pdf::{Area, Mark, Page, Stroke};
use sextant_site_model::TagId;
use sextant_tag_families::{Board, module_is_white};

/// Margin that most printers cannot print, millimetres.
pub const MARGIN: f64 = 10.0;
/// Height of small print.
pub const SMALL: f64 = 2.1;
/// Font size of notes.
pub const NOTE: f64 = 3.2;
/// Length of the rulers.
pub const RULER: f64 = 100.0;

/// Size of the paper that a sheet is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paper {
    /// 210 x 297 mm.
    A4,
    /// 8.5 x 11 inches.
    Letter,
}

impl Paper {
    /// Width and height, millimetres.
    pub fn size(self) -> [f64; 2] {
        match self {
            Self::A4 => [210.0, 297.0],
            Self::Letter => [215.9, 279.4],
        }
    }

    /// Name of the size, as printers list it.
    pub fn name(self) -> &'static str {
        match self {
            Self::A4 => "A4",
            Self::Letter => "Letter",
        }
    }
}

/// A sheet under construction.
pub struct Sheet {
    page: Page,
}

impl Sheet {
    /// An empty sheet of this paper.
    pub fn new(paper: Paper) -> Self {
        Self {
            page: Page {
                size: paper.size(),
                marks: Vec::new(),
            },
        }
    }

    /// The page with all marks added so far.
    pub fn into_page(self) -> Page {
        self.page
    }

    /// Adds an upright tag centred at a point; `size` is the edge of its black square, or of a ChArUco board's marker.
    /// Squares at the corners of an AprilGrid's tag are separate: [`Self::squares`].
    pub fn tag(&mut self, tag: TagId, centre: [f64; 2], size: f64) {
        let across = usize::from(tag.family.data().total_width);
        let module = module_of(tag, size);
        let half = module * across as f64 / 2.0;
        let [left, top] = [centre[0] - half, centre[1] + half];
        let ring = usize::from(tag.family.data().board == Some(Board::Aprilgrid));
        let end = across - ring;
        let mut areas = Vec::new();
        for row in ring..end {
            let black = |column: usize| !module_is_white(tag.family, tag.id, column, row);
            let mut column = ring;
            while column < end {
                let run = (column..end).take_while(|&c| black(c)).count();
                if run > 0 {
                    areas.push(Area {
                        x: left + column as f64 * module,
                        y: top - (row + 1) as f64 * module,
                        width: run as f64 * module,
                        height: module,
                    });
                }
                column += run.max(1);
            }
        }
        self.page.marks.push(Mark::Black(areas));
    }

    /// Adds black squares by their lower left corners.
    pub fn squares(&mut self, corners: impl Iterator<Item = [f64; 2]>, edge: f64) {
        let area = |[x, y]: [f64; 2]| Area {
            x,
            y,
            width: edge,
            height: edge,
        };
        self.page
            .marks
            .push(Mark::Black(corners.map(area).collect()));
    }

    /// Adds a line of text.
    pub fn text(&mut self, at: [f64; 2], height: f64, words: impl Into<String>) {
        self.page.marks.push(Mark::Text(at, height, words.into()));
    }

    /// Adds a line through points.
    pub fn line(&mut self, stroke: Stroke, points: &[[f64; 2]]) {
        self.page.marks.push(Mark::Line(stroke, points.to_vec()));
    }

    /// Adds the outline of a square around a centre.
    pub fn square(&mut self, stroke: Stroke, centre: [f64; 2], edge: f64) {
        let half = edge / 2.0;
        let corner = |x: f64, y: f64| [centre[0] + x * half, centre[1] + y * half];
        let [a, b, c, d] = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        self.line(stroke, &[a, b, c, d, a]);
    }

    /// Adds a horizontal ruler of length [`RULER`] with a tick every millimetre and numbers below.
    pub fn ruler_right(&mut self, zero: [f64; 2]) {
        let [x, y] = zero;
        self.line(Stroke::Ruler, &[[x, y], [x + RULER, y]]);
        for mm in 0..=RULER as u32 {
            let at = x + f64::from(mm);
            self.line(Stroke::Ruler, &[[at, y], [at, y + tick(mm)]]);
            if mm % 10 == 0 {
                self.text([at - 0.6, y - SMALL], SMALL, mm.to_string());
            }
        }
        self.text([x + RULER + 3.0, y - SMALL], SMALL, "mm");
    }

    /// Adds a vertical ruler of length [`RULER`] with ticks to the right.
    pub fn ruler_up(&mut self, zero: [f64; 2]) {
        let [x, y] = zero;
        self.line(Stroke::Ruler, &[[x, y], [x, y + RULER]]);
        for mm in 0..=RULER as u32 {
            let at = y + f64::from(mm);
            self.line(Stroke::Ruler, &[[x, at], [x + 0.7 * tick(mm), at]]);
        }
    }

    /// Adds notes line by line, from top to bottom.
    pub fn notes(&mut self, at: [f64; 2], lines: &[String]) {
        for (index, line) in lines.iter().enumerate() {
            let y = at[1] - 1.35 * NOTE * index as f64;
            self.text([at[0], y], NOTE, line.clone());
        }
    }
}

/// Edge of a module.
pub fn module_of(tag: TagId, size: f64) -> f64 {
    size / f64::from(tag.family.data().border_width)
}

/// Edge of the whole printed tag with its white ring.
pub fn printed_edge(tag: TagId, size: f64) -> f64 {
    module_of(tag, size) * f64::from(tag.family.data().total_width)
}

/// Label of a tag: its id and size.
pub fn label_of(tag: TagId, size: f64) -> String {
    format!("{} {}   {}", tag.family, tag.id, length_text(size))
}

/// Formats millimetres without trailing zeros.
pub fn length_text(mm: f64) -> String {
    format!("{} mm", (mm * 100.0).round() / 100.0)
}

fn tick(mm: u32) -> f64 {
    match mm {
        mm if mm % 10 == 0 => 5.0,
        mm if mm % 5 == 0 => 3.5,
        _ => 2.0,
    }
}
