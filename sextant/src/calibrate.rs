//! `sextant calibrate`: procedures that a person runs now and then.

mod lens;
mod rig;
mod robot;
mod site;

use crate::output::Format;
use clap::{Args, Subcommand};

/// What is to be calibrated.
#[derive(Args, Debug)]
pub struct CalibrateArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand, Debug)]
enum What {
    /// Find the lens of a camera, from images of a board of tags.
    Lens(lens::LensArguments),
    /// Find where every camera is, from an object carried through what they see.
    Rig(rig::RigArguments),
    /// Find where a robot's base is and what its hand carries, from its poses and images.
    Robot(robot::RobotArguments),
    /// Find lenses, camera poses, objects and clocks at once, from tagged things carried about; nothing but sizes is
    /// known before.
    Site(site::SiteArguments),
}

/// Standard deviations by which a line delay differs from that of a global shutter, and microseconds.
const ROLLS: (f64, f64) = (6.0, 1.0);

/// A line on an estimated line delay in microseconds with its standard deviation, where the shutter rolls.
fn rolling_shutter(
    camera: &str,
    line_delay_us: Option<f64>,
    sigma_us: Option<f64>,
) -> Option<String> {
    let (us, sigma) = line_delay_us.zip(sigma_us)?;
    let rolls = us.abs() > ROLLS.0 * sigma && us.abs() > ROLLS.1;
    rolls.then(|| {
        format!(
            "{camera}: a rolling shutter, {us:.2} us from a row to the next (one sigma {sigma:.2})"
        )
    })
}

/// Runs `sextant calibrate`.
///
/// # Errors
/// Whatever the procedure cannot do, with its exit code.
pub fn run(arguments: &CalibrateArguments, format: Format) -> anyhow::Result<()> {
    match &arguments.what {
        What::Lens(arguments) => lens::run(arguments, format),
        What::Rig(arguments) => rig::run(arguments, format),
        What::Robot(arguments) => robot::run(arguments, format),
        What::Site(arguments) => site::run(arguments, format),
    }
}
