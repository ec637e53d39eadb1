//! What a site has: `cargo run --example list`.

use sextant_client::{Error, Site};

fn main() -> Result<(), Error> {
    let endpoint = std::env::args().nth(1);
    let endpoint = endpoint.as_deref().unwrap_or("tcp/127.0.0.1:7447");
    let site = Site::connect(endpoint, "demo")?;
    for node in site.nodes()? {
        println!("{} {}", node.kind.as_str(), node.id);
    }
    for camera in site.cameras()? {
        let rate_hz = camera.status.map_or(0.0, |status| status.rate_hz);
        println!("camera {}: {rate_hz:.1} images/s", camera.id);
    }
    for object in site.objects()? {
        println!(
            "object {}: {:?}, {} tags",
            object.id,
            object.state,
            object.config.tags.len()
        );
    }
    Ok(())
}
