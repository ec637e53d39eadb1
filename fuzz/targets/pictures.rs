//! What cameras and the programs in their place deliver: pixels in every format of a small image, and JPEGs in a
//! stream.

#![no_main]
#![allow(dead_code, reason = "of the node's modules, these parts are driven")]

use arbitrary::{Arbitrary, Result, Unstructured};
use sextant_fuzz as _;
use source::pixel_formats::{Coding, FORMATS, Geometry, GreyReader, jpeg_dimensions};

#[path = "../../node-camera/src/source"]
mod source {
    pub(crate) mod pixel_formats;

    pub(crate) mod command {
        mod jpeg_stream;

        /// Takes a stream in pieces of so many bytes and gives its images away.
        pub(crate) fn images(stream: &[u8], piece: usize, mut each: impl FnMut(&[u8])) {
            let mut images = jpeg_stream::JpegStream::default();
            for piece in stream.chunks(piece) {
                images.push(piece);
                while let Some(jpeg) = images.next() {
                    each(jpeg);
                }
            }
        }
    }
}

/// JPEGs that state more pixels than this are left out: they cost time and find nothing new.
const MOST_PIXELS: usize = 1 << 16;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut input = Unstructured::new(bytes);
    if let Ok(geometry) = geometry(&mut input) {
        let format = input.choose(FORMATS).expect("formats");
        let mut reader = GreyReader::new(format.coding, geometry);
        let mut pixels = vec![0; geometry.width * geometry.height];
        let _ = reader.read(input.take_rest(), &mut pixels);
    }
    let Some((&piece, stream)) = bytes.split_first() else {
        return;
    };
    source::command::images(stream, usize::from(piece) + 1, decode);
    decode(bytes);
});

fn geometry(input: &mut Unstructured) -> Result<Geometry> {
    let [width, height, stride] = <[u8; 3]>::arbitrary(input)?.map(usize::from);
    Ok(Geometry {
        width: width + 1,
        height: height % 64 + 1,
        stride,
    })
}

fn decode(jpeg: &[u8]) {
    let Some((width, height)) = jpeg_dimensions(jpeg) else {
        return;
    };
    if width * height <= MOST_PIXELS {
        let geometry = Geometry {
            width,
            height,
            stride: 0,
        };
        let mut pixels = vec![0; width * height];
        let _ = GreyReader::new(Coding::Jpeg, geometry).read(jpeg, &mut pixels);
    }
}
