//! The CSI-2 receiver and the video input module (VIN): their registers and what is written to them.
//!
//! Sources: renesas-rz/rza2m_drp, `DRP_sample/{mipi.c,mipi.h,main.c}`, for addresses, values and order; Linux'
//! `drivers/media/platform/renesas/rcar-vin/rcar-dma.c`, whose module is of the same family, for the stride of raw
//! images (pixels / 2, a multiple of 16) and the meaning of the frame buffer status. The demonstration's window is
//! 800x480; ours lies in its middle.

use crate::PhysicalMemory;
use std::io;
use std::time::Duration;

/// Greatest width and height: the window that the demonstration is known to receive, columns 100 to 899 and rows 24
/// to 503.
pub(crate) const LARGEST: [u16; 2] = [800, 480];
const WINDOW_START: [u16; 2] = [100, 24];
/// Widths are multiples of this, for the stride.
pub(crate) const WIDTH_STEP: u16 = 32;

const CSI2: u32 = 0xe820_9000;
const VIN: u32 = 0xe803_f000;
/// Standby control registers 6 and 7: a module runs while its bit is 0.
const STBCR6: u32 = 0xfcfe_042c;
const STBCR7: u32 = 0xfcfe_0430;
const VIN_STANDBY: u8 = 1 << 6;
const CSI2_STANDBY: u8 = 1 << 5;

const CSI2_TREF: u32 = CSI2;
const CSI2_SRST: u32 = CSI2 + 0x04;
const CSI2_PHYCNT: u32 = CSI2 + 0x08;
const CSI2_CHKSUM: u32 = CSI2 + 0x0c;
const CSI2_VCDT: u32 = CSI2 + 0x10;
const CSI2_FRDT: u32 = CSI2 + 0x18;
const CSI2_FLD: u32 = CSI2 + 0x1c;
const CSI2_INTCLOSE: u32 = CSI2 + 0x34;
const CSI2_INTSTATE: u32 = CSI2 + 0x38;
const CSI2_LINKCNT: u32 = CSI2 + 0x48;
const CSI2_PHYTIM1: u32 = CSI2 + 0x264;
const CSI2_PHYTIM2: u32 = CSI2 + 0x268;
const CSI2_PHYTIM3: u32 = CSI2 + 0x26c;

const VNMC: u32 = VIN;
const VNMS: u32 = VIN + 0x04;
const VNFC: u32 = VIN + 0x08;
const VNSLPRC: u32 = VIN + 0x0c;
const VNELPRC: u32 = VIN + 0x10;
const VNSPPRC: u32 = VIN + 0x14;
const VNEPPRC: u32 = VIN + 0x18;
const VNCSI_IFMD: u32 = VIN + 0x20;
const VNIS: u32 = VIN + 0x2c;
const VNMB: [u32; 3] = [VIN + 0x30, VIN + 0x34, VIN + 0x38];
const VNIE: u32 = VIN + 0x40;
const VNINTS: u32 = VIN + 0x44;
const VNDMR: u32 = VIN + 0x58;
const VNDMR2: u32 = VIN + 0x5c;
const VNUVAOF: u32 = VIN + 0x60;
const VNUDS_CTRL: u32 = VIN + 0x80;
const VNUDS_SCALE: u32 = VIN + 0x84;
const VNUDS_PASS_BWIDTH: u32 = VIN + 0x90;
const VNUDS_CLIP_SIZE: u32 = VIN + 0xa4;

/// VNMC: values unclipped, RAW8, colour space conversion bypassed; and the module enabled.
const VNMC_RAW8: u32 = 0x3004_000a;
const VNMC_ENABLED: u32 = 1;
const VNFC_CONTINUOUS: u32 = 1 << 1;
const VNMS_CAPTURING: u32 = 1;
const FRAME_INTERRUPT: u32 = 1 << 4;

/// The receiver settles in microseconds; the demonstration counts to some milliseconds.
const RESET_PAUSE: Duration = Duration::from_millis(5);
const PHY_PAUSE: Duration = Duration::from_millis(25);

/// Receiver, in the order in which it is written; pauses stand between the parts.
const CSI2_RESET: [(u32, u32); 2] = [(CSI2_TREF, 1), (CSI2_SRST, 1)];
const CSI2_SET_UP: [(u32, u32); 10] = [
    (CSI2_SRST, 0),
    (CSI2_PHYTIM1, 0x0000_3b5f),
    (CSI2_PHYTIM2, 0x0008_1e0f),
    (CSI2_PHYTIM3, 0x0000_1912),
    (CSI2_FLD, 0),
    (CSI2_CHKSUM, 3),         // error correction and checksums
    (CSI2_VCDT, 0x011e_802a), // channel 0 takes data type 0x2a, RAW8
    (CSI2_FRDT, 0x0001_0000),
    (CSI2_LINKCNT, 0x8200_0000),
    (CSI2_PHYCNT, 0x0003_0013), // clock and two lanes
];
const CSI2_ACKNOWLEDGE: (u32, u32) = (CSI2_INTSTATE, 0xc0);

/// Receiver and VIN to a standstill.
const STOP: [(u32, u32); 4] = [
    (CSI2_INTCLOSE, 0x181f_fcdd),
    (VNIE, 0),
    (VNFC, 0),
    (VNMC, VNMC_RAW8),
];
const CSI2_OFF: [(u32, u32); 3] = [(CSI2_PHYCNT, 0), (CSI2_SRST, 1), (CSI2_SRST, 0)];

/// Lets the clocks of both modules run, without which their registers must not be touched.
pub(crate) fn enable_clocks(memory: &mut impl PhysicalMemory) -> io::Result<()> {
    for (register, standby) in [(STBCR6, VIN_STANDBY), (STBCR7, CSI2_STANDBY)] {
        let value = memory.read_byte(register)?;
        memory.write_byte(register, value & !standby)?;
        // Read back, so that the write has arrived before the module is touched.
        memory.read_byte(register)?;
    }
    Ok(())
}

/// Stops both modules, whoever left them running.
pub(crate) fn stop(memory: &mut impl PhysicalMemory) -> io::Result<()> {
    write_all(memory, &STOP)?;
    write_all(memory, &CSI2_OFF)
}

/// Whether VIN is writing an image.
pub(crate) fn is_capturing(memory: &impl PhysicalMemory) -> io::Result<bool> {
    Ok(memory.read_word(VNMS)? & VNMS_CAPTURING != 0)
}

/// Resets the receiver and sets it up.
pub(crate) fn start_receiver(memory: &mut impl PhysicalMemory) -> io::Result<()> {
    write_all(memory, &CSI2_RESET)?;
    memory.pause(RESET_PAUSE);
    write_all(memory, &CSI2_SET_UP)?;
    memory.pause(PHY_PAUSE);
    write_all(memory, &[CSI2_ACKNOWLEDGE])
}

/// Lets VIN fill three buffers in turn with images of a size.
pub(crate) fn start_capture(
    memory: &mut impl PhysicalMemory,
    buffers: [u32; 3],
    size: [u16; 2],
) -> io::Result<()> {
    for (register, buffer) in VNMB.into_iter().zip(buffers) {
        memory.write_word(register, buffer)?;
    }
    write_all(memory, &set_up(size))?;
    memory.write_word(VNFC, VNFC_CONTINUOUS)
}

/// VIN for images of a size from the middle of the window, beginning at even columns and rows, which keeps the Bayer
/// order.
fn set_up(size: [u16; 2]) -> [(u32, u32); 17] {
    let margin = |i: usize| LARGEST[i] - size[i].min(LARGEST[i]);
    let start = [0, 1].map(|i| WINDOW_START[i] + (margin(i) / 4) * 2);
    let last = [0, 1].map(|i| u32::from(start[i] + size[i]) - 1);
    let [column, row] = start.map(u32::from);
    [
        (VNMC, VNMC_RAW8),
        (VNCSI_IFMD, 0x0200_0000),
        (VNDMR2, 0x0802_1000),
        (VNIS, u32::from(size[0]) / 2),
        (VNSLPRC, row),
        (VNELPRC, last[1]),
        (VNSPPRC, column),
        (VNEPPRC, last[0]),
        (VNUDS_CTRL, 0x4000_0000),
        (VNUDS_SCALE, 0),
        (VNUDS_PASS_BWIDTH, 0x0040_0040),
        (VNUDS_CLIP_SIZE, 0),
        (VNUVAOF, 0),
        (VNINTS, FRAME_INTERRUPT),
        // VIN's own enable: its interrupt is not routed anywhere while the kernel has no driver for it.
        (VNIE, FRAME_INTERRUPT),
        (VNDMR, 0),
        (VNMC, VNMC_RAW8 | VNMC_ENABLED),
    ]
}

/// Which buffer holds the newest whole image; none before the first.
pub(crate) fn newest_buffer(memory: &impl PhysicalMemory) -> io::Result<Option<usize>> {
    let buffer = (memory.read_word(VNMS)? >> 3 & 3) as usize;
    Ok((buffer < 3).then_some(buffer))
}

fn write_all(memory: &mut impl PhysicalMemory, program: &[(u32, u32)]) -> io::Result<()> {
    program
        .iter()
        .try_for_each(|&(register, value)| memory.write_word(register, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(size: [u16; 2], register: u32) -> u32 {
        let program = set_up(size);
        program
            .into_iter()
            .find(|(at, _)| *at == register)
            .unwrap()
            .1
    }

    #[test]
    fn the_demonstrations_window_is_written_as_it_writes_it() {
        let window = [VNSPPRC, VNEPPRC, VNSLPRC, VNELPRC, VNIS].map(|at| value([800, 480], at));
        assert_eq!(window, [0x64, 0x383, 0x18, 0x1f7, 0x190]);
    }

    #[test]
    fn smaller_windows_lie_in_its_middle_and_begin_with_red() {
        assert_eq!(
            [VNSPPRC, VNEPPRC, VNIS].map(|at| value([640, 480], at)),
            [180, 819, 320]
        );
        for size in [[640, 478], [608, 120], [32, 16]] {
            assert!(
                value(size, VNSPPRC).is_multiple_of(2) && value(size, VNSLPRC).is_multiple_of(2)
            );
            assert_eq!(
                value(size, VNEPPRC) - value(size, VNSPPRC) + 1,
                size[0].into()
            );
            assert_eq!(
                value(size, VNELPRC) - value(size, VNSLPRC) + 1,
                size[1].into()
            );
        }
    }
}
