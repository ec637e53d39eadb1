//! Verdicts, for people without experience of good numbers.

mod finding;

pub use finding::{Finding, PosePart, ScaleSource, WeakMotion};

use serde::Serialize;
use std::fmt;

/// Grade of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// Only better cameras would improve it.
    Good,
    /// It works; the reasons show what would improve it.
    Usable,
    /// It has to be repeated; the reasons show how.
    Poor,
}

/// A grade with its reasons.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The worst grade of all findings.
    pub grade: Grade,
    /// What limits the result; empty for a good one without remarks.
    pub because: Vec<Finding>,
}

impl Verdict {
    pub(crate) fn new() -> Self {
        Self {
            grade: Grade::Good,
            because: Vec::new(),
        }
    }

    /// Adds a finding; the worst one decides.
    pub(crate) fn add(&mut self, grade: Grade, because: Finding) {
        self.grade = self.grade.max(grade);
        self.because.push(because);
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Good => "good",
            Self::Usable => "usable",
            Self::Poor => "poor",
        })
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.grade)?;
        if !self.because.is_empty() {
            let because: Vec<String> = self.because.iter().map(Finding::to_string).collect();
            write!(f, ": {}", because.join("; "))?;
        }
        Ok(())
    }
}

/// Joins names into a list: "a, b and c".
pub(crate) fn listed(names: impl IntoIterator<Item = impl fmt::Display>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| name.to_string()).collect();
    match names.as_slice() {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_finding_decides() {
        let mut verdict = Verdict::new();
        verdict.add(Grade::Poor, Finding::Unplaced("blurred".to_owned()));
        let tag = "tag36h11:3".to_owned();
        verdict.add(Grade::Usable, Finding::FewImages { tag, fits: 2 });
        assert_eq!(
            verdict.to_string(),
            "poor: blurred; only 2 images of tag36h11:3 fit"
        );
    }

    #[test]
    fn lists_read_as_people_write_them() {
        assert_eq!(listed(["a"]), "a");
        assert_eq!(listed(["a", "b", "c"]), "a, b and c");
    }
}
