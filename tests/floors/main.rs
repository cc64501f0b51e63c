//! The architecture as a test: modules are floors and import only from lower ones, stages are peers
//! that say what they read and write, outside crates stay where they belong, and no file, function
//! or line outgrows its bound.
//!
//! The floors are read from the table in `src/lib.rs`, so that table cannot lie. Rules that a
//! source breaks are listed one per line, with file and line number; `can_fail` feeds the checker
//! sources that break each rule, so the checker itself cannot go blind.

mod can_fail;
mod functions;
mod kinds;
mod pages;
mod rules;
mod sources;
mod stages;
mod tokens;

use pages::check_page;
use rules::{Broken, check_file};
use sources::{Tree, floors_of, read, root};
use stages::check_stages;
use tokens::tokens_of;

/// Longest line, in columns.
const COLUMNS_MAX: usize = 100;
/// Longest function, in lines.
const FUNCTION_LINES_MAX: usize = 70;
/// Longest file, in lines.
const FILE_LINES_MAX: usize = 600;
/// Most parameters of a stage, where a tuple counts as its parts: with more, it is two stages.
const STAGE_PARAMETERS_MAX: usize = 6;
/// Where the stages live.
const STAGES: &str = "src/transport/stages/";
/// What a stage may come from or go to besides stages: functions of lower floors, and places.
const OUTSIDE: [&str; 4] = ["trace_closest", "resolve_surfaces", "the photon maps", "the film"];
/// Macros that have no place in finished code.
const UNFINISHED: [&str; 3] = ["todo", "unimplemented", "dbg"];

/// Outside crates that only some modules may know.
const CONFINED: [(&str, &[&str]); 12] = [
    ("hecs", &["scene"]),
    ("gltf", &["scene"]),
    ("roxmltree", &["scene"]),
    ("obvhs", &["geometry", "scene"]),
    ("memmap2", &["geometry"]),
    ("exr", &["image"]),
    ("plotters", &["bench"]),
    ("clap", &["cli"]),
    ("sha2", &["batch"]),
    ("toml", &["batch"]),
    ("tev_client", &["cli"]),
    (
        "rayon",
        &[
            "polarization",
            "image",
            "scene",
            "geometry",
            "scattering",
            "transport",
            "film",
            "render",
        ],
    ),
];

/// Modules below the floors' resolution: (files that start so, module they may not import, why).
const FORBIDDEN: [(&str, &str, &str); 1] =
    [("src/transport/mis", "polarization", "weights never see Stokes values")];

/// Files that start so have nothing to do with wavelengths.
const KNOWS_NO_N: [&str; 1] = ["src/geometry/"];

/// Pages whose tables lead to files and functions.
const PAGES: [&str; 2] = ["README.md", "src/lib.rs"];

#[test]
fn the_sources_keep_the_rules() {
    let tree = Tree::present();
    let mut broken = violations(&tree);
    broken.extend(rules_without_ground(&tree, &read("Cargo.toml")));
    let text_of = |path: &str| {
        let path = root().join(path);
        if path.is_dir() { Some(String::new()) } else { std::fs::read_to_string(path).ok() }
    };
    for page in PAGES {
        broken.extend(check_page(page, &read(page), &text_of));
    }
    assert!(broken.is_empty(), "{} rules broken:\n{}", broken.len(), broken.join("\n"));
}

#[test]
fn the_table_of_floors_lists_every_module() {
    let text = read("src/lib.rs");
    let tokens = tokens_of(&text);
    let modules: Vec<&str> = (tokens.windows(3))
        .filter(|w| w[0].text == "mod" && w[2].text == ";")
        .map(|w| w[1].text.as_str())
        .collect();
    let floors = floors_of(&text);
    assert!(modules.len() > 9, "found only {modules:?}");
    assert_eq!(floors.keys().map(String::as_str).collect::<Vec<_>>(), modules);
}

/// Every rule that the sources of a tree break, each by itself or together.
fn violations(tree: &Tree) -> Vec<String> {
    let mut list = Vec::new();
    for source in &tree.sources {
        let mut broken = Broken { file: &source.file, list: Vec::new() };
        check_file(&mut broken, source, tree);
        list.extend(broken.list);
    }
    list.extend(check_stages(tree));
    list
}

/// Rules about what is not there (any more): they would hold whatever is written.
fn rules_without_ground(tree: &Tree, manifest: &str) -> Vec<String> {
    let prefixes = FORBIDDEN.iter().map(|(prefix, _, _)| prefix);
    let prefixes = prefixes.chain(&KNOWS_NO_N).chain([&STAGES]);
    let has_file = |prefix: &str| tree.sources.iter().any(|s| s.file.starts_with(prefix));
    let files = prefixes
        .filter(|prefix| !has_file(prefix))
        .map(|prefix| format!("a rule is about {prefix}, and no file starts so"));
    let homes = CONFINED.iter().flat_map(|(_, homes)| homes.iter());
    let modules = homes
        .chain(FORBIDDEN.iter().map(|(_, module, _)| module))
        .filter(|module| !tree.floors.contains_key(**module))
        .map(|module| format!("a rule is about the module {module}, and there is none"));
    let is_needed =
        |name: &str| manifest.lines().any(|line| line.starts_with(&format!("{name} = ")));
    let crates = CONFINED
        .iter()
        .filter(|(name, _)| !is_needed(name))
        .map(|(name, _)| format!("a rule is about the crate {name}, which nothing needs"));
    files.chain(modules).chain(crates).collect()
}
