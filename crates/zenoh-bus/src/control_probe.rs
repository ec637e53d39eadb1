//! Whether the router still answers. Zenoh's control plane can stop while data flows (eclipse-zenoh/zenoh issue 1876):
//! subscriptions and queries then have no effect, and only a new session helps.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use zenoh::Wait;

use crate::{Bus, BusError};

/// Between two queries.
const PERIOD: Duration = Duration::from_secs(2);
/// How long an answer may take: less than the two seconds (`routing/interests/timeout`) after which zenoh itself ends a
/// query that its router leaves open, as if it had been answered.
const ANSWER: Duration = Duration::from_secs(1);
/// After so long without an answer the control plane counts as dead: seven queries.
const SILENCE: Duration = Duration::from_secs(15);

/// Queries the router's liveliness tokens every two seconds. Never blocks.
#[derive(Debug)]
pub struct ControlProbe {
    key: String,
    due: Instant,
    /// When the last question was asked that has been answered.
    answered: Arc<Mutex<Instant>>,
}

/// Dropped by zenoh at the end of the answer.
struct Question {
    asked: Instant,
    answered: Arc<Mutex<Instant>>,
    is_overdue: Mutex<bool>,
}

impl Drop for Question {
    fn drop(&mut self) {
        if !*lock(&self.is_overdue) {
            *lock(&self.answered) = self.asked;
        }
    }
}

impl ControlProbe {
    /// A probe that asks who is alive on this key expression.
    #[must_use]
    pub fn new(key_expr: &str, now: Instant) -> Self {
        Self {
            key: key_expr.to_owned(),
            due: now,
            answered: Arc::new(Mutex::new(now)),
        }
    }

    /// Asks again when it is time to.
    ///
    /// # Errors
    /// [`BusError::Silent`] when the router has not answered for 15 s: the caller opens a new session, or ends and is
    /// started again. No error while none is connected, since the session then reconnects by itself.
    pub fn check(&mut self, bus: &Bus, now: Instant) -> Result<(), BusError> {
        if now >= self.due {
            self.due = now + PERIOD;
            if bus.is_connected() {
                self.ask(bus, now);
            } else {
                *lock(&self.answered) = now;
            }
        }
        let silent = now.saturating_duration_since(*lock(&self.answered));
        match silent < SILENCE {
            true => Ok(()),
            false => Err(BusError::Silent {
                silent_s: silent.as_secs(),
            }),
        }
    }

    fn ask(&self, bus: &Bus, now: Instant) {
        let Ok(session) = bus.session() else { return };
        let question = Question {
            asked: now,
            answered: Arc::clone(&self.answered),
            is_overdue: Mutex::new(false),
        };
        let asked = session
            .liveliness()
            .get(&self.key)
            .timeout(ANSWER)
            .callback(move |reply| {
                if reply.result().is_err() {
                    *lock(&question.is_overdue) = true;
                }
            })
            .wait();
        if let Err(cause) = asked {
            tracing::debug!(%cause, "a query of the router");
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
