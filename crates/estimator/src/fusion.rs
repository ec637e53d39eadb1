//! The machine: images in, poses out. It has no clock and no socket; the same inputs give the same outputs.

use std::collections::VecDeque;

use thiserror::Error;

use crate::{
    FusionOptions, ImageObservation, ObjectEstimate, ObjectId, ObjectModel, OptionsError, Rig,
    Statistics, TagId,
};

/// What can be told to the machine.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// An image's corners.
    Image(ImageObservation),
    /// The cameras have changed: taken whole.
    Rig(Rig),
    /// The objects have changed: taken whole or refused whole.
    Objects(Vec<ObjectModel>),
    /// Time has passed.
    Tick,
}

/// What the machine has to say.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// An object's pose at the capture time of an image.
    Pose(ObjectEstimate),
    /// New objects contradict each other; the old ones stay.
    Refused(ModelError),
}

/// Why objects can't be tracked together.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// Two objects of one name.
    #[error("object {0} is there twice")]
    DuplicateObject(ObjectId),
    /// One tag on two objects.
    #[error("tag {tag} is on object {first} and on object {second}")]
    SharedTag {
        /// The tag.
        tag: TagId,
        /// The object that has it.
        first: ObjectId,
        /// The object that claims it too.
        second: ObjectId,
    },
    /// A tunable outside of its range.
    #[error("options: {0}")]
    Options(#[from] OptionsError),
}

/// Fuses the images of all cameras into one pose per object.
#[derive(Debug)]
pub struct Fusion {
    outputs: VecDeque<Output>,
    statistics: Statistics,
}

impl Fusion {
    /// A machine for these cameras and objects.
    ///
    /// # Errors
    /// When objects share a name or a tag, or an option is outside of its range.
    pub fn new(
        _rig: Rig,
        _objects: Vec<ObjectModel>,
        options: FusionOptions,
    ) -> Result<Self, ModelError> {
        options.validate()?;
        Ok(Self {
            outputs: VecDeque::new(),
            statistics: Statistics::default(),
        })
    }

    /// Takes an input in; `now_ns` is the present in ns since the Unix epoch.
    pub fn handle(&mut self, _now_ns: u64, _input: Input) {}

    /// The next thing to say, oldest first.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When to call `handle` with [`Input::Tick`] at the latest, if nothing else comes.
    pub fn poll_timeout(&self) -> Option<u64> {
        None
    }

    /// Counts since the start.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }
}
