//! A turn of a fusion node: what its process hands over to [`FusionCore`], and in which order. The process takes its
//! turns here, and so do simulations of it.

use crate::fusion_core::{Action, FusionCore, HostState};
use sextant_election::{Link, Moment};
use sextant_estimator::SolverTask;
use sextant_proto::NodeId;
use sextant_zenoh_bus::{Item, Presence};

/// Most messages under keys of the configuration that are read in one turn.
pub const MOST_REQUESTS: usize = 256;

/// The process around a fusion node: clock, queues, files and network.
pub trait Environment {
    /// Why an action failed.
    type Error;

    /// Now, by both clocks of the host.
    fn now(&self) -> Moment;
    /// Step of the wall clock since the last call, ns.
    fn take_clock_step(&mut self) -> Option<i64>;
    /// State of the link to the network.
    fn link(&self) -> Link;
    /// The next fusion node that has come or gone.
    fn next_presence(&mut self) -> Option<Presence>;
    /// The next heartbeat of a fusion node.
    fn next_heartbeat(&mut self) -> Option<Item>;
    /// The observation of this turn.
    fn next_observation(&mut self) -> Option<Item>;
    /// The next message under a key of the configuration.
    fn next_request(&mut self) -> Option<Item>;
    /// What became of the last [`Action::Keep`], once it is done.
    fn kept(&mut self) -> Option<Result<(), String>>;
    /// The answers to the last [`Action::Ask`], once they are complete.
    fn answers(&mut self) -> Option<(NodeId, Vec<Item>)>;
    /// State of the host, for the status.
    fn host(&mut self) -> HostState;
    /// Carries an action out.
    ///
    /// # Errors
    /// Where the process cannot go on.
    fn act(&mut self, action: Action, core: &FusionCore) -> Result<(), Self::Error>;
    /// Has an adjustment solved, which may take long.
    fn solve(&mut self, task: &SolverTask);
}

impl FusionCore {
    /// Takes an observation, if there is one, and does all that is due. Images go before changes of the models.
    ///
    /// # Errors
    /// Of [`Environment::act`].
    pub fn turn<E: Environment>(&mut self, environment: &mut E) -> Result<(), E::Error> {
        let stepped = environment.take_clock_step();
        let now = environment.now();
        if let Some(by_ns) = stepped {
            self.clock_stepped(by_ns, now);
        }
        self.link(environment.link(), now);
        while let Some(change) = environment.next_presence() {
            self.presence(&change, now);
        }
        while let Some(item) = environment.next_heartbeat() {
            self.heartbeat(&item, now);
        }
        self.update_duty(now);
        self.act(environment)?;
        if let Some(item) = environment.next_observation() {
            self.observation(&item, now);
            self.act(environment)?;
        }
        self.update_from(environment)?;
        let now = environment.now();
        self.tick(now);
        if self.is_report_due(now) {
            self.report(environment.host(), now);
        }
        self.act(environment)?;
        if let Some(task) = self.task() {
            environment.solve(&task);
        }
        Ok(())
    }

    /// Carries out what is to be done.
    ///
    /// # Errors
    /// Of [`Environment::act`].
    pub fn act<E: Environment>(&mut self, environment: &mut E) -> Result<(), E::Error> {
        while let Some(action) = self.poll(environment.now()) {
            environment.act(action, self)?;
        }
        Ok(())
    }

    /// Files that were written, models of other nodes, and requests.
    fn update_from<E: Environment>(&mut self, environment: &mut E) -> Result<(), E::Error> {
        if let Some(outcome) = environment.kept() {
            self.kept(outcome, environment.now());
        }
        if let Some((node, items)) = environment.answers() {
            self.follow(&node, &items, environment.now());
        }
        for _ in 0..MOST_REQUESTS {
            if !self.takes_requests(environment.now()) {
                break;
            }
            let Some(item) = environment.next_request() else {
                break;
            };
            self.config(&item, environment.now());
            self.act(environment)?;
        }
        Ok(())
    }
}
