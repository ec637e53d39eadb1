//! Queries of latest values.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use zenoh::Wait;
use zenoh::query::{ConsolidationMode, QueryTarget, Reply};
use zenoh::sample::Locality;

use crate::{BusError, Item};

/// Most keys of one query.
const MAX_ANSWERS: usize = 2048;
/// How long those who answer for the network may take to list tokens.
pub(crate) const TOKENS: Duration = Duration::from_secs(1);

/// The values asked for, while the answers come.
#[derive(Debug)]
pub struct Question {
    answers: Arc<Mutex<BTreeMap<String, Item>>>,
    /// Whether somebody has not answered in time.
    is_partial: Arc<AtomicBool>,
    /// Ends when the last answer has arrived, or the time is over.
    open: Receiver<()>,
}

impl Question {
    /// All answers, one per key, sorted by key; none before the last one has arrived or the time is over.
    pub fn poll(&self) -> Option<Vec<Item>> {
        matches!(self.open.try_recv(), Err(TryRecvError::Disconnected)).then(|| self.take())
    }

    /// Whether somebody who keeps values has not answered in time, or has refused to.
    pub fn is_partial(&self) -> bool {
        self.is_partial.load(Ordering::Relaxed)
    }

    fn wait(&self, timeout: Duration) -> Vec<Item> {
        let _ = self.open.recv_timeout(timeout);
        self.take()
    }

    fn take(&self) -> Vec<Item> {
        let answers = std::mem::take(&mut *locked(&self.answers));
        answers.into_values().collect()
    }
}

/// Asks these sessions for their latest values on `key_expr`.
pub(crate) fn ask(
    session: &zenoh::Session,
    key_expr: &str,
    max_bytes: usize,
    timeout: Duration,
    whose: Locality,
) -> Result<Question, BusError> {
    let answers = Arc::new(Mutex::new(BTreeMap::new()));
    let is_partial = Arc::<AtomicBool>::default();
    let (done, open) = std::sync::mpsc::channel::<()>();
    let callback = {
        let (answers, is_partial) = (Arc::clone(&answers), Arc::clone(&is_partial));
        move |reply: Reply| {
            // `done` is dropped with this closure, when the last answer has arrived.
            let _open = &done;
            // Zenoh reports the end of the time as an answer that is an error.
            if reply.result().is_err() {
                is_partial.store(true, Ordering::Relaxed);
            }
            collect(&answers, &reply, max_bytes);
        }
    };
    session
        .get(key_expr)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .allowed_destination(whose)
        .timeout(timeout)
        .callback(callback)
        .wait()
        .map_err(|cause| BusError::of_key(key_expr, &cause))?;
    Ok(Question {
        answers,
        is_partial,
        open,
    })
}

/// The latest values of all sessions on `key_expr`, one per key, sorted by key.
pub(crate) fn latest(
    session: &zenoh::Session,
    key_expr: &str,
    max_bytes: usize,
    timeout: Duration,
) -> Result<Vec<Item>, BusError> {
    let question = ask(session, key_expr, max_bytes, timeout, Locality::Any)?;
    // Zenoh ends the query at the timeout; the margin only guards against a session that does not.
    Ok(question.wait(timeout + Duration::from_millis(500)))
}

/// The keys of the liveliness tokens on `key_expr`, sorted.
pub(crate) fn alive_keys(
    session: &zenoh::Session,
    key_expr: &str,
) -> Result<Vec<String>, BusError> {
    let found = Arc::new(Mutex::new(BTreeSet::new()));
    let (done, wait) = std::sync::mpsc::channel::<()>();
    let answers = Arc::clone(&found);
    session
        .liveliness()
        .get(key_expr)
        .timeout(TOKENS)
        .callback(move |reply| {
            // As above.
            let _open = &done;
            let Ok(sample) = reply.result() else { return };
            let mut found = locked(&answers);
            if found.len() < MAX_ANSWERS {
                found.insert(sample.key_expr().as_str().to_owned());
            }
        })
        .wait()
        .map_err(|cause| BusError::of_key(key_expr, &cause))?;
    let _ = wait.recv_timeout(TOKENS + Duration::from_millis(500));
    let found = std::mem::take(&mut *locked(&found));
    Ok(found.into_iter().collect())
}

fn collect(answers: &Mutex<BTreeMap<String, Item>>, reply: &Reply, max_bytes: usize) {
    let Ok(sample) = reply.result() else { return };
    // Publishers answer without a time stamp. One comes from a storage, whose value may be of a process that has ended.
    if sample.timestamp().is_some() {
        return;
    }
    let Some(item) = Item::from_sample(sample, max_bytes) else {
        return;
    };
    let mut answers = locked(answers);
    if answers.len() < MAX_ANSWERS || answers.contains_key(&item.key) {
        answers.insert(item.key.clone(), item);
    }
}

fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
