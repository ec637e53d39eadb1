//! Roles of members as rules of zenoh's access control: who may publish and read what. Others may do nothing.
//!
//! Zenoh checks for each message of a link whether a rule that includes its key allows it, on entry (ingress) and
//! on exit (egress). Reading is restricted by both, writing by ingress.

use serde_json::{Value, json};
use sextant_proto::{Keys, NodeKind};

use super::{Member, Role};

/// How a link proves the identity of its other end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Proof {
    UserName,
    CertificateName,
}

impl Proof {
    fn property(self) -> &'static str {
        match self {
            Self::UserName => "usernames",
            Self::CertificateName => "cert_common_names",
        }
    }
}

/// Permissions of a member, as key expressions.
#[derive(Debug, Default)]
struct Grants {
    /// Publish.
    puts: Vec<String>,
    /// Answer queries of latest values.
    answers: Vec<String>,
    /// Declare as liveliness tokens.
    tokens: Vec<String>,
    /// Subscribe to and query.
    reads: Vec<String>,
}

fn grants(keys: &Keys, member: &Member) -> Grants {
    let everything = keys.everything();
    let root = everything.trim_end_matches("/**");
    let name = &member.name;
    let own = |kind: NodeKind| format!("{root}/{}/{name}/*", kind.as_str());
    let alive = |kind: NodeKind| format!("{root}/alive/{}/{name}", kind.as_str());
    let holder = |kind: NodeKind| format!("{root}/holder/{}/{name}/*/*", kind.as_str());
    match member.role {
        Role::Camera => Grants {
            puts: vec![own(NodeKind::Camera)],
            answers: vec![own(NodeKind::Camera)],
            tokens: vec![alive(NodeKind::Camera), holder(NodeKind::Camera)],
            reads: vec![
                keys.config_rig(),
                keys.all_config_objects(),
                format!("{root}/config/camera/{name}"),
                keys.all_fusion_alive(),
                holder(NodeKind::Camera),
            ],
        },
        Role::Fusion => {
            let own = format!("{root}/fusion/{name}/**");
            Grants {
                puts: vec![own.clone(), format!("{root}/object/*/*"), keys.all_config()],
                answers: vec![own, keys.all_config()],
                tokens: vec![alive(NodeKind::Fusion), holder(NodeKind::Fusion)],
                reads: vec![everything],
            }
        }
        Role::Router => Grants {
            puts: vec![everything.clone()],
            answers: vec![everything.clone()],
            tokens: vec![everything.clone()],
            reads: vec![everything],
        },
        Role::Viewer => Grants {
            puts: vec![own(NodeKind::Viewer)],
            tokens: vec![alive(NodeKind::Viewer)],
            reads: vec![everything],
            ..Grants::default()
        },
        Role::Operator => Grants {
            puts: vec![keys.all_config(), own(NodeKind::Viewer)],
            tokens: vec![alive(NodeKind::Viewer)],
            reads: vec![everything],
            ..Grants::default()
        },
        // A phone has no link of its own; the page publishes for it.
        Role::Phone => Grants::default(),
    }
}

/// Adds to the permissions of a page those of a phone's camera.
fn grant_phone(page: &mut Grants, keys: &Keys, phone: &Member) {
    let camera = Member {
        role: Role::Camera,
        ..phone.clone()
    };
    let Grants {
        puts,
        answers,
        tokens,
        ..
    } = grants(keys, &camera);
    page.puts.extend(puts);
    page.answers.extend(answers);
    page.tokens.extend(tokens);
}

/// Zenoh's section `access_control` for these members.
pub(super) fn access_control<'a>(
    keys: &Keys,
    members: impl Iterator<Item = &'a Member>,
    proof: Proof,
) -> Value {
    let mut rules = vec![hints(keys)];
    let (mut subjects, mut policies) = (Vec::new(), Vec::new());
    let members: Vec<&Member> = members.collect();
    let phones = || members.iter().filter(|member| member.role == Role::Phone);
    for &member in members.iter().filter(|member| member.role != Role::Phone) {
        let mut granted = grants(keys, member);
        if member.role.has_page() {
            phones().for_each(|phone| grant_phone(&mut granted, keys, phone));
        }
        let id = &member.common_name;
        subjects.push(json!({ "id": id, (proof.property()): [id] }));
        let own = rules_of(id, &granted);
        let mut names: Vec<Value> = own.iter().map(|rule| rule["id"].clone()).collect();
        names.push(json!(HINTS));
        policies.push(json!({ "subjects": [id], "rules": names }));
        rules.extend(own);
    }
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    })
}

const HINTS: &str = "hints";

/// Declarations that a router forwards between its links, without which nothing flows: subscriptions, queryables, and
/// queries on their way to those who may answer.
fn hints(keys: &Keys) -> Value {
    let messages = [
        "declare_subscriber",
        "declare_queryable",
        "query",
        "liveliness_query",
        "declare_liveliness_subscriber",
    ];
    rule(HINTS, "egress", &messages, &[keys.everything()])
}

fn rules_of(id: &str, grants: &Grants) -> Vec<Value> {
    let reading = [
        "declare_subscriber",
        "query",
        "declare_liveliness_subscriber",
        "liveliness_query",
    ];
    let rules: [(&str, &str, &[&str], &[String]); 5] = [
        ("publishes", "ingress", &["put"], &grants.puts),
        (
            "answers",
            "ingress",
            &["declare_queryable", "reply"],
            &grants.answers,
        ),
        ("is-alive", "ingress", &["liveliness_token"], &grants.tokens),
        ("asks", "ingress", &reading, &grants.reads),
        (
            "hears",
            "egress",
            &["put", "reply", "liveliness_token"],
            &grants.reads,
        ),
    ];
    let granted = rules.into_iter().filter(|(.., keys)| !keys.is_empty());
    granted
        .map(|(what, flow, messages, keys)| rule(&format!("{id} {what}"), flow, messages, keys))
        .collect()
}

fn rule(id: &str, flow: &str, messages: &[&str], keys: &[String]) -> Value {
    json!({
        "id": id,
        "permission": "allow",
        "flows": [flow],
        "messages": messages,
        "key_exprs": keys,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zenoh::key_expr::KeyExpr;

    fn member(name: &str, role: Role) -> Member {
        Member {
            name: name.parse().unwrap(),
            role,
            common_name: format!("{name}.1"),
            valid_until_s: 0,
            revoked: false,
        }
    }

    fn keys() -> Keys {
        Keys::new("lab").unwrap()
    }

    /// Whether one of the expressions includes a key, as zenoh checks it.
    fn includes(expressions: &[String], key: &str) -> bool {
        let key = KeyExpr::new(format!("sextant/v1/lab/{key}")).unwrap();
        let mut expressions = expressions.iter();
        expressions.any(|one| KeyExpr::new(one.clone()).unwrap().includes(&key))
    }

    #[test]
    fn a_role_publishes_what_its_work_needs_and_nothing_else() {
        for (role, allowed, denied) in [
            (
                Role::Camera,
                &[
                    "camera/a/observations",
                    "camera/a/status",
                    "camera/a/preview",
                ][..],
                &[
                    "camera/b/observations",
                    "camera/aa/status",
                    "camera/*/status",
                    "config/rig",
                    "config/camera/a",
                    "object/box/pose",
                    "fusion/a/status",
                ][..],
            ),
            (
                Role::Fusion,
                &[
                    "fusion/a/former/object/box",
                    "object/box/pose",
                    "config/rig",
                ],
                &["camera/a/observations", "fusion/b/status"],
            ),
            (Role::Router, &["camera/b/observations", "config/rig"], &[]),
            (
                Role::Viewer,
                &["viewer/a/events"],
                &[
                    "config/rig",
                    "config/camera/a",
                    "camera/a/status",
                    "viewer/b/events",
                    "**",
                ],
            ),
            (
                Role::Operator,
                &["config/rig", "config/camera/a"],
                &["object/box/pose", "fusion/a/status", "camera/a/status"],
            ),
        ] {
            let puts = grants(&keys(), &member("a", role)).puts;
            for key in allowed {
                assert!(includes(&puts, key), "{role} {key}");
            }
            for key in denied {
                assert!(!includes(&puts, key), "{role} {key}");
            }
        }
    }

    #[test]
    fn a_camera_reads_the_models_and_its_own_settings() {
        let reads = grants(&keys(), &member("a", Role::Camera)).reads;
        for own in ["config/rig", "config/object/box", "config/camera/a"] {
            assert!(includes(&reads, own), "{own}");
        }
        for foreign in ["config/camera/b", "config/**", "object/box/pose"] {
            assert!(!includes(&reads, foreign), "{foreign}");
        }
    }

    #[test]
    fn a_name_is_held_by_its_owner_only() {
        let tokens = grants(&keys(), &member("a", Role::Camera)).tokens;
        assert!(includes(&tokens, "alive/camera/a"));
        assert!(includes(&tokens, "holder/camera/a/7f/desk"));
        for foreign in [
            "alive/camera/b",
            "alive/fusion/a",
            "holder/camera/b/7f/desk",
        ] {
            assert!(!includes(&tokens, foreign), "{foreign}");
        }
    }

    #[test]
    fn pages_publish_for_phones_and_for_no_other_camera() {
        let mut page = grants(&keys(), &member("desk", Role::Viewer));
        grant_phone(&mut page, &keys(), &member("pocket", Role::Phone));
        assert!(includes(&page.puts, "camera/pocket/observations"));
        assert!(includes(&page.tokens, "alive/camera/pocket"));
        assert!(!includes(&page.puts, "camera/north/observations"));
        assert!(!includes(&page.puts, "config/rig"));
        let members = [member("desk", Role::Viewer), member("pocket", Role::Phone)];
        let rules = access_control(&keys(), members.iter(), Proof::UserName);
        let subjects = rules["subjects"].as_array().unwrap();
        assert_eq!(subjects.len(), 1, "a phone has no link of its own: {rules}");
    }

    #[test]
    fn zenoh_takes_the_rules_and_revoked_members_are_in_none() {
        let mut members = Role::ALL.map(|role| member(role.name(), role));
        members[0].revoked = true;
        let accepted = members.iter().filter(|member| !member.revoked);
        let rules = access_control(&keys(), accepted, Proof::CertificateName).to_string();
        assert!(!rules.contains("camera.1"), "{rules}");
        let mut config = zenoh::Config::default();
        config.insert_json5("access_control", &rules).unwrap();
    }
}
