//! Source files that are made from the contract: how they are written, and how a check finds one that is out of date.

use crate::tools::root;
use sextant_contract::Contract;
use std::fs;

/// A committed file, and what makes it.
pub struct Generated {
    /// Its path within the workspace.
    pub file: &'static str,
    /// The chore that writes it.
    pub chore: &'static str,
    pub make: fn() -> Result<String, String>,
}

impl Generated {
    pub fn write(&self) -> Result<(), String> {
        let text = (self.make)()?;
        fs::write(root().join(self.file), text).map_err(|cause| format!("{}: {cause}", self.file))
    }

    pub fn check(&self) -> Result<(), String> {
        let Self { file, chore, make } = self;
        if read(file)? == make()? {
            return Ok(());
        }
        Err(format!(
            "{file} differs from what proto/CONTRACT.md makes: run `cargo xtask {chore}` and commit it"
        ))
    }
}

/// The network's contract, read from `proto/CONTRACT.md`.
pub fn contract() -> Result<Contract, String> {
    Contract::read(&read("proto/CONTRACT.md")?).map_err(|cause| cause.to_string())
}

pub fn read(file: &str) -> Result<String, String> {
    fs::read_to_string(root().join(file)).map_err(|cause| format!("{file}: {cause}"))
}

/// `camera_moved` and `brown-conrady` as `CameraMoved` and `BrownConrady`.
pub fn camel(name: &str) -> String {
    let words = name.split(['_', '-']);
    let capital = |word: &str| {
        let (first, rest) = word.split_at(1);
        first.to_uppercase() + rest
    };
    words.map(capital).collect()
}
