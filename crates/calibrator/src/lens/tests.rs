//! Boards held before lenses that are known, with noise and with every kind of flaw.

mod board_walk;
mod difference;

use super::*;
use crate::verdict::Grade;
use board_walk::{BoardWalk, board, fisheye, ordinary};
use difference::mean_difference;
use nalgebra::Matrix2;
use sextant_geometry::{Lens, LensModel};
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_tag_families::Family;

fn options(model: Option<LensModel>) -> LensOptions {
    LensOptions {
        resolution: [640, 480],
        model,
        selection: Selection::All,
    }
}

fn solved(walk: &BoardWalk, model: Option<LensModel>) -> Result<LensCalibration, LensRefusal> {
    let mut session = LensSession::new(&board(1.0, 1.0), options(model))?;
    for image in walk.images() {
        session.handle(&image)?;
    }
    session.solve()
}

#[test]
fn thirty_images_give_the_lens() {
    for seed in 20..22 {
        let truth = ordinary();
        let found = solved(&BoardWalk::new(truth, seed), None).unwrap();
        let (t, f) = (truth.intrinsics(), found.lens.intrinsics());
        assert_eq!(
            found.lens.model(),
            LensModel::BrownConrady,
            "{:?}",
            found.scores
        );
        assert!(
            (f.fx / t.fx - 1.0).abs() < 5e-4 && (f.fy / t.fy - 1.0).abs() < 5e-4,
            "{f:?}"
        );
        assert!((f.cx - t.cx).hypot(f.cy - t.cy) < 0.5, "{f:?}");
        assert!(mean_difference(&truth, &found.lens) < 0.1);
        assert!((found.noise_px - 0.1).abs() < 0.01, "{}", found.noise_px);
        assert_eq!(
            (found.verdict.grade, found.wrong_tags),
            (Grade::Good, 0),
            "{}",
            found.verdict
        );
    }
}

#[test]
fn a_fisheye_is_recognised_and_found() {
    let truth = fisheye();
    let found = solved(&BoardWalk::new(truth, 5), None).unwrap();
    assert_eq!(
        found.lens.model(),
        LensModel::KannalaBrandt,
        "{:?}",
        found.scores
    );
    assert!(mean_difference(&truth, &found.lens) < 0.15);
}

#[test]
fn a_lens_without_distortion_is_a_pinhole() {
    let truth = Lens::pinhole(ordinary().intrinsics()).unwrap();
    let found = solved(&BoardWalk::new(truth, 6), None).unwrap();
    assert_eq!(found.lens.model(), LensModel::Pinhole, "{:?}", found.scores);
    assert!(mean_difference(&truth, &found.lens) < 0.05);
}

/// Errors of every lens parameter in units of their reported deviations, over calibrations with 15 images each.
fn normalised_errors(seeds: std::ops::Range<u64>) -> Vec<Vec<f64>> {
    let truth = ordinary();
    let of_seed = |seed| {
        let mut walk = BoardWalk::new(truth, seed);
        walk.images = 15;
        let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
        let errors = truth.parameters().into_iter().zip(found.lens.parameters());
        let errors = errors.zip(&found.sigmas);
        errors
            .map(|((truth, found), sigma)| (found - truth) / sigma)
            .collect()
    };
    seeds.map(of_seed).collect()
}

fn part_within_two(errors: &[Vec<f64>]) -> f64 {
    let all = errors.iter().flatten();
    all.clone().filter(|e| e.abs() < 2.0).count() as f64 / all.count() as f64
}

/// Of many calibrations 90 to 99 % of the errors lie within two deviations (`benches/honesty.rs`); a few can only tell
/// gross dishonesty.
#[test]
fn stated_deviations_are_honest() {
    let part = part_within_two(&normalised_errors(100..112));
    assert!((0.85..=1.0).contains(&part), "{part}");
}

#[test]
fn a_third_of_wrong_tags_does_no_harm() {
    let truth = ordinary();
    let mut walk = BoardWalk::new(truth, 7);
    walk.wrong = 0.3;
    let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
    assert!(mean_difference(&truth, &found.lens) < 0.1);
    assert!(found.wrong_tags > 100);
    assert!(
        found
            .verdict
            .to_string()
            .contains("not where the board file says")
    );
}

/// As at the rim of a ChArUco board: the detector extrapolates a corner and says that it is unsure.
#[test]
fn corners_that_do_not_show_do_no_harm() {
    let truth = ordinary();
    let mut board = board(1.0, 1.0).tags().to_vec();
    let family = Family::Tag36h11b2;
    board.iter_mut().for_each(|tag| tag.tag.family = family);
    let board = ObjectModel::new(ObjectId::new("board").unwrap(), board).unwrap();
    let mut session = LensSession::new(&board, options(None)).unwrap();
    for mut image in BoardWalk::new(truth, 9).images() {
        for seen in &mut image.tags {
            let corner = seen.tag.id as usize % 4;
            seen.tag.family = family;
            seen.corners[corner].x += 1.5;
            seen.corner_covariance[corner] = Matrix2::identity();
        }
        session.handle(&image).unwrap();
    }
    let found = session.solve().unwrap();
    assert_eq!(found.wrong_tags, 0);
    assert!((found.noise_px - 0.1).abs() < 0.01, "{}", found.noise_px);
    assert!(mean_difference(&truth, &found.lens) < 0.1);
}

#[test]
fn partly_visible_boards_will_do() {
    let truth = ordinary();
    let mut walk = BoardWalk::new(truth, 8);
    walk.missing = 0.6;
    walk.images = 40;
    let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
    assert!(mean_difference(&truth, &found.lens) < 0.15);
}

#[test]
fn a_board_enlarged_as_a_whole_gives_the_same_lens() {
    let truth = ordinary();
    let mut session =
        LensSession::new(&board(1.02, 1.02), options(Some(LensModel::BrownConrady))).unwrap();
    for image in BoardWalk::new(truth, 9).images() {
        session.handle(&image).unwrap();
    }
    assert!(mean_difference(&truth, &session.solve().unwrap().lens) < 0.1);
}

#[test]
fn a_bent_board_gives_the_lens_all_the_same() {
    for seed in 30..33 {
        let mut walk = BoardWalk::new(ordinary(), seed);
        walk.bend_m = 0.0008;
        let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
        let off_px = found.lens.intrinsics().fx - ordinary().intrinsics().fx;
        assert!(off_px.abs() < 1.0, "{off_px}");
        assert!(
            off_px.abs() < 3.0 * found.sigmas[0],
            "{off_px} {}",
            found.sigmas[0]
        );
        assert!(found.wrong_tags < 5, "{}", found.wrong_tags);
    }
}

#[test]
fn what_all_corners_of_an_image_share_counts_once() {
    let squares = (40..60).map(|seed| {
        let mut walk = BoardWalk::new(ordinary(), seed);
        walk.breathing = 0.002;
        let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
        ((found.lens.intrinsics().fx - ordinary().intrinsics().fx) / found.sigmas[0]).powi(2)
    });
    let rms = (squares.sum::<f64>() / 20.0).sqrt();
    assert!((0.5..1.5).contains(&rms), "{rms}");
}

#[test]
fn squares_that_contradict_their_distances_are_found() {
    let mut session = LensSession::new(&board(1.02, 1.0), options(None)).unwrap();
    for image in BoardWalk::new(ordinary(), 10).images() {
        session.handle(&image).unwrap();
    }
    match session.solve() {
        Err(LensRefusal::Sizes { percent }) => assert!((percent + 1.96).abs() < 0.3, "{percent}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn frontal_views_are_named() {
    let mut walk = BoardWalk::new(ordinary(), 11);
    walk.tilt = 0.01;
    for model in [None, Some(LensModel::BrownConrady)] {
        let refusal = solved(&walk, model).unwrap_err();
        assert!(
            matches!(refusal, LensRefusal::OnlyFrontal { .. }),
            "{refusal}"
        );
    }
}

#[test]
fn a_second_tag_of_the_same_id_is_named() {
    let truth = ordinary();
    let mut walk = BoardWalk::new(truth, 12);
    walk.second_of = Some(7);
    let found = solved(&walk, Some(LensModel::BrownConrady)).unwrap();
    assert!(mean_difference(&truth, &found.lens) < 0.1);
    assert_eq!(
        found
            .suspicious
            .iter()
            .map(|tag| tag.id)
            .collect::<Vec<_>>(),
        [7]
    );
}

#[test]
fn sets_without_a_board_are_refused_with_their_cause() {
    let mut walk = BoardWalk::new(ordinary(), 13);
    walk.missing = 1.0;
    let message = solved(&walk, None).unwrap_err().to_string();
    assert!(
        message.starts_with("none of 30 images shows a tag of the board;"),
        "{message}"
    );
    walk.missing = 0.0;
    walk.images = 3;
    assert!(matches!(
        solved(&walk, None),
        Err(LensRefusal::TooFew { views: 3, .. })
    ));
    let mut session = LensSession::new(
        &board(1.0, 1.0),
        LensOptions {
            resolution: [320, 240],
            ..options(None)
        },
    )
    .unwrap();
    let refused = walk
        .images()
        .iter()
        .find_map(|image| session.handle(image).err());
    assert!(refused.unwrap().to_string().contains("another resolution"));
}

#[test]
fn a_stream_leads_to_coverage_by_its_hints() {
    let stream = LensOptions {
        selection: Selection::New,
        ..options(None)
    };
    let mut session = LensSession::new(&board(1.0, 1.0), stream).unwrap();
    assert_eq!(session.progress().hint, Hint::ShowBoard);
    let mut walk = BoardWalk::new(ordinary(), 14);
    walk.images = 300;
    let images = walk.images();
    assert_eq!(session.handle(&images[0]), Ok(ViewOutcome::Added));
    assert_eq!(session.handle(&images[0]), Ok(ViewOutcome::Duplicate));
    assert!(matches!(session.progress().hint, Hint::HoldAt(..)));
    let mut before = 0.0;
    for image in &images {
        session.handle(image).unwrap();
        let now = session.progress().fraction;
        assert!(now >= before && now <= 1.0);
        before = now;
    }
    assert_eq!((session.progress().hint, before), (Hint::Enough, 1.0));
    assert!(session.progress().views < 300);
}

#[test]
fn a_hint_names_the_empty_corner_and_the_side_not_yet_turned_away() {
    let mut session = LensSession::new(&board(1.0, 1.0), options(None)).unwrap();
    let mut walk = BoardWalk::new(ordinary(), 15);
    walk.images = 60;
    for mut image in walk.images() {
        image
            .tags
            .retain(|tag| tag.corners.iter().all(|c| c.x > 250.0 || c.y > 200.0));
        session.handle(&image).unwrap();
    }
    let hint = session.progress().hint.to_string();
    assert!(
        hint.starts_with("hold the board to the upper left of the picture"),
        "{hint}"
    );
}

#[test]
fn a_board_that_stays_far_away_is_asked_to_come_nearer() {
    let stream = LensOptions {
        selection: Selection::New,
        ..options(None)
    };
    let mut session = LensSession::new(&board(1.0, 1.0), stream).unwrap();
    let mut walk = BoardWalk::new(ordinary(), 16);
    walk.depth = [0.45, 0.53];
    walk.images = 300;
    let mut asked = false;
    for image in walk.images() {
        session.handle(&image).unwrap();
        asked |= session.progress().hint == Hint::Nearer;
    }
    assert!(asked);
    assert_eq!(
        (session.progress().hint, session.progress().near),
        (Hint::Enough, 0)
    );
}
