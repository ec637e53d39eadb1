//! Pages as a PDF file: black areas, grey lines and Helvetica, all in millimetres from the lower left corner of the
//! paper.
//!
//! Follows ISO 32000-1 (PDF 1.7): objects, cross-reference table, and uncompressed content, so that a person can
//! read it. The file asks viewers not to scale it (12.2, `PrintScaling`). Equal pages give
//! equal bytes.

use std::fmt::Write as _;

/// PDF points per millimetre.
const POINTS_PER_MM: f64 = 72.0 / 25.4;

/// A rectangle, millimetres: lower left corner, width, height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Left edge.
    pub x: f64,
    /// Lower edge.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

/// Style of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// A black line of a ruler.
    Ruler,
    /// A thin grey cutting line.
    Cut,
    /// A dashed grey folding line.
    Fold,
}

/// An element of a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// Black areas, filled as one shape so that no hairline shows between neighbours.
    Black(Vec<Area>),
    /// A line through points.
    Line(Stroke, Vec<[f64; 2]>),
    /// A line of text: start of its base line, font size, and the words.
    Text([f64; 2], f64, String),
}

/// A page of a PDF, by its size and marks.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Width and height of the paper.
    pub size: [f64; 2],
    /// Elements in drawing order.
    pub marks: Vec<Mark>,
}

/// The PDF file of these pages.
pub fn pdf(title: &str, pages: &[Page]) -> Vec<u8> {
    let first_page = 5;
    let kids: Vec<String> = (0..pages.len())
        .map(|page| format!("{} 0 R", first_page + 2 * page))
        .collect();
    let mut objects = vec![
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>".to_owned(),
        format!(
            "<< /Type /Pages /Kids [{}] /Count {} >>",
            kids.join(" "),
            pages.len()
        ),
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>"
            .to_owned(),
        format!("<< /Title ({}) /Producer (Sextant) >>", escaped(title)),
    ];
    for (index, page) in pages.iter().enumerate() {
        let content = content_of(page);
        let [width, height] = page.size.map(|mm| mm * POINTS_PER_MM);
        objects.push(format!(
            "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.4} {height:.4}] \
             /Resources << /Font << /F1 3 0 R >> >> /Contents {} 0 R >>",
            first_page + 2 * index + 1
        ));
        objects.push(format!(
            "<< /Length {} >>\nstream\n{content}endstream",
            content.len()
        ));
    }
    file_of(&objects)
}

/// Header, numbered objects, cross-reference table, and trailer.
fn file_of(objects: &[String]) -> Vec<u8> {
    let mut text = String::from("%PDF-1.7\n");
    let mut places = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        places.push(text.len());
        // Writing to a String cannot fail.
        let _ = write!(text, "{} 0 obj\n{object}\nendobj\n", index + 1);
    }
    let table = text.len();
    let _ = write!(text, "xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for place in places {
        let _ = writeln!(text, "{place:010} 00000 n ");
    }
    let _ = write!(
        text,
        "trailer\n<< /Size {} /Root 1 0 R /Info 4 0 R >>\nstartxref\n{table}\n%%EOF\n",
        objects.len() + 1
    );
    text.into_bytes()
}

fn content_of(page: &Page) -> String {
    let mut text = format!("{POINTS_PER_MM:.10} 0 0 {POINTS_PER_MM:.10} 0 0 cm\n");
    for mark in &page.marks {
        match mark {
            Mark::Black(areas) => fill(&mut text, areas),
            Mark::Line(stroke, points) => draw_line(&mut text, *stroke, points),
            Mark::Text([x, y], height, words) => {
                let words = escaped(words);
                let _ = writeln!(
                    text,
                    "BT /F1 {height:.4} Tf 0 g {x:.5} {y:.5} Td ({words}) Tj ET"
                );
            }
        }
    }
    text
}

fn fill(text: &mut String, areas: &[Area]) {
    text.push_str("0 g\n");
    for area in areas {
        let _ = writeln!(
            text,
            "{:.5} {:.5} {:.5} {:.5} re",
            area.x, area.y, area.width, area.height
        );
    }
    text.push_str("f\n");
}

fn draw_line(text: &mut String, stroke: Stroke, points: &[[f64; 2]]) {
    text.push_str(match stroke {
        Stroke::Ruler => "[] 0 d 0.15 w 0 G\n",
        Stroke::Cut => "[] 0 d 0.1 w 0.75 G\n",
        Stroke::Fold => "[1.5 1] 0 d 0.1 w 0.6 G\n",
    });
    for (index, [x, y]) in points.iter().enumerate() {
        let _ = writeln!(text, "{x:.5} {y:.5} {}", if index == 0 { "m" } else { "l" });
    }
    text.push_str("S\n");
}

/// A PDF string: Latin letters only, brackets and backslashes escaped.
fn escaped(words: &str) -> String {
    let mut text = String::new();
    for letter in words.chars() {
        match letter {
            '(' | ')' | '\\' => text.extend(['\\', letter]),
            ' '..='~' => text.push(letter),
            _ => text.push('?'),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> String {
        let marks = vec![Mark::Text([10.0, 10.0], 3.0, "a (b) \\ \u{1b}ü".into())];
        let page = Page {
            size: [210.0, 297.0],
            marks,
        };
        String::from_utf8(pdf("title", &[page.clone(), page])).unwrap()
    }

    #[test]
    fn every_object_stands_where_the_table_says() {
        let text = file();
        let (_, table) = text.split_once("xref\n").unwrap();
        let places: Vec<usize> = table
            .lines()
            .skip(2)
            .take_while(|line| line.ends_with(" n "))
            .map(|line| line[..10].parse().unwrap())
            .collect();
        assert_eq!(places.len(), 8);
        for (index, place) in places.into_iter().enumerate() {
            assert!(text[place..].starts_with(&format!("{} 0 obj\n", index + 1)));
        }
        let start: usize = text
            .split_once("startxref\n")
            .and_then(|(_, rest)| rest.lines().next()?.parse().ok())
            .unwrap();
        assert!(text[start..].starts_with("xref"));
    }

    #[test]
    fn streams_are_as_long_as_they_say() {
        let text = file();
        let (_, rest) = text.split_once("/Length ").unwrap();
        let (length, rest) = rest.split_once(" >>\nstream\n").unwrap();
        let length: usize = length.parse().unwrap();
        assert!(rest[length..].starts_with("endstream"));
    }

    #[test]
    fn text_cannot_end_its_own_string() {
        assert!(file().contains("(a \\(b\\) \\\\ ??) Tj"));
    }
}
