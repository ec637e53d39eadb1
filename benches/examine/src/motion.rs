//! Motions of bodies: smooth ones, and ones of legs of steady acceleration, as of bodies that are struck, halted or
//! thrown.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::Pose;

use crate::random::Random;

/// The sum of two sines.
pub struct Wave([[f64; 3]; 2]);

impl Wave {
    /// `speed` is the highest, `amplitude` bounds either sine.
    pub fn new(speed: f64, hertz: [f64; 2], amplitude: f64, random: &mut Random) -> Self {
        Self([(); 2].map(|()| {
            let rate = std::f64::consts::TAU * random.within(hertz[0], hertz[1]);
            let size = (0.5 * random.within(0.3, 1.0) * speed / rate).min(amplitude);
            [size, rate, random.within(0.0, std::f64::consts::TAU)]
        }))
    }

    pub fn at(&self, seconds: f64) -> f64 {
        let sine = |[size, rate, phase]: &[f64; 3]| size * (rate * seconds + phase).sin();
        self.0.iter().map(sine).sum()
    }
}

/// Steady acceleration from a pose on; turning is about axes of the world.
struct Segment {
    start_s: f64,
    from: Pose,
    /// Of position, then of rotation: speed and half the acceleration.
    rates: [[Vector3<f64>; 2]; 2],
}

impl Segment {
    fn at(&self, seconds: f64) -> Pose {
        let t = seconds - self.start_s;
        let [moved, turned] = self.rates.map(|[speed, half]| (speed + half * t) * t);
        let turn = UnitQuaternion::from_scaled_axis(turned) * self.from.rotation;
        Pose::from_parts((self.from.translation.vector + moved).into(), turn)
    }
}

pub enum Motion {
    Smooth {
        middle: Pose,
        spin: Vector3<f64>,
        waves: Box<[Wave; 6]>,
    },
    Segments(Segments),
}

pub struct Segments(Vec<Segment>);

impl Motion {
    /// Up to so many m/s and rad/s.
    pub fn smooth(speed: f64, turning: f64, hertz: [f64; 2], random: &mut Random) -> Self {
        let wave = |place: usize| match place {
            0..3 => Wave::new(speed / 1.73, hertz, 0.12, random),
            _ => Wave::new(0.5 * turning / 1.73, hertz, 0.6, random),
        };
        let waves = Box::new(std::array::from_fn(wave));
        let spin = random.direction().scale(random.within(0.0, 0.5 * turning));
        let middle = Pose::new(Vector3::zeros(), random.direction().scale(3.0));
        Self::Smooth {
            middle,
            spin,
            waves,
        }
    }

    pub fn jerky(seconds: f64, random: &mut Random) -> Self {
        let mut legs = Segments::new(random);
        while legs.end_s() < seconds {
            let cruise_s = random.within(0.2, 0.8);
            legs.veer(random.within(0.03, 0.1), cruise_s, random);
            legs.last(cruise_s);
        }
        Self::Segments(legs)
    }

    pub fn stop_and_go(seconds: f64, random: &mut Random) -> Self {
        let mut legs = Segments::new(random);
        while legs.end_s() < seconds {
            let (ramp_s, cruise_s) = (random.within(0.05, 0.3), random.within(0.2, 0.7));
            legs.veer(ramp_s, cruise_s, random);
            legs.last(cruise_s);
            legs.accelerate([Vector3::zeros(); 2], ramp_s);
            legs.last(random.within(0.3, 1.5));
        }
        Self::Segments(legs)
    }

    /// Free fall, bounces 0.25 m below the middle, and throws.
    pub fn thrown(seconds: f64, random: &mut Random) -> Self {
        let mut legs = Segments::new(random);
        let (mut up, mut bounces) = (random.within(1.5, 2.2), 0);
        while legs.end_s() < seconds {
            let height = 0.25 + legs.place().z;
            let flight_s = (up + (up * up + 2.0 * 9.81 * height).sqrt()) / 9.81;
            let across = (random.gaussian(0.08) - legs.place()) / flight_s;
            let speed = Vector3::new(across.x, across.y, up);
            let spin = random.direction().scale(random.within(0.0, 8.0));
            legs.fly([speed, spin], flight_s);
            up = (9.81 * flight_s - up) * random.within(0.5, 0.8);
            bounces += 1;
            if up < 0.8 || bounces % 4 == 0 {
                up = random.within(1.8, 2.5);
            }
        }
        Self::Segments(legs)
    }

    pub fn at(&self, seconds: f64) -> Pose {
        match self {
            Self::Segments(legs) => legs.at(seconds),
            Self::Smooth {
                middle,
                spin,
                waves,
            } => {
                let [x, y, z, a, b, c] = [0, 1, 2, 3, 4, 5].map(|place| waves[place].at(seconds));
                let swing = UnitQuaternion::from_scaled_axis(Vector3::new(a, b, c));
                let turn = UnitQuaternion::from_scaled_axis(spin * seconds) * swing;
                let place = middle.translation.vector + Vector3::new(x, y, z);
                Pose::from_parts(place.into(), turn * middle.rotation)
            }
        }
    }
}

impl Segments {
    fn new(random: &mut Random) -> Self {
        let from = Pose::new(random.gaussian(0.05), random.direction().scale(3.0));
        let rates = [[Vector3::zeros(); 2]; 2];
        Self(vec![Segment {
            start_s: 0.0,
            from,
            rates,
        }])
    }

    fn end_s(&self) -> f64 {
        self.0.last().map_or(0.0, |leg| leg.start_s)
    }

    fn at(&self, seconds: f64) -> Pose {
        let next = self.0.partition_point(|leg| leg.start_s <= seconds).max(1);
        self.0[next - 1].at(seconds)
    }

    fn place(&self) -> Vector3<f64> {
        self.at(self.end_s()).translation.vector
    }

    /// The last leg ends after some seconds; the next begins with its speeds.
    fn last(&mut self, seconds: f64) {
        let Some(leg) = self.0.last() else { return };
        let start_s = leg.start_s + seconds;
        let reached = |[speed, half]: [Vector3<f64>; 2]| [speed + half * 2.0 * seconds; 2];
        let rates = leg
            .rates
            .map(reached)
            .map(|[speed, _]| [speed, speed * 0.0]);
        let from = leg.at(start_s);
        self.0.push(Segment {
            start_s,
            from,
            rates,
        });
    }

    /// Reaches speeds (m/s, rad/s) within some seconds.
    fn accelerate(&mut self, speeds: [Vector3<f64>; 2], seconds: f64) {
        if let Some(leg) = self.0.last_mut() {
            for ([speed, half], wanted) in leg.rates.iter_mut().zip(speeds) {
                *half = (wanted - *speed) / (2.0 * seconds);
            }
        }
        self.last(seconds);
    }

    /// Sets out for another place in the middle, to be reached after the cruise.
    fn veer(&mut self, ramp_s: f64, cruise_s: f64, random: &mut Random) {
        let goal = random.gaussian(0.08);
        let speed = (goal - self.place()) / (cruise_s + ramp_s);
        let turning = random.direction().scale(random.within(0.0, 4.0));
        self.accelerate([speed, turning], ramp_s);
    }

    fn fly(&mut self, [speed, spin]: [Vector3<f64>; 2], seconds: f64) {
        if let Some(leg) = self.0.last_mut() {
            let fall = Vector3::new(0.0, 0.0, -0.5 * 9.81);
            leg.rates = [[speed, fall], [spin, Vector3::zeros()]];
        }
        self.last(seconds);
    }
}
