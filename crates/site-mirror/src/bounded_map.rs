//! Values by ids from the network: bounded in number, and dropped when they are no longer updated. Times are ns by any
//! one clock.
//!
//! Drop rule: if there is no room for a new id, it replaces the entry untouched for the longest time, if that is at
//! least the expiry; otherwise it is refused. A flood of forged ids therefore neither grows the map nor evicts what is
//! in use.

use std::collections::BTreeMap;

/// A map of bounded size.
#[derive(Debug, Clone)]
pub struct BoundedMap<K, V> {
    capacity: usize,
    expiry_ns: u64,
    entries: BTreeMap<K, Entry<V>>,
}

#[derive(Debug, Clone)]
struct Entry<V> {
    value: V,
    /// When it was last inserted or touched; `None` for entries that never expire.
    touched: Option<u64>,
}

/// All entries are in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no more ids are kept")]
pub struct Full;

impl<K: Ord + Clone, V> BoundedMap<K, V> {
    /// A map of at most `capacity` entries, which may be evicted once untouched for `expiry_ns`.
    pub fn new(capacity: usize, expiry_ns: u64) -> Self {
        Self {
            capacity,
            expiry_ns,
            entries: BTreeMap::new(),
        }
    }

    /// Inserts or replaces a value; returns the replaced or evicted one.
    ///
    /// # Errors
    /// [`Full`] for a new id while all others are in use.
    pub fn insert(&mut self, now_ns: u64, key: K, value: V) -> Result<Option<V>, Full> {
        self.put(now_ns, key, value, Some(now_ns))
    }

    /// As [`Self::insert`], for a value that never expires.
    ///
    /// # Errors
    /// As [`Self::insert`].
    pub fn insert_lasting(&mut self, now_ns: u64, key: K, value: V) -> Result<Option<V>, Full> {
        self.put(now_ns, key, value, None)
    }

    fn put(
        &mut self,
        now_ns: u64,
        key: K,
        value: V,
        touched: Option<u64>,
    ) -> Result<Option<V>, Full> {
        let evicted = self.make_room(now_ns, &key)?;
        let replaced = self.entries.insert(key, Entry { value, touched });
        Ok(replaced.map(|held| held.value).or(evicted))
    }

    /// The value of an id, a new one if need be; marks it as in use.
    ///
    /// # Errors
    /// As [`Self::insert`].
    pub fn entry(&mut self, now_ns: u64, key: K) -> Result<&mut V, Full>
    where
        V: Default,
    {
        self.make_room(now_ns, &key)?;
        let new = || Entry {
            value: V::default(),
            touched: Some(now_ns),
        };
        let held = self.entries.entry(key).or_insert_with(new);
        held.touched = held.touched.map(|_| now_ns);
        Ok(&mut held.value)
    }

    /// Evicts and returns the value that [`Self::insert`] or [`Self::entry`] would evict for this id.
    ///
    /// # Errors
    /// As [`Self::insert`].
    pub fn make_room(&mut self, now_ns: u64, key: &K) -> Result<Option<V>, Full> {
        if self.entries.len() < self.capacity || self.entries.contains_key(key) {
            return Ok(None);
        }
        let ages = self.entries.iter();
        let ages = ages.filter_map(|(key, held)| Some((key, held.touched?)));
        let (oldest, touched) = ages.min_by_key(|(_, touched)| *touched).ok_or(Full)?;
        if now_ns.saturating_sub(touched) < self.expiry_ns {
            return Err(Full);
        }
        let oldest = oldest.clone();
        Ok(self.remove(&oldest))
    }

    /// Marks these entries as in use.
    pub fn touch_where(&mut self, now_ns: u64, is_used: impl Fn(&K) -> bool) {
        for (key, held) in &mut self.entries {
            if let Some(touched) = held.touched.as_mut().filter(|_| is_used(key)) {
                *touched = now_ns;
            }
        }
    }

    /// Removes and returns everything that was untouched for the expiry.
    pub fn expire(&mut self, now_ns: u64) -> Vec<(K, V)> {
        let expiry_ns = self.expiry_ns;
        let expired = self.entries.extract_if(.., |_, held| {
            held.touched
                .is_some_and(|touched| now_ns.saturating_sub(touched) >= expiry_ns)
        });
        expired.map(|(key, held)| (key, held.value)).collect()
    }

    /// Removes an entry and returns its value.
    pub fn remove(&mut self, key: &K) -> Option<V> {
        Some(self.entries.remove(key)?.value)
    }

    /// The value of an id.
    pub fn get(&self, key: &K) -> Option<&V> {
        Some(&self.entries.get(key)?.value)
    }

    /// The same, to be changed.
    pub fn get_mut(&mut self, key: &K) -> Option<&mut V> {
        Some(&mut self.entries.get_mut(key)?.value)
    }

    /// All entries, sorted by id.
    pub fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        self.entries.iter().map(|(key, held)| (key, &held.value))
    }

    /// Number of entries, expired ones included until they are removed.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether the map is empty.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPIRY_NS: u64 = 60;

    #[test]
    fn ten_times_as_many_ids_as_there_is_room_for_drive_nothing_out() {
        let (mut map, now) = (BoundedMap::new(8, EXPIRY_NS), 7);
        let refused = (0..80).filter(|id| map.insert(now, *id, ()).is_err());
        assert_eq!(refused.count(), 72);
        assert_eq!(map.insert(now, 3, ()), Ok(Some(())));
        let ids: Vec<i32> = map.iter().map(|(id, ())| *id).collect();
        assert_eq!(ids, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn the_longest_untouched_gives_way_once_it_is_old_enough() {
        let (mut map, start) = (BoundedMap::new(3, EXPIRY_NS), 7);
        map.insert_lasting(start, "lasting", ()).unwrap();
        map.insert(start, "old", ()).unwrap();
        map.insert(start, "used", ()).unwrap();
        let later = start + EXPIRY_NS;
        map.touch_where(later, |id| *id == "used");
        assert_eq!(map.insert(later, "new", ()), Ok(Some(())));
        assert_eq!(map.insert(later, "newer", ()), Err(Full));
        let ids: Vec<&str> = map.iter().map(|(id, ())| *id).collect();
        assert_eq!(ids, ["lasting", "new", "used"]);
        assert_eq!(map.expire(later + EXPIRY_NS).len(), 2);
        assert_eq!((map.len(), map.get(&"lasting")), (1, Some(&())));
    }
}
