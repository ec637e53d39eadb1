//! The queue of the wizard's machine. Network and server put inputs in and never wait; the wizard's thread takes them
//! out.

use super::wizard_core::{Input, Reply, RequestInput};
use sextant_site_model::ImageObservation;
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::oneshot;

/// Images that wait; further ones are missed, and counted.
pub(super) const MOST_IMAGES: usize = 256;
/// Answers and offers of fusion nodes that wait; the oldest give way. An offer takes the place of a former one of its
/// node.
const MOST_NEWS: usize = 128;
/// Requests that wait; further ones are refused.
const MOST_REQUESTS: usize = 32;
/// Most images that are taken out at once.
const MOST_AT_ONCE: usize = 64;

/// A request, and where its reply goes.
pub(super) type Asked = (Box<RequestInput>, oneshot::Sender<Reply>);

/// What was taken out of the queue, in the order in which it is to be handled.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// Images that found no room.
    pub missed: u64,
    /// Changes that the network's thread has published.
    pub n_published: usize,
    /// Of the network.
    pub news: VecDeque<Input>,
    /// Of people.
    pub requests: VecDeque<Asked>,
    /// Of cameras.
    pub images: Vec<ImageObservation>,
}

#[derive(Debug, Default)]
struct Waiting {
    missed: u64,
    n_published: usize,
    news: VecDeque<Input>,
    requests: VecDeque<Asked>,
    images: VecDeque<ImageObservation>,
    wants_images: bool,
}

/// The queue.
#[derive(Debug, Default)]
pub(super) struct Inbox {
    waiting: Mutex<Waiting>,
    arrived: Condvar,
}

impl Inbox {
    /// Queues what a fusion node says.
    pub(super) fn put_news(&self, news: Input) {
        let mut waiting = self.waiting();
        if let Input::Offer(offer, proposal) = &news {
            let (offer, node) = (*offer, &proposal.node);
            let is_former = |old: &Input| matches!(old, Input::Offer(of, known) if *of == offer && known.node == *node);
            waiting.news.retain(|old| !is_former(old));
        }
        if waiting.news.len() == MOST_NEWS {
            waiting.news.pop_front();
        }
        waiting.news.push_back(news);
        self.arrived.notify_one();
    }

    /// A change is on the network.
    pub(super) fn note_published(&self) {
        self.waiting().n_published += 1;
        self.arrived.notify_one();
    }

    /// Queues a request; gives it back where there is no room.
    pub(super) fn put_request(&self, asked: Asked) -> Result<(), Asked> {
        let mut waiting = self.waiting();
        if waiting.requests.len() == MOST_REQUESTS {
            return Err(asked);
        }
        waiting.requests.push_back(asked);
        self.arrived.notify_one();
        Ok(())
    }

    /// Queues an image if images are wanted; it is made without the lock.
    pub(super) fn put_image(&self, image: impl FnOnce() -> ImageObservation) {
        let mut waiting = self.waiting();
        if !waiting.wants_images {
            return;
        }
        if waiting.images.len() == MOST_IMAGES {
            waiting.missed += 1;
            return;
        }
        drop(waiting);
        let image = image();
        self.waiting().images.push_back(image);
        self.arrived.notify_one();
    }

    /// Whether images are wanted from now on.
    pub(super) fn want_images(&self, wanted: bool) {
        self.waiting().wants_images = wanted;
    }

    /// Takes out what waits; waits so long at most for something to come.
    pub(super) fn take(&self, patience: Duration) -> Batch {
        let waiting = self.waiting();
        let is_empty = |waiting: &mut Waiting| waiting.is_empty();
        let waited = self.arrived.wait_timeout_while(waiting, patience, is_empty);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let n_images = waiting.images.len().min(MOST_AT_ONCE);
        Batch {
            missed: std::mem::take(&mut waiting.missed),
            n_published: std::mem::take(&mut waiting.n_published),
            news: std::mem::take(&mut waiting.news),
            requests: std::mem::take(&mut waiting.requests),
            images: waiting.images.drain(..n_images).collect(),
        }
    }

    /// What is under this lock is whole even where somebody panicked.
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn is_empty(&self) -> bool {
        let is_quiet = self.n_published == 0 && self.missed == 0;
        is_quiet && self.news.is_empty() && self.requests.is_empty() && self.images.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::changes::Offer;
    use crate::wizard::samples;
    use sextant_proto::{NodeId, Proposal};

    #[test]
    fn images_beyond_the_queue_are_missed_and_counted() {
        let inbox = Inbox::default();
        inbox.put_image(|| panic!("nobody asked for it"));
        inbox.want_images(true);
        let n_images = MOST_IMAGES as u64 + 7;
        (0..n_images).for_each(|step| inbox.put_image(|| samples::image(step)));
        let batch = inbox.take(Duration::ZERO);
        assert_eq!((batch.missed, batch.images.len()), (7, MOST_AT_ONCE));
        assert_eq!(inbox.take(Duration::ZERO).missed, 0);
    }

    #[test]
    fn a_flood_of_offers_ends_at_the_bound_and_a_node_has_one_of_a_kind() {
        let inbox = Inbox::default();
        let offer = |node: &str, t_ns| {
            let proposal = Proposal::none(NodeId::new(node).unwrap(), t_ns);
            Input::Offer(Offer::Former, Box::new(proposal))
        };
        (0..3).for_each(|t_ns| inbox.put_news(offer("main", t_ns)));
        assert_eq!(inbox.take(Duration::ZERO).news.len(), 1);
        (0..10 * MOST_NEWS).for_each(|n| inbox.put_news(offer(&format!("n{n}"), 1)));
        assert_eq!(inbox.take(Duration::ZERO).news.len(), MOST_NEWS);
    }

    #[test]
    fn an_empty_queue_is_waited_for_no_longer_than_asked() {
        let batch = Inbox::default().take(Duration::from_millis(1));
        assert!(batch.requests.is_empty() && batch.news.is_empty());
    }
}
