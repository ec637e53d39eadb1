//! Prints ten poses of an object: `cargo run --example poses -- cuboid`.

use sextant_client::{Error, Site};

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let object = arguments.next().unwrap_or_else(|| "cuboid".into());
    let endpoint = arguments
        .next()
        .unwrap_or_else(|| "tcp/127.0.0.1:7447".into());
    let site = Site::connect(&endpoint, "demo")?;
    for pose in site.poses(&object)?.take(10) {
        println!("{} {:?} {:?}", pose.t_ns, pose.state, pose.position.data);
    }
    Ok(())
}
