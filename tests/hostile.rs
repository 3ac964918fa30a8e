//! Attacks the command with what a careless or hostile hand could give it; every defect once found is a test by its name.
//!
//! | file | what is attacked |
//! |---|---|
//! | `attack.rs` | runs the command with limits and holds its manners |
//! | `priors.rs` | every prior a scene can hold |
//! | `transcripts.rs` | sizes; places that files are written to and what stands there; standard output, threads, paths |
//! | `texts.rs` | names and texts that reach a terminal, a page or a picture |
//! | `folders.rs` | folders that are read back |

mod attack;
mod folders;
mod priors;
mod texts;
mod transcripts;
