//! Places of tags as other tools write them: the bundles of `apriltag_ros`, and the fields of WPILib and PhotonVision.

use crate::error::Complaint;
use nalgebra::{Quaternion, Translation3};
use sextant_geometry::{Pose, unit_quaternion};
use sextant_site_model::{ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use yaml_serde::Value;

/// Edge of the tags of a field, m: those of FRC since 2024, 6.5 inches, tag36h11. The files have neither.
const FIELD_TAG_M: f64 = 0.1651;
/// The family that `apriltag_ros` has by default; another is stated in another file.
const FAMILY: Family = Family::Tag36h11;

/// The object of a document that lists places of tags; nothing of another document.
pub(super) fn object(document: &Value, id: &ObjectId) -> Option<Result<ObjectModel, Complaint>> {
    let tags = if let Some(bundles) = document.get("tag_bundles").and_then(Value::as_sequence) {
        bundle(bundles).and_then(|bundle| list(bundle, "layout", of_bundle))
    } else if document.get("field").is_some() && document.get("tags").is_some() {
        list(document, "tags", of_field)
    } else {
        return None;
    };
    let object = |tags| {
        ObjectModel::new(id.clone(), tags)
            .map_err(|error| Complaint::new("", error.to_string(), "write metres"))
    };
    Some(tags.and_then(object))
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
    tag: fn(&Value) -> Result<ObjectTag, Complaint>,
) -> Result<Vec<ObjectTag>, Complaint> {
    let tags = parent.get(key).and_then(Value::as_sequence);
    let tags = tags.ok_or_else(|| Complaint::new(key, "this is no list of tags", ""))?;
    let read = tags.iter().enumerate().map(|(index, value)| {
        tag(value).map_err(|complaint| Complaint {
            key: format!("{key}[{index}].{}", complaint.key),
            ..complaint
        })
    });
    read.collect()
}

/// `{id, size, x, y, z, qw, qx, qy, qz}`, with the axes of tags here.
fn of_bundle(value: &Value) -> Result<ObjectTag, Complaint> {
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
        tag_id(value, "id")?,
        number(value, "size")?,
        Some(pose),
    ))
}

/// `{ID, pose: {translation, rotation: {quaternion}}}`. There a tag's x points out of its face and z up, so that y is to the right.
fn of_field(value: &Value) -> Result<ObjectTag, Complaint> {
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
        tag_id(value, "ID")?,
        FIELD_TAG_M,
        Some(field_from_tag),
    ))
}

fn tag_id(value: &Value, key: &str) -> Result<TagId, Complaint> {
    let id = value.get(key).and_then(Value::as_u64);
    let known = id.filter(|id| (*id as usize) < FAMILY.data().codes.len());
    let id = known.ok_or_else(|| Complaint::new(key, format!("{FAMILY} has no such tag"), ""))?;
    Ok(TagId {
        family: FAMILY,
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
