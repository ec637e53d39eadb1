//! Passwords and tokens.

use anyhow::Context;
use std::fs::File;
use std::io::Read;

/// Random bytes of a secret; enough to make guessing infeasible.
const BYTES: usize = 16;

/// A random secret of letters and digits.
///
/// # Errors
/// A system without a source of random numbers.
pub fn random_text() -> anyhow::Result<String> {
    let mut bytes = [0_u8; BYTES];
    File::open("/dev/urandom")
        .and_then(|mut source| source.read_exact(&mut bytes))
        .context("/dev/urandom")?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
