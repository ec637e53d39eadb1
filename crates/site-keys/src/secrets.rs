//! Passwords and tokens.

use crate::KeysError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Random bytes of a secret; enough to make guessing infeasible.
const BYTES: usize = 16;

/// A random secret of letters and digits.
///
/// # Errors
/// A system without a source of random numbers.
pub fn random_text() -> Result<String, KeysError> {
    let mut bytes = [0_u8; BYTES];
    let source = Path::new("/dev/urandom");
    File::open(source)
        .and_then(|mut source| source.read_exact(&mut bytes))
        .map_err(KeysError::system(source, ""))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
