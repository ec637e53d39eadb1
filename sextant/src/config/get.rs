//! What a running site works from, as files.

use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use anyhow::{anyhow, bail};
use sextant_gateways::site::SiteSession;
use sextant_process::{Exit, Failure};
use sextant_proto::{ObjectConfig, RigConfig};
use sextant_site_files::{object_toml, rig_toml};
use sextant_site_model::{ObjectId, ObjectModel, Rig};

/// Prints the rig in force.
///
/// # Errors
/// A site without a rig, or one that makes no sense.
pub fn rig(site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let site = site.open()?;
    let found: Vec<RigConfig> = site.latest(&site.keys.config_rig())?;
    let Some(message) = found.first() else {
        bail!(Failure::new(Exit::Unavailable, nobody(&site)))
    };
    let text = rig_toml(&Rig::try_from(message)?);
    print("rig", &text, format)?;
    site.bus.close();
    Ok(())
}

/// Prints an object in force.
///
/// # Errors
/// No such object, or one that makes no sense.
pub fn object(id: &ObjectId, site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let site = site.open()?;
    let text = object_toml(&known_object(&site, id)?);
    print("object", &text, format)?;
    site.bus.close();
    Ok(())
}

/// The object of that name, rigid or of links.
///
/// # Errors
/// There is none, or no node answers.
pub fn known_object(site: &SiteSession, id: &ObjectId) -> anyhow::Result<ObjectModel> {
    let mut objects = Vec::new();
    for message in site.latest::<ObjectConfig>(&site.keys.all_config_objects())? {
        objects.push(ObjectModel::try_from(&message)?);
    }
    if let Some(found) = objects.iter().position(|object| object.id() == id) {
        return Ok(objects.swap_remove(found));
    }
    if objects.is_empty()
        && site
            .latest::<RigConfig>(&site.keys.config_rig())?
            .is_empty()
    {
        bail!(Failure::new(Exit::Unavailable, nobody(site)))
    }
    let names = objects.iter().map(|object| object.id().to_string());
    let names = names.collect::<Vec<_>>().join(", ");
    let names = if names.is_empty() {
        "none".to_owned()
    } else {
        names
    };
    bail!(
        "no object {id} on site {}; it has: {names}",
        site.keys.site()
    )
}

/// Nobody answers for the site.
pub fn nobody(site: &SiteSession) -> anyhow::Error {
    anyhow!(
        "no fusion node answers on site {}; start one (`sextant fusion`) or name the site with --site",
        site.keys.site()
    )
}

fn print(kind: &str, text: &str, format: Format) -> anyhow::Result<()> {
    match format {
        Format::Text => print_line(text.trim_end())?,
        Format::Json => {
            print_line(&serde_json::json!({"kind": kind, "toml": text}).to_string())?;
        }
    }
    Ok(())
}
