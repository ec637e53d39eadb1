//! Requests, answers and offers, in time that the test makes.

use super::*;
use crate::wizard::samples;
use sextant_proto::{
    ChangeOutcome as Answer, ModelPayload, NodeKind, ObjectConfig, Refusal as Cause, RigConfig,
    encode, fingerprint,
};

struct Bench {
    core: WizardCore,
    site: SiteMirror,
    now: Instant,
    n_requests: u64,
}

fn node() -> NodeId {
    NodeId::new("main").unwrap()
}

impl Bench {
    fn new() -> Self {
        let mut site = samples::mirror();
        site.handle_joined(1, NodeKind::Fusion, &node()).unwrap();
        let now = Instant::now();
        Self {
            core: WizardCore::new(false, now),
            site,
            now,
            n_requests: 0,
        }
    }

    fn handle(&mut self, input: Input) -> Vec<Output> {
        self.core.handle(input, self.now);
        std::iter::from_fn(|| self.core.poll_output()).collect()
    }

    fn pass(&mut self, time: Duration) -> Vec<Output> {
        self.now += time;
        self.handle(Input::Tick)
    }

    fn request(&mut self, request: UserRequest) -> Vec<Output> {
        self.n_requests += 1;
        let input = RequestInput {
            request,
            site: self.site.clone(),
            rig: samples::rig(),
        };
        self.handle(Input::Request(self.n_requests, Box::new(input)))
    }

    fn command(&mut self, text: &str) -> Vec<Output> {
        let command = Command::parse(text.as_bytes()).unwrap();
        self.request(UserRequest::Command(command))
    }

    /// Removes the cube by an edit; the fingerprint of what is published.
    fn remove_cube(&mut self) -> (Vec<Output>, u64) {
        let cube = self.site.configs().next().unwrap();
        let version = edit::version_of(cube);
        let payload = encode(&ObjectConfig::removal(cube.id.clone())).unwrap();
        let text = format!(r#"{{"do":"remove_object","id":"cube","version":"{version}"}}"#);
        let edit = EditRequest::parse(text.as_bytes()).unwrap();
        (self.request(UserRequest::Edit(edit)), fingerprint(&payload))
    }

    fn answer(&mut self, fingerprint: u64, outcome: Answer) -> Vec<Output> {
        self.handle(Input::Answer(ConfigAnswer {
            node: node(),
            key: "config/object/cube".to_owned(),
            fingerprint,
            outcome,
            followers: vec![],
            behind: vec![],
        }))
    }
}

fn replies(outputs: &[Output]) -> Vec<(u64, Reply)> {
    let reply = |output: &Output| match output {
        Output::Reply(number, reply) => Some((*number, reply.clone())),
        _ => None,
    };
    outputs.iter().filter_map(reply).collect()
}

fn n_published(outputs: &[Output]) -> usize {
    let is_change = |output: &&Output| matches!(output, Output::Publish(_));
    outputs.iter().filter(is_change).count()
}

#[test]
fn an_edit_is_answered_when_a_fusion_node_has_decided() {
    let mut bench = Bench::new();
    let (outputs, fingerprint) = bench.remove_cube();
    assert_eq!((replies(&outputs).len(), n_published(&outputs)), (0, 1));
    bench.handle(Input::Published);
    let other = bench.answer(fingerprint + 1, Answer::Kept);
    assert!(replies(&other).is_empty());
    let done = replies(&bench.answer(fingerprint, Answer::Kept));
    assert!(matches!(&done[..], [(1, Ok(said))] if said[0].contains("keeps it in its files")));

    let (_, fingerprint) = bench.remove_cube();
    bench.handle(Input::Published);
    let refused = replies(&bench.answer(fingerprint, Answer::Refused(Cause::NoCamera)));
    assert!(matches!(&refused[..], [(2, Err(refusal))] if refusal.cause.contains("no camera")));
}

#[test]
fn an_edit_without_an_answer_is_repeated_once_and_then_given_up() {
    let mut bench = Bench::new();
    bench.remove_cube();
    bench.handle(Input::Published);
    let due = bench.core.poll_timeout().unwrap();
    assert!(due > bench.now);
    assert_eq!(n_published(&bench.pass(Duration::from_secs(2))), 1);
    assert_eq!(n_published(&bench.pass(Duration::from_secs(2))), 0);
    let (busy, _) = bench.remove_cube();
    assert!(replies(&busy)[0].1.is_err());
    let given_up = replies(&bench.pass(Duration::from_secs(60)));
    assert!(
        matches!(&given_up[..], [(1, Err(refusal))] if refusal.cause.contains("no fusion node"))
    );
}

#[test]
fn one_change_goes_to_the_network_after_the_other() {
    let mut bench = Bench::new();
    let gain = r#"{"do":"set_camera","camera":"a","gain":2.0}"#;
    let first = bench.command(gain);
    assert_eq!(n_published(&first), 1);
    let second = bench.command(gain);
    let (_, busy) = &replies(&second)[0];
    assert!(busy.as_ref().unwrap_err().cause.contains("under way"));
    bench.handle(Input::Published);
    assert_eq!(n_published(&bench.command(gain)), 1);
}

#[test]
fn an_offer_is_applied_until_its_node_has_gone() {
    let mut bench = Bench::new();
    let apply = r#"{"do":"apply_refinement","node":"main"}"#;
    assert!(replies(&bench.command(apply))[0].1.is_err());
    let rig = RigConfig::from(&samples::rig());
    let proposal = Proposal {
        rig: Some(ModelPayload::encode(&rig).unwrap()),
        ..Proposal::none(node(), 7)
    };
    bench.handle(Input::Offer(Offer::Refinement, Box::new(proposal)));
    let outputs = bench.command(apply);
    let by_number = |output: &Output| match output {
        Output::Publish(Outgoing::Models(named)) => named.is_empty() && named.t_ns == 7,
        _ => false,
    };
    assert!(outputs.iter().any(by_number), "{outputs:?}");
    bench.handle(Input::Published);
    bench.handle(Input::NodeLeft(node()));
    assert!(replies(&bench.command(apply))[0].1.is_err());
}

#[test]
fn the_state_is_shown_at_the_start_and_no_oftener_than_people_can_follow() {
    let mut bench = Bench::new();
    let shown = |outputs: Vec<Output>| {
        let is_state = |output: &Output| matches!(output, Output::Show(_));
        outputs.iter().any(is_state)
    };
    assert!(shown(bench.handle(Input::Tick)));
    let start = r#"{"do":"start","wizard":"lens","camera":"a",
        "board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;
    assert!(shown(bench.command(start)));
    assert!(bench.core.is_collecting());
    let image = || Input::Image(samples::image(1));
    assert!(!shown(bench.handle(image())));
    assert!(bench.core.poll_timeout().is_some());
    assert!(shown(bench.pass(STATE_PERIOD)));
}

#[test]
fn missed_images_are_counted_from_the_start_of_a_wizard_on() {
    let mut bench = Bench::new();
    let start = r#"{"do":"start","wizard":"lens","camera":"a",
        "board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;
    bench.handle(Input::Missed(3));
    bench.command(start);
    bench.handle(Input::Missed(7));
    let state = serde_json::to_value(bench.core.wizard.state(bench.core.missed)).unwrap();
    assert_eq!(state["missed"], 7);
}
