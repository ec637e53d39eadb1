//! Changing the rig and the objects of a running site, and what it answers.

use crate::config::answers::AwaitedAnswer;
use crate::config::get::known_object;
use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::site::{SiteArguments, check_may_change};
use crate::words;
use anyhow::{Context, bail};
use sextant_gateways::site::SiteSession;
use sextant_process::{Exit, Failure, WithExit};
use sextant_proto::{ChangeOutcome, ConfigAnswer, Message, ObjectConfig, RigConfig, encode};
use sextant_site_model::ObjectId;
use sextant_zenoh_bus::Qos;
use std::path::Path;

/// Publishes the rig of a file.
///
/// # Errors
/// A wrong file, no answer, a refusal.
pub fn set_rig(file: &Path, site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let rig = read_rig(file).exit_with(Exit::Input)?;
    let site = site.open()?;
    change(
        &site,
        &site.keys.config_rig(),
        &RigConfig::from(&rig),
        format,
    )
}

/// Publishes the object of a file.
///
/// # Errors
/// A wrong file, no answer, a refusal.
pub fn set_object(file: &Path, site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let object = read_object(file).exit_with(Exit::Input)?;
    let site = site.open()?;
    let key = site.keys.config_object(object.id());
    change(&site, &key, &ObjectConfig::from(&object), format)
}

/// Asks for an object's removal.
///
/// # Errors
/// No such object, no answer, a refusal.
pub fn remove_object(id: &ObjectId, site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let site = site.open()?;
    let known = known_object(&site, id)?;
    let removal = ObjectConfig::removal(known.id().clone());
    change(&site, &site.keys.config_object(id), &removal, format)
}

/// Publishes a change and waits for what becomes of it.
///
/// # Errors
/// No answer, a refusal.
pub fn change<M: Message>(
    site: &SiteSession,
    key: &str,
    message: &M,
    format: Format,
) -> anyhow::Result<()> {
    check_may_change(site)?;
    let payload = encode(message)
        .context("this is more than fits into a message")
        .exit_with(Exit::Input)?;
    let awaited = AwaitedAnswer::expect(site, &payload)?;
    let publisher = site.bus.publisher::<M>(key, Qos::Config)?;
    let publisher = publisher.signed(&signature());
    let answer = awaited.wait(|| Ok(publisher.put(message)?))?;
    print_line(&line_of(&answer, format))?;
    if let ChangeOutcome::Refused(refusal) = &answer.outcome {
        let cause = words::plain(&refusal.to_string());
        bail!(Failure::new(
            Exit::Fault,
            anyhow::anyhow!("{} refused: {cause}; nothing has changed", answer.node)
        ));
    }
    Ok(())
}

/// Who changes the site: what the fusion node's log and status name.
fn signature() -> String {
    let user = std::env::var("USER").unwrap_or_else(|_| "somebody".to_owned());
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let whole = format!("{user}@{}", host.trim());
    sextant_proto::limits::clipped(&words::plain(&whole), 64)
}

fn line_of(answer: &ConfigAnswer, format: Format) -> String {
    match format {
        Format::Json => {
            let (outcome, refusal) = match &answer.outcome {
                ChangeOutcome::Taken => ("taken", None),
                ChangeOutcome::Kept => ("kept", None),
                ChangeOutcome::Same => ("same", None),
                ChangeOutcome::Refused(refusal) => ("refused", Some(refusal)),
            };
            let words = refusal.map_or_else(String::new, ToString::to_string);
            serde_json::json!({
                "node": answer.node, "key": answer.key, "outcome": outcome, "words": words, "refusal": refusal,
                "followers": answer.followers, "behind": answer.behind,
            })
            .to_string()
        }
        Format::Text => {
            let how = words::outcome(&answer.outcome);
            let until = match &answer.outcome {
                ChangeOutcome::Taken => {
                    " until the node ends (`keep_changes` in its file is false)"
                }
                ChangeOutcome::Kept => " in its files",
                ChangeOutcome::Same | ChangeOutcome::Refused(_) => "",
            };
            let key = words::plain(&answer.key);
            let there = format!("{}: {key} {how}{until}", answer.node);
            let followers = answer
                .followers
                .iter()
                .map(|node| format!("{node}: {key} in force"));
            let behind = answer.behind.iter().map(|node| {
                format!("{node}: not yet; it takes {key} over before it publishes anything")
            });
            let lines: Vec<String> = [there].into_iter().chain(followers).chain(behind).collect();
            lines.join("\n")
        }
    }
}
