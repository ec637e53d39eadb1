//! Places of tags as other tools write them: the bundles of `apriltag_ros`, and the fields of WPILib and PhotonVision.

use crate::error::Complaint;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use sextant_geometry::{Pose, unit_quaternion};
use sextant_site_model::{ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use yaml_serde::Value;

/// Edge of the tags of a field of FRC since 2024, 6.5 inches, and of 2023, 6 inches; m.
const FIELD_TAG_M: f64 = 0.1651;
const FIELD_TAG_2023_M: f64 = 0.1524;
/// Length and width of the fields of FRC, m, by the year: 2023, whose tags are of tag16h5, then those of tag36h11.
const FIELD_2023: [f64; 2] = [16.541_75, 8.0137];
const FIELDS: [[f64; 2]; 3] = [[16.541, 8.211], [17.548, 8.052], [16.541, 8.069]];
/// Largest difference of a length or a width that is the same, m.
const SAME_M: f64 = 2e-3;

/// What the tags of a document have in common: the files of the tools state neither, people may add both.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TagKind {
    family: Family,
    /// m; of fields only, since bundles have the size of each tag.
    size_m: f64,
    /// What is assumed rather than stated.
    assumed: Assumed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Assumed {
    Nothing,
    /// The tags of FRC in 2023, by the size of the field and the ids.
    Of2023,
    /// The default.
    Default,
}

/// What describes the tags of a document: a bundle or a field.
enum TagLayout<'a> {
    Bundles(&'a [Value]),
    Field(&'a Value),
}

fn layout_of(document: &Value) -> Option<TagLayout<'_>> {
    if let Some(bundles) = document.get("tag_bundles").and_then(Value::as_sequence) {
        Some(TagLayout::Bundles(bundles))
    } else {
        let field = document.get("field")?;
        document.get("tags").map(|_| TagLayout::Field(field))
    }
}

/// The object of a document that lists places of tags; nothing of another document.
pub(super) fn object(document: &Value, id: &ObjectId) -> Option<Result<ObjectModel, Complaint>> {
    let layout = layout_of(document)?;
    // A field is where robots localise themselves: its frame is the world.
    let place = matches!(layout, TagLayout::Field(_)).then(Pose::identity);
    let tags = tag_kind(document, &layout).and_then(|kind| match layout {
        TagLayout::Bundles(bundles) => list(bundle(bundles)?, "layout", kind, of_bundle),
        TagLayout::Field(_) => list(document, "tags", kind, of_field),
    });
    let object = |tags| {
        ObjectModel::new(id.clone(), tags)
            .and_then(|object| object.with_world_from_object(place))
            .map_err(|error| Complaint::new("", error.to_string(), "write metres"))
    };
    Some(tags.and_then(object))
}

/// An object whose frame is a field, as a layout of WPILib, with the length and width of the field, m. `family` and
/// `tagSize` stand beside them, which WPILib passes over and `read_object` reads.
///
/// # Errors
/// For a field without an area, an articulated object, tags of several families or sizes, and an object without a
/// placed tag.
pub fn field_layout(object: &ObjectModel, field_m: [f64; 2]) -> Result<String, Complaint> {
    let refused = |cause: &str, remedy: &str| Err(Complaint::new("", cause, remedy));
    let [length, width] = field_m;
    if !field_m.iter().all(|m| m.is_finite() && *m > 0.0) {
        return refused(
            "the field has no area",
            "give its length and width in metres",
        );
    }
    if object.articulation().is_some() {
        return refused(
            "a field layout has tags that do not move, and this object has joints",
            "give an object without joints",
        );
    }
    let placed = object.tags().iter();
    let placed: Vec<_> = placed
        .filter_map(|tag| Some((tag, tag.object_from_tag?)))
        .collect();
    let Some((first, _)) = placed.first() else {
        return refused(
            "no tag has a place on the object",
            "find their places first: `sextant learn` or `sextant calibrate site`",
        );
    };
    let (family, size_m) = (first.tag.family, first.size_m);
    let is_alike = |tag: &ObjectTag| tag.tag.family == family && tag.size_m == size_m;
    if let Some((other, _)) = placed.iter().find(|(tag, _)| !is_alike(tag)) {
        let cause = format!(
            "a field layout has tags of one family and size: {} has {} m, {} has {size_m} m",
            other.tag, other.size_m, first.tag
        );
        return refused(
            &cause,
            "write an object file for each kind, and a layout of each",
        );
    }
    let tags: Vec<String> = placed
        .iter()
        .map(|(tag, field_from_tag)| field_tag(tag.tag.id, field_from_tag))
        .collect();
    Ok(format!(
        "{{\n  \"tags\": [\n{}\n  ],\n  \"field\": {{\"length\": {length}, \"width\": \
         {width}}},\n  \"family\": \"{family}\",\n  \"tagSize\": {size_m}\n}}\n",
        tags.join(",\n")
    ))
}

/// A tag of a layout, with WPILib's axes.
fn field_tag(id: u32, field_from_tag: &Pose) -> String {
    let ours_from_theirs = UnitQuaternion::new_unchecked(Quaternion::new(0.5, -0.5, -0.5, -0.5));
    let turned = (field_from_tag.rotation * ours_from_theirs).into_inner();
    let [x, y, z]: [f64; 3] = field_from_tag.translation.vector.into();
    let (qw, qx, qy, qz) = (turned.w, turned.i, turned.j, turned.k);
    format!(
        "    {{\"ID\": {id}, \"pose\": {{\"translation\": {{\"x\": {x}, \"y\": {y}, \"z\": \
         {z}}}, \"rotation\": {{\"quaternion\": {{\"W\": {qw}, \"X\": {qx}, \"Y\": {qy}, \"Z\": {qz}}}}}}}}}"
    )
}

/// What is assumed of the tags of a document.
pub(crate) fn assumption(document: &Value) -> Option<String> {
    let layout = layout_of(document)?;
    let kind = tag_kind(document, &layout).ok()?;
    let (family, mm) = (kind.family, kind.size_m * 1e3);
    let remedy = "else write \"family\"";
    match (layout, kind.assumed) {
        (_, Assumed::Nothing) => None,
        (TagLayout::Field(_), Assumed::Of2023) => Some(format!(
            "the tags are taken for {family} of {mm} mm, as FRC had them in 2023 on a field of \
             this size; {remedy} and \"tagSize\" (m) beside \"field\" in it"
        )),
        (TagLayout::Field(_), _) => Some(format!(
            "the tags are taken for {family} of {mm} mm, as FRC has them since 2024, since the \
             file does not say it; {remedy} and \"tagSize\" (m) beside \"field\" in it"
        )),
        (TagLayout::Bundles(_), _) => Some(format!(
            "the tags are taken for {family}, since the file does not say it; else write family \
             beside tag_bundles in it, such as family: tag16h5"
        )),
    }
}

/// The family and the size of the tags: what is written beside them, else what their ids and the field allow.
fn tag_kind(document: &Value, layout: &TagLayout<'_>) -> Result<TagKind, Complaint> {
    let keys = ["family", "tag_family", "tagFamily"];
    let family = keys
        .iter()
        .find_map(|key| Some((*key, document.get(*key)?)));
    let family = family.map(|(key, value)| {
        let name = value.as_str().unwrap_or_default();
        let family = name.parse::<Family>();
        family.map_err(|error| Complaint::new(key, error.to_string(), ""))
    });
    let family = family.transpose()?;
    let size_m = match document.get("tagSize") {
        Some(_) => Some(number(document, "tagSize")?),
        None => None,
    };
    let inferred = inferred(document, layout);
    Ok(TagKind {
        family: family.unwrap_or(inferred.family),
        size_m: size_m.unwrap_or(inferred.size_m),
        assumed: match (family, layout) {
            (Some(_), TagLayout::Bundles(_)) => Assumed::Nothing,
            (Some(_), TagLayout::Field(_)) if size_m.is_some() => Assumed::Nothing,
            _ => inferred.assumed,
        },
    })
}

/// Of FRC's families tag16h5 has 30 tags, and was on the field of 2023 only.
fn inferred(document: &Value, layout: &TagLayout<'_>) -> TagKind {
    let of_36h11 = |assumed| TagKind {
        family: Family::Tag36h11,
        size_m: FIELD_TAG_M,
        assumed,
    };
    let TagLayout::Field(field) = layout else {
        return of_36h11(Assumed::Default);
    };
    let tags = document.get("tags").and_then(Value::as_sequence);
    let ids = tags.into_iter().flatten();
    let ids = ids.filter_map(|tag| tag.get("ID").and_then(Value::as_u64));
    let last = ids.max().unwrap_or(0);
    let is_field = |[length, width]: [f64; 2]| {
        let is = |key: &str, m: f64| number(field, key).is_ok_and(|is| (is - m).abs() < SAME_M);
        is("length", length) && is("width", width)
    };
    if is_field(FIELD_2023) && last <= 8 {
        TagKind {
            family: Family::Tag16h5,
            size_m: FIELD_TAG_2023_M,
            assumed: Assumed::Of2023,
        }
    } else if FIELDS.into_iter().any(is_field) {
        of_36h11(Assumed::Nothing)
    } else {
        of_36h11(Assumed::Default)
    }
}

/// The only bundle.
fn bundle(bundles: &[Value]) -> Result<&Value, Complaint> {
    if let [bundle] = bundles {
        return Ok(bundle);
    }
    let names: Vec<&str> = bundles
        .iter()
        .filter_map(|bundle| bundle.get("name")?.as_str())
        .collect();
    let cause = format!(
        "it describes {} objects: {}",
        bundles.len(),
        names.join(", ")
    );
    let remedy = "leave one bundle in a file: an object file has one object";
    Err(Complaint::new("tag_bundles", cause, remedy))
}

fn list(
    parent: &Value,
    key: &str,
    kind: TagKind,
    tag: fn(&Value, TagKind) -> Result<ObjectTag, Complaint>,
) -> Result<Vec<ObjectTag>, Complaint> {
    let tags = parent.get(key).and_then(Value::as_sequence);
    let tags = tags.ok_or_else(|| Complaint::new(key, "this is no list of tags", ""))?;
    let read = tags.iter().enumerate().map(|(index, value)| {
        tag(value, kind).map_err(|complaint| Complaint {
            key: format!("{key}[{index}].{}", complaint.key),
            ..complaint
        })
    });
    read.collect()
}

/// `{id, size, x, y, z, qw, qx, qy, qz}`, with the axes of tags here.
fn of_bundle(value: &Value, kind: TagKind) -> Result<ObjectTag, Complaint> {
    let place = |key: &str| {
        number(value, key).or_else(|error| match value.get(key) {
            None if key != "qw" => Ok(0.0),
            None => Ok(1.0),
            Some(_) => Err(error),
        })
    };
    let pose = pose(
        [place("x")?, place("y")?, place("z")?],
        [place("qw")?, place("qx")?, place("qy")?, place("qz")?],
    )?;
    Ok(ObjectTag::new(
        tag_id(value, "id", kind.family)?,
        number(value, "size")?,
        Some(pose),
    ))
}

/// `{ID, pose: {translation, rotation: {quaternion}}}`. There a tag's x points out of its face and z up, so that y is
/// to the right.
fn of_field(value: &Value, kind: TagKind) -> Result<ObjectTag, Complaint> {
    let part = |value: &Value, key: &'static str| {
        let part = value.get(key).cloned();
        part.ok_or_else(|| Complaint::new(key, "it is missing", ""))
    };
    let placed = part(value, "pose")?;
    let (translation, rotation) = (part(&placed, "translation")?, part(&placed, "rotation")?);
    let turned = part(&rotation, "quaternion")?;
    let [x, y, z] = ["x", "y", "z"].map(|key| number(&translation, key));
    let [qw, qx, qy, qz] = ["W", "X", "Y", "Z"].map(|key| number(&turned, key));
    let field_from_theirs = pose([x?, y?, z?], [qw?, qx?, qy?, qz?])?;
    // Ours: x to their y, y to their z, z to their x: a third of a turn about the diagonal.
    let theirs_from_ours = pose([0.0; 3], [0.5; 4])?;
    let field_from_tag = field_from_theirs * theirs_from_ours;
    Ok(ObjectTag::new(
        tag_id(value, "ID", kind.family)?,
        kind.size_m,
        Some(field_from_tag),
    ))
}

fn tag_id(value: &Value, key: &str, family: Family) -> Result<TagId, Complaint> {
    let id = value.get(key).and_then(Value::as_u64);
    let known = id.filter(|id| (*id as usize) < family.data().codes.len());
    let id = known.ok_or_else(|| Complaint::new(key, format!("{family} has no such tag"), ""))?;
    Ok(TagId {
        family,
        id: id as u32,
    })
}

fn number(value: &Value, key: &str) -> Result<f64, Complaint> {
    let number = value.get(key).and_then(Value::as_f64);
    let number = number.filter(|number| number.is_finite());
    number.ok_or_else(|| Complaint::new(key, "this is no finite number", ""))
}

fn pose([x, y, z]: [f64; 3], [qw, qx, qy, qz]: [f64; 4]) -> Result<Pose, Complaint> {
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    if !(0.9..1.1).contains(&quaternion.norm()) {
        return Err(Complaint::new(
            "qw",
            "the quaternion is not of length 1",
            "",
        ));
    }
    let turned = unit_quaternion(quaternion);
    Ok(Pose::from_parts(Translation3::new(x, y, z), turned))
}
