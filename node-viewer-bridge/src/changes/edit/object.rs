//! Edits of an object and its tags.

use super::requests::{ObjectEdit, Removal, TagEdit};
use super::{check_pose, parse, version};
use crate::changes::Outgoing;
use crate::refusal::Refusal;
use sextant_proto::{
    EncodeError, ModelPayload, NodeKind, ObjectConfig, ObjectTagConfig, Proposal, RigConfig,
};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{LinkId, ObjectId, ObjectModel};
use sextant_tag_families::Family;

/// The edited object; with another name also the removal of the former one, and the rig where the object carries
/// cameras.
pub(super) fn edit(edit: &ObjectEdit, site: &SiteMirror) -> Result<Outgoing, Refusal> {
    let before = match &edit.object {
        Some(id) => Some(known(
            id,
            edit.version.as_deref().unwrap_or_default(),
            site,
        )?),
        None => None,
    };
    let id: ObjectId = parse("id", &edit.id)?;
    let is_renamed = before.is_none_or(|before| before.id != id);
    if is_renamed && site.configs().any(|object| object.id == id) {
        let cause = format!("the site has an object {id} already: choose another name");
        return Err(Refusal::wrong("id", cause));
    }
    let mut after = before
        .cloned()
        .unwrap_or_else(|| ObjectConfig::removal(id.clone()));
    after.id = id;
    replace_tags(&mut after, edit)?;
    if before.is_none_or(|before| before.world_from_object.is_some()) {
        after.world_from_object = edit.place;
    }
    if let Some(place) = &edit.place {
        check_pose(place, &format!("object {}", after.id))
            .map_err(|refusal| Refusal::wrong("place", refusal.cause))?;
    }
    ObjectModel::try_from(&after).map_err(|error| Refusal::wrong("tags", error))?;
    match before.filter(|before| before.id != after.id) {
        Some(before) => renamed(&before.id, &after, site),
        None => Ok(Outgoing::Object(after)),
    }
}

/// The removal of an object.
pub(super) fn remove(removal: &Removal, site: &SiteMirror) -> Result<Outgoing, Refusal> {
    let object = known(&removal.id, &removal.version, site)?;
    Ok(Outgoing::Object(ObjectConfig::removal(object.id.clone())))
}

fn known<'a>(id: &str, begun: &str, site: &'a SiteMirror) -> Result<&'a ObjectConfig, Refusal> {
    let id: ObjectId = parse("object", id)?;
    let object = site.configs().find(|object| object.id == id);
    let Some(object) = object else {
        return Err(Refusal::not_now(format!(
            "the site has no object {id} any more"
        )));
    };
    let in_force = version::version_of(object);
    version::check(begun, &in_force, &format!("object {id}"))?;
    Ok(object)
}

/// All tags, or those of the link that is edited.
fn replace_tags(object: &mut ObjectConfig, edit: &ObjectEdit) -> Result<(), Refusal> {
    if edit.tags.is_empty() && (edit.link.is_none() || object.tags.is_empty()) {
        let cause = "an object has at least one tag: remove the object instead";
        return Err(Refusal::wrong("tags", cause));
    }
    let link = match &edit.link {
        Some(link) => Some(link_of(object, link)?),
        None if object.links.is_empty() => None,
        None => {
            return Err(Refusal::wrong(
                "tags",
                "name the link that these tags are on",
            ));
        }
    };
    let tags = edit.tags.iter().map(|tag| tag_of(tag, link));
    let tags: Vec<ObjectTagConfig> = tags.collect::<Result<_, _>>()?;
    object.tags.retain(|tag| link.is_some() && tag.link != link);
    object.tags.extend(tags);
    if object.tags.is_empty() {
        let cause = "an object has at least one tag: remove the object instead";
        return Err(Refusal::wrong("tags", cause));
    }
    Ok(())
}

fn link_of(object: &ObjectConfig, link: &str) -> Result<u8, Refusal> {
    let link: LinkId = parse("link", link)?;
    let index = object.links.iter().position(|known| *known == link);
    let index = index.and_then(|index| u8::try_from(index).ok());
    index.ok_or_else(|| Refusal::wrong("link", format!("object {} has no link {link}", object.id)))
}

fn tag_of(edit: &TagEdit, link: Option<u8>) -> Result<ObjectTagConfig, Refusal> {
    let family: Family = parse("tags", &edit.family)?;
    let what = format!("tag {family}:{}", edit.id);
    let n_codes = family.data().codes.len();
    if edit.id as usize >= n_codes {
        let last = n_codes.saturating_sub(1);
        let cause = format!("{what}: the tags of {family} are 0 to {last}");
        return Err(Refusal::wrong("tags", cause));
    }
    if let Some(pose) = &edit.pose {
        check_pose(pose, &what).map_err(|refusal| Refusal::wrong("tags", refusal.cause))?;
    }
    Ok(ObjectTagConfig {
        family,
        id: edit.id,
        size_m: edit.size_m,
        size_sigma_m: edit.size_sigma_m,
        link,
        object_from_tag: edit.pose,
        object_from_tag_sigma: edit.sigma,
    })
}

/// The change that gives an object another name, also where cameras on it name their carrier.
fn renamed(
    before: &ObjectId,
    after: &ObjectConfig,
    site: &SiteMirror,
) -> Result<Outgoing, Refusal> {
    let node = site.alive(NodeKind::Fusion).next().map(|(node, _)| node);
    let node = node.ok_or_else(|| Refusal::not_now("no fusion node runs that could apply it"))?;
    let rig = site
        .rig()
        .and_then(|rig| with_carrier(rig, before, &after.id));
    let rig = rig.map(|rig| ModelPayload::encode(&rig)).transpose();
    let objects = [ObjectConfig::removal(before.clone()), after.clone()];
    let objects: Result<_, _> = objects.iter().map(ModelPayload::encode).collect();
    let too_large = |error: EncodeError| Refusal::wrong("tags", error);
    Ok(Outgoing::Models(Proposal {
        rig: rig.map_err(too_large)?,
        objects: objects.map_err(too_large)?,
        ..Proposal::none(node.clone(), 0)
    }))
}

/// The rig whose cameras are carried by the object of another name; none where it carries none.
fn with_carrier(rig: &RigConfig, before: &ObjectId, after: &ObjectId) -> Option<RigConfig> {
    let mut rig = rig.clone();
    let mounts = rig
        .cameras
        .iter_mut()
        .filter_map(|camera| camera.mount.as_mut());
    let mounts = mounts.filter(|mount| mount.carrier == *before);
    let n_carried = mounts.map(|mount| mount.carrier = after.clone()).count();
    (n_carried > 0).then_some(rig)
}
