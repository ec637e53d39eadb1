//! Mistakes of the files and in the room: found, mended in the models, reported.

use crate::contradictions::TrackDoubts;
use crate::fusion::RigFusion;
use crate::site::AssociatedImage;
use crate::site::indexed_site::IndexedSite;
use crate::tracker::timeline::Timeline;
use sextant_geometry::se3;
use sextant_mistakes::Mistake;
use sextant_site_model::{ImageObservation, TagId};
use sextant_site_report::{Fault, ObjectEstimate, State};

impl RigFusion {
    /// Compares an image with the models, and mends the mistakes that explain what contradicts; returns the image by
    /// the models in force then.
    pub(crate) fn check_mistakes(
        &mut self,
        image: &ImageObservation,
        associated: AssociatedImage,
    ) -> AssociatedImage {
        for (object, seen) in &associated.objects {
            let doubts = self.track_doubts(*object, seen.camera_index);
            self.contradictions
                .take(*object, seen, &doubts, &self.site, &self.options);
        }
        // Adjustments come first: images would contradict a site that waits for one.
        if self.self_calibration.due().is_none() {
            self.contradictions.prepare(&self.site);
        }
        let is_due = self.contradictions.due().is_some();
        if !is_due || self.adjusts_apart || !self.take_found() {
            return associated;
        }
        match self.site.camera(&image.camera) {
            Some((camera_index, _)) => self.site.associate(camera_index, image, &self.options),
            None => associated,
        }
    }

    /// Mends what the search that is due has found; whether the models have changed by it.
    pub(crate) fn take_found(&mut self) -> bool {
        let Some((mut mistakes, search)) = self.contradictions.take_found() else {
            return false;
        };
        mistakes.retain(|mistake| {
            let mut cameras = mistake.cameras().into_iter();
            !cameras.any(|camera| self.is_clock_in_question(camera))
        });
        if !mistakes.is_empty() {
            self.mend(&mistakes, search.indexed());
        }
        !mistakes.is_empty()
    }

    /// Whether what a camera shows may be due to its clock.
    pub(crate) fn is_clock_in_question(&self, camera: usize) -> bool {
        self.offset_search.is_young(self.now_ns) || self.offset_search.is_out_of_step(camera)
    }

    fn track_doubts(&self, object: usize, camera_index: usize) -> TrackDoubts {
        let track = self.timelines[object].at(u64::MAX);
        let best = track.hypotheses.first().filter(|_| track.trusted);
        let doubted = best.map_or(&[][..], |best| best.consistency.doubted());
        TrackDoubts {
            is_any: !track.summary.refused.is_empty()
                || !doubted.is_empty()
                || track.contradicted_since_ns.is_some()
                || track.refused_share(self.present_ns()).is_some(),
            cameras: doubted.to_vec(),
            ahead_s: self.ahead_s(object, camera_index),
        }
    }

    /// Takes over what is right if some mistakes were made. What was learned with them means nothing now.
    fn mend(&mut self, mistakes: &[Mistake], indexed: &IndexedSite) {
        for mistake in mistakes {
            let fault = self.fault(mistake, indexed);
            if self.is_back(mistake) {
                self.mended
                    .retain(|other| fault.as_ref().is_none_or(|fault| !is_of_same(other, fault)));
                if let Mistake::CameraMoved { camera, .. } = mistake {
                    self.site.restore_camera(*camera, &self.rig);
                }
                continue;
            }
            self.site.mend(mistake, indexed);
            if let Some(fault) = fault {
                self.mended.retain(|other| !is_of_same(other, &fault));
                self.mended.push(fault);
            }
        }
        for timeline in &mut self.timelines {
            *timeline = Timeline::new(timeline.object().clone());
        }
        self.forget_calibration();
        self.diagnosis.reset();
        self.offset_search.models_changed();
        self.contradictions.models_changed();
    }

    /// Whether a camera that had been moved is where its file has it again.
    fn is_back(&self, mistake: &Mistake) -> bool {
        let Mistake::CameraMoved {
            camera,
            world_from_camera,
            sigma,
        } = mistake
        else {
            return false;
        };
        let id = self.site.camera_id(*camera);
        let was_moved = self.mended.iter().any(
            |fault| matches!(fault, Fault::CameraMoved { camera } if Some(camera) == id.as_ref()),
        );
        let mut cameras = self.rig.cameras().iter();
        let file = cameras.find(|file| Some(&file.id) == id.as_ref());
        let place = file.and_then(|file| file.world_from_camera);
        was_moved
            && place.is_some_and(|place| {
                let step = se3::difference(world_from_camera, &place);
                step.fixed_rows::<3>(0).norm() <= BACK * sigma.position_m
                    && step.fixed_rows::<3>(3).norm() <= BACK * sigma.orientation_rad
            })
    }

    /// What is reported of a mistake; `None` where something else reports it.
    fn fault(&self, mistake: &Mistake, indexed: &IndexedSite) -> Option<Fault> {
        let camera = |index: usize| self.site.camera_id(index);
        let degrees = |quarters: u8| u16::from(quarters) * 90;
        let tags = mistake.tags(&indexed.site).into_iter();
        let tags: Vec<TagId> = tags.map(|tag| indexed.tags[tag]).collect();
        let first = tags.first().copied();
        let of_first = first.and_then(|tag| Some((self.site.object_of(&tag)?.clone(), tag)));
        Some(match *mistake {
            Mistake::CameraMoved { camera: index, .. } => Fault::CameraMoved {
                camera: camera(index)?,
            },
            Mistake::CameraTurned {
                camera: index,
                quarters,
            } => Fault::CameraTurned {
                camera: camera(index)?,
                degrees: degrees(quarters),
            },
            Mistake::CamerasExchanged { a, b } => Fault::CamerasExchanged {
                a: camera(a)?,
                b: camera(b)?,
            },
            Mistake::LensChanged {
                camera: index,
                ratio,
            } => Fault::LensChanged {
                camera: camera(index)?,
                ratio,
            },
            Mistake::TagTurned { quarters, .. } => {
                let (object, tag) = of_first?;
                Fault::TagTurned {
                    object,
                    tag,
                    degrees: degrees(quarters),
                }
            }
            Mistake::TagsExchanged { .. } => {
                let (object, a) = of_first?;
                Fault::TagsExchanged {
                    object,
                    a,
                    b: *tags.get(1)?,
                }
            }
            Mistake::TagResized { ratio, .. } => {
                let (object, tag) = of_first?;
                Fault::TagSize { object, tag, ratio }
            }
            // The site knows the scales of its objects; clocks and loose tags are not mended.
            Mistake::BodyScaled { .. }
            | Mistake::SizesScaled { .. }
            | Mistake::ClockOff { .. }
            | Mistake::TagMoved { .. } => return None,
        })
    }

    /// The faults of the mistakes that are mended, and of two cameras that may as well be the one or the other.
    pub(crate) fn mistakes(&self) -> Vec<Fault> {
        let mut all = self.mended.clone();
        let ids = self
            .contradictions
            .pair()
            .map(|pair| pair.map(|index| self.site.camera_id(index)));
        if let Some([Some(a), Some(b)]) = ids {
            all.push(Fault::CamerasDisagree {
                a: a.clone().min(b.clone()),
                b: a.max(b),
            });
        }
        all
    }

    /// The estimate of an object on whose pose no majority of its cameras or tags agrees is not tracked; its covariance
    /// spans what they say.
    pub(crate) fn with_doubt(&self, object: usize, mut estimate: ObjectEstimate) -> ObjectEstimate {
        let doubt = self.contradictions.doubt(object, estimate.capture_ns);
        if let Some(apart) = doubt.filter(|_| estimate.state == State::Tracking) {
            estimate.state = State::Initialising;
            let variance = apart.variance();
            for axis in 0..6 {
                estimate.covariance[(axis, axis)] += variance[axis];
            }
        }
        estimate
    }
}

/// Standard deviations within which a camera is where it was.
const BACK: f64 = 3.0;

/// Whether two faults are of one camera or tag, so that the later one replaces the other.
fn is_of_same(one: &Fault, other: &Fault) -> bool {
    let camera = |fault: &Fault| match fault {
        Fault::CameraMoved { camera }
        | Fault::CameraTurned { camera, .. }
        | Fault::LensChanged { camera, .. } => Some(camera.clone()),
        _ => None,
    };
    one == other || camera(one).is_some_and(|id| camera(other) == Some(id))
}
