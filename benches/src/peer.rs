//! AprilTag's own detector in C (Wang & Olson, AprilTag 2, IROS 2016; Krogius et al., IROS 2019), one thread, full
//! resolution.

use apriltag_sys::{
    apriltag_detections_destroy, apriltag_detector_add_family_bits, apriltag_detector_create,
    apriltag_detector_destroy, apriltag_detector_detect, apriltag_detector_t, apriltag_family_t,
    image_u8_t, tag36h11_create, tag36h11_destroy,
};

/// A detector for `tag36h11`.
#[derive(Debug)]
pub struct Peer {
    detector: *mut apriltag_detector_t,
    family: *mut apriltag_family_t,
}

impl Peer {
    /// Everything as AprilTag has it by default, but for `quad_decimate` = 1, the full resolution, and the given least
    /// difference of black and white (`min_white_black_diff`, 5 by default).
    pub fn new(min_contrast: i32) -> Self {
        const CORRECTED_BITS: i32 = 2;
        // SAFETY: both functions take nothing and return what only the matching destroy function frees; the library
        // ends the process when memory runs out, so neither pointer is null.
        let (detector, family) = unsafe { (apriltag_detector_create(), tag36h11_create()) };
        // SAFETY: both pointers were just made and are used by nobody else; the family outlives the detector, see
        // `drop`.
        unsafe {
            apriltag_detector_add_family_bits(detector, family, CORRECTED_BITS);
            (*detector).nthreads = 1;
            (*detector).quad_decimate = 1.0;
            (*detector).qtp.min_white_black_diff = min_contrast;
        }
        Self { detector, family }
    }

    /// How many tags it finds in an image whose rows follow one another without a gap.
    pub fn detect(&mut self, pixels: &[u8], width: usize) -> usize {
        let height = pixels.len() / width;
        let mut image = image_u8_t {
            width: width as i32,
            height: height as i32,
            stride: width as i32,
            buf: pixels.as_ptr().cast_mut(),
        };
        // SAFETY: the image describes `pixels`, which are only read at full resolution without blur, and outlives the
        // call; the array of detections is valid until it is destroyed, and used by nobody after that.
        unsafe {
            let found = apriltag_detector_detect(self.detector, &raw mut image);
            let count = (*found).size;
            apriltag_detections_destroy(found);
            usize::try_from(count).unwrap_or(0)
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // SAFETY: both were made in `new` and are destroyed once, the detector first as it refers to the family.
        unsafe {
            apriltag_detector_destroy(self.detector);
            tag36h11_destroy(self.family);
        }
    }
}
