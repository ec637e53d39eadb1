//! Lenses and pictures of cameras.

use sextant_proto::{CameraConfig, LensConfig, Preview};
use sextant_site_model::CameraId;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

use super::frames::optical_frame;
use crate::messages::{CameraInfo, CompressedImage, Header, RegionOfInterest};

/// The lens of a camera for whole images. ROS's models: `plumb_bob` for pinhole and Brown-Conrady lenses, `equidistant`
/// for Kannala-Brandt lenses. The images are not rectified, so that the projection matrix is that of the lens.
#[must_use]
pub fn camera_info(camera: &CameraConfig, stamp_ns: u64) -> CameraInfo {
    info(camera, camera.resolution, stamp_ns)
}

/// The picture of a preview as a JPEG file.
#[must_use]
pub fn picture(preview: &Preview) -> CompressedImage {
    image(
        &preview.camera,
        preview.capture_ns,
        "jpeg",
        preview.jpeg.clone(),
    )
}

/// An image of a camera as a file of the named format.
#[must_use]
pub fn image(camera: &CameraId, capture_ns: u64, format: &str, file: Vec<u8>) -> CompressedImage {
    CompressedImage {
        header: Header::new(capture_ns, &optical_frame(camera)),
        format: format.to_owned(),
        data: file,
    }
}

/// The lens of a camera for the picture of a preview, which may be smaller than the image. None where the picture is no
/// JPEG.
#[must_use]
pub fn picture_info(camera: &CameraConfig, preview: &Preview) -> Option<CameraInfo> {
    let mut decoder = JpegDecoder::new(ZCursor::new(preview.jpeg.as_slice()));
    decoder.decode_headers().ok()?;
    let (width, height) = decoder.dimensions()?;
    let size = [u32::try_from(width).ok()?, u32::try_from(height).ok()?];
    Some(info(camera, size, preview.capture_ns))
}

/// For images of `size` pixels that show what the camera's own images show.
fn info(camera: &CameraConfig, size: [u32; 2], stamp_ns: u64) -> CameraInfo {
    let lens = Lens::from_config(&camera.lens);
    let [sx, sy] = [0, 1].map(|axis| f64::from(size[axis]) / f64::from(camera.resolution[axis]));
    // The centre of the first pixel is (0, 0), its corner (-0.5, -0.5): scaling leaves the corner where it is.
    let [cx, cy] = [(lens.cx + 0.5) * sx - 0.5, (lens.cy + 0.5) * sy - 0.5];
    let [fx, fy] = [lens.fx * sx, lens.fy * sy];
    CameraInfo {
        header: Header::new(stamp_ns, &optical_frame(&camera.id)),
        height: size[1],
        width: size[0],
        distortion_model: lens.model.to_owned(),
        d: lens.distortion,
        k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        binning_x: 0,
        binning_y: 0,
        roi: RegionOfInterest {
            x_offset: 0,
            y_offset: 0,
            height: 0,
            width: 0,
            do_rectify: false,
        },
    }
}

/// A lens in ROS's terms.
struct Lens {
    model: &'static str,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    distortion: Vec<f64>,
}

impl Lens {
    fn from_config(lens: &LensConfig) -> Self {
        let [fx, fy, cx, cy] = lens.intrinsics();
        let (model, distortion) = match lens {
            LensConfig::Pinhole { .. } => ("plumb_bob", &[0.0; 5][..]),
            LensConfig::BrownConrady { .. } => ("plumb_bob", lens.distortion()),
            LensConfig::KannalaBrandt { .. } => ("equidistant", lens.distortion()),
        };
        Self {
            model,
            fx,
            fy,
            cx,
            cy,
            distortion: distortion.to_vec(),
        }
    }
}
