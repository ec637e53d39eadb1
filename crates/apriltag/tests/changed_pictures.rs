//! The same tags in a picture that was cropped, turned, mirrored, inverted, brightened, darkened or pressed through
//! JPEG. `benches/robustness.py` asks the same of any folder of pictures.

#![allow(clippy::unwrap_used)]

mod drawing;

use drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Detection, Detector, Image, Options};
use std::f64::consts::PI;
use std::sync::LazyLock;

const WIDTH: usize = 240;
const HEIGHT: usize = 160;

/// Rows of pixels.
type Grey = Vec<Vec<u8>>;

/// A tag's id and its middle.
type Place = (u32, [f64; 2]);

/// Six tags of 20 to 35 px on a grey ground, and where they are.
static SCENE: LazyLock<(Grey, Vec<Place>)> = LazyLock::new(|| {
    let camera = Camera::new(WIDTH, HEIGHT);
    let tags: Vec<Tag> = (0..6).map(tag).collect();
    let pixels = Picture::draw(&camera, &tags, 110.0)
        .blurred(0.6)
        .pixels(1.5, 1);
    let middle = |tag: &Tag| {
        let corners = tag.corners(&camera);
        [0, 1].map(|axis: usize| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0)
    };
    let places = tags.iter().map(|tag| (tag.id, middle(tag))).collect();
    (pixels.chunks(WIDTH).map(<[u8]>::to_vec).collect(), places)
});

fn tag(i: u32) -> Tag {
    let k = f64::from(i);
    Tag {
        position_m: [
            -0.09 + 0.09 * (k % 3.0),
            -0.05 + 0.1 * (k / 3.0).floor(),
            0.75 + 0.05 * k,
        ],
        turn_deg: [30.0 * k.sin(), 30.0 * (2.0 * k).cos(), 65.0 * k],
        greys: [25.0, 205.0],
        ..Tag::new(97 * i)
    }
}

fn detect(picture: &Grey) -> Vec<Detection> {
    let (width, height) = (picture[0].len(), picture.len());
    let pixels = picture.concat();
    let image = Image::new(&pixels, width, height, width).unwrap();
    Detector::new(Options::default())
        .unwrap()
        .detect(&image)
        .to_vec()
}

/// Each tag is found once, where it must be, and nothing else.
fn assert_shows(picture: &Grey, places: &[Place], what: &str) {
    let found = detect(picture);
    assert_eq!(found.len(), places.len(), "{what}");
    for detection in found {
        let [x, y] = detection.centre().map(f64::from);
        let here = |&(id, [px, py]): &Place| id == detection.id && (x - px).hypot(y - py) < 2.0;
        assert!(places.iter().any(here), "{what}: {detection:?}");
    }
}

fn moved(places: &[Place], to: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<Place> {
    places.iter().map(|&(id, place)| (id, to(place))).collect()
}

/// A quarter turn clockwise.
fn turned(picture: &Grey, places: &[Place]) -> (Grey, Vec<Place>) {
    let (width, height) = (picture[0].len(), picture.len());
    let row = |y: usize| (0..height).map(|x| picture[height - 1 - x][y]).collect();
    let to = |[x, y]: [f64; 2]| [height as f64 - 1.0 - y, x];
    ((0..width).map(row).collect(), moved(places, to))
}

fn each_pixel(picture: &Grey, change: impl Fn(u8) -> u8) -> Grey {
    let row = |row: &Vec<u8>| row.iter().map(|&grey| change(grey)).collect();
    picture.iter().map(row).collect()
}

/// The luminance part of JPEG: cosines of blocks of 8x8 pixels, rounded to multiples of the standard's table (ITU-T
/// T.81, table K.1) scaled to a quality below 50.
fn through_jpeg(picture: &Grey, quality: f64) -> Grey {
    #[rustfmt::skip]
    const STEPS: [f64; 64] = [
        16., 11., 10., 16., 24., 40., 51., 61., 12., 12., 14., 19., 26., 58., 60., 55.,
        14., 13., 16., 24., 40., 57., 69., 56., 14., 17., 22., 29., 51., 87., 80., 62.,
        18., 22., 37., 56., 68., 109., 103., 77., 24., 35., 55., 64., 81., 104., 113., 92.,
        49., 64., 78., 87., 103., 121., 120., 101., 72., 92., 95., 98., 112., 100., 103., 99.,
    ];
    let cosine = |k: usize, x: usize| {
        let scale = if k == 0 { 0.125_f64 } else { 0.25 }.sqrt();
        scale * ((2 * x + 1) as f64 * k as f64 * PI / 16.0).cos()
    };
    let mut out = picture.clone();
    for (top, left) in
        (0..picture.len() / 8).flat_map(|i| (0..picture[0].len() / 8).map(move |j| (8 * i, 8 * j)))
    {
        let places = || (0..64).map(|i| (i / 8, i % 8));
        let coefficients: Vec<f64> = places()
            .map(|(v, u)| {
                let grey = |(y, x): (usize, usize)| f64::from(picture[top + y][left + x]) - 128.0;
                let sum: f64 = places()
                    .map(|at| grey(at) * cosine(v, at.0) * cosine(u, at.1))
                    .sum();
                let step = STEPS[8 * v + u] * 50.0 / quality;
                (sum / step).round() * step
            })
            .collect();
        for (y, x) in places() {
            let sum: f64 = places()
                .map(|(v, u)| coefficients[8 * v + u] * cosine(v, y) * cosine(u, x))
                .sum();
            out[top + y][left + x] = (sum + 128.0).round().clamp(0.0, 255.0) as u8;
        }
    }
    out
}

#[test]
fn quarter_turns_change_nothing() {
    let mut scene = SCENE.clone();
    for turns in 0..4 {
        assert_shows(&scene.0, &scene.1, &format!("{turns} quarter turns"));
        scene = turned(&scene.0, &scene.1);
    }
    assert_eq!(scene.0, SCENE.0);
}

#[test]
fn mirrored_and_inverted_pictures_show_no_tags() {
    let mirrored: Grey = SCENE
        .0
        .iter()
        .map(|row| row.iter().rev().copied().collect())
        .collect();
    assert_shows(&mirrored, &[], "mirrored");
    assert_shows(&turned(&mirrored, &[]).0, &[], "mirrored and turned");
    assert_shows(&each_pixel(&SCENE.0, |grey| 255 - grey), &[], "inverted");
}

#[test]
fn bright_dark_and_coarsely_packed_pictures_show_the_same_tags() {
    for gamma in [0.4, 0.7, 1.5, 2.5] {
        let curve = |grey: u8| (255.0 * (f64::from(grey) / 255.0).powf(gamma)).round() as u8;
        assert_shows(
            &each_pixel(&SCENE.0, curve),
            &SCENE.1,
            &format!("gamma {gamma}"),
        );
    }
    assert_shows(
        &through_jpeg(&SCENE.0, 30.0),
        &SCENE.1,
        "JPEG of quality 30",
    );
}

#[test]
fn crops_show_the_tags_that_are_wholly_in_them_and_no_others() {
    /// Half the diagonal of the largest tag with its ring, in pixels.
    const REACH: f64 = 30.0;
    let (picture, places) = &*SCENE;
    let mut random = Random(11);
    for _ in 0..100 {
        let mut range = |size: usize| {
            let length = random.between(16.0, size as f64 + 1.0) as usize;
            let first = random.between(0.0, (size - length + 1) as f64) as usize;
            first..first + length
        };
        let (columns, rows) = (range(WIDTH), range(HEIGHT));
        let crop: Grey = picture[rows.clone()]
            .iter()
            .map(|row| row[columns.clone()].to_vec())
            .collect();
        let places = moved(places, |[x, y]| {
            [x - columns.start as f64, y - rows.start as f64]
        });
        let inside = |place: &Place, reach: f64| {
            let within = |x: f64, size: usize| x >= reach && x + reach <= size as f64 - 1.0;
            within(place.1[0], columns.len()) && within(place.1[1], rows.len())
        };
        let found = detect(&crop);
        let is_at = |place: &Place, detection: &Detection| {
            let [x, y] = detection.centre().map(f64::from);
            detection.id == place.0 && (x - place.1[0]).hypot(y - place.1[1]) < 2.0
        };
        for place in places.iter().filter(|place| inside(place, REACH)) {
            assert!(
                found.iter().any(|tag| is_at(place, tag)),
                "{columns:?} {rows:?} {place:?}"
            );
        }
        for tag in &found {
            assert!(
                places
                    .iter()
                    .any(|place| inside(place, 0.0) && is_at(place, tag)),
                "{columns:?} {rows:?} {tag:?}"
            );
        }
    }
}
