//! Rigs and objects with everything that their files state, to messages and back.

use crate::convert::config::RigConfigError;
use crate::messages::articulated_config::{ArticulatedConfig, LinkTagConfig};
use crate::messages::config::{CameraConfig, ObjectConfig, ObjectTagConfig, RigConfig};
use crate::messages::full_config::{
    ExposureConfig, FullCamera, FullObject, FullRig, FullTag, LensSigmaConfig, SigmaConfig,
};
use sextant_estimator::{Exposure, LensSigma, ObjectError, ObjectModel, ObjectTag, PoseSigma, Rig};

impl From<PoseSigma> for SigmaConfig {
    fn from(sigma: PoseSigma) -> Self {
        Self {
            position_m: sigma.position_m,
            orientation_rad: sigma.orientation_rad,
        }
    }
}

impl From<SigmaConfig> for PoseSigma {
    fn from(message: SigmaConfig) -> Self {
        Self {
            position_m: message.position_m,
            orientation_rad: message.orientation_rad,
        }
    }
}

impl From<LensSigma> for LensSigmaConfig {
    fn from(sigma: LensSigma) -> Self {
        Self {
            focal_px: sigma.focal_px,
            distortion_px: sigma.distortion_px,
        }
    }
}

impl From<LensSigmaConfig> for LensSigma {
    fn from(message: LensSigmaConfig) -> Self {
        Self {
            focal_px: message.focal_px,
            distortion_px: message.distortion_px,
        }
    }
}

impl From<Exposure> for ExposureConfig {
    fn from(exposure: Exposure) -> Self {
        Self {
            length_s: exposure.length_s,
            stamp: exposure.stamp,
        }
    }
}

impl From<ExposureConfig> for Exposure {
    fn from(message: ExposureConfig) -> Self {
        Self {
            length_s: message.length_s,
            stamp: message.stamp,
        }
    }
}

impl From<&Rig> for FullRig {
    fn from(rig: &Rig) -> Self {
        let cameras = rig.cameras().iter().map(|camera| FullCamera {
            camera: CameraConfig::from(camera),
            pose_sigma: rig.pose_sigma(&camera.id).map(SigmaConfig::from),
            lens_sigma: rig.lens_sigma(&camera.id).map(LensSigmaConfig::from),
            line_delay_s: rig.line_delay_s(&camera.id),
            exposure: rig.exposure(&camera.id).map(ExposureConfig::from),
        });
        Self {
            cameras: cameras.collect(),
        }
    }
}

impl From<&FullRig> for RigConfig {
    fn from(message: &FullRig) -> Self {
        let cameras = message.cameras.iter().map(|one| one.camera.clone());
        Self {
            cameras: cameras.collect(),
        }
    }
}

impl TryFrom<&FullRig> for Rig {
    type Error = RigConfigError;

    fn try_from(message: &FullRig) -> Result<Self, RigConfigError> {
        let mut rig = Self::try_from(&RigConfig::from(message))?;
        for one in &message.cameras {
            let id = || one.camera.id.clone();
            let pose = one.pose_sigma.map(|sigma| (id(), sigma.into()));
            let lens = one.lens_sigma.map(|sigma| (id(), sigma.into()));
            let delay = one.line_delay_s.map(|delay_s| (id(), delay_s));
            let exposure = one.exposure.map(|exposure| (id(), exposure.into()));
            rig = rig
                .with_pose_sigmas(pose)?
                .with_lens_sigmas(lens)?
                .with_line_delays(delay)?
                .with_exposures(exposure)?;
        }
        Ok(rig)
    }
}

impl From<&ObjectModel> for FullObject {
    fn from(object: &ObjectModel) -> Self {
        let tags = object.tags().iter().map(|tag| FullTag {
            link: 0,
            tag: ObjectTagConfig::from(tag),
            sigma: object.tag_sigma(&tag.tag).map(SigmaConfig::from),
        });
        let mut tags: Vec<FullTag> = tags.collect();
        let Some(of_links) = ArticulatedConfig::of(object) else {
            return Self {
                id: object.id().clone(),
                links: Vec::new(),
                joints: Vec::new(),
                tags,
            };
        };
        for (tag, on_link) in tags.iter_mut().zip(&of_links.tags) {
            tag.link = on_link.link;
        }
        Self {
            id: of_links.id,
            links: of_links.links,
            joints: of_links.joints,
            tags,
        }
    }
}

impl FullObject {
    /// The object alone, rigid.
    fn rigid(&self) -> ObjectConfig {
        ObjectConfig {
            id: self.id.clone(),
            tags: self.tags.iter().map(|one| one.tag.clone()).collect(),
        }
    }

    /// The object alone, of links.
    fn of_links(&self) -> ArticulatedConfig {
        let tags = self.tags.iter().map(|one| LinkTagConfig {
            link: one.link,
            tag: one.tag.clone(),
        });
        ArticulatedConfig {
            id: self.id.clone(),
            links: self.links.clone(),
            joints: self.joints.clone(),
            tags: tags.collect(),
        }
    }
}

impl TryFrom<&FullObject> for ObjectModel {
    type Error = ObjectError;

    fn try_from(message: &FullObject) -> Result<Self, ObjectError> {
        let object = if message.links.is_empty() {
            Self::try_from(&message.rigid())?
        } else {
            Self::try_from(&message.of_links())?
        };
        let sigmas = message.tags.iter().filter_map(|one| {
            let tag = ObjectTag::from(&one.tag).tag;
            Some((tag, one.sigma?.into()))
        });
        object.with_tag_sigmas(sigmas)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::samples::{lidded_box, tag};
    use sextant_estimator::{Camera, CameraId, ObjectId, Stamp};
    use sextant_geometry::{Intrinsics, Lens, Pose};

    const SIGMA: PoseSigma = PoseSigma {
        position_m: 0.001,
        orientation_rad: 0.002,
    };

    fn camera(name: &str) -> Camera {
        let intrinsics = Intrinsics {
            fx: 600.0,
            fy: 601.0,
            cx: 319.5,
            cy: 239.5,
        };
        Camera {
            id: CameraId::new(name).unwrap(),
            resolution: [640, 480],
            lens: Lens::pinhole(intrinsics).unwrap(),
            world_from_camera: Some(Pose::translation(1.0, 2.0, 3.0)),
        }
    }

    #[test]
    fn all_that_a_rig_states_survives_the_way_there_and_back() {
        let [north, south] = ["north", "south"].map(camera);
        let (first, second) = (north.id.clone(), south.id.clone());
        let plain = Rig::new(vec![north, south]).unwrap();
        let lens = LensSigma {
            focal_px: 0.3,
            distortion_px: 0.1,
        };
        let exposure = Exposure {
            length_s: 0.004,
            stamp: Stamp::End,
        };
        let stated = plain
            .clone()
            .with_pose_sigmas([(first.clone(), SIGMA)])
            .and_then(|rig| rig.with_lens_sigmas([(second.clone(), lens)]))
            .and_then(|rig| rig.with_line_delays([(first.clone(), -2e-5)]))
            .and_then(|rig| rig.with_exposures([(second, exposure)]))
            .unwrap();
        let message = FullRig::from(&stated);
        assert_eq!(Rig::try_from(&message), Ok(stated));
        assert_eq!(RigConfig::from(&message), RigConfig::from(&plain));
    }

    #[test]
    fn what_no_file_may_state_no_message_may_either() {
        let rig = Rig::new(vec![camera("north")]).unwrap();
        let mut message = FullRig::from(&rig);
        message.cameras[0].line_delay_s = Some(1.0);
        let refused = Rig::try_from(&message).unwrap_err().to_string();
        assert!(
            refused.contains("camera north: the line delay"),
            "{refused}"
        );
    }

    #[test]
    fn objects_rigid_or_of_links_survive_the_way_there_and_back() {
        let known = [(tag(4).tag, SIGMA)];
        let rigid = ObjectModel::new(ObjectId::new("box").unwrap(), vec![tag(3), tag(4)]).unwrap();
        let rigid = rigid.with_tag_sigmas(known).unwrap();
        assert_eq!(ObjectModel::try_from(&FullObject::from(&rigid)), Ok(rigid));

        let of_links = lidded_box().with_tag_sigmas(known).unwrap();
        let message = FullObject::from(&of_links);
        assert_eq!(ObjectModel::try_from(&message), Ok(of_links));
    }
}
