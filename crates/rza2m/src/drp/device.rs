//! The driver's file.

use super::requests::Record;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::path::Path;

/// The driver, at the level of bytes.
pub trait DrpDevice {
    /// Hands a request and its record to the driver, which answers in the record.
    ///
    /// # Errors
    /// The call itself fails. A request that fails answers with a negative number in its record instead, and one that
    /// the driver does not know succeeds and leaves its record as it was.
    fn request(&mut self, number: u32, record: &mut Record) -> io::Result<()>;
}

/// The driver's device file, `/dev/drp`, held by one process at a time.
#[derive(Debug)]
pub struct DrpFile {
    file: File,
}

impl DrpFile {
    /// Opens the driver and locks its file: the driver itself lets everybody in, and all share one state.
    ///
    /// # Errors
    /// No driver, not ours to open, or locked by another process.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        file.try_lock()?;
        Ok(Self { file })
    }
}

impl DrpDevice for DrpFile {
    fn request(&mut self, number: u32, record: &mut Record) -> io::Result<()> {
        // SAFETY: the driver reads and writes at most the 256 bytes of a record, which is valid and writable for the
        // whole call; the only request that follows a pointer in it, GETINFO, is never made.
        let result =
            unsafe { libc::ioctl(self.file.as_raw_fd(), number as _, record.as_mut_ptr()) };
        if result == -1 {
            return Err(io::Error::last_os_error());
        }
        Ok(())
    }
}
