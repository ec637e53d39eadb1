//! Serde forms of bounded lists, bytes and long arrays: what is too long is refused before any memory is set aside for
//! it.

pub(crate) mod list {
    //! A list of at most `N` elements: its length is checked before memory is reserved.
    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use std::fmt;
    use std::marker::PhantomData;

    pub(crate) fn at_most<'de, T, D, const N: usize>(source: D) -> Result<Vec<T>, D::Error>
    where
        T: Deserialize<'de>,
        D: Deserializer<'de>,
    {
        source.deserialize_seq(Bounded::<T, N>(PhantomData))
    }

    struct Bounded<T, const N: usize>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Bounded<T, N> {
        type Value = Vec<T>;

        fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(out, "a list of at most {N}")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
            let length = items.size_hint().unwrap_or(0);
            if length > N {
                return Err(A::Error::invalid_length(length, &self));
            }
            let mut list = Vec::with_capacity(length);
            while let Some(item) = items.next_element()? {
                if list.len() == N {
                    return Err(A::Error::invalid_length(N + 1, &self));
                }
                list.push(item);
            }
            Ok(list)
        }
    }
}

pub(crate) mod bytes {
    //! At most `N` raw bytes; a list of numbers where the format has no bytes of its own (JSON).
    use serde::de::{Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::Serializer;
    use std::fmt;

    pub(crate) fn serialize<S: Serializer>(bytes: &[u8], sink: S) -> Result<S::Ok, S::Error> {
        sink.serialize_bytes(bytes)
    }

    pub(crate) fn at_most<'de, D, const N: usize>(source: D) -> Result<Vec<u8>, D::Error>
    where
        D: Deserializer<'de>,
    {
        source.deserialize_bytes(Bounded::<N>)
    }

    struct Bounded<const N: usize>;

    impl<'de, const N: usize> Visitor<'de> for Bounded<N> {
        type Value = Vec<u8>;

        fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(out, "at most {N} bytes")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
            if bytes.len() > N {
                return Err(E::invalid_length(bytes.len(), &self));
            }
            Ok(bytes.to_vec())
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
            let mut bytes = Vec::new();
            while let Some(byte) = items.next_element()? {
                if bytes.len() == N {
                    return Err(A::Error::invalid_length(N + 1, &self));
                }
                bytes.push(byte);
            }
            Ok(bytes)
        }
    }
}

pub(crate) mod array {
    //! Arrays longer than the 32 that serde itself knows: `N` numbers in a row, no length in front.
    use serde::de::{Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{SerializeTuple, Serializer};
    use std::fmt;

    pub(crate) fn serialize<S: Serializer, const N: usize>(
        values: &[f64; N],
        sink: S,
    ) -> Result<S::Ok, S::Error> {
        let mut tuple = sink.serialize_tuple(N)?;
        for value in values {
            tuple.serialize_element(value)?;
        }
        tuple.end()
    }

    pub(crate) fn deserialize<'de, D, const N: usize>(source: D) -> Result<[f64; N], D::Error>
    where
        D: Deserializer<'de>,
    {
        source.deserialize_tuple(N, Numbers::<N>)
    }

    struct Numbers<const N: usize>;

    impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
        type Value = [f64; N];

        fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(out, "{N} numbers")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
            let mut values = [0.0; N];
            for (index, value) in values.iter_mut().enumerate() {
                *value = items
                    .next_element()?
                    .ok_or_else(|| A::Error::invalid_length(index, &self))?;
            }
            Ok(values)
        }
    }
}
