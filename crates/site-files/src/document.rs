//! A TOML text with locations: from a key's path to line and column, and from an offset to the path of its key.

use crate::error::{Complaint, InvalidFile};
use crate::values::{self, Refusal};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A parsed text with the locations of its keys and values.
pub(crate) struct Document<'a> {
    path: &'a Path,
    text: &'a str,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    pub(crate) fn parse(path: &'a Path, text: &'a str) -> Result<Self, InvalidFile> {
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { path, text, root }),
            Err(error) => Err(InvalidFile {
                path: path.to_owned(),
                place: error.span().map(|span| place(text, span.start)),
                complaint: Complaint::new(
                    "",
                    format!("malformed TOML: {}", one_line(error.message())),
                    "see https://toml.io for how it is written",
                ),
            }),
        }
    }

    /// The document as a type of serde; refuses arrays that are too long as well.
    pub(crate) fn read<T: DeserializeOwned>(&self) -> Result<T, InvalidFile> {
        values::read(&self.root).map_err(|refusal| self.refused(refusal))
    }

    /// An error of serde, with location and key.
    fn refused(&self, refusal: Refusal) -> InvalidFile {
        let offset = refusal.span.map(|span| span.start);
        InvalidFile {
            path: self.path.to_owned(),
            place: offset.map(|offset| place(self.text, offset)),
            complaint: Complaint {
                key: offset.map(|offset| self.key_at(offset)).unwrap_or_default(),
                cause: one_line(&refusal.cause),
                remedy: refusal.remedy,
            },
        }
    }

    /// An error of ours, with the location of its value.
    pub(crate) fn complaint(&self, complaint: Complaint) -> InvalidFile {
        InvalidFile {
            path: self.path.to_owned(),
            place: self
                .span_of(&complaint.key)
                .map(|span| place(self.text, span.start)),
            complaint,
        }
    }

    /// Line of the value at a key's path, from 1.
    pub(crate) fn line_of(&self, key: &str) -> Option<usize> {
        self.span_of(key).map(|span| place(self.text, span.start).0)
    }

    /// The whole table.
    pub(crate) fn root(&self) -> &DeTable<'a> {
        self.root.get_ref()
    }

    /// Span of the value at a path such as `camera[1].lens.fx`, or of the deepest part of the path that exists.
    pub(crate) fn span_of(&self, key: &str) -> Option<Range<usize>> {
        let mut span = None;
        let mut table = Some(self.root.get_ref());
        for part in key.split('.').filter(|part| !part.is_empty()) {
            let (name, indices) = split_indices(part);
            let Some(mut value) = table.and_then(|table| table.get(name)) else {
                break;
            };
            for index in indices {
                let items = value.get_ref().as_array();
                let Some(item) = items.and_then(|items| items.get(index)) else {
                    break;
                };
                value = item;
            }
            span = Some(value.span());
            table = value.get_ref().as_table();
        }
        span
    }

    /// Path of the innermost key whose name or value covers an offset.
    fn key_at(&self, offset: usize) -> String {
        let mut path = String::new();
        descend(self.root.get_ref(), offset, &mut path);
        path
    }
}

/// Extends `path` by the keys below `table` that cover `offset`.
fn descend(table: &DeTable<'_>, offset: usize, path: &mut String) {
    for (key, value) in table.iter() {
        let here = key.span().contains(&offset);
        if !here && !covers(value, offset) {
            continue;
        }
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(key.get_ref());
        if !here {
            descend_value(value, offset, path);
        }
        return;
    }
}

fn descend_value(value: &Spanned<DeValue<'_>>, offset: usize, path: &mut String) {
    match value.get_ref() {
        DeValue::Table(table) => descend(table, offset, path),
        DeValue::Array(items) => {
            let found = items.iter().position(|item| covers(item, offset));
            if let Some(index) = found {
                path.push_str(&format!("[{index}]"));
                descend_value(&items[index], offset, path);
            }
        }
        _ => {}
    }
}

/// Whether a value covers an offset. The span of a `[table]` is its header alone, so its members are checked as well.
fn covers(value: &Spanned<DeValue<'_>>, offset: usize) -> bool {
    value.span().contains(&offset)
        || match value.get_ref() {
            DeValue::Table(table) => table
                .iter()
                .any(|(key, value)| key.span().contains(&offset) || covers(value, offset)),
            DeValue::Array(items) => items.iter().any(|item| covers(item, offset)),
            _ => false,
        }
}

/// `tag[2]` to `tag` and 2.
fn split_indices(part: &str) -> (&str, impl Iterator<Item = usize>) {
    let (name, rest) = part.split_once('[').unwrap_or((part, ""));
    let indices = rest
        .split('[')
        .filter_map(|index| index.trim_end_matches(']').parse().ok());
    (name, indices)
}

/// Line and column, from 1; the column counts characters.
fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = 1 + before.matches('\n').count();
    (line, 1 + before[line_start..].chars().count())
}

fn one_line(message: &str) -> String {
    message
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n[[camera]]\nid = \"x\"\n\n[[camera]]\nid = \"ü\"\nlens = { fx = 1.0, cy = [1, 2] }\n";

    fn document() -> Document<'static> {
        Document::parse(Path::new("f.toml"), TEXT).unwrap()
    }

    #[test]
    fn a_path_has_its_place() {
        let document = document();
        let place_of = |key: &str| document.complaint(Complaint::new(key, "", "")).place;
        assert_eq!(place_of("a"), Some((1, 5)));
        assert_eq!(place_of("camera[1].id"), Some((6, 6)));
        assert_eq!(place_of("camera[1].lens.fx"), Some((7, 15)));
        assert_eq!(place_of("camera[1].lens.cy[1]"), Some((7, 29)));
        assert_eq!(place_of("camera[0].missing"), Some((2, 1)));
        assert_eq!(place_of(""), None);
    }

    #[test]
    fn an_offset_has_its_path() {
        let document = document();
        let key_at = |needle: &str| document.key_at(TEXT.find(needle).unwrap());
        assert_eq!(key_at("a = "), "a");
        assert_eq!(key_at("\"x\""), "camera[0].id");
        assert_eq!(key_at("\"ü\""), "camera[1].id");
        assert_eq!(key_at("cy"), "camera[1].lens.cy");
        assert_eq!(key_at("2]"), "camera[1].lens.cy[1]");
    }
}
