//! Single tags to cut out, and an object file that lists them; several of them without poses.

use crate::pdf::Stroke;
use crate::sheet::{MARGIN, SMALL, Sheet, label_of, length_text, printed_edge};
use crate::{Paper, PrintJob, SheetError, check_size, tag_of};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;

/// Distance between the cutting lines of neighbours; the ids are printed there.
const STRIP: f64 = 4.0;
/// Height of ruler and notes under the tags.
const FOOT: f64 = 24.0;
/// Lays out tags of a family, with black squares of `size_m`.
///
/// # Errors
/// Ids that the family lacks, duplicate ids, and a size larger than the paper.
pub fn tags(
    family: Family,
    ids: &[u32],
    size_m: f64,
    id: &str,
    paper: Paper,
) -> Result<PrintJob, SheetError> {
    let size = size_m * 1e3;
    check_size(size)?;
    let tags: Vec<TagId> = ids
        .iter()
        .map(|&id| tag_of(family, id))
        .collect::<Result<_, _>>()?;
    let edge = printed_edge(tag_of(family, 0)?, size);
    let places = places_on(paper, edge)?;
    // A tag by itself is the object; where several are glued on, `sextant learn` finds out.
    let object_from_tag = (tags.len() == 1).then(Pose::identity);
    let on_object = |&tag: &TagId| ObjectTag::new(tag, size * 1e-3, object_from_tag);
    let model = ObjectModel::new(id.parse()?, tags.iter().map(on_object).collect())?;
    let pages = tags.chunks(places.len()).map(|tags| {
        let mut sheet = Sheet::new(paper);
        for (&tag, &centre) in tags.iter().zip(&places) {
            sheet.tag(tag, centre, size);
            sheet.square(Stroke::Cut, centre, edge);
            let below = [centre[0] - edge / 2.0, centre[1] - edge / 2.0 - 0.9 * SMALL];
            sheet.text(below, SMALL, label_of(tag, size));
        }
        foot(&mut sheet, size);
        sheet.into_page()
    });
    Ok(PrintJob {
        title: format!("Sextant tags of {id}"),
        pages: pages.collect(),
        model,
        size,
    })
}

/// Centres of the tags of a sheet, from the top left, row by row.
fn places_on(paper: Paper, edge: f64) -> Result<Vec<[f64; 2]>, SheetError> {
    let [width, height] = paper.size();
    let pitch = edge + STRIP;
    let [across, down] = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    let [columns, rows] = [((across + STRIP) / pitch) as u32, (down / pitch) as u32];
    if columns == 0 || rows == 0 {
        return Err(SheetError::TagTooLarge {
            edge,
            room: [across, down],
            paper,
        });
    }
    let left = (width - f64::from(columns) * pitch + STRIP) / 2.0 + edge / 2.0;
    let top = height - MARGIN - edge / 2.0;
    let places = (0..rows).flat_map(|row| {
        (0..columns).map(move |column| {
            [
                left + f64::from(column) * pitch,
                top - f64::from(row) * pitch,
            ]
        })
    });
    Ok(places.collect())
}

fn foot(sheet: &mut Sheet, size: f64) {
    let notes = [
        format!(
            "Black squares of {}. Print at 100 %, cut along the grey lines: the white ring belongs to the tag.",
            length_text(size)
        ),
        "The ruler must be 100 mm long. If it is not, measure a black square and use --measured-size.".to_owned(),
    ];
    sheet.notes([MARGIN + 5.0, MARGIN + 16.5], &notes);
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
}
