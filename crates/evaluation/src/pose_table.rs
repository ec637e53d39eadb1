//! Columns of a text table of poses: which one is the time, the position and the quaternion, and in which units.
//!
//! A header decides where there is one: `#timestamp [ns],tx,ty,tz,qx,qy,qz,qw`, EuRoC's `p_RS_R_x [m]`, ROS's
//! `pose.position.x`. Columns that are no pose are passed over. Without a header the order is that of the format.

use sextant_geometry::{Pose, PoseParts};
use std::borrow::Cow;

/// Where a pose stands in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PoseColumns {
    /// Whether the time is the number of an image in its stead.
    is_by_image: bool,
    /// Column, and power of ten from its unit to nanoseconds; unknown where the header leaves it out.
    time: (usize, Option<i32>),
    /// Columns of x, y, z, and metres in their unit.
    position: [(usize, f64); 3],
    /// Columns of x, y, z, w.
    quaternion: [usize; 4],
}

/// Decimal digits from seconds to nanoseconds.
const SECONDS: i32 = 9;
const NANOSECONDS: i32 = 0;

impl PoseColumns {
    /// Seconds x y z qx qy qz qw: the trajectories of TUM's benchmark, which `evo` reads and writes.
    pub(crate) const TUM: Self = Self::of_order(SECONDS, [4, 5, 6, 7]);
    /// Nanoseconds, x, y, z, qw, qx, qy, qz: EuRoC's ground truth.
    pub(crate) const EUROC: Self = Self::of_order(NANOSECONDS, [5, 6, 7, 4]);

    const fn of_order(time_unit: i32, quaternion: [usize; 4]) -> Self {
        Self {
            is_by_image: false,
            time: (0, Some(time_unit)),
            position: [(1, 1.0), (2, 1.0), (3, 1.0)],
            quaternion,
        }
    }

    /// Whether rows have the number of an image in place of a time.
    pub(crate) fn is_by_image(&self) -> bool {
        self.is_by_image
    }

    /// Why a row is not of this format, which has no header; nothing where it may be.
    pub(crate) fn complaint_without_header(&self, line: &str) -> Option<String> {
        let columns = split(line);
        let n = columns.len();
        if n == 12 || n == 16 {
            return Some(format!(
                "{n} columns, as matrices have; write a time and a quaternion in their place"
            ));
        }
        if *self == Self::TUM && n > 8 {
            return Some(format!("{n} columns, of which nothing says what they are"));
        }
        let time = columns
            .first()
            .map(|time| time.as_ref())
            .unwrap_or_default();
        let is_whole = time.bytes().all(|byte| byte.is_ascii_digit());
        (*self == Self::EUROC && !is_whole)
            .then(|| format!("\"{time}\" is no whole number of nanoseconds"))
    }

    /// How a row without a header is written.
    pub(crate) fn form(&self) -> &'static str {
        match *self == Self::EUROC {
            true => "timestamp [ns], x, y, z, qw, qx, qy, qz",
            false => "seconds x y z qx qy qz qw, as `evo` reads it",
        }
    }

    /// The columns that a line names; nothing where it is no header. A line that names a time and half of a pose is
    /// one.
    ///
    /// # Errors
    /// A header without one of the columns, with two of one kind, or with an unknown unit.
    pub(crate) fn of_header(line: &str) -> Option<Result<Self, String>> {
        let names = names_of(line);
        let found: Vec<(usize, Role, Option<&str>)> = names
            .iter()
            .enumerate()
            .filter_map(|(index, name)| {
                let (name, unit) = unit_of(name);
                Some((index, role_of(name)?, unit))
            })
            .collect();
        let has = |role: Role| found.iter().any(|(_, found, _)| *found == role);
        let n_named = Role::POSE.iter().filter(|role| has(**role)).count();
        let has_key = has(Role::Time) || has(Role::Stamp) || has(Role::Image);
        let is_vector = ["rx", "ry", "rz"].iter().all(|axis| {
            names
                .iter()
                .any(|name| unit_of(name).0.eq_ignore_ascii_case(axis))
        });
        (has_key && n_named >= 3).then(|| {
            Self::of_roles(&found).map_err(|error| match is_vector {
                true => format!("{error}{VECTOR_REMEDY}"),
                false => error,
            })
        })
    }

    fn of_roles(found: &[(usize, Role, Option<&str>)]) -> Result<Self, String> {
        let has = |role: Role| found.iter().any(|(_, found, _)| *found == role);
        let column = |role: Role| {
            // Of ROS' tables the time of the message counts, not that at which it was recorded.
            let role = match role {
                Role::Time if has(Role::Stamp) => Role::Stamp,
                role => role,
            };
            let mut named = found.iter().filter(|(_, found, _)| *found == role);
            match (named.next(), named.next()) {
                (Some((index, _, unit)), None) => Ok((*index, *unit)),
                (None, _) => Err(format!("the header names no column {}", role.word())),
                (Some(_), Some(_)) => Err(format!("the header names two columns {}", role.word())),
            }
        };
        let position = |axis| {
            let (index, unit) = column(Role::Position(axis))?;
            Ok::<_, String>((index, metres_in(unit)?))
        };
        let quaternion = |axis| Ok::<_, String>(column(Role::Quaternion(axis))?.0);
        let is_by_image = !has(Role::Time) && !has(Role::Stamp);
        let time = match is_by_image {
            true => (column(Role::Image)?.0, Some(NANOSECONDS)),
            false => {
                let (time, unit) = column(Role::Time)?;
                (time, unit.map(digits_to_ns).transpose()?)
            }
        };
        Ok(Self {
            is_by_image,
            time,
            position: [position(0)?, position(1)?, position(2)?],
            quaternion: [
                quaternion(0)?,
                quaternion(1)?,
                quaternion(2)?,
                quaternion(3)?,
            ],
        })
    }

    /// The unit that a row's time seems to have, where the header names none.
    pub(crate) fn guessed_unit(&self, line: &str) -> Option<i32> {
        let columns = split(line);
        let time = columns.get(self.time.0)?;
        self.time.1.is_none().then(|| probable_unit(time))
    }

    /// Whether a row has the time alone: the body was out of sight.
    pub(crate) fn is_empty(&self, line: &str) -> bool {
        let columns = split(line);
        let position = self.position.iter().map(|(index, _)| index);
        let mut all = position.chain(&self.quaternion);
        all.any(|index| {
            let cell = columns.get(*index).map(|cell| cell.as_ref());
            cell.is_some_and(|cell: &str| cell.is_empty() || cell.eq_ignore_ascii_case("nan"))
        })
    }

    /// Time, ns, and pose of a row.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn row(&self, line: &str) -> Result<(u64, Pose), String> {
        let columns = split(line);
        let text = |index: usize| {
            let missing = || format!("{} columns; column {} is missing", columns.len(), index + 1);
            let cell = columns.get(index).map(|cell| cell.as_ref());
            cell.ok_or_else(missing)
        };
        let number = |index: usize| {
            let text = text(index)?;
            let number = text.parse::<f64>();
            number.map_err(|_| format!("\"{text}\" in column {} is no number", index + 1))
        };
        let time = text(self.time.0)?;
        let unit = self.time.1.unwrap_or_else(|| probable_unit(time));
        let t_ns = ns_of(time, unit).ok_or_else(|| format!("\"{time}\" is no time"))?;
        let [x, y, z] = self.position;
        let metres = |(index, unit_m): (usize, f64)| Ok::<_, String>(number(index)? * unit_m);
        let [qx, qy, qz, qw] = self.quaternion;
        let parts = PoseParts {
            position: [metres(x)?, metres(y)?, metres(z)?],
            orientation: [number(qx)?, number(qy)?, number(qz)?, number(qw)?],
        };
        let pose = parts.to_pose().map_err(|cause| cause.to_string())?;
        Ok((t_ns, pose))
    }
}

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    /// The time of a message, beside that at which it was recorded.
    Stamp,
    /// The number of an image, from 0.
    Image,
    /// x, y, z.
    Position(usize),
    /// x, y, z, w.
    Quaternion(usize),
}

impl Role {
    const POSE: [Self; 7] = [
        Self::Position(0),
        Self::Position(1),
        Self::Position(2),
        Self::Quaternion(0),
        Self::Quaternion(1),
        Self::Quaternion(2),
        Self::Quaternion(3),
    ];

    fn word(self) -> String {
        match self {
            Self::Time | Self::Stamp => "timestamp".to_owned(),
            Self::Image => "image".to_owned(),
            Self::Position(axis) => ["x", "y", "z"][axis].to_owned(),
            Self::Quaternion(axis) => ["qx", "qy", "qz", "qw"][axis].to_owned(),
        }
    }
}

/// What to do with a table of rotation vectors or angles, which are written alike.
const VECTOR_REMEDY: &str = "; rx, ry and rz may be a rotation vector or angles: write the orientation as a quaternion \
                             (of a rotation vector of the length a: (qx, qy, qz) = sin(a/2)/a (rx, ry, rz), qw = \
                             cos(a/2))";

/// The role that a name says: `timestamp`, `tx`, `p_RS_R_x`, `pose.position.x`, `q_RS_w`, `qw`.
fn role_of(name: &str) -> Option<Role> {
    let name = name.to_lowercase();
    let name = name.trim_start_matches('_');
    if name.ends_with("header.stamp") {
        return Some(Role::Stamp);
    }
    if matches!(name, "t" | "time" | "timestamp" | "stamp" | "time_stamp") {
        return Some(Role::Time);
    }
    if name == "image" {
        return Some(Role::Image);
    }
    let axis = "xyzw".find(name.chars().next_back()?)?;
    let stem = &name[..name.len() - 1];
    let words: Vec<&str> = stem
        .split(['_', '.', '-', ' ', '/'])
        .filter(|w| !w.is_empty())
        .collect();
    let is_one_of = |known: &[&str]| words.iter().any(|word| known.contains(word));
    if is_one_of(&["q", "quat", "quaternion", "orientation", "rot", "rotation"]) {
        return Some(Role::Quaternion(axis));
    }
    let is_position =
        words.is_empty() || is_one_of(&["p", "t", "pos", "position", "trans", "translation"]);
    (is_position && axis < 3).then_some(Role::Position(axis))
}

/// A name and its unit in brackets, as in `x [mm]`, or at its end, as in `x_mm` and `t_ns`.
fn unit_of(name: &str) -> (&str, Option<&str>) {
    if let Some((name, unit)) = name.split_once(['[', '(']) {
        let unit = unit.trim_end_matches([']', ')']).trim();
        return (name.trim(), (!unit.is_empty()).then_some(unit));
    }
    let units = ["ns", "us", "ms", "s", "sec", "m", "cm", "mm"];
    match name.rsplit_once('_') {
        Some((name, unit)) if units.contains(&&*unit.to_lowercase()) => (name, Some(unit)),
        _ => (name, None),
    }
}

fn metres_in(unit: Option<&str>) -> Result<f64, String> {
    match unit.map(str::to_lowercase).as_deref() {
        None | Some("m" | "metre" | "metres" | "meter" | "meters") => Ok(1.0),
        Some("cm") => Ok(1e-2),
        Some("mm") => Ok(1e-3),
        Some(other) => Err(format!(
            "the header has the unknown unit [{other}]; known are m, cm and mm"
        )),
    }
}

fn digits_to_ns(unit: &str) -> Result<i32, String> {
    match &*unit.to_lowercase() {
        "ns" | "nsec" | "nanoseconds" => Ok(NANOSECONDS),
        "us" | "µs" | "usec" | "microseconds" => Ok(3),
        "ms" | "msec" | "milliseconds" => Ok(6),
        "s" | "sec" | "seconds" => Ok(SECONDS),
        other => Err(format!(
            "the header has the unknown unit [{other}]; known are ns, us, ms and s"
        )),
    }
}

/// The unit of a time whose header has none, by which it lies between 2001 and 5000; small whole numbers are
/// nanoseconds.
fn probable_unit(time: &str) -> i32 {
    let value: f64 = time.parse().unwrap_or(0.0);
    match value {
        _ if value < 1e11 && time.contains('.') => SECONDS,
        1e9..1e11 => SECONDS,
        1e12..1e14 => 6,
        1e15..1e17 => 3,
        _ => NANOSECONDS,
    }
}

/// A decimal number, also with an exponent, in a unit of 10^`digits` ns: exactly, cut to whole nanoseconds.
fn ns_of(text: &str, digits: i32) -> Option<u64> {
    let (number, exponent) = match text.split_once(['e', 'E']) {
        Some((number, exponent)) => (number, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let number = number.strip_prefix('+').unwrap_or(number);
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let all = format!("{whole}{fraction}");
    if all.is_empty() || !all.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let all = all.trim_start_matches('0');
    let leading_zeros = whole.len() + fraction.len() - all.len();
    let point = i32::try_from(whole.len()).ok()? - i32::try_from(leading_zeros).ok()?;
    let kept = point.checked_add(exponent)?.checked_add(digits)?;
    match usize::try_from(kept) {
        Err(_) | Ok(0) => Some(0),
        Ok(kept) if all.is_empty() || kept <= 20 => {
            let padded = format!("{all:0<kept$}");
            padded[..kept].parse().ok()
        }
        Ok(_) => None,
    }
}

fn plain(cell: &str) -> &str {
    cell.trim().trim_matches('"').trim()
}

/// The columns of a row: between semicolons, tabs or commas where there are any, else between blanks. Between the
/// former two a comma is a decimal one.
fn split(line: &str) -> Vec<Cow<'_, str>> {
    match separator(line) {
        None => line.split_whitespace().map(Cow::from).collect(),
        Some(',') => line.split(',').map(plain).map(Cow::from).collect(),
        Some(separator) => {
            let cells = line.split(separator).map(plain);
            cells.map(|cell| cell.replace(',', ".").into()).collect()
        }
    }
}

fn separator(line: &str) -> Option<char> {
    [';', '\t', ',']
        .into_iter()
        .find(|separator| line.contains(*separator))
}

/// The names of a header. Between blanks, a unit in brackets belongs to the name before it.
fn names_of(line: &str) -> Vec<String> {
    let line = line.trim_start_matches(['#', '%']).trim();
    if separator(line).is_some() {
        return split(line).into_iter().map(Cow::into_owned).collect();
    }
    let mut names: Vec<String> = Vec::new();
    for word in line.split_whitespace() {
        match names.last_mut() {
            Some(name) if word.starts_with(['[', '(']) => name.push_str(word),
            _ => names.push(plain(word).to_owned()),
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn rows_of_both_tables_are_read_to_the_nanosecond() {
        let tum = |row| PoseColumns::TUM.row(row);
        let (t_ns, pose) = tum("1800000000.000000005 1 2 3 0 0 0 1").unwrap();
        assert_eq!(t_ns, 1_800_000_000_000_000_005);
        assert_eq!(pose.translation.vector, Vector3::new(1.0, 2.0, 3.0));
        assert_eq!(tum("5.5 1 2 3 0 0 0 1").unwrap().0, 5_500_000_000);
        let euroc = "1403636580838555648,4.6,-1.7,0.8,0.5,0.5,-0.5,-0.5,0,0,0,0,0,0,0,0,0";
        let (t_ns, pose) = PoseColumns::EUROC.row(euroc).unwrap();
        assert_eq!(t_ns, 1_403_636_580_838_555_648);
        assert_eq!(pose.rotation.quaternion().w, 0.5);
        for row in [
            "",
            "x 1 2 3 0 0 0 1",
            "1 1 2 3 0 0 1",
            "1 1 2 3 0 0 0 0",
            "-1 1 2 3 0 0 0 1",
            "1e99 1 2 3 0 0 0 1",
        ] {
            assert!(tum(row).is_err(), "{row}");
        }
    }

    #[test]
    fn times_in_scientific_notation_are_exact() {
        assert_eq!(
            ns_of("1.700000000033333302e+09", SECONDS),
            Some(1_700_000_000_033_333_302)
        );
        assert_eq!(ns_of("1.5e3", SECONDS), Some(1_500_000_000_000));
        assert_eq!(ns_of("2.5E-3", SECONDS), Some(2_500_000));
        assert_eq!(ns_of("0.000000000e+00", SECONDS), Some(0));
        assert_eq!(ns_of("0.033", SECONDS), Some(33_000_000));
        assert_eq!(ns_of("1e-12", SECONDS), Some(0));
        assert_eq!(ns_of("1e", SECONDS), None);
        assert_eq!(ns_of("nan", SECONDS), None);
        assert_eq!(ns_of("1e30", SECONDS), None);
    }

    #[test]
    fn columns_are_read_by_their_names_and_units() {
        let columns = |header: &str| PoseColumns::of_header(header).unwrap().unwrap();
        let euroc = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], \
            q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1]";
        let row = "1403636580838555648,4.6,-1.7,0.8,0.5,0.5,-0.5,-0.5,9,9,9,9";
        assert_eq!(columns(euroc).row(row), PoseColumns::EUROC.row(row));
        let swapped = columns("#timestamp [us],x [mm],y [mm],z [mm],qx,qy,qz,qw");
        let (t_ns, pose) = swapped.row("1700000000000001,20,0,800,1,0,0,0").unwrap();
        assert_eq!(t_ns, 1_700_000_000_000_001_000);
        assert_eq!(pose.translation.vector, Vector3::new(0.02, 0.0, 0.8));
        assert_eq!(pose.rotation.quaternion().i, 1.0);
        let ros = columns("qw;time;pose.position.x;pose.position.y;pose.position.z;qx;qy;qz");
        assert_eq!(
            ros.row("1;1700000000.5;1;2;3;0;0;0").unwrap().0,
            1_700_000_000_500_000_000
        );
        assert_eq!(
            columns("# timestamp tx ty tz qx qy qz qw").row("1700000000.25 1 2 3 0 0 0 1"),
            PoseColumns::TUM.row("1700000000.25 1 2 3 0 0 0 1")
        );
        assert_eq!(
            columns("# t_ns x [cm] y [cm] z [cm] qx qy qz qw")
                .row("7 100 2 3 0 0 0 1")
                .unwrap()
                .1
                .translation
                .x,
            1.0
        );
    }

    #[test]
    fn tables_of_spreadsheets_and_of_ros_are_read() {
        let columns = |header: &str| PoseColumns::of_header(header).unwrap().unwrap();
        let expected = PoseColumns::TUM
            .row("1700000000.25 1.5 2 3 0 0 0 1")
            .unwrap();
        let named = "Time [s];x;y;z;qx;qy;qz;qw";
        assert_eq!(
            columns(named).row("1700000000,25;1,5;2;3;0;0;0;1").unwrap(),
            expected
        );
        let tabs = columns(&named.replace(';', "\t"));
        assert_eq!(
            tabs.row("1700000000.25\t1.5\t2\t3\t0\t0\t0\t1").unwrap(),
            expected
        );
        let quoted = columns("\"time (s)\",\"x\",\"y\",\"z\",\"qx\",\"qy\",\"qz\",\"qw\"");
        assert_eq!(
            quoted
                .row("\"1700000000.25\",\"1.5\",\"2\",\"3\",0,0,0,1")
                .unwrap(),
            expected
        );
        let bag = "%time,field.header.seq,field.header.stamp,field.header.frame_id,\
            field.pose.position.x,field.pose.position.y,field.pose.position.z,\
            field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w";
        let row = "1700000000900000000,5,1700000000250000000,map,1.5,2,3,0,0,0,1";
        assert_eq!(columns(bag).row(row).unwrap(), expected);
        let plots = "__time,/cube/pose/position/x,/cube/pose/position/y,/cube/pose/position/z,\
            /cube/pose/orientation/x,/cube/pose/orientation/y,/cube/pose/orientation/z,/cube/pose/orientation/w";
        assert_eq!(
            columns(plots).row("1700000000.25,1.5,2,3,0,0,0,1").unwrap(),
            expected
        );
        // Out of sight.
        for row in [
            "1700000000.25;;;;;;;",
            "1700000000.25;NaN;NaN;NaN;NaN;NaN;NaN;NaN",
        ] {
            assert!(columns(named).is_empty(row), "{row}");
        }
        assert!(!columns(named).is_empty("1700000000,25;1,5;2;3;0;0;0;1"));
    }

    #[test]
    fn rows_without_a_header_are_of_their_format_or_refused() {
        let refused = |columns: PoseColumns, row: &str| columns.complaint_without_header(row);
        assert_eq!(
            refused(PoseColumns::TUM, "1700000000.25 1 2 3 0 0 0 1"),
            None
        );
        // KITTI's first row was the pose (0, 0, 0) at 1 s.
        let kitti = "1 0 0 0 0 1 0 0 0 0 1 0";
        assert!(
            refused(PoseColumns::TUM, kitti)
                .unwrap()
                .contains("12 columns, as matrices")
        );
        assert!(
            refused(PoseColumns::TUM, "1 1 2 3 0 0 0 1 7")
                .unwrap()
                .contains("9 columns")
        );
        assert_eq!(
            refused(PoseColumns::EUROC, "1700000000250000000,1,2,3,1,0,0,0"),
            None
        );
        let seconds = refused(PoseColumns::EUROC, "1700000000.25,1,2,3,0,0,0,1").unwrap();
        assert!(
            seconds.contains("no whole number of nanoseconds"),
            "{seconds}"
        );
    }

    #[test]
    fn half_a_header_is_refused_and_a_comment_is_none() {
        let refused = |header: &str| PoseColumns::of_header(header).unwrap().unwrap_err();
        assert_eq!(refused("t,x,y,z,qx,qy,qz"), "the header names no column qw");
        let vector = refused("image,x [m],y [m],z [m],rx,ry,rz");
        assert!(
            vector.contains("write the orientation as a quaternion"),
            "{vector}"
        );
        assert!(refused("t,x [ft],y,z,qx,qy,qz,qw").contains("unknown unit [ft]"));
        assert_eq!(
            refused("t,x,y,z,qx,qy,qz,qw,x"),
            "the header names two columns x"
        );
        for comment in [
            "# time of the recording",
            "# ground truth",
            "#",
            "# timestamps in seconds",
        ] {
            assert_eq!(PoseColumns::of_header(comment), None, "{comment}");
        }
    }
}
