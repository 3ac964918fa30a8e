//! Turns a law of restitution into files for a simulation code, with a drop test of one sphere.
//!
//! Each file opens with the same heading: where the law comes from, at which speed it is taken, how far it holds, how St is
//! counted, what the code does to the number. Codes take one restitution for a pair of materials, and what they make of it
//! depends on their contact: `contact.rs` has the forms and their inverses, one file a code the rest.
//!
//! | file | job |
//! |---|---|
//! | `numbers.rs`, `template.rs` | numbers as every code reads them, texts filled in |
//! | `law.rs` | what is handed over |
//! | `contact.rs` | e of an input, input for an e |
//! | `heading.rs` | what every file begins with |
//! | `drop.rs` | lengths and times of a drop test |
//! | `table.rs`, `lammps.rs`, `liggghts.rs`, `yade.rs`, `mercurydpm.rs`, `mfix.rs` | the files of a code |

mod contact;
mod drop;
mod heading;
mod lammps;
mod law;
mod liggghts;
mod mercurydpm;
mod mfix;
mod numbers;
mod table;
mod template;
mod yade;

use crate::error::Error;
pub use law::{Code, Handoff, HandoffFile, Wetting};

/// The files that hand a law over to a code.
///
/// Fails with [`Error::Usage`] where the law gives no rebound at the reference speed, or one that the code refuses.
pub fn files(code: Code, handoff: &Handoff) -> Result<Vec<HandoffFile>, Error> {
    handoff.check()?;
    match code {
        Code::Table => Ok(vec![table::file(handoff)]),
        Code::Lammps => Ok(lammps::files(handoff)),
        Code::Liggghts => liggghts::files(handoff),
        Code::Yade => Ok(vec![yade::file(handoff)]),
        Code::MercuryDpm => Ok(vec![mercurydpm::file(handoff)]),
        Code::Mfix => Ok(vec![mfix::file(handoff)]),
    }
}

#[cfg(test)]
mod tests;
