//! Where the second chance is worth its time: tiles that hang together with black and white in the shade of something
//! brighter. One bit a tile.
//!
//! In: which tiles are live and which of them show shade. Out: the live tiles that are connected to those. A tag's border
//! is a closed band of live tiles, so all of it is reached from wherever a lit neighbour spoils the usual level.

/// Most sweeps over the image down and up again. Each reaches around one more bend of a band; a tag's border has four.
const MAX_SWEEPS: usize = 8;

const WORD: usize = u64::BITS as usize;

#[derive(Debug, Default)]
pub(crate) struct Shade {
    words_in_row: usize,
    live: Vec<u64>,
    reached: Vec<u64>,
}

impl Shade {
    pub(crate) fn make_room(&mut self, columns: usize, rows: usize) {
        self.words_in_row = columns.div_ceil(WORD);
        self.live.resize(self.words_in_row * rows, 0);
        self.reached.resize(self.words_in_row * rows, 0);
    }

    /// Says of each tile of a row, by 0 or 1, whether it is live and whether it shows shade; returns whether any does.
    pub(crate) fn set_row(&mut self, row: usize, live: &[u8], seeds: &[u8]) -> bool {
        let words = row * self.words_in_row..(row + 1) * self.words_in_row;
        let here = self.live[words.clone()]
            .iter_mut()
            .zip(&mut self.reached[words]);
        let flags = live.chunks(WORD).zip(seeds.chunks(WORD));
        let mut any = 0;
        for ((live_word, reached), (live, seeds)) in here.zip(flags) {
            *live_word = pack(live);
            *reached = pack(seeds) & *live_word;
            any |= *reached;
        }
        any != 0
    }

    pub(crate) fn clear_row(&mut self, row: usize) {
        let words = row * self.words_in_row..(row + 1) * self.words_in_row;
        self.live[words.clone()].fill(0);
        self.reached[words].fill(0);
    }

    pub(crate) fn spread(&mut self) {
        let n_rows = self.live.len() / self.words_in_row;
        for row in 0..n_rows {
            self.fill_row(row);
        }
        for _ in 0..MAX_SWEEPS {
            let down = (1..n_rows)
                .filter(|&row| self.reach_from(row - 1, row))
                .count();
            let up = (1..n_rows)
                .rev()
                .filter(|&row| self.reach_from(row, row - 1))
                .count();
            if down + up == 0 {
                break;
            }
        }
    }

    /// Takes in the live tiles of a row that touch reached ones of the row beside it. Says whether there were new ones.
    fn reach_from(&mut self, from: usize, to: usize) -> bool {
        let n = self.words_in_row;
        let (first, rest) = self.reached.split_at_mut(from.max(to) * n);
        let (low, high) = (&mut first[from.min(to) * n..][..n], &mut rest[..n]);
        let (from_words, to_words) = if from < to { (low, high) } else { (high, low) };
        let (mut changed, mut left) = (0, 0);
        for (i, (to_word, live)) in to_words.iter_mut().zip(&self.live[to * n..]).enumerate() {
            let here = from_words[i];
            let right = from_words.get(i + 1).map_or(0, |right| right << (WORD - 1));
            let new = (here | here << 1 | here >> 1 | left | right) & live & !*to_word;
            *to_word |= new;
            changed |= new;
            left = here >> (WORD - 1);
        }
        if changed != 0 {
            self.fill_row(to);
        }
        changed != 0
    }

    /// Spreads along a row in both directions.
    fn fill_row(&mut self, row: usize) {
        let words = row * self.words_in_row..(row + 1) * self.words_in_row;
        let (live, reached) = (&self.live[words.clone()], &mut self.reached[words]);
        let mut carry = false;
        for (live, reached) in live.iter().zip(reached.iter_mut()) {
            (*reached, carry) = fill_upwards(*reached, *live, carry);
        }
        carry = false;
        for (live, reached) in live.iter().zip(reached.iter_mut()).rev() {
            let filled;
            (filled, carry) = fill_upwards(reached.reverse_bits(), live.reverse_bits(), carry);
            *reached = filled.reverse_bits();
        }
    }

    /// Puts out the levels of a row's tiles that were not reached.
    pub(crate) fn mask_row(&self, row: usize, levels: &mut [u8]) {
        let words = &self.reached[row * self.words_in_row..][..self.words_in_row];
        for (levels, word) in levels.chunks_mut(WORD).zip(words) {
            for (i, level) in levels.iter_mut().enumerate() {
                *level *= (word >> i & 1) as u8;
            }
        }
    }
}

/// One bit for each of up to 64 bytes that are 0 or 1.
fn pack(flags: &[u8]) -> u64 {
    /// Moves the lowest bits of eight bytes beside each other into the highest byte.
    const GATHER: u64 = 0x0102_0408_1020_4080;
    let (eights, rest) = flags.as_chunks::<8>();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    let bits = eights.iter().chain([&last]).enumerate();
    bits.take(WORD / 8).fold(0, |bits, (i, eight)| {
        bits | (u64::from_le_bytes(*eight).wrapping_mul(GATHER) >> 56) << (8 * i)
    })
}

/// The seeds and all set bits of `live` above them without a gap, and whether that goes on beyond the last bit: what the
/// carries of an addition reach.
fn fill_upwards(seeds: u64, live: u64, carry: bool) -> (u64, bool) {
    let (sum, over) = live.overflowing_add(seeds);
    let (sum, over_too) = sum.overflowing_add(u64::from(carry));
    (((sum ^ live) | seeds) & live, over | over_too)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles as text: `.` dead, `o` live, `x` live and showing shade.
    fn spread(picture: &[&str]) -> Vec<String> {
        let mut shade = Shade::default();
        shade.make_room(picture[0].len(), picture.len());
        for (row, tiles) in picture.iter().enumerate() {
            let live: Vec<u8> = tiles.bytes().map(|tile| u8::from(tile != b'.')).collect();
            let seeds: Vec<u8> = tiles.bytes().map(|tile| u8::from(tile == b'x')).collect();
            shade.set_row(row, &live, &seeds);
        }
        shade.spread();
        let reached = |row: usize| {
            let mut levels = vec![b'x'; picture[0].len()];
            shade.mask_row(row, &mut levels);
            levels
                .iter()
                .map(|&level| if level == 0 { '.' } else { 'x' })
                .collect()
        };
        (0..picture.len()).map(reached).collect()
    }

    #[test]
    fn a_band_is_reached_all_around_and_others_are_not() {
        let picture = [
            "ooooo.ooo",
            "o...o.o.o",
            "o...o.ooo",
            "ooxoo....",
            ".....o...",
        ];
        assert_eq!(
            spread(&picture),
            [
                "xxxxx....",
                "x...x....",
                "x...x....",
                "xxxxx....",
                ".....x..."
            ]
        );
    }

    #[test]
    fn words_hang_together() {
        let mut row = "o".repeat(200);
        assert_eq!(spread(&[&row]), [".".repeat(200)]);
        row.replace_range(100..101, "x");
        assert_eq!(spread(&[&row]), ["x".repeat(200)]);
        let above = format!("{}x{}", ".".repeat(64), ".".repeat(135));
        let below = format!("{}o{}", ".".repeat(63), ".".repeat(136));
        assert_eq!(spread(&[&above, &below])[1], below.replace('o', "x"));
    }
}
