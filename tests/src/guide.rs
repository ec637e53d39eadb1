//! Commands that a guide tells people to type.

use crate::program::workspace_root;
use std::fs;

/// The lines of a page's blocks that begin with ```` ```KIND ````.
///
/// # Panics
/// When there is no such page, or no such block.
#[must_use]
pub fn commands(page: &str, kind: &str) -> Vec<String> {
    let text = fs::read_to_string(workspace_root().join(page)).expect("a page");
    let blocks = text.split("\n```").skip(1).step_by(2);
    let commands: Vec<String> = blocks
        .filter_map(|block| block.split_once('\n'))
        .filter(|(of, _)| *of == kind)
        .flat_map(|(_, lines)| lines.lines().map(str::to_owned))
        .collect();
    assert!(!commands.is_empty(), "{page} has no block {kind}");
    commands
}
