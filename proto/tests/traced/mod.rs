//! Reads a type of the code from a type of the contract: a serde source that gives zeros and short texts, and panics
//! where the code asks for something else than the contract has.

use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, SeqAccess,
    VariantAccess, Visitor, value::Error,
};
use serde::forward_to_deserialize_any;
use sextant_contract::{Content, Contract, Field, Shape, Type, Variant};

/// Checks that a message of the contract is the type `T`; each enum takes the variant `round`, modulo how many it has.
pub fn trace<T: DeserializeOwned>(contract: &Contract, message: &str, round: usize) {
    let source = Source {
        contract,
        round,
        ty: &Type::Named(message.to_owned()),
        path: message,
    };
    T::deserialize(source).unwrap_or_else(|cause| panic!("{message}: {cause}"));
}

#[derive(Clone, Copy)]
struct Source<'a> {
    contract: &'a Contract,
    round: usize,
    ty: &'a Type,
    path: &'a str,
}

impl<'a> Source<'a> {
    fn shape(&self) -> &'a Shape {
        match self.ty {
            Type::Named(name) => self.contract.shape(name).unwrap(),
            Type::Nested(shape) => shape,
            other => panic!(
                "{}: a {other:?} of the contract has a name in the code",
                self.path
            ),
        }
    }

    fn expect(&self, wanted: &Type) {
        assert_eq!(self.ty, wanted, "{}", self.path);
    }

    fn fields(self, fields: &'a [Field], names: &[&str]) -> Values<'a> {
        let own: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
        assert_eq!(own, names, "{}", self.path);
        let types = fields.iter().map(|field| (&field.ty, field.name.as_str()));
        Values {
            source: self,
            left: types.collect(),
        }
    }

    fn repeated(self, of: &'a Type, count: usize) -> Values<'a> {
        Values {
            source: self,
            left: std::iter::repeat_n((of, self.path), count).collect(),
        }
    }
}

macro_rules! numbers {
    ($($method:ident $visit:ident $ty:ident;)*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            self.expect(&Type::$ty);
            visitor.$visit(Default::default())
        })*
    };
}

impl<'de> Deserializer<'de> for Source<'_> {
    type Error = Error;

    numbers! {
        deserialize_u8 visit_u8 U8;
        deserialize_u16 visit_u16 U16;
        deserialize_u32 visit_u32 U32;
        deserialize_u64 visit_u64 U64;
        deserialize_f32 visit_f32 F32;
        deserialize_f64 visit_f64 F64;
    }

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        panic!(
            "{}: the code has a type that the contract knows nothing of",
            self.path
        )
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.expect(&Type::String);
        visitor.visit_str("a")
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        assert!(matches!(self.ty, Type::Bytes(_)), "{}", self.path);
        visitor.visit_bytes(&[])
    }

    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_bytes(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let Type::Optional(ty) = self.ty else {
            panic!("{}: optional in the code", self.path)
        };
        visitor.visit_some(Source { ty, ..self })
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let Type::List(of, _) = self.ty else {
            panic!("{}: a list in the code", self.path)
        };
        visitor.visit_seq(self.repeated(of, 1))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, n: usize, visitor: V) -> Result<V::Value, Error> {
        let Type::Array(of, length) = self.ty else {
            panic!("{}: an array in the code", self.path)
        };
        assert_eq!(*length, n, "{}", self.path);
        visitor.visit_seq(self.repeated(of, n))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let Shape::Struct(fields) = self.shape() else {
            panic!("{}: a struct in the code", self.path)
        };
        visitor.visit_seq(self.fields(fields, names))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let Shape::Enum(variants) = self.shape() else {
            panic!("{}: an enum in the code", self.path)
        };
        let own: Vec<&str> = variants
            .iter()
            .map(|variant| variant.name.as_str())
            .collect();
        assert_eq!(own, names, "{}", self.path);
        let index = self.round % variants.len();
        visitor.visit_enum(Chosen {
            source: self,
            index,
            variant: &variants[index],
        })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u128 char unit unit_struct tuple_struct map identifier ignored_any
    }
}

/// Values one after the other, each with its name.
struct Values<'a> {
    source: Source<'a>,
    left: std::collections::VecDeque<(&'a Type, &'a str)>,
}

impl<'de> SeqAccess<'de> for Values<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some((ty, name)) = self.left.pop_front() else {
            return Ok(None);
        };
        let path = format!("{}.{name}", self.source.path);
        let source = Source {
            ty,
            path: &path,
            ..self.source
        };
        seed.deserialize(source).map(Some)
    }
}

struct Chosen<'a> {
    source: Source<'a>,
    index: usize,
    variant: &'a Variant,
}

impl<'de> EnumAccess<'de> for Chosen<'_> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Error> {
        let index = u32::try_from(self.index).unwrap();
        let value = seed.deserialize(IntoDeserializer::<Error>::into_deserializer(index))?;
        Ok((value, self))
    }
}

impl<'de> VariantAccess<'de> for Chosen<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        assert_eq!(self.variant.content, Content::Unit, "{}", self.source.path);
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        let Content::Value(ty) = &self.variant.content else {
            panic!("{}: a value in the code", self.variant.name)
        };
        seed.deserialize(Source { ty, ..self.source })
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let Content::Fields(fields) = &self.variant.content else {
            panic!("{}: fields in the code", self.variant.name)
        };
        visitor.visit_seq(self.source.fields(fields, names))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Error> {
        panic!(
            "{}: a tuple, which the contract does not have",
            self.variant.name
        )
    }
}
