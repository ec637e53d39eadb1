//! One wizard at a time, from start to a kept result: a state machine without thread, file or network. Time is an
//! argument.

use super::command::Start;
use super::plan::{plan, subject};
use super::state::WizardState;
use crate::changes::{Answered, Outgoing, Publication};
use crate::refusal::Refusal;
use sextant_calibrator::procedure::{Procedure, ProcedureOutcome, Product};
use sextant_proto::{ConfigAnswer, NodeKind, ObjectConfig, RigConfig};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{ImageObservation, Rig};
use std::time::Instant;

/// What the machine wants done elsewhere.
#[derive(Debug)]
pub(super) enum Job {
    /// Solve, and report by [`Machine::solved`] with the number.
    Solve(u64, Box<Procedure>),
    /// Put this on the network; answers come by [`Machine::answered`].
    Publish(Outgoing),
    /// Write it into a file of the site's folder and report by [`Machine::written`].
    Write(Product),
}

/// The machine.
#[derive(Debug, Default)]
pub(super) struct Machine {
    running: Option<Running>,
    /// Counts solves, so that one that was given up is recognised when it ends after all.
    solves: u64,
    /// Whether a solve is at work, given up or not.
    is_solver_busy: bool,
    jobs: Vec<Job>,
    is_news: bool,
}

#[derive(Debug)]
struct Running {
    procedure: Procedure,
    subject: String,
    /// What went wrong last.
    cause: Option<String>,
    phase: Phase,
}

#[derive(Debug)]
enum Phase {
    Collecting,
    Solving(u64),
    Solved(ProcedureOutcome),
    Keeping(ProcedureOutcome, Option<Publication>, Vec<String>),
    Kept(ProcedureOutcome, Vec<String>),
}

/// What a command has to be judged by.
pub(super) struct CommandContext<'a> {
    pub mirror: &'a SiteMirror,
    /// The rig in force, or else that of the site's folder; needed to start only.
    pub rig: &'a Rig,
    /// Whether results have a folder to go to.
    pub has_folder: bool,
}

impl Machine {
    /// Begins; refused while another wizard runs.
    pub(super) fn start(
        &mut self,
        request: &Start,
        site: &CommandContext<'_>,
    ) -> Result<(), Refusal> {
        if let Some(running) = &self.running
            && !matches!(running.phase, Phase::Kept(..))
        {
            let subject = &running.subject;
            return Err(Refusal::not_now(format!(
                "another wizard is at work ({subject}): finish it or discard it first"
            )));
        }
        let plan = plan(request, site.mirror, site.rig)?;
        let subject = subject(&plan);
        let procedure = Procedure::start(site.rig.clone(), plan)
            .map_err(|error| Refusal::wrong(field_of(request), error))?;
        self.is_news = true;
        self.running = Some(Running {
            procedure,
            subject,
            cause: None,
            phase: Phase::Collecting,
        });
        Ok(())
    }

    /// Solves with the images that are there.
    pub(super) fn solve(&mut self) -> Result<(), Refusal> {
        let is_busy = self.is_solver_busy;
        let running = self.running_in(|phase| matches!(phase, Phase::Collecting), "to solve")?;
        if is_busy {
            return Err(Refusal::not_now(
                "the solve that was given up is still at work; try again in a moment",
            ));
        }
        let procedure = Box::new(running.procedure.clone());
        running.cause = None;
        self.solves += 1;
        self.is_solver_busy = true;
        self.jobs.push(Job::Solve(self.solves, procedure));
        self.go(Phase::Solving(self.solves));
        Ok(())
    }

    /// Goes on collecting.
    pub(super) fn resume(&mut self) -> Result<(), Refusal> {
        let may = |phase: &Phase| matches!(phase, Phase::Solving(_) | Phase::Solved(_));
        let running = self.running_in(may, "to go on with")?;
        running.cause = None;
        self.go(Phase::Collecting);
        Ok(())
    }

    /// Keeps the result: in force on the site, and in its folder.
    pub(super) fn keep(&mut self, site: &CommandContext<'_>, now: Instant) -> Result<(), Refusal> {
        let has_fusion = site.mirror.alive(NodeKind::Fusion).next().is_some();
        let running = self.running_in(|phase| matches!(phase, Phase::Solved(_)), "to keep")?;
        let Phase::Solved(outcome) = &running.phase else {
            return Ok(());
        };
        if !has_fusion && !site.has_folder {
            return Err(Refusal::not_now(
                "there is nowhere to keep it: no fusion node lives, and viewer.toml names no \
                 `folder`; download the file",
            ));
        }
        let (outcome, publication) = if !has_fusion {
            (outcome.clone(), None)
        } else {
            let message = message_of(&outcome.product);
            let publication = Publication::new(&message, now).map_err(Refusal::not_now)?;
            let outcome = outcome.clone();
            self.jobs.push(Job::Publish(message));
            (outcome, Some(publication))
        };
        self.go(Phase::Keeping(outcome, publication, Vec::new()));
        self.proceed(now, site.has_folder);
        Ok(())
    }

    /// Gives up, or puts a finished wizard away.
    pub(super) fn discard(&mut self) -> Result<(), Refusal> {
        let is_keeping = |running: &Running| matches!(running.phase, Phase::Keeping(..));
        if self.running.as_ref().is_some_and(is_keeping) {
            return Err(Refusal::not_now("the result is being kept this moment"));
        }
        self.running = None;
        self.is_news = true;
        Ok(())
    }

    /// The wizard, if it is in a phase that allows what is requested.
    fn running_in(
        &mut self,
        may: impl Fn(&Phase) -> bool,
        what_for: &str,
    ) -> Result<&mut Running, Refusal> {
        let running = self.running.as_mut().filter(|running| may(&running.phase));
        running.ok_or_else(|| Refusal::not_now(format!("there is nothing {what_for} now")))
    }

    fn go(&mut self, phase: Phase) {
        self.is_news = true;
        if let Some(running) = &mut self.running {
            running.phase = phase;
        }
    }

    /// Whether images are wanted.
    pub(super) fn is_collecting(&self) -> bool {
        let collects = |running: &Running| matches!(running.phase, Phase::Collecting);
        self.running.as_ref().is_some_and(collects)
    }

    /// Takes an image in, if it counts.
    pub(super) fn image(&mut self, image: &ImageObservation) {
        let Some(running) = &mut self.running else {
            return;
        };
        if !matches!(running.phase, Phase::Collecting) || !running.procedure.counts(&image.camera) {
            return;
        }
        if let Err(cause) = running.procedure.handle(image) {
            running.cause = Some(cause.to_string());
        }
        self.is_news = true;
    }

    /// A solve has ended. After a failure its cause is shown and images are collected further.
    pub(super) fn solved(&mut self, number: u64, result: Result<ProcedureOutcome, String>) {
        self.is_solver_busy = false;
        let is_waited_for =
            |running: &Running| matches!(running.phase, Phase::Solving(waited) if waited == number);
        let Some(running) = self
            .running
            .as_mut()
            .filter(|running| is_waited_for(running))
        else {
            return;
        };
        let phase = match result {
            Ok(outcome) => Phase::Solved(outcome),
            Err(cause) => {
                running.cause = Some(cause);
                Phase::Collecting
            }
        };
        self.go(phase);
    }

    /// A fusion node has answered a change.
    pub(super) fn answered(&mut self, answer: &ConfigAnswer) {
        if let Some(Running {
            phase: Phase::Keeping(_, Some(publication), _),
            ..
        }) = &mut self.running
        {
            publication.take(answer);
        }
    }

    /// Time passes: goes on with keeping when the site has answered, or has had its time.
    pub(super) fn tick(&mut self, now: Instant, has_folder: bool) {
        let is_published =
            |running: &Running| matches!(running.phase, Phase::Keeping(_, Some(_), _));
        if self.running.as_ref().is_some_and(is_published) {
            self.proceed(now, has_folder);
        }
    }

    /// From published to written to kept.
    fn proceed(&mut self, now: Instant, has_folder: bool) {
        let Some(running) = &mut self.running else {
            return;
        };
        let Phase::Keeping(outcome, publication, words) = &mut running.phase else {
            return;
        };
        match publication.as_ref().map(|waiting| waiting.answered(now)) {
            Some(Answered::NotYet) => return,
            Some(Answered::Refused(refusal)) => {
                running.cause = Some(refusal.cause);
                let outcome = outcome.clone();
                return self.go(Phase::Solved(outcome));
            }
            Some(Answered::Done(said)) => words.extend(said),
            Some(Answered::Silence(said)) => words.push(said),
            None => words.push(
                "no fusion node lives: it is in force when one starts with this file".to_owned(),
            ),
        }
        *publication = None;
        if has_folder {
            self.jobs.push(Job::Write(outcome.product.clone()));
        } else {
            let (outcome, words) = (outcome.clone(), std::mem::take(words));
            self.go(Phase::Kept(outcome, words));
        }
    }

    /// The file is written, or is not: a sentence each.
    pub(super) fn written(&mut self, result: Result<String, String>) {
        let Some(running) = &mut self.running else {
            return;
        };
        let Phase::Keeping(outcome, None, words) = &mut running.phase else {
            return;
        };
        let (outcome, mut words) = (outcome.clone(), std::mem::take(words));
        match result {
            Ok(sentence) => words.push(sentence),
            Err(cause) => running.cause = Some(cause),
        }
        self.go(Phase::Kept(outcome, words));
    }

    /// What there is to do, once.
    pub(super) fn take_jobs(&mut self) -> Vec<Job> {
        std::mem::take(&mut self.jobs)
    }

    /// When time changes something at the latest.
    pub(super) fn due(&self) -> Option<Instant> {
        match &self.running.as_ref()?.phase {
            Phase::Keeping(_, Some(publication), _) => Some(publication.due()),
            _ => None,
        }
    }

    /// Whether the state has changed since it was last published.
    pub(super) fn is_news(&self) -> bool {
        self.is_news
    }

    /// The same, once.
    pub(super) fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.is_news)
    }

    /// The state for the clients.
    pub(super) fn state(&self, missed: u64) -> WizardState {
        let Some(running) = &self.running else {
            return WizardState::idle();
        };
        let state = WizardState::starting(
            running.procedure.kind(),
            &running.subject,
            running.cause.as_deref(),
        );
        match &running.phase {
            Phase::Collecting => state.collecting(running.procedure.progress(), missed),
            Phase::Solving(_) => state.solving(running.procedure.progress()),
            Phase::Solved(outcome) => state.solved("solved", outcome, &[]),
            Phase::Keeping(outcome, ..) => state.solved("keeping", outcome, &[]),
            Phase::Kept(outcome, words) => state.solved("kept", outcome, words),
        }
    }
}

/// The message that puts a result into force.
fn message_of(product: &Product) -> Outgoing {
    match product {
        Product::Rig(rig) => Outgoing::Rig(RigConfig::from(rig)),
        Product::Object(object) => Outgoing::Object(ObjectConfig::from(object)),
    }
}

/// The field that a plan's complaint is about, as far as the request tells.
fn field_of(request: &Start) -> &'static str {
    match request {
        Start::Lens { .. } => "board",
        Start::Rig { .. } => "object",
        Start::Learn { .. } => "tags",
    }
}

#[cfg(test)]
mod tests;
