//! Trees and what is none.

use super::*;

fn link(name: &str) -> LinkId {
    LinkId::new(name).unwrap()
}

fn joint(name: &str, parent: &str, child: &str) -> Joint {
    Joint {
        id: JointId::new(name).unwrap(),
        kind: JointKind::Revolute,
        parent: link(parent),
        child: link(child),
        axis: Vector3::z(),
        parent_from_joint: Pose::translation(0.1, 0.0, 0.0),
        limits: Some([-1.0, 2.0]),
        max_speed: Some(3.0),
    }
}

fn links() -> Vec<LinkId> {
    ["base", "upper", "fore"].map(link).to_vec()
}

fn joints() -> Vec<Joint> {
    vec![
        joint("elbow", "upper", "fore"),
        joint("shoulder", "base", "upper"),
    ]
}

#[test]
fn a_tree_is_taken_in_any_order_and_knows_its_base() {
    let tree = Articulation::new(links(), joints()).unwrap();
    assert_eq!(tree.base(), 0);
    assert_eq!((tree.joint_of(1), tree.joint_of(2)), (Some(1), Some(0)));
    assert_eq!(tree.parent_of(0), Some(1));
}

#[test]
fn a_revolute_joint_turns_about_its_origin_and_a_prismatic_one_slides() {
    let point = nalgebra::Point3::new(1.0, 0.0, 0.0);
    let turning = joint("a", "base", "upper");
    let turned = turning.parent_from_child(std::f64::consts::FRAC_PI_2) * point;
    assert!((turned.coords - Vector3::new(0.1, 1.0, 0.0)).norm() < 1e-12);
    let sliding = Joint {
        kind: JointKind::Prismatic,
        ..turning
    };
    let slid = sliding.parent_from_child(0.2) * point;
    assert!((slid.coords - Vector3::new(1.1, 0.0, 0.2)).norm() < 1e-12);
}

#[test]
fn an_almost_unit_axis_is_normalised() {
    let mut joints = joints();
    joints[0].axis = Vector3::new(0.0, 0.6001, 0.8);
    let tree = Articulation::new(links(), joints).unwrap();
    assert!((tree.joints()[0].axis.norm() - 1.0).abs() < 1e-15);
}

#[test]
fn what_is_no_tree_is_refused() {
    let refused = |joints: Vec<Joint>| Articulation::new(links(), joints).unwrap_err();
    let two = |second: Joint| vec![joint("shoulder", "base", "upper"), second];
    let elbow = JointId::new("elbow").unwrap();
    assert_eq!(
        refused(two(joint("shoulder", "upper", "fore"))).to_string(),
        "joint shoulder is there twice"
    );
    assert_eq!(
        refused(two(joint("elbow", "base", "upper"))),
        ArticulationError::TwoParents {
            joint: elbow.clone(),
            link: link("upper")
        }
    );
    assert_eq!(
        refused(two(joint("elbow", "fore", "fore"))),
        ArticulationError::Ring(elbow.clone())
    );
    let ring = vec![joint("a", "upper", "fore"), joint("b", "fore", "upper")];
    assert!(matches!(refused(ring), ArticulationError::Ring(_)));
    assert_eq!(
        refused(vec![joint("shoulder", "base", "upper")]),
        ArticulationError::Loose {
            link: link("fore"),
            base: link("base")
        }
    );
    assert_eq!(
        refused(two(joint("elbow", "hand", "fore"))),
        ArticulationError::UnknownLink {
            joint: elbow,
            link: link("hand")
        }
    );
    assert_eq!(
        Articulation::new(Vec::new(), Vec::new()),
        Err(ArticulationError::Links(0))
    );
}

#[test]
fn numbers_that_mean_nothing_are_refused() {
    let refused = |change: fn(&mut Joint)| {
        let mut joints = joints();
        change(&mut joints[0]);
        Articulation::new(links(), joints).unwrap_err().to_string()
    };
    assert!(refused(|joint| joint.axis.z = 2.0).contains("has length 2, not 1"));
    assert!(refused(|joint| joint.axis.z = f64::NAN).contains("has length NaN"));
    assert!(refused(|joint| joint.limits = Some([1.0, 1.0])).contains("1 to 1"));
    assert!(refused(|joint| joint.limits = Some([f64::NAN, 1.0])).contains("NaN to 1"));
    assert!(refused(|joint| joint.max_speed = Some(0.0)).contains("is 0; it must"));
    assert!(
        refused(|joint| joint.parent_from_joint.translation.x = f64::INFINITY)
            .contains("origin of joint elbow")
    );
}
