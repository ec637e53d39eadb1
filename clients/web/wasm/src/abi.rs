//! The crate as functions of numbers, for JavaScript.
//!
//! Input that is no number is written into buffers of this module: pixels, text, and up to [`N_NUMBERS`] numbers. A
//! call returns how many figures or bytes it has made, which stay where they are until the next call; or [`FAILED`],
//! and the bytes are the cause in English. Every call accepts any numbers.

use crate::messages::{self, Figures, Times};
use crate::vision::{Light, Search, Vision, grey_of_rgba};
use sextant_apriltag::{Detection, Image, Options};
use sextant_geometry::{Intrinsics, Lens};
use sextant_proto::limits::MAX_JPEG_BYTES;
use sextant_site_model::CameraId;
use sextant_tag_families::Family;
use std::cell::RefCell;
use std::fmt::Display;

/// Length of the array by which JavaScript and this module exchange numbers.
pub const N_NUMBERS: usize = 16;
/// Returned instead of a count.
pub const FAILED: i32 = -1;
/// Figures of a tag: family, id, hamming, margin, eight of corners, twelve of their covariances.
pub const TAG_FIGURES: usize = 24;
/// Figures of a pose: position, orientation, error.
pub const POSE_FIGURES: usize = 8;

/// The largest image with four bytes a pixel.
const MAX_PIXEL_BYTES: usize = 4 * Image::MAX_PIXELS;
const MAX_TEXT_BYTES: usize = 4096;

#[derive(Default)]
struct Instance {
    vision: Option<Vision>,
    resolution: [u16; 2],
    pixels: Vec<u8>,
    text: Vec<u8>,
    numbers: [f64; N_NUMBERS],
    figures: Vec<f64>,
    bytes: Vec<u8>,
}

thread_local! {
    static INSTANCE: RefCell<Instance> = RefCell::default();
}

type CallResult = Result<usize, String>;

/// Runs a call. It borrows the instance for as long as it takes, and calls no other.
fn call(work: impl FnOnce(&mut Instance) -> CallResult) -> i32 {
    INSTANCE.with_borrow_mut(|instance| {
        let count = work(instance).and_then(|count| i32::try_from(count).map_err(words));
        count.unwrap_or_else(|cause| {
            instance.bytes = cause.into_bytes();
            FAILED
        })
    })
}

fn words(cause: impl Display) -> String {
    cause.to_string()
}

/// Room for `length` bytes, or null for more than `most`.
fn room(buffer: &mut Vec<u8>, length: usize, most: usize) -> *mut u8 {
    if length > most {
        return std::ptr::null_mut();
    }
    buffer.resize(length, 0);
    buffer.as_mut_ptr()
}

/// Room for the bytes of an image or a picture; null for too many.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_pixels(length: usize) -> *mut u8 {
    INSTANCE.with_borrow_mut(|instance| room(&mut instance.pixels, length, MAX_PIXEL_BYTES))
}

/// Room for text in UTF-8; null for too much.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_text(length: usize) -> *mut u8 {
    INSTANCE.with_borrow_mut(|instance| room(&mut instance.text, length, MAX_TEXT_BYTES))
}

/// Room for [`N_NUMBERS`] numbers.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_numbers() -> *mut f64 {
    INSTANCE.with_borrow_mut(|instance| instance.numbers.as_mut_ptr())
}

/// The figures of the last call.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_figures() -> *const f64 {
    INSTANCE.with_borrow(|instance| instance.figures.as_ptr())
}

/// The bytes of the last call.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_bytes() -> *const u8 {
    INSTANCE.with_borrow(|instance| instance.bytes.as_ptr())
}

/// Number of bytes of the last call, or of its error.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_bytes_length() -> usize {
    INSTANCE.with_borrow(|instance| instance.bytes.len())
}

/// The name of the family of that number, in bytes; fails for a number that has none.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_family(number: usize) -> i32 {
    call(|instance| {
        let family = Family::ALL.get(number).ok_or("no such family")?;
        instance.bytes = family.name().as_bytes().to_vec();
        Ok(instance.bytes.len())
    })
}

/// Makes a detector. Text: the families' names, apart by commas. Numbers: most corrected bits, least edge in pixels, 1
/// for inverted tags, 1 for tracking.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_configure() -> i32 {
    call(|instance| {
        let [max_hamming, min_edge_px, inverted, tracking, ..] = instance.numbers;
        let options = Options {
            families: families(&instance.text)?,
            max_hamming: max_hamming as u8,
            min_edge_px: min_edge_px as f32,
            inverted: inverted != 0.0,
            ..Options::default()
        };
        let search = match tracking == 0.0 {
            true => Search::Whole,
            false => Search::Tracking,
        };
        instance.vision = Some(Vision::new(options, search).map_err(words)?);
        Ok(0)
    })
}

fn families(text: &[u8]) -> Result<Vec<Family>, String> {
    let text = str::from_utf8(text).map_err(words)?;
    let families = text.split(',').map(|name| {
        let family: Family = name.trim().parse().map_err(words)?;
        match family.data().has_codes() {
            true => Ok(family),
            false => Err(format!("tags of {family} are not read in browsers")),
        }
    });
    families.collect()
}

/// Finds the tags of the image in the pixels: as figures, [`TAG_FIGURES`] a tag; returns the number of tags. `channels`
/// is 1 for grey, with `stride` bytes a row, or 4 for red, green, blue and one that is ignored, with no padding.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_detect(
    width: usize,
    height: usize,
    stride: usize,
    channels: usize,
) -> i32 {
    call(|instance| {
        let vision = instance.vision.as_mut().ok_or("not configured")?;
        let stride = match channels {
            1 => stride,
            4 => width,
            _ => return Err(format!("{channels} channels are neither 1 nor 4")),
        };
        let mut pixels = &mut instance.pixels[..];
        if channels == 4 {
            let n_pixels = grey_of_rgba(pixels);
            pixels = &mut pixels[..n_pixels];
        }
        let tags = vision
            .detect(pixels, [width, height], stride)
            .map_err(words)?;
        instance.figures.clear();
        for tag in tags {
            instance.figures.extend(figures(tag));
        }
        instance.resolution = [width as u16, height as u16];
        Ok(tags.len())
    })
}

fn figures(tag: &Detection) -> [f64; TAG_FIGURES] {
    let mut figures = [0.0; TAG_FIGURES];
    let first = [
        f64::from(tag.family as u8),
        f64::from(tag.id),
        f64::from(tag.hamming),
        f64::from(tag.margin),
    ];
    let corners = tag.corners.as_flattened().iter();
    let others = corners.chain(tag.corner_covariance.as_flattened());
    let all = first
        .into_iter()
        .chain(others.map(|number| f64::from(*number)));
    figures
        .iter_mut()
        .zip(all)
        .for_each(|(figure, value)| *figure = value);
    figures
}

/// Light and sharpness of the last image, as two figures.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_light() -> i32 {
    call(|instance| {
        let light = instance.light();
        instance.figures = vec![light.brightness.into(), light.sharpness.into()];
        Ok(2)
    })
}

/// Poses of a tag of the last image: as figures, [`POSE_FIGURES`] a pose, the better first; returns the number of
/// poses. Numbers: the tag's size in metres, fx, fy, cx, cy, and the five of Brown-Conrady's distortion.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_pose(tag: usize) -> i32 {
    call(|instance| {
        let [size_m, fx, fy, cx, cy, k1, k2, p1, p2, k3, ..] = instance.numbers;
        let intrinsics = Intrinsics { fx, fy, cx, cy };
        let lens = Lens::brown_conrady(intrinsics, [k1, k2, p1, p2, k3]).map_err(words)?;
        let vision = instance.vision.as_ref().ok_or("not configured")?;
        let poses = vision.poses(tag, &lens, size_m);
        instance.figures.clear();
        for pose in &poses {
            let position = pose.camera_from_tag.translation.vector;
            let orientation = pose.camera_from_tag.rotation.coords;
            let all = position.iter().chain(&orientation).copied();
            instance.figures.extend(all.chain([pose.rms_px]));
        }
        Ok(poses.len())
    })
}

/// The payload of the last image's observations. Text: the camera's name.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_observations(
    sequence: u64,
    capture_ns: u64,
    received_ns: u64,
    detected_ns: u64,
    is_arrival: u32,
) -> i32 {
    let times = Times {
        capture_ns,
        received_ns,
        detected_ns,
        is_arrival: is_arrival != 0,
    };
    call(|instance| {
        let tags = instance.vision.as_ref().map_or(&[][..], Vision::tags);
        let camera = instance.camera()?;
        let payload = messages::observations(camera, sequence, &times, instance.resolution, tags);
        instance.bytes = payload.map_err(words)?;
        Ok(instance.bytes.len())
    })
}

/// The payload of a status. Text: the camera's name, a line feed, the device's. Numbers: images captured, searched,
/// sent; rate in Hz; median and 99th percentile of detection in ms; seconds since the start.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_status() -> i32 {
    call(|instance| {
        let [
            captured,
            detected,
            published,
            rate_hz,
            median,
            late,
            uptime_s,
            ..,
        ] = instance.numbers;
        let figures = Figures {
            captured: captured as u64,
            detected: detected as u64,
            published: published as u64,
            rate_hz: rate_hz as f32,
            detect_ms: [median as f32, late as f32],
            uptime_s: uptime_s as u64,
        };
        let (brightness, camera) = (instance.light().brightness, instance.camera()?);
        let payload = messages::status(camera, instance.second_line(), &figures, brightness);
        instance.bytes = payload.map_err(words)?;
        Ok(instance.bytes.len())
    })
}

/// The payload of a preview, whose JPEG file is in the pixels. Text: the camera's name.
#[unsafe(no_mangle)]
pub extern "C" fn sextant_preview(sequence: u64, capture_ns: u64, width: u32, height: u32) -> i32 {
    call(|instance| {
        let (camera, resolution) = (instance.camera()?, [width as u16, height as u16]);
        let jpeg = instance
            .pixels
            .get(..instance.pixels.len().min(MAX_JPEG_BYTES + 1))
            .unwrap_or_default();
        let payload = messages::preview(camera, sequence, capture_ns, resolution, jpeg);
        instance.bytes = payload.map_err(words)?;
        Ok(instance.bytes.len())
    })
}

impl Instance {
    fn light(&self) -> Light {
        self.vision.as_ref().map(Vision::light).unwrap_or_default()
    }

    fn lines(&self) -> impl Iterator<Item = &str> {
        str::from_utf8(&self.text).unwrap_or_default().split('\n')
    }

    fn camera(&self) -> Result<CameraId, String> {
        CameraId::new(self.lines().next().unwrap_or_default()).map_err(words)
    }

    fn second_line(&self) -> &str {
        self.lines().nth(1).unwrap_or_default()
    }
}
