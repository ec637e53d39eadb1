//! After its first images the detecting part takes nothing from the heap for another one, but for what it takes to
//! encode its message and hand it to the network's library, which keeps the bytes.

use super::*;
use allocation_counter::measure;
use sextant_iceoryx_images::{IceoryxOptions, ImagePublisher};
use sextant_proto::{ObjectConfig, RigConfig, SiteId};
use sextant_simulator::{Renderer, Scenario};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_zenoh_bus::BusOptions;

const PATIENCE: Duration = Duration::from_secs(10);

/// A scenario's camera and objects, as a fusion node would announce them.
fn announce(
    scenario: &Scenario,
    bus: &Bus,
    keys: &Keys,
) -> (Latest<RigConfig>, Latest<ObjectConfig>) {
    let [camera, object] = [&scenario.cameras[0].id, &scenario.objects[0].id];
    let seen = &scenario.cameras[0];
    let rig = Rig::new(vec![Camera::new(
        CameraId::new(camera).unwrap(),
        seen.resolution,
        seen.lens,
        Some(seen.world_from_camera),
    )]);
    let tags = scenario.objects[0].tags.iter().map(|tag| {
        ObjectTag::new(
            TagId {
                family: tag.family,
                id: tag.id,
            },
            tag.size,
            Some(tag.object_from_tag),
        )
    });
    let id = ObjectId::new(object).unwrap();
    let model = ObjectModel::new(id.clone(), tags.collect()).unwrap();
    let rig_key = bus
        .latest_publisher(&keys.config_rig(), Qos::Config)
        .unwrap();
    rig_key.put(&RigConfig::from(&rig.unwrap())).unwrap();
    let object_key = bus
        .latest_publisher(&keys.config_object(&id), Qos::Config)
        .unwrap();
    object_key.put(&ObjectConfig::from(&model)).unwrap();
    (rig_key, object_key)
}

#[test]
fn an_image_costs_no_memory_but_for_sending_its_message() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = Scenario::demo(1, 1, 1);
    let [width, height] = scenario.cameras[0].resolution;
    let bytes = (width * height) as usize;
    let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
    let config = CameraNodeConfig::new(
        SiteId::new("test").unwrap(),
        CameraId::new(&scenario.cameras[0].id).unwrap(),
        crate::SourceConfig::images(folder.path()),
        BusOptions::client_of(&bus.endpoints()[0]),
        IceoryxOptions {
            root: folder.path().join("i"),
            prefix: format!("{:x}d", std::process::id()),
        },
    );
    let _announced = announce(&scenario, &bus, &Keys::for_site(config.site.clone()));
    let own = Bus::open(&config.network).unwrap();
    let mut part = DetectPart::new(&config, &own).unwrap();
    let deadline = Instant::now() + PATIENCE;
    while part.models.lens(width as u16, height as u16).is_none() {
        assert!(Instant::now() < deadline);
        part.models.update(&own);
        thread::yield_now();
    }
    let (place, camera) = (&config.shared_memory, config.camera.as_str());
    let publisher = ImagePublisher::open(place, camera, bytes).unwrap();
    let mut images = ImageSubscriber::open(place, camera).unwrap();
    let mut renderer = Renderer::new(&scenario, 0).unwrap();
    for sequence in 0..20 {
        let mut blank = publisher.blank(bytes).unwrap();
        let (header, pixels) = blank.parts();
        *header = ImageHeader {
            sequence,
            capture_ns: now_ns(),
            stride: width,
            width: width as u16,
            height: height as u16,
            ..ImageHeader::default()
        };
        renderer.render(0, pixels).unwrap();
        publisher.send(blank).unwrap();
        // Asking whether anybody wants to see how it detects costs something, but not with each image.
        part.inspection.due = Instant::now() + PATIENCE;
        let taking = measure(|| {
            let image = images.wait(PATIENCE).unwrap().unwrap();
            part.take(&image).unwrap();
        });
        let message = &part.draft.message;
        let sending = measure(|| part.observations.put(message).unwrap());
        assert!(message.tags.iter().any(|tag| !tag.poses.is_empty()));
        if sequence >= 5 {
            assert_eq!(taking.count_total, sending.count_total);
        }
    }
}
