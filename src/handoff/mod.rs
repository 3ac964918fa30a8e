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
//! | `deck.rs` | fills in the template of a drop test |
//! | `table.rs`, `lammps.rs`, `liggghts.rs`, `yade.rs` | the files of a code |
//! | `templates/` | the drop tests, and what each code makes of a restitution |
//!
//! A code is here once its files have been run (`tests/handoff_in_codes.rs`); lines for others stand in
//! docs/simulation-codes.md.

mod contact;
mod deck;
mod heading;
mod lammps;
mod law;
mod liggghts;
mod numbers;
mod table;
mod template;
mod yade;

use crate::error::Error;
pub use law::{Code, Handoff, HandoffFile};

/// The files that hand a law over to a code.
///
/// Fails with [`Error::Usage`] where the law gives no rebound at the reference speed, or one that the code refuses.
pub fn files(code: Code, handoff: &Handoff) -> Result<Vec<HandoffFile>, Error> {
    handoff.check()?;
    match code {
        Code::Table => Ok(vec![table::file(handoff)?]),
        Code::Lammps => lammps::files(handoff),
        Code::Liggghts => liggghts::files(handoff),
        Code::Yade => Ok(vec![yade::file(handoff)?]),
    }
}

#[cfg(test)]
mod tests;
