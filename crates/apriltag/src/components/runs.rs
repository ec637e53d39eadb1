//! Runs in the words of a pair of rows, and which of them touch runs of the pair above.
//!
//! Input: two rows of bits, or four. Output: start and end of each run, the part of a component that each run belongs
//! to, and which parts are connected.

use super::{Component, Span};
use crate::bit_plane::RowPair;
use crate::kernels::WORD;
use std::mem;

/// Label of a run without a part. Its bytes differ, since memory filled with one repeated byte is
/// set by a call that is slower than a vectorised loop.
pub(super) const UNLABELLED: u32 = 1 << 31;

/// Start and end of the runs of either row. Returns the number of runs.
#[inline(always)]
pub(super) fn find_spans(pair: &RowPair<'_>, spans: &mut [Span]) -> usize {
    let (mut n, mut before) = (0, 0);
    for i in pair.live.clone() {
        let word = pair.upper[i] | pair.lower[i];
        let column = |bits: u64| (i * WORD) as u16 + bits.trailing_zeros() as u16;
        let moved = moved_on(word, &mut before);
        let (mut begun, mut ended) = (word & !moved, moved & !word);
        // A run of the previous word that reached this one.
        if moved & 1 != 0 {
            spans[n - 1][1] = column(ended);
            ended &= ended.wrapping_sub(1);
        }
        while begun != 0 {
            // A run that does not end here reaches at least the next word.
            spans[n] = [column(begun), column(ended)];
            begun &= begun - 1;
            ended &= ended.wrapping_sub(1);
            n += 1;
        }
    }
    n
}

/// A word shifted by one column, with the carry of the previous word, which it replaces for the next one.
#[inline(always)]
fn moved_on(word: u64, before: &mut u64) -> u64 {
    word << 1 | mem::replace(before, word) >> (WORD - 1)
}

/// A pair of rows with the number of its first run.
#[derive(Default)]
pub(super) struct NumberedPair<'a> {
    pub(super) rows: RowPair<'a>,
    pub(super) first_run: usize,
}

/// Connects the runs of a pair of rows with those of the pair above: they get the same part, or their parts are merged.
///
/// Rows touch where both are black or were in the previous column. Two runs are connected at the first such place, and
/// where one of them begins.
#[inline(always)]
pub(super) fn join_pairs<'a>(
    labels: &mut [u32],
    parts: &mut [Component],
    here: &NumberedPair<'a>,
    over: &NumberedPair<'a>,
) {
    let (pair, above) = (&here.rows, &over.rows);
    if pair.live.is_empty() || above.live.is_empty() {
        return;
    }
    let (mut n, mut n_above) = (here.first_run as u32, over.first_run as u32);
    let mut before = [0; 5];
    let live = pair.live.start.min(above.live.start)..pair.live.end.max(above.live.end);
    let words_of = |rows: &RowPair<'a>| {
        let [upper, lower] = [rows.upper, rows.lower].map(|row| &row[live.clone()]);
        upper.iter().zip(lower)
    };
    for ((upper, lower), (upper_above, lower_above)) in words_of(pair).zip(words_of(above)) {
        let [of_upper, of_lower_above, of_runs, of_runs_above, of_touch] = &mut before;
        let begun = |word: u64, before| word & !moved_on(word, before);
        let reached = |word: u64, before| word | moved_on(word, before);
        let runs = begun(upper | lower, of_runs);
        let runs_above = begun(upper_above | lower_above, of_runs_above);
        let touch = reached(*upper, of_upper) & reached(*lower_above, of_lower_above);
        let mut joints = begun(touch, of_touch) | touch & (runs | runs_above);
        while joints != 0 {
            let up_to_here = joints ^ (joints - 1);
            let run = n + (runs & up_to_here).count_ones() - 1;
            let run_above = n_above + (runs_above & up_to_here).count_ones() - 1;
            let (part, above) = (labels[run as usize], labels[run_above as usize]);
            labels[run as usize] = match part {
                UNLABELLED => above,
                _ if part == above => part,
                _ => join(parts, part, above),
            };
            joints &= joints - 1;
        }
        n += runs.count_ones();
        n_above += runs_above.count_ones();
    }
}

/// Connects two parts: the first part of one component refers to that of the other, which is returned.
fn join(parts: &mut [Component], a: u32, b: u32) -> u32 {
    let (a, b) = (first_part(parts, a), first_part(parts, b));
    parts[a.max(b) as usize].earlier = a.min(b);
    a.min(b)
}

/// The first part of a component; halves the path to it.
fn first_part(parts: &mut [Component], mut part: u32) -> u32 {
    while parts[part as usize].earlier != part {
        let earlier = parts[part as usize].earlier;
        let earliest = parts[earlier as usize].earlier;
        parts[part as usize].earlier = earliest;
        part = earliest;
    }
    part
}
