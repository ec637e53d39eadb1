//! Names that one process of a site holds at a time, by tokens whose keys contain session and host of the holder.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::liveliness::{AliveToken, AliveWatch, Presence};
use crate::{Bus, BusError};

/// Time beyond a link's lease before a taken name is refused: the holder may have died with its host.
const MARGIN: Duration = Duration::from_secs(1);
/// Retry interval, and its variation between processes, which separates two that start at the same time.
const RETRY: Duration = Duration::from_millis(100);

/// Most other holders of one name.
const MOST_OTHERS: usize = 16;

/// A name of the site, held by this process until dropped.
#[derive(Debug)]
pub struct HeldName {
    _token: AliveToken,
    watch: AliveWatch,
    own: String,
    /// Hosts of other holders, by key: the network was partitioned when they took the name, or they are being refused.
    others: BTreeMap<String, String>,
}

impl HeldName {
    /// Hosts of other processes that hold the same name now, which is possible only if the network was partitioned when
    /// they took it.
    pub fn others(&mut self) -> Vec<&str> {
        while let Some(change) = self.watch.try_recv() {
            note(&mut self.others, &self.own, change);
        }
        self.others.values().map(String::as_str).collect()
    }
}

/// Records that a process took or released a name.
fn note(others: &mut BTreeMap<String, String>, own: &str, change: Presence) {
    match change {
        Presence::Joined(key) if key != own && others.len() < MOST_OTHERS => {
            let host = host_of(&key).to_owned();
            others.insert(key, host);
        }
        Presence::Joined(_) => {}
        Presence::Left(key) => drop(others.remove(&key)),
    }
}

impl Bus {
    /// Takes the name of `key` for this process on the host `host`. While another process holds it, waits
    /// a little longer than a dead link's lease; `None` when `stop` returns true meanwhile.
    ///
    /// A name is taken by declaring a token and then querying those of others. Of two simultaneous attempts at least
    /// one sees the other; it withdraws and tries again.
    ///
    /// # Errors
    /// [`BusError::NameTaken`] with the host of the other holder.
    pub fn hold_name(
        &self,
        key: &str,
        host: &str,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<HeldName>, BusError> {
        let session = self.session()?.zid();
        let own = format!("{key}/{session}/{}", as_chunk(host));
        let retry = RETRY + RETRY * u32::from(session.to_le_bytes()[0]) / 256;
        let deadline = Instant::now() + self.lease() + MARGIN;
        loop {
            let token = self.alive(&own)?;
            let others = self.alive_keys(&format!("{key}/*/*"))?;
            let Some(other) = others.into_iter().find(|other| *other != own) else {
                return Ok(Some(HeldName {
                    _token: token,
                    watch: self.watch_alive(&format!("{key}/*/*"))?,
                    own,
                    others: BTreeMap::new(),
                }));
            };
            drop(token);
            if Instant::now() >= deadline {
                return Err(BusError::NameTaken {
                    name: name_of(key),
                    host: host_of(&other).to_owned(),
                });
            }
            if stop() {
                return Ok(None);
            }
            std::thread::sleep(retry);
        }
    }
}

/// A host name as a chunk of a key, which must not contain `/`, `*`, `$`, `?` or `#`.
fn as_chunk(host: &str) -> String {
    let allowed =
        |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '.' | '_');
    let chunk: String = host
        .chars()
        .map(|letter| if allowed(letter) { letter } else { '_' })
        .collect();
    if chunk.is_empty() {
        "unknown".to_owned()
    } else {
        chunk
    }
}

fn host_of(token: &str) -> &str {
    token.rsplit('/').next().unwrap_or_default()
}

/// The last two chunks of the key, as in "camera north".
fn name_of(key: &str) -> String {
    let mut chunks: Vec<&str> = key.rsplit('/').take(2).collect();
    chunks.reverse();
    chunks.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_host_name_is_a_chunk_of_a_key() {
        for (host, chunk) in [
            ("desk-1.lan", "desk-1.lan"),
            ("a/*$?#b", "a_____b"),
            ("", "unknown"),
        ] {
            assert_eq!(as_chunk(host), chunk);
            zenoh::key_expr::KeyExpr::new(chunk).unwrap();
        }
    }

    #[test]
    fn a_flood_of_holders_ends_at_the_bound() {
        let mut others = BTreeMap::new();
        let key = |n: usize| format!("holder/camera/north/{n}/desk");
        for n in 0..10 * MOST_OTHERS {
            note(&mut others, &key(0), Presence::Joined(key(n)));
        }
        assert_eq!(others.len(), MOST_OTHERS);
        note(&mut others, &key(0), Presence::Left(key(1)));
        assert_eq!(others.len(), MOST_OTHERS - 1);
    }

    #[test]
    fn a_name_is_printed_as_people_say_it() {
        assert_eq!(
            name_of("sextant/v1/demo/holder/camera/north"),
            "camera north"
        );
        assert_eq!(host_of("holder/camera/north/ab12/desk"), "desk");
    }
}
