//! The files that the rules are about, and what several of them say together: the floors, the
//! enums, the functions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use super::functions::{Function, functions_of};
use super::tokens::{Token, closing, closing_angle, is_name, split, text_at, tokens_of};

/// Numbers of the floors by module.
pub type Floors = BTreeMap<String, u32>;

pub struct Source {
    /// From the root of the package, with `/` between.
    pub file: String,
    pub text: String,
    pub tokens: Vec<Token>,
    pub functions: Vec<Function>,
}

impl Source {
    pub fn new(file: &str, text: &str) -> Self {
        let tokens = tokens_of(text);
        let functions = functions_of(&tokens);
        Self { file: file.to_owned(), text: text.to_owned(), tokens, functions }
    }
}

/// All that is checked.
pub struct Tree {
    pub sources: Vec<Source>,
    pub floors: Floors,
    /// Variants of the enums in `src`, by name; several enums of one name share a set.
    pub enums: BTreeMap<String, BTreeSet<String>>,
}

impl Tree {
    pub fn new(sources: Vec<Source>, floors: Floors) -> Self {
        let mut enums: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for source in sources.iter().filter(|source| source.file.starts_with("src/")) {
            for (name, variants) in enums_of(&source.tokens) {
                enums.entry(name).or_default().extend(variants);
            }
        }
        Self { sources, floors, enums }
    }

    /// The tree on the disk.
    pub fn present() -> Self {
        let sources = files().iter().map(|file| Source::new(file, &read(file))).collect();
        Self::new(sources, floors_of(&read("src/lib.rs")))
    }

    /// Whether any function of `src` has this name.
    pub fn has_function(&self, name: &str) -> bool {
        let in_src = self.sources.iter().filter(|source| source.file.starts_with("src/"));
        in_src.flat_map(|source| &source.functions).any(|function| function.name == name)
    }
}

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

pub fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// All Rust files of the package.
fn files() -> Vec<String> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = ["src", "tests", "benches"].map(PathBuf::from).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).into_iter().flatten() {
            let entry = entry.expect("a folder can be read");
            let path = folder.join(entry.file_name());
            if entry.path().is_dir() {
                // The races' own package is built below its folder.
                folders.extend((entry.file_name() != "target").then_some(path));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    assert!(files.len() > 50, "found only {} files", files.len());
    files.sort();
    files
}

/// The table "floor, module" in the documentation of the crate.
pub fn floors_of(text: &str) -> Floors {
    let row = |line: &str| -> Option<(String, u32)> {
        let mut cells = line.strip_prefix("//! |")?.split('|').map(str::trim);
        let floor = cells.next()?.parse().ok()?;
        Some((cells.next()?.trim_matches(['[', ']', '`']).to_owned(), floor))
    };
    text.lines().filter_map(row).collect()
}

/// Where a file stands in the tree of modules.
pub struct Module {
    /// The module of `lib.rs` that it belongs to.
    pub top: String,
    /// Modules between the root of the crate and the file's own items, itself included.
    pub depth: usize,
}

pub fn module_of(file: &str, floors: &Floors) -> Option<Module> {
    let path = file.strip_prefix("src/")?.strip_suffix(".rs")?;
    let parts: Vec<&str> = path.split('/').filter(|part| *part != "mod").collect();
    let top = parts.first()?.to_string();
    floors.contains_key(&top).then_some(Module { top, depth: parts.len() })
}

/// The first names of a path: one, or those of a group in braces.
pub fn heads_of(tokens: &[Token], start: usize) -> Vec<(usize, String)> {
    let head = |token: &Token| (token.line, token.text.clone());
    match tokens.get(start) {
        Some(token) if token.text == "{" => {
            let end = closing(tokens, start);
            let names = split(&tokens[start + 1..end], ",");
            names.iter().filter_map(|name| name.first()).map(head).collect()
        }
        Some(token) => vec![head(token)],
        None => Vec::new(),
    }
}

/// Names and variants of the enums that are declared.
fn enums_of(tokens: &[Token]) -> Vec<(String, Vec<String>)> {
    let mut enums = Vec::new();
    for index in 0..tokens.len() {
        let name = text_at(tokens, Some(index + 1));
        if tokens[index].text != "enum" || !is_name(name) {
            continue;
        }
        let mut open = index + 2;
        if text_at(tokens, Some(open)) == "<" {
            open = closing_angle(tokens, open) + 1;
        }
        if text_at(tokens, Some(open)) == "{" {
            let body = &tokens[open + 1..closing(tokens, open)];
            enums.push((
                name.to_owned(),
                split(body, ",").into_iter().filter_map(variant).collect(),
            ));
        }
    }
    enums
}

/// The name of a variant, behind its attributes.
fn variant(tokens: &[Token]) -> Option<String> {
    let mut at = 0;
    while text_at(tokens, Some(at)) == "#" {
        at = closing(tokens, at + 1) + 1;
    }
    tokens.get(at).filter(|token| is_name(&token.text)).map(|token| token.text.clone())
}
