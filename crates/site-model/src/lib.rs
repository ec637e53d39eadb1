//! The data of a site: cameras, objects with tags, and observations of images.
//!
//! - [`Rig`]: cameras with lens, pose, shutter and exposure.
//! - [`ObjectModel`]: a constellation of tags, rigid or on the links of an [`Articulation`].
//! - [`Prior`]: what is known of the error of a pose, lens or size; [`default_sigmas`]: what is assumed without one.
//! - [`ImageObservation`]: the tag corners that one image shows, with its capture time.
//!
//! Plain checked data in metres, radians, pixels with (0, 0) at the centre of the top-left pixel, and nanoseconds since
//! the Unix epoch. This crate estimates nothing and reads no file.

mod articulation;
mod defaults;
mod ids;
mod object;
mod observation;
mod prior;
mod rig;

pub use articulation::{
    Articulation, ArticulationError, Joint, JointKind, MOST_JOINTS, MOST_LINKS,
};
pub use defaults::{
    BEND_SIGMA, CENTRE_SIGMA, CLOCK_SIGMA_S, DISTORTION_SIGMA, DefaultSigma, FOCAL_SIGMA,
    MISPRINT_SIGMA, READOUT_SIGMA_S, SIZE_SIGMA, UNCHECKED_FOCAL_SIGMA, UNKNOWN_CENTRE_SIGMA,
    UNKNOWN_FOCAL_SIGMA, UNKNOWN_RADIAL_SIGMA, UNKNOWN_TANGENTIAL_SIGMA, default_sigmas,
};
pub use ids::{CameraId, IdError, JointId, LinkId, ObjectId, TagId};
pub use object::{ObjectError, ObjectModel, ObjectTag, posed_objects};
pub use observation::{ImageObservation, TagCorners};
pub use prior::{Deviation, Prior};
pub use rig::{
    Camera, Exposure, LensSigma, MOST_LENS_SIGMA_PX, Mount, PoseSigma, Rig, RigError, Stamp,
    is_finite,
};
