//! Faults that come and go while a site runs: named right, in time, and not otherwise?
//!
//! `examine faults KIND FROM TO` injects one after three seconds, mends it after eight more and watches six more. The
//! rule, stated beforehand: a fault must be named within its bound of time in which images show it, nothing else may
//! ever be named, and it must not be named any longer once images have shown its mending for three seconds. Images show
//! - that a camera was moved (1 degree): while two other cameras see the body that it sees; within 2 s. Of two cameras
//!   that disagree it must be said just that;
//! - that a tag slipped (3 mm) or is of another size (2 %): while it and two other tags of its body are seen; within 3
//!   s;
//! - that a clock jumped (5 to 200 ms): while it and another camera see a body that moves by 0.1 m/s; within 3 s;
//! - that a tag is there twice (a second print): while one image shows both; within 3 s;
//! - that a tag is on another body (as well): while that one is seen; within 3 s.
//!
//! `KIND+unvouched`: clock errors are unknown; `KIND+first`: it is wrong from the first image on; `KIND+stated`:
//! cameras' poses are wrong by their configured deviations, `KIND+calibrated` by as little as a calibration leaves and
//! reports, and `KIND+unstated` by .2 mm and mrad without configured deviations; any of them together. Of what is right
//! the share of images is printed after which it was named, from its first naming to its last.
//!
//! Of a clock's jump it is printed by how many sigma it stands out at least in the images that tell it within its
//! bound.
//!
//! `examine quiet MINUTES FROM TO` watches sites without a fault, `quiet+unvouched` such with unknown clock errors,
//! `quiet+stated`, `quiet+calibrated` and `quiet+unstated` such whose cameras' poses are wrong likewise.

use std::collections::BTreeMap;
use std::fmt;

use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_site_model::ImageObservation;
use sextant_site_report::Fault;

use crate::models::made;
use crate::motion::Motion;
use crate::random::Random;
use crate::scene::{CLASSES, Class, PERIOD_NS, START_NS, Scene};
use crate::wrong::{CHANGE_S, KINDS, Wrong, WrongKind};

/// When the fault is mended and when the scene ends, s.
const MENDED_S: f64 = 11.0;
const END_S: f64 = 17.0;
/// Seconds in which images show its end after which a fault must not be named any more.
const OVER_S: f64 = 3.0;
/// Seconds in which images show a fault by which it must be named, but a camera that was moved.
const BOUND_S: f64 = 3.0;
/// Scenes, by turns; true where nothing moves.
const SCENES: [(Class, bool); 10] = [
    (Class::Base, false),
    (Class::Many, false),
    (Class::Pair, false),
    (Class::Free, false),
    (Class::Base, true),
    (Class::OtherNoise, false),
    (Class::UnstatedNoise, false),
    (Class::Arm, false),
    (Class::Late, false),
    (Class::Fast, false),
];

/// Scenes whose cameras' poses are wrong.
const POSES: [(&str, Class); 3] = [
    ("unstated", Class::UnstatedPoses),
    ("stated", Class::StatedPoses),
    ("calibrated", Class::CalibratedPoses),
];

/// What is wrong, since when, whether anybody says how well clocks are known, and how cameras' poses are wrong, if they
/// are.
#[derive(Clone, Copy)]
struct Case {
    kind: Option<WrongKind>,
    change_s: f64,
    unvouched: bool,
    poses: Option<Class>,
}

impl Case {
    fn new(kind: Option<WrongKind>, how: &str) -> Self {
        Self {
            kind,
            change_s: if how.contains("first") { 0.0 } else { CHANGE_S },
            unvouched: how.contains("unvouched"),
            poses: POSES
                .into_iter()
                .find(|(word, _)| how.contains(word))
                .map(|(_, class)| class),
        }
    }
}

fn scene_of(case: Case, seed: u64) -> (Scene, String) {
    let kind = case.kind;
    let (class, still) = match (kind, case.poses) {
        (Some(WrongKind::Shared), _) => (Class::Many, false),
        (_, Some(poses)) => (poses, false),
        _ => SCENES[seed as usize % SCENES.len()],
    };
    let still = still && kind != Some(WrongKind::Clock);
    let mut scene = Scene::new(class, 1_000_000 + seed);
    for body in scene.bodies.iter_mut().filter(|_| still) {
        body.motion = Motion::smooth(0.0, 0.0, [0.2, 0.6], &mut Random(seed));
    }
    for clock in scene.clocks.iter_mut().filter(|_| case.unvouched) {
        clock.stated_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
    }
    let name = CLASSES.iter().find(|one| one.1 == class);
    let name = name.map_or("", |one| one.0);
    let noise = scene.sigma_px;
    let words = format!(
        "{seed} {name}{} n={} {noise:.2} px",
        if still { " still" } else { "" },
        scene.clocks.len()
    );
    (scene, words)
}

/// A fault that was named.
struct ReportedFault {
    key: String,
    /// Seconds from the change, and those of them in which images show it.
    first_s: f64,
    evident_s: f64,
    last_s: f64,
    /// Images after which it was named, and those before the first of them.
    images: u32,
    before: u32,
    /// Share of images since the first naming up to the last.
    steady: f64,
    right: bool,
    doubt: bool,
}

impl fmt::Display for ReportedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (key, first_s, evident_s, last_s) =
            (&self.key, self.first_s, self.evident_s, self.last_s);
        write!(
            f,
            "{key} {first_s:.1} ({evident_s:.1} evident) to {last_s:.1}"
        )?;
        if self.right {
            write!(f, " {:.0} %", 100.0 * self.steady)?;
        }
        Ok(())
    }
}

/// A fault without its numbers.
fn key_of(fault: &Fault) -> String {
    match fault {
        Fault::TagSize { tag, .. } => format!("size {tag}"),
        Fault::ClockOff { camera, .. } => format!("clock {camera}"),
        Fault::CameraMoved { camera } => format!("moved {camera}"),
        Fault::CamerasDisagree { a, b } => format!("disagree {a} {b}"),
        Fault::TagMisplaced { tag, .. } => format!("misplaced {tag}"),
        Fault::TagElsewhere { tag, on, .. } => {
            format!("elsewhere {tag}{}", if on.is_some() { " on" } else { "" })
        }
        Fault::DuplicateTag { tag, camera } => format!("twice {tag} {camera}"),
        Fault::Untimely { camera, .. } => format!("untimely {camera}"),
        Fault::HostClockOff { .. } => "host clock".to_owned(),
        Fault::CameraFrozen { camera, .. } => format!("frozen {camera}"),
        Fault::LensOff { camera } => format!("lens {camera}"),
        Fault::ObjectScaled { object, .. } => format!("scaled {object}"),
        Fault::ObjectContradicted { object, .. } => format!("contradicted {object}"),
        Fault::ObjectUnplaced { object } => format!("unplaced {object}"),
        Fault::ImageSize { camera, .. } => format!("size {camera}"),
        Fault::CameraTurned { camera, .. } => format!("turned {camera}"),
        Fault::CamerasExchanged { a, b } => format!("exchanged {a} {b}"),
        Fault::LensChanged { camera, .. } => format!("zoom {camera}"),
        Fault::TagTurned { tag, .. } => format!("turned {tag}"),
        Fault::TagsExchanged { a, b, .. } => format!("exchanged {a} {b}"),
        Fault::CameraBlind { camera, .. } => format!("blind {camera}"),
    }
}

fn fusion_of(scene: &Scene) -> Fusion {
    let models = scene.bodies.iter().map(|body| body.model.clone()).collect();
    made(Fusion::new(
        scene.stated.clone(),
        models,
        FusionOptions::default(),
    ))
}

/// A scene with a fault, as it plays.
struct Play {
    wrong: Wrong,
    kind: WrongKind,
    change_s: f64,
    /// Images so far.
    seen: u32,
    /// As it is without the fault.
    scene: Scene,
    named: Vec<ReportedFault>,
    /// Seconds in which images show the fault, and its end.
    evident_s: f64,
    over_s: f64,
    /// Information about a clock's offset within the bound, 1/s².
    information: f64,
    /// The period under way, and its images by camera.
    round: u64,
    images: BTreeMap<usize, ImageObservation>,
}

impl Play {
    /// An image comes; whenever all of a period have come, it is known whether they show the fault.
    fn observe(&mut self, taken_s: f64, image: &ImageObservation) {
        self.seen += 1;
        let period_s = PERIOD_NS as f64 * 1e-9;
        let round = (taken_s / period_s) as u64;
        if round > self.round {
            // Where nothing is there twice, any image shows its end.
            let by_any =
                matches!(self.kind, WrongKind::Twice | WrongKind::Shared) && taken_s > MENDED_S;
            let evident = by_any || self.wrong.is_evident(&self.scene, &self.images, taken_s);
            match taken_s {
                _ if !evident => {}
                MENDED_S.. => self.over_s += period_s,
                _ if taken_s >= self.change_s => {
                    self.evident_s += period_s;
                    if self.evident_s <= BOUND_S {
                        let more = self.wrong.information(&self.scene, &self.images, taken_s);
                        self.information += more;
                    }
                }
                _ => {}
            }
            (self.round, self.images) = (round, BTreeMap::new());
        }
        let mut cameras = self.scene.truth.cameras().iter();
        let camera = cameras.position(|one| one.id == image.camera);
        self.images.insert(camera.unwrap_or(0), image.clone());
    }

    fn record(&mut self, at_s: f64, fault: &Fault) {
        let key = key_of(fault);
        match self.named.iter_mut().find(|one| one.key == key) {
            Some(known) => {
                known.last_s = at_s;
                known.images += 1;
                known.steady = f64::from(known.images) / f64::from(self.seen - known.before);
            }
            None => self.named.push(ReportedFault {
                key,
                first_s: at_s,
                evident_s: self.evident_s,
                last_s: at_s,
                images: 1,
                before: self.seen - 1,
                steady: 1.0,
                right: self.wrong.is_named_by(&self.scene, fault),
                doubt: self.wrong.is_in_doubt_by(&self.scene, fault),
            }),
        }
    }

    fn verdict(&self) -> &'static str {
        let bound_s = if self.kind == WrongKind::Camera {
            2.0
        } else {
            BOUND_S
        };
        let may_be_named = self.evident_s >= bound_s;
        let is_right = |one: &&ReportedFault| one.right || (one.doubt && !may_be_named);
        let end_s = END_S - self.change_s - 0.2;
        let stays = self.over_s > OVER_S && self.named.iter().any(|one| one.last_s > end_s);
        match self.named.iter().find(is_right) {
            _ if self.named.iter().any(|one| !one.right && !one.doubt) => "WRONG",
            _ if stays => "STAYS",
            Some(one) if one.evident_s > bound_s => "LATE",
            Some(_) => "right",
            None if may_be_named => "MISSED",
            None => "untold",
        }
    }
}

/// Plays a fault; the verdict and a line about it.
fn played(kind: WrongKind, how: &str, seed: u64) -> (&'static str, String) {
    let case = Case::new(Some(kind), how);
    let change_s = case.change_s;
    let (mut scene, words) = scene_of(case, seed);
    let random = &mut Random(seed ^ 0x5eed);
    let mut wrong = Wrong::choose(kind, &scene, random);
    if wrong.camera >= scene.clocks.len() {
        return ("none", words);
    }
    let mut fusion = fusion_of(&scene);
    let mut shots = scene.shots(0.0, change_s, random);
    wrong.come(&mut scene, random);
    shots.extend(scene.shots(change_s, MENDED_S, random));
    let (scene, _) = scene_of(case, seed);
    shots.extend(scene.shots(MENDED_S, END_S, random));
    let mut play = Play {
        wrong,
        kind,
        change_s,
        seen: 0,
        scene,
        named: Vec::new(),
        evident_s: 0.0,
        over_s: 0.0,
        information: 0.0,
        round: 0,
        images: BTreeMap::new(),
    };
    for shot in shots {
        play.observe(shot.taken_s, &shot.image);
        fusion.handle(shot.arrival_ns, Input::Image(shot.image));
        while fusion.poll_output().is_some() {}
        let at_s = (shot.arrival_ns - START_NS) as f64 * 1e-9 - change_s;
        for fault in fusion.faults() {
            play.record(at_s, &fault);
        }
    }
    let verdict = play.verdict();
    let (wrong, evident_s) = (&play.wrong, play.evident_s);
    let named: Vec<String> = play.named.iter().map(ToString::to_string).collect();
    let sigmas = match kind {
        WrongKind::Clock => format!(
            ", {:.0} sigma",
            wrong.jump_s.abs() * play.information.sqrt()
        ),
        _ => String::new(),
    };
    let line = format!(
        "{words}: camera {} {} {}, evident {evident_s:.1} s{sigmas}: {verdict}: {}",
        wrong.camera,
        wrong.tag,
        wrong.words,
        named.join(", ")
    );
    (verdict, line)
}

/// `examine faults KIND FROM TO`.
pub fn examine(name: &str, seeds: std::ops::Range<u64>) {
    let (name, how) = name.split_once('+').unwrap_or((name, ""));
    for (_, kind) in KINDS.iter().filter(|one| one.0 == name || name == "all") {
        let mut sums: BTreeMap<&str, usize> = BTreeMap::new();
        for seed in seeds.clone() {
            let (verdict, line) = played(*kind, how, seed);
            *sums.entry(verdict).or_default() += 1;
            println!("{line}");
        }
        println!("{name}: {sums:?}");
    }
}

/// `examine quiet MINUTES FROM TO`.
pub fn watch(how: &str, minutes: f64, seeds: std::ops::Range<u64>) {
    let case = Case::new(None, how);
    let mut alarms = 0;
    for seed in seeds {
        let (scene, words) = scene_of(case, seed);
        let (mut fusion, random) = (fusion_of(&scene), &mut Random(seed));
        let mut named: BTreeMap<String, [f64; 2]> = BTreeMap::new();
        for span in 0..(minutes * 6.0) as u32 {
            let from_s = f64::from(span) * 10.0;
            for shot in scene.shots(from_s, from_s + 10.0, random) {
                fusion.handle(shot.arrival_ns, Input::Image(shot.image));
                while fusion.poll_output().is_some() {}
                for fault in fusion.faults() {
                    let at = named.entry(key_of(&fault)).or_insert([shot.taken_s; 2]);
                    at[1] = shot.taken_s;
                }
            }
        }
        alarms += usize::from(!named.is_empty());
        println!("{words}: {named:.1?}");
    }
    println!("sites with a false alarm: {alarms}");
}
