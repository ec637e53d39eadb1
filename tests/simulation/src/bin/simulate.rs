//! Runs sites from many seeds, and says which promise was broken by which.

use clap::Parser;
use site_simulation::{Coverage, Plan, run, superfluous};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Whole sites in simulated time, from seeds.
#[derive(Debug, Parser)]
struct Arguments {
    /// How many seeds.
    #[arg(long, default_value_t = 200)]
    seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 0)]
    from: u64,
    /// Ends after so many hours, whatever is left.
    #[arg(long, default_value_t = 8.0)]
    hours: f64,
    /// Runs this seed alone and prints what happens.
    #[arg(long)]
    trace: Option<u64>,
    /// Leaves out these faults and requests of the plan that is traced, by number from 0, faults first.
    #[arg(long, value_delimiter = ',')]
    without: Vec<usize>,
    /// Somebody makes a mistake at each site: moves or turns a camera, exchanges names, prints at another scale.
    #[arg(long)]
    mistakes: bool,
    /// Ends with the first promise that is broken.
    #[arg(long)]
    until_broken: bool,
    /// Finds out which faults and requests of a failing plan do not matter.
    #[arg(long)]
    shrink: bool,
    /// How many run at the same time; as many as there are processors.
    #[arg(long)]
    threads: Option<usize>,
}

/// What all runs showed.
#[derive(Default)]
struct Total {
    failures: u64,
    runs: u64,
    poses: u64,
    simulated_s: f64,
    coverage: Coverage,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(seed) = arguments.trace {
        return trace(&arguments.plan(seed).without(&arguments.without));
    }
    let begun = Instant::now();
    let ends = Duration::from_secs_f64(arguments.hours * 3600.0);
    let next = AtomicU64::new(arguments.from);
    let total = Mutex::new(Total::default());
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..arguments.threads.unwrap_or(n_threads) {
            scope.spawn(|| {
                while begun.elapsed() < ends {
                    let has_failed = total.lock().is_ok_and(|total| total.failures > 0);
                    if arguments.until_broken && has_failed {
                        break;
                    }
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= arguments.from + arguments.seeds {
                        break;
                    }
                    one(&arguments.plan(seed), arguments.shrink, &total);
                }
            });
        }
    });
    let total = total.into_inner().unwrap_or_default();
    let took_s = begun.elapsed().as_secs_f64();
    println!("{}", total.coverage.table());
    println!(
        "{} sites, {:.0} s simulated in {took_s:.1} s ({:.0} times as fast), {} poses, {} with a broken promise",
        total.runs,
        total.simulated_s,
        total.simulated_s / took_s,
        total.poses,
        total.failures
    );
    match total.failures {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}

impl Arguments {
    fn plan(&self, seed: u64) -> Plan {
        let plan = Plan::new(seed);
        match self.mistakes {
            true => plan.with_mistake(),
            false => plan,
        }
    }
}

fn one(plan: &Plan, shrink: bool, total: &Mutex<Total>) {
    let outcome = run(plan, false);
    if let Some(broken) = &outcome.broken {
        let without = match shrink {
            true => superfluous(plan, broken.promise),
            false => Vec::new(),
        };
        let without: Vec<String> = without.iter().map(usize::to_string).collect();
        let option = match without.is_empty() {
            true => String::new(),
            false => format!(" --without {}", without.join(",")),
        };
        let mistakes = plan.mistake.map_or("", |_| " --mistakes");
        let seed = plan.seed;
        println!("seed {seed} {broken}; cargo xtask simulate --trace {seed}{mistakes}{option}");
    }
    let Ok(mut total) = total.lock() else {
        return;
    };
    total.runs += 1;
    total.poses += outcome.poses;
    total.failures += u64::from(outcome.broken.is_some());
    total.simulated_s += plan.end_ns as f64 * 1e-9;
    total.coverage.add(&outcome.coverage);
}

fn trace(plan: &Plan) -> ExitCode {
    print!("{plan}");
    let outcome = run(plan, true);
    println!("fingerprint {:016x}", outcome.fingerprint);
    match outcome.broken {
        None => ExitCode::SUCCESS,
        Some(broken) => {
            println!("{broken}");
            ExitCode::FAILURE
        }
    }
}
