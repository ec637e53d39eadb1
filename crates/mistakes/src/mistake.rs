//! The kinds of mistakes, and how each of them changes the site's models.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::{Lens, Pose};
use sextant_site_model::PoseSigma;

use crate::site::{NominalSite, View};

/// One mistake, with the values that are right if it was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mistake {
    /// A camera is somewhere else.
    CameraMoved {
        /// Which camera.
        camera: usize,
        /// Where it is: maps points of the camera into the world.
        world_from_camera: Pose,
        /// Standard deviation of that.
        sigma: PoseSigma,
    },
    /// A camera is turned about its line of sight, as a phone held in the other landscape.
    CameraTurned {
        /// Which camera.
        camera: usize,
        /// By so many right angles about its z axis, 1 to 3.
        quarters: u8,
    },
    /// Each of two cameras has the name of the other: its lens and its place are those of the other.
    CamerasExchanged {
        /// The one.
        a: usize,
        /// The other.
        b: usize,
    },
    /// A camera has another lens, or another zoom.
    LensChanged {
        /// Which camera.
        camera: usize,
        /// Its focal length over that of the file.
        ratio: f64,
    },
    /// A camera's clock is ahead.
    ClockOff {
        /// Which camera.
        camera: usize,
        /// By how much, s; below zero where it is behind.
        offset_s: f64,
    },
    /// A whole body was printed or built at another scale: places and sizes of its tags.
    BodyScaled {
        /// Which body.
        body: usize,
        /// Its size over that of the file.
        ratio: f64,
    },
    /// All tags of a body were printed at another scale, and stuck on where the file says.
    SizesScaled {
        /// Which body.
        body: usize,
        /// Their size over that of the file.
        ratio: f64,
    },
    /// A tag was stuck on turned by right angles in its plane.
    TagTurned {
        /// Which tag.
        tag: usize,
        /// By so many right angles about its z axis, 1 to 3.
        quarters: u8,
    },
    /// Each of two tags of a body is where the other should be.
    TagsExchanged {
        /// The one.
        a: usize,
        /// The other.
        b: usize,
    },
    /// A tag is of another size.
    TagResized {
        /// Which tag.
        tag: usize,
        /// Its size over that of the file.
        ratio: f64,
    },
    /// A tag is somewhere else on its body.
    TagMoved {
        /// Which tag.
        tag: usize,
        /// Where it is: maps points of the tag into the body.
        body_from_tag: Pose,
    },
}

impl Mistake {
    /// The site as it is if the mistake was made.
    #[must_use]
    pub fn amended(&self, site: &NominalSite) -> NominalSite {
        let mut site = site.clone();
        self.amend(&mut site);
        site
    }

    fn amend(&self, site: &mut NominalSite) {
        let NominalSite { cameras, tags } = site;
        match *self {
            Self::CameraMoved {
                camera,
                world_from_camera,
                sigma: _,
            } => {
                if let Some(camera) = &mut cameras[camera] {
                    camera.world_from_camera = world_from_camera;
                }
            }
            Self::CameraTurned { camera, quarters } => {
                if let Some(camera) = &mut cameras[camera] {
                    camera.world_from_camera *= turn(quarters);
                }
            }
            Self::CamerasExchanged { a, b } => cameras.swap(a, b),
            Self::LensChanged { camera, ratio } => {
                if let Some(camera) = &mut cameras[camera] {
                    camera.lens = zoomed(&camera.lens, ratio);
                }
            }
            Self::ClockOff { camera, offset_s } => {
                if let Some(camera) = &mut cameras[camera] {
                    camera.clock_s += offset_s;
                }
            }
            Self::BodyScaled { body, ratio } => {
                for tag in tags.iter_mut().filter(|tag| tag.body == body) {
                    tag.size_m *= ratio;
                    tag.body_from_tag.translation.vector *= ratio;
                }
            }
            Self::SizesScaled { body, ratio } => {
                let own = tags.iter_mut().filter(|tag| tag.body == body);
                own.for_each(|tag| tag.size_m *= ratio);
            }
            Self::TagTurned { tag, quarters } => tags[tag].body_from_tag *= turn(quarters),
            Self::TagsExchanged { a, b } => {
                let place = tags[a].body_from_tag;
                tags[a].body_from_tag = tags[b].body_from_tag;
                tags[b].body_from_tag = place;
            }
            Self::TagResized { tag, ratio } => tags[tag].size_m *= ratio,
            Self::TagMoved { tag, body_from_tag } => tags[tag].body_from_tag = body_from_tag,
        }
    }

    /// The cameras that it is a mistake of.
    pub fn cameras(&self) -> Vec<usize> {
        match *self {
            Self::CameraMoved { camera, .. }
            | Self::CameraTurned { camera, .. }
            | Self::LensChanged { camera, .. }
            | Self::ClockOff { camera, .. } => vec![camera],
            Self::CamerasExchanged { a, b } => vec![a, b],
            _ => Vec::new(),
        }
    }

    /// The tags that it is a mistake of, by index.
    pub fn tags(&self, site: &NominalSite) -> Vec<usize> {
        match *self {
            Self::BodyScaled { body, .. } | Self::SizesScaled { body, .. } => {
                let tags = site.tags.iter().enumerate();
                let own = tags.filter(|(_, tag)| tag.body == body);
                own.map(|(index, _)| index).collect()
            }
            Self::TagTurned { tag, .. }
            | Self::TagResized { tag, .. }
            | Self::TagMoved { tag, .. } => vec![tag],
            Self::TagsExchanged { a, b } => vec![a, b],
            _ => Vec::new(),
        }
    }

    /// Whether it may happen to a site that has been right: cameras are touched and tags come off, while names and
    /// prints stay.
    pub fn is_sudden(&self) -> bool {
        matches!(
            self,
            Self::CameraMoved { .. }
                | Self::CameraTurned { .. }
                | Self::LensChanged { .. }
                | Self::ClockOff { .. }
                | Self::TagMoved { .. }
        )
    }

    /// How many numbers are free in it: of two mistakes that explain the same, the simpler one was made.
    pub fn n_parameters(&self) -> usize {
        match self {
            Self::CameraMoved { .. } | Self::TagMoved { .. } => 6,
            Self::LensChanged { .. }
            | Self::ClockOff { .. }
            | Self::BodyScaled { .. }
            | Self::SizesScaled { .. }
            | Self::TagResized { .. } => 1,
            Self::CameraTurned { .. }
            | Self::CamerasExchanged { .. }
            | Self::TagTurned { .. }
            | Self::TagsExchanged { .. } => 0,
        }
    }

    /// Whether it changes how a view is explained.
    pub(crate) fn concerns(&self, site: &NominalSite, view: &View) -> bool {
        match *self {
            Self::CameraMoved { camera, .. }
            | Self::CameraTurned { camera, .. }
            | Self::LensChanged { camera, .. }
            | Self::ClockOff { camera, .. } => view.camera == camera,
            Self::CamerasExchanged { a, b } => view.camera == a || view.camera == b,
            Self::BodyScaled { body, .. } | Self::SizesScaled { body, .. } => {
                site.tags[view.tag].body == body
            }
            Self::TagTurned { tag, .. }
            | Self::TagResized { tag, .. }
            | Self::TagMoved { tag, .. } => view.tag == tag,
            Self::TagsExchanged { a, b } => view.tag == a || view.tag == b,
        }
    }

    /// Whether it changes what a view's own corners say of the tag's pose in the camera.
    pub(crate) fn changes_branches(&self) -> bool {
        matches!(
            self,
            Self::CamerasExchanged { .. }
                | Self::LensChanged { .. }
                | Self::ClockOff { .. }
                | Self::BodyScaled { .. }
                | Self::SizesScaled { .. }
                | Self::TagResized { .. }
        )
    }
}

/// A turn by right angles about z.
fn turn(quarters: u8) -> Pose {
    let angle = f64::from(quarters) * FRAC_PI_2;
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    Pose::from_parts(Vector3::zeros().into(), turn)
}

/// A lens with another focal length; the same where that would be none.
pub(crate) fn zoomed(lens: &Lens, ratio: f64) -> Lens {
    let mut numbers = lens.parameters();
    numbers[0] *= ratio;
    numbers[1] *= ratio;
    Lens::from_parameters(lens.model(), &numbers).unwrap_or(*lens)
}
