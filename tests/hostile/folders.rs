//! Attacks folders that are read back.
