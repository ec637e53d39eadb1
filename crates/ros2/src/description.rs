//! Types of messages: as descriptions (REP 2011) with their hash RIHS01, SHA-256 of the description as JSON, fields in
//! order, referenced types by name; and as definitions, the text of `.msg` files, which bags carry.

use std::collections::BTreeMap;
use std::fmt::Write;

use sha2::{Digest, Sha256};

use crate::cdr::Writer;

/// A value of a ROS message.
pub trait Field {
    /// Its type; registers the message types that it refers to.
    #[doc(hidden)]
    fn describe(types: &mut TypeTable) -> FieldType;

    #[doc(hidden)]
    fn write(&self, cdr: &mut Writer);

    /// The elements of a sequence or array.
    #[doc(hidden)]
    fn write_all(elements: &[Self], cdr: &mut Writer)
    where
        Self: Sized,
    {
        elements.iter().for_each(|element| element.write(cdr));
    }
}

/// A struct that is a message of ROS, field by field.
pub trait RosMessage: Field {
    /// Its type, as in `geometry_msgs/msg/Point`.
    const TYPE_NAME: &'static str;
}

/// Encoding of messages, as MCAP names it.
pub const MESSAGE_ENCODING: &str = "cdr";
/// Encoding of [`definition`], as MCAP names it.
pub const SCHEMA_ENCODING: &str = "ros2msg";

/// The bytes of a message: CDR with its header.
#[must_use]
pub fn encode(message: &impl RosMessage) -> Vec<u8> {
    let mut cdr = Writer::new();
    message.write(&mut cdr);
    cdr.into_bytes()
}

/// The hash of a message's type: `RIHS01_` and 64 hexadecimal digits.
#[must_use]
pub fn type_hash<M: RosMessage>() -> String {
    let mut hash = String::from("RIHS01_");
    for byte in Sha256::digest(description_json::<M>()) {
        let _ = write!(hash, "{byte:02x}");
    }
    hash
}

/// The definition of a message's type, in the format `ros2msg` of MCAP and rosbag2: its fields, then those of each type
/// that they refer to.
#[must_use]
pub fn definition<M: RosMessage>() -> String {
    let (fields, referenced) = types_of::<M>();
    let referenced = referenced.into_iter().map(|(name, fields)| {
        let rule = "=".repeat(80);
        format!("{rule}\nMSG: {}\n{}", resource_name(name), lines(&fields))
    });
    lines(&fields) + &referenced.collect::<String>()
}

fn lines(fields: &Fields) -> String {
    let fields = fields.iter();
    fields
        .map(|(name, kind)| format!("{} {name}\n", kind.definition()))
        .collect()
}

/// The name of a type in definitions: `geometry_msgs/Point` of `geometry_msgs/msg/Point`.
fn resource_name(type_name: &str) -> String {
    type_name.replace("/msg/", "/")
}

/// Added to the number of an element's type where the field is an array of fixed length.
const ARRAY: u8 = 48;
/// The same where it is a sequence without a bound.
const SEQUENCE: u8 = 144;
/// The number of a nested message's type.
const NESTED: u8 = 1;

/// The type of a field, as type_description_interfaces/msg/FieldType numbers them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldType {
    id: u8,
    capacity: usize,
    /// Of the element, where there are several: the word for a primitive, or the type's name for a message.
    name: &'static str,
}

impl FieldType {
    const fn primitive(id: u8, name: &'static str) -> Self {
        Self {
            id,
            capacity: 0,
            name,
        }
    }

    fn json(&self, name: &str) -> String {
        let is_nested = self.name.contains('/');
        format!(
            r#"{{"name": "{name}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": 0, "nested_type_name": "{}"}}}}"#,
            self.id,
            self.capacity,
            if is_nested { self.name } else { "" }
        )
    }

    fn definition(&self) -> String {
        let name = resource_name(self.name);
        match self.id {
            SEQUENCE.. => format!("{name}[]"),
            ARRAY.. => format!("{name}[{}]", self.capacity),
            _ => name,
        }
    }
}

/// The fields of a message by their names, in their order.
type Fields = Vec<(&'static str, FieldType)>;

/// Message types by name.
#[derive(Debug, Default)]
pub struct TypeTable {
    types: BTreeMap<&'static str, Fields>,
}

impl TypeTable {
    /// Registers a message type with its fields.
    pub(crate) fn nested(
        &mut self,
        name: &'static str,
        fields: impl FnOnce(&mut Self) -> Fields,
    ) -> FieldType {
        if !self.types.contains_key(name) {
            let fields = fields(self);
            self.types.insert(name, fields);
        }
        FieldType {
            id: NESTED,
            capacity: 0,
            name,
        }
    }
}

/// The fields of a message, and the types that they refer to.
fn types_of<M: RosMessage>() -> (Fields, BTreeMap<&'static str, Fields>) {
    let mut table = TypeTable::default();
    M::describe(&mut table);
    let own = table.types.remove(M::TYPE_NAME).unwrap_or_default();
    (own, table.types)
}

/// What is hashed: spaces and the order of keys are part of it.
fn description_json<M: RosMessage>() -> String {
    let (own, referenced) = types_of::<M>();
    let referenced = referenced.iter();
    let referenced: Vec<String> = referenced
        .map(|(name, fields)| json(name, fields))
        .collect();
    format!(
        r#"{{"type_description": {}, "referenced_type_descriptions": [{}]}}"#,
        json(M::TYPE_NAME, &own),
        referenced.join(", ")
    )
}

fn json(name: &str, fields: &Fields) -> String {
    let fields = fields.iter();
    let fields: Vec<String> = fields.map(|(name, kind)| kind.json(name)).collect();
    format!(
        r#"{{"type_name": "{name}", "fields": [{}]}}"#,
        fields.join(", ")
    )
}

macro_rules! numbers {
    ($($number:ty = $id:literal $word:literal),*) => {$(
        impl Field for $number {
            fn describe(_: &mut TypeTable) -> FieldType {
                FieldType::primitive($id, $word)
            }

            fn write(&self, cdr: &mut Writer) {
                cdr.number(self.to_le_bytes());
            }
        }
    )*};
}

numbers!(i8 = 2 "int8", i32 = 6 "int32", u32 = 7 "uint32", f32 = 10 "float32", f64 = 11 "float64");

impl Field for u8 {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(3, "uint8")
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.number([*self]);
    }

    fn write_all(elements: &[Self], cdr: &mut Writer) {
        cdr.raw(elements);
    }
}

impl Field for bool {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(15, "bool")
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.number([u8::from(*self)]);
    }
}

/// ROS's `byte`: as `uint8` on the wire, of another type in descriptions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Byte(pub u8);

impl Field for Byte {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(16, "byte")
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.number([self.0]);
    }
}

impl Field for String {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(17, "string")
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.text(self);
    }
}

impl<F: Field> Field for Vec<F> {
    fn describe(types: &mut TypeTable) -> FieldType {
        let element = F::describe(types);
        FieldType {
            id: element.id + SEQUENCE,
            ..element
        }
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.length(self.len());
        F::write_all(self, cdr);
    }
}

impl<F: Field, const N: usize> Field for [F; N] {
    fn describe(types: &mut TypeTable) -> FieldType {
        let element = F::describe(types);
        FieldType {
            id: element.id + ARRAY,
            capacity: N,
            ..element
        }
    }

    fn write(&self, cdr: &mut Writer) {
        F::write_all(self, cdr);
    }
}
