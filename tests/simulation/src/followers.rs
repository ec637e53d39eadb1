//! Those who follow the models of the site: cameras, as the nodes do, and the client, as tools do.

use crate::plan::MS;
use node_camera::SiteModels;
use sextant_proto::{CameraSettings, Keys, NodeId, NodeKind};
use sextant_site_mirror::Renewal;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Item, Presence};
use std::collections::{BTreeMap, BTreeSet};

/// Between two looks for changes.
pub const UPDATE_NS: u64 = 200 * MS;
/// How long answers are waited for.
pub const ANSWER_NS: u64 = 500 * MS;

/// Someone who follows.
pub struct Follower {
    keys: Keys,
    /// The fusion nodes whose tokens it sees.
    pub seen: BTreeSet<usize>,
    question: Option<Question>,
    asked: u64,
    process: Process,
}

enum Process {
    Camera {
        models: Box<SiteModels>,
        /// In shared memory: outlives the process.
        settings: CameraSettings,
    },
    Client(Renewal<Item>),
}

/// What is asked for, until the last answer.
struct Question {
    number: u64,
    awaited: BTreeSet<usize>,
    items: BTreeMap<String, Item>,
}

impl Follower {
    /// A camera that knows nothing yet.
    #[must_use]
    pub fn camera(keys: &Keys, camera: CameraId) -> Self {
        let settings = CameraSettings::none(camera);
        let models = Box::new(SiteModels::new(keys.clone(), settings.clone()));
        Self::new(keys, Process::Camera { models, settings })
    }

    /// The client.
    #[must_use]
    pub fn client(keys: &Keys) -> Self {
        Self::new(keys, Process::Client(Renewal::default()))
    }

    fn new(keys: &Keys, process: Process) -> Self {
        Self {
            keys: keys.clone(),
            seen: BTreeSet::new(),
            question: None,
            asked: 0,
            process,
        }
    }

    /// Its process starts anew, on a host that has kept its shared memory or not.
    pub fn restart(&mut self, has_kept_memory: bool) {
        self.seen.clear();
        self.question = None;
        match &mut self.process {
            Process::Camera { models, settings } => {
                if !has_kept_memory {
                    *settings = CameraSettings::none(settings.camera.clone());
                }
                **models = SiteModels::new(self.keys.clone(), settings.clone());
            }
            Process::Client(renewal) => *renewal = Renewal::default(),
        }
    }

    /// The models of a camera.
    #[must_use]
    pub fn models(&self) -> Option<&SiteModels> {
        match &self.process {
            Process::Camera { models, .. } => Some(models),
            Process::Client(_) => None,
        }
    }

    /// Whether messages of this key reach it.
    #[must_use]
    pub fn subscribes(&self, key: &str) -> bool {
        match &self.process {
            Process::Camera { models, .. } => models.keys().iter().any(|own| covers(own, key)),
            Process::Client(_) => true,
        }
    }

    /// A fusion node comes, or goes.
    pub fn presence(&mut self, node: &NodeId, has_come: bool) {
        let key = self.keys.alive(NodeKind::Fusion, node);
        match &mut self.process {
            Process::Camera { models, .. } if has_come => models.presence(&Presence::Joined(key)),
            Process::Camera { models, .. } => models.presence(&Presence::Left(key)),
            Process::Client(renewal) if has_come => renewal.joined(),
            Process::Client(_) => {}
        }
    }

    /// Whether it asks those who keep the models, and the number of its question.
    pub fn update(&mut self, is_linked: bool, at_ns: u64) -> Option<u64> {
        let asks = match &mut self.process {
            Process::Camera { models, settings } => {
                models.link(is_linked);
                if let Some(new) = models.poll_settings() {
                    *settings = new.clone();
                }
                models.asks(at_ns)
            }
            Process::Client(renewal) => {
                renewal.link(is_linked);
                renewal.take_due(at_ns)
            }
        };
        asks.then(|| {
            self.asked += 1;
            self.asked
        })
    }

    /// Waits for the answers of these nodes.
    pub fn wait_for(&mut self, number: u64, awaited: BTreeSet<usize>) {
        self.question = Some(Question {
            number,
            awaited,
            items: BTreeMap::new(),
        });
    }

    /// A node answers; whether it was the last one.
    pub fn answer(&mut self, number: u64, node: usize, items: Vec<Item>) -> bool {
        let is_it = |question: &&mut Question| question.number == number;
        let Some(question) = self.question.as_mut().filter(is_it) else {
            return false;
        };
        question.awaited.remove(&node);
        let items = items.into_iter().map(|item| (item.key.clone(), item));
        question.items.extend(items);
        question.awaited.is_empty()
    }

    /// Nobody answers a question any more; what the client has to use.
    pub fn end_question(&mut self, number: u64, at_ns: u64) -> Vec<Item> {
        let is_it = |question: &mut Question| question.number == number;
        let Some(question) = self.question.take_if(is_it) else {
            return Vec::new();
        };
        let are_all = question.awaited.is_empty();
        let mut items: Vec<Item> = question.items.into_values().collect();
        match &mut self.process {
            Process::Camera { models, .. } => {
                models.answered(&items, are_all, at_ns);
                Vec::new()
            }
            Process::Client(renewal) => {
                items.extend(std::iter::from_fn(|| renewal.next_held()));
                items
            }
        }
    }

    /// A message arrives; what the client has to use.
    pub fn handle(&mut self, item: Item, at_ns: u64) -> Option<Item> {
        match &mut self.process {
            Process::Camera { models, .. } => {
                models.handle(item, at_ns);
                None
            }
            Process::Client(renewal) => {
                let is_model = self
                    .keys
                    .parse(&item.key)
                    .is_some_and(|key| key.is_config());
                match is_model {
                    true => renewal.hold(item),
                    false => Some(item),
                }
            }
        }
    }
}

/// Whether a key expression whose last part may be a star covers a key.
fn covers(expression: &str, key: &str) -> bool {
    match expression.strip_suffix('*') {
        Some(root) => key
            .strip_prefix(root)
            .is_some_and(|rest| !rest.contains('/')),
        None => expression == key,
    }
}
