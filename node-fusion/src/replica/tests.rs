//! One node's replica, and the replicas of several nodes on a network that loses what it likes.

use super::*;
use sextant_proto::{CameraSettings, Keys};
use sextant_simulator::Random;
use sextant_site_files::{parse_object, parse_rig};
use sextant_site_model::{ObjectModel, Rig};
use std::path::Path;

const SECOND_NS: u64 = 1000 * MS;
const START_NS: u64 = 1_800_000_000 * SECOND_NS;

fn at(ns: u64) -> Moment {
    Moment {
        monotonic_ns: ns,
        wall_ns: START_NS + ns,
    }
}

fn id(name: &str) -> NodeId {
    NodeId::new(name).unwrap()
}

fn rig(fx: f64) -> Rig {
    let text = format!(
        "[[camera]]\nid = \"north\"\nresolution = [640, 480]\n\
         lens = {{ model = \"pinhole\", fx = {fx:.1}, fy = 600.0, cx = 319.5, cy = 239.5 }}\n"
    );
    parse_rig(Path::new("r"), &text).unwrap()
}

fn object(id: &str, tag: u32) -> ObjectModel {
    let text = format!("id = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n");
    parse_object(Path::new("o"), &text).unwrap()
}

fn models(fx: f64) -> ModelsInForce {
    ModelsInForce {
        rig: rig(fx),
        objects: vec![object("cube", 1), object("ball", 2)],
        settings: Default::default(),
    }
}

fn replica(name: &str, models: ModelsInForce) -> Replica {
    Replica::new(id(name), models, Formers::default(), None, None)
}

fn asked(changes: Vec<Change>) -> Request {
    Request {
        key: Keys::below_site(&Keys::new("lab").unwrap().config_rig()).to_owned(),
        fingerprint: 7,
        origin: Origin::Request {
            about: KeyRef::ConfigRig,
            sender: None,
        },
        changes: Ok(changes),
    }
}

fn effects(replica: &mut Replica) -> Vec<Effect> {
    std::iter::from_fn(|| replica.poll()).collect()
}

fn outcomes(effects: &[Effect]) -> Vec<&ChangeOutcome> {
    let answers = effects.iter().filter_map(|effect| match effect {
        Effect::Answer(answered) => Some(&answered.answer.outcome),
        _ => None,
    });
    answers.collect()
}

#[test]
fn a_change_is_answered_when_the_others_have_it_or_after_a_second() {
    let (mut main, mut spare) = (
        replica("main", models(600.0)),
        replica("spare", models(600.0)),
    );
    main.tick(true, at(0));
    spare.hear(&id("main"), main.state(), at(0));
    assert_eq!(
        spare.state(),
        main.state(),
        "the same models are of one version"
    );
    main.hear(&id("spare"), spare.state(), at(0));
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(10));
    main.tick(true, at(20));
    let taken = effects(&mut main);
    assert_eq!(taken, [Effect::PutInForce(vec![Change::Rig(rig(610.0))])]);
    assert!(!main.is_ready(at(SECOND_NS / 2)), "one at a time");

    spare.hear(&id("main"), main.state(), at(30));
    assert!(!spare.is_current());
    spare.tick(false, at(30));
    assert_eq!(effects(&mut spare), [Effect::Ask(id("main"))]);
    // Answers of another state change nothing.
    spare.follow(&id("main"), Payloads::encode(&models(620.0)), at(35));
    assert!(!spare.is_current());
    spare.follow(&id("main"), main.payloads().clone(), at(40));
    assert!(spare.is_current());
    assert_eq!(spare.models(), main.models());
    main.hear(&id("spare"), spare.state(), at(50));
    main.tick(true, at(50));
    let done = effects(&mut main);
    let [Effect::Answer(Answered { answer, .. })] = &done[..] else {
        panic!("{done:?}")
    };
    assert_eq!(
        (&answer.outcome, &answer.followers),
        (&ChangeOutcome::Taken, &vec![id("spare")])
    );

    main.request(asked(vec![Change::Rig(rig(620.0))]), at(60));
    main.tick(true, at(60 + FOLLOWED_NS));
    let done = effects(&mut main);
    let [_, Effect::Answer(Answered { answer, .. })] = &done[..] else {
        panic!("{done:?}")
    };
    assert_eq!(
        (&answer.followers, &answer.behind),
        (&vec![], &vec![id("spare")])
    );
}

#[test]
fn the_same_and_what_cannot_be_are_answered_at_once() {
    let mut main = replica("main", models(600.0));
    main.tick(true, at(0));
    let before = main.state().clone();
    main.request(asked(vec![Change::Rig(rig(600.0))]), at(1));
    main.request(asked(vec![Change::Object(object("twin", 1))]), at(2));
    let wrong = Request {
        changes: Err(Refusal::NoCamera),
        ..asked(vec![])
    };
    main.request(wrong, at(3));
    let done = effects(&mut main);
    assert!(matches!(
        outcomes(&done)[..],
        [
            ChangeOutcome::Same,
            ChangeOutcome::Refused(Refusal::SharedTag { .. }),
            ChangeOutcome::Refused(Refusal::NoCamera)
        ]
    ));
    assert_eq!(*main.state(), before);
}

#[test]
fn a_tag_moves_from_one_object_to_another_in_one_change() {
    let mut main = replica("main", models(600.0));
    let exchanged = vec![
        Change::Object(object("cube", 2)),
        Change::Object(object("ball", 1)),
    ];
    main.request(asked(exchanged.clone()), at(1));
    assert_eq!(effects(&mut main), [Effect::PutInForce(exchanged)]);
    assert_eq!(main.formers().objects.len(), 2);
    // An object is renamed: its tags are on another one before it is gone.
    main.tick(true, at(2));
    let renamed = vec![
        Change::Object(object("die", 2)),
        Change::Removal("cube".parse().unwrap()),
    ];
    main.request(asked(renamed), at(3));
    assert_eq!(main.models().objects, [object("ball", 1), object("die", 2)]);
}

/// A spare whose file is old starts while the publisher does not answer.
#[test]
fn files_that_were_never_compared_are_older_than_all_others() {
    let (mut main, mut spare) = (
        replica("main", models(600.0)),
        replica("spare", models(650.0)),
    );
    main.tick(true, at(0));
    spare.joined(id("main"), at(0));
    spare.tick(false, at(1));
    assert_eq!(
        spare.state().version,
        None,
        "main has not told of its models"
    );
    assert!(!spare.is_current());
    // It may stand still, and be gone for the network.
    spare.left(&id("main"), at(1));
    spare.tick(false, at(PAUSE_NS));
    assert!(!spare.is_current());
    let mut third = replica("third", models(650.0));
    third.joined(id("main"), at(0));
    third.hear(&id("spare"), spare.state(), at(1));
    third.tick(false, at(2));
    assert!(!third.is_current(), "main is not heard yet");
    third.tick(false, at(PAUSE_NS));
    assert!(third.is_current(), "it is waited for no longer");
    main.hear(&id("spare"), spare.state(), at(2));
    assert!(main.is_current());
    spare.hear(&id("main"), main.state(), at(2));
    assert!(!spare.is_current());
    // That main is gone does not make the models of the spare any newer.
    spare.left(&id("main"), at(3));
    spare.tick(true, at(SECOND_NS));
    assert!(!spare.is_current());
    assert_eq!(
        spare.outdated(at(SECOND_NS)).next(),
        Some((&id("spare"), &id("main")))
    );
    // A person decides.
    assert!(spare.is_ready(at(SECOND_NS)));
    spare.request(asked(vec![Change::Rig(rig(660.0))]), at(SECOND_NS));
    assert!(spare.is_current());
    assert!(spare.state().version > main.state().version);
}

/// The node that has newer models is gone, or was started anew without them.
#[test]
fn models_that_no_node_has_any_more_are_not_waited_for() {
    for is_gone in [true, false] {
        let (mut main, mut spare) = (kept("main"), kept("spare"));
        main.request(asked(vec![Change::Rig(rig(610.0))]), at(2));
        effects(&mut main);
        main.kept(Ok(()), at(3));
        spare.hear(&id("main"), main.state(), at(4));
        assert!(!spare.is_current());
        if is_gone {
            spare.left(&id("main"), at(5));
            spare.tick(false, at(SECOND_NS));
            assert!(!spare.is_current());
        } else {
            let anew = kept("main");
            spare.hear(&id("main"), anew.state(), at(SECOND_NS));
            assert!(spare.is_current());
        }
        effects(&mut spare);
        assert!(spare.is_ready(at(SECOND_NS)));
        spare.request(asked(vec![Change::Rig(rig(660.0))]), at(SECOND_NS));
        spare.kept(Ok(()), at(SECOND_NS + 1));
        spare.tick(true, at(SECOND_NS + 2));
        assert_eq!(outcomes(&effects(&mut spare)).len(), usize::from(is_gone));
        assert!(spare.is_current());
        assert!(spare.state().version > main.state().version);
    }
}

/// Nor does a node that is there and does not hand its models over, or hands over what cannot be used.
#[test]
fn a_node_that_hands_nothing_over_is_not_waited_for_by_a_person() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(2));
    effects(&mut main);
    main.kept(Ok(()), at(3));
    for seconds in 0..5 {
        let now = at(seconds * SECOND_NS + 4);
        spare.hear(&id("main"), main.state(), now);
        spare.tick(false, now);
        assert!(!spare.is_ready(now), "{seconds}");
        // It writes down what it knows.
        effects(&mut spare);
        spare.kept(Ok(()), now);
    }
    spare.hear(&id("main"), main.state(), at(6 * SECOND_NS));
    assert!(spare.is_ready(at(6 * SECOND_NS)) && !spare.is_current());
}

#[test]
fn edited_files_count_where_no_other_node_runs() {
    let of_record = Some(record(&models(600.0), 5));
    let start = |models| {
        Replica::new(
            id("main"),
            models,
            Formers::default(),
            of_record.clone(),
            Some(Vec::new()),
        )
    };
    let state = of_record.as_ref().map(|record| &record.state);
    assert_eq!(Some(start(models(600.0)).state()), state);
    let mut edited = start(models(601.0));
    assert_eq!(edited.state().version, None);
    edited.tick(true, at(0));
    assert_eq!(
        edited
            .state()
            .version
            .as_ref()
            .map(|version| version.counter),
        Some(6)
    );
    let [Effect::Keep(job)] = &effects(&mut edited)[..] else {
        panic!()
    };
    assert_eq!(job.record.state, *edited.state());
}

fn record(models: &ModelsInForce, counter: u64) -> ModelsRecord {
    ModelsRecord {
        state: ModelsState {
            version: Some(ModelsVersion {
                counter,
                t_ns: START_NS,
                author: id("main"),
            }),
            fingerprint: Payloads::encode(models).fingerprint(),
        },
        newer: None,
    }
}

fn kept(name: &str) -> Replica {
    let kept = Some(Vec::new());
    let mut replica = Replica::new(id(name), models(600.0), Formers::default(), None, kept);
    replica.tick(true, at(0));
    assert!(matches!(effects(&mut replica)[..], [Effect::Keep(_)]));
    replica.kept(Ok(()), at(1));
    replica
}

#[test]
fn a_change_is_in_force_once_it_is_written_and_not_at_all_on_a_full_disk() {
    let mut main = kept("main");
    let before = main.state().clone();
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(2));
    let [Effect::Keep(job)] = &effects(&mut main)[..] else {
        panic!()
    };
    assert_eq!(
        (&job.changes, &job.undo),
        (
            &vec![Change::Rig(rig(610.0))],
            &vec![Change::Rig(rig(600.0))]
        )
    );
    assert_eq!(*main.state(), before);
    main.kept(Err("no space left".to_owned()), at(3));
    let refused = effects(&mut main);
    assert!(matches!(
        outcomes(&refused)[..],
        [ChangeOutcome::Refused(Refusal::NotStored { .. })]
    ));
    assert_eq!(*main.state(), before);
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(4));
    effects(&mut main);
    main.kept(Ok(()), at(5));
    main.tick(true, at(5));
    assert_eq!(outcomes(&effects(&mut main)), [&ChangeOutcome::Kept]);
    assert_eq!(main.models().rig, rig(610.0));
}

/// What is in force elsewhere is in force here too, whatever the disk says.
#[test]
fn a_follower_without_a_disk_follows_says_so_and_writes_later() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    for fx in [610.0, 620.0] {
        main.hear(&id("spare"), spare.state(), at(2));
        main.request(asked(vec![Change::Rig(rig(fx))]), at(2));
        effects(&mut main);
        main.kept(Ok(()), at(3));
        spare.hear(&id("main"), main.state(), at(4));
        spare.follow(&id("main"), main.payloads().clone(), at(5));
        spare.tick(false, at(6));
        main.hear(&id("spare"), spare.state(), at(6));
        main.tick(true, at(6));
        assert_eq!(spare.models(), main.models());
        spare.kept(Err("no space left".to_owned()), at(7));
        effects(&mut spare);
        assert!(spare.not_kept().is_some());
    }
    spare.tick(false, at(7 + RETRY_NS));
    let [Effect::Keep(job)] = &effects(&mut spare)[..] else {
        panic!()
    };
    assert_eq!(job.changes, [Change::Rig(rig(620.0))]);
    assert_eq!(job.record.state.version, main.state().version);
    spare.kept(Ok(()), at(8 + RETRY_NS));
    spare.tick(false, at(9 + 2 * RETRY_NS));
    assert_eq!(effects(&mut spare), []);
    assert_eq!(spare.not_kept(), None);
}

#[test]
fn a_change_that_a_newer_one_overtakes_is_refused_and_taken_off_the_disk() {
    let (mut main, mut other) = (kept("main"), replica("other", models(600.0)));
    for n in 0..9 {
        other.request(asked(vec![Change::Rig(rig(700.0 + f64::from(n)))]), at(2));
        other.tick(true, at(2));
    }
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(3));
    effects(&mut main);
    // The network comes back while the change is written.
    main.hear(&id("other"), other.state(), at(4));
    main.follow(&id("other"), other.payloads().clone(), at(5));
    assert_eq!(main.models().rig, rig(600.0));
    main.kept(Ok(()), at(6));
    assert!(matches!(
        outcomes(&effects(&mut main))[..],
        [ChangeOutcome::Refused(_)]
    ));
    main.follow(&id("other"), other.payloads().clone(), at(7));
    main.tick(false, at(8));
    let done = effects(&mut main);
    let [Effect::PutInForce(_), Effect::Keep(job)] = &done[..] else {
        panic!("{done:?}")
    };
    assert_eq!(job.changes.last(), Some(&Change::Rig(rig(708.0))));
    assert_eq!(main.models(), other.models());
}

/// Nodes that publish whenever they may, on a network that loses messages and falls into halves. At every moment a node
/// that knows of newer models does not publish; when the network is whole again all have the same models, those of the
/// newest version.
#[test]
fn replicas_agree_on_the_newest_version_when_they_hear_each_other() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let mut pick = |n: usize| random.below(n);
        let names = ["a", "b", "c"].map(id);
        let mut nodes: Vec<Replica> = (0..3)
            .map(|k| replica(names[k].as_str(), models(600.0 + k as f64)))
            .collect();
        for node in &mut nodes {
            (names.iter()).for_each(|other| node.joined(other.clone(), at(0)));
        }
        let mut newest_heard: Vec<Option<ModelsVersion>> = vec![None; 3];
        let mut halves = 0;
        for step in 1..400_u64 {
            let now = at(step * 50 * MS);
            let is_whole = step >= 300;
            if step % 40 == 0 {
                halves = pick(4);
            }
            let hears =
                |one: usize, other: usize| is_whole || (halves != 1 + one && halves != 1 + other);
            if !is_whole && pick(5) == 0 {
                let k = pick(3);
                let fx = 700.0 + step as f64;
                if nodes[k].is_ready(now) {
                    nodes[k].request(asked(vec![Change::Rig(rig(fx))]), now);
                }
            }
            if step == 120 {
                // One is started anew with old files.
                let k = pick(3);
                nodes[k] = replica(names[k].as_str(), models(650.0));
                // What it alone had is lost.
                newest_heard = nodes
                    .iter()
                    .map(|node| node.state().version.clone())
                    .collect();
                (0..3).for_each(|other| nodes[k].joined(names[other].clone(), now));
            }
            for k in 0..3 {
                for other in (0..3).filter(|other| *other != k) {
                    if hears(k, other) && (is_whole || pick(4) > 0) {
                        let state = nodes[other].state().clone();
                        newest_heard[k] = newest_heard[k].clone().max(state.version.clone());
                        nodes[k].hear(&names[other], &state, now);
                    }
                }
                let publishes = nodes[k].is_current();
                if publishes {
                    assert!(
                        nodes[k].state().version >= newest_heard[k],
                        "seed {seed} step {step}"
                    );
                }
                nodes[k].tick(publishes, now);
                for effect in effects(&mut nodes[k]) {
                    if let Effect::Ask(whom) = effect {
                        let other = names.iter().position(|name| *name == whom).unwrap();
                        if hears(k, other) {
                            let theirs = nodes[other].payloads().clone();
                            nodes[k].follow(&whom, theirs, now);
                        }
                    }
                }
            }
        }
        let states: Vec<&ModelsState> = nodes.iter().map(Replica::state).collect();
        assert!(states[0].version.is_some());
        assert!(
            states.iter().all(|state| state == &states[0]),
            "seed {seed}: {states:?}"
        );
        assert!(
            nodes
                .iter()
                .all(|node| node.models() == nodes[0].models() && node.is_current())
        );
    }
}

/// A standby stood still during a change, and the node that made it has died: what the standby knows of the newer
/// models outlives its process, until a person decides.
#[test]
fn a_node_that_knows_of_newer_models_knows_it_after_a_restart() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(2));
    effects(&mut main);
    main.kept(Ok(()), at(3));
    spare.hear(&id("main"), main.state(), at(4));
    spare.left(&id("main"), at(5));
    for ms in [5, 50, 150, 600] {
        spare.tick(true, at(ms * MS));
        assert_eq!(spare.is_stuck(at(ms * MS)), ms == 600, "{ms}");
    }
    let jobs = effects(&mut spare);
    let [Effect::Keep(job)] = &jobs[..] else {
        panic!("{jobs:?}")
    };
    let newer = (main.state().version.clone().unwrap(), id("main"));
    assert_eq!(job.record.newer, Some(newer));
    assert_eq!(job.record.state, *spare.state());

    let restart = |record: &ModelsRecord| {
        let (record, kept) = (Some(record.clone()), Some(Vec::new()));
        Replica::new(id("spare"), models(600.0), Formers::default(), record, kept)
    };
    let mut anew = restart(&job.record);
    for ms in [0, 600] {
        anew.tick(true, at(ms * MS));
        assert!(!anew.is_current());
    }
    assert!(anew.is_stuck(at(600 * MS)));
    assert_eq!(effects(&mut anew), []);
    // The node with the newer ones is there again.
    let mut follower = restart(&job.record);
    follower.hear(&id("main"), main.state(), at(SECOND_NS));
    follower.follow(&id("main"), main.payloads().clone(), at(SECOND_NS));
    assert!(follower.is_current() && follower.models() == main.models());
    let wrote = {
        follower.tick(false, at(SECOND_NS));
        effects(&mut follower)
    };
    let Some(Effect::Keep(job)) = wrote.last() else {
        panic!("{wrote:?}")
    };
    assert_eq!(job.record.newer, None);
    // A person decides that what there is counts.
    assert!(anew.is_ready(at(SECOND_NS)));
    anew.request(asked(vec![Change::Rig(rig(600.0))]), at(SECOND_NS));
    anew.kept(Ok(()), at(SECOND_NS + 1));
    anew.tick(true, at(3 * SECOND_NS));
    assert!(anew.is_current() && !anew.is_stuck(at(3 * SECOND_NS)));
    assert!(anew.state().version > main.state().version);
    assert!(outcomes(&effects(&mut anew)).contains(&&ChangeOutcome::Kept));
}

/// The network is divided, both halves change something, and it is whole again: whose change is not in force says so,
/// and can bring it back.
#[test]
fn a_change_that_the_other_half_sets_aside_is_reported_and_can_be_brought_back() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    let now = at(SECOND_NS);
    spare.hear(&id("main"), main.state(), now);
    main.hear(&id("spare"), spare.state(), now);
    let change = |replica: &mut Replica, change: Change, s: u64| {
        replica.request(asked(vec![change]), at(s * SECOND_NS));
        replica.kept(Ok(()), at(s * SECOND_NS + 1));
        replica.tick(true, at((s + 2) * SECOND_NS));
        effects(replica);
    };
    change(&mut main, Change::Rig(rig(610.0)), 2);
    for (s, gain) in [(2, 1.5), (5, 2.0)] {
        let settings = CameraSettings {
            gain: Some(gain),
            ..CameraSettings::none("north".parse().unwrap())
        };
        change(&mut spare, Change::Camera(settings), s);
    }
    let healed = at(20 * SECOND_NS);
    main.hear(&id("spare"), spare.state(), healed);
    main.follow(&id("spare"), spare.payloads().clone(), healed);
    assert_eq!(main.models(), spare.models());
    let set_aside = main.set_aside().expect("a change is set aside");
    assert_eq!(set_aside.by, id("spare"));
    assert_eq!(set_aside.changes, [Change::Rig(rig(610.0))]);
    assert!(
        set_aside.detail.contains("camera north"),
        "{}",
        set_aside.detail
    );
    let last = main.formers().last(&id("main")).unwrap();
    assert_eq!(last.rig_config().unwrap(), Some((&rig(610.0)).into()));
    effects(&mut main);
    main.kept(Ok(()), healed);
    assert!(spare.set_aside().is_none());
    // Somebody brings it back, at the node that publishes.
    change(&mut spare, Change::Rig(rig(610.0)), 30);
    let now = at(40 * SECOND_NS);
    main.hear(&id("spare"), spare.state(), now);
    main.follow(&id("spare"), spare.payloads().clone(), now);
    assert_eq!((main.models(), main.set_aside()), (spare.models(), None));
}

/// While the link of a node was lost the others may have changed the models: it publishes nothing by its own until it
/// has heard them.
#[test]
fn a_node_whose_link_is_back_is_not_current_before_it_has_heard_the_others() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    spare.hear(&id("main"), main.state(), at(SECOND_NS));
    spare.link(Link::Down, at(2 * SECOND_NS));
    spare.left(&id("main"), at(2 * SECOND_NS));
    spare.tick(true, at(3 * SECOND_NS));
    assert!(spare.is_current(), "alone it goes on");
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(4 * SECOND_NS));
    effects(&mut main);
    main.kept(Ok(()), at(4 * SECOND_NS));
    spare.link(Link::Up, at(5 * SECOND_NS));
    assert!(!spare.is_current());
    spare.hear(&id("main"), main.state(), at(5 * SECOND_NS + 50 * MS));
    spare.follow(
        &id("main"),
        main.payloads().clone(),
        at(5 * SECOND_NS + 60 * MS),
    );
    spare.tick(true, at(5 * SECOND_NS + 70 * MS));
    assert!(spare.is_current() && spare.models() == main.models());
    // The other one is gone for good.
    let mut lonely = kept("lonely");
    lonely.hear(&id("main"), main.state(), at(SECOND_NS));
    lonely.follow(&id("main"), main.payloads().clone(), at(SECOND_NS));
    lonely.link(Link::Down, at(2 * SECOND_NS));
    lonely.link(Link::Up, at(3 * SECOND_NS));
    lonely.tick(true, at(3 * SECOND_NS));
    assert!(!lonely.is_current());
    lonely.tick(true, at(3 * SECOND_NS + REJOIN_NS));
    assert!(lonely.is_current());
}

/// A change that the others had is not set aside by a later one of theirs.
#[test]
fn a_change_that_was_followed_is_no_change_that_is_set_aside() {
    let (mut main, mut spare) = (kept("main"), kept("spare"));
    main.request(asked(vec![Change::Rig(rig(610.0))]), at(2));
    effects(&mut main);
    main.kept(Ok(()), at(3));
    spare.hear(&id("main"), main.state(), at(4));
    spare.follow(&id("main"), main.payloads().clone(), at(5));
    main.hear(&id("spare"), spare.state(), at(6));
    effects(&mut spare);
    spare.tick(true, at(7));
    effects(&mut spare);
    spare.kept(Ok(()), at(8));
    spare.request(asked(vec![Change::Rig(rig(620.0))]), at(SECOND_NS));
    spare.kept(Ok(()), at(SECOND_NS + 1));
    main.hear(&id("spare"), spare.state(), at(2 * SECOND_NS));
    main.follow(&id("spare"), spare.payloads().clone(), at(2 * SECOND_NS));
    assert_eq!((main.models(), main.set_aside()), (spare.models(), None));
}

#[test]
fn settings_of_cameras_are_followed_too() {
    let (mut main, mut spare) = (
        replica("main", models(600.0)),
        replica("spare", models(600.0)),
    );
    main.tick(true, at(0));
    let settings = CameraSettings {
        gain: Some(2.0),
        ..CameraSettings::none("north".parse().unwrap())
    };
    main.request(asked(vec![Change::Camera(settings.clone())]), at(1));
    spare.hear(&id("main"), main.state(), at(2));
    spare.follow(&id("main"), main.payloads().clone(), at(3));
    assert_eq!(
        spare.models().settings.values().collect::<Vec<_>>(),
        [&settings]
    );
    main.tick(true, at(4));
    main.request(
        asked(vec![Change::Camera(CameraSettings::none(settings.camera))]),
        at(SECOND_NS),
    );
    spare.hear(&id("main"), main.state(), at(SECOND_NS));
    spare.follow(&id("main"), main.payloads().clone(), at(SECOND_NS));
    assert!(spare.models().settings.is_empty());
}
