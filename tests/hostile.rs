//! Attacks the command with what a careless or hostile hand could give it; every defect once found is a test by its name.
//! Sizes, places and outputs stand in `transcripts`.
//!
//! | file | what is attacked |
//! |---|---|
//! | `attack.rs` | runs the command with limits and holds its manners |
//! | `priors.rs` | every prior a scene can hold |
//! | `texts.rs` | names that reach a folder, a page or a picture |
//! | `folders.rs` | folders that are read back |

pub mod attack;
mod folders;
mod priors;
mod texts;
