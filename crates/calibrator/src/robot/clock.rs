//! A first estimate of the delay between images and a robot's poses, from angles: by how much the hand turns between
//! two times is the same in every frame.

use super::poses::RobotPoses;
use sextant_geometry::Pose;

/// Delays that are tried, seconds.
const MOST_DELAY_S: f64 = 2.0;
const STEP_S: f64 = 0.005;
/// Turns are compared over at least this time.
const OVER_NS: u64 = 200_000_000;
const AT_MOST_NS: u64 = 600_000_000;
/// Fewer turns say nothing.
const LEAST_TURNS: usize = 10;
/// Most turns that are compared, spread over the recording: each is compared at every delay.
const MOST_TURNS: usize = 300;
/// A delay counts that leaves less than this share of the median disagreement.
const CLEAR: f64 = 0.5;

/// The delay by which the robot's turns agree best with those of the images (`capture_ns` and any pose that turns with
/// the hand, in the order of time); zero where that is not clear.
pub(super) fn delay_s(poses: &RobotPoses, images: &[(u64, Pose)]) -> f64 {
    let turns: Vec<(u64, u64, f64)> = turns(images).collect();
    let every = turns.len().div_ceil(MOST_TURNS).max(1);
    let turns: Vec<(u64, u64, f64)> = turns.into_iter().step_by(every).collect();
    let steps = (MOST_DELAY_S / STEP_S) as i32;
    let delays = (-steps..=steps).map(|step| f64::from(step) * STEP_S);
    let costs = delays.filter_map(|delay_s| Some((disagreement(poses, &turns, delay_s)?, delay_s)));
    let mut costs: Vec<(f64, f64)> = costs.collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    match (costs.first(), costs.get(costs.len() / 2)) {
        (Some((least, delay_s)), Some((median, _))) if *least < CLEAR * median => *delay_s,
        _ => 0.0,
    }
}

fn turns(images: &[(u64, Pose)]) -> impl Iterator<Item = (u64, u64, f64)> {
    images
        .iter()
        .enumerate()
        .filter_map(|(at, (from_ns, from))| {
            let mut later = images[at..].iter();
            let (to_ns, to) = later.find(|(ns, _)| ns - from_ns >= OVER_NS)?;
            let turn = from.rotation.angle_to(&to.rotation);
            (to_ns - from_ns <= AT_MOST_NS).then_some((*from_ns, *to_ns, turn))
        })
}

/// Mean difference of the turns, radians; `None` where most have no poses.
fn disagreement(poses: &RobotPoses, turns: &[(u64, u64, f64)], delay_s: f64) -> Option<f64> {
    let differences = turns.iter().filter_map(|(from_ns, to_ns, turn)| {
        let [from, to] = [from_ns, to_ns].map(|ns| poses.hand(0, *ns, delay_s));
        let own = from?.base_from_hand.rotation;
        Some((own.angle_to(&to?.base_from_hand.rotation) - turn).abs())
    });
    let differences: Vec<f64> = differences.collect();
    let n = differences.len();
    (n >= LEAST_TURNS && 2 * n >= turns.len()).then(|| differences.iter().sum::<f64>() / n as f64)
}
