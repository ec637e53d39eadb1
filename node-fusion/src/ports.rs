//! The network's side of what a fusion node publishes: a publisher for each key, declared with its first message.

use crate::outbox::{Publication, Put};
use sextant_zenoh_bus::{Bus, BusError, RawLatest, RawPublisher, Shelf};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// The publishers of one fusion node.
#[derive(Debug)]
pub struct Ports<'a> {
    bus: &'a Bus,
    by_key: BTreeMap<String, Port>,
    shelf: Option<Shelf>,
}

#[derive(Debug)]
enum Port {
    Passing(RawPublisher),
    Kept(RawLatest),
}

impl<'a> Ports<'a> {
    /// No port yet: each opens with its first publication.
    pub fn new(bus: &'a Bus) -> Self {
        Self {
            bus,
            by_key: BTreeMap::new(),
            shelf: None,
        }
    }

    /// Publishes it.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn publish(&mut self, publication: Publication) -> Result<(), BusError> {
        match publication {
            Publication::Message(put) => self.put(put),
            Publication::Withdrawal(key) => {
                self.by_key.remove(&key);
                Ok(())
            }
            Publication::Models(root, payloads) => {
                let shelf = match &self.shelf {
                    Some(shelf) => shelf,
                    None => self.shelf.insert(self.bus.shelf(&root)?),
                };
                shelf.replace(payloads.iter())
            }
        }
    }

    fn put(&mut self, put: Put) -> Result<(), BusError> {
        let sender = put.sender.as_deref();
        let port = match self.by_key.entry(put.key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let port = match put.is_kept {
                    true => Port::Kept(self.bus.raw_latest(place.key(), put.qos)?.signed(sender)),
                    false => {
                        Port::Passing(self.bus.raw_publisher(place.key(), put.qos)?.signed(sender))
                    }
                };
                place.insert(port)
            }
        };
        match port {
            Port::Passing(publisher) => publisher.put(&put.payload),
            Port::Kept(latest) => latest.put(&put.payload),
        }
    }
}
