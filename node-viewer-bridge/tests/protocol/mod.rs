//! Holds JSON messages to `PROTOCOL.md`.

use serde_json::Value;
use sextant_contract::{Content, Contract, Field, Shape, Type};
use std::path::Path;

/// The protocol with the types of the contract.
pub fn protocol() -> Contract {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file| std::fs::read_to_string(folder.join(file)).unwrap();
    let contract = Contract::read(&read("../proto/CONTRACT.md")).unwrap();
    contract.with_protocol(&read("PROTOCOL.md")).unwrap()
}

/// Panics where a message has another form than the protocol gives it. Reports of wizards may have more fields.
pub fn check(protocol: &Contract, message: &Value) {
    let name = message["type"].as_str().unwrap();
    let mut content = message.clone();
    content.as_object_mut().unwrap().remove("type");
    if let Err(cause) = shape(protocol, protocol.shape(name).unwrap(), &content) {
        panic!("{name}{cause}: {message}");
    }
}

/// Where the value differs, as a path.
type Checked = Result<(), String>;

fn shape(protocol: &Contract, of: &Shape, value: &Value) -> Checked {
    match of {
        Shape::Struct(fields) => record(protocol, fields, value),
        Shape::OneOf(names) => {
            let tried = names.iter().map(|name| named(protocol, name, value));
            let tried: Vec<Checked> = tried.collect();
            tried
                .iter()
                .find(|it| it.is_ok())
                .unwrap_or(&tried[0])
                .clone()
        }
        Shape::Enum(variants) => {
            let (name, content) = match value {
                Value::Object(one) if one.len() == 1 => one.iter().next().unwrap(),
                _ => (&value.as_str().unwrap_or_default().to_owned(), &Value::Null),
            };
            let variant = variants.iter().find(|variant| variant.name == *name);
            let variant = variant.ok_or(format!(" has no variant {value}"))?;
            match &variant.content {
                Content::Unit => content.is_null().then_some(()).ok_or(format!(".{name}")),
                Content::Value(of) => ty(protocol, of, content),
                Content::Fields(fields) => record(protocol, fields, content),
            }
        }
    }
}

fn record(protocol: &Contract, fields: &[Field], value: &Value) -> Checked {
    let values = value.as_object().ok_or(" is no object")?;
    for field in fields {
        let inside = |cause| format!(".{}{cause}", field.name);
        match values.get(&field.name) {
            None if field.may_be_missing => {}
            None => return Err(inside(" is missing".to_owned())),
            Some(value) => ty(protocol, &field.ty, value).map_err(inside)?,
        }
    }
    let is_known = |name: &String| fields.iter().any(|field| field.name == *name);
    match values.keys().find(|name| !is_known(name)) {
        Some(name) if !values.contains_key("verdict") => Err(format!(".{name} is not in it")),
        _ => Ok(()),
    }
}

fn ty(protocol: &Contract, of: &Type, value: &Value) -> Checked {
    let is_right = match of {
        Type::Optional(_) if value.is_null() => true,
        Type::Optional(of) => return ty(protocol, of, value),
        Type::Named(name) => return named(protocol, name, value),
        Type::Nested(of) => return shape(protocol, of, value),
        Type::List(item, most) => {
            let items = all(protocol, item, value)?;
            most.is_none_or(|most| items <= most)
        }
        Type::Array(item, length) => all(protocol, item, value)? == *length,
        Type::Tuple(types) => {
            let items = value.as_array().ok_or(" is no list")?;
            let mut pairs = types.iter().zip(items);
            pairs.try_for_each(|(of, item)| ty(protocol, of, item))?;
            items.len() == types.len()
        }
        Type::Bool => value.is_boolean(),
        Type::String => value.is_string(),
        Type::Bytes(_) => value.is_array(),
        Type::F32 | Type::F64 => value.is_number(),
        Type::U8 | Type::U16 | Type::U32 | Type::U64 => value.is_u64(),
    };
    is_right.then_some(()).ok_or(format!(" is no {of:?}"))
}

/// How many items of this type a list has.
fn all(protocol: &Contract, item: &Type, value: &Value) -> Result<usize, String> {
    let items = value.as_array().ok_or(" is no list")?;
    let mut each = items.iter();
    each.try_for_each(|value| ty(protocol, item, value))?;
    Ok(items.len())
}

fn named(protocol: &Contract, name: &str, value: &Value) -> Checked {
    shape(protocol, protocol.shape(name).unwrap(), value)
}
