//! Text in Noto Sans Mono (SIL Open Font License 1.1), rasterised at build time.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Size and weight of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Font {
    /// 16 pixels a line.
    Body,
    /// 24 pixels a line, bold.
    Heading,
}

impl Font {
    /// Width and height of a line of text, pixels.
    pub fn extent(self, text: &str) -> [usize; 2] {
        let (weight, height) = self.raster();
        let width = get_raster_width(weight, height);
        [text.chars().count() * width, height.val()]
    }

    /// The pixels of a line of text that have ink: column, row, and how much from 0 to 1. A character that the font
    /// lacks is drawn as a question mark.
    pub(crate) fn ink(self, text: &str) -> impl Iterator<Item = ([usize; 2], f32)> {
        let (weight, height) = self.raster();
        let glyph = move |letter| get_raster(letter, weight, height);
        let glyphs = text
            .chars()
            .map(move |letter| glyph(letter).or_else(|| glyph('?')));
        let advance = get_raster_width(weight, height);
        glyphs.enumerate().flat_map(move |(i, glyph)| {
            let pixels = glyph.map_or(&[][..], |glyph| glyph.pixels());
            let pixels = pixels.iter().enumerate().filter(|(_, ink)| **ink > 0);
            pixels.map(move |(at, ink)| {
                (
                    [i * advance + at % advance, at / advance],
                    f32::from(*ink) / 255.0,
                )
            })
        })
    }

    fn raster(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Body => (FontWeight::Regular, RasterHeight::Size16),
            Self::Heading => (FontWeight::Bold, RasterHeight::Size24),
        }
    }
}

/// Lines of body text that fit into a width.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if Font::Body.extent(&format!("{line} {word}"))[0] <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use crate::*;

    #[test]
    fn ink_lies_within_the_extent_of_the_text() {
        for font in [Font::Body, Font::Heading] {
            let [width, height] = font.extent("Ag|é");
            let ink: Vec<_> = font.ink("Ag|é").collect();
            let last = ink.iter().map(|([x, _], _)| *x).max().unwrap();
            assert!(last < width && last >= width / 4 * 3, "{last} of {width}");
            assert!(
                ink.iter()
                    .all(|([_, y], share)| *y < height && *share <= 1.0)
            );
        }
    }

    #[test]
    fn lines_end_between_words() {
        let width = Font::Body.extent("one two")[0];
        assert_eq!(wrapped("one two three", width), ["one two", "three"]);
        assert!(wrapped("", width).is_empty());
    }
}
