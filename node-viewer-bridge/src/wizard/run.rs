//! The wizard's thread: processes images, starts a thread for each solve, writes files, publishes the state.

use super::machine::Job;
use super::service::WizardService;
use super::state::WizardState;
use crate::frame::frame_of;
use crate::hub::{Hub, Slot};
use sextant_calibrator::procedure::{Procedure, ProcedureOutcome, Product};
use sextant_process::{Shutdown, fail_point, panics::contained};
use sextant_site_files::{former_of, keep_object, keep_rig, object_file};
use sextant_site_model::ImageObservation;
use std::path::Path;
use std::sync::mpsc::Receiver;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait for an image: bounds the delay of commands and of a shutdown.
const POLL_PERIOD: Duration = Duration::from_millis(30);
/// Most images processed between two polls.
const MOST_AT_ONCE: usize = 64;
/// Least time between two published states: as often as a person can follow.
const STATE_PERIOD: Duration = Duration::from_millis(150);

/// Runs until `shutdown`. A solve that is at work then ends with the process.
pub(crate) fn run(service: &WizardService, hub: &Hub, shutdown: &Shutdown) {
    let Some(images) = service.take_worker() else {
        return;
    };
    publish(hub, &WizardState::idle());
    let mut worker = Worker {
        service,
        hub,
        solver: None,
        state_due: Instant::now(),
    };
    while !shutdown.is_requested() {
        fail_point!("wizard");
        worker.take_images(&images);
        worker.work();
        worker.poll_solver();
        worker.publish_state();
    }
}

/// What a solve came to.
type Solved = Result<ProcedureOutcome, String>;

struct Worker<'a> {
    service: &'a WizardService,
    hub: &'a Hub,
    solver: Option<(u64, JoinHandle<Result<Solved, String>>)>,
    state_due: Instant,
}

impl Worker<'_> {
    fn take_images(&self, images: &Receiver<Box<ImageObservation>>) {
        let Ok(first) = images.recv_timeout(POLL_PERIOD) else {
            return;
        };
        self.service.image(&first);
        for image in images.try_iter().take(MOST_AT_ONCE) {
            self.service.image(&image);
        }
    }

    fn work(&mut self) {
        for job in self.service.tick(Instant::now()) {
            match job {
                Job::Solve(number, procedure) => self.solve(number, procedure),
                Job::Publish(outgoing) => self.service.post(outgoing),
                Job::Write(product) => self.service.written(self.write(&product)),
            }
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
            Err(error) => self.service.solved(number, Err(error.to_string())),
        }
    }

    fn poll_solver(&mut self) {
        let Some((number, solver)) = self.solver.take_if(|(_, solver)| solver.is_finished()) else {
            return;
        };
        let failed = "solving failed by a defect of this program; the log says more";
        let solved = solver.join().unwrap_or_else(|_| Err(String::new()));
        let result = solved.unwrap_or_else(|_| Err(failed.to_owned()));
        self.service.solved(number, result);
    }

    fn write(&self, product: &Product) -> Result<String, String> {
        match self.service.folder() {
            Some(folder) => write_into(folder, product),
            None => Err("viewer.toml names no `folder`".to_owned()),
        }
    }

    fn publish_state(&mut self) {
        if Instant::now() < self.state_due {
            return;
        }
        if let Some(state) = self.service.news() {
            self.state_due = Instant::now() + STATE_PERIOD;
            publish(self.hub, &state);
        }
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
