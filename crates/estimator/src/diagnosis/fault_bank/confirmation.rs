//! What a contest takes from the suspects and what it tells them.

use crate::TagId;
use crate::diagnosis::exclusion_test::subset_filter::{Excluded, SubsetFilter};
use crate::diagnosis::fault_bank::{FaultBank, FaultHypothesis, NamingPolicy, SIMPLE, Tag, covers};
use crate::diagnosis::fault_estimate::ALERT;

impl FaultBank {
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
    pub fn known(&self, object: usize) -> Vec<Excluded> {
        let left_out = |cause: &FaultHypothesis| match cause {
            FaultHypothesis::Camera(camera) | FaultHypothesis::Clock(camera) => {
                Some(Excluded::Camera(*camera))
            }
            FaultHypothesis::Size(tag) | FaultHypothesis::Place(tag) => {
                (tag.0 == object).then_some(Excluded::Tag(tag.1))
            }
        };
        self.found.iter().filter_map(left_out).collect()
    }

    /// Evidence alone may name but these.
    pub fn admit(&mut self, admitted: NamingPolicy) {
        self.admitted = admitted;
    }

    /// It is this one: a single parameter of it if that explains as much.
    pub fn confirm(&mut self, object: usize, subset_filter: Option<SubsetFilter>) {
        let Some((left_out, one)) = subset_filter.and_then(|one| Some((one.left_out?, one))) else {
            return;
        };
        let [simple, whole] = one.evidences();
        let [by_simple, by_whole] = one.estimate.explain();
        let is_clock = matches!(left_out, Excluded::Clock(_));
        let is_simple = is_clock || by_simple && (!by_whole || simple + SIMPLE > whole);
        let (first, causes) = match left_out {
            Excluded::Camera(camera) | Excluded::Clock(camera) => (
                0,
                [
                    FaultHypothesis::Clock(camera),
                    FaultHypothesis::Camera(camera),
                ],
            ),
            Excluded::Tag(tag) => {
                let tag = (object, tag);
                (2, [FaultHypothesis::Size(tag), FaultHypothesis::Place(tag)])
            }
        };
        for ((camera, tag), evidence) in one.cells {
            let cell = self.cells.entry((camera, (object, tag))).or_default();
            cell.0[first..first + 2].copy_from_slice(&evidence);
        }
        match left_out {
            Excluded::Camera(camera) | Excluded::Clock(camera) => {
                self.angles.insert(camera, one.angles);
                self.cameras.insert(camera, one.estimate);
            }
            Excluded::Tag(tag) => drop(self.tags.insert((object, tag), one.estimate)),
        }
        self.found.insert(causes[usize::from(!is_simple)]);
        self.alert = true;
    }
}
