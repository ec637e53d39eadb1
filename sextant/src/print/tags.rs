//! Single tags to cut out, and an object file that lists them; several of them without poses.

use super::PrintJob;
use super::pdf::Stroke;
use super::sheet::{MARGIN, Paper, SMALL, Sheet, label_of, length_text, printed_edge};
use anyhow::{Context, ensure};
use clap::Args;
use sextant_geometry::Pose;
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use std::str::FromStr;

/// Distance between the cutting lines of neighbours; the ids are printed there.
const STRIP: f64 = 4.0;
/// Height of ruler and notes under the tags.
const FOOT: f64 = 24.0;
/// Most tags of one file, so that a typing error does not fill the disk.
const MAX_TAGS: usize = 1000;

/// Options of single tags.
#[derive(Args, Debug, Clone)]
pub struct TagsArguments {
    /// Ids and ranges, such as 0-5,9.
    #[arg(long, value_name = "IDS", default_value = "0-5")]
    pub ids: Ids,
    /// Edge of each black square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.04)]
    pub size: f64,
    /// The tags' family.
    #[arg(long, default_value = "tag36h11")]
    pub family: Family,
}

/// Ids in the order given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ids(Vec<u32>);

impl FromStr for Ids {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let mut ids = Vec::new();
        for part in text.split(',') {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let number = |word: &str| {
                let number = word.trim().parse::<u32>();
                number.with_context(|| format!("`{part}` is no id and no range such as 0-5"))
            };
            let (first, last) = (number(first)?, number(last)?);
            ensure!(first <= last, "the range `{part}` runs backwards");
            let count = (last - first) as usize + ids.len();
            ensure!(count < MAX_TAGS, "more than {MAX_TAGS} tags");
            ids.extend(first..=last);
        }
        Ok(Self(ids))
    }
}

/// Lays out the tags.
///
/// # Errors
/// Ids that the family lacks, duplicate ids, and a size larger than the paper.
pub fn tags(arguments: &TagsArguments, id: &str, paper: Paper) -> anyhow::Result<PrintJob> {
    let size = arguments.size * 1e3;
    super::check_size(size)?;
    let tags: Vec<TagId> = arguments
        .ids
        .0
        .iter()
        .map(|&id| super::tag_of(arguments.family, id))
        .collect::<anyhow::Result<_>>()?;
    let edge = printed_edge(super::tag_of(arguments.family, 0)?, size);
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
fn places_on(paper: Paper, edge: f64) -> anyhow::Result<Vec<[f64; 2]>> {
    let [width, height] = paper.size();
    let pitch = edge + STRIP;
    let [across, down] = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    let [columns, rows] = [((across + STRIP) / pitch) as u32, (down / pitch) as u32];
    ensure!(
        columns > 0 && rows > 0,
        "a tag of {edge:.0} mm with its white ring does not fit on {}, which leaves {across:.0} x {down:.0} mm; take a smaller --size",
        paper.name()
    );
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_single_or_ranges() {
        assert_eq!("0-2,9, 4".parse::<Ids>().unwrap().0, [0, 1, 2, 9, 4]);
        for wrong in ["", "3-1", "a", "1-", "0-4000000000"] {
            assert!(wrong.parse::<Ids>().is_err(), "{wrong}");
        }
    }
}
