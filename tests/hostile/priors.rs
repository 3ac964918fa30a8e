//! Attacks with every prior a scene can hold.
