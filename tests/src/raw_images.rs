//! Grey images in the pixel formats of the kernel's driver vivid, as a camera would deliver them.

/// Every format of vivid (Linux 6.1) that camera nodes read, by its code.
pub const RAW_FORMATS: &[&str] = &[
    "GREY", "Y10", "Y12", "Y16", "NV12", "NV21", "YU12", "YV12", "NV16", "NV61", "NV24", "NV42",
    "422P", "YUYV", "YVYU", "UYVY", "VYUY", "RGGB", "GRBG", "GBRG", "BA81", "RG10", "BA10", "GB10",
    "BG10", "RG12", "BA12", "GB12", "BG12", "RG16", "GR16", "GB16", "BYR2", "RGB3", "BGR3", "XR24",
    "AR24", "BGR4", "XB24", "AB24", "BX24", "BA24", "RGB4",
];

/// Chroma without colour.
const NEUTRAL: u8 = 128;

/// An image with an even number of pixels in one of [`RAW_FORMATS`].
///
/// # Panics
/// For any other format.
#[must_use]
pub fn raw_image(format: &str, grey: &[u8]) -> Vec<u8> {
    let pixels = grey.len();
    match format {
        "GREY" | "RGGB" | "GRBG" | "GBRG" | "BA81" => grey.to_vec(),
        "Y10" | "RG10" | "BA10" | "GB10" | "BG10" => words(grey, 10),
        "Y12" | "RG12" | "BA12" | "GB12" | "BG12" => words(grey, 12),
        "Y16" | "RG16" | "GR16" | "GB16" | "BYR2" => words(grey, 16),
        "NV12" | "NV21" | "YU12" | "YV12" => with_chroma(grey, pixels / 2),
        "NV16" | "NV61" | "422P" => with_chroma(grey, pixels),
        "NV24" | "NV42" => with_chroma(grey, 2 * pixels),
        "YUYV" | "YVYU" => each(grey, |y| vec![y, NEUTRAL]),
        "UYVY" | "VYUY" => each(grey, |y| vec![NEUTRAL, y]),
        "RGB3" | "BGR3" => each(grey, |y| vec![y; 3]),
        "XR24" | "AR24" | "BGR4" | "XB24" | "AB24" | "BX24" | "BA24" | "RGB4" => {
            each(grey, |y| vec![y; 4])
        }
        _ => panic!("{format}: no such format"),
    }
}

fn each(grey: &[u8], bytes: impl Fn(u8) -> Vec<u8>) -> Vec<u8> {
    grey.iter().flat_map(|y| bytes(*y)).collect()
}

/// Little-endian words with so many valid bits.
fn words(grey: &[u8], bits: u32) -> Vec<u8> {
    each(grey, |y| {
        (u16::from(y) << (bits - 8)).to_le_bytes().to_vec()
    })
}

fn with_chroma(grey: &[u8], bytes: usize) -> Vec<u8> {
    [grey, &vec![NEUTRAL; bytes]].concat()
}
