//! What an operator wants changed, as `POST /api/zones` brings it.

use super::zone::{MAX_ZONES, Zone, ZonesFile};
use crate::refusal::{Refusal, RefusalKind};
use serde::Deserialize;

/// The longest command.
pub(crate) const MAX_BYTES: usize = 4096;

/// A change.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(crate) enum Command {
    /// Adds a zone, or replaces the one of its name.
    Set {
        zone: Zone,
    },
    Remove {
        name: String,
    },
}

impl Command {
    pub(crate) fn parse(body: &[u8]) -> Result<Self, Refusal> {
        serde_json::from_slice(body).map_err(|error| Refusal {
            kind: RefusalKind::Wrong,
            field: None,
            cause: format!("not a command: {error}"),
        })
    }

    /// The zones after the change.
    pub(super) fn apply(self, zones: &[Zone]) -> Result<ZonesFile, Refusal> {
        let mut zones = zones.to_vec();
        match self {
            Self::Set { zone } => {
                zone.check()
                    .map_err(|fault| Refusal::wrong(fault.field, fault.cause))?;
                match zones.iter().position(|known| known.name() == zone.name()) {
                    Some(known) => zones[known] = zone,
                    None if zones.len() < MAX_ZONES => zones.push(zone),
                    None => {
                        let cause = format!("there are {MAX_ZONES} zones already: remove one");
                        return Err(Refusal::not_now(cause));
                    }
                }
            }
            Self::Remove { name } => {
                let before = zones.len();
                zones.retain(|zone| zone.name() != name);
                if zones.len() == before {
                    return Err(Refusal::wrong("name", "there is no such zone"));
                }
            }
        }
        Ok(ZonesFile { zones })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(text: &str, zones: &[Zone]) -> Result<Vec<Zone>, Refusal> {
        Ok(Command::parse(text.as_bytes())?.apply(zones)?.zones)
    }

    #[test]
    fn zones_are_set_replaced_and_removed_by_name() {
        let set = |radius: f64| {
            format!(
                r#"{{"do":"set","zone":{{"shape":"sphere","name":"ball","centre":[0,0,1],"radius":{radius}}}}}"#
            )
        };
        let one = apply(&set(1.0), &[]).unwrap();
        let other = apply(&set(2.0), &one).unwrap();
        assert_eq!((one.len(), other.len()), (1, 1));
        assert_ne!(one, other);
        assert_eq!(
            apply(r#"{"do":"remove","name":"ball"}"#, &other),
            Ok(vec![])
        );
        assert!(apply(r#"{"do":"remove","name":"ball"}"#, &[]).is_err());
    }

    #[test]
    fn what_is_no_zone_is_refused() {
        for wrong in [
            r#"{"do":"set","zone":{"shape":"cone","name":"a","centre":[0,0,0]}}"#,
            r#"{"do":"set","zone":{"shape":"sphere","name":"a","centre":[0,0,0],"radius":-1}}"#,
            r#"{"do":"set","zone":{"shape":"sphere","name":"a","centre":[0,0,0],"radius":1,"more":2}}"#,
            r#"{"do":"set","zone":{"shape":"box","name":"a b","centre":[0,0,0],"size":[1,1,1]}}"#,
            "[]",
        ] {
            assert!(apply(wrong, &[]).is_err(), "{wrong}");
        }
    }

    #[test]
    fn zones_are_bounded() {
        let set = |n: usize| {
            format!(
                r#"{{"do":"set","zone":{{"shape":"sphere","name":"z{n}","centre":[0,0,1],"radius":1}}}}"#
            )
        };
        let mut zones = Vec::new();
        for n in 0..MAX_ZONES {
            zones = apply(&set(n), &zones).unwrap();
        }
        assert_eq!(
            apply(&set(MAX_ZONES), &zones).unwrap_err().kind,
            RefusalKind::NotNow
        );
        assert!(apply(&set(0), &zones).is_ok());
    }
}
