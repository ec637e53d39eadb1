//! The interface of the wizards: takes commands, images and answers, and hands jobs to the wizard's thread.
//!
//! The network's threads only lock the answers and offers: neither lock is held while a file is read, an image is evaluated or a command is
//! executed.

use super::command::{Command, check_settings};
use super::machine::{Job, Machine, Site};
use super::state::WizardState;
use crate::changes::edit::{self, EditRequest};
use crate::changes::{Answered, Offer, Offers, Outgoing, Publication};
use crate::refusal::Refusal;
use sextant_calibrator::procedure::Outcome;
use sextant_proto::{ConfigAnswer, NodeId, Proposal};
use sextant_site_files::read_rig;
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{ImageObservation, Rig};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tokio::sync::oneshot;

/// Images that wait for the wizard's thread; further ones are missed, and counted.
const QUEUE: usize = 256;
/// Answers that wait for it; the oldest give way.
const MOST_ANSWERS: usize = 256;

/// What became of an edit: a sentence for each fusion node, or why nothing has changed.
pub(crate) type EditAnswer = Result<Vec<String>, Refusal>;

/// An edit on its way, and who waits for its answer.
#[derive(Debug)]
struct PendingEdit {
    outgoing: Outgoing,
    publication: Publication,
    reply: oneshot::Sender<EditAnswer>,
}

/// One for the whole bridge.
#[derive(Debug)]
pub(crate) struct WizardService {
    machine: Mutex<Machine>,
    answers: Mutex<VecDeque<ConfigAnswer>>,
    /// Where results are kept.
    folder: Option<PathBuf>,
    images: SyncSender<Box<ImageObservation>>,
    worker: Mutex<Option<Receiver<Box<ImageObservation>>>>,
    /// Whether images are collected: read for every image without the lock.
    is_collecting: AtomicBool,
    missed: AtomicU64,
    offers: Mutex<Offers>,
    outgoing: Mutex<VecDeque<Outgoing>>,
    edit: Mutex<Option<PendingEdit>>,
}

impl WizardService {
    pub(crate) fn new(folder: Option<PathBuf>) -> Self {
        let (images, worker) = sync_channel(QUEUE);
        Self {
            machine: Mutex::default(),
            answers: Mutex::default(),
            folder,
            images,
            worker: Mutex::new(Some(worker)),
            is_collecting: AtomicBool::new(false),
            missed: AtomicU64::new(0),
            offers: Mutex::default(),
            outgoing: Mutex::default(),
            edit: Mutex::default(),
        }
    }

    /// Executes a command on a site as it is heard, or returns why not. May read a file.
    pub(crate) fn command(&self, command: &Command, mirror: &SiteMirror) -> Result<(), Refusal> {
        match command {
            Command::ApplyRefinement { node } => return self.accept(node, Offer::Refinement),
            Command::Revert { node } => return self.accept(node, Offer::Former),
            Command::SetCamera(settings) => {
                check_settings(settings)?;
                return self.send(Outgoing::Camera(settings.clone()));
            }
            _ => {}
        }
        let rig = match command {
            Command::Start(_) => self.rig_of_site(mirror)?,
            _ => Rig::default(),
        };
        let mut machine = self.machine();
        let site = Site {
            mirror,
            rig: &rig,
            has_folder: self.folder.is_some(),
        };
        if matches!(command, Command::Start(_)) {
            self.missed.store(0, Ordering::Relaxed);
        }
        let answer = machine.command(command, &site, Instant::now());
        self.is_collecting
            .store(machine.is_collecting(), Ordering::Relaxed);
        answer
    }

    /// Publishes an edit; what becomes of it comes by the receiver.
    pub(crate) fn edit(
        &self,
        request: &EditRequest,
        mirror: &SiteMirror,
    ) -> Result<oneshot::Receiver<EditAnswer>, Refusal> {
        let outgoing = edit::change(request, mirror)?;
        let publication = Publication::of(&outgoing, Instant::now()).map_err(Refusal::not_now)?;
        let mut pending = locked(&self.edit);
        if pending.is_some() {
            return Err(Refusal::not_now(
                "another edit is under way; try again in a moment",
            ));
        }
        self.send(outgoing.clone())?;
        let (reply, answer) = oneshot::channel();
        *pending = Some(PendingEdit {
            outgoing,
            publication,
            reply,
        });
        Ok(answer)
    }

    fn answer_edit(&self, answers: &VecDeque<ConfigAnswer>, now: Instant) {
        let mut slot = locked(&self.edit);
        let Some(pending) = slot.as_mut() else {
            return;
        };
        answers.iter().for_each(|it| pending.publication.take(it));
        if pending.publication.take_repeat(now) {
            self.post(pending.outgoing.clone());
        }
        let answer = match pending.publication.answered(now) {
            Answered::NotYet => return,
            Answered::Refused(refusal) => Err(refusal),
            Answered::Done(said) => Ok(said),
            Answered::Silence(said) => Err(Refusal::not_now(said)),
        };
        if let Some(answered) = slot.take() {
            // Who asked may have gone.
            let _ = answered.reply.send(answer);
        }
    }

    /// Publishes what a fusion node offers; the node's status shows the outcome.
    fn accept(&self, node: &NodeId, offer: Offer) -> Result<(), Refusal> {
        let change = locked(&self.offers).change(node, offer)?;
        self.send(change)
    }

    fn send(&self, change: Outgoing) -> Result<(), Refusal> {
        let mut outgoing = locked(&self.outgoing);
        if !outgoing.is_empty() {
            return Err(Refusal::not_now(
                "a change is under way; try again in a moment",
            ));
        }
        outgoing.push_back(change);
        Ok(())
    }

    /// What a fusion node offers to be put in force.
    pub(crate) fn take_offer(&self, offer: Offer, proposal: Proposal) {
        locked(&self.offers).take(offer, proposal);
    }

    /// The rig in force, completed by the folder's file; the folder's rig while there is no fusion node.
    fn rig_of_site(&self, mirror: &SiteMirror) -> Result<Rig, Refusal> {
        let file = self.folder.as_ref().map(|folder| folder.join("rig.toml"));
        let kept = match file.filter(|file| file.exists()) {
            Some(file) => read_rig(&file).map_err(Refusal::not_now)?,
            None => Rig::default(),
        };
        // It was checked when it was taken in.
        let in_force = mirror.rig().and_then(|rig| Rig::try_from(rig).ok());
        Ok(match in_force {
            Some(rig) => rig.holding_on_to(&kept),
            None => kept,
        })
    }

    /// Queues an image. Never waits: an image that finds no room is missed and counted.
    pub(crate) fn offer(&self, image: impl FnOnce() -> ImageObservation) {
        if self.is_collecting.load(Ordering::Relaxed)
            && self.images.try_send(Box::new(image())).is_err()
        {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// A fusion node is gone.
    pub(crate) fn forget_offers(&self, node: &NodeId) {
        locked(&self.offers).forget(node);
    }

    pub(crate) fn take_answer(&self, answer: &ConfigAnswer) {
        let mut answers = locked(&self.answers);
        if answers.len() == MOST_ANSWERS {
            answers.pop_front();
        }
        answers.push_back(answer.clone());
    }

    /// The next thing to be put on the network, once.
    pub(crate) fn take_outgoing(&self) -> Option<Outgoing> {
        locked(&self.outgoing).pop_front()
    }

    pub(super) fn post(&self, outgoing: Outgoing) {
        locked(&self.outgoing).push_back(outgoing);
    }

    pub(super) fn folder(&self) -> Option<&PathBuf> {
        self.folder.as_ref()
    }

    /// The worker's end of the images; there is one worker.
    pub(super) fn take_worker(&self) -> Option<Receiver<Box<ImageObservation>>> {
        locked(&self.worker).take()
    }

    pub(super) fn image(&self, image: &ImageObservation) {
        self.machine().image(image);
    }

    pub(super) fn solved(&self, number: u64, result: Result<Outcome, String>) {
        let mut machine = self.machine();
        machine.solved(number, result);
        let wanted = machine.is_collecting();
        self.is_collecting.store(wanted, Ordering::Relaxed);
    }

    pub(super) fn written(&self, result: Result<String, String>) {
        self.machine().written(result);
    }

    pub(super) fn tick(&self, now: Instant) -> Vec<Job> {
        let answers = std::mem::take(&mut *locked(&self.answers));
        self.answer_edit(&answers, now);
        let mut machine = self.machine();
        answers.iter().for_each(|answer| machine.answered(answer));
        machine.tick(now, self.folder.is_some());
        machine.take_jobs()
    }

    /// The state for the clients, if it has changed.
    pub(super) fn news(&self) -> Option<WizardState> {
        let mut machine = self.machine();
        let missed = self.missed.load(Ordering::Relaxed);
        let is_news = machine.take_news();
        is_news.then(|| machine.state(missed))
    }

    fn machine(&self) -> MutexGuard<'_, Machine> {
        locked(&self.machine)
    }
}

/// What is under these locks is whole even where somebody panicked.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wizard::samples;
    use sextant_site_files::write_rig;
    use sextant_site_model::{PoseSigma, Prior};

    const LENS: &str = r#"{"do":"start","wizard":"lens","camera":"a",
        "board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;

    fn obey(service: &WizardService, text: &str) -> Result<(), Refusal> {
        let command = Command::parse(text.as_bytes()).unwrap();
        service.command(&command, &samples::mirror())
    }

    #[test]
    fn images_beyond_the_queue_are_missed_and_counted() {
        let service = WizardService::new(None);
        service.offer(|| panic!("nobody asked for it"));
        obey(&service, LENS).unwrap();
        (0..QUEUE as u64 + 7).for_each(|step| service.offer(|| samples::image(step)));
        let state = serde_json::to_value(service.news().unwrap()).unwrap();
        assert_eq!(state["missed"], 7);
        obey(&service, r#"{"do":"discard"}"#).unwrap();
        obey(&service, LENS).unwrap();
        let state = serde_json::to_value(service.news().unwrap()).unwrap();
        assert_eq!(state["missed"], 0);
    }

    #[test]
    fn a_damaged_rig_file_is_named_at_the_start_and_hinders_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("rig.toml"), "camera = 3").unwrap();
        let service = WizardService::new(Some(folder.path().to_owned()));
        let refused = obey(&service, LENS).unwrap_err();
        assert!(refused.cause.contains("rig.toml"), "{}", refused.cause);
        obey(&service, r#"{"do":"discard"}"#).unwrap();
    }

    #[test]
    fn what_the_folder_knows_of_poses_stays_with_cameras_that_stayed() {
        let folder = tempfile::tempdir().unwrap();
        let prior = Prior::Sigma(PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.002,
        });
        let mut cameras = samples::rig().cameras().to_vec();
        cameras[1].pose_prior = prior;
        let kept = Rig::new(cameras).unwrap();
        write_rig(&folder.path().join("rig.toml"), &kept).unwrap();
        let service = WizardService::new(Some(folder.path().to_owned()));
        let mut mirror = samples::mirror();
        let rig = service.rig_of_site(&mirror).unwrap();
        assert_eq!(rig.cameras()[1].pose_prior, prior);
        let mut cameras = samples::rig().cameras().to_vec();
        cameras[1].world_from_camera = None;
        samples::hear_rig(&mut mirror, &Rig::new(cameras).unwrap());
        let rig = service.rig_of_site(&mirror).unwrap();
        assert_eq!(rig.cameras()[1].pose_prior, Prior::Default);
    }
}
