//! The wire contract as data, read from the text of `proto/CONTRACT.md`: keys, kinds and the type of every message.
//!
//! The page is the source of decoders in other languages (`cargo xtask python`, `cargo xtask page-types`); tests of
//! `sextant-proto` hold it to the code. The viewer bridge's `PROTOCOL.md` defines its JSON messages in the same
//! notation and by the same types. No dependency, so that development tasks start in seconds.

mod definitions;
mod tables;
mod types;

pub use types::{Content, Definition, Field, Shape, Type, Variant};

/// A row of the table of keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyRow {
    /// The key below the site, with `<camera>` and the like for ids.
    pub key: String,
    /// The name of the message and its kind; none of liveliness tokens.
    pub message: Option<(String, u8)>,
}

/// A row of the table of kinds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KindRow {
    /// The number in the header.
    pub number: u8,
    /// The name of the message.
    pub message: String,
    /// Longest payload in bytes, header included.
    pub max_bytes: usize,
}

/// What the page `CONTRACT.md` defines, in its order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contract {
    /// Every key.
    pub keys: Vec<KeyRow>,
    /// Every kind of message.
    pub kinds: Vec<KindRow>,
    /// Every named type, messages included, in the order of the page.
    pub definitions: Vec<Definition>,
}

/// Where the page cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unreadable(pub String);

impl std::fmt::Display for Unreadable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unreadable {}

impl Contract {
    /// Reads the page.
    ///
    /// # Errors
    /// A table or type that is not written as the others are, and names without a definition.
    pub fn read(page: &str) -> Result<Self, Unreadable> {
        let contract = Self {
            keys: tables::keys(page)?,
            kinds: tables::kinds(page)?,
            definitions: definitions::definitions(page)?,
        };
        contract.check_names()?;
        Ok(contract)
    }

    /// Adds the messages of the viewer bridge's protocol, which begin with a small letter, and their types.
    ///
    /// # Errors
    /// As of [`read`](Self::read).
    pub fn with_protocol(mut self, page: &str) -> Result<Self, Unreadable> {
        self.definitions.extend(definitions::definitions(page)?);
        self.check_names()?;
        Ok(self)
    }

    /// The names of the protocol's messages.
    pub fn messages(&self) -> impl Iterator<Item = &str> {
        let messages = self.definitions.iter().filter(|it| it.is_message());
        messages.map(|message| message.name.as_str())
    }

    /// The type of that name.
    #[must_use]
    pub fn shape(&self, name: &str) -> Option<&Shape> {
        let mut definitions = self.definitions.iter();
        let definition = definitions.find(|definition| definition.name == name)?;
        Some(&definition.shape)
    }

    fn check_names(&self) -> Result<(), Unreadable> {
        let mut named: Vec<&str> = self.kinds.iter().map(|row| row.message.as_str()).collect();
        for definition in &self.definitions {
            definition.shape.collect_names(&mut named);
        }
        match named.into_iter().find(|name| self.shape(name).is_none()) {
            Some(name) => Err(Unreadable(format!("the type {name} has no definition"))),
            None => Ok(()),
        }
    }
}
