//! The squares of a plain chessboard as a family: they have no codes, and an id is a place on the board.

use crate::table::{Board, BorderColour, FamilyData};

/// Most squares between inner corners in a row or a column.
pub const CHESSBOARD_SQUARES: u16 = 64;

const IDS: usize = CHESSBOARD_SQUARES as usize * CHESSBOARD_SQUARES as usize;

/// Its code words only count the ids.
pub(crate) const CHESSBOARD: FamilyData = FamilyData {
    codes: &[0; IDS],
    bits: &[],
    total_width: 3,
    border_width: 1,
    border: BorderColour::Black,
    min_hamming: 0,
    board: Some(Board::Chessboard),
};

/// Id of a square between inner corners, by the column and row of its upper left corner.
pub fn chessboard_id([column, row]: [u16; 2]) -> u32 {
    u32::from(row) * u32::from(CHESSBOARD_SQUARES) + u32::from(column)
}

/// Column and row of the upper left corner of a square.
pub fn chessboard_place(id: u32) -> [u16; 2] {
    let row = id / u32::from(CHESSBOARD_SQUARES);
    [
        (id % u32::from(CHESSBOARD_SQUARES)) as u16,
        u16::try_from(row).unwrap_or(u16::MAX),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_a_place_on_the_board() {
        for place in [[0, 0], [63, 0], [7, 4], [63, 63]] {
            let id = chessboard_id(place);
            assert_eq!(chessboard_place(id), place);
            assert!((id as usize) < CHESSBOARD.codes.len());
        }
        assert_eq!(chessboard_place(u32::MAX), [63, u16::MAX]);
    }
}
