//! Prints ten poses in an asynchronous program: `cargo run --example stream -- cuboid`.

use futures_util::StreamExt;
use sextant_client::{Error, Site};

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let object = arguments.next().unwrap_or_else(|| "cuboid".into());
    let endpoint = arguments
        .next()
        .unwrap_or_else(|| "tcp/127.0.0.1:7447".into());
    let site = Site::connect(&endpoint, "demo")?;
    let mut poses = site.poses(&object)?.into_stream().take(10);
    while let Some(pose) = poses.next().await {
        println!("{} {:?} {:?}", pose.t_ns, pose.state, pose.position.data);
    }
    Ok(())
}
