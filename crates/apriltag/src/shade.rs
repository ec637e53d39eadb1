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

    /// Says of each tile of a row, by 0 or 1, whether it is live and whether it shows shade.
    pub(crate) fn set_row(&mut self, row: usize, live: &[u8], seeds: &[u8]) {
        let words = row * self.words_in_row..(row + 1) * self.words_in_row;
        for (i, word) in words.enumerate() {
            self.live[word] = pack(live, i);
            self.reached[word] = pack(seeds, i) & self.live[word];
        }
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
        let (from, to_start) = (from * self.words_in_row, to * self.words_in_row);
        let mut changed = false;
        for i in 0..self.words_in_row {
            let here = self.reached[from + i];
            let left = if i > 0 {
                self.reached[from + i - 1] >> (WORD - 1)
            } else {
                0
            };
            let right = if i + 1 < self.words_in_row {
                self.reached[from + i + 1] << (WORD - 1)
            } else {
                0
            };
            let near = here | here << 1 | here >> 1 | left | right;
            let new = near & self.live[to_start + i] & !self.reached[to_start + i];
            self.reached[to_start + i] |= new;
            changed |= new != 0;
        }
        if changed {
            self.fill_row(to);
        }
        changed
    }

    /// Spreads along a row in both directions.
    fn fill_row(&mut self, row: usize) {
        let words = row * self.words_in_row..(row + 1) * self.words_in_row;
        let (live, reached) = (&self.live[words.clone()], &mut self.reached[words]);
        let mut carry = 0;
        for (live, reached) in live.iter().zip(reached.iter_mut()) {
            *reached = fill_upwards(*reached | carry & live, *live);
            carry = *reached >> (WORD - 1);
        }
        carry = 0;
        for (live, reached) in live.iter().zip(reached.iter_mut()).rev() {
            let seeds = (*reached).reverse_bits() | carry & live.reverse_bits();
            *reached = fill_upwards(seeds, live.reverse_bits()).reverse_bits();
            carry = *reached & 1;
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

/// One bit for each of 64 bytes that are 0 or 1; none for those that are missing.
fn pack(flags: &[u8], word: usize) -> u64 {
    /// Moves the lowest bits of eight bytes beside each other into the highest byte.
    const GATHER: u64 = 0x0102_0408_1020_4080;
    let flags = &flags[word * WORD..flags.len().min((word + 1) * WORD)];
    flags.chunks(8).enumerate().fold(0, |bits, (i, chunk)| {
        let mut bytes = [0; 8];
        bytes[..chunk.len()].copy_from_slice(chunk);
        bits | (u64::from_le_bytes(bytes).wrapping_mul(GATHER) >> 56) << (8 * i)
    })
}

/// The seeds and all set bits of `live` above them without a gap (Kogge-Stone: distances 1, 2, 4, ..., 32).
fn fill_upwards(seeds: u64, live: u64) -> u64 {
    let (mut filled, mut open) = (seeds, live);
    for distance in [1, 2, 4, 8, 16, 32] {
        filled |= open & (filled << distance);
        open &= open << distance;
    }
    filled
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
