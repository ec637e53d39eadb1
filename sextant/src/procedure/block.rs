//! A procedure under way as lines of text: what each camera or tag lacks, and what to do next.

use sextant_calibrator::procedure::{
    LearnDetails, LensDetails, ProcedureKind, Progress, ProgressDetails, RigDetails,
};
use sextant_calibrator::{CameraProgress, SketchedTag, TagProgress};

/// Characters of the bar.
const BAR: usize = 24;
/// Characters of the sketch, across and down: about square on a terminal.
const CANVAS: [usize; 2] = [44, 15];
/// Viewpoint of the sketch: rotations about the vertical and then the horizontal axis, radians.
const VIEW: [f64; 2] = [0.35, -0.3];

/// Progress in one line.
pub fn line(progress: &Progress) -> String {
    format!(
        "{:>3.0} %  {:>5} images  {}",
        percent(progress),
        progress.images,
        progress.hint
    )
}

/// All there is to see.
pub fn lines(progress: &Progress, remarks: &[String]) -> Vec<String> {
    let mut lines = match &progress.details {
        ProgressDetails::Lens(details) => of_lens(details),
        ProgressDetails::Rig(details) => of_rig(details),
        ProgressDetails::Learn(details) => of_learn(details),
    };
    lines.extend(remarks.iter().map(|remark| format!("! {remark}")));
    let full = (progress.fraction.clamp(0.0, 1.0) * BAR as f64) as usize;
    lines.push(format!(
        "{} [{}{}] {:.0} %  {} images  Ctrl-C ends it and solves",
        match progress.kind {
            ProcedureKind::Lens => "lens",
            ProcedureKind::Rig => "rig",
            ProcedureKind::Learn => "learning",
        },
        "#".repeat(full),
        "-".repeat(BAR - full),
        percent(progress),
        progress.images
    ));
    lines.push(format!("> {}", progress.hint));
    lines
}

/// Rounded down: 100 means enough.
fn percent(progress: &Progress) -> f64 {
    (100.0 * progress.fraction).floor()
}

/// The picture in cells, from empty to full.
fn of_lens(details: &LensDetails) -> Vec<String> {
    let cell = |corners: &u32| match corners {
        0 => '.',
        1..10 => '-',
        10..40 => '+',
        _ => '#',
    };
    let rows = details.coverage.iter();
    let mut lines: Vec<String> = rows
        .map(|row| {
            row.iter()
                .flat_map(|corners| [cell(corners), ' '])
                .collect()
        })
        .collect();
    let [left, right, upper, lower] = details.tilted;
    lines.push(format!(
        "{} views; tilted away: left side {left}, right {right}, upper {upper}, lower {lower}",
        details.views
    ));
    lines
}

fn of_rig(details: &RigDetails) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<14} {:>7} {:>6}  {:<14} {:>9}  together with",
        "camera", "images", "seen", "where (4 x 3)", "distances"
    )];
    let cameras = details.cameras.iter();
    lines.extend(cameras.map(|camera| {
        format!(
            "{:<14} {:>7} {:>6}  {:<14} {:>9}  {}",
            camera.camera,
            camera.images,
            camera.seeing,
            fields(camera),
            camera.distances,
            company(details, camera)
        )
    }));
    lines
}

fn fields(camera: &CameraProgress) -> String {
    let row = |row: &[bool]| -> String {
        let field = |seen: &bool| if *seen { '#' } else { '.' };
        row.iter().map(field).collect()
    };
    let rows: Vec<String> = camera.fields.chunks(4).map(row).collect();
    rows.join(" ")
}

fn company(details: &RigDetails, camera: &CameraProgress) -> String {
    let pairs = details.together.iter();
    let others: Vec<String> = pairs
        .filter_map(|(a, b, times)| match &camera.camera {
            own if own == a => Some(format!("{b} ({times})")),
            own if own == b => Some(format!("{a} ({times})")),
            _ => None,
        })
        .collect();
    or_nothing(others)
}

fn of_learn(details: &LearnDetails) -> Vec<String> {
    let mut lines = sketch(&details.sketch);
    lines.push(format!(
        "{:<16} {:>6} {:>9}  joined with",
        "tag", "images", "sides (3)"
    ));
    let tags = details.tags.iter();
    lines.extend(tags.map(|tag| {
        format!(
            "{:<16} {:>6} {:>9}  {}",
            tag.tag,
            tag.images,
            tag.directions,
            joined(&details.tags, tag)
        )
    }));
    if let Some(still) = details.found.as_ref().map(|found| &found.still)
        && !still.is_empty()
    {
        lines.push(format!("standing still: {}", still.join(", ")));
    }
    lines
}

fn joined(tags: &[TagProgress], tag: &TagProgress) -> String {
    let same = |other: &&TagProgress| other.group == tag.group && other.tag != tag.tag;
    let others = tags.iter().filter(same);
    or_nothing(others.map(|other| number(&other.tag).to_owned()).collect())
}

fn or_nothing(others: Vec<String>) -> String {
    if others.is_empty() {
        "nothing yet".to_owned()
    } else {
        others.join(", ")
    }
}

/// The tag's number without its family.
fn number(tag: &str) -> &str {
    tag.rsplit(':').next().unwrap_or(tag)
}

/// Tag numbers at their positions, seen slightly from the side, so that they do not overlap.
fn sketch(tags: &[SketchedTag]) -> Vec<String> {
    if tags.is_empty() {
        return Vec::new();
    }
    let seen: Vec<[f64; 2]> = tags.iter().map(|tag| seen(tag.position)).collect();
    let bounds = [0, 1].map(|axis| {
        let along = || seen.iter().map(move |at| at[axis]);
        let low = along().fold(f64::INFINITY, f64::min);
        (low, along().fold(f64::NEG_INFINITY, f64::max) - low)
    });
    // A character is twice as high as wide.
    let across = (CANVAS[0] - 4) as f64 / bounds[0].1.max(1e-3);
    let scale = across.min(2.0 * (CANVAS[1] - 1) as f64 / bounds[1].1.max(1e-3));
    let mut canvas = vec![vec![' '; CANVAS[0]]; 1 + (bounds[1].1 * scale / 2.0) as usize];
    for (tag, [right, up]) in tags.iter().zip(&seen) {
        let column = ((right - bounds[0].0) * scale) as usize;
        let row = ((bounds[1].0 + bounds[1].1 - up) * scale / 2.0) as usize;
        let row = row.min(canvas.len() - 1);
        let name = number(&tag.tag).chars();
        for (place, letter) in canvas[row].iter_mut().skip(column).zip(name) {
            *place = letter;
        }
    }
    let rows = canvas.into_iter();
    rows.map(|row| format!("  {}", row.into_iter().collect::<String>().trim_end()))
        .collect()
}

/// Right and up as the viewer of the sketch has them.
fn seen([x, y, z]: [f64; 3]) -> [f64; 2] {
    let (right, away) = (
        x * VIEW[0].cos() + z * VIEW[0].sin(),
        -x * VIEW[0].sin() + z * VIEW[0].cos(),
    );
    [right, y * VIEW[1].cos() - away * VIEW[1].sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(id: u32, position: [f64; 3]) -> SketchedTag {
        SketchedTag {
            tag: format!("tag36h11:{id}"),
            size_m: 0.04,
            position,
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }

    #[test]
    fn a_sketch_shows_what_is_right_and_above() {
        let tags = [
            at(3, [0.0; 3]),
            at(14, [0.1, 0.0, 0.0]),
            at(5, [0.0, 0.1, 0.0]),
        ];
        let drawn = sketch(&tags);
        let find = |name: &str| {
            let row = drawn.iter().position(|row| row.contains(name)).unwrap();
            (row, drawn[row].find(name).unwrap())
        };
        let ([three, fourteen], five) = (["3", "14"].map(find), find("5"));
        assert!(fourteen.1 > three.1 + 10, "{drawn:#?}");
        assert!(five.0 + 5 < three.0, "{drawn:#?}");
        assert!(drawn.len() <= CANVAS[1]);
    }

    #[test]
    fn one_place_and_wild_places_are_drawn_too() {
        assert!(sketch(&[at(1, [0.0; 3]), at(2, [0.0; 3])]).len() == 1);
        let far = sketch(&[at(1, [-1e9, 1e9, 3.0]), at(2, [1e9, 0.0, -1e9])]);
        assert!(far.len() <= CANVAS[1] && far.iter().all(|row| row.len() <= CANVAS[0] + 2));
    }

    #[test]
    fn joined_tags_are_named_without_their_family() {
        let tag = |id: u32, group| TagProgress {
            tag: format!("tag36h11:{id}"),
            images: 4,
            directions: 1,
            group,
        };
        let details = LearnDetails {
            joining: 2,
            tags: vec![tag(3, 0), tag(4, 0), tag(9, 2)],
            sketch: Vec::new(),
            found: None,
        };
        let lines = of_learn(&details);
        assert!(lines[1].ends_with("  4"), "{lines:#?}");
        assert!(lines[3].ends_with("  nothing yet"), "{lines:#?}");
    }
}
