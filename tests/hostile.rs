//! Attacks the command with what a careless or hostile hand could give it; every defect once found is a test by its name.
//!
//! | file | what is attacked |
//! |---|---|
//! | `attack.rs` | runs the command with limits and holds its manners |
//! | `places.rs` | where files are written and what stands there |
//! | `priors.rs` | every prior a scene can hold |
//! | `bounds.rs` | sizes: of files, lines, counts, numbers of particles |
//! | `texts.rs` | names and texts that reach a terminal, a page or a picture; standard output; threads |
//! | `folders.rs` | folders that are read back |

mod attack;
mod bounds;
mod folders;
mod places;
mod priors;
mod texts;
