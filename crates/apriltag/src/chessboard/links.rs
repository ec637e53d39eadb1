//! Links between neighbouring corners: the edge of a square from one to the other.

use super::candidates::Candidate;
use super::smoothed::Smoothed;
use crate::quad::{Point, distance};

/// Largest sine of the angle between an edge at a corner and the way to the neighbour: a lens bends edges, and squares
/// may be small.
const MOST_SINE: f32 = 0.42;
/// Least distance of neighbours, in pixels.
const LEAST_PX: f32 = 4.5;
/// Neighbours examined in each direction, nearest first.
const EXAMINED: usize = 3;
/// Least contrast along an edge, as a share of the swings at its ends.
const LEAST_CONTRAST: f32 = 0.5;

/// A neighbour of a corner, and which of its edges leads back.
pub(super) type Link = Option<(usize, usize)>;

/// The neighbours of each candidate along its four edges. Links are mutual.
pub(super) fn links(image: &Smoothed, candidates: &[Candidate]) -> Vec<[Link; 4]> {
    let one_way: Vec<[Link; 4]> = candidates
        .iter()
        .map(|from| std::array::from_fn(|ray| neighbour(image, candidates, from, ray)))
        .collect();
    let is_mutual = |index: usize, ray: usize, link: &Link| {
        link.is_some_and(|(other, back)| one_way[other][back] == Some((index, ray)))
    };
    let mutual = one_way.iter().enumerate().map(|(index, links)| {
        std::array::from_fn(|ray| links[ray].filter(|_| is_mutual(index, ray, &links[ray])))
    });
    mutual.collect()
}

/// The nearest candidate along an edge that the edge really connects.
fn neighbour(image: &Smoothed, candidates: &[Candidate], from: &Candidate, ray: usize) -> Link {
    let direction = from.ray(ray);
    let mut nearest = [(f32::INFINITY, None); EXAMINED];
    for (index, to) in candidates.iter().enumerate() {
        let way = [to.place[0] - from.place[0], to.place[1] - from.place[1]];
        let along = way[0] * direction[0] + way[1] * direction[1];
        if along < LEAST_PX || along >= nearest[EXAMINED - 1].0 {
            continue;
        }
        let length = way[0].hypot(way[1]);
        let is_ahead = sine(way, direction) < MOST_SINE * length;
        let Some(back) = back_ray(to, ray, way).filter(|_| is_ahead) else {
            continue;
        };
        let at = nearest.partition_point(|(distance, _)| *distance < along);
        nearest[at..].rotate_right(1);
        nearest[at] = (along, Some((index, back)));
    }
    let bright_right = ray.is_multiple_of(2);
    nearest.into_iter().find_map(|(_, link)| {
        let (index, back) = link?;
        let to = &candidates[index];
        let least = LEAST_CONTRAST * (from.swing + to.swing);
        is_edge(image, [from.place, to.place], bright_right, least).then_some((index, back))
    })
}

/// The edge of `to` that leads back along `way`. Colours alternate, so that it is one of the other kind.
fn back_ray(to: &Candidate, ray: usize, way: Point) -> Option<usize> {
    let length = way[0].hypot(way[1]);
    let kind = 1 - ray % 2;
    let edge = to.edges[kind];
    let cosine = way[0] * edge[0] + way[1] * edge[1];
    (sine(way, edge) < MOST_SINE * length).then_some(if cosine < 0.0 { kind } else { kind + 2 })
}

/// Absolute cross product with a unit vector.
fn sine(way: Point, direction: Point) -> f32 {
    (way[0] * direction[1] - way[1] * direction[0]).abs()
}

/// Whether white and black meet along a line, everywhere between its ends; white to its right or to its left.
pub(super) fn is_edge(
    image: &Smoothed,
    [from, to]: [Point; 2],
    bright_right: bool,
    least_contrast: f32,
) -> bool {
    const PLACES: [f32; 5] = [0.25, 0.375, 0.5, 0.625, 0.75];
    /// Distance of the samples from the line, as a share of its length and in pixels.
    const ASIDE: f32 = 0.18;
    const LEAST_ASIDE_PX: f32 = 1.5;
    let length = distance(from, to);
    let aside = (ASIDE * length).max(LEAST_ASIDE_PX) / length;
    let way = [to[0] - from[0], to[1] - from[1]];
    // Clockwise from the way, with y down.
    let right = [-way[1] * aside, way[0] * aside];
    let sign = if bright_right { 1.0 } else { -1.0 };
    PLACES.into_iter().all(|at| {
        let middle = [from[0] + at * way[0], from[1] + at * way[1]];
        let sides = [1.0, -1.0]
            .map(|side| image.sample([middle[0] + side * right[0], middle[1] + side * right[1]]));
        matches!(sides, [Some(right), Some(left)] if sign * (right - left) > least_contrast)
    })
}
