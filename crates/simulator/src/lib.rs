//! Seeded scenes rendered to images, with truth, clock and network faults.
//!
//! A [`Scenario`] is plain data; a [`Renderer`] makes a camera's images of it, an [`Observer`] ideal observations
//! without images, a [`Network`] late, lost and reordered messages. Pure: no clock, no file, time is an argument (true
//! time in ns). Truth comes from [`SceneObject::world_from_object`] and [`SceneObject::twist`]. Nothing here detects or
//! estimates: the simulator never uses what it tests.

mod clock;
mod coverage;
mod model;
mod network;
mod observe;
mod optics;
mod path;
mod polygon;
mod pose_format;
mod random;
mod renderer;
mod scenario;
mod view;

pub use clock::{Clock, ClockFaults, Schedule};
pub use network::{Arrival, MAX_UNDER_WAY, Network};
pub use observe::{ObservedTag, Observer, Occlusion, Visibility};
pub use path::{Harmonic, Path, PathEvent, PathJoint, PathJointKind, Wave};
pub use random::Random;
pub use renderer::{Renderer, WrongImageSize};
pub use scenario::{
    AutoExposure, Background, CameraFileError, Curl, Displacement, Face, Flicker, Imperfections,
    LensResidual, Light, Mosaic, NetworkFaults, Scenario, ScenarioError, SceneCamera, SceneObject,
    SceneTag, Solid,
};
