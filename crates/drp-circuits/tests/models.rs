//! Each model beside the manual's words, written down a second time as plainly as they are.

#![allow(clippy::unwrap_used, reason = "a test ends by panicking")]

use proptest::prelude::*;
use sextant_drp_circuits::{Circuit, Model, Raster, Standing};

fn image() -> impl Strategy<Value = (Vec<u8>, [usize; 2])> {
    (2_usize..70, 2_usize..20).prop_flat_map(|(width, height)| {
        prop::collection::vec(any::<u8>(), width * height)
            .prop_map(move |pixels| (pixels, [width, height]))
    })
}

fn run(model: &Model, pixels: &[u8], size: [usize; 2]) -> Vec<u8> {
    let mut output = vec![0; pixels.len()];
    let input = Raster::new(pixels, size).unwrap();
    model.run(&input, &mut output).unwrap();
    output
}

fn model(circuit: Circuit, standing: Standing) -> &'static Model {
    let mut models = circuit.models().iter();
    models.find(|model| model.standing() == standing).unwrap()
}

/// Reflection as OpenCV documents it, `gfedcb|abcdefgh|gfedcba`.
fn reflect(i: isize, n: usize) -> usize {
    let last = n as isize - 1;
    (if i < 0 {
        -i
    } else if i > last {
        2 * last - i
    } else {
        i
    }) as usize
}

/// Red, green and blue by "linear interpolation using a 3 x 3 filter", in real numbers.
fn rgb(pixels: &[u8], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> [f64; 3] {
    let mut rgb = [0.0; 3];
    for dy in -1..=1_isize {
        for dx in -1..=1_isize {
            let (x, y) = (
                reflect(x as isize + dx, width),
                reflect(y as isize + dy, height),
            );
            let multiplier = [4.0, 2.0, 1.0][(dx.abs() + dy.abs()) as usize] / 16.0;
            let (colour, density) = match (x % 2, y % 2) {
                (0, 0) => (0, 4.0),
                (1, 1) => (2, 4.0),
                _ => (1, 2.0),
            };
            rgb[colour] += f64::from(pixels[y * width + x]) * multiplier * density;
        }
    }
    rgb
}

proptest! {
    #[test]
    fn bayer_to_grey_follows_the_manual((pixels, size) in image()) {
        let readings: [fn([f64; 3]) -> f64; 5] = [
            |[r, g, b]| ((r * 76.0 + g * 152.0 + b * 28.0) / 256.0).floor(),
            |[r, g, b]| ((r * 76.0 + g * 152.0 + b * 28.0) / 256.0 + 0.5).floor(),
            |[r, g, b]| ((r.floor() * 76.0 + g.floor() * 152.0 + b.floor() * 28.0) / 256.0).floor(),
            |rgb| {
                let [r, g, b] = rgb.map(|colour| (colour + 0.5).floor());
                ((r * 76.0 + g * 152.0 + b * 28.0) / 256.0).floor()
            },
            |rgb| {
                let [r, g, b] = rgb.map(|colour| (colour + 0.5).floor());
                ((r * 76.0 + g * 152.0 + b * 28.0) / 256.0 + 0.5).floor()
            },
        ];
        for (number, reading) in (1..).zip(readings) {
            let grey = run(model(Circuit::Bayer2Grayscale, Standing::Interpretation(number)), &pixels, size);
            for (i, grey) in grey.iter().enumerate() {
                let expected = reading(rgb(&pixels, size, [i % size[0], i / size[0]]));
                prop_assert_eq!(f64::from(*grey), expected, "interpretation {}, pixel {}", number, i);
            }
        }
    }

    #[test]
    fn an_image_is_its_pixels((pixels, size) in image()) {
        for model in Circuit::ALL.iter().flat_map(|circuit| circuit.models()) {
            for (i, out) in run(model, &pixels, size).into_iter().enumerate() {
                let at = [i % size[0], i / size[0]];
                prop_assert_eq!(model.pixel(size, at, |x, y| pixels[y * size[0] + x]), out);
            }
        }
    }

    #[test]
    fn the_extrema_enclose_the_median((pixels, size) in image()) {
        let [least, median, most] = [Circuit::Erode, Circuit::MedianBlur, Circuit::Dilate]
            .map(|circuit| run(model(circuit, Standing::Exact), &pixels, size));
        for i in 0..pixels.len() {
            prop_assert!(least[i] <= median[i] && median[i] <= most[i]);
            prop_assert!(least[i] <= pixels[i] && pixels[i] <= most[i]);
        }
    }
}

#[test]
fn uniform_images_stay_as_they_are() {
    for circuit in Circuit::ALL {
        for model in circuit.models() {
            for grey in [0, 1, 127, 255] {
                assert_eq!(run(model, &[grey; 24 * 8], [24, 8]), [grey; 24 * 8]);
            }
        }
    }
}

/// The example that the manual prints for Dilate.
#[test]
fn dilate_gives_the_manuals_example() {
    let grey = run(
        model(Circuit::Dilate, Standing::Exact),
        &[15, 18, 30, 5, 10, 50, 7, 18, 20],
        [3, 3],
    );
    assert_eq!(grey[4], 50);
}

#[test]
fn only_readings_of_an_open_formula_are_numbered() {
    for circuit in Circuit::ALL {
        let standings: Vec<Standing> = circuit.models().iter().map(Model::standing).collect();
        let numbered = (1..).map(Standing::Interpretation);
        assert!(
            standings == [Standing::Exact] || numbered.zip(&standings).all(|(a, b)| a == *b),
            "{circuit}: {standings:?}"
        );
    }
}
