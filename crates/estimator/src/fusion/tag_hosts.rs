//! What is there where a tag is seen that is not where its object has it.

use crate::ObjectModel;
use crate::fusion::Fusion;
use crate::measurement::ray::Ray;
use crate::tracker::finalised_views::SeenOn;
use crate::tracker::timeline::FinalisedInstant;

impl Fusion {
    /// Notes on which other object the far-off tags of an instant are.
    pub(crate) fn find_hosts(&self, object: usize, instant: &mut FinalisedInstant) {
        for view in &mut instant.views {
            let host = |ray: Ray| self.object_on(&ray, object, instant.time_ns);
            view.elsewhere = view
                .ray
                .map(|ray| host(ray).map_or(SeenOn::Nowhere, SeenOn::On));
        }
    }

    /// The object that a ray goes through at a time, other than one.
    fn object_on(&self, ray: &Ray, but: usize, time_ns: u64) -> Option<usize> {
        let others = self.timelines.iter().zip(&self.objects).enumerate();
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
