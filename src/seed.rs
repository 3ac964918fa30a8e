//! Gives every use of chance a random stream of its own, named after the use.
//!
//! A stream depends on the seed, its name and its index and on nothing else, so that adding a use of chance, or
//! running on another number of threads, moves no other draw.

use std::io::{ErrorKind, Read};

use rand::rngs::ChaCha8Rng;
use rand::SeedableRng;
use sha2::{Digest, Sha256};

/// The random stream of one use of chance.
///
/// `index` tells replicates, chains or data sets of the same use apart.
pub fn stream(seed: u64, name: &str, index: u64) -> ChaCha8Rng {
    Streams::new(seed, name).at(index)
}

/// Names one use of chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamName<'n> {
    /// seed of every use of chance
    pub seed: u64,
    /// the use
    pub name: &'n str,
}

impl<'n> StreamName<'n> {
    /// The use of this name under a seed.
    pub fn new(seed: u64, name: &'n str) -> StreamName<'n> {
        StreamName { seed, name }
    }

    /// The random stream of an index.
    pub fn at(self, index: u64) -> ChaCha8Rng {
        stream(self.seed, self.name, index)
    }
}

/// The random streams of one use of chance, for many indices: hashing takes longer than a short use.
#[derive(Debug, Clone, Copy)]
pub struct Streams {
    key: [u8; 32],
}

impl Streams {
    /// The streams of this seed and name.
    pub fn new(seed: u64, name: &str) -> Streams {
        let mut hash = Sha256::new();
        hash.update(seed.to_le_bytes());
        hash.update(name.as_bytes());
        let mut key = [0u8; 32];
        key.copy_from_slice(&hash.finalize());
        Streams { key }
    }

    /// The stream of an index.
    pub fn at(&self, index: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::from_seed(self.key);
        rng.set_stream(index);
        rng
    }

    /// One stream from the stretch of an index on, where every stretch has so many words of 32 bits: the next one
    /// follows without a new start, which takes as long as sixty words.
    pub fn stretch(&self, index: u64, words: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::from_seed(self.key);
        rng.set_word_pos(u128::from(index) * u128::from(words));
        rng
    }
}

/// Lowercase hexadecimal SHA-256 of some bytes.
pub fn sha256(bytes: &[u8]) -> String {
    in_hexadecimal(Sha256::new_with_prefix(bytes))
}

/// The same of all that a source has.
pub(crate) fn sha256_of(mut source: impl Read) -> std::io::Result<String> {
    let (mut hash, mut piece) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match source.read(&mut piece) {
            Ok(0) => return Ok(in_hexadecimal(hash)),
            Ok(read) => hash.update(&piece[..read]),
            // a signal came first
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

fn in_hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn streams_differ_by_seed_name_and_index_and_repeat() {
        let first = |seed, name: &str, index| stream(seed, name, index).next_u64();
        assert_eq!(first(1, "simulate", 0), first(1, "simulate", 0));
        assert_ne!(first(1, "simulate", 0), first(2, "simulate", 0));
        assert_ne!(first(1, "simulate", 0), first(1, "bootstrap", 0));
        assert_ne!(first(1, "simulate", 0), first(1, "simulate", 1));
    }

    #[test]
    fn sha256_of_a_source_and_of_its_bytes_is_the_published_one() {
        let published = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), published);
        assert_eq!(sha256_of(b"abc".as_slice()).expect("bytes that are there"), published);
    }
}
