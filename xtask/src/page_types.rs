//! The page's module of messages, made from the network's contract and the bridge's protocol: a check for each type,
//! from which TypeScript infers the type itself.
//!
//! Types without a name stand within those that have them. What no message of the bridge refers to is left out.

use crate::generated::{Generated, camel, contract, read};
use sextant_contract::{Content, Contract, Field, Shape, Type};
use std::collections::BTreeSet;

pub const MESSAGES: Generated = Generated {
    file: "node-viewer-bridge/page/src/messages.ts",
    chore: "page-types",
    make: module,
};
const HEAD: &str = "// The bridge's messages: what each looks like. Written by `cargo xtask page-types` from \
    proto/CONTRACT.md and PROTOCOL.md: do not edit.

import { anyOf, arrayOf, isFlag, isNumber, isText, listOf, oneOf, orNull, record, tuple, variants, type Checked } \
    from \"./shape.ts\";
";

/// Writes the page's module of messages.
pub fn page_types() -> Result<(), String> {
    MESSAGES.write()
}

fn module() -> Result<String, String> {
    let protocol = read("node-viewer-bridge/PROTOCOL.md")?;
    let contract = contract()?.with_protocol(&protocol);
    let contract = contract.map_err(|cause| cause.to_string())?;
    let mut module = Module {
        contract: &contract,
        text: HEAD.to_owned(),
        written: BTreeSet::new(),
    };
    let mut table = String::new();
    for message in contract.definitions.iter().filter(|it| it.is_message()) {
        let check = match &message.shape {
            Shape::OneOf(names) => module.one_of(names),
            shape => module.named(&camel(&message.name), shape, &message.note),
        };
        table += &format!("  {}: {check},\n", message.name);
    }
    Ok(format!(
        "{}\n/** By the `type` of each message. */\nexport const MESSAGES = {{\n{table}}};\n",
        module.text
    ))
}

/// What was written so far.
struct Module<'a> {
    contract: &'a Contract,
    text: String,
    written: BTreeSet<String>,
}

impl Module<'_> {
    /// Writes a type after those that it refers to, once; the name of its check.
    fn named(&mut self, name: &str, shape: &Shape, note: &str) -> String {
        if self.written.insert(name.to_owned()) {
            let check = self.shape(shape, 0);
            let doc = doc(note, 0);
            self.text += &format!(
                "\n{doc}export const is{name} = {check};\nexport type {name} = Checked<typeof is{name}>;\n"
            );
        }
        format!("is{name}")
    }

    fn reference(&mut self, name: &str) -> String {
        let mut definitions = self.contract.definitions.iter();
        match definitions.find(|definition| definition.name == name) {
            Some(definition) => self.named(name, &definition.shape, &definition.note),
            None => format!("is{name}"),
        }
    }

    fn one_of(&mut self, names: &[String]) -> String {
        let checks: Vec<String> = names.iter().map(|name| self.reference(name)).collect();
        match checks.as_slice() {
            [one] => one.clone(),
            several => format!("anyOf({})", several.join(", ")),
        }
    }

    fn shape(&mut self, shape: &Shape, depth: usize) -> String {
        match shape {
            Shape::Struct(fields) => self.record(fields, depth),
            Shape::OneOf(names) => self.one_of(names),
            Shape::Enum(list) if list.iter().all(|it| it.content == Content::Unit) => {
                let words = list.iter().map(|variant| format!("{:?}", variant.name));
                format!("oneOf({})", words.collect::<Vec<_>>().join(", "))
            }
            Shape::Enum(list) => {
                let lines = list.iter().map(|variant| {
                    let check = match &variant.content {
                        Content::Unit => "null".to_owned(),
                        Content::Value(ty) => self.ty(ty, depth + 1),
                        Content::Fields(fields) => self.record(fields, depth + 1),
                    };
                    member(&variant.name, &check, &variant.note, depth + 1)
                });
                let lines: String = lines.collect();
                format!("variants({{\n{lines}{}}})", indent(depth))
            }
        }
    }

    fn record(&mut self, fields: &[Field], depth: usize) -> String {
        let mut of = |may_be_missing: bool| -> String {
            let of = fields
                .iter()
                .filter(|it| it.may_be_missing == may_be_missing);
            let lines = of.map(|field| {
                let check = self.ty(&field.ty, depth + 1);
                member(&field.name, &check, &field.note, depth + 1)
            });
            lines.collect()
        };
        let (always, sometimes, end) = (of(false), of(true), indent(depth));
        match (always.as_str(), sometimes.as_str()) {
            (_, "") => format!("record({{\n{always}{end}}})"),
            ("", _) => format!("record({{}}, {{\n{sometimes}{end}}})"),
            _ => format!("record({{\n{always}{end}}}, {{\n{sometimes}{end}}})"),
        }
    }

    fn ty(&mut self, ty: &Type, depth: usize) -> String {
        match ty {
            Type::Bool => "isFlag".into(),
            Type::String => "isText".into(),
            Type::Bytes(_) => "listOf(isNumber)".into(),
            Type::List(of, _) => format!("listOf({})", self.ty(of, depth)),
            Type::Array(of, length) => format!("arrayOf({}, {length})", self.ty(of, depth)),
            Type::Tuple(items) => {
                let items: Vec<String> = items.iter().map(|item| self.ty(item, depth)).collect();
                format!("tuple({})", items.join(", "))
            }
            Type::Optional(of) => format!("orNull({})", self.ty(of, depth)),
            Type::Named(name) => self.reference(name),
            Type::Nested(shape) => self.shape(shape, depth),
            _ => "isNumber".into(),
        }
    }
}

fn member(name: &str, check: &str, note: &str, depth: usize) -> String {
    let (doc, indent) = (doc(note, depth), indent(depth));
    let name = if name.contains('-') {
        format!("{name:?}")
    } else {
        name.to_owned()
    };
    format!("{doc}{indent}{name}: {check},\n")
}

fn doc(note: &str, depth: usize) -> String {
    if note.is_empty() {
        return String::new();
    }
    format!("{}/** {note} */\n", indent(depth))
}

fn indent(depth: usize) -> String {
    "  ".repeat(depth)
}
