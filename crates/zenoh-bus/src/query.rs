//! Queries of latest values.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use zenoh::Wait;
use zenoh::query::{ConsolidationMode, QueryTarget, Reply};

use crate::{BusError, Item};

/// Most keys of one query.
const MAX_ANSWERS: usize = 1024;

/// The latest values on `key_expr`, one per key, sorted by key.
pub(crate) fn latest(
    session: &zenoh::Session,
    key_expr: &str,
    max_bytes: usize,
    timeout: Duration,
) -> Result<Vec<Item>, BusError> {
    let answers = Arc::new(Mutex::new(BTreeMap::new()));
    let (done, wait) = std::sync::mpsc::channel::<()>();
    let callback = {
        let answers = Arc::clone(&answers);
        move |reply: Reply| {
            // `done` is dropped with this closure, when the last answer has arrived: that ends the wait below.
            let _open = &done;
            collect(&answers, &reply, max_bytes);
        }
    };
    session
        .get(key_expr)
        .target(QueryTarget::All)
        .consolidation(ConsolidationMode::None)
        .timeout(timeout)
        .callback(callback)
        .wait()
        .map_err(|cause| BusError::Key {
            key: key_expr.to_owned(),
            cause: cause.to_string(),
        })?;
    // Zenoh ends the query at the timeout; the margin only guards against a session that does not.
    let _ = wait.recv_timeout(timeout + Duration::from_millis(500));
    let answers = std::mem::take(&mut *answers.lock().unwrap_or_else(PoisonError::into_inner));
    Ok(answers.into_values().collect())
}

fn collect(answers: &Mutex<BTreeMap<String, Item>>, reply: &Reply, max_bytes: usize) {
    let Ok(sample) = reply.result() else { return };
    let Some(item) = Item::from_sample(sample, max_bytes) else {
        return;
    };
    let mut answers = answers.lock().unwrap_or_else(PoisonError::into_inner);
    if answers.len() < MAX_ANSWERS || answers.contains_key(&item.key) {
        answers.insert(item.key.clone(), item);
    }
}
