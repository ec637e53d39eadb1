//! The Python module of the contract's messages: a dataclass for each type, with functions that read and write it.
//!
//! Types without a name get one from where they stand: `timing` of `Observations` becomes `ObservationsTiming`. An enum of bare names
//! becomes a `Word`, any other a union of one dataclass for each variant.

use sextant_contract::{Content, Contract, Definition, Field, Shape, Type, Variant};

const HEAD: &str = r#""""The messages of the wire contract. Written by `cargo xtask python` from proto/CONTRACT.md: do not edit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Optional, Union

from ._postcard import Alternative, Kind, Reader, Record, VariantRecord, Word, Writer

"#;

/// The text of the module.
pub fn module(contract: &Contract) -> String {
    let mut module = Module::default();
    for definition in &contract.definitions {
        module.definition(definition);
    }
    let mut kinds =
        "#: Every kind of message, by its number in the header.\nKINDS: dict[int, Kind] = {\n"
            .to_owned();
    for row in &contract.kinds {
        let (number, name, most) = (row.number, &row.message, row.max_bytes);
        kinds += &format!(
            "    {number}: Kind({number}, {most}, {name}, _read_{name}, _write_{name}),\n"
        );
    }
    let Module {
        classes,
        functions,
        tables,
        names,
    } = module;
    let names: String = names
        .iter()
        .map(|name| format!("    \"{name}\",\n"))
        .collect();
    format!("{HEAD}{classes}\n{functions}\n{tables}\n\n{kinds}}}\n\n__all__ = [\n{names}]\n")
}

/// The parts of the module: tables stand last, since they refer to functions.
#[derive(Default)]
struct Module {
    classes: String,
    functions: String,
    tables: String,
    /// Public names.
    names: Vec<String>,
}

impl Module {
    fn definition(&mut self, definition: &Definition) {
        self.shape(&definition.name, &definition.shape, &definition.note);
    }

    fn shape(&mut self, name: &str, shape: &Shape, note: &str) {
        self.names.push(name.to_owned());
        match shape {
            Shape::Struct(fields) => {
                self.record(name, "Record", "", fields, note);
            }
            Shape::Enum(variants) if variants.iter().all(|v| v.content == Content::Unit) => {
                self.words(name, variants, note);
            }
            Shape::Enum(variants) => self.union(name, variants, note),
        }
    }

    /// A dataclass, its reader and its writer; `lead` stands before the fields.
    fn record(&mut self, name: &str, base: &str, lead: &str, fields: &[Field], note: &str) {
        for field in fields {
            self.nested(name, field);
        }
        let doc = docstring(name, note);
        let mut class = format!("\n@dataclass(frozen=True)\nclass {name}({base}):\n{doc}\n{lead}");
        for field in fields {
            let notes: Vec<String> = [shape_note(&field.ty), field.note.clone()].into();
            let notes: Vec<String> = notes.into_iter().filter(|note| !note.is_empty()).collect();
            if !notes.is_empty() {
                class += &format!("    #: {}\n", notes.join("; "));
            }
            let ty = annotation(&field.ty, &nested_name(name, field));
            class += &format!("    {}: {ty}\n", field.name);
        }
        self.classes += &(class + "\n");
        self.functions_of(name, fields);
    }

    fn functions_of(&mut self, name: &str, fields: &[Field]) {
        let mut reads = format!("\ndef _read_{name}(r: Reader) -> {name}:\n    return {name}(");
        let mut writes = format!("\ndef _write_{name}(w: Writer, value: {name}) -> None:\n");
        for field in fields {
            let nested = nested_name(name, field);
            let member = format!("value.{}", field.name);
            reads += &format!("\n        {},", read(&field.ty, &nested));
            writes += &format!("    {}\n", write(&field.ty, &nested, &member));
        }
        if fields.is_empty() {
            writes += "    pass\n";
        } else {
            reads += "\n    ";
        }
        self.functions += &format!("{reads})\n\n{writes}\n");
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
        self.tables += &format!("\n_ALL_{name} = tuple({name})");
        self.functions += &format!(
            "\ndef _read_{name}(r: Reader) -> {name}:\n    return r.word(_ALL_{name})\n\n\ndef _write_{name}(w: Writer, value: {name}) -> None:\n    w.word(_ALL_{name}, value)\n\n"
        );
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
                    note: String::new(),
                }],
            };
            let form = match variant.content {
                Content::Unit => "unit",
                Content::Fields(_) => "fields",
                Content::Value(_) => "value",
            };
            let lead = format!(
                "    VARIANT: ClassVar[str] = \"{}\"\n    FORM: ClassVar[str] = \"{form}\"\n",
                variant.name
            );
            self.record(class, "VariantRecord", &lead, &fields, &variant.note);
        }
        let listed = classes.join(", ");
        self.classes += &format!(
            "\n#: {}\n{name} = Union[{listed}]\n\n",
            one_line(name, note)
        );
        self.tables += &format!("\n_ALL_{name} = (\n");
        for class in &classes {
            self.tables += &format!("    Alternative({class}, _read_{class}, _write_{class}),\n");
        }
        self.tables += ")";
        self.functions += &format!(
            "\ndef _read_{name}(r: Reader) -> {name}:\n    value: {name} = r.alternative(_ALL_{name})\n    return value\n\n\ndef _write_{name}(w: Writer, value: {name}) -> None:\n    w.alternative(_ALL_{name}, value)\n\n"
        );
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

/// `camera_moved` and `brown-conrady` as `CameraMoved` and `BrownConrady`.
fn camel(name: &str) -> String {
    let words = name.split(['_', '-']);
    let capital = |word: &str| {
        let (first, rest) = word.split_at(1);
        first.to_uppercase() + rest
    };
    words.map(capital).collect()
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

/// The lengths of arrays, which Python's types do not tell.
fn shape_note(ty: &Type) -> String {
    fn lengths(ty: &Type) -> Vec<String> {
        match ty {
            Type::Array(of, length) => {
                let mut all = vec![length.to_string()];
                all.extend(lengths(of));
                all
            }
            Type::Optional(of) => lengths(of),
            _ => Vec::new(),
        }
    }
    let lengths = lengths(ty);
    if lengths.is_empty() {
        String::new()
    } else {
        format!("shape ({})", lengths.join(", "))
    }
}

fn annotation(ty: &Type, nested: &str) -> String {
    match ty {
        Type::U8 | Type::U16 | Type::U32 | Type::U64 => "int".into(),
        Type::F32 | Type::F64 => "float".into(),
        Type::String => "str".into(),
        Type::Bytes(_) => "bytes".into(),
        Type::List(of, _) | Type::Array(of, _) => format!("tuple[{}, ...]", annotation(of, nested)),
        Type::Optional(of) => format!("Optional[{}]", annotation(of, nested)),
        Type::Named(name) => name.clone(),
        Type::Nested(_) => nested.to_owned(),
    }
}

/// The expression that reads a value of this type from `r`.
fn read(ty: &Type, nested: &str) -> String {
    match ty {
        Type::Bytes(most) => format!("r.blob({})", limit(*most)),
        Type::List(of, most) => format!("r.list({}, {})", reader(of, nested), limit(*most)),
        Type::Array(of, length) => match **of {
            Type::F32 => format!("r.f32s({length})"),
            Type::F64 => format!("r.f64s({length})"),
            _ => format!("r.array({}, {length})", reader(of, nested)),
        },
        Type::Optional(of) => format!("r.optional({})", reader(of, nested)),
        Type::Named(name) => format!("_read_{name}(r)"),
        Type::Nested(_) => format!("_read_{nested}(r)"),
        _ => format!("r.{}()", primitive(ty)),
    }
}

/// The function that does the same.
fn reader(ty: &Type, nested: &str) -> String {
    match ty {
        Type::Named(name) => format!("_read_{name}"),
        Type::Nested(_) => format!("_read_{nested}"),
        Type::Bytes(_) | Type::List(..) | Type::Array(..) | Type::Optional(_) => {
            format!("lambda r: {}", read(ty, nested))
        }
        _ => format!("Reader.{}", primitive(ty)),
    }
}

/// The expression that writes `value` to `w`.
fn write(ty: &Type, nested: &str, value: &str) -> String {
    match ty {
        Type::Bytes(_) => format!("w.blob({value})"),
        Type::List(of, _) => format!("w.list({}, {value})", writer(of, nested)),
        Type::Array(of, length) => match **of {
            Type::F32 => format!("w.f32s({value}, {length})"),
            Type::F64 => format!("w.f64s({value}, {length})"),
            _ => format!("w.array({}, {value}, {length})", writer(of, nested)),
        },
        Type::Optional(of) => format!("w.optional({}, {value})", writer(of, nested)),
        Type::Named(name) => format!("_write_{name}(w, {value})"),
        Type::Nested(_) => format!("_write_{nested}(w, {value})"),
        _ => format!("w.{}({value})", primitive(ty)),
    }
}

/// The function that does the same.
fn writer(ty: &Type, nested: &str) -> String {
    match ty {
        Type::Named(name) => format!("_write_{name}"),
        Type::Nested(_) => format!("_write_{nested}"),
        Type::Bytes(_) | Type::List(..) | Type::Array(..) | Type::Optional(_) => {
            format!("lambda w, v: {}", write(ty, nested, "v"))
        }
        _ => format!("Writer.{}", primitive(ty)),
    }
}

fn primitive(ty: &Type) -> &'static str {
    match ty {
        Type::U8 => "u8",
        Type::U16 => "u16",
        Type::U32 => "u32",
        Type::U64 => "u64",
        Type::F32 => "f32",
        Type::F64 => "f64",
        _ => "string",
    }
}

fn limit(most: Option<usize>) -> String {
    most.map_or_else(|| "None".into(), |most| most.to_string())
}
