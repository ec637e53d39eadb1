//! Work on a stream of items by several threads, with results in the order of the items.
//!
//! At most a few items per thread are under way or waiting for an earlier one: the stream may be endless.

use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Items under way or waiting per thread.
const AHEAD: usize = 4;

/// Each thread works with its own state; `take` gets the results in the order of the items, on the calling thread.
///
/// # Errors
/// The first error of `take`, which also ends the work.
pub fn in_order<I: Send, S, R: Send, E>(
    threads: usize,
    items: impl Iterator<Item = I> + Send,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, I) -> R + Sync,
    take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let threads = threads.max(1);
    let source = Mutex::new(items.enumerate());
    let (permit, permits) = mpsc::channel();
    for _ in 0..threads * AHEAD {
        // The receiver lives: it is the next variable.
        let _ = permit.send(());
    }
    let permits = Mutex::new(permits);
    let (done, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads {
            let done = done.clone();
            let (source, permits, state, work) = (&source, &permits, &state, &work);
            scope.spawn(move || {
                let mut state = state();
                while let Some((index, item)) = next(source, permits) {
                    if done.send((index, work(&mut state, item))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(done);
        // Owned here, so that an error drops both ends and the threads come to an end.
        sort_out(results, permit, take)
    })
}

fn next<I>(source: &Mutex<impl Iterator<Item = I>>, permits: &Mutex<Receiver<()>>) -> Option<I> {
    let permitted = permits
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .recv();
    permitted.ok()?;
    source.lock().unwrap_or_else(PoisonError::into_inner).next()
}

fn sort_out<R, E>(
    results: Receiver<(usize, R)>,
    permit: mpsc::Sender<()>,
    mut take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let mut waiting = BTreeMap::new();
    let mut due = 0;
    for (index, result) in results {
        waiting.insert(index, result);
        while let Some(result) = waiting.remove(&due) {
            take(result)?;
            due += 1;
            let _ = permit.send(());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn results_come_in_order_whatever_each_takes() {
        let mut seen = Vec::new();
        let work = |_: &mut (), item: u64| {
            thread::sleep(Duration::from_micros((item * 7919) % 400));
            item * 2
        };
        in_order(
            3,
            0..200_u64,
            || (),
            work,
            |result| {
                seen.push(result);
                Ok::<_, ()>(())
            },
        )
        .unwrap();
        assert_eq!(seen, (0..200).map(|item| item * 2).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_ends_the_work_on_an_endless_stream() {
        let taken = in_order(
            2,
            0..,
            || (),
            |(), item: u64| item,
            |item| {
                if item < 10 { Ok(()) } else { Err("enough") }
            },
        );
        assert_eq!(taken, Err("enough"));
    }

    #[test]
    fn nothing_in_nothing_out() {
        in_order(
            2,
            std::iter::empty::<u8>(),
            || (),
            |(), x| x,
            |_| Ok::<_, ()>(()),
        )
        .unwrap();
    }
}
