//! Sites from many seeds keep every promise.

use site_simulation::{Plan, run};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Seeds of a run of the tests.
const SEEDS: u64 = 200;

#[test]
fn every_promise_is_kept() {
    let (next, broken) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..n_threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= SEEDS {
                        break;
                    }
                    if let Some(one) = run(&Plan::new(seed), false).broken {
                        broken.lock().unwrap().push(format!("seed {seed} {one}"));
                    }
                }
            });
        }
    });
    let broken = broken.into_inner().unwrap();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    for seed in [3, 6, 14] {
        let runs = [0, 1].map(|_| run(&Plan::new(seed), false));
        let [first, second] = runs.map(|run| (run.fingerprint, run.poses, run.broken));
        assert_eq!(first, second);
    }
}
