//! Outbound messages: sent directly, or through the network faults of a scenario for a simulated camera.
//!
//! Faults follow from the seed of the scenario. Messages in flight are bounded; lost ones are counted.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use sextant_proto::Observations;
use sextant_simulator::{Network, NetworkFaults, Scenario};
use sextant_site_files::read_toml;
use sextant_site_model::CameraId;

use crate::config::SourceConfig;

/// Path of outbound messages.
pub(super) enum Outbound {
    /// Directly to the network.
    Direct,
    /// Through simulated faults, as the camera of this index.
    Faulty(Box<Network<Observations>>, usize),
}

impl Outbound {
    /// The path for a camera: with faults if its scenario has any.
    ///
    /// # Errors
    /// An invalid scenario file.
    pub(super) fn for_source(source: &SourceConfig, camera: &CameraId) -> anyhow::Result<Self> {
        match source {
            SourceConfig::Simulator { scenario, .. } => Self::simulated(scenario, camera),
            SourceConfig::Images { .. }
            | SourceConfig::V4l2(_)
            | SourceConfig::Rza2m(_)
            | SourceConfig::Command(_)
            | SourceConfig::Video(_) => Ok(Self::Direct),
        }
    }

    fn simulated(file: &Path, camera: &CameraId) -> anyhow::Result<Self> {
        let scenario: Scenario = read_toml(file).context("the scenario's network")?;
        let index = scenario.camera_index(camera.as_str());
        let faulty =
            index.filter(|index| scenario.cameras[*index].network != NetworkFaults::default());
        Ok(faulty.map_or(Self::Direct, |index| {
            Self::Faulty(Box::new(Network::new(&scenario)), index)
        }))
    }

    /// Whether a message is to be published immediately; else a copy of it is on its way from `now_ns` on.
    pub(super) fn passes(&mut self, message: &Observations, now_ns: u64) -> bool {
        match self {
            Self::Direct => true,
            Self::Faulty(network, camera) => {
                network.send(*camera, now_ns, message.capture_ns, message.clone());
                false
            }
        }
    }

    /// The next message that has arrived by `now_ns`.
    pub(super) fn receive(&mut self, now_ns: u64) -> Option<Observations> {
        match self {
            Self::Direct => None,
            Self::Faulty(network, _) => network.receive(now_ns).map(|arrival| arrival.payload),
        }
    }

    /// How long it is until the next message arrives, at most `longest`.
    pub(super) fn wait_at_most(&self, longest: Duration, now_ns: u64) -> Duration {
        let next_ns = match self {
            Self::Direct => None,
            Self::Faulty(network, _) => network.next_arrival_ns(),
        };
        let wait = next_ns.map(|next_ns| Duration::from_nanos(next_ns.saturating_sub(now_ns)));
        wait.map_or(longest, |wait| wait.min(longest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ClockQuality, Timing};

    fn outbound(faults: NetworkFaults) -> (Outbound, CameraId) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        let mut scenario = Scenario::demo(2, 1, 3);
        scenario.cameras[1].network = faults;
        sextant_site_files::write_toml(&file, &scenario).unwrap();
        let camera = CameraId::new(&scenario.cameras[1].id).unwrap();
        let source = SourceConfig::simulator(&file);
        (Outbound::for_source(&source, &camera).unwrap(), camera)
    }

    fn message(camera: &CameraId, sequence: u64) -> Observations {
        Observations {
            camera: camera.clone(),
            sequence,
            capture_ns: sequence * 1_000_000,
            exposure_ns: 0,
            clock: ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        }
    }

    #[test]
    fn a_network_without_faults_is_no_detour() {
        let (mut outbound, camera) = outbound(NetworkFaults::default());
        assert!(outbound.passes(&message(&camera, 1), 5));
        assert!(outbound.receive(u64::MAX).is_none());
    }

    #[test]
    fn messages_are_late_lost_and_doubled_as_the_scenario_says() {
        let (mut outbound, camera) = outbound(NetworkFaults {
            loss: 0.2,
            delay_ms: 20.0,
            duplicate: 0.1,
            ..NetworkFaults::default()
        });
        for sequence in 0..200 {
            let sent_ns = sequence * 1_000_000;
            assert!(!outbound.passes(&message(&camera, sequence), sent_ns));
        }
        let wait = outbound.wait_at_most(Duration::from_secs(1), 0);
        assert!(wait >= Duration::from_millis(20), "{wait:?}");
        let arrived: Vec<u64> = std::iter::from_fn(|| outbound.receive(u64::MAX))
            .map(|message| message.sequence)
            .collect();
        let mut different = arrived.clone();
        different.sort_unstable();
        different.dedup();
        assert!((140..190).contains(&different.len()), "{}", different.len());
        assert!(arrived.len() > different.len());
    }
}
