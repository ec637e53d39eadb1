//! A lens calibration session: handles images, reports coverage and hints, and solves for the lens.

use super::board::Board;
use super::calibration::LensCalibration;
use super::choice::choose;
use super::coverage::{COLUMNS, Coverage, ROWS, lean};
use super::fit::{Fit, LEAST_TAGS};
use super::hint::{Hint, NEAR, TILTS, VIEWS, covered};
use super::judgement::verdict_of;
use super::maps::LensMaps;
use super::poses::board_pose;
use super::refusal::LensRefusal;
use super::start::start;
use super::view::{BoardView, SortedView};
use sextant_geometry::{Intrinsics, Lens, LensModel, Pose};
use sextant_site_model::{ImageObservation, ObjectModel, TagId};
use std::collections::{BTreeMap, BTreeSet};

/// Least number of views for any lens.
const LEAST_VIEWS: usize = 5;
/// Most views; more only cost time.
const MOST_VIEWS: usize = 300;
/// A new view differs from all others by this share of the image width, or by [`NEW_LEAN`], or by [`NEW_SIZE`].
const NEW_PLACE: f64 = 0.06;
/// Difference of the tilt, as a tangent.
const NEW_LEAN: f64 = 0.15;
/// Relative difference of the size.
const NEW_SIZE: f64 = 0.2;
/// Assumed focal length for hints before a solution, as a share of the image width.
const USUAL_FOCAL: f64 = 0.9;
/// Largest relative standard deviation of the focal length of a result.
const UNDETERMINED: f64 = 0.01;
/// Below this tilt, radians, of all but a tenth of the views, they are frontal.
const FRONTAL: f64 = 0.21;
/// Largest share of outlier tags of a result.
const MOST_WRONG: f64 = 0.6;
/// Relative difference of the size of the squares from which they contradict the file.
const SIZES_DIFFER: f64 = 0.004;

/// Which images become views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Selection {
    /// All that show enough of the board: for a selected set of images.
    #[default]
    All,
    /// Those that differ from the earlier views: for a stream.
    New,
}

/// Options of a lens calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LensOptions {
    /// Width and height of the images, pixels.
    pub resolution: [u32; 2],
    /// The lens model; `None` selects it by cross-validation.
    pub model: Option<LensModel>,
    /// Which images become views.
    pub selection: Selection,
}

/// Result of handling an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewOutcome {
    /// It was added to the views.
    Added,
    /// It adds nothing to the views.
    Duplicate,
    /// It shows fewer than two tags of the board.
    TooFewTags,
}

/// Progress of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct LensProgress {
    /// Number of images received.
    pub images: usize,
    /// Number of views.
    pub views: usize,
    /// Corners in each cell of the image, row by row from the top left.
    pub coverage: [[u32; COLUMNS]; ROWS],
    /// Views in which the board's left, right, upper and lower side was turned away.
    pub tilted: [u32; 4],
    /// Views in which the board fills the image.
    pub near: u32,
    /// Progress from 0 to 1; 1 is enough.
    pub fraction: f64,
    /// Instruction for the next view.
    pub hint: Hint,
}

/// Where and how a view shows the board, to tell views apart.
#[derive(Clone, Debug)]
struct ViewPlace {
    centre: nalgebra::Point2<f64>,
    /// Extent in the image, px.
    spread: f64,
    /// Tilt to the right and down.
    lean: [f64; 2],
}

/// A lens calibration session.
#[derive(Clone, Debug)]
pub struct LensSession {
    board: Board,
    options: LensOptions,
    views: Vec<BoardView>,
    places: Vec<ViewPlace>,
    coverage: Coverage,
    images: usize,
    alike: usize,
    without_board: usize,
    foreign: BTreeSet<TagId>,
    twice: BTreeSet<TagId>,
}

impl LensSession {
    /// A session with a board.
    ///
    /// # Errors
    /// A board without tag poses.
    pub fn new(board: &ObjectModel, options: LensOptions) -> Result<Self, LensRefusal> {
        Ok(Self {
            board: Board::from_object(board)?,
            options,
            views: Vec::new(),
            places: Vec::new(),
            coverage: Coverage::default(),
            images: 0,
            alike: 0,
            without_board: 0,
            foreign: BTreeSet::new(),
            twice: BTreeSet::new(),
        })
    }

    /// Width and height of the images, px.
    pub fn resolution(&self) -> [u32; 2] {
        self.options.resolution
    }

    /// Handles an image.
    ///
    /// # Errors
    /// Corners outside the resolution.
    pub fn handle(&mut self, image: &ImageObservation) -> Result<ViewOutcome, LensRefusal> {
        let sorted = SortedView::from_image(&self.board, self.options.resolution, image)?;
        self.images += 1;
        self.foreign.extend(sorted.foreign);
        self.twice.extend(sorted.twice);
        let view = sorted.view;
        if view.tags.len() < LEAST_TAGS {
            self.without_board += 1;
            return Ok(ViewOutcome::TooFewTags);
        }
        let pose = self.guess(&view);
        let (centre, spread) = view.extent();
        let place = ViewPlace {
            centre,
            spread,
            lean: pose.map_or([0.0; 2], |pose| lean(&pose)),
        };
        let wanted = self.options.selection == Selection::All || self.is_new(&place);
        if !wanted || self.views.len() >= MOST_VIEWS {
            self.alike += 1;
            return Ok(ViewOutcome::Duplicate);
        }
        self.coverage
            .take(self.options.resolution, &view, pose.as_ref());
        self.views.push(view);
        self.places.push(place);
        Ok(ViewOutcome::Added)
    }

    /// Approximate pose of the board, assuming a usual lens.
    fn guess(&self, view: &BoardView) -> Option<Pose> {
        let [width, height] = self.options.resolution.map(f64::from);
        let focal = USUAL_FOCAL * width;
        let lens = Lens::pinhole(Intrinsics {
            fx: focal,
            fy: focal,
            cx: (width - 1.0) / 2.0,
            cy: (height - 1.0) / 2.0,
        });
        let (pose, _) = board_pose(&self.board, view, &lens.ok()?, 0.05 * width)?;
        Some(pose)
    }

    fn is_new(&self, place: &ViewPlace) -> bool {
        let width = f64::from(self.options.resolution[0]);
        self.places.iter().all(|other| {
            let lean = [0, 1].map(|axis| place.lean[axis] - other.lean[axis]);
            (place.centre - other.centre).norm() > NEW_PLACE * width
                || lean[0].hypot(lean[1]) > NEW_LEAN
                || (place.spread / other.spread).ln().abs() > NEW_SIZE.ln_1p()
        })
    }

    /// Progress and the next instruction.
    pub fn progress(&self) -> LensProgress {
        let tilts = self
            .coverage
            .tilted
            .iter()
            .map(|&n| n.min(TILTS))
            .sum::<u32>();
        let parts = [
            covered(&self.coverage),
            f64::from(tilts) / f64::from(4 * TILTS),
            (f64::from(self.coverage.near) / f64::from(NEAR)).min(1.0),
            (f64::from(self.coverage.views) / f64::from(VIEWS)).min(1.0),
        ];
        let hint = Hint::for_coverage(&self.coverage);
        let fraction = match hint {
            Hint::Enough => 1.0,
            _ => parts.iter().sum::<f64>() / parts.len() as f64,
        };
        LensProgress {
            images: self.images,
            views: self.views.len(),
            coverage: self.coverage.corners,
            tilted: self.coverage.tilted,
            near: self.coverage.near,
            fraction,
            hint,
        }
    }

    /// Solves for the lens.
    ///
    /// # Errors
    /// The reason why these images do not determine it.
    pub fn solve(&self) -> Result<LensCalibration, LensRefusal> {
        self.check_views()?;
        let resolution = self.options.resolution;
        let width = f64::from(resolution[0]);
        let first = start(&self.board, &self.views, resolution)?;
        let models = match &self.options.model {
            Some(model) => std::slice::from_ref(model),
            None => &LensModel::ALL[..],
        };
        let chosen = choose(&self.board, &self.views, &first, models, width);
        let (fit, scores) = chosen.ok_or(LensRefusal::Unexplained {
            wrong_percent: 100.0,
        })?;
        let wrong = self.wrong_tags(&fit);
        self.check_fit(&fit, wrong.values().map(|(wrong, _)| wrong).sum())?;
        let maps = LensMaps::from_fit(&fit, resolution);
        let (wrong_tags, all) = wrong
            .values()
            .fold((0, 0), |sum, n| (sum.0 + n.0, sum.1 + n.1));
        let covariance = fit.covariance();
        Ok(LensCalibration {
            lens: fit.adjustment.lens,
            resolution,
            sigmas: covariance
                .diagonal()
                .iter()
                .map(|v| v.max(0.0).sqrt())
                .collect(),
            covariance,
            rms_px: fit.adjustment.solution.rms_px,
            noise_px: fit.adjustment.solution.rms_px / std::f64::consts::SQRT_2,
            images: self.images,
            views: fit.adjustment.view_of.len(),
            alike: self.alike,
            without_board: self.without_board,
            tags: all - wrong_tags,
            wrong_tags,
            suspicious: self.suspicious(&wrong),
            scores,
            verdict: verdict_of(&maps, wrong_tags as f64 / all.max(1) as f64),
            maps,
        })
    }

    fn check_views(&self) -> Result<(), LensRefusal> {
        let (views, images) = (self.views.len(), self.images);
        if views == 0 {
            let foreign = self.foreign.iter().copied().collect();
            return Err(LensRefusal::NoBoard { images, foreign });
        }
        if views < LEAST_VIEWS {
            let needed = LEAST_VIEWS;
            return Err(LensRefusal::TooFew {
                views,
                images,
                needed,
            });
        }
        Ok(())
    }

    /// Number of exclusions and of occurrences of each tag of the board.
    fn wrong_tags(&self, fit: &Fit) -> BTreeMap<TagId, (usize, usize)> {
        let mut counts = BTreeMap::new();
        for (view, pose) in self.views.iter().zip(&fit.adjustment.poses) {
            for (at, seen) in view.tags.iter().enumerate() {
                let fitted = pose.as_ref().is_some_and(|(_, tags)| tags.contains(&at));
                let count = counts
                    .entry(self.board.tags[seen.tag].tag)
                    .or_insert((0, 0));
                count.0 += usize::from(!fitted);
                count.1 += 1;
            }
        }
        counts
    }

    fn suspicious(&self, wrong: &BTreeMap<TagId, (usize, usize)>) -> Vec<TagId> {
        // Squares of a chessboard seen in part have other ids than they should.
        let often = wrong.iter().filter(|(tag, (wrong, all))| {
            2 * wrong > *all && *all > 2 && tag.family.data().has_codes()
        });
        let mut tags: BTreeSet<TagId> = often.map(|(tag, _)| *tag).collect();
        tags.extend(&self.twice);
        tags.into_iter().collect()
    }

    fn check_fit(&self, fit: &Fit, wrong: usize) -> Result<(), LensRefusal> {
        let all: usize = self.views.iter().map(|view| view.tags.len()).sum();
        let wrong_part = wrong as f64 / all.max(1) as f64;
        if wrong_part > MOST_WRONG {
            let wrong_percent = 100.0 * wrong_part;
            return Err(LensRefusal::Unexplained { wrong_percent });
        }
        let uncertainty = fit.focal_uncertainty();
        // The comparison also refuses NaN.
        let determined = uncertainty <= UNDETERMINED;
        if !determined {
            return Err(self.undetermined(fit, 100.0 * uncertainty.min(1e3)));
        }
        let growth = fit.growth(&self.board, &self.views);
        if let Some((growth, sigma)) = growth
            && growth.abs() > SIZES_DIFFER
            && growth.abs() > 8.0 * sigma
        {
            let percent = 100.0 * growth;
            return Err(LensRefusal::Sizes { percent });
        }
        Ok(())
    }

    fn undetermined(&self, fit: &Fit, sigma_percent: f64) -> LensRefusal {
        let mut tilts = fit.tilts();
        tilts.sort_by(f64::total_cmp);
        let tilt = tilts.get(tilts.len() * 9 / 10).copied().unwrap_or(0.0);
        if tilt < FRONTAL {
            let tilt_deg = tilt.to_degrees();
            return LensRefusal::OnlyFrontal {
                tilt_deg,
                sigma_percent,
            };
        }
        LensRefusal::Undetermined { sigma_percent }
    }
}
