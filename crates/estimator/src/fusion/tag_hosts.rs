//! Objects at the places of tags that are far from where their own object has them.

use crate::diagnosis::misplaced_tags::SeenOn;
use crate::fusion::RigFusion;
use crate::measurement::ray::Ray;
use crate::tracker::report::FinalisedView;
use sextant_site_model::ObjectModel;

impl RigFusion {
    /// What is where a view shows a tag far from its place; `None` where it is near.
    pub(crate) fn host(&self, object: usize, time_ns: u64, view: &FinalisedView) -> Option<SeenOn> {
        let on = |ray: Ray| self.object_on(&ray, object, time_ns);
        view.ray
            .map(|ray| on(ray).map_or(SeenOn::Nowhere, SeenOn::On))
    }

    /// The object that a ray goes through at a time, other than one.
    fn object_on(&self, ray: &Ray, but: usize, time_ns: u64) -> Option<usize> {
        let (_, models) = self.models.in_force();
        let others = self.timelines.iter().zip(models).enumerate();
        let mut hit = others
            .filter(|(index, _)| *index != but)
            .filter(|(_, (timeline, model))| {
                let estimate = timeline.estimate(time_ns, &self.site, &self.options);
                let place = estimate.map(|one| one.world_from_object.translation.vector);
                let distance = place.and_then(|place| ray.distance(&place));
                distance.is_some_and(|distance| distance <= reach(model))
            });
        hit.next().map(|(index, _)| index)
    }
}

/// Metres from the object's origin to the farthest corner of its tags.
fn reach(model: &ObjectModel) -> f64 {
    let tags = model.tags().iter();
    let farthest = tags.filter_map(|tag| {
        let place = tag.object_from_tag?;
        Some(place.translation.vector.norm() + tag.size_m * std::f64::consts::FRAC_1_SQRT_2)
    });
    farthest.fold(0.0, f64::max)
}
