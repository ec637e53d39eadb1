//! Where one object is as seen from another, and where it was a tenth of a second ago:
//! `cargo run --example relative -- cuboid prism`.

use sextant_client::{Error, Site};
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(5);

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let a = arguments.next().unwrap_or_else(|| "cuboid".into());
    let b = arguments.next().unwrap_or_else(|| "prism".into());
    let endpoint = arguments
        .next()
        .unwrap_or_else(|| "tcp/127.0.0.1:7447".into());
    let site = Site::connect(&endpoint, "demo")?;

    let now = site.transform(&a, &b, PATIENCE)?;
    let sigma_mm = now.covariance.fixed_view::<3, 3>(0, 0).trace().sqrt() * 1e3;
    println!(
        "{b} in {a}: {:?} m, sigma {sigma_mm:.2} mm",
        now.position.data
    );

    // Poses are kept from the first request on: that of a moment later has some before it.
    let moment = now.t_ns + 100_000_000;
    let pose = site.pose_at(&b, moment, PATIENCE)?;
    println!(
        "{b} at {moment}: {:?} m, {:?}",
        pose.position.data, pose.state
    );
    Ok(())
}
