//! The way of a wizard, with its wrong turns.

use super::*;
use crate::wizard::command::Command;
use crate::wizard::samples;
use sextant_proto::{ChangeOutcome as Answer, NodeId, ObjectConfig, Refusal, encode, fingerprint};
use std::time::Duration;

const LEARN: &str = r#"{"do":"start","wizard":"learn","id":"cube","cameras":["a"],"tags":[
    {"id":0,"size_m":0.04},{"id":1,"size_m":0.04},{"id":2,"size_m":0.04},
    {"id":3,"size_m":0.04},{"id":4,"size_m":0.04},{"id":5,"size_m":0.04}]}"#;

/// A machine on the sample site.
struct Bench {
    machine: Machine,
    mirror: SiteMirror,
    rig: Rig,
    has_folder: bool,
    now: Instant,
}

impl Bench {
    fn new(nodes: &[&str], has_folder: bool) -> Self {
        let mut mirror = samples::mirror();
        for node in nodes {
            let node = NodeId::new(node).unwrap();
            mirror.handle_joined(1, NodeKind::Fusion, &node).unwrap();
        }
        Self {
            machine: Machine::default(),
            mirror,
            rig: samples::rig(),
            has_folder,
            now: Instant::now(),
        }
    }

    fn obey(&mut self, command: &str) -> Result<(), String> {
        let site = CommandContext {
            mirror: &self.mirror,
            rig: &self.rig,
            has_folder: self.has_folder,
        };
        let answer = match Command::parse(command.as_bytes()).unwrap() {
            Command::Start(start) => self.machine.start(&start, &site),
            Command::Solve => self.machine.solve(),
            Command::Resume => self.machine.resume(),
            Command::Keep => self.machine.keep(&site, self.now),
            Command::Discard => self.machine.discard(),
            other => panic!("no command to the wizard: {other:?}"),
        };
        answer.map_err(|refusal| refusal.cause)
    }

    fn say(&mut self, word: &str) -> Result<(), String> {
        self.obey(&format!(r#"{{"do":"{word}"}}"#))
    }

    fn state(&self) -> serde_json::Value {
        serde_json::to_value(self.machine.state(0)).unwrap()
    }

    fn stage(&self) -> String {
        self.state()["stage"].as_str().unwrap().to_owned()
    }

    /// Learns the cube from these many images, up to the solve that is to be done.
    fn begin(&mut self, images: u64) -> (u64, Box<Procedure>) {
        self.obey(LEARN).unwrap();
        (0..images).for_each(|step| self.machine.image(&samples::image(step)));
        self.say("solve").unwrap();
        self.solve_job()
    }

    fn solve_job(&mut self) -> (u64, Box<Procedure>) {
        match self.machine.take_jobs().pop() {
            Some(Job::Solve(number, procedure)) => (number, procedure),
            other => panic!("no solve but {other:?}"),
        }
    }

    /// Up to a result.
    fn solved(nodes: &[&str], has_folder: bool) -> Self {
        let mut bench = Self::new(nodes, has_folder);
        let (number, procedure) = bench.begin(60);
        bench.machine.solved(number, Ok(procedure.solve().unwrap()));
        assert_eq!(bench.stage(), "solved");
        bench
    }

    /// A node's answer to the published object.
    fn answer(&mut self, node: &str, outcome: Answer) {
        let Some(Running {
            phase: Phase::Keeping(found, ..),
            ..
        }) = &self.machine.running
        else {
            panic!("nothing is being kept");
        };
        let Product::Object(object) = &found.product else {
            panic!("no object");
        };
        let payload = encode(&ObjectConfig::from(object)).unwrap();
        let answer = ConfigAnswer {
            node: NodeId::new(node).unwrap(),
            key: "config/object/cube".to_owned(),
            fingerprint: fingerprint(&payload),
            outcome,
            followers: vec![],
            behind: vec![],
        };
        self.machine.answered(&answer);
        self.machine.tick(self.now, self.has_folder);
    }
}

#[test]
fn a_wizard_goes_from_start_to_a_kept_result() {
    let mut bench = Bench::solved(&["main"], true);
    assert_eq!(
        bench.state()["result"]["report"]["verdict"]["grade"],
        "good"
    );
    assert_eq!(bench.state()["result"]["file"], "cube.toml");
    bench.say("keep").unwrap();
    assert!(matches!(bench.machine.take_jobs()[..], [Job::Publish(_)]));
    assert_eq!(bench.stage(), "keeping");
    bench.answer("main", Answer::Kept);
    let jobs = bench.machine.take_jobs();
    assert!(
        matches!(&jobs[..], [Job::Write(Product::Object(cube))] if cube.id().as_str() == "cube")
    );
    bench.machine.written(Ok("written".to_owned()));
    assert_eq!(bench.stage(), "kept");
    assert_eq!(bench.state()["result"]["kept"].as_array().unwrap().len(), 2);
    bench.say("discard").unwrap();
    assert_eq!(bench.stage(), "idle");
}

#[test]
fn one_wizard_is_at_work_at_a_time() {
    let mut bench = Bench::new(&[], true);
    bench.obey(LEARN).unwrap();
    let refused = bench.obey(LEARN).unwrap_err();
    assert!(
        refused.contains("another wizard is at work (cube)"),
        "{refused}"
    );
    bench.say("discard").unwrap();
    bench.obey(LEARN).unwrap();
}

#[test]
fn what_cannot_be_solved_is_said_and_collecting_goes_on() {
    let mut bench = Bench::new(&[], true);
    let (number, procedure) = bench.begin(0);
    let cause = procedure.solve().unwrap_err().to_string();
    bench.machine.solved(number, Err(cause.clone()));
    assert_eq!(
        (bench.stage().as_str(), &bench.state()["cause"]),
        ("collecting", &cause.into())
    );
    assert!(bench.machine.is_collecting());
    bench.machine.image(&samples::image(0));
    assert_eq!(bench.state()["progress"]["images"], 1);
}

#[test]
fn a_solve_that_was_given_up_changes_nothing_when_it_ends() {
    let mut bench = Bench::new(&[], true);
    let (number, procedure) = bench.begin(60);
    bench.say("resume").unwrap();
    assert_eq!(bench.stage(), "collecting");
    let refused = bench.say("solve").unwrap_err();
    assert!(refused.contains("still at work"), "{refused}");
    bench.machine.solved(number, Ok(procedure.solve().unwrap()));
    assert_eq!(bench.stage(), "collecting");
    bench.say("solve").unwrap();
    assert_ne!(bench.solve_job().0, number);
    bench.say("discard").unwrap();
    assert_eq!(bench.stage(), "idle");
}

#[test]
fn a_refused_result_is_kept_nowhere() {
    let mut bench = Bench::solved(&["main"], true);
    bench.say("keep").unwrap();
    bench.machine.take_jobs();
    bench.answer("main", Answer::Refused(Refusal::NoCamera));
    assert_eq!(bench.stage(), "solved");
    let cause = bench.state()["cause"].to_string();
    assert!(
        cause.contains("main refused it: the rig has no camera"),
        "{cause}"
    );
    assert!(bench.machine.take_jobs().is_empty());
    bench.say("keep").unwrap();
}

#[test]
fn silence_is_said_and_does_not_keep_the_file_from_being_written() {
    let mut bench = Bench::solved(&["main"], true);
    bench.say("keep").unwrap();
    bench.machine.take_jobs();
    assert_eq!(bench.stage(), "keeping");
    bench
        .machine
        .tick(bench.now + Duration::from_secs(20), true);
    assert!(matches!(bench.machine.take_jobs()[..], [Job::Write(_)]));
    bench.machine.written(Err("the disk is full".to_owned()));
    let state = bench.state();
    assert!(
        state["result"]["kept"]
            .to_string()
            .contains("no fusion node has answered"),
        "{state}"
    );
    assert_eq!(state["cause"], "the disk is full");
}

#[test]
fn without_folder_and_without_node_there_is_nowhere_to_keep() {
    let mut bench = Bench::solved(&[], false);
    let refused = bench.say("keep").unwrap_err();
    assert!(refused.contains("nowhere to keep"), "{refused}");
    assert_eq!(bench.stage(), "solved");
}

#[test]
fn a_command_out_of_turn_is_refused() {
    let mut bench = Bench::new(&["main"], true);
    for word in ["solve", "resume", "keep"] {
        assert!(bench.say(word).unwrap_err().contains("nothing"), "{word}");
    }
    bench.obey(LEARN).unwrap();
    for word in ["resume", "keep"] {
        assert!(bench.say(word).is_err(), "{word}");
    }
    bench.machine.written(Ok(String::new()));
    bench.machine.solved(7, Err(String::new()));
    assert_eq!(bench.stage(), "collecting");
}

#[test]
fn images_of_cameras_that_do_not_count_are_passed_over() {
    let mut bench = Bench::new(&[], true);
    bench.machine.image(&samples::image(0));
    bench.obey(LEARN).unwrap();
    let mut foreign = samples::image(0);
    foreign.camera = "b".parse().unwrap();
    bench.machine.image(&foreign);
    assert_eq!(bench.state()["progress"]["images"], 0);
}
