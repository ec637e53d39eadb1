//! Objects for the tests of conversions.

use nalgebra::Vector3;
use sextant_estimator::{
    Articulation, Joint, JointId, JointKind, LinkId, ObjectId, ObjectModel, ObjectTag, TagId,
};
use sextant_geometry::Pose;
use sextant_tag_families::Family;

/// A tag of 40 mm.
pub fn tag(id: u32) -> ObjectTag {
    ObjectTag {
        tag: TagId {
            family: Family::Tag36h11,
            id,
        },
        size_m: 0.04,
        object_from_tag: Some(Pose::translation(0.0, 0.0, 0.01)),
    }
}

/// A base with tag 3 and a lid with tag 4, which comes first.
pub fn lidded_box() -> ObjectModel {
    let [base, lid] = ["base", "lid"].map(|name| LinkId::new(name).unwrap());
    let hinge = Joint {
        id: JointId::new("hinge").unwrap(),
        kind: JointKind::Revolute,
        parent: base.clone(),
        child: lid.clone(),
        axis: Vector3::y(),
        parent_from_joint: Pose::translation(0.1, 0.0, 0.2),
        limits: Some([0.0, 1.5]),
        max_speed: Some(3.0),
    };
    let tree = Articulation::new(vec![base.clone(), lid.clone()], vec![hinge]).unwrap();
    let tags = vec![(lid, tag(4)), (base, tag(3))];
    ObjectModel::articulated(ObjectId::new("box").unwrap(), tree, tags).unwrap()
}
