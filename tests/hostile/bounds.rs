//! Attacks sizes: of files, lines and counts, and numbers of particles.
