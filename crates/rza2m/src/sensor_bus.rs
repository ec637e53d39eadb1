//! The sensor's registers, over I2C.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::path::Path;

/// 7-bit address of the IMX219.
pub(crate) const ADDRESS: u16 = 0x10;

/// Registers of a camera sensor: 16-bit addresses, 8-bit values.
pub trait SensorBus {
    /// The value of a register.
    ///
    /// # Errors
    /// A sensor that does not answer.
    fn read(&mut self, register: u16) -> io::Result<u8>;

    /// Sets a register.
    ///
    /// # Errors
    /// A sensor that does not answer.
    fn write(&mut self, register: u16, value: u8) -> io::Result<()>;
}

/// A sensor on an I2C bus of this host.
#[derive(Debug)]
pub struct I2cBus {
    file: File,
    address: u16,
}

/// `I2C_RDWR`, `struct i2c_msg` and `struct i2c_rdwr_ioctl_data` of `<linux/i2c-dev.h>` and `<linux/i2c.h>`.
const I2C_RDWR: libc::c_ulong = 0x0707;
const READ: u16 = 1;

#[repr(C)]
struct Message {
    address: u16,
    flags: u16,
    length: u16,
    bytes: *mut u8,
}

#[repr(C)]
struct Transfer {
    messages: *mut Message,
    n_messages: u32,
}

impl I2cBus {
    /// Opens the bus for the camera's sensor. The bus is locked: two programs would set one sensor otherwise.
    ///
    /// # Errors
    /// A bus that is not there, not ours to open, or locked.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        file.try_lock()?;
        Ok(Self {
            file,
            address: ADDRESS,
        })
    }

    fn transfer(&mut self, buffers: &mut [(u16, &mut [u8])]) -> io::Result<()> {
        let address = self.address;
        let mut messages: Vec<Message> = buffers
            .iter_mut()
            .map(|(flags, bytes)| Message {
                address,
                flags: *flags,
                // A register's address and value: three bytes at most.
                length: bytes.len() as u16,
                bytes: bytes.as_mut_ptr(),
            })
            .collect();
        let mut transfer = Transfer {
            messages: messages.as_mut_ptr(),
            n_messages: messages.len() as u32,
        };
        // SAFETY: the structures have the kernel's layout; `messages` and the buffers that they point to are valid and
        // writable for the whole call, with the lengths given.
        let result =
            unsafe { libc::ioctl(self.file.as_raw_fd(), I2C_RDWR as _, &raw mut transfer) };
        if result == -1 {
            return Err(io::Error::last_os_error());
        }
        Ok(())
    }
}

impl SensorBus for I2cBus {
    fn read(&mut self, register: u16) -> io::Result<u8> {
        let (mut address, mut value) = (register.to_be_bytes(), [0]);
        self.transfer(&mut [(0, &mut address), (READ, &mut value)])?;
        Ok(value[0])
    }

    fn write(&mut self, register: u16, value: u8) -> io::Result<()> {
        let [high, low] = register.to_be_bytes();
        self.transfer(&mut [(0, &mut [high, low, value])])
    }
}
