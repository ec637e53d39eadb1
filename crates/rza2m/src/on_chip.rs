//! Where images and circuit data lie in the 4 MB of on-chip memory.
//!
//! The camera writes raw images there and circuits see it directly; external RAM is the kernel's. Source of the address
//! and of the use that the vendor's demonstration makes of it: renesas-rz/rza2m_drp, `DRP_sample/main.c`.

/// Physical address of on-chip memory.
pub(crate) const BASE: u32 = 0x8000_0000;
/// Its size in bytes.
pub(crate) const SIZE: u32 = 4 << 20;

/// VIN takes buffers at multiples of 128 bytes (`DRP_sample/mipi.c`), LOAD circuit data at multiples of 32; the caches'
/// lines are shorter.
const ALIGNMENT: u32 = 128;

/// Physical addresses of everything in on-chip memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OnChipLayout {
    /// Raw images, which VIN fills in turn.
    pub raw: [u32; 3],
    /// The input of self-tests, which run while the camera does.
    pub test_input: u32,
    /// Outputs of circuits: each reads what the one before it wrote.
    pub outputs: [u32; 2],
    /// Data of each circuit.
    pub circuit_data: Vec<u32>,
}

/// Images and circuit data exceed on-chip memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "six images and the circuits' data take {needed} of {SIZE} bytes of on-chip memory; choose a \
     smaller resolution or fewer circuits"
)]
pub struct LayoutError {
    /// Bytes needed.
    pub needed: u64,
}

impl OnChipLayout {
    /// Places images of `image_bytes` and circuit data of the sizes given, in bytes.
    ///
    /// # Errors
    /// More than on-chip memory holds.
    pub fn plan(image_bytes: usize, circuit_data: &[usize]) -> Result<Self, LayoutError> {
        let mut used = 0_u64;
        let mut take = |bytes: usize| {
            let address = BASE.wrapping_add(used as u32);
            let rounded = (bytes as u64).checked_next_multiple_of(ALIGNMENT.into());
            used = used.saturating_add(rounded.unwrap_or(u64::MAX));
            address
        };
        let layout = Self {
            raw: [(); 3].map(|()| take(image_bytes)),
            test_input: take(image_bytes),
            outputs: [(); 2].map(|()| take(image_bytes)),
            circuit_data: circuit_data.iter().map(|bytes| take(*bytes)).collect(),
        };
        if used > SIZE.into() {
            return Err(LayoutError { needed: used });
        }
        Ok(layout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vga_and_two_circuits_fit() {
        let layout = OnChipLayout::plan(640 * 480, &[62_912, 57_536]).unwrap();
        let OnChipLayout {
            raw,
            test_input,
            outputs,
            circuit_data,
        } = &layout;
        let images = [&raw[..], &[*test_input], &outputs[..]].concat();
        assert_eq!(images.len(), 6);
        let last = circuit_data[1] + 57_536;
        assert!(last <= BASE + SIZE);
        let all = [&images[..], circuit_data].concat();
        assert!(all.is_sorted() && all.iter().all(|address| address.is_multiple_of(128)));
        assert!(
            all.windows(2)
                .take(6)
                .all(|pair| pair[1] - pair[0] >= 640 * 480)
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        assert!(OnChipLayout::plan(960 * 800, &[]).is_err());
        assert!(OnChipLayout::plan(usize::MAX, &[1]).is_err());
    }
}
