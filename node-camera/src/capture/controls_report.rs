//! What became of the site's settings, for the detecting part, which publishes it.

use sextant_proto::{CameraControls, Control, SettingsOutcome, limits};

use crate::settings_files::SettingsFiles;

/// Values this near count as the same: drivers count in steps.
const TOLERANCE: f64 = 0.005;

/// A setting as people name it.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    /// Values of the message in one of the unit.
    divisor: f64,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        name: "exposure",
        unit: " ms",
        divisor: 1000.0,
    },
    Quantity {
        name: "gain",
        unit: "",
        divisor: 1.0,
    },
    Quantity {
        name: "rate",
        unit: " images/s",
        divisor: 1.0,
    },
];

/// The report, written when it changes.
#[derive(Debug)]
pub(super) struct ControlsReport {
    files: SettingsFiles,
    wanted: [Option<f64>; 3],
    refusal: Option<String>,
    written: Option<CameraControls>,
}

impl ControlsReport {
    /// Of a camera for which the site has no settings yet.
    pub(super) fn new(files: SettingsFiles) -> Self {
        Self {
            files,
            wanted: [None; 3],
            refusal: None,
            written: None,
        }
    }

    /// The site wants these values of exposure, gain and rate, which are in force but for a `refusal`.
    pub(super) fn set(&mut self, wanted: [Option<f64>; 3], refusal: Option<String>) {
        (self.wanted, self.refusal) = (wanted, refusal);
    }

    /// Takes what the source has now; none while it cannot be reached.
    pub(super) fn update(&mut self, controls: Option<CameraControls>) {
        let outcome = self.outcome(controls.as_ref());
        let controls = controls.unwrap_or_default().wanting(self.wanted, outcome);
        if self.written.as_ref() == Some(&controls) {
            return;
        }
        match self.files.write_controls(&controls) {
            Ok(()) => self.written = Some(controls),
            Err(cause) => {
                tracing::warn!(%cause, "the status cannot say which exposure, gain and rate are in force")
            }
        }
    }

    fn outcome(&self, controls: Option<&CameraControls>) -> SettingsOutcome {
        match (&self.refusal, controls) {
            _ if self.wanted == [None; 3] => SettingsOutcome::None,
            (Some(detail), _) => SettingsOutcome::Refused {
                detail: limits::clipped(detail, limits::MAX_DETAIL_BYTES),
            },
            (None, None) => SettingsOutcome::Pending,
            (None, Some(controls)) => judge(self.wanted, controls),
        }
    }
}

/// Compares what is in force with what is wanted.
fn judge(wanted: [Option<f64>; 3], controls: &CameraControls) -> SettingsOutcome {
    let controls = [&controls.exposure_us, &controls.gain, &controls.rate_hz];
    let mut complaints = Vec::new();
    let mut n_settable = 0;
    for ((quantity, control), wanted) in QUANTITIES.iter().zip(controls).zip(wanted) {
        let Some(wanted) = wanted else { continue };
        n_settable += usize::from(is_settable(control));
        complaints.extend(complaint(quantity, control, wanted));
    }
    if complaints.is_empty() {
        return SettingsOutcome::Applied;
    }
    let detail = limits::clipped(&complaints.join("; "), limits::MAX_DETAIL_BYTES);
    match n_settable {
        0 => SettingsOutcome::Refused { detail },
        _ => SettingsOutcome::Adjusted { detail },
    }
}

fn is_settable(control: &Control) -> bool {
    control.value.is_some() || control.range.is_some()
}

fn complaint(quantity: &Quantity, control: &Control, wanted: f64) -> Option<String> {
    let Quantity {
        name,
        unit,
        divisor,
    } = quantity;
    let Some(value) = control.value else {
        return Some(match is_settable(control) {
            true => format!("the camera keeps choosing its {name} by itself"),
            false => format!("the camera has no adjustable {name}; set it to `file`"),
        });
    };
    if (value - wanted).abs() <= TOLERANCE * wanted.abs() {
        return None;
    }
    let range = control.range.map_or_else(String::new, |range| {
        let [least, greatest] = range.map(|end| end / divisor);
        format!(", possible are {least} to {greatest}{unit}")
    });
    let [value, wanted] = [value, wanted].map(|value| value / divisor);
    Some(format!(
        "{name} {value}{unit} instead of {wanted}{unit}{range}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control(value: Option<f64>, range: Option<[f64; 2]>) -> Control {
        Control {
            wanted: None,
            value,
            range,
        }
    }

    fn controls() -> CameraControls {
        CameraControls {
            exposure_us: control(Some(3990.0), Some([100.0, 33_000.0])),
            gain: control(None, None),
            rate_hz: control(Some(25.0), None),
            ..CameraControls::default()
        }
    }

    fn detail(outcome: SettingsOutcome) -> String {
        match outcome {
            SettingsOutcome::Adjusted { detail } => format!("adjusted: {detail}"),
            SettingsOutcome::Refused { detail } => format!("refused: {detail}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_camera_that_has_what_is_wanted_has_it_applied() {
        let wanted = [Some(4000.0), None, Some(25.0)];
        assert_eq!(judge(wanted, &controls()), SettingsOutcome::Applied);
    }

    #[test]
    fn what_differs_is_named_with_the_range() {
        let said = detail(judge([Some(50.0), Some(2.0), None], &controls()));
        assert!(said.starts_with(
            "adjusted: exposure 3.99 ms instead of 0.05 ms, possible are 0.1 to 33 ms"
        ));
        assert!(said.ends_with("the camera has no adjustable gain; set it to `file`"));
        let said = detail(judge([None, Some(2.0), None], &controls()));
        assert!(said.starts_with("refused"), "{said}");
    }

    #[test]
    fn a_camera_out_of_reach_has_settings_pending() {
        let folder = tempfile::tempdir().unwrap();
        let mut report = ControlsReport::new(SettingsFiles::in_folder(folder.path()));
        report.update(Some(controls()));
        assert_eq!(report.files.controls(), controls());
        report.set([Some(4000.0), None, None], None);
        report.update(None);
        assert_eq!(report.files.controls().outcome, SettingsOutcome::Pending);
        report.update(Some(controls()));
        assert_eq!(report.files.controls().outcome, SettingsOutcome::Applied);
        report.set([None; 3], None);
        report.update(Some(controls()));
        assert_eq!(report.files.controls(), controls());
    }
}
