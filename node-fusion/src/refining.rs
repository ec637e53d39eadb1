//! Refinement while running, off the live path: a thread of its own looks at the images and now and then finds a change.
//!
//! In: images as they come (the newest are dropped while it is busy, and counted), models as they change. Out: findings. It
//! changes nothing itself; the node puts a change in force as any other, whole or not at all. The node never waits for it.

use crate::models::Models;
use sextant_calibrator::refinement::{Change, Finding, Refinement, RefinementOptions};
use sextant_estimator::{CameraId, ClockOffset, Fault, ImageObservation};
use sextant_process::{fail_point, panics::contained};
use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel,
};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Images that wait while it works: four seconds of 16 cameras.
const QUEUE: usize = 2048;
/// The longest wait for an image before it is asked whether it is time to look.
const PATIENCE: Duration = Duration::from_millis(500);

/// What the thread is told.
#[derive(Debug)]
enum Word {
    Image(ImageObservation),
    /// Others have changed them.
    Models(Box<Models>),
    /// What it had found is in force.
    Accepted(Box<Change>),
    /// What it had found is not.
    Refused,
}

/// What is known of the site apart from the images.
#[derive(Debug, Default)]
struct Health {
    is_sound: bool,
    clocks: BTreeMap<CameraId, ClockOffset>,
}

/// An offset that is known this well is taken off, seconds.
const KNOWN_S: f64 = 0.001;

impl Health {
    fn set_right(&self, image: &ImageObservation) -> ImageObservation {
        let known = self.clocks.get(&image.camera);
        let offset_s = known.filter(|clock| clock.sigma_s < KNOWN_S);
        let offset_ns = offset_s.map_or(0, |clock| (clock.offset_s * 1e9) as i64);
        ImageObservation {
            capture_ns: image.capture_ns.saturating_add_signed(-offset_ns),
            ..image.clone()
        }
    }
}

/// The thread's handle.
#[derive(Debug)]
pub struct Refining {
    words: Option<SyncSender<Word>>,
    /// What must not be lost and has no room yet: the newest models, and the answer to the one change that may be open.
    waiting: VecDeque<Word>,
    findings: Receiver<Finding>,
    thread: Option<JoinHandle<Result<(), String>>>,
    dropped: u64,
    health: Health,
}

impl Refining {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system has no thread to give.
    pub fn start(
        models: &Models,
        options: RefinementOptions,
        period: Duration,
    ) -> std::io::Result<Self> {
        let (words, heard) = sync_channel(QUEUE);
        let (told, findings) = sync_channel(1);
        let refinement = Refinement::new(&models.rig, &models.objects, options);
        let worker = Worker {
            refinement,
            period,
            looked: Instant::now(),
            answer: Answer::Given,
        };
        let thread = std::thread::Builder::new()
            .name("refining".to_owned())
            .spawn(move || contained(move || worker.work(&heard, &told)))?;
        Ok(Self {
            words: Some(words),
            waiting: VecDeque::new(),
            findings,
            thread: Some(thread),
            dropped: 0,
            health: Health::default(),
        })
    }

    /// What the machine knows of the site: while something is wrong with it nothing is gathered, and clocks that are off are
    /// set right.
    pub fn take_health(&mut self, faults: &[Fault], clocks: BTreeMap<CameraId, ClockOffset>) {
        // A clock whose offset is known does no harm.
        let harmless = |fault: &Fault| matches!(fault, Fault::ClockOff { .. });
        self.health = Health {
            is_sound: faults.iter().all(harmless),
            clocks,
        };
    }

    /// Shows it an image, if the site is sound and it has time.
    pub fn show(&mut self, image: &ImageObservation) {
        self.say_what_waits();
        if !self.health.is_sound {
            return;
        }
        let image = Word::Image(self.health.set_right(image));
        // What was seen after the models changed must not be heard before that.
        let sent = self.waiting.is_empty() && self.offer(image).is_ok();
        if !sent {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// Images that it had no time for.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// What it has found since this was asked last.
    ///
    /// # Errors
    /// Why it has ended: it panicked, which holds up nobody else.
    pub fn finding(&mut self) -> Result<Option<Finding>, String> {
        match self.findings.try_recv() {
            Ok(finding) => Ok(Some(finding)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(self.failure()),
        }
    }

    fn failure(&mut self) -> String {
        let ended = self.thread.take().map(JoinHandle::join);
        match ended {
            Some(Ok(Err(panicked))) => panicked,
            _ => "its thread has ended".to_owned(),
        }
    }

    /// The change is in force.
    pub fn accepted(&mut self, change: &Change) {
        self.say(Word::Accepted(Box::new(change.clone())));
    }

    /// The change is not in force.
    pub fn refused(&mut self) {
        self.say(Word::Refused);
    }

    /// Others have changed the models: what waits is about former ones.
    pub fn take_models(&mut self, models: &Models) {
        self.waiting.clear();
        self.say(Word::Models(Box::new(models.clone())));
    }

    fn say(&mut self, word: Word) {
        self.waiting.push_back(word);
        self.say_what_waits();
    }

    fn say_what_waits(&mut self) {
        while let Some(word) = self.waiting.pop_front() {
            if let Err(word) = self.offer(word) {
                self.waiting.push_front(word);
                return;
            }
        }
    }

    /// Gives the word back where there is no room. A thread that has ended takes everything: nobody needs to know.
    fn offer(&self, word: Word) -> Result<(), Word> {
        let sent = self.words.as_ref().map(|words| words.try_send(word));
        match sent {
            Some(Err(TrySendError::Full(word))) => Err(word),
            _ => Ok(()),
        }
    }
}

impl Drop for Refining {
    fn drop(&mut self) {
        self.words = None;
        if let Some(thread) = self.thread.take() {
            // It ends with the channel.
            let _ = thread.join();
        }
    }
}

/// Whether the last change that was found has been answered.
#[derive(PartialEq, Eq)]
enum Answer {
    Given,
    Awaited,
}

struct Worker {
    refinement: Refinement,
    period: Duration,
    looked: Instant,
    answer: Answer,
}

impl Worker {
    fn work(mut self, heard: &Receiver<Word>, told: &SyncSender<Finding>) {
        loop {
            fail_point!("refining");
            match heard.recv_timeout(PATIENCE) {
                Ok(word) => self.take(word),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if self.answer == Answer::Given && self.looked.elapsed() >= self.period {
                self.looked = Instant::now();
                self.look(told);
            }
        }
    }

    fn take(&mut self, word: Word) {
        match word {
            Word::Image(image) => self.refinement.handle(&image),
            Word::Models(models) => {
                self.refinement.take_models(&models.rig, &models.objects);
                self.answer = Answer::Given;
            }
            Word::Accepted(change) => {
                self.refinement.accept(&change);
                self.answer = Answer::Given;
            }
            Word::Refused => self.answer = Answer::Given,
        }
    }

    fn look(&mut self, told: &SyncSender<Finding>) {
        if !self.refinement.take_news() {
            return;
        }
        let finding = self.refinement.find();
        let is_change = matches!(finding, Finding::Better(_));
        if told.try_send(finding).is_ok() && is_change {
            self.answer = Answer::Awaited;
        }
    }
}

#[cfg(test)]
mod tests;
