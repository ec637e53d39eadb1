//! Type descriptions (REP 2011) and their hash RIHS01: SHA-256 of the description as JSON, fields in order, referenced types by name.

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

/// A ROS message.
pub trait RosMessage: Field {
    /// Its type, as in `geometry_msgs/msg/Point`.
    const TYPE_NAME: &'static str;
}

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
    nested: &'static str,
}

impl FieldType {
    const fn primitive(id: u8) -> Self {
        Self {
            id,
            capacity: 0,
            nested: "",
        }
    }

    fn json(&self, name: &str) -> String {
        format!(
            r#"{{"name": "{name}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": 0, "nested_type_name": "{}"}}}}"#,
            self.id, self.capacity, self.nested
        )
    }
}

/// Message types by name, each with its fields as JSON.
#[derive(Debug, Default)]
pub struct TypeTable {
    types: BTreeMap<&'static str, String>,
}

impl TypeTable {
    /// Registers a message type with its fields.
    pub(crate) fn nested(
        &mut self,
        name: &'static str,
        fields: impl FnOnce(&mut Self) -> Vec<(&'static str, FieldType)>,
    ) -> FieldType {
        if !self.types.contains_key(name) {
            let fields = fields(self);
            let fields: Vec<String> = fields.iter().map(|(name, kind)| kind.json(name)).collect();
            let json = format!(
                r#"{{"type_name": "{name}", "fields": [{}]}}"#,
                fields.join(", ")
            );
            self.types.insert(name, json);
        }
        FieldType {
            id: NESTED,
            capacity: 0,
            nested: name,
        }
    }
}

/// What is hashed: spaces and the order of keys are part of it.
fn description_json<M: RosMessage>() -> String {
    let mut table = TypeTable::default();
    M::describe(&mut table);
    let own = table.types.remove(M::TYPE_NAME).unwrap_or_default();
    let referenced: Vec<String> = table.types.into_values().collect();
    format!(
        r#"{{"type_description": {own}, "referenced_type_descriptions": [{}]}}"#,
        referenced.join(", ")
    )
}

macro_rules! numbers {
    ($($number:ty = $id:literal),*) => {$(
        impl Field for $number {
            fn describe(_: &mut TypeTable) -> FieldType {
                FieldType::primitive($id)
            }

            fn write(&self, cdr: &mut Writer) {
                cdr.number(self.to_le_bytes());
            }
        }
    )*};
}

numbers!(i8 = 2, i32 = 6, u32 = 7, f32 = 10, f64 = 11);

impl Field for u8 {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(3)
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
        FieldType::primitive(15)
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
        FieldType::primitive(16)
    }

    fn write(&self, cdr: &mut Writer) {
        cdr.number([self.0]);
    }
}

impl Field for String {
    fn describe(_: &mut TypeTable) -> FieldType {
        FieldType::primitive(17)
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
