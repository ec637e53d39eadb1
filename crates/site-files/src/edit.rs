//! Changes one value of a file written by a person and keeps everything else, including comments.

use std::path::Path;

use toml::de::{DeTable, DeValue};

use crate::document::Document;
use crate::error::FileError;

/// Replaces a top-level value of a text, or adds it. `value` is TOML; `path` is for messages.
///
/// # Errors
/// Invalid TOML.
pub fn with_value(path: &Path, text: &str, key: &str, value: &str) -> Result<String, FileError> {
    let document = Document::parse(path, text)?;
    if let Some(span) = document.span_of(key) {
        return Ok([&text[..span.start], value, &text[span.end..]].concat());
    }
    let (before, after) = text.split_at(end_of_top_level(document.root(), text));
    let newline = if before.is_empty() || before.ends_with('\n') {
        ""
    } else {
        "\n"
    };
    Ok(format!("{before}{newline}{key} = {value}\n{after}"))
}

/// Start of the first table; top-level keys are before it.
fn end_of_top_level(root: &DeTable<'_>, text: &str) -> usize {
    let tables = root
        .iter()
        .filter(|(_, value)| matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_)));
    let lines = tables.map(|(key, _)| text[..key.span().start].rfind('\n').map_or(0, |at| at + 1));
    let headers = lines.filter(|start| text[*start..].trim_start().starts_with('['));
    headers.min().unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edited(text: &str) -> String {
        with_value(Path::new("f.toml"), text, "objects", "[\"a.toml\"]").unwrap()
    }

    #[test]
    fn a_value_is_replaced_and_nothing_else() {
        assert_eq!(
            edited(
                "# mine\nsite = \"x\"\nobjects = [ # all\n  \"b.toml\",\n] # end\n[network]\nlisten = []\n"
            ),
            "# mine\nsite = \"x\"\nobjects = [\"a.toml\"] # end\n[network]\nlisten = []\n"
        );
    }

    #[test]
    fn a_missing_value_is_added_before_the_first_table() {
        assert_eq!(
            edited("site = \"x\"\nlist = [\n[1],\n]\n\n  [network]\nlisten = []\n[[more]]\n"),
            "site = \"x\"\nlist = [\n[1],\n]\n\nobjects = [\"a.toml\"]\n  [network]\nlisten = []\n[[more]]\n"
        );
        assert_eq!(
            edited("site = \"x\""),
            "site = \"x\"\nobjects = [\"a.toml\"]\n"
        );
        assert_eq!(edited(""), "objects = [\"a.toml\"]\n");
    }

    #[test]
    fn a_text_that_is_no_toml_is_refused() {
        assert!(with_value(Path::new("f.toml"), "site =", "objects", "[]").is_err());
    }
}
