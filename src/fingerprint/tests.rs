//! The search on edges of an even shaft.
