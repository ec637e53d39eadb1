//! What happens to a site: drawn from a seed, before it happens.

use sextant_simulator::Random;
use std::fmt;

/// A second, ns.
pub const S: u64 = 1_000_000_000;
/// A millisecond, ns.
pub const MS: u64 = 1_000_000;
/// Everything is mended so long before the end, ns.
pub const QUIET_NS: u64 = 15 * S;

/// A process on a host of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// A fusion node.
    Fusion(usize),
    /// A camera.
    Camera(usize),
    /// Someone who watches the site and changes it.
    Client,
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fusion(index) => write!(formatter, "fusion {index}"),
            Self::Camera(index) => write!(formatter, "camera {index}"),
            Self::Client => write!(formatter, "client"),
        }
    }
}

/// What is wrong for a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaultKind {
    /// Nothing passes between a process and its router.
    Cut(Place),
    /// Nothing passes from the router to a process; the other direction works.
    Deaf(Place),
    /// Nothing passes from a process to its router; the other direction works.
    Mute(Place),
    /// Nothing passes between the two routers.
    Parted,
    /// A router is down.
    RouterDown(usize),
    /// Messages to and from a process take longer, by up to so many ns.
    Slow(Place, u64),
    /// So large a share of the messages that may be lost is lost.
    Lossy(Place, f64),
    /// The process is killed, and started again at the end.
    Killed(Place),
    /// Its host loses power, and starts again at the end.
    PowerOff(Place),
    /// The process stands still.
    Paused(Place),
    /// Its wall clock is set by so many ns, and stays so.
    ClockSet(Place, i64),
    /// Writing a file takes so many ns.
    SlowDisk(usize, u64),
    /// No file can be written.
    FullDisk(usize),
    /// An image takes a fusion node so many ns.
    Overloaded(usize, u64),
}

impl FaultKind {
    /// Its name, for the table of what was met.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Cut(_) => "link cut",
            Self::Deaf(_) | Self::Mute(_) => "link half open",
            Self::Parted => "site divided",
            Self::RouterDown(_) => "router down",
            Self::Slow(..) => "link slow",
            Self::Lossy(..) => "messages lost",
            Self::Killed(_) => "process killed",
            Self::PowerOff(_) => "power lost",
            Self::Paused(_) => "process stopped",
            Self::ClockSet(..) => "clock set",
            Self::SlowDisk(..) => "disk slow",
            Self::FullDisk(_) => "disk full",
            Self::Overloaded(..) => "overload",
        }
    }

    /// The place that it concerns; none where it concerns the routers.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        match *self {
            Self::Cut(place)
            | Self::Deaf(place)
            | Self::Mute(place)
            | Self::Slow(place, _)
            | Self::Lossy(place, _)
            | Self::Killed(place)
            | Self::PowerOff(place)
            | Self::Paused(place)
            | Self::ClockSet(place, _) => Some(place),
            Self::SlowDisk(index, _) | Self::FullDisk(index) | Self::Overloaded(index, _) => {
                Some(Place::Fusion(index))
            }
            Self::Parted | Self::RouterDown(_) => None,
        }
    }
}

/// Something wrong, from and until when in ns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// What.
    pub kind: FaultKind,
    /// From.
    pub from_ns: u64,
    /// Until.
    pub until_ns: u64,
}

impl Fault {
    /// Whether it lasts at a time.
    #[must_use]
    pub fn lasts(&self, at_ns: u64) -> bool {
        (self.from_ns..self.until_ns).contains(&at_ns)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from_s, until_s] = [self.from_ns, self.until_ns].map(|ns| ns as f64 * 1e-9);
        write!(formatter, "{from_s:.3} to {until_s:.3} s {:?}", self.kind)
    }
}

/// A change that the client asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeRequest {
    /// The world of the rig lies so many quarters of a metre along x.
    World(i32),
    /// An object is removed.
    Remove(usize),
    /// An object is as it was in the initial.
    Restore(usize),
    /// A camera's gain, tenths.
    Gain(usize, u8),
    /// The rig as by [`Self::World`], and an object as by [`Self::Restore`], together.
    Both(i32, usize),
}

/// What somebody gets wrong at the site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SiteMistake {
    /// A camera is pushed aside by so many metres, at a time in ns.
    CameraMoved(usize, f64, u64),
    /// A camera is turned about its line of sight by so many right angles, at a time in ns.
    CameraTurned(usize, u8, u64),
    /// Two cameras have the names of each other in the rig file.
    NamesExchanged(usize, usize),
    /// The tags of an object are printed at a scale.
    PrintScaled(usize, f64),
}

impl SiteMistake {
    /// When it is made, ns; 0 where it is in the files.
    #[must_use]
    pub fn at_ns(&self) -> u64 {
        match *self {
            Self::CameraMoved(.., at_ns) | Self::CameraTurned(.., at_ns) => at_ns,
            Self::NamesExchanged(..) | Self::PrintScaled(..) => 0,
        }
    }

    fn new(plan: &Plan, random: &mut Random) -> Self {
        let camera = random.below(plan.cameras);
        let at_ns = 4 * S + (random.uniform() * (plan.end_ns - QUIET_NS - 4 * S) as f64) as u64;
        match random.below(4) {
            0 => Self::CameraMoved(camera, [0.2, 0.5, 1.0][random.below(3)], at_ns),
            1 => Self::CameraTurned(camera, 1 + random.below(3) as u8, at_ns),
            2 => Self::NamesExchanged(camera, (camera + 1) % plan.cameras),
            _ => Self::PrintScaled(
                random.below(plan.objects),
                [0.93, 0.95, 1.05][random.below(3)],
            ),
        }
    }
}

/// A site, what goes wrong there, and what is changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Of everything.
    pub seed: u64,
    /// How many.
    pub cameras: usize,
    /// How many.
    pub objects: usize,
    /// Images a second of each camera.
    pub rate_hz: f64,
    /// Fusion nodes.
    pub nodes: usize,
    /// One or two.
    pub routers: usize,
    /// Whether fusion nodes share the objects among them.
    pub shares: bool,
    /// Whether changes outlive the fusion nodes.
    pub keeps: bool,
    /// Whether the site's files are exact, and say so.
    pub exact: bool,
    /// By how much cameras' clocks are off, ns.
    pub clocks_off_ns: u64,
    /// Whether the site is recorded. Nodes that share objects do not publish what they took in.
    pub records: bool,
    /// When each fusion node starts first, ns.
    pub starts_ns: Vec<u64>,
    /// What goes wrong.
    pub faults: Vec<Fault>,
    /// What somebody gets wrong.
    pub mistake: Option<SiteMistake>,
    /// What the client asks for, and when.
    pub requests: Vec<(u64, ChangeRequest)>,
    /// When it ends.
    pub end_ns: u64,
}

impl Plan {
    /// Of a seed: from 27 to 60 s.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Random::from_keys(&[seed, 0x706c_616e]);
        let (cameras, objects) = (2 + random.below(4), 1 + random.below(3));
        let nodes = [1, 2, 2, 3][random.below(4)];
        let end_ns = (27 + random.below(34) as u64) * S;
        let mut plan = Self {
            seed,
            cameras,
            objects,
            rate_hz: [4.0, 6.0, 10.0][random.below(3)],
            nodes,
            routers: 1 + random.below(2),
            shares: random.chance(0.2),
            keeps: random.chance(0.7),
            exact: random.chance(0.6),
            clocks_off_ns: [0, 0, 15 * MS][random.below(3)],
            records: false,
            starts_ns: (0..nodes).map(|_| start(&mut random)).collect(),
            faults: Vec::new(),
            mistake: None,
            requests: Vec::new(),
            end_ns,
        };
        let n_faults = [0, 1, 2, 3, 5, 8][random.below(6)];
        plan.faults = (0..n_faults).map(|_| plan.fault(&mut random)).collect();
        let n_wishes = [0, 0, 1, 3, 6][random.below(5)];
        for _ in 0..n_wishes {
            let at_ns = plan.time_of_request(&mut random);
            let request = plan.request(&mut random);
            plan.requests.push((at_ns, request));
        }
        plan.requests.sort_by_key(|(at_ns, _)| *at_ns);
        plan.records = !plan.shares && random.chance(0.3);
        plan
    }

    /// The plan with a mistake, in files that are off.
    #[must_use]
    pub fn with_mistake(mut self) -> Self {
        let mut random = Random::from_keys(&[self.seed, 0x6d69_7374]);
        self.exact = false;
        self.mistake = Some(SiteMistake::new(&self, &mut random));
        self
    }

    /// The plan without some faults and requests, which are numbered in this order.
    #[must_use]
    pub fn without(&self, numbers: &[usize]) -> Self {
        let mut number = 0..;
        let mut is_left = || {
            number
                .next()
                .is_none_or(|number| !numbers.contains(&number))
        };
        let mut plan = self.clone();
        plan.faults.retain(|_| is_left());
        plan.requests.retain(|_| is_left());
        plan
    }

    fn place(&self, random: &mut Random) -> Place {
        match random.below(10) {
            0..5 => Place::Fusion(random.below(self.nodes)),
            5..9 => Place::Camera(random.below(self.cameras)),
            _ => Place::Client,
        }
    }

    fn fault(&self, random: &mut Random) -> Fault {
        let from_ns = 3 * S + (random.uniform() * (self.end_ns - QUIET_NS - 4 * S) as f64) as u64;
        let longest_s = [0.05, 0.3, 1.5, 4.0, 12.0][random.below(5)];
        let until_ns = from_ns + (random.between(0.2, 1.0) * longest_s * 1e9) as u64;
        let (place, node) = (self.place(random), random.below(self.nodes));
        let kind = match random.below(15) {
            0 => FaultKind::Cut(place),
            1 => FaultKind::Deaf(place),
            2 => FaultKind::Mute(place),
            3 | 4 if self.routers > 1 => FaultKind::Parted,
            3..6 => FaultKind::RouterDown(random.below(self.routers)),
            6 => FaultKind::Slow(place, [3, 30, 300][random.below(3)] * MS),
            7 => FaultKind::Lossy(place, random.between(0.1, 1.0)),
            8 | 9 => FaultKind::Killed(place),
            10 => FaultKind::PowerOff(place),
            11 => FaultKind::Paused(place),
            12 => {
                let by_s = [0.02, 1.0, 60.0, 3600.0][random.below(4)] * random.between(-1.0, 1.0);
                FaultKind::ClockSet(place, (by_s * 1e9) as i64)
            }
            13 if random.chance(0.5) => {
                FaultKind::SlowDisk(node, [30, 700, 4000][random.below(3)] * MS)
            }
            13 => FaultKind::FullDisk(node),
            _ => FaultKind::Overloaded(node, [5, 40, 700][random.below(3)] * MS),
        };
        Fault {
            kind,
            from_ns,
            until_ns: until_ns.min(self.end_ns - QUIET_NS),
        }
    }

    /// Any time; half of the requests come while something is wrong, and some shortly after another one, since what
    /// goes wrong together is seldom met by chance.
    fn time_of_request(&self, random: &mut Random) -> u64 {
        let (first_ns, last_ns) = (2 * S, self.end_ns - QUIET_NS);
        let within = |random: &mut Random, from_ns: u64, until_ns: u64| {
            from_ns + (random.uniform() * until_ns.saturating_sub(from_ns) as f64) as u64
        };
        let at_ns = match (
            random.below(4),
            self.faults.as_slice(),
            self.requests.last(),
        ) {
            (0 | 1, faults @ [_, ..], _) => {
                let fault = &faults[random.below(faults.len())];
                within(random, fault.from_ns, fault.until_ns)
            }
            (2, _, Some((at_ns, _))) => within(random, *at_ns, at_ns + 300 * MS),
            _ => within(random, first_ns, last_ns),
        };
        at_ns.clamp(first_ns, last_ns)
    }

    fn request(&self, random: &mut Random) -> ChangeRequest {
        let object = random.below(self.objects);
        let world = random.below(9) as i32 - 4;
        match random.below(6) {
            0 | 1 => ChangeRequest::World(world),
            2 => ChangeRequest::Remove(object),
            3 => ChangeRequest::Restore(object),
            4 => ChangeRequest::Gain(random.below(self.cameras), 10 + random.below(20) as u8),
            _ => ChangeRequest::Both(world, object),
        }
    }
}

fn start(random: &mut Random) -> u64 {
    match random.chance(0.6) {
        true => random.below(50) as u64 * MS,
        false => random.below(8000) as u64 * MS,
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut words = format!(
            "seed {}: {} cameras at {} Hz, {} objects, {} fusion nodes, {} routers, {:.0} s",
            self.seed,
            self.cameras,
            self.rate_hz,
            self.objects,
            self.nodes,
            self.routers,
            self.end_ns as f64 * 1e-9
        );
        for (holds, word) in [
            (self.shares, "shares objects"),
            (self.keeps, "keeps changes"),
            (self.exact, "exact files"),
            (self.clocks_off_ns > 0, "cameras' clocks off"),
            (self.records, "recorded"),
        ] {
            if holds {
                words += ", ";
                words += word;
            }
        }
        writeln!(formatter, "{words}")?;
        if let Some(mistake) = &self.mistake {
            writeln!(formatter, "  {mistake:?}")?;
        }
        for fault in &self.faults {
            writeln!(formatter, "  {fault}")?;
        }
        for (at_ns, request) in &self.requests {
            writeln!(formatter, "  {:.3} s {request:?}", *at_ns as f64 * 1e-9)?;
        }
        Ok(())
    }
}
