//! The wizard's thread: takes inputs out of the queue, has the machine handle them, and carries its outputs out. A
//! solve has a thread of its own.

use super::inbox::Batch;
use super::service::WizardService;
use super::state::WizardState;
use super::wizard_core::{Input, Output, Reply, WizardCore};
use crate::frame::frame_of;
use crate::hub::{Hub, Slot};
use sextant_calibrator::procedure::{Procedure, ProcedureOutcome, Product};
use sextant_process::{Shutdown, fail_point, panics::contained};
use sextant_site_files::{former_of, keep_object, keep_rig, object_file};
use std::collections::BTreeMap;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// Longest wait for an input: bounds the delay of a shutdown.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// Between two looks at a solve.
const SOLVER_PERIOD: Duration = Duration::from_millis(30);

/// Runs until `shutdown`. A solve that is at work then ends with the process.
pub(crate) fn run(service: &WizardService, hub: &Hub, shutdown: &Shutdown) {
    let mut worker = Worker {
        core: WizardCore::new(service.folder().is_some(), Instant::now()),
        service,
        hub,
        solver: None,
        replies: BTreeMap::new(),
        n_requests: 0,
    };
    worker.carry_out();
    while !shutdown.is_requested() {
        fail_point!("wizard");
        let batch = service.inbox().take(worker.patience());
        worker.handle_batch(batch);
        worker.poll_solver();
        worker.handle(Input::Tick);
    }
}

/// What a solve came to.
type Solved = Result<ProcedureOutcome, String>;

struct Worker<'a> {
    core: WizardCore,
    service: &'a WizardService,
    hub: &'a Hub,
    solver: Option<(u64, JoinHandle<Result<Solved, String>>)>,
    /// Who waits for the reply to a request, by its number.
    replies: BTreeMap<u64, oneshot::Sender<Reply>>,
    n_requests: u64,
}

impl Worker<'_> {
    fn patience(&self) -> Duration {
        let longest = match self.solver {
            Some(_) => SOLVER_PERIOD,
            None => LONGEST_WAIT,
        };
        let due = self.core.poll_timeout();
        due.map_or(longest, |due| {
            longest.min(due.saturating_duration_since(Instant::now()))
        })
    }

    fn handle_batch(&mut self, batch: Batch) {
        if batch.missed > 0 {
            self.handle(Input::Missed(batch.missed));
        }
        (0..batch.n_published).for_each(|_| self.handle(Input::Published));
        batch.news.into_iter().for_each(|news| self.handle(news));
        for (request, reply) in batch.requests {
            self.n_requests += 1;
            self.replies.insert(self.n_requests, reply);
            self.handle(Input::Request(self.n_requests, request));
        }
        let images = batch.images.into_iter();
        images.for_each(|image| self.handle(Input::Image(image)));
    }

    fn handle(&mut self, input: Input) {
        self.core.handle(input, Instant::now());
        self.carry_out();
    }

    fn carry_out(&mut self) {
        while let Some(output) = self.core.poll_output() {
            match output {
                Output::Reply(number, reply) => self.reply(number, reply),
                Output::Publish(outgoing) => self.service.put_outgoing(outgoing),
                Output::Solve(number, procedure) => self.solve(number, procedure),
                Output::Write(product) => self.write(&product),
                Output::Show(state) => publish(self.hub, &state),
            }
        }
        self.service.inbox().want_images(self.core.is_collecting());
    }

    fn reply(&mut self, number: u64, reply: Reply) {
        if let Some(sender) = self.replies.remove(&number) {
            // Who asked may have gone.
            let _ = sender.send(reply);
        }
    }

    fn solve(&mut self, number: u64, procedure: Box<Procedure>) {
        let solve = move || {
            fail_point!("solve");
            procedure.solve().map_err(|error| error.to_string())
        };
        let thread = std::thread::Builder::new().name("solve".into());
        match thread.spawn(move || contained(solve)) {
            Ok(solver) => self.solver = Some((number, solver)),
            Err(error) => {
                let failed = Input::Solved(number, Err(error.to_string()));
                self.core.handle(failed, Instant::now());
            }
        }
    }

    fn poll_solver(&mut self) {
        let Some((number, solver)) = self.solver.take_if(|(_, solver)| solver.is_finished()) else {
            return;
        };
        let failed = "solving failed by a defect of this program; the log says more";
        let solved = solver.join().unwrap_or_else(|_| Err(String::new()));
        let result = solved.unwrap_or_else(|_| Err(failed.to_owned()));
        self.handle(Input::Solved(number, result.map(Box::new)));
    }

    fn write(&mut self, product: &Product) {
        let written = match self.service.folder() {
            Some(folder) => write_into(folder, product),
            None => Err("viewer.toml names no `folder`".to_owned()),
        };
        self.core.handle(Input::Written(written), Instant::now());
    }
}

/// Writes a wizard's result into the site's folder; returns a sentence with its path.
fn write_into(folder: &Path, product: &Product) -> Result<String, String> {
    let (path, written) = match product {
        Product::Rig(rig) => {
            let path = folder.join("rig.toml");
            let written = keep_rig(&path, rig);
            (path, written)
        }
        Product::Object(object) => {
            let path = folder.join(object_file(object.id()));
            let written = keep_object(&path, object);
            (path, written)
        }
    };
    written.map_err(|error| format!("the file could not be written: {error}"))?;
    let former = former_of(&path);
    Ok(match former.exists() {
        true => format!(
            "written to {}; the former one is {}",
            path.display(),
            former.display()
        ),
        false => format!("written to {}", path.display()),
    })
}

fn publish(hub: &Hub, state: &WizardState) {
    // One slot: it only fails when others have filled the hub.
    let _ = hub.publish(&Slot::Wizard, frame_of(state));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wizard::samples;
    use sextant_site_model::{ObjectId, ObjectModel};
    use std::fs;

    #[test]
    fn a_result_of_any_name_leaves_the_configuration_alone() {
        let folder = tempfile::tempdir().unwrap();
        let viewer = folder.path().join("viewer.toml");
        fs::write(&viewer, "site = \"lab\"\n").unwrap();
        let tags = samples::cube().tags().to_vec();
        let id = ObjectId::new("viewer").unwrap();
        let product = Product::Object(ObjectModel::new(id, tags).unwrap());
        let said = write_into(folder.path(), &product).unwrap();
        assert!(said.ends_with("objects/viewer.toml"), "{said}");
        assert_eq!(fs::read_to_string(&viewer).unwrap(), "site = \"lab\"\n");

        fs::write(folder.path().join("rig.toml"), "mine\n").unwrap();
        let said = write_into(folder.path(), &Product::Rig(samples::rig())).unwrap_err();
        assert!(said.contains("rig.toml: is left as it is"), "{said}");
        let kept = fs::read_to_string(folder.path().join("rig.toml")).unwrap();
        assert_eq!(kept, "mine\n");
    }
}
