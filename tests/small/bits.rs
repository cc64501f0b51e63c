//! Images bit by bit, for work that must not change them: `tests/data/bits.tsv` has hashes of small
//! images of the shipped scenes and of the reference scenes by every integrator, in every mode and
//! color, with two seeds, and how many rays they took.
//!
//! Bits hang on the processor for which the program is compiled and on the versions of the compiler
//! and the dependencies. So this test is no part of `cargo test`. Before such work, at the commit
//! where it starts, check that the table holds where you are, and renew it if it does not; then
//! compare after each step:
//!
//! ```sh
//! BLESS=1 cargo test --profile checks --test small -- --ignored bits
//! cargo test --profile checks --test small -- --ignored bits
//! ```
//!
//! Debug builds give the same bits.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use rayon::prelude::*;

use crate::{Job, Outcome, jobs, scenes_in};

const HEAD: &str = "scene\tintegrator\tmode\tcolor\tseed\thash\trays_closest\trays_visibility";

/// FNV-1a, 64 bits.
pub fn hash(bytes: impl IntoIterator<Item = u8>) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, step)
}

/// Of names and values, without which images of fewer channels could pass for others.
fn hash_of(image: &Outcome) -> u64 {
    let channels = image.channels.iter().flat_map(|(name, values)| {
        name.bytes().chain(values.iter().flat_map(|value| value.to_bits().to_le_bytes()))
    });
    hash(channels)
}

/// What is rendered, and what that came to, as columns of the table. The second seed also asks for
/// variances.
fn line_of(job: &Job, seed: u32) -> (String, String) {
    let seed = seed.to_string();
    let mut options = vec!["--width", "40", "--height", "36", "--spp", "8", "--seed", &seed];
    options.extend(["--max-path-length", "12", "--roulette-after", "3"]);
    if job.integrator == "ppm" {
        options.extend(["--photons", "40000", "--samples-per-iteration", "2"]);
    }
    if seed == "1" {
        options.extend(["--variance", "--replicates", "2"]);
    }
    let image = job.run(&options);
    let what = [&job.scene, job.integrator, job.mode, job.color, &seed].join("\t");
    let [closest, visibility] = image.rays;
    (what, format!("{:016x}\t{closest}\t{visibility}", hash_of(&image)))
}

#[test]
#[ignore = "bits hang on processor and compiler; run it when they must not change"]
fn the_bits_are_those_of_the_table() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/bits.tsv");
    let jobs = jobs(&[scenes_in(""), scenes_in("reference/")].concat());
    let renders: Vec<(&Job, u32)> = jobs.iter().flat_map(|job| [(job, 0), (job, 1)]).collect();
    let now: Vec<(String, String)> =
        renders.par_iter().map(|(job, seed)| line_of(job, *seed)).collect();
    if std::env::var_os("BLESS").is_some() {
        let mut table = format!("{HEAD}\n");
        now.iter().for_each(|(what, found)| writeln!(table, "{what}\t{found}").unwrap());
        fs::write(&file, table).unwrap();
    }
    let table = fs::read_to_string(&file).unwrap();
    let row = |line: &'_ str| {
        let (at, _) = line.match_indices('\t').nth(4)?;
        Some((line[..at].to_owned(), line[at + 1..].to_owned()))
    };
    let expected: BTreeMap<String, String> = table.lines().skip(1).filter_map(row).collect();
    assert_eq!(expected.len(), now.len(), "rows of {}", file.display());
    let differ = |(what, found): &&(String, String)| expected.get(what) != Some(found);
    let others: Vec<&(String, String)> = now.iter().filter(differ).collect();
    assert!(others.is_empty(), "{} of {} differ: {others:#?}", others.len(), now.len());
}
