//! Reads a type of serde from a parsed document. Its errors are data: location, cause and remedy. Those of `toml` are
//! texts, and its reader ignores elements behind the last of an array of fixed length.

use crate::hint::nearest;
use serde::de::value::{self, MapAccessDeserializer};
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error, IntoDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeString, DeTable, DeValue};

/// Why a document is not of a type.
#[derive(Debug)]
pub(crate) struct Refusal {
    /// The innermost key or value that is invalid.
    pub(crate) span: Option<Range<usize>>,
    pub(crate) cause: String,
    /// Empty if there is none.
    pub(crate) remedy: String,
}

/// Reads a document.
pub(crate) fn read<T: DeserializeOwned>(root: &Spanned<DeTable<'_>>) -> Result<T, Refusal> {
    let table = DeValue::Table(root.get_ref().clone());
    Value(&Spanned::new(root.span(), table)).read(PhantomData)
}

impl Refusal {
    fn new(cause: impl fmt::Display, remedy: String) -> Self {
        Self {
            span: None,
            cause: cause.to_string(),
            remedy,
        }
    }

    /// Adds a location, unless there is a more precise one.
    fn at(mut self, span: Range<usize>) -> Self {
        self.span.get_or_insert(span);
        self
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.cause)
    }
}

impl std::error::Error for Refusal {}

/// In serde's own words, with a remedy.
impl Error for Refusal {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message, String::new())
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let cause = value::Error::unknown_field(field, expected);
        let remedy = did_you_mean(field, expected).unwrap_or_else(|| "remove it".to_owned());
        Self::new(cause, remedy)
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        let cause = value::Error::unknown_variant(variant, expected);
        Self::new(cause, did_you_mean(variant, expected).unwrap_or_default())
    }

    fn missing_field(field: &'static str) -> Self {
        let cause = value::Error::missing_field(field);
        Self::new(cause, format!("add `{field} = ...`"))
    }
}

fn did_you_mean(word: &str, known: &[&str]) -> Option<String> {
    nearest(word, known).map(|meant| format!("did you mean `{meant}`?"))
}

/// A value of the document.
struct Value<'a>(&'a Spanned<DeValue<'a>>);

impl Value<'_> {
    /// An error without a location has that of the value.
    fn read<'de, T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Refusal> {
        let span = self.0.span();
        seed.deserialize(self).map_err(|refusal| refusal.at(span))
    }
}

impl<'de> Deserializer<'de> for Value<'_> {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(number) => read_integer(number, visitor),
            DeValue::Float(number) => match number.as_str().parse::<f64>() {
                Ok(x) if x.is_finite() || !number.as_str().contains(char::is_numeric) => {
                    visitor.visit_f64(x)
                }
                _ => Err(Refusal::custom("floating-point number overflowed")),
            },
            DeValue::Boolean(is_true) => visitor.visit_bool(*is_true),
            DeValue::Datetime(time) => visitor.visit_str(&time.to_string()),
            DeValue::Array(items) => read_array(items.iter(), visitor),
            DeValue::Table(table) => visitor.visit_map(Entries::new(table)),
        }
    }

    /// TOML has no value for "none": the key is left out.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refusal> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        visitor.visit_newtype_struct(self)
    }

    /// A word, or a table with a word as its only key.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refusal> {
        match self.0.get_ref() {
            DeValue::String(word) => visitor.visit_enum(word.as_ref().into_deserializer()),
            DeValue::Table(table) if table.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(Entries::new(table)))
            }
            _ => Err(Refusal::custom("wanted a string, or a table with one key")),
        }
    }

    forward_to_deserialize_any! {
        bool u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 f64 char str string seq bytes byte_buf map unit
        ignored_any unit_struct tuple_struct tuple struct identifier
    }
}

fn read_integer<'de, V: Visitor<'de>>(
    number: &DeInteger<'_>,
    visitor: V,
) -> Result<V::Value, Refusal> {
    let (digits, radix) = (number.as_str(), number.radix());
    if let Ok(number) = i64::from_str_radix(digits, radix) {
        return visitor.visit_i64(number);
    }
    match u64::from_str_radix(digits, radix) {
        Ok(number) => visitor.visit_u64(number),
        Err(_) => Err(Refusal::custom("integer number overflowed")),
    }
}

fn read_array<'a, 'de, V: Visitor<'de>>(
    items: impl ExactSizeIterator<Item = &'a Spanned<DeValue<'a>>>,
    visitor: V,
) -> Result<V::Value, Refusal> {
    let length = items.len();
    let mut items = Items(items);
    let read = visitor.visit_seq(&mut items)?;
    match items.0.len() {
        0 => Ok(read),
        _ => Err(Refusal::new(
            format!("{length} elements are too many"),
            "remove those at the end".to_owned(),
        )),
    }
}

/// Elements of an array that are yet to be read.
struct Items<I>(I);

impl<'a, 'de, I: ExactSizeIterator<Item = &'a Spanned<DeValue<'a>>>> SeqAccess<'de>
    for &mut Items<I>
{
    type Error = Refusal;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let item = self.0.next();
        item.map(|item| Value(item).read(seed)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// Entries of a table that are yet to be read.
struct Entries<'a> {
    entries: Box<dyn Iterator<Item = (&'a Spanned<DeString<'a>>, &'a Spanned<DeValue<'a>>)> + 'a>,
    value: Option<&'a Spanned<DeValue<'a>>>,
}

impl<'a> Entries<'a> {
    fn new(table: &'a DeTable<'a>) -> Self {
        Self {
            entries: Box::new(table.iter()),
            value: None,
        }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Refusal;

    fn next_key_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Refusal> {
        let Some((key, value)) = self.entries.next() else {
            return Ok(None);
        };
        self.value = Some(value);
        let word = DeValue::String(key.get_ref().as_ref().into());
        Value(&Spanned::new(key.span(), word)).read(seed).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Refusal> {
        let value = self.value.take();
        let value = value.ok_or_else(|| Refusal::custom("a value without a key"))?;
        Value(value).read(seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Shape {
        Point,
        Circle { radius: f64 },
    }

    #[derive(Debug, PartialEq, Deserialize)]
    struct All {
        a: u8,
        b: i64,
        c: u64,
        d: f64,
        e: f64,
        f: bool,
        g: Vec<[u8; 2]>,
        h: BTreeMap<String, Shape>,
        k: Option<f64>,
    }

    fn read_text<T: DeserializeOwned>(text: &str) -> Result<T, Refusal> {
        read(&DeTable::parse(text).unwrap())
    }

    #[test]
    fn values_are_read_as_toml_reads_them() {
        let text = "a = 0x10\nb = -1_000\nc = 18446744073709551615\nd = 1.5e3\ne = -inf\n\
            f = true\ng = [[1, 2]]\n[h]\ni = \"point\"\nj = { circle = { radius = 2 } }\n";
        let all: All = read_text(text).unwrap();
        assert_eq!(all, toml::from_str(text).unwrap());
        assert_eq!((all.a, all.b, all.c), (16, -1000, u64::MAX));
        assert_eq!((all.d, all.e, all.k), (1500.0, f64::NEG_INFINITY, None));
        assert_eq!(all.h["j"], Shape::Circle { radius: 2.0 });
        assert!(read_text::<BTreeMap<String, f64>>("e = 1e999\n").is_err());
        assert!(read_text::<BTreeMap<String, u64>>("e = 18446744073709551616\n").is_err());
    }

    #[test]
    fn refusals_have_a_place_and_a_remedy() {
        let about = |text: &str, needle: &str| {
            let refusal = read_text::<BTreeMap<String, Vec<[u8; 2]>>>(text).unwrap_err();
            assert_eq!(refusal.span.unwrap().start, text.find(needle).unwrap());
            format!("{}; {}", refusal.cause, refusal.remedy)
        };
        assert_eq!(
            about("a = [[1, 2], [3, 4, 5]]\n", "[3"),
            "3 elements are too many; remove those at the end"
        );
        assert!(about("a = [[1, 300]]\n", "300").contains("invalid value: integer `300`"));
        let refusal = read_text::<BTreeMap<String, Shape>>("a = \"pont\"\n").unwrap_err();
        assert_eq!(refusal.remedy, "did you mean `point`?");
    }
}
