//! How far an image is from what a track and stated errors let expect, all its views of a link taken together: one view after the
//! other hides what they share, for each is held against a pose that the others have pulled.
//!
//! Of the views' N and g (see [`crate::measurement::pose_innovation`]) the sums count. What a common displacement explains of the sum of squares is
//! gᵀ N⁻¹ g. Of that, g is expected to be N B e for the stated errors e, and its covariance is N + N P N, with the views among what P
//! knows N - N P N, besides what is unknown of e.

use nalgebra::{Cholesky, Const, Matrix6, Vector6};

use crate::measurement::biases::BiasJacobian;
use crate::measurement::pose_innovation::ViewResidual;
use crate::tracker::finalised_views::FinalisedView;

/// Share of N that is left at least where a pose follows views closely, so that there is an inverse.
const LEFT: f64 = 1e-3;
/// What half a sum of squares of noise exceeds its mean by, where it does, over the root of its degrees of freedom: 1 / 2 sqrt(pi).
const BY_NOISE: f64 = 0.282;

/// What views of a link in an image show together.
#[derive(Debug)]
pub(crate) struct PredictiveCost {
    /// Half the squared sigmas, beyond as many as are usual, of a displacement that the views share, and of what no displacement of all
    /// explains.
    pub shared: f64,
    pub apart: f64,
    /// By how much less sure the pose was than the views are: half the logarithm of by how much more likely they would be, were it known.
    pub vague: f64,
    /// What noise alone makes of `shared` and `apart` on the average.
    pub usual: f64,
}

/// Whether two views next to each other are of one link in one image.
pub(crate) fn are_of_one_link(one: &FinalisedView, other: &FinalisedView) -> bool {
    let link = |view: &FinalisedView| {
        let residual = view.residual.as_ref()?;
        Some((residual.took_part, residual.innovation.world_from_link))
    };
    one.camera_index == other.camera_index && link(one).is_some() && link(one) == link(other)
}

impl PredictiveCost {
    /// Of views of one link in one image; `None` where they say nothing.
    pub fn of(views: &[FinalisedView]) -> Option<Self> {
        let residuals = views.iter().filter_map(|view| view.residual.as_ref());
        let sum = Sum::of(residuals)?;
        let n = sum.information;
        let by_pose = n * sum.covariance * n;
        let covariance = if sum.took_part {
            n * (1.0 + LEFT) - by_pose
        } else {
            n + by_pose
        };
        let biases: Matrix6<f64> = sum.displacing.iter().map(BiasJacobian::covariance).sum();
        let known = Cholesky::<f64, Const<6>>::new(n)?;
        let all = Cholesky::<f64, Const<6>>::new(covariance + biases)?;
        let explained = sum.gradient.dot(&known.solve(&sum.gradient));
        let freedom = 8.0 * sum.views - 6.0;
        let shared = beyond(sum.gradient.dot(&all.solve(&sum.gradient)), 6.0);
        let apart = beyond(sum.square - explained, freedom);
        let usual = BY_NOISE * (6.0_f64.sqrt() + freedom.sqrt());
        let spread =
            Cholesky::<f64, Const<6>>::new(covariance)?.ln_determinant() - known.ln_determinant();
        let vague = 0.5 * if sum.took_part { -spread } else { spread };
        (shared + apart + vague).is_finite().then_some(Self {
            shared,
            apart,
            vague,
            usual,
        })
    }
}

fn beyond(square: f64, usual: f64) -> f64 {
    (0.5 * (square - usual)).max(0.0)
}

/// What such views say together.
struct Sum {
    views: f64,
    information: Matrix6<f64>,
    gradient: Vector6<f64>,
    square: f64,
    covariance: Matrix6<f64>,
    took_part: bool,
    /// What lasting errors do to the gradient.
    displacing: Vec<BiasJacobian>,
}

impl Sum {
    fn of<'a>(mut residuals: impl Iterator<Item = &'a ViewResidual>) -> Option<Self> {
        let first = residuals.next()?;
        let mut sum = Self {
            views: 0.0,
            information: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            square: 0.0,
            covariance: first.covariance,
            took_part: first.took_part,
            displacing: Vec::new(),
        };
        std::iter::once(first)
            .chain(residuals)
            .for_each(|residual| sum.add(residual));
        Some(sum)
    }

    fn add(&mut self, residual: &ViewResidual) {
        let mut view = residual.innovation;
        // The pose knows of views that take part as they were weighed; others count in full.
        if !self.took_part {
            view.scale(view.weight.recip());
        }
        self.views += 1.0;
        self.information += view.information;
        self.gradient += view.gradient;
        self.square += view.square;
        for one in &residual.displacing {
            let by = view.information * one.by;
            let mut known = self.displacing.iter_mut();
            match known.find(|own| own.source == one.source) {
                Some(own) => own.by += by,
                None => self.displacing.push(BiasJacobian { by, ..*one }),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TagId;
    use crate::measurement::pose_innovation::PoseInnovation;
    use sextant_tag_families::Family;

    const INFORMATION: f64 = 1e6;

    /// A view of a link that seems to be displaced by so much along x.
    fn view(id: u32, metres: f64) -> FinalisedView {
        let information = Matrix6::identity() * INFORMATION;
        let displaced = Vector6::x() * metres;
        let mut innovation = PoseInnovation::of_displaced(information, &displaced);
        innovation.square += 8.0;
        FinalisedView {
            camera_index: 0,
            tag: TagId {
                family: Family::Tag36h11,
                id,
            },
            agreed: false,
            hit: false,
            ray: None,
            elsewhere: None,
            residual: Some(ViewResidual {
                innovation,
                covariance: Matrix6::identity() * 1e-9,
                took_part: false,
                displacing: Vec::new(),
            }),
        }
    }

    /// Of a track that knows six numbers with `variance` apart from the view, or with it.
    fn vague(variance: f64, took_part: bool) -> f64 {
        let mut view = view(0, 0.0);
        let residual = view.residual.as_mut().expect("it has one");
        residual.covariance = Matrix6::identity() * variance;
        residual.took_part = took_part;
        let misfit = PredictiveCost::of(&[view]);
        misfit.expect("it says something").vague
    }

    #[test]
    fn a_track_is_as_vague_before_a_view_as_it_was_by_what_is_left_after_it() {
        for times in [0.1, 1.0, 10.0] {
            let before = times / INFORMATION;
            let after = (INFORMATION + before.recip()).recip();
            let expected = 3.0 * (1.0 + times).ln();
            assert!((vague(before, false) - expected).abs() < 1e-9, "{times}");
            assert!((vague(after, true) - expected).abs() < 0.05, "{times}");
        }
    }

    #[test]
    fn what_all_views_share_is_told_from_what_they_do_not() {
        let of = |by: [f64; 2]| {
            let views = [view(0, by[0]), view(1, by[1])];
            assert!(are_of_one_link(&views[0], &views[1]));
            let misfit = PredictiveCost::of(&views).expect("they say something");
            [misfit.shared, misfit.apart]
        };
        assert_eq!(of([0.0, 0.0]), [0.0, 3.0]);
        let [shared, apart] = of([0.02, 0.02]);
        assert!(shared > 300.0 && (apart - 3.0).abs() < 1e-6);
        let [shared, apart] = of([0.02, -0.02]);
        assert!(shared == 0.0 && apart > 300.0);
    }
}
