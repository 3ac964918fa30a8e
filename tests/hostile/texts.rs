//! Attacks with names and texts, with a standard output that refuses, and without threads.
