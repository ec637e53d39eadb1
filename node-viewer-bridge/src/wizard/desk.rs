//! The desk: where commands are answered, images and news of the site handed in, and the wizard's thread finds its work.
//!
//! The network's threads take the lock of what is known, and that of the answers, only: neither is ever held while a file is
//! read, an image is looked at or a command obeyed.

use super::account::Account;
use super::command::{Command, Refusal};
use super::known::Known;
use super::machine::{Job, Machine, Site};
use super::offers::{Offer, Offers};
use super::publication::Outgoing;
use sextant_calibrator::procedure::Outcome;
use sextant_estimator::{CameraId, ImageObservation, ObjectId, ObjectModel, Rig};
use sextant_proto::{ConfigAnswer, NodeId, Proposal};
use sextant_site_files::read_rig;
use std::collections::{BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Images that wait for the wizard's thread; further ones are missed, and counted.
const QUEUE: usize = 256;
/// Answers that wait for it; the oldest give way.
const MOST_ANSWERS: usize = 256;

/// One for the whole bridge.
#[derive(Debug)]
pub(crate) struct Desk {
    machine: Mutex<Machine>,
    known: Mutex<Known>,
    answers: Mutex<VecDeque<ConfigAnswer>>,
    /// Where results are kept.
    folder: Option<PathBuf>,
    images: SyncSender<Box<ImageObservation>>,
    worker: Mutex<Option<Receiver<Box<ImageObservation>>>>,
    /// Whether images are wanted: looked at for every image, without the lock.
    is_collecting: AtomicBool,
    missed: AtomicU64,
    offers: Mutex<Offers>,
    outgoing: Mutex<VecDeque<Outgoing>>,
}

impl Desk {
    pub(crate) fn new(folder: Option<PathBuf>) -> Self {
        let (images, worker) = sync_channel(QUEUE);
        Self {
            machine: Mutex::default(),
            known: Mutex::default(),
            answers: Mutex::default(),
            folder,
            images,
            worker: Mutex::new(Some(worker)),
            is_collecting: AtomicBool::new(false),
            missed: AtomicU64::new(0),
            offers: Mutex::default(),
            outgoing: Mutex::default(),
        }
    }

    /// Obeys a command, or says why not. May read a file.
    pub(crate) fn command(&self, command: &Command) -> Result<(), Refusal> {
        match command {
            Command::ApplyRefinement { node } => return self.accept(node, Offer::Refinement),
            Command::Revert { node } => return self.accept(node, Offer::Former),
            _ => {}
        }
        let known = self.known().clone();
        let rig = match command {
            Command::Start(_) => self.rig_of_site(&known)?,
            _ => Rig::default(),
        };
        let mut machine = self.machine();
        let site = Site {
            known: &known,
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

    /// Sends what a fusion node offers on its way; what becomes of it the node's status says.
    fn accept(&self, node: &NodeId, offer: Offer) -> Result<(), Refusal> {
        let changes = locked(&self.offers).changes(node, offer)?;
        let mut outgoing = locked(&self.outgoing);
        if !outgoing.is_empty() {
            return Err(Refusal::not_now(
                "a change is under way; try again in a moment",
            ));
        }
        outgoing.extend(changes);
        Ok(())
    }

    /// What a fusion node offers to be put in force.
    pub(crate) fn take_offer(&self, offer: Offer, proposal: Proposal) {
        locked(&self.offers).take(offer, proposal);
    }

    /// The rig in force, with what besides the folder's file states of it; that of the folder while there is no fusion node.
    fn rig_of_site(&self, known: &Known) -> Result<Rig, Refusal> {
        let file = self.folder.as_ref().map(|folder| folder.join("rig.toml"));
        let kept = match file.filter(|file| file.exists()) {
            Some(file) => read_rig(&file).map_err(Refusal::not_now)?,
            None => Rig::default(),
        };
        Ok(match &known.rig {
            Some(rig) => rig.clone().holding_on_to(&kept),
            None => kept,
        })
    }

    /// An image came. Never waits: one that finds no place is missed.
    pub(crate) fn offer(&self, image: impl FnOnce() -> ImageObservation) {
        if self.is_collecting.load(Ordering::Relaxed)
            && self.images.try_send(Box::new(image())).is_err()
        {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The rig in force, with all that is stated of it.
    pub(crate) fn take_rig(&self, rig: Rig) {
        self.known().rig = Some(rig);
    }

    /// The cameras in force, without what is stated of them.
    pub(crate) fn take_cameras(&self, rig: Rig) {
        let known = &mut self.known().rig;
        *known = Some(match known.take() {
            Some(before) => rig.holding_on_to(&before),
            None => rig,
        });
    }

    /// An object in force, with all that is stated of it.
    pub(crate) fn take_object(&self, object: ObjectModel) {
        self.known().take_object(object);
    }

    /// The tags of an object in force, without what is stated of them.
    pub(crate) fn take_tags(&self, object: ObjectModel) {
        let mut known = self.known();
        let held = match known.object(object.id()) {
            Some(before) => object.holding_on_to(before),
            None => object,
        };
        known.take_object(held);
    }

    /// These objects exist, as a fusion node says.
    pub(crate) fn confirm_objects(&self, objects: &BTreeSet<&str>) {
        self.known().confirm_objects(objects);
    }

    pub(crate) fn forget_object(&self, id: &ObjectId) {
        self.known().forget_object(id);
    }

    pub(crate) fn take_resolution(&self, camera: &CameraId, resolution: [u32; 2]) {
        self.known().take_resolution(camera, resolution);
    }

    pub(crate) fn fusion_node(&self, id: &NodeId, up: bool) {
        self.known().fusion_node(id, up);
        if !up {
            locked(&self.offers).forget(id);
        }
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
        let mut machine = self.machine();
        answers.iter().for_each(|answer| machine.answered(answer));
        machine.tick(now, self.folder.is_some());
        machine.take_jobs()
    }

    /// What to tell clients, if there is something new.
    pub(super) fn news(&self) -> Option<Account> {
        let mut machine = self.machine();
        let missed = self.missed.load(Ordering::Relaxed);
        let is_news = machine.take_news();
        is_news.then(|| machine.account(missed))
    }

    fn machine(&self) -> MutexGuard<'_, Machine> {
        locked(&self.machine)
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        locked(&self.known)
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
    use sextant_estimator::PoseSigma;
    use sextant_site_files::write_rig;

    const LENS: &str = r#"{"do":"start","wizard":"lens","camera":"a",
        "board":{"grid":{"columns":5,"rows":6,"size_m":0.028}}}"#;

    fn obey(desk: &Desk, text: &str) -> Result<(), Refusal> {
        desk.command(&Command::parse(text.as_bytes()).unwrap())
    }

    #[test]
    fn images_beyond_the_queue_are_missed_and_counted() {
        let desk = Desk::new(None);
        desk.offer(|| panic!("nobody asked for it"));
        desk.take_rig(samples::rig());
        obey(&desk, LENS).unwrap();
        (0..QUEUE as u64 + 7).for_each(|step| desk.offer(|| samples::image(step)));
        let told = serde_json::to_value(desk.news().unwrap()).unwrap();
        assert_eq!(told["missed"], 7);
        obey(&desk, r#"{"do":"discard"}"#).unwrap();
        obey(&desk, LENS).unwrap();
        let told = serde_json::to_value(desk.news().unwrap()).unwrap();
        assert_eq!(told["missed"], 0);
    }

    #[test]
    fn a_damaged_rig_file_is_named_at_the_start_and_hinders_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("rig.toml"), "camera = 3").unwrap();
        let desk = Desk::new(Some(folder.path().to_owned()));
        let refused = obey(&desk, LENS).unwrap_err();
        assert!(refused.cause.contains("rig.toml"), "{}", refused.cause);
        obey(&desk, r#"{"do":"discard"}"#).unwrap();
    }

    #[test]
    fn what_the_folder_knows_of_poses_stays_with_cameras_that_stayed() {
        let folder = tempfile::tempdir().unwrap();
        let sigma = PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.002,
        };
        let b: CameraId = "b".parse().unwrap();
        let kept = samples::rig()
            .with_pose_sigmas([(b.clone(), sigma)])
            .unwrap();
        write_rig(&folder.path().join("rig.toml"), &kept).unwrap();
        let desk = Desk::new(Some(folder.path().to_owned()));
        let mut known = samples::known();
        let rig = desk.rig_of_site(&known).unwrap();
        assert_eq!(rig.pose_sigma(&b), Some(sigma));
        let mut cameras = samples::rig().cameras().to_vec();
        cameras[1].world_from_camera = None;
        known.rig = Some(Rig::new(cameras).unwrap());
        assert_eq!(desk.rig_of_site(&known).unwrap().pose_sigma(&b), None);
    }
}
