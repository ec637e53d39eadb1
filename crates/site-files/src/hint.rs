//! Suggestion of a known word for a misspelled one.

/// The nearest known word, if at most a third of the letters differ, or two in short words.
pub(crate) fn nearest<'a>(unknown: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|word| (edits(unknown, word), *word))
        .filter(|(edits, word)| *edits <= (word.chars().count() / 3).max(2))
        .min()
        .map(|(_, word)| word)
}

/// Letters to insert, drop or replace between two words (V. Levenshtein, 1966), one row at a time.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_word_is_the_one_meant() {
        let known = ["resolution", "lens", "id", "world_from_camera"];
        assert_eq!(nearest("resolutoin", &known), Some("resolution"));
        assert_eq!(nearest("lense", &known), Some("lens"));
        assert_eq!(nearest("world_from_cam", &known), Some("world_from_camera"));
        assert_eq!(nearest("colour", &known), None);
    }

    #[test]
    fn edits_count_letters() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("abc", "abc"), 0);
    }
}
