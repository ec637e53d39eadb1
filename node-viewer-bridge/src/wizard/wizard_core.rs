//! The machine behind the requests of people: the wizard, and changes of the site that need none. Inputs in, outputs
//! out; time is an argument, and it knows no thread, no file and no network.

use super::command::{Command, check_settings};
use super::machine::{CommandContext, Job, Machine};
use super::state::WizardState;
use crate::changes::edit::{self, EditRequest};
use crate::changes::{Answered, Offer, Offers, Outgoing, Publication};
use crate::refusal::Refusal;
use sextant_calibrator::procedure::{Procedure, ProcedureOutcome, Product};
use sextant_proto::{ConfigAnswer, NodeId, Proposal};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{ImageObservation, Rig};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Least time between two published states: as often as a person can follow.
const STATE_PERIOD: Duration = Duration::from_millis(150);

/// What became of a request: a sentence each, or why it is refused.
pub(crate) type Reply = Result<Vec<String>, Refusal>;

/// What a person asks for.
#[derive(Debug)]
pub(crate) enum UserRequest {
    /// A command to the wizard, or an offer to be put in force.
    Command(Command),
    /// An edit of a camera or an object.
    Edit(EditRequest),
}

/// A request, with the site as it was heard when it came.
#[derive(Debug)]
pub(super) struct RequestInput {
    pub request: UserRequest,
    pub site: SiteMirror,
    /// The rig in force, or else that of the site's folder; needed to start a wizard only.
    pub rig: Rig,
}

/// What happens to the machine.
#[derive(Debug)]
pub(super) enum Input {
    /// A person asks for something; the reply has the same number.
    Request(u64, Box<RequestInput>),
    /// A camera has seen something.
    Image(ImageObservation),
    /// So many images found no room in the queue.
    Missed(u64),
    /// A fusion node has answered a change.
    Answer(ConfigAnswer),
    /// What a fusion node offers to be put in force.
    Offer(Offer, Box<Proposal>),
    /// A fusion node is gone.
    NodeLeft(NodeId),
    /// An [`Output::Publish`] is on the network.
    Published,
    /// An [`Output::Solve`] of this number has ended.
    Solved(u64, Result<Box<ProcedureOutcome>, String>),
    /// An [`Output::Write`] is done: a sentence each.
    Written(Result<String, String>),
    /// Time has passed.
    Tick,
}

/// What the machine wants done elsewhere.
#[derive(Debug)]
pub(super) enum Output {
    /// Answer the request of this number.
    Reply(u64, Reply),
    /// Put this on the network, then [`Input::Published`].
    Publish(Outgoing),
    /// Solve, then [`Input::Solved`] with this number.
    Solve(u64, Box<Procedure>),
    /// Write it into a file of the site's folder, then [`Input::Written`].
    Write(Product),
    /// Show this to all clients.
    Show(Box<WizardState>),
}

/// An edit that no fusion node has answered yet.
#[derive(Debug)]
struct PendingEdit {
    number: u64,
    outgoing: Outgoing,
    publication: Publication,
}

/// The machine.
#[derive(Debug)]
pub(super) struct WizardCore {
    wizard: Machine,
    /// Whether results have a folder to go to.
    has_folder: bool,
    offers: Offers,
    edit: Option<PendingEdit>,
    /// Changes that are not on the network yet.
    n_unpublished: usize,
    /// Images that a wizard missed.
    missed: u64,
    state_due: Instant,
    outputs: VecDeque<Output>,
}

impl WizardCore {
    /// Without a wizard at work; shows that.
    pub(super) fn new(has_folder: bool, now: Instant) -> Self {
        Self {
            wizard: Machine::default(),
            has_folder,
            offers: Offers::default(),
            edit: None,
            n_unpublished: 0,
            missed: 0,
            state_due: now,
            outputs: VecDeque::from([Output::Show(Box::new(WizardState::idle()))]),
        }
    }

    /// Handles an input.
    pub(super) fn handle(&mut self, input: Input, now: Instant) {
        match input {
            Input::Request(number, input) => self.request(number, &input, now),
            Input::Image(image) => self.wizard.image(&image),
            Input::Missed(n_images) => self.missed += n_images,
            Input::Answer(answer) => self.answered(&answer),
            Input::Offer(offer, proposal) => self.offers.take(offer, *proposal),
            Input::NodeLeft(node) => self.offers.forget(&node),
            Input::Published => self.n_unpublished = self.n_unpublished.saturating_sub(1),
            Input::Solved(number, result) => {
                self.wizard.solved(number, result.map(|outcome| *outcome));
            }
            Input::Written(result) => self.wizard.written(result),
            Input::Tick => {}
        }
        self.wizard.tick(now, self.has_folder);
        self.finish_edit(now);
        self.collect_outputs(now);
    }

    /// The next thing to be done elsewhere.
    pub(super) fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When [`Input::Tick`] is due at the latest.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let edit = self.edit.as_ref().map(|edit| edit.publication.due());
        let state = self.wizard.is_news().then_some(self.state_due);
        [edit, state, self.wizard.due()].into_iter().flatten().min()
    }

    /// Whether images are wanted.
    pub(super) fn is_collecting(&self) -> bool {
        self.wizard.is_collecting()
    }

    fn request(&mut self, number: u64, input: &RequestInput, now: Instant) {
        let reply = match &input.request {
            UserRequest::Command(command) => self.command(command, input, now),
            UserRequest::Edit(edit) => match self.begin_edit(number, edit, &input.site, now) {
                // A fusion node decides.
                Ok(()) => return,
                Err(refusal) => Err(refusal),
            },
        };
        let reply = reply.map(|()| Vec::new());
        self.outputs.push_back(Output::Reply(number, reply));
    }

    fn command(
        &mut self,
        command: &Command,
        input: &RequestInput,
        now: Instant,
    ) -> Result<(), Refusal> {
        let site = CommandContext {
            mirror: &input.site,
            rig: &input.rig,
            has_folder: self.has_folder,
        };
        match command {
            Command::ApplyRefinement { node } => self.accept(node, Offer::Refinement),
            Command::Revert { node } => self.accept(node, Offer::Former),
            Command::SetCamera(settings) => {
                check_settings(settings)?;
                self.publish_alone(Outgoing::Camera(settings.clone()))
            }
            Command::Start(start) => {
                self.missed = 0;
                self.wizard.start(start, &site)
            }
            Command::Solve => self.wizard.solve(),
            Command::Resume => self.wizard.resume(),
            Command::Keep => self.wizard.keep(&site, now),
            Command::Discard => self.wizard.discard(),
        }
    }

    /// Publishes what a fusion node offers; the node's status shows the outcome.
    fn accept(&mut self, node: &NodeId, offer: Offer) -> Result<(), Refusal> {
        let change = self.offers.change(node, offer)?;
        self.publish_alone(change)
    }

    fn begin_edit(
        &mut self,
        number: u64,
        request: &EditRequest,
        site: &SiteMirror,
        now: Instant,
    ) -> Result<(), Refusal> {
        if self.edit.is_some() {
            return Err(Refusal::not_now(
                "another edit is under way; try again in a moment",
            ));
        }
        let outgoing = edit::change(request, site)?;
        let publication = Publication::new(&outgoing, now).map_err(Refusal::not_now)?;
        self.publish_alone(outgoing.clone())?;
        self.edit = Some(PendingEdit {
            number,
            outgoing,
            publication,
        });
        Ok(())
    }

    fn answered(&mut self, answer: &ConfigAnswer) {
        self.wizard.answered(answer);
        if let Some(edit) = &mut self.edit {
            edit.publication.take(answer);
        }
    }

    /// Replies to an edit once a fusion node has answered it, or has had its time.
    fn finish_edit(&mut self, now: Instant) {
        let Some(edit) = &mut self.edit else {
            return;
        };
        let is_repeated = edit.publication.take_repeat(now);
        let repeated = is_repeated.then(|| edit.outgoing.clone());
        let reply = match edit.publication.answered(now) {
            Answered::NotYet => None,
            Answered::Refused(refusal) => Some(Err(refusal)),
            Answered::Done(said) => Some(Ok(said)),
            Answered::Silence(said) => Some(Err(Refusal::not_now(said))),
        };
        let number = edit.number;
        if let Some(outgoing) = repeated {
            self.publish(outgoing);
        }
        if let Some(reply) = reply {
            self.edit = None;
            self.outputs.push_back(Output::Reply(number, reply));
        }
    }

    /// One change after the other, so that the second is of what the first has made.
    fn publish_alone(&mut self, outgoing: Outgoing) -> Result<(), Refusal> {
        if self.n_unpublished > 0 {
            return Err(Refusal::not_now(
                "a change is under way; try again in a moment",
            ));
        }
        self.publish(outgoing);
        Ok(())
    }

    fn publish(&mut self, outgoing: Outgoing) {
        self.n_unpublished += 1;
        self.outputs.push_back(Output::Publish(outgoing));
    }

    fn collect_outputs(&mut self, now: Instant) {
        for job in self.wizard.take_jobs() {
            match job {
                Job::Solve(number, procedure) => {
                    self.outputs.push_back(Output::Solve(number, procedure));
                }
                Job::Publish(outgoing) => self.publish(outgoing),
                Job::Write(product) => self.outputs.push_back(Output::Write(product)),
            }
        }
        if now >= self.state_due && self.wizard.take_news() {
            self.state_due = now + STATE_PERIOD;
            let state = self.wizard.state(self.missed);
            self.outputs.push_back(Output::Show(Box::new(state)));
        }
    }
}

#[cfg(test)]
mod tests;
