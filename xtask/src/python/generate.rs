//! The Python module of the contract's messages: a dataclass for each type, whose annotations are what the codec reads
//! and writes.
//!
//! Types without a name get one from where they stand: `timing` of `Observations` becomes `ObservationsTiming`. An enum
//! of bare names becomes a `Word`, any other a union of one dataclass for each variant.

use crate::generated::{camel, contract};
use sextant_contract::{Content, Field, Shape, Type, Variant};

const HEAD: &str = r#""""The messages of the wire contract. Written by `cargo xtask python` from proto/CONTRACT.md: do not edit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Optional, Union

from ._postcard import F32, F64, U8, U16, U32, U64, AtMost, Kind, Length, Record, VariantRecord, Word

"#;

/// The text of the module.
pub fn module() -> Result<String, String> {
    let contract = contract()?;
    let mut module = Module::default();
    for definition in &contract.definitions {
        module.shape(&definition.name, &definition.shape, &definition.note);
    }
    let kinds = contract.kinds.iter().map(|row| {
        format!(
            "    {0}: Kind({0}, {1}, {2}),\n",
            row.number, row.max_bytes, row.message
        )
    });
    let kinds: String = kinds.collect();
    let names = module.names.iter().map(|name| format!("    \"{name}\",\n"));
    let names: String = names.collect();
    let classes = module.classes;
    Ok(format!(
        "{HEAD}{classes}\n#: Every kind of message, by its number in the header.\n\
         KINDS: dict[int, Kind] = {{\n{kinds}}}\n\n__all__ = [\n{names}]\n"
    ))
}

#[derive(Default)]
struct Module {
    classes: String,
    /// Public names.
    names: Vec<String>,
}

impl Module {
    fn shape(&mut self, name: &str, shape: &Shape, note: &str) {
        self.names.push(name.to_owned());
        match shape {
            Shape::Struct(fields) => self.record(name, "Record", fields, note),
            Shape::Enum(variants) if variants.iter().all(|v| v.content == Content::Unit) => {
                self.words(name, variants, note);
            }
            Shape::Enum(variants) => self.union(name, variants, note),
            Shape::OneOf(_) => unreachable!("in JSON only"),
        }
    }

    fn record(&mut self, name: &str, bases: &str, fields: &[Field], note: &str) {
        for field in fields {
            self.nested(name, field);
        }
        let doc = docstring(name, note);
        let mut class = format!("\n@dataclass(frozen=True)\nclass {name}({bases}):\n{doc}");
        for (index, field) in fields.iter().enumerate() {
            if index == 0 {
                class.push('\n');
            }
            if !field.note.is_empty() {
                class += &format!("    #: {}\n", field.note);
            }
            let ty = annotation(&field.ty, &nested_name(name, field));
            class += &format!("    {}: {ty}\n", field.name);
        }
        self.classes += &(class + "\n");
    }

    fn nested(&mut self, parent: &str, field: &Field) {
        if let Some(shape) = nested_shape(&field.ty) {
            let note = format!("`{}` of {parent}", field.name);
            self.shape(&nested_name(parent, field), shape, &note);
        }
    }

    /// An enum of bare names.
    fn words(&mut self, name: &str, variants: &[Variant], note: &str) {
        let mut class = format!("\nclass {name}(Word):\n{}\n", docstring(name, note));
        for variant in variants {
            if !variant.note.is_empty() {
                class += &format!("    #: {}\n", variant.note);
            }
            let constant = variant.name.to_uppercase().replace('-', "_");
            class += &format!("    {constant} = \"{}\"\n", variant.name);
        }
        self.classes += &(class + "\n");
    }

    /// An enum some of whose variants hold something.
    fn union(&mut self, name: &str, variants: &[Variant], note: &str) {
        let classes: Vec<String> = variants
            .iter()
            .map(|v| format!("{name}{}", camel(&v.name)))
            .collect();
        self.names.extend(classes.iter().cloned());
        for (variant, class) in variants.iter().zip(&classes) {
            let fields = match &variant.content {
                Content::Unit => Vec::new(),
                Content::Fields(fields) => fields.clone(),
                Content::Value(ty) => vec![Field {
                    name: "value".into(),
                    ty: ty.clone(),
                    may_be_missing: false,
                    note: String::new(),
                }],
            };
            let form = match variant.content {
                Content::Unit => "unit",
                Content::Fields(_) => "fields",
                Content::Value(_) => "value",
            };
            let bases = format!(
                "VariantRecord, variant=\"{}\", form=\"{form}\"",
                variant.name
            );
            self.record(class, &bases, &fields, &variant.note);
        }
        let (doc, classes) = (one_line(name, note), classes.join(", "));
        self.classes += &format!("\n#: {doc}\n{name} = Union[{classes}]\n\n");
    }
}

fn docstring(name: &str, note: &str) -> String {
    format!("    \"\"\"{}\"\"\"\n", one_line(name, note))
}

/// The note as a sentence, or the name.
fn one_line(name: &str, note: &str) -> String {
    let text = if note.is_empty() { name } else { note };
    let end = if text.ends_with('.') { "" } else { "." };
    let mut letters = text.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect::<String>() + end
}

/// The name of a type that has none, of this field; elements of a list in the singular.
fn nested_name(parent: &str, field: &Field) -> String {
    let name = match &field.ty {
        Type::List(..) => field.name.strip_suffix('s').unwrap_or(&field.name),
        _ => &field.name,
    };
    format!("{parent}{}", camel(name))
}

fn nested_shape(ty: &Type) -> Option<&Shape> {
    match ty {
        Type::Nested(shape) => Some(shape),
        Type::List(of, _) | Type::Array(of, _) | Type::Optional(of) => nested_shape(of),
        _ => None,
    }
}

/// The type with what its bytes need to know: widths of numbers, lengths of arrays, bounds of lists.
fn annotation(ty: &Type, nested: &str) -> String {
    match ty {
        Type::U8 => "U8".into(),
        Type::U16 => "U16".into(),
        Type::U32 => "U32".into(),
        Type::U64 => "U64".into(),
        Type::F32 => "F32".into(),
        Type::F64 => "F64".into(),
        Type::String => "str".into(),
        Type::Bytes(most) => bounded("bytes", *most),
        Type::List(of, most) => bounded(&format!("tuple[{}, ...]", annotation(of, nested)), *most),
        Type::Array(of, length) => {
            let of = annotation(of, nested);
            format!("Annotated[tuple[{of}, ...], Length({length})]")
        }
        Type::Optional(of) => format!("Optional[{}]", annotation(of, nested)),
        Type::Named(name) => name.clone(),
        Type::Nested(_) => nested.to_owned(),
        Type::Bool | Type::Tuple(_) => unreachable!("in JSON only"),
    }
}

fn bounded(ty: &str, most: Option<usize>) -> String {
    most.map_or_else(
        || ty.to_owned(),
        |most| format!("Annotated[{ty}, AtMost({most})]"),
    )
}
