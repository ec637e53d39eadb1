//! What one camera or one tag may be accused of, and what speaks for it.

use crate::diagnosis::fault_model::FaultModel;
use crate::diagnosis::fault_model::camera::CameraPoseFault;
use crate::diagnosis::fault_model::clock::ClockFault;
use crate::diagnosis::fault_model::tag_pose::TagPoseFault;
use crate::diagnosis::fault_model::tag_size::TagSizeFault;
use crate::diagnosis::recursive_estimate::RecursiveEstimate;

/// Evidence that is worth watching all images.
pub(crate) const ALERT: f64 = 5.0;
/// Half the squared sigmas of an error beyond which it is not as is stated: of six numbers one in 10⁸ by chance.
const UNLIKELY: f64 = 25.0;
/// What a camera or a tag may be accused of: an error of one parameter, its clock's offset or its size, or a displacement.
#[derive(Debug)]
pub(crate) struct FaultEstimate {
    pub simple: RecursiveEstimate<1>,
    pub whole: RecursiveEstimate<6>,
    /// Shares of squared residuals that either may leave.
    rests: [f64; 2],
}

impl FaultEstimate {
    /// Of a camera: offset of its clock, displacement.
    pub fn camera() -> Self {
        Self::of::<ClockFault, CameraPoseFault>()
    }

    /// Of a tag: its size, displacement.
    pub fn tag() -> Self {
        Self::of::<TagSizeFault, TagPoseFault>()
    }

    fn of<Simple: FaultModel<1>, Whole: FaultModel<6>>() -> Self {
        Self {
            simple: RecursiveEstimate::of::<Simple>(),
            whole: RecursiveEstimate::of::<Whole>(),
            rests: [Simple::UNEXPLAINED, Whole::UNEXPLAINED],
        }
    }

    /// What either explains, if errors as large as is stated do not.
    pub fn strengths(&self) -> [f64; 2] {
        let stated = self.whole.strength_of_stated();
        let is_likely = |own: f64| stated > 0.0 && own < stated + UNLIKELY;
        let strengths = [self.simple.strength(), self.whole.strength()];
        strengths.map(|own| if is_likely(own) { 0.0 } else { own })
    }

    /// Whether nothing but either is needed.
    pub fn explain(&self) -> [bool; 2] {
        let [simple, whole] = self.rests;
        [self.simple.explains(simple), self.whole.explains(whole)]
    }

    /// It begins to contradict.
    pub fn unsettle(&mut self) {
        if self.strengths()[1] < ALERT {
            self.whole.unsettle();
            self.simple.unsettle();
        }
    }
}
