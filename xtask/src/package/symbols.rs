//! Which version of the C library a program needs: the newest of its symbols' versions.

use std::path::Path;
use std::process::Command;

/// Fails where a symbol is newer than `newest`.
pub fn check(program: &Path, newest: [u32; 2]) -> Result<(), String> {
    let output = Command::new("readelf")
        .args(["--version-info", "--wide"])
        .arg(program)
        .output()
        .map_err(|cause| format!("readelf: {cause}"))?;
    let needed = needed(&String::from_utf8_lossy(&output.stdout));
    let Some(needed) = needed.filter(|_| output.status.success()) else {
        return Err(format!("{}: no symbol of glibc", program.display()));
    };
    let [[major, minor], [most_major, most_minor]] = [needed, newest];
    if needed > newest {
        return Err(format!(
            "{} needs glibc {major}.{minor}; it is to run with {most_major}.{most_minor}",
            program.display()
        ));
    }
    println!(
        "xtask: {} needs glibc {major}.{minor}, no newer than {most_major}.{most_minor}",
        program.display()
    );
    Ok(())
}

/// The newest version among the words of a listing.
fn needed(listing: &str) -> Option<[u32; 2]> {
    let words = listing.split_whitespace();
    let versions = words.filter_map(|word| word.strip_prefix("GLIBC_"));
    versions.filter_map(parse).max()
}

/// Of `2.17` or `2.2.5`; the third number is of no interest.
fn parse(version: &str) -> Option<[u32; 2]> {
    let mut numbers = version.split('.').map(str::parse);
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTING: &str = "
  0x0010: Version: 1  File: libm.so.6  Cnt: 1
  0x0020:   Name: GLIBC_2.4  Flags: none  Version: 9
  0x0040: Version: 1  File: libc.so.6  Cnt: 2
  0x0050:   Name: GLIBC_2.18  Flags: none  Version: 4
  0x0060:   Name: GLIBC_2.2.5  Flags: none  Version: 3
";

    #[test]
    fn the_newest_version_counts_and_as_a_number() {
        assert_eq!(needed(LISTING), Some([2, 18]));
        assert_eq!(needed("Name: GCC_3.5"), None);
    }

    /// This program was linked on this machine: it needs what no C library of the year 1997 has.
    #[test]
    fn a_program_of_a_newer_library_is_refused() {
        let program = std::env::current_exe().unwrap();
        check(&program, [2, 1]).unwrap_err();
        check(&program, [99, 0]).unwrap();
    }
}
