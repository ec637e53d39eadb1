//! What became of each chore: the table at the end.

use std::fmt;
use std::time::Duration;

pub enum ChoreOutcome {
    Passed,
    /// With the reason.
    Skipped(String),
    /// With the cause.
    Failed(String),
}

pub struct Row {
    pub word: &'static str,
    pub outcome: ChoreOutcome,
    pub took: Duration,
    /// What the chore skipped, and why.
    pub skips: Vec<String>,
}

/// One row per chore, in their order.
#[derive(Default)]
pub struct Report(pub Vec<Row>);

impl Report {
    pub fn has_failed(&self, word: &str) -> bool {
        let is_it = |row: &&Row| row.word == word;
        let row = self.0.iter().find(is_it);
        row.is_some_and(|row| !matches!(row.outcome, ChoreOutcome::Passed))
    }

    /// One chore and nothing to say about it that it has not said itself.
    pub fn is_trivial(&self) -> bool {
        let [row] = self.0.as_slice() else {
            return false;
        };
        row.skips.is_empty() && !matches!(row.outcome, ChoreOutcome::Skipped(_))
    }

    /// The words of what failed.
    pub fn failed(&self) -> Vec<&'static str> {
        let failed = |row: &&Row| matches!(row.outcome, ChoreOutcome::Failed(_));
        self.0.iter().filter(failed).map(|row| row.word).collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{:<14}{:<10}{:>6}", "chore", "outcome", "time")?;
        for row in &self.0 {
            let (outcome, why) = match &row.outcome {
                ChoreOutcome::Passed => ("passed", ""),
                ChoreOutcome::Skipped(why) => ("skipped", why.as_str()),
                ChoreOutcome::Failed(cause) => ("FAILED", cause.as_str()),
            };
            let line = format!("{:<14}{outcome:<10}{:>6}  {why}", row.word, clock(row.took));
            writeln!(out, "{}", line.trim_end())?;
            for skip in &row.skips {
                writeln!(out, "{:<14}skipped: {skip}", "")?;
            }
        }
        Ok(())
    }
}

fn clock(took: Duration) -> String {
    let seconds = took.as_secs();
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_outcome_with_its_reason() {
        let row = |word, outcome, skips: &[&str]| Row {
            word,
            outcome,
            took: Duration::from_secs(75),
            skips: skips.iter().map(|&skip| skip.to_owned()).collect(),
        };
        let report = Report(vec![
            row("page", ChoreOutcome::Passed, &[]),
            row(
                "system",
                ChoreOutcome::Failed("tests/tests/fleet.rs".to_owned()),
                &["a: needs b"],
            ),
            row("arm", ChoreOutcome::Skipped("needs qemu".to_owned()), &[]),
        ]);
        let lines = [
            "chore         outcome     time",
            "page          passed      1:15",
            "system        FAILED      1:15  tests/tests/fleet.rs",
            "              skipped: a: needs b",
            "arm           skipped     1:15  needs qemu",
        ];
        assert_eq!(report.to_string(), lines.join("\n") + "\n");
        assert_eq!(report.failed(), ["system"]);
        assert!(report.has_failed("arm") && !report.has_failed("page"));
    }
}
