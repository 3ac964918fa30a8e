//! Exchanges bytes between ranks by MPI; the only file that names it.

use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::traits::CommunicatorCollectives;
use mpi::{Count, Threading};
use serde::de::DeserializeOwned;
use serde::Serialize;

use crate::error::Error;

/// Every process that was started together, until it is dropped.
pub(super) struct World {
    all: SimpleCommunicator,
    /// after what it has made
    _universe: Universe,
}

/// In place of a number of bytes: this rank cannot go on.
const FAILED: Count = -1;

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ranks", self.all.size())
    }
}

impl World {
    /// `None` where MPI was started before, or gives no thread of many leave to call it.
    pub fn start() -> Option<World> {
        let (universe, threading) = mpi::initialize_with_threading(Threading::Funneled)?;
        (threading >= Threading::Funneled).then(|| World {
            all: universe.world(),
            _universe: universe,
        })
    }

    /// What every rank has, by rank.
    pub fn exchange_all<T: Serialize + DeserializeOwned>(&self, own: &[T]) -> Result<Vec<Vec<T>>, Error> {
        let packed = rmp_serde::to_vec(own).ok();
        let sendable = packed.filter(|bytes| Count::try_from(bytes.len()).is_ok());
        let Some(bytes) = sendable else {
            return Err(too_much());
        };
        let counts = self.counts(bytes.len() as Count);
        let ends = counts.iter().scan(0, |end: &mut Count, count| {
            *end = end.checked_add(*count)?;
            Some(*end)
        });
        let ends: Vec<Count> = ends.collect();
        if counts.contains(&FAILED) {
            return Err(Error::OtherRank);
        }
        if ends.len() < counts.len() {
            return Err(too_much());
        }
        let starts: Vec<Count> = ends.iter().zip(&counts).map(|(end, count)| end - count).collect();
        let mut all = vec![0u8; ends.last().map_or(0, |end| *end as usize)];
        let mut parts = PartitionMut::new(&mut all[..], counts, &starts[..]);
        self.all.all_gather_varcount_into(&bytes[..], &mut parts);
        let part = |(start, end): (&Count, &Count)| {
            let read = rmp_serde::from_slice(&all[*start as usize..*end as usize]);
            read.map_err(|error| internal(error.to_string()))
        };
        starts.iter().zip(&ends).map(part).collect()
    }

    /// Takes part in the exchange that the others have reached, in order to say that this rank cannot go on; gives the first
    /// of those that cannot.
    pub fn fail(&self) -> u64 {
        let counts = self.counts(FAILED);
        let first = counts.iter().position(|count| *count == FAILED);
        first.map_or(0, |place| place as u64)
    }

    fn counts(&self, own: Count) -> Vec<Count> {
        let mut counts = vec![0; self.all.size() as usize];
        self.all.all_gather_into(&own, &mut counts[..]);
        counts
    }
}

fn too_much() -> Error {
    internal("more than two gigabytes at once".to_owned())
}

fn internal(reason: String) -> Error {
    Error::Internal {
        doing: "exchange results between ranks",
        reason,
    }
}
