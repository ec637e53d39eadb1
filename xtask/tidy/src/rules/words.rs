//! Words that say less than the term of the field for what they mean, in comments and in names.

use super::Finding;
use crate::source::{Rust, Source};

/// Phrases of comments, with what to write.
const PHRASES: &[(&str, &str)] = &[
    ("foretell", "predict"),
    ("foretells", "predicts"),
    ("foretold", "predicted"),
    ("speak against", "name the test or the likelihood"),
    ("speaks against", "name the test or the likelihood"),
    ("held against", "name the test or the likelihood"),
    ("taken for", "counts as, or is used as"),
    ("at its word", "counts as exact"),
    ("nobody says", "is unknown"),
    ("nobody said", "is unknown"),
    ("to blame", "the cause, invalid, or faulty"),
    ("as is stated", "as configured, or as reported"),
    ("what is stated", "the configured or the reported deviation"),
    ("stated deviation", "reported, or configured"),
    ("stated deviations", "reported, or configured"),
    ("stated standard deviation", "reported, or configured"),
    ("stated standard deviations", "reported, or configured"),
    ("believed", "accepted, or configured"),
    ("told", "published, reported, estimated or given"),
    ("hang together", "are correlated"),
    ("hangs together", "is correlated"),
    ("who is wrong", "fault isolation"),
    ("vouches for", "verifies"),
    ("accused", "suspected, or under test"),
    ("convict", "confirm"),
    ("convicted", "confirmed"),
    ("testimony", "measurement"),
];
/// Parts of names, with what to write.
const PARTS: &[(&str, &str)] = &[
    ("wish", "request"),
    ("told", "published, reported, estimated or given"),
    ("believed", "accepted, or configured"),
    ("foretold", "predicted"),
    ("accused", "suspect"),
    ("convict", "confirm"),
    ("testimony", "measurement"),
    ("contender", "hypothesis"),
];

pub fn check(source: &Source, rust: &Rust) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, comment) in rust.comments.iter().enumerate() {
        let next = rust.comments.get(i + 1);
        let next = next.filter(|next| next.line == comment.line + 1);
        // Phrases go over the end of a line.
        let text = format!("{} {}", comment.text, next.map_or("", |next| &next.text));
        let text = text.to_lowercase();
        for (phrase, remedy) in PHRASES {
            let begins_here = |at: &usize| *at < comment.text.len();
            if occurrences(&text, phrase).any(|at| begins_here(&at)) {
                let remedy = format!("\"{phrase}\": {remedy}");
                findings.push(Finding::new(&source.path, comment.line, "words", remedy));
            }
        }
    }
    for identifier in &rust.identifiers {
        for (part, remedy) in PARTS {
            if parts(&identifier.name).any(|it| it == *part) {
                let remedy = format!("{} has \"{part}\": {remedy}", identifier.name);
                findings.push(Finding::new(&source.path, identifier.line, "words", remedy));
            }
        }
    }
    findings
}

/// Where a phrase stands as whole words.
fn occurrences<'a>(text: &'a str, phrase: &'a str) -> impl Iterator<Item = usize> + 'a {
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(phrase).filter_map(move |(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + phrase.len()..].chars().next();
        (!is_word(before) && !is_word(after)).then_some(at)
    })
}

/// The words of a name in either case style, in lower case.
fn parts(name: &str) -> impl Iterator<Item = String> {
    let mut parts = vec![String::new()];
    for c in name.chars() {
        if c == '_'
            || c.is_uppercase()
                && parts
                    .last()
                    .is_some_and(|it| !it.ends_with(char::is_uppercase))
        {
            parts.push(String::new());
        }
        if c != '_'
            && let Some(part) = parts.last_mut()
        {
            part.push(c);
        }
    }
    parts.into_iter().map(|part| part.to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let source = Source::new("a.rs", text.to_owned()).unwrap();
        let rust = source.rust.as_ref().unwrap();
        let findings = check(&source, rust);
        findings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_phrase_is_found_over_the_end_of_a_line_and_not_within_words_or_strings() {
        let text = "// It is taken\n// for another one.\nfn f() {}\n// Untold, retold.\n\
            const A: &str = \"\n// told\";\n";
        let expected = "a.rs:1: words: \"taken for\": counts as, or is used as";
        assert_eq!(found(text), [expected]);
    }

    #[test]
    fn a_part_of_a_name_is_found_in_every_case() {
        let text = "struct BoardWish; const MOST_TOLD: u8 = 0; fn is_believed() {} fn untold() {}";
        let parts = ["wish", "told", "believed"].map(|part| format!("has \"{part}\""));
        let found = found(text);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(
            found
                .iter()
                .zip(&parts)
                .all(|(found, part)| found.contains(part))
        );
    }
}
