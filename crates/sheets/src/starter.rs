//! One page for a first site: tags of two objects, and one for the floor.

use crate::pdf::{Page, Stroke};
use crate::sheet::{MARGIN, SMALL, Sheet, label_of, length_text, printed_edge};
use crate::{Paper, SheetError, ids_from};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;

const FAMILY: Family = Family::Tag36h11;
/// Edges of the black squares on objects and on the floor, mm.
const SIZE: f64 = 40.0;
const FLOOR_SIZE: f64 = 80.0;
/// Tags of an object.
const TAGS: u32 = 3;
/// Names of the objects and the first tag of each.
const OBJECTS: [(&str, u32); 2] = [("one", 0), ("two", TAGS)];
const FLOOR: (&str, u32) = ("floor", 300);
/// Between neighbours, and above each row for its title.
const STRIP: f64 = 6.0;
const TITLE: f64 = 7.0;

/// The page with its objects.
#[derive(Debug, Clone)]
pub struct Starter {
    /// The page.
    pub page: Page,
    /// Two objects whose tags have no poses yet, and the floor's tag, whose pose is the object's.
    pub objects: Vec<ObjectModel>,
    /// Edge of the black squares on objects, mm.
    pub size: f64,
}

/// Lays out the page.
///
/// # Errors
/// None on these papers.
pub fn starter(paper: Paper) -> Result<Starter, SheetError> {
    let [width, height] = paper.size();
    let mut sheet = Sheet::new(paper);
    let mut top = height - MARGIN;
    let mut objects = Vec::new();
    for (id, first) in OBJECTS {
        let title =
            format!("Object {id}: stick these on different sides of a thing, flat, ring and all");
        let tags = ids_from(FAMILY, first, TAGS)?;
        top = row(&mut sheet, [width, top], &title, &tags, SIZE);
        objects.push(object(id, &tags, SIZE, None)?);
    }
    let (id, first) = FLOOR;
    let title =
        "Floor: lay this at the origin of the world; x points to its right, y to its upper edge";
    let tags = ids_from(FAMILY, first, 1)?;
    row(&mut sheet, [width, top], title, &tags, FLOOR_SIZE);
    objects.push(object(id, &tags, FLOOR_SIZE, Some(Pose::identity()))?);
    let notes = [
        format!(
            "Black squares of {} and {}. Print at 100 %, cut along the grey lines.",
            length_text(SIZE),
            length_text(FLOOR_SIZE)
        ),
        "The ruler must be 100 mm long. If it is not, measure a small black square and use --measured-size.".to_owned(),
    ];
    sheet.notes([MARGIN + 5.0, MARGIN + 16.5], &notes);
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
    Ok(Starter {
        page: sheet.into_page(),
        objects,
        size: SIZE,
    })
}

/// Draws a titled row of tags in the middle of the width; returns where the next one begins.
fn row(sheet: &mut Sheet, [width, top]: [f64; 2], title: &str, tags: &[TagId], size: f64) -> f64 {
    let edge = tags.first().map_or(size, |tag| printed_edge(*tag, size));
    let whole = tags.len() as f64 * (edge + STRIP) - STRIP;
    let left = (width - whole) / 2.0;
    sheet.text([left, top - 0.7 * TITLE], 1.3 * SMALL, title);
    for (i, tag) in tags.iter().enumerate() {
        let centre = [
            left + edge / 2.0 + i as f64 * (edge + STRIP),
            top - TITLE - edge / 2.0,
        ];
        sheet.tag(*tag, centre, size);
        sheet.square(Stroke::Cut, centre, edge);
        let below = [centre[0] - edge / 2.0, centre[1] - edge / 2.0 - 0.9 * SMALL];
        sheet.text(below, SMALL, label_of(*tag, size));
    }
    top - TITLE - edge - STRIP
}

fn object(
    id: &str,
    tags: &[TagId],
    size: f64,
    object_from_tag: Option<Pose>,
) -> Result<ObjectModel, SheetError> {
    let tags = tags
        .iter()
        .map(|tag| ObjectTag::new(*tag, size * 1e-3, object_from_tag));
    Ok(ObjectModel::new(id.parse()?, tags.collect())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_tags_differ_and_the_floor_has_its_pose() {
        for paper in [Paper::A4, Paper::Letter] {
            let starter = starter(paper).unwrap();
            let tags = starter.objects.iter().flat_map(ObjectModel::tags);
            let mut ids: Vec<u32> = tags.map(|tag| tag.tag.id).collect();
            ids.dedup();
            assert_eq!(ids, [0, 1, 2, 3, 4, 5, 300]);
            let floor = &starter.objects[2].tags()[0];
            assert!(floor.object_from_tag.is_some() && floor.size_m == 0.08);
        }
    }
}
