//! `object.toml`: one object, its tags and their poses on the object or its links.

mod links;

use crate::atomic::write_keeping_former;
use crate::boards::{AniposeFile, BoardError, Chessboard, parse_board};
use crate::document::Document;
use crate::error::{Complaint, FileError, InvalidFile};
use crate::foreign::{is_foreign, name_of, stem_of};
use crate::pose::{SCALE_SIGMA_REMEDY, SigmaTable, pose_of, pose_toml, sigma_toml};
use crate::read::read_text;
use links::{JointTable, LinkTable, articulation_of, articulation_toml};
use serde::Deserialize;
use sextant_geometry::PoseParts;
use sextant_site_model::{
    Articulation, IdError, LinkId, ObjectError, ObjectId, ObjectModel, ObjectTag, PoseSigma, TagId,
};
use sextant_tag_families::Family;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    id: ObjectId,
    /// Whether every number without a sigma is exact: a simulation.
    #[serde(default)]
    exact: bool,
    /// Standard deviation of the object's frame in its tags; optional.
    frame_sigma: Option<SigmaTable>,
    /// Standard deviation of the common scale, as a share of it; optional.
    scale_sigma: Option<f64>,
    /// Where it stands still in the world, if it is a landmark.
    world_from_object: Option<PoseParts>,
    /// Empty for a rigid object.
    #[serde(default)]
    link: Vec<LinkTable>,
    #[serde(default)]
    joint: Vec<JointTable>,
    #[serde(default)]
    tag: Vec<TagTable>,
}

/// A board in place of a list of tags.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoardFile {
    id: ObjectId,
    kind: BoardKind,
    /// Inner corners in a row.
    columns: u16,
    /// Rows of inner corners.
    rows: u16,
    /// Edge of a square, metres.
    size: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum BoardKind {
    Chessboard,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TagTable {
    family: Family,
    id: u32,
    /// Edge of the black square, metres.
    size: f64,
    /// Standard deviation in metres; optional.
    size_sigma: Option<f64>,
    /// For a rigid object; omitted until learned.
    object_from_tag: Option<PoseParts>,
    /// Standard deviation; optional.
    object_from_tag_sigma: Option<SigmaTable>,
    /// The link of the tag, if the object has links.
    link: Option<LinkId>,
    /// Replaces `object_from_tag` there; omitted until learned.
    link_from_tag: Option<PoseParts>,
    link_from_tag_sigma: Option<SigmaTable>,
}

/// The object of a file; for the board or the places of tags of another tool, named after the file.
///
/// # Errors
/// A file that is missing, malformed, or invalid; with line, column, key and remedy.
pub fn read_object(path: &Path) -> Result<ObjectModel, FileError> {
    let text = read_text(path)?;
    if !is_foreign(path, &text) {
        return parse_object(path, &text);
    }
    let board = parse_board(path, &text, &id_of(path)?)?;
    Ok(board.ok_or_else(|| {
        let known = "known are Kalibr's target.yaml (target_type: aprilgrid or checkerboard), \
            ChArUco boards (squaresX, squaresY, squareLength, markerLength, dictionary) grids of \
            markers (markersX, markersY, markerLength, markerSeparation, dictionary), \
            tag_bundles of apriltag_ros and fields of WPILib";
        let cause = "this is no board that is known";
        InvalidFile::with_all(path, Complaint::new("", cause, known))
    })?)
}

/// An id from the name of a file.
fn id_of(path: &Path) -> Result<ObjectId, InvalidFile> {
    name_of(stem_of(path)).parse().map_err(|error: IdError| {
        let complaint = Complaint::new("", error.to_string(), "rename the file");
        InvalidFile::with_all(path, complaint)
    })
}

/// The object of a text; `path` is for messages.
///
/// # Errors
/// As [`read_object`].
pub fn parse_object(path: &Path, text: &str) -> Result<ObjectModel, FileError> {
    let document = Document::parse(path, text)?;
    let has = |key: &str| document.root().get(key).is_some();
    let object = if has("kind") {
        board_of(document.read()?)
    } else if has("calibration") {
        document.read::<AniposeFile>()?.object(&id_of(path)?)
    } else {
        object_of(&document.read()?, &document)
    };
    Ok(object.map_err(|complaint| document.complaint(complaint))?)
}

fn board_of(file: BoardFile) -> Result<ObjectModel, Complaint> {
    let board = match file.kind {
        BoardKind::Chessboard => Chessboard {
            columns: file.columns,
            rows: file.rows,
            square_m: file.size,
        },
    };
    board.object(file.id).map_err(|error| match error {
        BoardError::Object(error) => Complaint::new("size", error.to_string(), "write metres"),
        error => Complaint::new("columns", error.to_string(), ""),
    })
}

fn object_of(file: &ObjectFile, document: &Document<'_>) -> Result<ObjectModel, Complaint> {
    if file.tag.is_empty() {
        let remedy = "add a [[tag]] table with family, id and size";
        return Err(Complaint::new("id", "the object has no tag", remedy));
    }
    let articulation = articulation_of(&file.link, &file.joint, document)?;
    let tree = articulation.as_ref();
    let tags: Result<Vec<ObjectTag>, Complaint> = (file.tag.iter().enumerate())
        .map(|(index, table)| {
            let link = link_of(index, table, tree)?;
            let tag = tag_of(&file.id, index, table)?;
            Ok(ObjectTag { link, ..tag })
        })
        .collect();
    unique(file, document)?;
    let object = match articulation {
        None => ObjectModel::new(file.id.clone(), tags?),
        Some(tree) => ObjectModel::articulated(file.id.clone(), tree, tags?),
    };
    let object = object.map_err(|error| complaint("tag", "object", &error))?;
    let frame_sigma = file.frame_sigma.as_ref().map(PoseSigma::from);
    let object = object.with_frame_sigma(frame_sigma).map_err(|error| {
        let remedy = "write metres and radians, one sigma an axis, or leave it out";
        Complaint::new("frame_sigma", error.to_string(), remedy)
    })?;
    let object = object
        .with_scale_sigma(file.scale_sigma)
        .map_err(|error| Complaint::new("scale_sigma", error.to_string(), SCALE_SIGMA_REMEDY))?;
    let place = pose_of(file.world_from_object.as_ref(), "world_from_object")?;
    let object = object.with_world_from_object(place).map_err(|error| {
        let remedy = "write finite numbers, or remove it where the object moves";
        Complaint::new("world_from_object", error.to_string(), remedy)
    })?;
    Ok(if file.exact { object.exact() } else { object })
}

/// The link of a tag; `None` if the object is rigid.
fn link_of(
    index: usize,
    table: &TagTable,
    articulation: Option<&Articulation>,
) -> Result<Option<LinkId>, Complaint> {
    let wrong = |part: &str, cause: &str, remedy: &str| {
        Err(Complaint::new(format!("tag[{index}]{part}"), cause, remedy))
    };
    let rigid = "the object has no links";
    match (articulation, &table.link) {
        (None, Some(_)) => wrong(".link", rigid, "add [[link]] tables, or remove the key"),
        (None, None) if table.link_from_tag.is_some() => {
            wrong(".link_from_tag", rigid, "write `object_from_tag`")
        }
        (None, None) if table.link_from_tag_sigma.is_some() => wrong(
            ".link_from_tag_sigma",
            rigid,
            "write `object_from_tag_sigma`",
        ),
        (None, None) => Ok(None),
        (Some(_), None) => wrong(
            "",
            "the object has links, and this tag names none",
            "add `link = ...` with the link that it sits on",
        ),
        (Some(_), Some(_)) if table.object_from_tag.is_some() => wrong(
            ".object_from_tag",
            "the tag sits on a link",
            "write `link_from_tag`",
        ),
        (Some(_), Some(_)) if table.object_from_tag_sigma.is_some() => wrong(
            ".object_from_tag_sigma",
            "the tag sits on a link",
            "write `link_from_tag_sigma`",
        ),
        (Some(tree), Some(link)) if tree.link(link).is_none() => wrong(
            ".link",
            &format!("the object has no link {link}"),
            "name one of the [[link]] tables",
        ),
        (Some(_), Some(link)) => Ok(Some(link.clone())),
    }
}

fn unique(file: &ObjectFile, document: &Document<'_>) -> Result<(), Complaint> {
    let mut first = BTreeMap::new();
    for (index, tag) in file.tag.iter().enumerate() {
        let key = format!("tag[{index}].id");
        if let Some(earlier) = first.insert((tag.family, tag.id), key.clone()) {
            let line = document.line_of(&earlier).unwrap_or(0);
            let cause = format!("{}:{} is there already, on line {line}", tag.family, tag.id);
            let remedy = "each tag may be used once: print and name another, or remove one";
            return Err(Complaint::new(key, cause, remedy));
        }
    }
    Ok(())
}

fn tag_of(object: &ObjectId, index: usize, table: &TagTable) -> Result<ObjectTag, Complaint> {
    let key = format!("tag[{index}]");
    let ids = table.family.data().codes.len();
    if table.id as usize >= ids {
        let cause = format!("{} has no tag {}", table.family, table.id);
        let remedy = format!("its ids are 0 to {}", ids - 1);
        return Err(Complaint::new(format!("{key}.id"), cause, remedy));
    }
    let (outer, pose, pose_sigma) = match &table.link {
        None => (
            "object",
            &table.object_from_tag,
            &table.object_from_tag_sigma,
        ),
        Some(_) => ("link", &table.link_from_tag, &table.link_from_tag_sigma),
    };
    let name = TagId {
        family: table.family,
        id: table.id,
    };
    let pose = pose_of(pose.as_ref(), &format!("{key}.{outer}_from_tag"))?;
    let tag = ObjectTag {
        pose_prior: pose_sigma.as_ref().map(PoseSigma::from).into(),
        size_prior: table.size_sigma.into(),
        ..ObjectTag::new(name, table.size, pose)
    };
    // An object with this tag alone: the rules are the site model's, the location is known here.
    let alone = ObjectModel::new(object.clone(), vec![tag.clone()]);
    alone.map_err(|error| complaint(&key, outer, &error))?;
    Ok(tag)
}

/// `outer` is "object", or "link" if the tag is on one.
fn complaint(key: &str, outer: &str, error: &ObjectError) -> Complaint {
    let (part, remedy) = match error {
        ObjectError::Size { .. } => (
            ".size".to_owned(),
            "measure the edge of the black square and write it in metres",
        ),
        ObjectError::SizeSigma { .. } => (
            ".size_sigma".to_owned(),
            "write metres, one sigma, or leave it out",
        ),
        ObjectError::Pose { .. } => (format!(".{outer}_from_tag"), "write finite numbers"),
        ObjectError::TagSigma { .. } => (
            format!(".{outer}_from_tag_sigma"),
            "write metres and radians, one sigma an axis, or leave it out",
        ),
        _ => (String::new(), ""),
    };
    Complaint::new(format!("{key}{part}"), error.to_string(), remedy)
}

/// The text of an object file. Numbers have enough digits to be read back exactly.
pub fn object_toml(object: &ObjectModel) -> String {
    let mut text = format!("id = \"{}\"\n", object.id());
    if let Some(sigma) = object.frame_sigma() {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "frame_sigma = {}", sigma_toml(&sigma));
    }
    if let Some(sigma) = object.scale_sigma() {
        let _ = writeln!(text, "scale_sigma = {sigma:?}");
    }
    if let Some(pose) = object.world_from_object() {
        let _ = writeln!(text, "world_from_object = {}", pose_toml(&pose.into()));
    }
    let tree = object.articulation().map(articulation_toml);
    text.push_str(&tree.unwrap_or_default());
    for tag in object.tags() {
        let TagId { family, id } = tag.tag;
        let _ = write!(
            text,
            "\n[[tag]]\nfamily = \"{family}\"\nid = {id}\nsize = {:?}\n",
            tag.size_m
        );
        if let Some(sigma_m) = tag.size_prior.given() {
            let _ = writeln!(text, "size_sigma = {sigma_m:?}");
        }
        if let Some(link) = &tag.link {
            let _ = writeln!(text, "link = \"{link}\"");
        }
        let outer = tag.link.as_ref().map_or("object", |_| "link");
        if let Some(pose) = &tag.object_from_tag {
            let _ = writeln!(text, "{outer}_from_tag = {}", pose_toml(&pose.into()));
        }
        if let Some(sigma) = tag.pose_prior.given() {
            let _ = writeln!(text, "{outer}_from_tag_sigma = {}", sigma_toml(&sigma));
        }
    }
    text
}

/// Writes an object file atomically; the former version is kept ([`crate::former_of`]).
///
/// # Errors
/// An error of the system; the old file is then unchanged.
pub fn write_object(path: &Path, object: &ObjectModel) -> Result<(), FileError> {
    write_keeping_former(path, object_toml(object).as_bytes())
}

#[cfg(test)]
mod tests;
