//! The data of one family and the reader of its file.
//!
//! A file is words between white space; `#` begins a comment until the end of its line. In this order:
//! `total-width N`, `border-width N`, `border black|white`, `min-hamming N`, for tags of such boards `board aprilgrid`,
//! `bits N` and N pairs `x y` (most significant bit of the code word first), `codes N` and N hexadecimal code words. It
//! is read at compile time: a malformed file does not build. Tens of thousands of words would take the compiler too
//! long: there `codes N packed` ends the file, and a second one has the words, each in eight bytes, the highest first.

/// Colour of the ring that forms the tag's square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BorderColour {
    /// Black square on white (classic AprilTag, ArUco).
    Black,
    /// White square within black (AprilTag 3's "reversed border").
    White,
}

/// Calibration boards with tags of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// Kalibr's AprilGrid: black squares touch the corners of each tag, so that the corner modules of its ring are
    /// black.
    Aprilgrid,
    /// OpenCV's ChArUco board: a marker in the middle of each white square of a chessboard. The tag is that white
    /// square: its corners are corners of the chessboard, and its size is the square's edge. The layout is the
    /// marker's, of any share of the square.
    Charuco,
    /// A plain chessboard. The tag is a square between four inner corners, black or white; it has no code, and its id
    /// is its place on the board ([`crate::chessboard_id`]).
    Chessboard,
}

/// Code words and layout of a family. Module (0, 0) is the top left module of the border of the upright tag.
#[derive(Debug)]
pub struct FamilyData {
    /// Code word of each id; bit `bits.len() - 1` (the highest) stands at `bits[0]`; a set bit is white.
    pub codes: &'static [u64],
    /// Module (x right, y down) of each bit; may be negative or beyond the border where data lie outside it.
    pub bits: &'static [(i8, i8)],
    /// Edge of the whole printed tag, in modules.
    pub total_width: u8,
    /// Edge of the square whose corners are reported, in modules.
    pub border_width: u8,
    /// Colour of the square's ring.
    pub border: BorderColour,
    /// Least number of bits in which two different tags (under any rotation) differ.
    pub min_hamming: u8,
    /// The board that the family's tags are part of, where it is for one.
    pub board: Option<Board>,
}

impl FamilyData {
    /// Modules between the edge of the printed tag and the border.
    pub const fn margin(&self) -> i8 {
        ((self.total_width - self.border_width) / 2) as i8
    }

    /// Whether its tags are recognised by codes, each by itself.
    pub const fn has_codes(&self) -> bool {
        !self.bits.is_empty()
    }

    /// The same tags as the squares of a ChArUco board.
    pub(crate) const fn on_charuco(self) -> Self {
        Self {
            board: Some(Board::Charuco),
            ..self
        }
    }
}

/// Owns what [`FamilyData`] borrows.
pub(crate) struct Table<const CODES: usize, const BITS: usize> {
    codes: [u64; CODES],
    bits: [(i8, i8); BITS],
    total_width: u8,
    border_width: u8,
    border: BorderColour,
    min_hamming: u8,
    board: Option<Board>,
}

#[cfg(target_family = "wasm")]
impl Table<0, 0> {
    /// Of a family whose words are left out.
    pub(crate) const EMPTY: Self = Self {
        codes: [],
        bits: [],
        total_width: 1,
        border_width: 1,
        border: BorderColour::Black,
        min_hamming: 1,
        board: None,
    };
}

impl<const CODES: usize, const BITS: usize> Table<CODES, BITS> {
    pub(crate) const fn data(&'static self) -> FamilyData {
        FamilyData {
            codes: &self.codes,
            bits: &self.bits,
            total_width: self.total_width,
            border_width: self.border_width,
            border: self.border,
            min_hamming: self.min_hamming,
            board: self.board,
        }
    }
}

impl<const CODES: usize, const BITS: usize> Table<CODES, BITS> {
    /// The first `n` code words, which have a greater distance than all.
    pub(crate) const fn first(&'static self, n: usize, min_hamming: u8) -> FamilyData {
        let whole = self.data();
        FamilyData {
            codes: whole.codes.split_at(n).0,
            min_hamming,
            ..whole
        }
    }
}

pub(crate) const fn parse<const CODES: usize, const BITS: usize>(
    file: &[u8],
) -> Table<CODES, BITS> {
    let mut words = Tokens { file, at: 0 };
    let mut table: Table<CODES, BITS> = without_codes(&mut words);
    let mut i = 0;
    while i < CODES {
        table.codes[i] = words.hexadecimal();
        i += 1;
    }
    assert!(words.next().is_empty(), "words after the last code");
    table
}

/// Reads a family whose code words are in a file of their own.
#[cfg(any(test, not(target_family = "wasm")))]
pub(crate) const fn parse_packed<const CODES: usize, const BITS: usize>(
    file: &[u8],
    mut packed: &[u8],
) -> Table<CODES, BITS> {
    let mut words = Tokens { file, at: 0 };
    let mut table: Table<CODES, BITS> = without_codes(&mut words);
    words.keyword(b"packed");
    assert!(words.next().is_empty(), "words after the last");
    let mut i = 0;
    // Without a call a word: evaluated by the compiler, calls would take seconds of every build.
    while let [a, b, c, d, e, f, g, h, rest @ ..] = packed {
        let high = (*a as u64) << 56 | (*b as u64) << 48 | (*c as u64) << 40 | (*d as u64) << 32;
        let low = (*e as u64) << 24 | (*f as u64) << 16 | (*g as u64) << 8 | *h as u64;
        table.codes[i] = high | low;
        packed = rest;
        i += 1;
    }
    assert!(i == CODES && packed.is_empty(), "length of the code words");
    table
}

/// All up to the number of codes.
const fn without_codes<const CODES: usize, const BITS: usize>(
    words: &mut Tokens<'_>,
) -> Table<CODES, BITS> {
    let total_width = words.field(b"total-width") as u8;
    let border_width = words.field(b"border-width") as u8;
    words.keyword(b"border");
    let border = match words.next() {
        b"black" => BorderColour::Black,
        b"white" => BorderColour::White,
        _ => panic!("the border is black or white"),
    };
    let min_hamming = words.field(b"min-hamming") as u8;
    let board = match words.optional(b"board") {
        Some(b"aprilgrid") => Some(Board::Aprilgrid),
        Some(_) => panic!("the only board with a layout of its own is aprilgrid"),
        None => None,
    };

    assert!(words.field(b"bits") == BITS as i64, "number of bits");
    let mut bits = [(0, 0); BITS];
    let mut i = 0;
    while i < BITS {
        bits[i] = (words.decimal() as i8, words.decimal() as i8);
        i += 1;
    }

    assert!(words.field(b"codes") == CODES as i64, "number of codes");
    Table {
        codes: [0; CODES],
        bits,
        total_width,
        border_width,
        border,
        min_hamming,
        board,
    }
}

#[derive(Clone, Copy)]
struct Tokens<'a> {
    file: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    /// The next word; empty at the end of the file.
    const fn next(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let start = self.at;
        while self.at < self.file.len() && !self.file[self.at].is_ascii_whitespace() {
            self.at += 1;
        }
        self.file.split_at(start).1.split_at(self.at - start).0
    }

    const fn skip_blanks(&mut self) {
        let mut in_comment = false;
        while self.at < self.file.len() {
            match self.file[self.at] {
                b'#' => in_comment = true,
                b'\n' => in_comment = false,
                byte if !in_comment && !byte.is_ascii_whitespace() => return,
                _ => {}
            }
            self.at += 1;
        }
    }

    const fn keyword(&mut self, keyword: &[u8]) {
        assert!(
            is_same(self.next(), keyword),
            "another keyword was expected"
        );
    }

    /// The word after a keyword, if that is what comes next.
    const fn optional(&mut self, keyword: &[u8]) -> Option<&'a [u8]> {
        let before = *self;
        if is_same(self.next(), keyword) {
            return Some(self.next());
        }
        *self = before;
        None
    }

    const fn field(&mut self, keyword: &[u8]) -> i64 {
        self.keyword(keyword);
        self.decimal()
    }

    const fn decimal(&mut self) -> i64 {
        match self.next() {
            [b'-', digits @ ..] => -(number(digits, 10) as i64),
            digits => number(digits, 10) as i64,
        }
    }

    const fn hexadecimal(&mut self) -> u64 {
        number(self.next(), 16)
    }
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

const fn number(digits: &[u8], radix: u32) -> u64 {
    assert!(!digits.is_empty(), "a number was expected");
    let mut value = 0_u64;
    let mut i = 0;
    while i < digits.len() {
        match (digits[i] as char).to_digit(radix) {
            Some(digit) => value = value * radix as u64 + digit as u64,
            None => panic!("not a digit"),
        }
        i += 1;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &[u8] =
        b"# a comment\ntotal-width 5 border-width 3 border white\nmin-hamming 1 # more\n\
        bits 2\n1 1 -1 3\ncodes 1\n2\n";

    #[test]
    fn a_file_reads_as_written() {
        let table: Table<1, 2> = parse(SMALL);
        assert_eq!(
            (table.total_width, table.border_width, table.min_hamming),
            (5, 3, 1)
        );
        assert_eq!(
            (table.border, table.bits, table.codes),
            (BorderColour::White, [(1, 1), (-1, 3)], [2])
        );
        assert_eq!(table.board, None);
        let text = str::from_utf8(SMALL).unwrap();
        let on_board = text.replace("bits 2", "board aprilgrid\nbits 2");
        let table: Table<1, 2> = parse(on_board.as_bytes());
        assert_eq!(table.board, Some(Board::Aprilgrid));
    }

    #[test]
    fn packed_code_words_are_read_from_their_file() {
        let text = str::from_utf8(SMALL).unwrap();
        let layout = text.replace("codes 1\n2\n", "codes 2 packed\n");
        let words = [3_u64, 0x1_0000_0002].map(u64::to_be_bytes).concat();
        let table: Table<2, 2> = parse_packed(layout.as_bytes(), &words);
        assert_eq!(table.codes, [3, 0x1_0000_0002]);
    }

    #[test]
    #[should_panic(expected = "number of bits")]
    fn a_wrong_count_is_refused() {
        let _: Table<1, 3> = parse(SMALL);
    }

    #[test]
    #[should_panic(expected = "words after the last code")]
    fn surplus_words_are_refused() {
        let surplus = [SMALL, b"3"].concat();
        let _: Table<1, 2> = parse(&surplus);
    }
}
