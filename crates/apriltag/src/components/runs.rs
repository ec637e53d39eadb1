//! Runs in the words of a pair of rows, and which of them touch those of the pair above.
//!
//! In: two rows of bits, or four. Out: where runs begin and end; labels by which runs that touch hang together.

use super::Span;
use crate::bit_plane::RowPair;
use crate::kernels::WORD;
use std::hint::select_unpredictable;

/// Where bits of either row begin and end to be set, in turn. Returns how many runs there are.
#[inline(always)]
pub(super) fn find_spans(pair: &RowPair<'_>, spans: &mut [Span]) -> usize {
    let columns = spans.as_flattened_mut();
    let (mut n, mut carry) = (0, 0);
    for i in pair.live.clone() {
        let word = pair.upper[i] | pair.lower[i];
        let mut changes = word ^ (word << 1 | carry);
        carry = word >> (WORD - 1);
        while changes != 0 {
            columns[n] = (i * WORD) as u16 + changes.trailing_zeros() as u16;
            changes &= changes - 1;
            n += 1;
        }
    }
    if carry != 0 {
        columns[n] = (pair.live.end * WORD) as u16;
        n += 1;
    }
    n / 2
}

/// A word with each of its bits once more a column further on, the last of them in `carry` for the next word.
#[inline(always)]
fn moved_on(word: u64, carry: &mut u64) -> u64 {
    let moved = word << 1 | *carry;
    *carry = word >> (WORD - 1);
    moved
}

/// Joins the runs of a pair of rows with those of the pair above, each with the number of its first run.
///
/// Rows touch where both are black or have just been. Two runs are joined at the first such place beside others, and where
/// one of them begins.
#[inline(always)]
pub(super) fn join_pairs<'a>(
    labels: &mut [u32],
    (pair, first): &(RowPair<'a>, usize),
    (above, first_above): &(RowPair<'a>, usize),
) {
    if pair.live.is_empty() || above.live.is_empty() {
        return;
    }
    let (mut n, mut n_above) = (*first as u32, *first_above as u32);
    let mut carries = [0; 5];
    let live = pair.live.start.min(above.live.start)..pair.live.end.max(above.live.end);
    let words_of = |rows: &RowPair<'a>| {
        let [upper, lower] = [rows.upper, rows.lower].map(|row| &row[live.clone()]);
        upper.iter().zip(lower)
    };
    for ((upper, lower), (upper_above, lower_above)) in words_of(pair).zip(words_of(above)) {
        let [of_upper, of_lower_above, of_runs, of_runs_above, of_touch] = &mut carries;
        let begun = |word: u64, carry| word & !moved_on(word, carry);
        let reached = |word: u64, carry| word | moved_on(word, carry);
        let runs = begun(upper | lower, of_runs);
        let runs_above = begun(upper_above | lower_above, of_runs_above);
        let touch = reached(*upper, of_upper) & reached(*lower_above, of_lower_above);
        let mut joints = begun(touch, of_touch) | touch & (runs | runs_above);
        while joints != 0 {
            let up_to_here = joints ^ (joints - 1);
            let run = n + (runs & up_to_here).count_ones() - 1;
            let run_above = n_above + (runs_above & up_to_here).count_ones() - 1;
            join(labels, run, run_above);
            joints &= joints - 1;
        }
        n += runs.count_ones();
        n_above += runs_above.count_ones();
    }
}

/// Lets two runs hang together: the first run of either component goes by that of the other.
#[inline(always)]
fn join(labels: &mut [u32], a: u32, b: u32) {
    let (a, b) = (first_run(labels, a), first_run(labels, b));
    let (later, earlier) = (
        select_unpredictable(a > b, a, b),
        select_unpredictable(a > b, b, a),
    );
    labels[later as usize] = earlier;
}

/// The first run of a run's component, with the path to it halved. Most runs know it, be it themselves or another.
#[inline(always)]
fn first_run(labels: &mut [u32], mut run: u32) -> u32 {
    loop {
        let earlier = labels[run as usize];
        let earliest = labels[earlier as usize];
        if earliest == earlier {
            return earliest;
        }
        labels[run as usize] = earliest;
        run = earliest;
    }
}
