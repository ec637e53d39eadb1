//! Value of `--ids`: ids and ranges.

use anyhow::{Context, ensure};
use std::str::FromStr;

/// Most tags of one file, so that a typing error does not fill the disk.
const MAX_TAGS: usize = 1000;

/// Ids in the order given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ids(Vec<u32>);

impl FromStr for Ids {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let mut ids = Vec::new();
        for part in text.split(',') {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let number = |word: &str| {
                let number = word.trim().parse::<u32>();
                number.with_context(|| format!("`{part}` is no id and no range such as 0-5"))
            };
            let (first, last) = (number(first)?, number(last)?);
            ensure!(first <= last, "the range `{part}` runs backwards");
            let count = (last - first) as usize + ids.len();
            ensure!(count < MAX_TAGS, "more than {MAX_TAGS} tags");
            ids.extend(first..=last);
        }
        Ok(Self(ids))
    }
}

impl Ids {
    /// The ids in the order given.
    pub fn as_slice(&self) -> &[u32] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_single_or_ranges() {
        assert_eq!("0-2,9, 4".parse::<Ids>().unwrap().0, [0, 1, 2, 9, 4]);
        for wrong in ["", "3-1", "a", "1-", "0-4000000000"] {
            assert!(wrong.parse::<Ids>().is_err(), "{wrong}");
        }
    }
}
