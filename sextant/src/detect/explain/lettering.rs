//! Letters of 5x8 dots, drawn for this program, for pictures that must not depend on a font of the machine.
//!
//! `letters.txt` has a line a letter: the letter, then its five columns in hexadecimal, the lowest bit on top. Capitals are
//! drawn as small letters; what the table lacks is drawn as a gap.

use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Dots from one letter to the next.
pub const ADVANCE: usize = 6;
/// Dots of a letter's height.
pub const HEIGHT: usize = 8;

const TABLE: &str = include_str!("letters.txt");

/// The dots of a text: columns from the left, rows from the top.
pub fn dots(text: &str) -> impl Iterator<Item = (usize, usize)> {
    text.chars().enumerate().flat_map(|(i, letter)| {
        let columns = letters().get(&letter.to_ascii_lowercase());
        let columns = columns.copied().unwrap_or_default();
        (0..columns.len() * HEIGHT)
            .map(|k| (k / HEIGHT, k % HEIGHT))
            .filter(move |&(x, y)| columns[x] >> y & 1 == 1)
            .map(move |(x, y)| (i * ADVANCE + x, y))
    })
}

fn letters() -> &'static BTreeMap<char, [u8; 5]> {
    static LETTERS: OnceLock<BTreeMap<char, [u8; 5]>> = OnceLock::new();
    LETTERS.get_or_init(|| TABLE.lines().filter_map(letter_of).collect())
}

fn letter_of(line: &str) -> Option<(char, [u8; 5])> {
    let mut fields = line.split(' ');
    let letter = fields.next()?.chars().next()?;
    let mut columns = [0; 5];
    for column in &mut columns {
        *column = u8::from_str_radix(fields.next()?, 16).ok()?;
    }
    Some((letter, columns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_is_a_letter() {
        assert_eq!(letters().len(), TABLE.lines().count());
    }

    #[test]
    fn an_l_is_a_bar_with_a_foot() {
        let column = |x| dots("L").filter(|dot| dot.0 == x).count();
        assert_eq!([0, 1, 2, 3, 4].map(column), [0, 2, 7, 1, 0]);
        assert_eq!(dots("L-").map(|dot| dot.0).max(), Some(ADVANCE + 4));
    }
}
