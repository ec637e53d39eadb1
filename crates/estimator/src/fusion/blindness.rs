//! Which objects a camera should see by the poses of the others, for images without a tag.

use crate::diagnosis::blind_cameras::is_well_in_view;
use crate::fusion::RigFusion;
use crate::site::TagPlacement;
use sextant_geometry::Pose;
use sextant_site_model::ImageObservation;
use sextant_site_report::{ObjectEstimate, State};

impl RigFusion {
    /// Notes what an image says of whether its camera sees.
    pub(crate) fn note_blindness(&mut self, camera: usize, image: &ImageObservation) {
        if !image.tags.is_empty() {
            self.blind_cameras
                .note_sight(camera, &image.tags, self.now_ns);
        } else if self.blind_cameras.is_due(camera, self.now_ns) {
            let object = self.first_in_view(camera, image.capture_ns);
            self.blind_cameras.note_nothing(camera, object, self.now_ns);
        }
    }

    /// The first object that is tracked and has a tag well in the picture of a camera.
    fn first_in_view(&self, camera: usize, time_ns: u64) -> Option<usize> {
        let visible_px = self.blind_cameras.visible_px(self.now_ns);
        let camera = self.site.cameras().get(camera)?;
        let posed = camera.posed.as_ref().filter(|_| visible_px.is_finite())?;
        let estimates = self.timelines.iter().map(|timeline| {
            let estimate = timeline.estimate(time_ns, &self.site, &self.options);
            estimate.filter(|it| matches!(it.state, State::Tracking | State::Coasting))
        });
        let estimates: Vec<Option<ObjectEstimate>> = estimates.collect();
        let in_view = self.site.placements().filter_map(|(_, placement)| {
            let (object, _) = placement.body();
            let world_from_tag = world_from_tag(estimates[object].as_ref()?, placement)?;
            let size_m = placement.tag.size_m;
            is_well_in_view(
                posed,
                camera.resolution,
                &world_from_tag,
                size_m,
                visible_px,
            )
            .then_some(object)
        });
        in_view.min()
    }
}

/// Where a tag is by the pose of its object, or of its link.
fn world_from_tag(estimate: &ObjectEstimate, placement: &TagPlacement) -> Option<Pose> {
    let (_, link) = placement.body();
    let world_from_body = match &estimate.articulated {
        Some(articulated) => articulated.links.get(link)?.world_from_link,
        None => estimate.world_from_object,
    };
    Some(world_from_body * placement.tag.object_from_tag?)
}
