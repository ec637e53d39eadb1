//! Memory and registers by their physical address.
//!
//! The kernel maps on-chip memory and registers strongly ordered through `/dev/mem`, so that every access must be
//! aligned to its own size; all go through volatile accesses here, and no slice of such memory exists. Reading it is
//! slow: images are copied out once, in order.

use crate::on_chip;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::ptr::NonNull;
use std::time::Duration;

/// Memory and registers by their physical address. Addresses are multiples of the size of an access; of copies,
/// multiples of 8.
pub trait PhysicalMemory {
    /// A register of 8 bits.
    ///
    /// # Errors
    /// As of all methods: an address that is not mapped or not aligned.
    fn read_byte(&self, address: u32) -> io::Result<u8>;

    /// Sets a register of 8 bits.
    ///
    /// # Errors
    /// As [`Self::read_byte`].
    fn write_byte(&mut self, address: u32, value: u8) -> io::Result<()>;

    /// A register or word of 32 bits.
    ///
    /// # Errors
    /// As [`Self::read_byte`].
    fn read_word(&self, address: u32) -> io::Result<u32>;

    /// Sets a register or word of 32 bits.
    ///
    /// # Errors
    /// As [`Self::read_byte`].
    fn write_word(&mut self, address: u32, value: u32) -> io::Result<()>;

    /// Copies memory from `address` on into `bytes`.
    ///
    /// # Errors
    /// As [`Self::read_byte`].
    fn copy_out(&self, address: u32, bytes: &mut [u8]) -> io::Result<()>;

    /// Copies `bytes` into memory from `address` on.
    ///
    /// # Errors
    /// As [`Self::read_byte`].
    fn copy_in(&mut self, address: u32, bytes: &[u8]) -> io::Result<()>;

    /// Waits while hardware settles.
    fn pause(&mut self, duration: Duration);
}

/// Ranges that are mapped: on-chip memory and the pages of the CSI-2 receiver, VIN and the clocks' standby registers.
const RANGES: [(u32, u32); 4] = [
    (on_chip::BASE, on_chip::SIZE),
    (0xe820_9000, 0x1000),
    (0xe803_f000, 0x1000),
    (0xfcfe_0000, 0x1000),
];

/// Where the kernel says which machine this is.
const COMPATIBLE: &str = "/proc/device-tree/compatible";
/// What it says of every board with this chip.
const RZA2M: &str = "renesas,r7s9210";
/// Where the kernel lists what occupies physical memory.
const IOMEM: &str = "/proc/iomem";

/// `/dev/mem` of an RZ/A2M.
#[derive(Debug)]
pub struct DevMem {
    mappings: Vec<Mapping>,
}

#[derive(Debug)]
struct Mapping {
    address: u32,
    length: u32,
    start: NonNull<u8>,
}

impl DevMem {
    /// Maps on-chip memory and the registers of the camera path.
    ///
    /// # Errors
    /// Another machine, on-chip memory that belongs to the kernel, a `/dev/mem` that cannot be opened or mapped.
    pub fn open() -> io::Result<Self> {
        refuse_other_machines(&std::fs::read(COMPATIBLE).unwrap_or_default())?;
        refuse_system_memory(&std::fs::read_to_string(IOMEM)?)?;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(libc::O_SYNC)
            .open("/dev/mem")?;
        let mappings = RANGES
            .iter()
            .map(|&(address, length)| Mapping::new(&file, address, length));
        Ok(Self {
            mappings: mappings.collect::<io::Result<_>>()?,
        })
    }

    /// Where `length` bytes from `address` on are mapped.
    fn locate(&self, address: u32, length: usize, alignment: usize) -> io::Result<NonNull<u8>> {
        let mapping = self.mappings.iter().find(|mapping| {
            let offset = address.wrapping_sub(mapping.address);
            offset < mapping.length && length <= (mapping.length - offset) as usize
        });
        match mapping {
            Some(mapping) if (address as usize).is_multiple_of(alignment) => {
                let offset = (address - mapping.address) as usize;
                // SAFETY: the offset lies within the mapping, which is one allocation of `mapping.length` bytes.
                Ok(unsafe { mapping.start.add(offset) })
            }
            _ => Err(out_of_reach(address, length)),
        }
    }
}

/// Anything may stand at these addresses on another machine. `compatible` holds its names, each ended by a zero.
fn refuse_other_machines(compatible: &[u8]) -> io::Result<()> {
    let mut names = compatible.split(|byte| *byte == 0);
    if names.any(|name| name == RZA2M.as_bytes()) {
        return Ok(());
    }
    let message = format!("this machine is no RZ/A2M: {COMPATIBLE} does not name {RZA2M}");
    Err(io::Error::new(io::ErrorKind::Unsupported, message))
}

/// Complains where the kernel uses on-chip memory as system memory, by the text of `/proc/iomem`: there is no room for
/// images then.
///
/// # Errors
/// Such an entry, or a listing without addresses, which is all that the kernel shows to anybody but root.
fn refuse_system_memory(iomem: &str) -> io::Result<()> {
    let last = on_chip::BASE + (on_chip::SIZE - 1);
    let range = |line: &str| {
        let (range, name) = line.split_once(" : ")?;
        let (first, last) = range.trim().split_once('-')?;
        let parse = |digits| u32::from_str_radix(digits, 16).ok();
        name.trim()
            .eq_ignore_ascii_case("system ram")
            .then_some((parse(first)?, parse(last)?))
    };
    for (from, to) in iomem.lines().filter_map(range) {
        if (from, to) == (0, 0) {
            let message = "the kernel hides its memory map; run as root";
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, message));
        }
        if from <= last && to >= on_chip::BASE {
            let message = format!(
                "the kernel uses on-chip memory ({from:#x} to {to:#x}); choose HyperRAM or SDRAM \
                 as system memory in the device tree"
            );
            return Err(io::Error::new(io::ErrorKind::AddrInUse, message));
        }
    }
    Ok(())
}

pub(crate) fn out_of_reach(address: u32, length: usize) -> io::Error {
    let message = format!("{length} bytes at {address:#010x} are not mapped, or not aligned");
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

impl PhysicalMemory for DevMem {
    fn read_byte(&self, address: u32) -> io::Result<u8> {
        let at = self.locate(address, 1, 1)?;
        // SAFETY: `locate` gives a mapped byte.
        Ok(unsafe { at.read_volatile() })
    }

    fn write_byte(&mut self, address: u32, value: u8) -> io::Result<()> {
        let at = self.locate(address, 1, 1)?;
        // SAFETY: as above; the mapping is writable.
        unsafe { at.write_volatile(value) };
        Ok(())
    }

    fn read_word(&self, address: u32) -> io::Result<u32> {
        let at = self.locate(address, 4, 4)?.cast::<u32>();
        // SAFETY: `locate` gives four mapped bytes, aligned since mappings begin at pages.
        Ok(unsafe { at.read_volatile() })
    }

    fn write_word(&mut self, address: u32, value: u32) -> io::Result<()> {
        let at = self.locate(address, 4, 4)?.cast::<u32>();
        // SAFETY: as above; the mapping is writable.
        unsafe { at.write_volatile(value) };
        Ok(())
    }

    fn copy_out(&self, address: u32, bytes: &mut [u8]) -> io::Result<()> {
        let from = self
            .locate(address, bytes.len().next_multiple_of(8), 8)?
            .cast::<u64>();
        let (words, rest) = bytes.as_chunks_mut::<8>();
        let n_words = words.len();
        // SAFETY: `index` counts words of the located range, which is rounded up to whole ones and aligned to them.
        let word = |index: usize| unsafe { from.add(index).read_volatile() }.to_ne_bytes();
        for (index, out) in words.iter_mut().enumerate() {
            *out = word(index);
        }
        if !rest.is_empty() {
            rest.copy_from_slice(&word(n_words)[..rest.len()]);
        }
        Ok(())
    }

    fn copy_in(&mut self, address: u32, bytes: &[u8]) -> io::Result<()> {
        let to = self.locate(address, bytes.len(), 8)?;
        let (words, rest) = bytes.as_chunks::<8>();
        for (index, word) in words.iter().enumerate() {
            // SAFETY: whole words of the located range, which is writable and aligned to them.
            unsafe {
                to.cast::<u64>()
                    .add(index)
                    .write_volatile(u64::from_ne_bytes(*word))
            };
        }
        for (index, byte) in (words.len() * 8..).zip(rest) {
            // SAFETY: a byte of the located range.
            unsafe { to.add(index).write_volatile(*byte) };
        }
        Ok(())
    }

    fn pause(&mut self, duration: Duration) {
        std::thread::sleep(duration);
    }
}

impl Mapping {
    fn new(file: &File, address: u32, length: u32) -> io::Result<Self> {
        // SAFETY: a new mapping at an address of the kernel's choice, which the Mapping owns and unmaps once.
        let start = unsafe {
            libc::mmap64(
                std::ptr::null_mut(),
                length as usize,
                libc::PROT_READ | libc::PROT_WRITE,
                libc::MAP_SHARED,
                file.as_raw_fd(),
                address.into(),
            )
        };
        if start == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        let start = NonNull::new(start.cast())
            .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidData))?;
        Ok(Self {
            address,
            length,
            start,
        })
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the very mapping that `new` made; no pointer into it outlives a method of DevMem.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.length as usize) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_in_on_chip_memory_is_refused() {
        let hyper = "20000000-23ffffff : 20000000.qspi\n\
            40000000-407fffff : System RAM\n  40008000-4003d3ab : Kernel data\n";
        assert!(refuse_system_memory(hyper).is_ok());
        let on_chip = "80000000-803fffff : System RAM\n";
        let refusal = refuse_system_memory(on_chip).unwrap_err().to_string();
        assert!(refusal.contains("HyperRAM"), "{refusal}");
        let hidden = "00000000-00000000 : System RAM\n";
        assert!(
            refuse_system_memory(hidden)
                .unwrap_err()
                .to_string()
                .contains("root")
        );
        assert!(refuse_system_memory("no listing").is_ok());
    }

    #[test]
    fn other_machines_are_refused() {
        assert!(refuse_other_machines(b"renesas,rza2mevb\0renesas,r7s9210\0").is_ok());
        assert!(refuse_other_machines(b"raspberrypi,4-model-b\0brcm,bcm2711\0").is_err());
        assert!(refuse_other_machines(b"").is_err());
    }

    /// A file in place of `/dev/mem`: the mapping's arithmetic is the same.
    #[test]
    fn copies_keep_every_byte_and_stay_inside() {
        let path = std::env::temp_dir().join(format!("sextant-rza2m-{}", std::process::id()));
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&path)
            .unwrap();
        std::fs::remove_file(&path).unwrap();
        file.set_len(4096).unwrap();
        let mut mapping = Mapping::new(&file, 0, 4096).unwrap();
        mapping.address = 0x8000_0000;
        let mut memory = DevMem {
            mappings: vec![mapping],
        };
        for length in [0, 1, 7, 8, 9, 31, 64] {
            let bytes: Vec<u8> = (1..=length).collect();
            memory.copy_in(0x8000_0008, &bytes).unwrap();
            let mut back = vec![0; bytes.len()];
            memory.copy_out(0x8000_0008, &mut back).unwrap();
            assert_eq!(back, bytes);
        }
        assert_eq!(memory.read_byte(0x8000_0008 + 64).unwrap(), 0);
        memory.write_word(0x8000_0ffc, 7).unwrap();
        assert_eq!(memory.read_word(0x8000_0ffc).unwrap(), 7);
        memory.write_byte(0x8000_0fff, 1).unwrap();
        assert_eq!(memory.read_byte(0x8000_0fff).unwrap(), 1);
        for (address, length) in [
            (0x8000_0004, 8),
            (0x8000_0ff8, 16),
            (0x7fff_fff8, 8),
            (0x8000_1000, 8),
        ] {
            assert!(
                memory.copy_out(address, &mut vec![0; length]).is_err(),
                "{address:#x}"
            );
            assert!(
                memory.copy_in(address, &vec![0; length]).is_err(),
                "{address:#x}"
            );
        }
        assert!(memory.read_word(0x8000_0ffe).is_err());
    }
}
