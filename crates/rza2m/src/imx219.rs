//! The Sony IMX219 (Raspberry Pi Camera Module 2) with 2x2 binning, as raw images of 8 bits on two lanes.
//!
//! Sources: the register table of renesas-rz/rza2m_drp (`DRP_sample/camera_mipi.c`), which the vendor's demonstration
//! writes; the names, exposure and gain from Linux (`drivers/media/i2c/imx219.c`). One deviation: the demonstration
//! turns the image by 180 degrees (orientation 3), which by Linux' driver makes its Bayer order BGGR; here the
//! orientation is 0, whose order is RGGB, as circuits need it.

use crate::SensorBus;
use std::io;

/// What the registers 0x0000 and 0x0001 of an IMX219 say.
const MODEL: u16 = 0x0219;
const MODEL_ID: u16 = 0x0000;

const MODE_SELECT: u16 = 0x0100;
const SOFTWARE_RESET: u16 = 0x0103;
const ANALOG_GAIN: u16 = 0x0157;
const COARSE_INTEGRATION_TIME: u16 = 0x015a;
const FRAME_LENGTH: u16 = 0x0160;

/// Lines of a frame in the table below, blanking included.
pub(crate) const SHORTEST_FRAME: u16 = 0x0438;

/// Lines of a frame that cannot be exposed.
const EXPOSURE_MARGIN: u16 = 4;

/// Registers in the order in which they are written.
const SET_UP: [(u16, u8); 36] = [
    (0x0114, 0x01), // CSI_LANE_MODE: two lanes
    (0x0128, 0x01), // DPHY_CTRL: timing by registers
    (0x012a, 0x0c), // EXCK_FREQ, MHz
    (0x012b, 0x00),
    (0x0160, 0x04), // FRM_LENGTH_A, lines
    (0x0161, 0x38),
    (0x0164, 0x02), // X_ADD_STA_A
    (0x0165, 0xa8),
    (0x0166, 0x0a), // X_ADD_END_A
    (0x0167, 0x27),
    (0x0168, 0x02), // Y_ADD_STA_A
    (0x0169, 0xb4),
    (0x016a, 0x06), // Y_ADD_END_A
    (0x016b, 0xeb),
    (0x016c, 0x05), // X_OUTPUT_SIZE
    (0x016d, 0x00),
    (0x016e, 0x04), // Y_OUTPUT_SIZE
    (0x016f, 0x38),
    (0x018c, 0x08), // CSI_DATA_FORMAT_A: RAW8
    (0x018d, 0x08),
    (0x0172, 0x00), // IMG_ORIENTATION_A
    (0x0174, 0x01), // BINNING_MODE_H_A: by 2
    (0x0175, 0x01), // BINNING_MODE_V_A: by 2
    (0x0176, 0x01), // BINNING_CAL_MODE_H_A
    (0x0177, 0x01), // BINNING_CAL_MODE_V_A
    (0x0301, 0x05), // VTPXCK_DIV
    (0x0303, 0x01), // VTSYCK_DIV
    (0x0304, 0x02), // PREPLLCK_VT_DIV
    (0x0305, 0x02), // PREPLLCK_OP_DIV
    (0x0306, 0x00), // PLL_VT_MPY
    (0x0307, 0x3a),
    (0x0309, 0x08), // OPPXCK_DIV
    (0x030b, 0x01), // OPSYCK_DIV
    (0x030c, 0x00), // PLL_OP_MPY
    (0x030d, 0x2a),
    (0x0100, 0x00), // MODE_SELECT: standby
];

/// The sensor behind its bus.
#[derive(Debug)]
pub(crate) struct Imx219<B> {
    bus: B,
}

/// What stands where the sensor should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Identity {
    Imx219,
    Other(u16),
}

impl<B: SensorBus> Imx219<B> {
    pub(crate) fn new(bus: B) -> Self {
        Self { bus }
    }

    pub(crate) fn identify(&mut self) -> io::Result<Identity> {
        let model = u16::from_be_bytes([self.bus.read(MODEL_ID)?, self.bus.read(MODEL_ID + 1)?]);
        Ok(if model == MODEL {
            Identity::Imx219
        } else {
            Identity::Other(model)
        })
    }

    /// Standby and reset; the sensor then needs 2 ms.
    pub(crate) fn reset(&mut self) -> io::Result<()> {
        self.stop()?;
        self.bus.write(SOFTWARE_RESET, 1)
    }

    /// Writes the table. The sensor stays in standby.
    pub(crate) fn set_up(&mut self) -> io::Result<()> {
        SET_UP
            .iter()
            .try_for_each(|&(register, value)| self.bus.write(register, value))
    }

    pub(crate) fn start(&mut self) -> io::Result<()> {
        self.bus.write(MODE_SELECT, 1)
    }

    pub(crate) fn stop(&mut self) -> io::Result<()> {
        self.bus.write(MODE_SELECT, 0)
    }

    pub(crate) fn set_frame_length(&mut self, lines: u16) -> io::Result<()> {
        self.write_pair(FRAME_LENGTH, lines)
    }

    pub(crate) fn set_exposure(&mut self, lines: u16) -> io::Result<()> {
        self.write_pair(COARSE_INTEGRATION_TIME, lines)
    }

    /// Analog gain, 1 to 10.66: 256 / (256 - register).
    pub(crate) fn set_gain(&mut self, gain: f64) -> io::Result<()> {
        let register = (256.0 - 256.0 / gain).round().clamp(0.0, 232.0);
        self.bus.write(ANALOG_GAIN, register as u8)
    }

    fn write_pair(&mut self, register: u16, value: u16) -> io::Result<()> {
        let [high, low] = value.to_be_bytes();
        self.bus.write(register, high)?;
        self.bus.write(register + 1, low)
    }
}

/// The longest exposure within a frame, lines.
pub(crate) fn longest_exposure(frame_length: u16) -> u16 {
    frame_length.saturating_sub(EXPOSURE_MARGIN).max(1)
}
