//! Attacks the places that files are written to.
