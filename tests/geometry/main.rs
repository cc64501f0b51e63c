//! The tree against brute force, and what must never happen: leaks and self-intersections.

mod fixtures;
mod instances;
mod leaks;
mod next;
mod offsets;
mod profile;
mod surfaces;
mod tracing;
