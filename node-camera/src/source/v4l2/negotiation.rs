//! Which format and size a camera gives images in: what it offers, what is chosen, and why nothing can be.

use super::device::{Api, Device, Format, Fraction, Intervals, Sizes};
use crate::config::V4l2Config;
use crate::source::pixel_formats::{Coding, FORMATS, PixelFormat};

/// More entries than any camera has, of each list: a driver that never says that it was the last is not followed
/// further.
const MOST_ENTRIES: u32 = 256;

/// Rates that are equal but for their rounding.
const RATE_TOLERANCE: f64 = 0.999;

/// A format with the sizes that the camera gives it in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Offer {
    pub(super) fourcc: [u8; 4],
    pub(super) sizes: Vec<Sizes>,
}

/// Everything that a camera offers, in its own order.
pub(super) fn offers(device: &impl Device, api: Api) -> Vec<Offer> {
    let formats = (0..MOST_ENTRIES).map_while(|n| device.nth_format(api, n).ok());
    let offer = |fourcc| Offer {
        fourcc,
        sizes: (0..MOST_ENTRIES)
            .map_while(|n| device.nth_size(fourcc, n).ok())
            .collect(),
    };
    formats.map(offer).collect()
}

/// The rates that a camera has for a format and size, images a second, the greatest first.
pub(super) fn rates_hz(device: &impl Device, fourcc: [u8; 4], size: [u32; 2]) -> Vec<f64> {
    let intervals = (0..MOST_ENTRIES).map_while(|n| device.nth_interval(fourcc, size, n).ok());
    let ends = intervals.flat_map(|intervals| match intervals {
        Intervals::One(one) => [Some(one), None],
        Intervals::From { least, greatest } => [Some(least), Some(greatest)],
    });
    let mut rates: Vec<f64> = ends.flatten().filter_map(Fraction::rate_hz).collect();
    rates.sort_by(|a, b| b.total_cmp(a));
    rates.dedup();
    rates
}

/// Sets the best format in exactly the size that is wished. Where a rate is wished, formats in which the camera reaches
/// it come first: over USB many cameras are slow in all formats but JPEG.
///
/// # Errors
/// What the camera offers instead, in words.
pub(super) fn negotiate(
    device: &impl Device,
    api: Api,
    config: &V4l2Config,
) -> Result<(Format, Coding), String> {
    let offers = offers(device, api);
    for format in candidates(device, &offers, config) {
        let Ok(set) = device.set_format(api, format.fourcc, config.resolution) else {
            continue;
        };
        if set.fourcc == format.fourcc && set.size == config.resolution {
            return Ok((set, format.coding));
        }
    }
    Err(refusal(&offers, config))
}

/// The formats to try, in their order. A camera that lists none is asked for each.
fn candidates(device: &impl Device, offers: &[Offer], config: &V4l2Config) -> Vec<PixelFormat> {
    let is_offered = |format: &PixelFormat| {
        offers.is_empty() || offers.iter().any(|offer| offer.fourcc == format.fourcc)
    };
    let is_wished = |format: &PixelFormat| match &config.format {
        Some(name) => PixelFormat::name(format.fourcc) == *name,
        None => true,
    };
    let mut candidates: Vec<PixelFormat> = FORMATS
        .iter()
        .copied()
        .filter(|format| is_offered(format) && is_wished(format))
        .collect();
    if let Some(rate_hz) = config.rate_hz {
        let is_slow = |format: &PixelFormat| {
            let fastest = rates_hz(device, format.fourcc, config.resolution);
            fastest
                .first()
                .is_some_and(|fastest| *fastest < rate_hz * RATE_TOLERANCE)
        };
        candidates.sort_by_cached_key(is_slow);
    }
    candidates
}

fn refusal(offers: &[Offer], config: &V4l2Config) -> String {
    let [width, height] = config.resolution;
    let wished = match &config.format {
        Some(format) => format!("no {width}x{height} image in {format}"),
        None => format!("no {width}x{height} image in a format that is known here"),
    };
    let readable = offers
        .iter()
        .filter(|offer| PixelFormat::from_fourcc(offer.fourcc).is_some());
    let readable: Vec<String> = readable.map(Offer::to_string).collect();
    if readable.is_empty() {
        let names = offers.iter().map(|offer| PixelFormat::name(offer.fourcc));
        let names: Vec<String> = names.collect();
        return match names.is_empty() {
            true => format!("{wished}, and it does not say what it has"),
            false => format!(
                "{wished}: it has {} only; take it through a program instead (kind = \"command\")",
                names.join(", ")
            ),
        };
    }
    format!(
        "{wished}; it has {}. Write one of these sizes as resolution{} into the file; `sextant \
         camera --probe` shows all with their rates",
        readable.join("; "),
        if config.format.is_some() {
            ", and its format, or leave format out,"
        } else {
            ""
        }
    )
}

impl std::fmt::Display for Offer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", PixelFormat::name(self.fourcc))?;
        self.sizes
            .iter()
            .try_for_each(|sizes| write!(f, " {sizes}"))
    }
}

impl std::fmt::Display for Sizes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::One([width, height]) => write!(f, "{width}x{height}"),
            Self::Steps { width, height } => {
                let ([w, width, _], [h, height, _]) = (width, height);
                write!(f, "{w}x{h} to {width}x{height}")
            }
        }
    }
}
