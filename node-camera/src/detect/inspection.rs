//! A look at the detector at work, a few times a second while somebody wants to know: how long its stages take, and
//! what it turns down for which cause.

use std::time::{Duration, Instant};

use sextant_apriltag::{Observer, Rejection, Report, Stage};
use sextant_iceoryx_images::ImageHeader;
use sextant_proto::{
    DetectionReport, RejectedCandidate, RejectionCause, RejectionCounts, StageTimes, limits,
};
use sextant_site_model::CameraId;

/// Between two looks: about as often as pictures are made, which this is drawn over.
const PERIOD: Duration = Duration::from_millis(200);
/// Candidates that are kept in mind of one image; a picture full of gravel has more.
const MAX_CANDIDATES: usize = 4096;

type Quad = [[f32; 2]; 4];

/// Observes single images.
#[derive(Debug)]
pub(super) struct Inspection {
    pub(super) due: Instant,
    stage_ended: Instant,
    /// Of each [`Stage`], in order.
    spent: [Duration; Stage::ALL.len()],
    rejected: Vec<(Rejection, Quad)>,
}

impl Inspection {
    /// Starts with the next image due.
    pub(super) fn new() -> Self {
        let now = Instant::now();
        Self {
            due: now,
            stage_ended: now,
            spent: [Duration::ZERO; Stage::ALL.len()],
            rejected: Vec::new(),
        }
    }

    /// Whether the next image is due for inspection; only the first question of each period is answered with yes.
    pub(super) fn is_due(&mut self) -> bool {
        let now = Instant::now();
        let is_due = now >= self.due;
        if is_due {
            self.due = now + PERIOD;
        }
        is_due
    }

    /// An image is about to be searched.
    pub(super) fn begin(&mut self) {
        self.stage_ended = Instant::now();
        self.spent = [Duration::ZERO; Stage::ALL.len()];
        self.rejected.clear();
    }

    /// What was seen of the image since [`Self::begin`]; `searched` is the share of it that was.
    pub(super) fn report(
        &mut self,
        camera: &CameraId,
        header: &ImageHeader,
        report: &Report,
        searched: f32,
    ) -> DetectionReport {
        DetectionReport {
            camera: camera.clone(),
            sequence: header.sequence,
            capture_ns: header.capture_ns,
            resolution: [header.width, header.height],
            searched: searched.clamp(0.0, 1.0),
            stage_ms: self.stage_times(),
            noise_sigma: report.noise_sigma,
            contrast_gate: report.contrast_gate,
            components: report.components,
            candidates: report.candidates,
            dropped: report.dropped,
            tags: report.detections,
            rejected: counts(report),
            examples: self.examples(),
        }
    }

    fn stage_times(&self) -> StageTimes {
        let ms = |stage: Stage| (self.spent[stage as usize].as_secs_f64() * 1e3) as f32;
        StageTimes {
            tiles: ms(Stage::Tiles),
            threshold: ms(Stage::Threshold),
            components: ms(Stage::Components),
            quads: ms(Stage::Quads),
            decode: ms(Stage::Decode),
            refine: ms(Stage::Refine),
        }
    }

    /// Those that came furthest, of these the largest: what looks like a tag to a person. Each once, though the
    /// detector may have looked at it twice.
    fn examples(&mut self) -> Vec<RejectedCandidate> {
        self.rejected.sort_by(|(a, quad), (b, other)| {
            let by_size = area(other).total_cmp(&area(quad));
            b.cmp(a).then(by_size)
        });
        let mut examples: Vec<RejectedCandidate> = Vec::new();
        for &(reason, corners) in &self.rejected {
            if examples.len() == limits::MAX_REJECTED {
                break;
            }
            if !examples.iter().any(|one| is_beside(&one.corners, &corners)) {
                let cause = cause_of(reason);
                examples.push(RejectedCandidate { cause, corners });
            }
        }
        examples
    }
}

impl Observer for Inspection {
    fn stage_ended(&mut self, stage: Stage) {
        let now = Instant::now();
        self.spent[stage as usize] += now - self.stage_ended;
        self.stage_ended = now;
    }

    fn rejected(&mut self, reason: Rejection, corners: &Quad) {
        if self.rejected.len() < MAX_CANDIDATES {
            self.rejected.push((reason, *corners));
        }
    }
}

fn cause_of(reason: Rejection) -> RejectionCause {
    match reason {
        Rejection::NotAQuad => RejectionCause::NotAQuad,
        Rejection::Shape => RejectionCause::Shape,
        Rejection::FaintBorder => RejectionCause::FaintBorder,
        Rejection::NoCode => RejectionCause::NoCode,
        Rejection::SmallMargin => RejectionCause::SmallMargin,
    }
}

fn counts(report: &Report) -> RejectionCounts {
    RejectionCounts {
        not_a_quad: report.rejected_for(Rejection::NotAQuad),
        shape: report.rejected_for(Rejection::Shape),
        faint_border: report.rejected_for(Rejection::FaintBorder),
        no_code: report.rejected_for(Rejection::NoCode),
        small_margin: report.rejected_for(Rejection::SmallMargin),
    }
}

/// Whether two outlines differ by less than a pixel.
fn is_beside(a: &Quad, b: &Quad) -> bool {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.into_iter().all(|(a, b)| (a - b).abs() < 1.0)
}

/// Twice the area between the diagonals, pixels².
fn area([a, b, c, d]: &Quad) -> f32 {
    ((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_apriltag::{Detector, Image, Options};

    const SIZE: usize = 160;

    /// Black squares without a code on white, at (left, top) with an edge each.
    fn squares(places: &[([usize; 2], usize)]) -> Vec<u8> {
        let mut pixels = vec![230; SIZE * SIZE];
        for &([left, top], edge) in places {
            for row in top..top + edge {
                pixels[row * SIZE + left..][..edge].fill(20);
            }
        }
        pixels
    }

    fn inspected(pixels: &[u8]) -> DetectionReport {
        let image = Image::new(pixels, SIZE, SIZE, SIZE).unwrap();
        let mut detector = Detector::new(Options::default()).unwrap();
        let mut inspection = Inspection::new();
        inspection.begin();
        detector.detect_observed(&image, &mut inspection);
        let header = ImageHeader {
            width: SIZE as u16,
            height: SIZE as u16,
            ..ImageHeader::default()
        };
        let camera = CameraId::new("north").unwrap();
        inspection.report(&camera, &header, detector.report(), 1.0)
    }

    #[test]
    fn a_square_without_a_code_is_named_with_its_place() {
        let report = inspected(&squares(&[([30, 40], 50)]));
        assert_eq!(report.tags, 0);
        assert!(report.rejected.no_code > 0, "{report:?}");
        let [example] = report.examples.as_slice() else {
            panic!("{report:?}");
        };
        assert_eq!(example.cause, RejectionCause::NoCode);
        let [x, y] = [0, 1].map(|axis| example.corners.iter().map(|c| c[axis]).sum::<f32>() / 4.0);
        assert!((x - 54.5).abs() < 1.0 && (y - 64.5).abs() < 1.0, "{x} {y}");
    }

    #[test]
    fn the_largest_come_first() {
        let report = inspected(&squares(&[([5, 5], 20), ([40, 40], 60), ([110, 5], 30)]));
        let areas: Vec<f32> = report.examples.iter().map(|e| area(&e.corners)).collect();
        assert_eq!(areas.len(), 3, "{report:?}");
        assert!(areas.is_sorted_by(|a, b| a >= b), "{areas:?}");
    }

    #[test]
    fn a_report_keeps_its_contract_with_more_rejected_than_it_takes() {
        let mut inspection = Inspection::new();
        for n in 0..100 {
            let (x, edge) = (n as f32, 10.0 + n as f32);
            let corners = [[x, 0.0], [x + edge, 0.0], [x + edge, edge], [x, edge]];
            inspection.rejected(Rejection::ALL[n % 5], &corners);
        }
        let header = ImageHeader {
            width: 640,
            height: 480,
            ..ImageHeader::default()
        };
        let camera = CameraId::new("north").unwrap();
        let report = inspection.report(&camera, &header, &Report::default(), 1.0);
        assert_eq!(report.examples.len(), limits::MAX_REJECTED);
        assert_eq!(report.examples[0].cause, RejectionCause::SmallMargin);
        sextant_proto::encode(&report).unwrap();
    }
}
