//! Stage 1: the hypotheses of a track at the instant of new images.

use std::borrow::Cow;

use crate::FusionOptions;
use crate::filter::state::ObjectState;
use crate::time::seconds;
use crate::tracker::track::Track;

/// A track at a later instant, before the images of that instant.
#[derive(Debug, Clone)]
pub(crate) struct Prediction<'a> {
    /// The track that is continued.
    pub track: Cow<'a, Track>,
    /// The instant, ns.
    pub time_ns: u64,
    /// Time since the track's own instant, s.
    pub elapsed_s: f64,
    /// State of each hypothesis at the instant; none where the object is to be initialised from the images alone.
    pub states: Vec<ObjectState>,
}

/// The states at `time_ns`, which is not before the track's instant; none where the object is unknown or lost by then.
pub(crate) fn predict<'a>(
    track: &'a Track,
    time_ns: u64,
    options: &FusionOptions,
) -> Prediction<'a> {
    let elapsed_s = seconds(track.time_ns, time_ns);
    let states = if track.is_known_at(time_ns, options) {
        let hypotheses = track.hypotheses.iter();
        hypotheses
            .map(|one| one.state.predicted(elapsed_s))
            .collect()
    } else {
        Vec::new()
    };
    Prediction {
        track: Cow::Borrowed(track),
        time_ns,
        elapsed_s,
        states,
    }
}

impl Prediction<'_> {
    /// Whether the object is to be initialised from the images alone.
    pub fn is_initialisation(&self) -> bool {
        self.states.is_empty()
    }

    /// The same instant with nothing known of the object.
    pub fn initialisation(&self) -> Prediction<'_> {
        Prediction {
            track: Cow::Borrowed(&self.track),
            states: Vec::new(),
            ..*self
        }
    }
}
