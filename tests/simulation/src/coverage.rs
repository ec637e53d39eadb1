//! Which faults met which states of a fusion node.

use node_fusion::CoreState;
use std::collections::BTreeMap;

/// Turns of fusion nodes by fault and state.
#[derive(Debug, Clone, Default)]
pub struct Coverage {
    turns: BTreeMap<(&'static str, &'static str), u64>,
}

impl Coverage {
    /// Notes a turn under these faults.
    pub fn note(&mut self, faults: impl Iterator<Item = &'static str>, state: &CoreState) {
        let mut faults = faults.peekable();
        if faults.peek().is_none() {
            return;
        }
        let doing = match (state.leads, state.is_current, state.is_deciding) {
            (_, false, _) => "follows newer models",
            (true, true, true) => "decides on a change",
            (true, true, false) => "publishes",
            (false, true, _) => "stands by",
        };
        for fault in faults {
            *self.turns.entry((fault, doing)).or_default() += 1;
        }
    }

    /// Adds those of another run.
    pub fn add(&mut self, other: &Self) {
        for (pair, turns) in &other.turns {
            *self.turns.entry(*pair).or_default() += turns;
        }
    }

    /// A line a fault.
    #[must_use]
    pub fn table(&self) -> String {
        const STATES: [&str; 4] = [
            "publishes",
            "stands by",
            "decides on a change",
            "follows newer models",
        ];
        let mut faults: Vec<&str> = self.turns.keys().map(|(fault, _)| *fault).collect();
        faults.dedup();
        let mut words = format!("{:18}", "turns");
        for state in STATES {
            words += &format!("{state:>22}");
        }
        for fault in faults {
            words += &format!("\n{fault:18}");
            for state in STATES {
                let turns = self.turns.get(&(fault, state)).copied().unwrap_or(0);
                words += &format!("{turns:22}");
            }
        }
        words
    }
}
