//! Draws images of the demonstration to look at, and tells how long one takes.
//!
//! `cargo run --release -p sextant-simulator --example picture -- [FOLDER] [CAMERAS] [OBJECTS] [SEED] [IMAGES]`;
//! without a folder the pictures go to the system's temporary one.

use sextant_simulator::{Renderer, Scenario};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments
        .next()
        .map_or_else(std::env::temp_dir, PathBuf::from);
    let mut number = |default: u64| arguments.next().map_or(Ok(default), |text| text.parse());
    let (n_cameras, n_objects, seed) = (number(4)?, number(3)?, number(1)?);
    let n_images = number(120)?.max(1);
    let scenario = Scenario::demo(n_cameras as usize, n_objects as usize, seed);
    for camera in 0..scenario.cameras.len() {
        draw(&scenario, camera, n_images, &folder)?;
    }
    Ok(())
}

fn draw(
    scenario: &Scenario,
    camera: usize,
    n_images: u64,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    let before = Instant::now();
    let mut renderer = Renderer::new(scenario, camera)?;
    let prepared = before.elapsed();
    let schedule = renderer.camera().schedule();
    let [width, height] = renderer.camera().resolution;
    let mut image = vec![0; (width * height) as usize];
    let before = Instant::now();
    for n in 0..n_images {
        renderer.render(
            schedule.next_at_or_after(n * schedule.period_ns()),
            &mut image,
        )?;
    }
    let each = before.elapsed() / n_images as u32;
    let path = folder.join(format!("{}.png", renderer.camera().id));
    println!(
        "{}: background {prepared:.2?}, {each:.2?} an image",
        path.display()
    );
    write_png(&path, [width, height], &image)
}

fn write_png(path: &Path, [width, height]: [u32; 2], image: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut encoder = png::Encoder::new(std::fs::File::create(path)?, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(image)?;
    Ok(())
}
