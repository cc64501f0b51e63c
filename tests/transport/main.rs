//! Light's way through scenes: renders against laws, tables, reference images and each other.
//!
//! One program, as the renderer is compiled into each. Its parts: `cargo test --profile checks
//! --test transport furnace`.

#[path = "../support/mod.rs"]
mod support;

mod absorption;
mod agreement;
mod aimed;
mod analyzers;
mod auto;
mod bands;
mod boundaries;
mod brushed;
mod contacts;
mod convergence;
mod door;
mod emitters;
mod filmed;
mod films;
mod furnace;
mod glimpses;
mod globes;
mod grounds;
mod incandescent;
mod instances;
mod lamps_in_media;
mod luminaires;
mod merging;
mod modes;
mod nesting;
mod painted;
mod parts;
mod plates;
mod polarized_lamps;
mod projectors;
mod reconstruction;
mod reference_images;
mod shares;
mod sheets;
mod skies;
mod slabs;
mod stains;
mod straight_on;
mod thin;
mod variance;
