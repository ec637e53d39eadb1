//! `[[link]]` and `[[joint]]` of `object.toml`, read and written.

use crate::document::Document;
use crate::error::Complaint;
use crate::pose::{pose_of, pose_toml};
use serde::Deserialize;
use sextant_geometry::{Pose, PoseParts};
use sextant_site_model::{Articulation, ArticulationError, Joint, JointId, JointKind, LinkId};
use std::fmt::Write as _;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LinkTable {
    id: LinkId,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointTable {
    id: JointId,
    kind: JointKind,
    parent: LinkId,
    child: LinkId,
    /// Required unless the joint is fixed.
    axis: Option<[f64; 3]>,
    /// Omitted if the joint is at the parent's origin.
    origin: Option<PoseParts>,
    /// Radians or metres.
    limits: Option<[f64; 2]>,
    /// Radians or metres per second.
    max_speed: Option<f64>,
}

/// The links and joints of a file; `None` without any.
pub(super) fn articulation_of(
    links: &[LinkTable],
    joints: &[JointTable],
    document: &Document<'_>,
) -> Result<Option<Articulation>, Complaint> {
    if links.is_empty() {
        return match joints {
            [] => Ok(None),
            _ => Err(Complaint::new(
                "joint[0]",
                "a joint needs links",
                "add a [[link]] table with an id for each link, or remove the joints",
            )),
        };
    }
    unique(links.iter().map(|link| link.id.as_str()), "link", document)?;
    unique(
        joints.iter().map(|joint| joint.id.as_str()),
        "joint",
        document,
    )?;
    let written = joints.iter().enumerate();
    let parsed: Result<Vec<Joint>, Complaint> = written
        .map(|(index, joint)| joint_of(index, joint))
        .collect();
    let ids = links.iter().map(|link| link.id.clone()).collect();
    let articulation = Articulation::new(ids, parsed?);
    articulation
        .map(Some)
        .map_err(|error| complaint(&error, links, joints))
}

fn unique<'a>(
    ids: impl Iterator<Item = &'a str>,
    table: &str,
    document: &Document<'_>,
) -> Result<(), Complaint> {
    let mut earlier: Vec<&str> = Vec::new();
    for (index, id) in ids.enumerate() {
        if let Some(first) = earlier.iter().position(|known| *known == id) {
            let line = document.line_of(&format!("{table}[{first}].id"));
            let cause = format!("{id} is there already, on line {}", line.unwrap_or(0));
            let remedy = format!("each {table} needs a name of its own");
            return Err(Complaint::new(
                format!("{table}[{index}].id"),
                cause,
                remedy,
            ));
        }
        earlier.push(id);
    }
    Ok(())
}

fn joint_of(index: usize, table: &JointTable) -> Result<Joint, Complaint> {
    let key = format!("joint[{index}]");
    if table.axis.is_none() && table.kind != JointKind::Fixed {
        let remedy = "add `axis = [x, y, z]` of length 1, in the joint's frame";
        return Err(Complaint::new(
            key,
            "a joint that moves needs an axis",
            remedy,
        ));
    }
    let origin = pose_of(table.origin.as_ref(), &format!("{key}.origin"))?;
    Ok(Joint {
        id: table.id.clone(),
        kind: table.kind,
        parent: table.parent.clone(),
        child: table.child.clone(),
        axis: table.axis.unwrap_or([0.0, 0.0, 1.0]).into(),
        parent_from_joint: origin.unwrap_or_else(Pose::identity),
        limits: table.limits,
        max_speed: table.max_speed,
    })
}

/// The site model's rules, with the location in the file.
fn complaint(error: &ArticulationError, links: &[LinkTable], joints: &[JointTable]) -> Complaint {
    let at = |id: &JointId| joints.iter().position(|joint| joint.id == *id);
    let joint = error.joint().and_then(at).unwrap_or(0);
    let at_joint = |part: &str| format!("joint[{joint}]{part}");
    let (key, remedy) = match error {
        ArticulationError::UnknownLink { link, .. } => {
            let names_parent = joints.get(joint).is_some_and(|one| one.parent == *link);
            let part = if names_parent { ".parent" } else { ".child" };
            (at_joint(part), "name one of the [[link]] tables")
        }
        ArticulationError::TwoParents { .. } => (
            at_joint(".child"),
            "a link may be the child of one joint only",
        ),
        ArticulationError::Ring(_) => (at_joint(".child"), "remove the joint that closes the ring"),
        ArticulationError::Axis { .. } => (
            at_joint(".axis"),
            "write a direction of length 1, such as [0, 0, 1]",
        ),
        ArticulationError::Limits { .. } => (
            at_joint(".limits"),
            "write [lowest, highest] in rad or m, or leave them out",
        ),
        ArticulationError::Speed { .. } => (
            at_joint(".max_speed"),
            "write rad/s or m/s above 0, or leave it out",
        ),
        ArticulationError::Loose { link, .. } => {
            let at = links.iter().position(|one| one.id == *link).unwrap_or(0);
            (
                format!("link[{at}].id"),
                "add a [[joint]] whose child it is; kind = \"fixed\" where nothing moves",
            )
        }
        _ => (at_joint(""), "make several objects of it"),
    };
    Complaint::new(key, error.to_string(), remedy)
}

/// The tables of links and joints.
pub(super) fn articulation_toml(articulation: &Articulation) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    for link in articulation.links() {
        let _ = write!(text, "\n[[link]]\nid = \"{link}\"\n");
    }
    for joint in articulation.joints() {
        let _ = write!(
            text,
            "\n[[joint]]\nid = \"{}\"\nkind = \"{}\"\nparent = \"{}\"\nchild = \"{}\"\n",
            joint.id,
            kind_name(joint.kind),
            joint.parent,
            joint.child
        );
        if joint.moves() {
            let axis: [f64; 3] = joint.axis.into();
            let _ = writeln!(text, "axis = {axis:?}");
        }
        let origin = pose_toml(&(&joint.parent_from_joint).into());
        let _ = writeln!(text, "origin = {origin}");
        if let Some(limits) = joint.limits {
            let _ = writeln!(text, "limits = {limits:?}");
        }
        if let Some(speed) = joint.max_speed {
            let _ = writeln!(text, "max_speed = {speed:?}");
        }
    }
    text
}

fn kind_name(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
        JointKind::Fixed => "fixed",
    }
}

#[cfg(test)]
mod tests {
    use super::super::{object_toml, parse_object};
    use sextant_site_model::ObjectModel;
    use std::path::Path;

    const ARM: &str = r#"
id = "arm"
[[link]]
id = "base"
[[link]]
id = "upper"
[[joint]]
id = "shoulder"
kind = "revolute"
parent = "base"
child = "upper"
axis = [0, 0.6, 0.8]
origin = { position = [0, 0, 0.1], orientation = [0, 0, 0, 1] }
limits = [-1.5, 1.25]
max_speed = 4
[[tag]]
family = "tag36h11"
id = 3
size = 0.04
link = "base"
link_from_tag = { position = [0, 0, 0.03], orientation = [0, 0, 0, 1] }
[[tag]]
family = "tag36h11"
id = 4
size = 0.04
link = "upper"
"#;

    fn parsed(text: &str) -> Result<ObjectModel, String> {
        parse_object(Path::new("arm.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn links_joints_and_the_links_of_tags_are_read() {
        let arm = parsed(ARM).unwrap();
        let tree = arm.articulation().unwrap();
        assert_eq!(tree.links().len(), 2);
        assert_eq!(tree.joints()[0].limits, Some([-1.5, 1.25]));
        let links = arm.tags().iter().map(|tag| arm.link_of(tag));
        assert!(links.eq([Some(0), Some(1)]));
        assert!(arm.tags()[0].object_from_tag.is_some());
        assert_eq!(arm.tags()[1].object_from_tag, None);
    }

    #[test]
    fn an_arm_that_is_written_is_read_back_exactly() {
        let arm = parsed(ARM).unwrap();
        assert_eq!(parsed(&object_toml(&arm)).unwrap(), arm);
    }

    #[test]
    fn wrong_arms_are_refused_with_line_key_and_remedy() {
        let fixed = "\n[[joint]]\nid = \"second\"\nkind = \"fixed\"\nparent = \"base\"\n\
            child = \"upper\"\n[[tag]]\nfamily = \"tag36h11\"\nid = 3";
        for (from, to, expected) in [
            (
                "id = \"upper\"",
                "id = \"base\"",
                "arm.toml:6:6: link[1].id: base is there already, on line 4; each link needs",
            ),
            (
                "parent = \"base\"",
                "parent = \"bsae\"",
                "arm.toml:10:10: joint[0].parent: joint shoulder joins link bsae, which is not there; name one of",
            ),
            (
                "child = \"upper\"",
                "child = \"base\"",
                "arm.toml:11:9: joint[0].child: joint shoulder closes a ring",
            ),
            (
                "\n[[tag]]\nfamily = \"tag36h11\"\nid = 3",
                fixed,
                "arm.toml:20:9: joint[1].child: joint second moves link upper, which another joint moves already",
            ),
            (
                "[[joint]]",
                "[[link]]\nid = \"hand\"\n[[joint]]",
                "arm.toml:8:6: link[2].id: link hand hangs on no joint, and the base is base already; add a [[joint]]",
            ),
            (
                "[0, 0.6, 0.8]",
                "[0, 1, 1]",
                "arm.toml:12:8: joint[0].axis: the axis of joint shoulder has length 1.414",
            ),
            (
                "axis = [0, 0.6, 0.8]\n",
                "",
                "arm.toml:7:1: joint[0]: a joint that moves needs an axis; add `axis",
            ),
            (
                "[-1.5, 1.25]",
                "[1.5, -1.5]",
                "arm.toml:14:10: joint[0].limits: the limits of joint shoulder are 1.5 to -1.5",
            ),
            (
                "[-1.5, 1.25]",
                "[nan, 1.5]",
                "write [lowest, highest] in rad or m",
            ),
            (
                "max_speed = 4",
                "max_speed = -4",
                "arm.toml:15:13: joint[0].max_speed: the highest speed",
            ),
            ("revolute", "revolut", "did you mean `revolute`?"),
            (
                "link = \"upper\"",
                "link = \"uper\"",
                "arm.toml:26:8: tag[1].link: the object has no link uper; name one of the [[link]] tables",
            ),
            (
                "link = \"upper\"\n",
                "",
                "arm.toml:22:1: tag[1]: the object has links, and this tag names none; add `link = ",
            ),
            (
                "link_from_tag",
                "object_from_tag",
                "arm.toml:21:19: tag[0].object_from_tag: the tag sits on a link; write `link_from_tag`",
            ),
            (
                "[0, 0, 0.03]",
                "[0, inf, 0.03]",
                "arm.toml:21:30: tag[0].link_from_tag.position: ",
            ),
            (
                "\n[[link]]\nid = \"base\"\n[[link]]\nid = \"upper\"",
                "",
                "joint[0]: a joint needs links; add a [[link]] table",
            ),
        ] {
            assert!(ARM.contains(from), "{from}");
            let message = parsed(&ARM.replacen(from, to, 1)).unwrap_err();
            assert!(message.contains(expected), "{from} -> {to}: {message}");
        }
    }

    #[test]
    fn a_tag_of_a_rigid_object_names_no_link() {
        let rigid = "id = \"a\"\n[[tag]]\nfamily = \"tag36h11\"\nid = 0\nsize = 0.1\n";
        let message = parsed(&format!("{rigid}link = \"base\"\n")).unwrap_err();
        assert!(
            message.contains("tag[0].link: the object has no links; add"),
            "{message}"
        );
        let message = parsed(&format!(
            "{rigid}link_from_tag = {{ position = [0, 0, 0], orientation = [0, 0, 0, 1] }}\n"
        ))
        .unwrap_err();
        assert!(
            message.contains("tag[0].link_from_tag: the object has no links"),
            "{message}"
        );
    }
}
