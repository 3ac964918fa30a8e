//! Divides work among processes that a launcher of MPI has started together: ranks, of which the first tells what came out.
//!
//! Work is counted. What each piece gives is gathered in the order of the pieces, so that what is made of all of them has the
//! same bytes for any number of ranks and threads. Every rank calls the same exchanges in the same order. One that cannot
//! go on takes part in the exchange the others have reached and says so in it: then all end, and no one waits.

#[cfg(feature = "mpi")]
mod world;

use serde::de::DeserializeOwned;
use serde::Serialize;

use crate::error::Error;

/// This process among those that work on one command.
#[derive(Debug)]
pub struct Ranks {
    /// from 0
    place: u64,
    /// at least 1
    count: u64,
    #[cfg(feature = "mpi")]
    world: Option<world::World>,
}

/// What launchers call the number of processes they have started, and the place of one: Open MPI, and those of the process
/// manager's interface that came with MPICH.
const LAUNCHERS: [[&str; 2]; 2] = [
    ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"],
    ["PMI_SIZE", "PMI_RANK"],
];

/// The number of processes that a launcher has started and the place of this one, as `variable` of the environment has
/// them; `None` where there was no launcher.
fn launched(variable: impl Fn(&str) -> Option<String>) -> Option<[u64; 2]> {
    let number = |name: &str| variable(name)?.parse().ok();
    LAUNCHERS
        .iter()
        .find_map(|[size, place]| Some([number(size)?, number(place)?]))
}

impl Ranks {
    /// One process on its own.
    pub fn alone() -> Ranks {
        Ranks {
            place: 0,
            count: 1,
            #[cfg(feature = "mpi")]
            world: None,
        }
    }

    /// Finds the processes that were started with this one.
    ///
    /// To be called once, by the thread that makes every exchange. MPI is not touched by a process without others. Where it
    /// cannot reach them the reason is given, which is the same on all and the first rank's to tell.
    pub fn start() -> (Ranks, Result<(), Error>) {
        match launched(|name| std::env::var(name).ok()) {
            Some([count, place]) if count > 1 => Ranks::among(count, place),
            _ => (Ranks::alone(), Ok(())),
        }
    }

    fn among(count: u64, place: u64) -> (Ranks, Result<(), Error>) {
        let mut ranks = Ranks::alone();
        (ranks.place, ranks.count) = (place, count);
        #[cfg(feature = "mpi")]
        if let Some(world) = world::World::start() {
            ranks.world = Some(world);
            return (ranks, Ok(()));
        }
        (ranks, Err(not_joined(count)))
    }

    /// Whether this is the first rank, which alone writes and tells.
    pub fn is_first(&self) -> bool {
        self.place == 0
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Which of so many pieces of work this rank does: they go round.
    pub fn own(&self, pieces: u64) -> Vec<u64> {
        let step = usize::try_from(self.count).unwrap_or(usize::MAX);
        (self.place..pieces).step_by(step).collect()
    }

    /// What each of so many pieces of work gives, in their order, on every rank; `work` does those that it is given.
    ///
    /// Fails where it fails, and with [`Error::OtherRank`] where another rank does.
    pub fn gather<T: Serialize + DeserializeOwned>(
        &self,
        pieces: u64,
        work: impl FnOnce(Vec<u64>) -> Result<Vec<T>, Error>,
    ) -> Result<Vec<T>, Error> {
        let own = work(self.own(pieces))?;
        #[cfg(feature = "mpi")]
        if let Some(world) = &self.world {
            return world.exchange_all(&own).map(in_turn);
        }
        Ok(own)
    }

    /// Waits for the others.
    ///
    /// Fails with [`Error::OtherRank`] where one of them cannot go on.
    pub fn agree(&self) -> Result<(), Error> {
        self.gather(self.count, |own| Ok(vec![(); own.len()])).map(drop)
    }

    /// How a command ends that has come to this result here: with it, or with [`Error::OtherRank`], about which nothing is
    /// left to tell, where another rank has failed, too, and tells it.
    pub fn end(&self, result: Result<u8, Error>) -> Result<u8, Error> {
        #[cfg(feature = "mpi")]
        if let Some(world) = &self.world {
            return match result {
                // this the others know
                Err(Error::OtherRank) => Err(Error::OtherRank),
                Err(error) if world.fail() == self.place => Err(error),
                Err(_) => Err(Error::OtherRank),
                Ok(status) => self.agree().map(|()| status),
            };
        }
        match result {
            Err(_) if !self.is_first() => Err(Error::OtherRank),
            result => result,
        }
    }
}

fn not_joined(count: u64) -> Error {
    Error::Usage(if cfg!(feature = "mpi") {
        format!("a launcher started {count} processes, and MPI cannot be started among them")
    } else {
        format!(
            "a launcher started {count} processes, and this wetcor was built without MPI: build it with `--features mpi`, which \
             needs Open MPI and libclang (Debian: libopenmpi-dev, openmpi-bin, libclang-dev)"
        )
    })
}

/// What ranks have of pieces that went round, in the order of the pieces.
#[cfg(any(feature = "mpi", test))]
fn in_turn<T>(each: Vec<Vec<T>>) -> Vec<T> {
    let mut each: Vec<_> = each.into_iter().map(Vec::into_iter).collect();
    let places = (0..each.len()).cycle();
    places.map_while(|place| each[place].next()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranks(place: u64, count: u64) -> Ranks {
        let mut ranks = Ranks::alone();
        (ranks.place, ranks.count) = (place, count);
        ranks
    }

    #[test]
    fn every_piece_is_done_once_and_comes_back_in_its_place() {
        for (pieces, count) in [(0, 3), (1, 3), (7, 1), (7, 3), (9, 3)] {
            let each = (0..count).map(|place| ranks(place, count).own(pieces)).collect();
            assert_eq!(in_turn(each), (0..pieces).collect::<Vec<u64>>(), "{pieces} on {count}");
        }
    }

    #[test]
    fn a_launcher_is_known_by_what_it_tells_its_processes() {
        let of = |known: &'static [(&str, &str)]| {
            launched(|name| {
                let found = known.iter().find(|(known, _)| *known == name);
                found.map(|(_, value)| (*value).to_owned())
            })
        };
        assert_eq!(of(&[]), None);
        let open_mpi = of(&[("OMPI_COMM_WORLD_SIZE", "3"), ("OMPI_COMM_WORLD_RANK", "2")]);
        assert_eq!(open_mpi, Some([3, 2]));
        assert_eq!(of(&[("PMI_SIZE", "2"), ("PMI_RANK", "0")]), Some([2, 0]));
        // half of it is none
        assert_eq!(of(&[("PMI_SIZE", "2")]), None);
    }

    #[test]
    fn without_the_others_the_first_rank_tells_why() {
        let failed = || Err(Error::Usage("no scene".to_owned()));
        assert!(matches!(ranks(0, 2).end(failed()), Err(Error::Usage(_))));
        assert!(matches!(ranks(1, 2).end(failed()), Err(Error::OtherRank)));
        assert_eq!(ranks(0, 1).end(Ok(1)).expect("it ran"), 1);
    }
}
