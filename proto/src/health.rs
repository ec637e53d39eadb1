//! The state of a node as monitoring tools show it: a level, a sentence, and what the node reports.

use crate::messages::camera_status::CameraStatus;
use crate::messages::fusion_status::{FusionStatus, ObjectHealth};

/// Levels of ROS's diagnostics, with their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum HealthLevel {
    /// Everything is well.
    Ok = 0,
    /// Something needs attention.
    Warning = 1,
    /// Something is wrong.
    Error = 2,
}

/// How a node is doing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeHealth {
    /// The worst that it reports.
    pub level: HealthLevel,
    /// That in a sentence.
    pub message: String,
    /// Everything that it reports, a sentence each.
    pub findings: Vec<String>,
}

impl CameraStatus {
    /// A warning if no image arrived in the last seconds.
    #[must_use]
    pub fn health(&self) -> NodeHealth {
        let findings: Vec<String> = self.notices.iter().map(ToString::to_string).collect();
        let is_silent = self.rate_hz <= 0.0;
        let message = match findings.last() {
            Some(notice) => notice.clone(),
            None if is_silent => "no images".to_owned(),
            None => format!("{:.1} images/s", self.rate_hz),
        };
        let level = if is_silent {
            HealthLevel::Warning
        } else {
            HealthLevel::Ok
        };
        NodeHealth {
            level,
            message,
            findings,
        }
    }
}

impl FusionStatus {
    /// An error if the site has a fault, a warning if the node has a notice.
    #[must_use]
    pub fn health(&self) -> NodeHealth {
        let faults = self.faults.iter().map(ToString::to_string);
        let notices = self.notices.iter().map(ToString::to_string);
        let findings: Vec<String> = faults.chain(notices).collect();
        let message = findings.first().cloned();
        NodeHealth {
            level: match (self.faults.is_empty(), findings.is_empty()) {
                (false, _) => HealthLevel::Error,
                (true, false) => HealthLevel::Warning,
                (true, true) => HealthLevel::Ok,
            },
            message: message.unwrap_or_else(|| format!("{} objects", self.objects.len())),
            findings,
        }
    }
}

impl ObjectHealth {
    /// State and rate, such as "tracking, 30.0 poses/s".
    #[must_use]
    pub fn summary(&self) -> String {
        format!("{:?}, {:.1} poses/s", self.state, self.rate_hz).to_lowercase()
    }
}
