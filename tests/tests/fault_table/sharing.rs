//! Objects shared among fusion nodes.

use super::*;

/// How many objects each node publishes, once each of these is published by one node and each node has some.
fn await_shares(house: &House, router: &str, nodes: &[&str], n: usize) -> BTreeMap<String, usize> {
    let shares = |statuses: &Statuses| {
        let published = |status: &FusionStatus| {
            let objects = status.objects.iter();
            objects.filter(|object| object.rate_hz > 1.0).count()
        };
        let shares = statuses
            .iter()
            .map(|(name, one)| (name.clone(), published(one)));
        shares.collect::<BTreeMap<_, _>>()
    };
    let statuses = house.await_statuses(&[router], |statuses| {
        let shares = shares(statuses);
        let has_some = |name: &&str| shares.get(*name).is_some_and(|share| *share > 0);
        shares.len() == nodes.len()
            && nodes.iter().all(has_some)
            && shares.values().sum::<usize>() == n
    });
    shares(&statuses)
}

/// Three nodes share twelve objects. One is killed, and started again.
#[test]
fn objects_are_shared_and_move_when_nodes_come_and_go() {
    const ROW: &str = "one of three fusion nodes that share 12 objects";
    const NODES: [&str; 3] = ["main", "spare", "third"];
    let names: Vec<String> = (0..12).map(|k| format!("cube{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut house = House::new(&Scene::new(CAMERAS, &names));
    let router = house.router("router", &[]);
    for node in NODES {
        house.fusion_with(node, &[&router], "[sharding]\nmode = \"by-members\"\n");
    }
    let cameras = Cameras {
        cameras: &ALL,
        routers: &[&router],
        start_ns: now_ns(),
        // Three nodes run on this machine.
        rate_hz: 10,
    };
    let feed = CameraFeed::start(&house, cameras);
    let witness = Witness::start(&house.keys, &[&router]);
    let before = await_shares(&house, &router, &NODES, names.len());
    // Two of three nodes track an object.
    let statuses = house.await_statuses(&[&router], |statuses| {
        let tracked = statuses.values().map(|status| status.objects.len());
        tracked.sum::<usize>() == 2 * names.len()
    });
    let unknown = statuses.values().flat_map(|status| &status.cameras);
    assert_eq!(unknown.map(|camera| camera.unknown_tags).max(), Some(0));

    let killed = Instant::now();
    house.kill("main");
    await_shares(&house, &router, &NODES[1..], names.len());
    let restarted = Instant::now();
    house.restart("main");
    assert_eq!(await_shares(&house, &router, &NODES, names.len()), before);
    let used = witness.used_since(killed);
    let (away, back): (Vec<_>, Vec<_>) = used.into_iter().partition(|one| one.at < restarted);
    for (what, sights, since) in [("kill -9", away, killed), ("back", back, restarted)] {
        assert_true(&house, &feed, &sights);
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&sights, since),
            unit: "ms without a pose",
            at_most: 300.0,
        }
        .keep();
    }
    assert_epochs_increase(&witness.sights());
}
