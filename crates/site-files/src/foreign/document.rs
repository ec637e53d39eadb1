//! A text of another tool as a tree of values, whatever it is written in: YAML, OpenCV's dialect of it, JSON, XML or
//! TOML.
//!
//! Its first characters say which; the name of the file decides only where they leave it open.

use super::opencv::as_plain_yaml;
use crate::error::{Complaint, FileError, InvalidFile};
use roxmltree::{Document, Node};
use serde::Deserialize;
use std::path::Path;
use yaml_serde::{Deserializer, Mapping, Value};

/// How a text is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Syntax {
    Toml,
    /// Also JSON, which is YAML.
    Yaml,
    Xml,
}

const REMEDY: &str = "export it again from the tool that made it";
/// Elements inside one another in an XML file; OpenCV's have five.
const MOST_LEVELS: usize = 64;

/// The syntax of a text. The first line that is no comment decides: `key = value` and `[table]` are TOML, `key: value`
/// is YAML.
pub(crate) fn syntax_of(path: &Path, text: &str) -> Syntax {
    let text = text.trim_start();
    if text.starts_with('<') {
        return Syntax::Xml;
    }
    if text.starts_with(['{', '%']) {
        return Syntax::Yaml;
    }
    let mut lines = text.lines().map(str::trim);
    let first = lines
        .find(|line| !line.is_empty() && !line.starts_with('#'))
        .unwrap_or_default();
    if first.starts_with("---") || first.starts_with("- ") {
        return Syntax::Yaml;
    }
    match first.find(['=', ':']).map(|at| first.as_bytes()[at]) {
        _ if first.starts_with('[') => Syntax::Toml,
        Some(b'=') => Syntax::Toml,
        Some(_) => Syntax::Yaml,
        None => match has_foreign_name(path) {
            true => Syntax::Yaml,
            false => Syntax::Toml,
        },
    }
}

/// Whether the file name is that of another tool's format.
pub fn has_foreign_name(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| matches!(ending, "yaml" | "yml" | "json" | "xml"))
}

/// The tree of a text.
pub(crate) fn parse_document(path: &Path, text: &str) -> Result<Value, FileError> {
    match syntax_of(path, text) {
        Syntax::Yaml => parse_yaml(path, text),
        Syntax::Xml => parse_xml(path, text),
        Syntax::Toml => toml::from_str(text).map_err(|error| {
            let cause = format!("malformed TOML: {}", error.message());
            malformed(path, None, cause)
        }),
    }
}

/// The first document of a YAML text; `ros2 topic echo` ends each message by `---`.
fn parse_yaml(path: &Path, text: &str) -> Result<Value, FileError> {
    let text = as_plain_yaml(text);
    let first = Deserializer::from_str(&text).next();
    let document = first.map_or(Ok(Value::Null), Value::deserialize);
    document.map_err(|error| {
        let place = error.location().map(|at| (at.line(), at.column()));
        malformed(path, place, format!("malformed YAML: {error}"))
    })
}

fn parse_xml(path: &Path, text: &str) -> Result<Value, FileError> {
    let document = Document::parse(text).map_err(|error| {
        let at = error.pos();
        let place = (at.row as usize, at.col as usize);
        malformed(path, Some(place), format!("malformed XML: {error}"))
    })?;
    value_of(document.root_element(), 0)
        .ok_or_else(|| malformed(path, None, "elements are nested too deeply".to_owned()))
}

/// An element with others in it as a mapping, or as a list where all are OpenCV's `_`; numbers in a row as a list.
fn value_of(element: Node<'_, '_>, level: usize) -> Option<Value> {
    if level > MOST_LEVELS {
        return None;
    }
    let children: Vec<Node<'_, '_>> = element.children().filter(Node::is_element).collect();
    if children.is_empty() {
        return Some(text_value(element.text().unwrap_or_default().trim()));
    }
    let values = children.iter().map(|child| value_of(*child, level + 1));
    let values: Option<Vec<Value>> = values.collect();
    if children.iter().all(|child| child.has_tag_name("_")) {
        return values.map(Value::Sequence);
    }
    let names = children.iter().map(|child| child.tag_name().name().into());
    Some(Value::Mapping(names.zip(values?).collect::<Mapping>()))
}

fn text_value(text: &str) -> Value {
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    match numbers.as_deref() {
        Ok([number]) => (*number).into(),
        Ok([_, ..]) => numbers.map(Value::from).unwrap_or_default(),
        _ => text.trim_matches('"').into(),
    }
}

fn malformed(path: &Path, place: Option<(usize, usize)>, cause: String) -> FileError {
    InvalidFile {
        path: path.to_owned(),
        place,
        complaint: Complaint::new("", cause, REMEDY),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_decides_about_the_syntax() {
        for (name, text, syntax) in [
            ("a.toml", "[[camera]]\nid = \"a\"\n", Syntax::Toml),
            ("a", "# a: comment\nid = \"a: b\"\n", Syntax::Toml),
            ("a.toml", "image_width: 640\n", Syntax::Yaml),
            ("a.toml", "%YAML:1.0\n---\n", Syntax::Yaml),
            ("a", "\n{\"a\": 1}", Syntax::Yaml),
            ("a", "<?xml version=\"1.0\"?>\n", Syntax::Xml),
            ("a.toml", "", Syntax::Toml),
            ("a.yaml", "nothing", Syntax::Yaml),
        ] {
            assert_eq!(syntax_of(Path::new(name), text), syntax, "{text}");
        }
    }

    #[test]
    fn elements_become_mappings_lists_and_numbers() {
        let text = "<s><a>1</a><b>\n 1. 2e0 </b><c>\"x y\"</c><d><_>1</_><_>2</_></d></s>";
        let value = parse_document(Path::new("a"), text).unwrap();
        let expected: Value =
            yaml_serde::from_str("{a: 1.0, b: [1.0, 2.0], c: 'x y', d: [1.0, 2.0]}").unwrap();
        assert_eq!(value, expected);
        let deep = "<a>".repeat(200) + &"</a>".repeat(200);
        let error = parse_document(Path::new("a"), &deep).unwrap_err();
        assert!(error.to_string().contains("nested too deeply"), "{error}");
        let error = parse_document(Path::new("a.xml"), "<a>\n<b></a>").unwrap_err();
        assert!(error.to_string().starts_with("a.xml:2:"), "{error}");
    }
}
