//! Types of the contract.

/// A type that the contract defines by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// What it is made of.
    pub shape: Shape,
    /// Sentences behind the definition.
    pub note: String,
}

/// What a named or nested type is made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// Fields in the order of the bytes.
    Struct(Vec<Field>),
    /// Variants by number, from 0.
    Enum(Vec<Variant>),
    /// `A or B`, distinguished by their fields: in JSON only.
    OneOf(Vec<String>),
}

/// A field of a struct or of a variant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// `name?`: left out where there is nothing to say, in JSON only.
    pub may_be_missing: bool,
    /// What stands in parentheses behind it.
    pub note: String,
}

/// A variant of an enum.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// What it holds.
    pub content: Content,
    /// What stands in parentheses, or as a sentence, behind it.
    pub note: String,
}

/// What a variant holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Content {
    /// Nothing.
    Unit,
    /// One value: `name(T)`.
    Value(Type),
    /// Fields: `name { a: T }`.
    Fields(Vec<Field>),
}

/// The type of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the type of its name in the contract")]
pub enum Type {
    /// In JSON only.
    Bool,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
    String,
    /// Raw bytes, at most so many where that is stated.
    Bytes(Option<usize>),
    /// A list, of at most so many elements where that is stated.
    List(Box<Type>, Option<usize>),
    Array(Box<Type>, usize),
    /// `[A, B]`, in JSON only.
    Tuple(Vec<Type>),
    Optional(Box<Type>),
    Named(String),
    /// A type without a name of its own.
    Nested(Box<Shape>),
}

impl Definition {
    /// Whether it is a message of the bridge's protocol.
    #[must_use]
    pub fn is_message(&self) -> bool {
        self.name
            .starts_with(|letter: char| letter.is_ascii_lowercase())
    }
}

impl Shape {
    /// Adds the names that it refers to.
    pub(crate) fn collect_names<'a>(&'a self, names: &mut Vec<&'a str>) {
        if let Self::OneOf(alternatives) = self {
            names.extend(alternatives.iter().map(String::as_str));
        }
        for ty in self.types() {
            ty.collect_names(names);
        }
    }

    fn types(&self) -> Vec<&Type> {
        match self {
            Self::Struct(fields) => fields.iter().map(|field| &field.ty).collect(),
            Self::Enum(variants) => variants.iter().flat_map(Variant::types).collect(),
            Self::OneOf(_) => Vec::new(),
        }
    }
}

impl Variant {
    fn types(&self) -> Vec<&Type> {
        match &self.content {
            Content::Unit => Vec::new(),
            Content::Value(ty) => vec![ty],
            Content::Fields(fields) => fields.iter().map(|field| &field.ty).collect(),
        }
    }
}

impl Type {
    fn collect_names<'a>(&'a self, names: &mut Vec<&'a str>) {
        match self {
            Self::List(of, _) | Self::Array(of, _) | Self::Optional(of) => of.collect_names(names),
            Self::Tuple(items) => items.iter().for_each(|item| item.collect_names(names)),
            Self::Named(name) => names.push(name),
            Self::Nested(shape) => shape.collect_names(names),
            _ => {}
        }
    }

    /// The same with the limit that a note states.
    pub(crate) fn limited(self, note: &str) -> Self {
        match self {
            Self::Bytes(None) => Self::Bytes(limit(note)),
            Self::List(of, None) => Self::List(of, limit(note)),
            other => other,
        }
    }
}

/// The number behind the first "at most", which may have a space between thousands.
fn limit(note: &str) -> Option<usize> {
    let (_, number) = note.split_once("at most ")?;
    let digits: String = number
        .chars()
        .take_while(|letter| letter.is_ascii_digit() || *letter == ' ')
        .filter(char::is_ascii_digit)
        .collect();
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::limit;

    #[test]
    fn limits_are_found_in_notes() {
        assert_eq!(limit("at most 100 000"), Some(100_000));
        assert_eq!(
            limit("payload of an ObjectConfig each; at most 1024"),
            Some(1024)
        );
        assert_eq!(limit("at most 16, 240 bytes each"), Some(16));
        assert_eq!(limit("px²"), None);
    }
}
