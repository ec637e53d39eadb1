//! What a contest takes from the suspects and what it tells them.

use crate::TagId;
use crate::diagnosis::exclusion_test::subset_filter::{Contender, LeftOut};
use crate::diagnosis::fault_bank::{Admitted, Cause, SIMPLE, Suspects, Tag, covers};
use crate::diagnosis::fault_estimate::ALERT;

impl Suspects {
    /// The most evidence for a cause of what no known one covers.
    pub fn most_unknown(&self) -> f64 {
        let is_open = |cell: &&(usize, Tag)| !self.found.iter().any(|cause| covers(cause, cell));
        let open: Vec<_> = self.cells.keys().filter(is_open).copied().collect();
        let causes = self.causes(&open).into_iter();
        causes.map(|(_, evidence)| evidence).fold(0.0, f64::max)
    }

    /// The object in whose views most speaks for faults.
    pub fn most_suspected(&self) -> usize {
        let of_cell = |(key, cell): (&(usize, Tag), &crate::diagnosis::fault_bank::Cell)| {
            (key.1.0, cell.0.into_iter().fold(0.0, f64::max))
        };
        let cells = self.cells.iter().map(of_cell);
        let most = cells.max_by(|a, b| a.1.total_cmp(&b.1));
        most.map_or(0, |(object, _)| object)
    }

    /// The tags of an object that something speaks against.
    pub fn suspected_tags(&self, object: usize) -> Vec<TagId> {
        let is_suspected =
            |cell: &crate::diagnosis::fault_bank::Cell| cell.0[2].max(cell.0[3]) > ALERT;
        let cells = self.cells.iter().filter(|(_, cell)| is_suspected(cell));
        let tags = cells.filter(|((_, tag), _)| tag.0 == object);
        let mut tags: Vec<TagId> = tags.map(|((_, tag), _)| tag.1).collect();
        tags.sort_unstable();
        tags.dedup();
        tags
    }

    /// What is known to be wrong in views of an object.
    pub fn known(&self, object: usize) -> Vec<LeftOut> {
        let left_out = |cause: &Cause| match cause {
            Cause::Camera(camera) | Cause::Clock(camera) => Some(LeftOut::Camera(*camera)),
            Cause::Size(tag) | Cause::Place(tag) => {
                (tag.0 == object).then_some(LeftOut::Tag(tag.1))
            }
        };
        self.found.iter().filter_map(left_out).collect()
    }

    /// Evidence alone may name but these.
    pub fn admit(&mut self, admitted: Admitted) {
        self.admitted = admitted;
    }

    /// It is this one: a single parameter of it if that explains as much.
    pub fn convict(&mut self, object: usize, contender: Option<Contender>) {
        let Some((left_out, one)) = contender.and_then(|one| Some((one.left_out?, one))) else {
            return;
        };
        let [simple, whole] = one.evidences();
        let [by_simple, by_whole] = one.accused.explain();
        let is_clock = matches!(left_out, LeftOut::Clock(_));
        let is_simple = is_clock || by_simple && (!by_whole || simple + SIMPLE > whole);
        let (first, causes) = match left_out {
            LeftOut::Camera(camera) | LeftOut::Clock(camera) => {
                (0, [Cause::Clock(camera), Cause::Camera(camera)])
            }
            LeftOut::Tag(tag) => {
                let tag = (object, tag);
                (2, [Cause::Size(tag), Cause::Place(tag)])
            }
        };
        for ((camera, tag), evidence) in one.cells {
            let cell = self.cells.entry((camera, (object, tag))).or_default();
            cell.0[first..first + 2].copy_from_slice(&evidence);
        }
        match left_out {
            LeftOut::Camera(camera) | LeftOut::Clock(camera) => {
                self.angles.insert(camera, one.angles);
                self.cameras.insert(camera, one.accused);
            }
            LeftOut::Tag(tag) => drop(self.tags.insert((object, tag), one.accused)),
        }
        self.found.insert(causes[usize::from(!is_simple)]);
        self.alert = true;
    }
}
