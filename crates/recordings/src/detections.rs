//! `detections.jsonl`: what a detector, ours or another, found in the images of one camera; an image a line.

use crate::error::RecordingError;
use crate::lines::{TimeOrder, each_line};
use serde::{Deserialize, Serialize};
use sextant_geometry::wrong_corner_pair;
use sextant_tag_families::Family;
use std::path::Path;

/// The tags of one image: a line of the file. Keys that are not listed here are ignored, so that other detectors may
/// say more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionsLine {
    /// Capture time, middle of the exposure, ns since the Unix epoch.
    pub t_ns: u64,
    /// When the image reached the fusion node, ns; the capture time when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrival_ns: Option<u64>,
    /// The tags; none is news, too.
    pub detections: Vec<DetectedTag>,
}

/// One tag in one image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DetectedTag {
    /// Its family.
    pub family: Family,
    /// Its number within the family.
    pub id: u32,
    /// Top left, top right, bottom right, bottom left; pixels, (0, 0) at the centre of the top-left one. Kept in single
    /// precision, as on the wire: written shortest, the numbers come back exactly.
    pub corners: [[f32; 2]; 4],
    /// Noise of a corner's coordinate, one standard deviation, pixels; the estimator's own default when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_px: Option<f32>,
    /// Covariance of each corner as (xx, xy, yy) in square pixels, in single precision as on the wire; goes before
    /// `sigma_px`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_covariance: Option<[[f32; 3]; 4]>,
    /// Covariance between the corners of each of [`sextant_geometry::CORNER_PAIRS`] in square pixels: x of the one with
    /// x and with y of the other, then y of the one with both; independent when absent. Counts beside
    /// `corner_covariance` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_cross_covariance: Option<[[f32; 4]; 6]>,
}

/// Corners beyond this many pixels are no corners of an image.
const MAX_PIXEL: f32 = 65_536.0;

impl DetectionsLine {
    /// Every line of a file, in the order of time.
    ///
    /// # Errors
    /// A file that cannot be read, or a line that is malformed, out of order, or says a number that is none.
    pub fn read_file(path: &Path) -> Result<Vec<Self>, RecordingError> {
        let mut lines = Vec::new();
        let mut ascending = TimeOrder::default();
        each_line(path, |number, text| {
            let line = Self::parse(text)
                .map_err(|(cause, remedy)| RecordingError::wrong(path, number, cause, remedy))?;
            ascending.check(path, number, line.t_ns)?;
            lines.push(line);
            Ok(())
        })?;
        check_convention(&lines)
            .map_err(|(cause, remedy)| RecordingError::wrong(path, None, cause, remedy))?;
        Ok(lines)
    }

    /// One line.
    ///
    /// # Errors
    /// What is wrong in it, and the remedy.
    pub fn parse(text: &str) -> Result<Self, (String, &'static str)> {
        let line: Self = serde_json::from_str(text).map_err(|error| {
            // The position inside the line is the column; its "line 1" would mislead.
            let cause = error.to_string().replace("at line 1 column", "at column");
            (
                cause,
                "write {\"t_ns\",\"arrival_ns\",\"detections\":[{\"family\",\"id\",\
                \"corners\":[[x,y]x4],\"sigma_px\",\"corner_covariance\":[[xx,xy,yy]x4],\
                \"corner_cross_covariance\":[[xx,xy,yx,yy]x6]}]} with finite numbers",
            )
        })?;
        line.detections.iter().try_for_each(DetectedTag::check)?;
        Ok(line)
    }
}

/// Share of the tags from which they tell of their detector.
const MOST: f64 = 0.9;

/// Refuses corners in another order or unit, which nearly all tags of a file then have.
fn check_convention(lines: &[DetectionsLine]) -> Result<(), (String, &'static str)> {
    let tags = || lines.iter().flat_map(|line| &line.detections);
    let are_most = |has: fn(&DetectedTag) -> bool| {
        let n = tags().filter(|tag| has(tag)).count();
        n > 0 && n as f64 > MOST * tags().count() as f64
    };
    if are_most(DetectedTag::is_below_a_pixel) {
        let cause = "the tags are smaller than a pixel: are their corners shares of the image?";
        return Err((cause.to_owned(), "write pixels"));
    }
    if are_most(DetectedTag::is_mirrored) {
        let cause = "the corners of the tags run counterclockwise in the image";
        let remedy =
            "write those of the upright tag: top left, top right, bottom right, bottom left";
        return Err((cause.to_owned(), remedy));
    }
    Ok(())
}

impl DetectedTag {
    fn is_below_a_pixel(&self) -> bool {
        let [first, ..] = self.corners;
        let mut others = self.corners.iter();
        others.all(|[x, y]| (x - first[0]).abs() < 1.0 && (y - first[1]).abs() < 1.0)
    }

    /// Whether the corners run counterclockwise for a viewer of the image, as those of no tag do that faces the camera.
    fn is_mirrored(&self) -> bool {
        let after = self.corners.iter().cycle().skip(1);
        let edges = self.corners.iter().zip(after);
        edges.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f32>() < 0.0
    }

    fn check(&self) -> Result<(), (String, &'static str)> {
        let tag = format!("{}:{}", self.family, self.id);
        // Written so that NaN is refused.
        let inside = |pixel: &f32| pixel.abs() <= MAX_PIXEL;
        if !self.corners.iter().flatten().all(inside) {
            let cause = format!("a corner of {tag} is not finite or far outside of any image");
            return Err((cause, "write pixels"));
        }
        if let Some(sigma) = self.sigma_px
            && !(sigma > 0.0 && sigma <= MAX_PIXEL)
        {
            let cause = format!("sigma_px = {sigma} of {tag} is not above 0 and finite");
            return Err((cause, "write pixels or leave it out"));
        }
        match self.corner_covariance {
            Some(stated) if !stated.into_iter().all(is_covariance) => {
                let cause = format!("corner_covariance of {tag} is no covariance");
                Err((
                    cause,
                    "write xx, xy, yy of each corner in square pixels, xx and yy above 0, or leave it out",
                ))
            }
            _ => self.check_pairs(&tag),
        }
    }

    fn check_pairs(&self, tag: &str) -> Result<(), (String, &'static str)> {
        let Some(crosses) = self.corner_cross_covariance else {
            return Ok(());
        };
        let Some(own) = self.corner_covariance else {
            let cause = format!("{tag} has corner_cross_covariance, but no corner_covariance");
            return Err((cause, "write both, or leave it out"));
        };
        let Some([a, b]) = wrong_corner_pair(&own, &crosses) else {
            return Ok(());
        };
        let cause = format!("corner_cross_covariance of {tag} is none of the corners {a} and {b}");
        Err((
            cause,
            "write xx, xy, yx, yy of the corners 0 and 1, 0 and 2, 0 and 3, 1 and 2, 1 and 3, 2 \
             and 3 in square pixels, no product above that of the corners' own variances, or leave it out",
        ))
    }
}

/// Finite and positive, up to what rounding to single precision does to a narrow one; written so that NaN is none.
fn is_covariance([xx, xy, yy]: [f32; 3]) -> bool {
    let [xx, xy, yy] = [xx, xy, yy].map(f64::from);
    let is_variance = |v: f64| v > 0.0 && v <= f64::from(MAX_PIXEL).powi(2);
    is_variance(xx) && is_variance(yy) && xy * xy <= xx * yy * (1.0 + 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const GOOD: &str = r#"{"t_ns":5,"detections":[{"family":"tag36h11","id":3,"hamming":0,"margin":70.5,"corners":[[1.1,2],[3,2],[3,4],[1,4]]}]}"#;

    const OWN: &str = "\"corner_covariance\":[[1,0,1],[1,0,1],[1,0,1],[1,0,1]]";

    /// Corners 1 and 3 share so much in x, others half of their own.
    fn crossing(shared: &str) -> String {
        let half = "[0.5,0,0,-0.5]";
        format!("\"corner_cross_covariance\":[{half},{half},{half},{half},[{shared},0,0,0],{half}]")
    }

    fn read(text: &str) -> Result<Vec<DetectionsLine>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("detections.jsonl");
        fs::write(&path, text).unwrap();
        let root = format!("{}/", folder.path().display());
        DetectionsLine::read_file(&path).map_err(|error| error.to_string().replace(&root, ""))
    }

    #[test]
    fn keys_of_other_detectors_are_ignored_and_optional_ones_may_lack() {
        let lines = read(GOOD).unwrap();
        assert_eq!(lines[0].arrival_ns, None);
        let tag = lines[0].detections[0];
        assert_eq!(
            (tag.id, tag.corners[0], tag.sigma_px),
            (3, [1.1, 2.0], None)
        );
        assert_eq!(tag.corner_covariance, None);
    }

    #[test]
    fn corners_in_another_order_or_unit_are_refused() {
        let lines = |corners: &str| -> String {
            let line = |k: u64| {
                format!(
                    r#"{{"t_ns":{k},"detections":[{{"family":"tag36h11","id":3,"corners":{corners}}}]}}"#
                ) + "\n"
            };
            (0..5).map(|k| line(1_000_000_000 * (k + 1))).collect()
        };
        assert!(read(&lines("[[10,20],[50,20],[50,60],[10,60]]")).is_ok());
        let error = read(&lines("[[10,60],[50,60],[50,20],[10,20]]")).unwrap_err();
        assert!(
            error.contains("run counterclockwise in the image; write those of the upright tag"),
            "{error}"
        );
        let error = read(&lines("[[0.1,0.2],[0.2,0.2],[0.2,0.4],[0.1,0.4]]")).unwrap_err();
        assert!(error.contains("smaller than a pixel"), "{error}");
        // One such among others is an error of a detector.
        let one = lines("[[10,60],[50,60],[50,20],[10,20]]");
        let first = one
            .lines()
            .next()
            .unwrap()
            .replace(":1000000000,", ":1000,");
        assert!(
            read(&format!(
                "{first}\n{}",
                lines("[[10,20],[50,20],[50,60],[10,60]]")
            ))
            .is_ok()
        );
    }

    #[test]
    fn a_line_comes_back_exactly() {
        let odd = f32::from_bits(0x43f1_2345);
        let line = DetectionsLine {
            t_ns: 1_800_000_000_123_456_789,
            arrival_ns: Some(1_800_000_000_133_456_789),
            detections: vec![DetectedTag {
                family: Family::Tag36h11,
                id: 586,
                corners: [
                    [odd, 0.1],
                    [1e-7, 479.333_34],
                    [-0.5, 12.0],
                    [639.499_94, 3.0],
                ],
                sigma_px: Some(0.037_251_3),
                corner_covariance: Some([
                    [odd, -1e-9, 3e-7],
                    [0.1; 3],
                    [1.0, 0.0, 2.0],
                    [1e-12; 3],
                ]),
                corner_cross_covariance: Some([[1e-13, -1e-13, odd * 1e-20, 0.0]; 6]),
            }],
        };
        let text = serde_json::to_string(&line).unwrap();
        assert_eq!(read(&text).unwrap(), [line]);
    }

    #[test]
    fn double_precision_digits_give_the_same_corners() {
        let shortest = r#"{"t_ns":5,"detections":[{"family":"tag36h11","id":3,"corners":[[123.456,0.1],[3,2],[3,4],[1,4]]}]}"#;
        let widened = shortest
            .replace("123.456", &f64::from(123.456_f32).to_string())
            .replace("0.1]", &format!("{}]", f64::from(0.1_f32)));
        assert_ne!(shortest, widened);
        assert_eq!(read(shortest), read(&widened));
    }

    #[test]
    fn wrong_lines_are_refused_with_their_number() {
        let line = |t: u64| GOOD.replace("\"t_ns\":5", &format!("\"t_ns\":{t}"));
        for (text, expected) in [
            (
                format!("{GOOD}\n{GOOD}\n"),
                "detections.jsonl:2: the timestamp 5 is there already, on line 1",
            ),
            (
                format!("{}\n{}\n", line(7), line(6)),
                "detections.jsonl:2: the timestamp 6 is earlier than 7",
            ),
            (
                format!("{GOOD}\n{{\"t_ns\":6\n"),
                "detections.jsonl:2: EOF while parsing",
            ),
            (
                GOOD.replace("1.1", "NaN"),
                "detections.jsonl:1: expected value at column",
            ),
            (
                GOOD.replace("1.1", "1e300"),
                "detections.jsonl:1: number out of range at column",
            ),
            (
                GOOD.replace("1.1", "1e6"),
                "detections.jsonl:1: a corner of tag36h11:3 is not finite or far",
            ),
            (
                GOOD.replace(",[1,4]", ""),
                "detections.jsonl:1: invalid length 3",
            ),
            (
                GOOD.replace("[1,4]]", "[1,4],[1,4]]"),
                "detections.jsonl:1: ",
            ),
            (
                GOOD.replace("tag36h11", "tag36h1"),
                "detections.jsonl:1: unknown variant `tag36h1`",
            ),
            (
                GOOD.replace("\"hamming\":0", "\"sigma_px\":0"),
                "detections.jsonl:1: sigma_px = 0 of tag36h11:3",
            ),
            (
                GOOD.replace(
                    "\"hamming\":0",
                    "\"corner_covariance\":[[1,0,1],[1,0,1],[1,2,1],[1,0,1]]",
                ),
                "detections.jsonl:1: corner_covariance of tag36h11:3 is no covariance",
            ),
            (
                GOOD.replace("\"hamming\":0", &format!("{OWN},{}", crossing("1.5"))),
                "detections.jsonl:1: corner_cross_covariance of tag36h11:3 is none of the corners 1 and 3",
            ),
            (
                GOOD.replace("\"hamming\":0", &crossing("0.5")),
                "detections.jsonl:1: tag36h11:3 has corner_cross_covariance, but no corner_covariance",
            ),
            (
                GOOD.replace("\"t_ns\":5,", ""),
                "detections.jsonl:1: missing field `t_ns`",
            ),
        ] {
            let message = read(&text).unwrap_err();
            assert!(message.starts_with(expected), "{text}: {message}");
        }
    }
}
