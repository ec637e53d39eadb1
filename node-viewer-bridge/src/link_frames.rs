//! Objects that have links, as clients see them: each link as an object of its own, named `<object>.<link>`, and the
//! joints. So a page that knows of no links draws them all the same.

use crate::message::{Joint, Pose};
use crate::models::{ObjectTag, object_tag};
use crate::translate::latency_ms;
use sextant_proto::{JointState, LinkPose, ObjectConfig, ObjectLinks};

/// A link with its tags.
pub(crate) struct Part {
    pub(crate) id: String,
    pub(crate) tags: Vec<ObjectTag>,
}

/// Every link with its tags.
pub(crate) fn parts(object: &ObjectConfig) -> Vec<Part> {
    let tags_of = |link: usize| {
        let tags = object.tags.iter();
        let tags = tags.filter(move |tag| tag.link.map(usize::from) == Some(link));
        tags.map(object_tag).collect()
    };
    let links = object.links.iter().enumerate();
    links
        .map(|(index, link)| Part {
            id: format!("{}.{link}", object.id),
            tags: tags_of(index),
        })
        .collect()
}

/// The name under which clients know a link.
pub(crate) fn id_of(links: &ObjectLinks, link: &LinkPose) -> String {
    format!("{}.{}", links.object, link.link)
}

/// A link's pose under such a name. Only the object's own pose has twist, cameras and tags.
pub(crate) fn pose<'a>(id: &'a str, links: &ObjectLinks, link: &'a LinkPose) -> Pose<'a> {
    Pose {
        object: id,
        sequence: links.sequence,
        t_ns: links.capture_ns,
        position: link.position,
        orientation: link.orientation,
        covariance: &link.covariance,
        twist: [0.0; 6],
        state: links.state,
        cameras: 0,
        tags: 0,
        rms_px: 0.0,
        latency_ms: latency_ms(links.capture_ns, links.published_ns),
    }
}

/// A joint as clients see it.
pub(crate) fn joint(joint: &JointState) -> Joint<'_> {
    Joint {
        joint: &joint.joint,
        value: joint.value,
        sigma: joint.variance.sqrt(),
        velocity: joint.velocity,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Message;
    use sextant_site_model::{JointId, LinkId, ObjectId};
    use sextant_site_report::State;

    #[test]
    fn a_link_is_an_object_of_its_own_to_clients() {
        let links = ObjectLinks {
            object: ObjectId::new("arm").unwrap(),
            epoch: 1,
            sequence: 3,
            capture_ns: 1_000_000,
            published_ns: 3_000_000,
            state: State::Tracking,
            links: vec![LinkPose {
                link: LinkId::new("upper").unwrap(),
                position: [1.0, 2.0, 3.0],
                orientation: [0.0, 0.0, 0.0, 1.0],
                covariance: [0.0; 36],
            }],
            joints: vec![JointState {
                joint: JointId::new("elbow").unwrap(),
                value: 0.5,
                variance: 0.04,
                velocity: 1.0,
                velocity_variance: 1.0,
            }],
        };
        let id = id_of(&links, &links.links[0]);
        let message = Message::Pose(pose(&id, &links, &links.links[0]));
        let json = serde_json::to_value(message).unwrap();
        assert_eq!(
            (&json["type"], &json["object"]),
            (&"pose".into(), &"arm.upper".into())
        );
        assert_eq!(json["latency_ms"], 2.0);
        let json = serde_json::to_value(joint(&links.joints[0])).unwrap();
        assert_eq!(
            (&json["joint"], &json["sigma"]),
            (&"elbow".into(), &0.2.into())
        );
    }
}
