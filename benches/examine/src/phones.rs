//! Phones as cameras: what four browsers that play rendered films find of two objects that are carried about.
//!
//! `phones film FOLDER [--seed N] [--size WxH] [--seconds
//! N]` writes a film a phone, `CAMERA.mjpeg` at 30 images a second, and  `scenario.toml` with the truth; objects are
//! back where they began when a film ends, so that it can be repeated. `phones score FOLDER SITE RECORDING` compares
//! the poses of a recording with that truth. SITE is the folder that `sextant calibrate site` wrote. The world frame of
//! a site, the frames of its objects and the start of the films are free: the rigid motions and the common shift in
//! time that fit best are removed. The truth in frames and time of the recording goes to `FOLDER/truth/OBJECT.tum`, for
//! `sextant replay RECORDING --against OBJECT.tum --align rigid`.  `phones clocks FOLDER RECORDING` says by how much
//! the films fell behind on a machine without time for them: then nothing else counts.

mod film;
mod film_clock;
mod scene;
mod score;

use anyhow::{Context, bail, ensure};
use std::path::PathBuf;
use std::str::FromStr;

const USAGE: &str = "phones film FOLDER [--seed N] [--size WxH] [--seconds N]
phones score FOLDER SITE RECORDING.mcap
phones clocks FOLDER RECORDING.mcap";

/// Runs a subcommand of `phones`.
///
/// # Errors
/// Wrong usage, and files that cannot be read or written.
pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let folder = |index: usize| arguments.get(index).map(PathBuf::from).context(USAGE);
    match arguments.first().map(String::as_str) {
        Some("film") => {
            let [width, height] = size(&option(arguments, "--size", "1280x720".to_owned())?)?;
            let wanted = scene::Wanted {
                seed: option(arguments, "--seed", 1)?,
                resolution: [width, height],
                seconds: option(arguments, "--seconds", 60)?,
            };
            ensure!(
                (1..=600).contains(&wanted.seconds),
                "--seconds: 1 to 600 seconds"
            );
            film::write(&folder(1)?, &wanted)
        }
        Some("clocks") => score::clocks(&folder(1)?, &folder(2)?),
        Some("score") => score::score(&folder(1)?, &folder(2)?, &folder(3)?),
        _ => bail!(USAGE),
    }
}

/// The value after a name, or the default.
fn option<T: FromStr>(arguments: &[String], name: &str, default: T) -> anyhow::Result<T> {
    let Some(index) = arguments.iter().position(|argument| argument == name) else {
        return Ok(default);
    };
    let value = arguments.get(index + 1).and_then(|text| text.parse().ok());
    value.with_context(|| format!("{name}: no valid value; {USAGE}"))
}

fn size(text: &str) -> anyhow::Result<[u32; 2]> {
    let both = text.split_once('x');
    let both = both.and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    both.with_context(|| format!("--size {text}: write WxH, such as 640x480"))
}
