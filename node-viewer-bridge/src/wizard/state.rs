//! The state of a wizard as clients receive it: the message `wizard` of `PROTOCOL.md`.

use crate::models::{self, ObjectTag, RigCamera};
use serde::{Serialize, Serializer};
use sextant_calibrator::procedure::{ProcedureKind, ProcedureOutcome, Product, Progress, Report};
use sextant_proto::{ObjectConfig, RigConfig};
use sextant_site_files::{object_toml, rig_toml};
use sextant_site_model::{ObjectModel, Rig};

/// The message, as it is written.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "wizard")]
pub(crate) struct WizardState {
    wizard: Option<ProcedureKind>,
    stage: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<String>,
    /// What went wrong last.
    #[serde(skip_serializing_if = "Option::is_none")]
    cause: Option<String>,
    /// Images that came while the wizard was busy.
    #[serde(skip_serializing_if = "Option::is_none")]
    missed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    progress: Option<Progress>,
    #[serde(skip_serializing_if = "Option::is_none")]
    result: Option<Shown>,
}

/// A result, as it is shown.
#[derive(Debug, Serialize)]
struct Shown {
    report: Report,
    model: Model,
    /// Name and text of the file that keeps it.
    file: String,
    toml: String,
    /// What became of it, a sentence each.
    kept: Vec<String>,
}

/// What was found, to be drawn.
#[derive(Debug)]
enum Model {
    Rig(Rig),
    Object(ObjectModel),
}

impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        #[serde(rename_all = "snake_case")]
        enum Drawn<'a> {
            Cameras(Vec<RigCamera<'a>>),
            Tags(Vec<ObjectTag>),
        }
        match self {
            Self::Rig(rig) => {
                let message = RigConfig::from(rig);
                let cameras = message.cameras.iter().map(models::camera);
                Drawn::Cameras(cameras.collect()).serialize(serializer)
            }
            Self::Object(object) => {
                let message = ObjectConfig::from(object);
                let tags = message.tags.iter().map(models::object_tag);
                Drawn::Tags(tags.collect()).serialize(serializer)
            }
        }
    }
}

impl WizardState {
    /// There is no wizard at work.
    pub(super) fn idle() -> Self {
        Self {
            wizard: None,
            stage: "idle",
            subject: None,
            cause: None,
            missed: None,
            progress: None,
            result: None,
        }
    }

    pub(super) fn starting(kind: ProcedureKind, subject: &str, cause: Option<&str>) -> Self {
        Self {
            wizard: Some(kind),
            subject: Some(subject.to_owned()),
            cause: cause.map(str::to_owned),
            ..Self::idle()
        }
    }

    pub(super) fn collecting(self, progress: Progress, missed: u64) -> Self {
        Self {
            stage: "collecting",
            progress: Some(progress),
            missed: Some(missed),
            ..self
        }
    }

    pub(super) fn solving(self, progress: Progress) -> Self {
        Self {
            stage: "solving",
            progress: Some(progress),
            ..self
        }
    }

    pub(super) fn solved(
        self,
        stage: &'static str,
        outcome: &ProcedureOutcome,
        kept: &[String],
    ) -> Self {
        let (file, toml) = file_of(&outcome.product);
        Self {
            stage,
            result: Some(Shown {
                report: outcome.report.clone(),
                model: match &outcome.product {
                    Product::Rig(rig) => Model::Rig(rig.clone()),
                    Product::Object(object) => Model::Object(object.clone()),
                },
                file,
                toml,
                kept: kept.to_vec(),
            }),
            ..self
        }
    }
}

/// Name and text of the file that a person may download.
fn file_of(product: &Product) -> (String, String) {
    match product {
        Product::Rig(rig) => ("rig.toml".to_owned(), rig_toml(rig)),
        Product::Object(object) => (format!("{}.toml", object.id()), object_toml(object)),
    }
}
