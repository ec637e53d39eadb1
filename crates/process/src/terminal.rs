//! Size of the terminal.

use std::os::fd::AsRawFd;

/// Columns and rows of the terminal on standard output; `None` if it is no terminal or its size is unknown.
pub fn size() -> Option<(u16, u16)> {
    let mut size = libc::winsize {
        ws_row: 0,
        ws_col: 0,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    // SAFETY: `size` is valid and writable for the whole call, which is what TIOCGWINSZ fills.
    let failed = unsafe {
        libc::ioctl(
            std::io::stdout().as_raw_fd(),
            libc::TIOCGWINSZ,
            &raw mut size,
        )
    };
    (failed == 0 && size.ws_col > 0 && size.ws_row > 0).then_some((size.ws_col, size.ws_row))
}
