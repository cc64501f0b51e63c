//! The architecture as a test: modules are floors and import only from lower ones, outside crates
//! stay where they belong, and no file, function or line outgrows its bound.
//!
//! The floors are read from the table in `src/lib.rs`, so that table cannot lie. Rules that a
//! source breaks are listed one per line, with file and line number; the last tests feed the
//! checker sources that break each rule, so the checker itself cannot go blind.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Longest line, in columns.
const COLUMNS_MAX: usize = 100;
/// Longest function, in lines.
const FUNCTION_LINES_MAX: usize = 70;
/// Longest file, in lines.
const FILE_LINES_MAX: usize = 600;
/// Most parameters of a stage: with more, it is two stages.
const STAGE_PARAMETERS_MAX: usize = 7;
/// Where the stages live.
const STAGES: &str = "src/transport/stages/";
/// Macros that have no place in finished code.
const UNFINISHED: [&str; 3] = ["todo", "unimplemented", "dbg"];

/// Outside crates that only some modules may know.
const CONFINED: [(&str, &[&str]); 8] = [
    ("hecs", &["scene"]),
    ("gltf", &["scene"]),
    ("obvhs", &["geometry"]),
    ("memmap2", &["geometry"]),
    ("exr", &["image"]),
    ("plotters", &["bench"]),
    ("clap", &["cli"]),
    ("rayon", &["geometry", "transport", "film", "render"]),
];

/// Modules below the floors' resolution: (files that start so, module they may not import, why).
const FORBIDDEN: [(&str, &str, &str); 1] =
    [("src/transport/mis", "polarization", "weights never see Stokes values")];

type Floors = BTreeMap<String, u32>;

#[test]
fn the_sources_keep_the_rules() {
    let floors = floors_of(&read("src/lib.rs"));
    let mut broken = Vec::new();
    for file in sources() {
        broken.extend(violations(&file, &read(&file), &floors));
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

// ---- the rules --------------------------------------------------------------------------------

/// Every rule that the text of `file` (a path from the root of the package) breaks.
fn violations(file: &str, text: &str, floors: &Floors) -> Vec<String> {
    let tokens = tokens_of(text);
    let mut broken = Broken { file, list: Vec::new() };
    check_size(&mut broken, text);
    check_functions(&mut broken, &tokens);
    check_attributes(&mut broken, &tokens);
    if let Some(module) = module_of(file, floors) {
        check_imports(&mut broken, &tokens, &module, floors);
        check_reexports(&mut broken, &tokens, &module, floors);
        check_crates(&mut broken, &tokens, &module);
    }
    if file.starts_with(STAGES) && !file.ends_with("/mod.rs") {
        check_stage(&mut broken, &tokens);
    }
    broken.list
}

struct Broken<'a> {
    file: &'a str,
    list: Vec<String>,
}

impl Broken<'_> {
    fn push(&mut self, line: usize, what: impl std::fmt::Display) {
        self.list.push(format!("{}:{line}: {what}", self.file));
    }
}

fn check_size(broken: &mut Broken, text: &str) {
    if !text.starts_with("//!") {
        broken.push(1, "a file starts with its `//!` documentation");
    }
    let lines = text.lines().count();
    if lines > FILE_LINES_MAX {
        broken.push(lines, format!("the file has {lines} lines, more than {FILE_LINES_MAX}"));
    }
    for (index, line) in text.lines().enumerate() {
        let columns = line.chars().count();
        if columns > COLUMNS_MAX {
            broken.push(index + 1, format!("{columns} columns, more than {COLUMNS_MAX}"));
        }
    }
}

fn check_functions(broken: &mut Broken, tokens: &[Token]) {
    for function in functions_of(tokens) {
        let lines = function.last_line + 1 - function.first_line;
        if lines > FUNCTION_LINES_MAX {
            let name = &function.name;
            let what = format!("`{name}` has {lines} lines, more than {FUNCTION_LINES_MAX}");
            broken.push(function.first_line, what);
        }
    }
    for pair in tokens.windows(2) {
        if pair[1].text == "!" && UNFINISHED.contains(&pair[0].text.as_str()) {
            broken.push(pair[0].line, format!("`{}!` is not finished code", pair[0].text));
        }
    }
}

fn check_attributes(broken: &mut Broken, tokens: &[Token]) {
    for (index, token) in tokens.iter().enumerate() {
        let follows_bracket = index > 0 && tokens[index - 1].text == "[";
        if !follows_bracket || !matches!(token.text.as_str(), "allow" | "expect") {
            continue;
        }
        let end = closing(tokens, index + 1);
        if !tokens[index..end].iter().any(|token| token.text == "reason") {
            broken.push(token.line, format!("`#[{}]` without a reason", token.text));
        }
    }
}

fn check_imports(broken: &mut Broken, tokens: &[Token], module: &Module, floors: &Floors) {
    for (line, target) in imports_of(tokens, module, floors) {
        let own = floors[&module.top];
        let Some(&floor) = floors.get(&target) else { continue };
        if target != module.top && floor >= own {
            let side = if floor == own { "sideways" } else { "upward" };
            let what = format!("{side} import: {} ({own}) uses {target} ({floor})", module.top);
            broken.push(line, what);
        }
        for (prefix, forbidden, why) in FORBIDDEN {
            if broken.file.starts_with(prefix) && target == forbidden {
                broken.push(line, format!("imports {target}: {why}"));
            }
        }
    }
}

fn check_reexports(broken: &mut Broken, tokens: &[Token], module: &Module, floors: &Floors) {
    let mut start = 0;
    while let Some(found) = tokens[start..].iter().position(|token| token.text == "use") {
        let begin = start + found;
        let length = tokens[begin..].iter().position(|token| token.text == ";");
        let end = length.map_or(tokens.len(), |length| begin + length);
        let before = begin.checked_sub(1).map_or("", |index| tokens[index].text.as_str());
        if before == "pub" || before == ")" {
            for (line, target) in imports_of(&tokens[begin..end], module, floors) {
                if target != module.top {
                    broken.push(line, format!("re-exports from another floor: {target}"));
                }
            }
        }
        start = end;
    }
}

fn check_crates(broken: &mut Broken, tokens: &[Token], module: &Module) {
    for (index, token) in tokens.iter().enumerate() {
        let text = |offset: isize| {
            index.checked_add_signed(offset).and_then(|at| tokens.get(at)).map_or("", |t| &t.text)
        };
        let begins_path = text(-1) != "::" && (text(1) == "::" || text(-1) == "use");
        let Some((name, homes)) = CONFINED.iter().find(|(name, _)| token.text == *name) else {
            continue;
        };
        if begins_path && !homes.contains(&module.top.as_str()) {
            let what = format!("the crate {name} is known in {} only", homes.join(", "));
            broken.push(token.line, what);
        }
    }
}

fn check_stage(broken: &mut Broken, tokens: &[Token]) {
    let stem = Path::new(broken.file).file_stem().unwrap_or_default().to_string_lossy();
    let functions = functions_of(tokens);
    if !functions.iter().any(|function| function.name == stem) {
        broken.push(1, format!("no function `{stem}`: a stage's file has its name"));
    }
    // Stages that differ between the modes are methods of a trait, and public through it.
    for function in functions.iter().filter(|f| f.is_public || f.name == stem) {
        if function.parameters > STAGE_PARAMETERS_MAX {
            let Function { name, parameters, .. } = function;
            let what = format!("`{name}` has {parameters} parameters, a stage has at most 7");
            broken.push(function.first_line, what);
        }
    }
}

// ---- reading the sources ----------------------------------------------------------------------

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// All Rust files of the package, as paths from its root with `/` between.
fn sources() -> Vec<String> {
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
fn floors_of(text: &str) -> Floors {
    let row = |line: &str| -> Option<(String, u32)> {
        let mut cells = line.strip_prefix("//! |")?.split('|').map(str::trim);
        let floor = cells.next()?.parse().ok()?;
        Some((cells.next()?.trim_matches(['[', ']', '`']).to_owned(), floor))
    };
    text.lines().filter_map(row).collect()
}

/// Where a file stands in the tree of modules.
struct Module {
    /// The module of `lib.rs` that it belongs to.
    top: String,
    /// Modules between the root of the crate and the file's own items, itself included.
    depth: usize,
}

fn module_of(file: &str, floors: &Floors) -> Option<Module> {
    let path = file.strip_prefix("src/")?.strip_suffix(".rs")?;
    let parts: Vec<&str> = path.split('/').filter(|part| *part != "mod").collect();
    let top = parts.first()?.to_string();
    floors.contains_key(&top).then_some(Module { top, depth: parts.len() })
}

/// Modules of the crate that are named after `crate::`, or after enough `super::` to get there.
fn imports_of(tokens: &[Token], module: &Module, floors: &Floors) -> Vec<(usize, String)> {
    let mut imports = Vec::new();
    let mut index = 0;
    while index < tokens.len() {
        let supers = tokens[index..]
            .chunks_exact(2)
            .take_while(|pair| pair[0].text == "super" && pair[1].text == "::")
            .count();
        let is_crate = tokens[index].text == "crate"
            && tokens.get(index + 1).is_some_and(|token| token.text == "::");
        let start = index + if is_crate { 2 } else { 2 * supers };
        if is_crate || (supers > 0 && supers >= module.depth) {
            let named = heads_of(tokens, start);
            imports.extend(named.into_iter().filter(|(_, name)| floors.contains_key(name)));
        }
        index = start.max(index + 1);
    }
    imports
}

/// The first names of a path: one, or those of a group in braces.
fn heads_of(tokens: &[Token], start: usize) -> Vec<(usize, String)> {
    let head = |token: &Token| (token.line, token.text.clone());
    match tokens.get(start) {
        Some(token) if token.text == "{" => {
            let end = closing(tokens, start);
            let mut depth = 0;
            let mut heads = Vec::new();
            for pair in tokens[start..end].windows(2) {
                match pair[0].text.as_str() {
                    "{" => depth += 1,
                    "}" => depth -= 1,
                    _ => {}
                }
                if depth == 1 && matches!(pair[0].text.as_str(), "{" | ",") {
                    heads.push(head(&pair[1]));
                }
            }
            heads
        }
        Some(token) => vec![head(token)],
        None => Vec::new(),
    }
}

struct Function {
    name: String,
    is_public: bool,
    parameters: usize,
    first_line: usize,
    last_line: usize,
}

fn functions_of(tokens: &[Token]) -> Vec<Function> {
    let is_name = |text: &str| text.starts_with(|c: char| c.is_alphabetic() || c == '_');
    (tokens.windows(2).enumerate())
        .filter(|(_, pair)| pair[0].text == "fn" && is_name(&pair[1].text))
        .map(|(index, pair)| {
            let open = skip_generics(tokens, index + 2);
            let end = closing(tokens, open);
            let body = (end..tokens.len()).find(|&i| matches!(tokens[i].text.as_str(), "{" | ";"));
            let last = body.map_or(end, |body| closing(tokens, body));
            // `pub`, or `pub(super)` and the like, with `const` in between at most.
            let before = &tokens[index.saturating_sub(5)..index];
            let visible = before.iter().rposition(|token| token.text == "pub");
            let is_public = visible.is_some_and(|at| {
                let between = before[at + 1..].iter().map(|token| token.text.as_str());
                between.clone().all(|t| matches!(t, "(" | ")" | "super" | "crate" | "const"))
            });
            Function {
                name: pair[1].text.clone(),
                is_public,
                parameters: count_items(&tokens[open..end]),
                first_line: pair[0].line,
                last_line: tokens[last.min(tokens.len() - 1)].line,
            }
        })
        .collect()
}

/// The index of the parenthesis that opens the parameters, behind the generics that may stand at
/// `start`; the `>` of `->` in a bound closes nothing.
fn skip_generics(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0_i32;
    for index in start..tokens.len() {
        match tokens[index].text.as_str() {
            "<" => depth += 1,
            ">" if tokens[index - 1].text != "-" => depth -= 1,
            "(" if depth == 0 => return index,
            _ => {}
        }
    }
    tokens.len()
}

/// The index of the bracket that closes the one at `open`; `open` itself if none stands there.
fn closing(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0_i32;
    for (index, token) in tokens.iter().enumerate().skip(open) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return index;
        }
    }
    tokens.len()
}

/// The number of items between commas in a list whose opening bracket is the first token.
fn count_items(list: &[Token]) -> usize {
    let mut depth = 0_i32;
    let mut items = 0;
    let mut is_empty = true;
    for (index, token) in list.iter().enumerate().skip(1) {
        match token.text.as_str() {
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            ">" if list[index - 1].text != "-" => depth -= 1,
            _ => {}
        }
        if token.text == "," && depth == 0 {
            items += 1;
            is_empty = true;
        } else {
            is_empty = false;
        }
    }
    items + usize::from(!is_empty)
}

// ---- tokens -----------------------------------------------------------------------------------

#[derive(Debug, PartialEq)]
struct Token {
    text: String,
    line: usize,
}

/// Names, `::` and single signs; comments are left out and literals are `""`.
fn tokens_of(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let (mut at, mut line) = (0, 1);
    while at < chars.len() {
        let end = end_of_token(&chars, at);
        let piece: String = chars[at..end].iter().collect();
        let is_comment = piece.starts_with("//") || piece.starts_with("/*");
        if !is_comment && !piece.trim().is_empty() {
            let is_literal = piece.len() > 1 && piece.ends_with(['"', '\'', '#']);
            let text = if is_literal { "\"\"".to_owned() } else { piece.clone() };
            tokens.push(Token { text, line });
        }
        line += piece.matches('\n').count();
        at = end;
    }
    tokens
}

fn end_of_token(chars: &[char], at: usize) -> usize {
    let next = |offset: usize| chars.get(at + offset).copied().unwrap_or(' ');
    let until = |start: usize, found: &dyn Fn(usize) -> bool| {
        (start..chars.len()).find(|&i| found(i)).unwrap_or(chars.len())
    };
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    match (chars[at], next(1)) {
        ('/', '/') => until(at, &|i| chars[i] == '\n'),
        ('/', '*') => until(at + 2, &|i| chars[i] == '/' && chars[i - 1] == '*' && i > at + 2) + 1,
        (':', ':') => at + 2,
        ('r', '"' | '#') | ('b', 'r') => end_of_raw_string(chars, at),
        ('b', '"') => end_of_quotes(chars, at + 1),
        ('"', _) => end_of_quotes(chars, at),
        ('\'', '\\') => until(at + 3, &|i| chars[i] == '\'') + 1,
        ('\'', _) if next(2) == '\'' => at + 3,
        (c, _) if is_name(c) => until(at, &|i| !is_name(chars[i])),
        _ => at + 1,
    }
}

fn end_of_quotes(chars: &[char], open: usize) -> usize {
    let mut at = open + 1;
    while at < chars.len() && chars[at] != '"' {
        at += if chars[at] == '\\' { 2 } else { 1 };
    }
    (at + 1).min(chars.len())
}

/// The end of `r#"..."#`, or of the name that only begins like it.
fn end_of_raw_string(chars: &[char], at: usize) -> usize {
    let prefix = if chars[at] == 'b' { 2 } else { 1 };
    let hashes = chars[at + prefix..].iter().take_while(|c| **c == '#').count();
    let open = at + prefix + hashes;
    if chars.get(open) != Some(&'"') {
        let is_name = |c: &char| c.is_alphanumeric() || *c == '_' || *c == '#';
        return at + chars[at..].iter().take_while(|c| is_name(c)).count();
    }
    let closes = |i: &usize| {
        chars[*i] == '"'
            && chars[i + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes
    };
    (open + 1..chars.len()).find(closes).map_or(chars.len(), |i| i + 1 + hashes)
}

// ---- the checker can fail ---------------------------------------------------------------------

/// The one rule that a source breaks, or nothing; the file's documentation is added.
fn broken_by(file: &str, text: &str) -> String {
    let floors = floors_of(&read("src/lib.rs"));
    violations(file, &format!("//! A file.\n{text}\n"), &floors).join("\n")
}

#[test]
fn imports_that_climb_are_found() {
    let cases = [
        ("src/math/a.rs", "use crate::film::Film;", "upward import: math (0) uses film (3)"),
        ("src/film/a.rs", "use crate::{math::F32s, cli::{run, x}};", "film (3) uses cli (11)"),
        ("src/spectrum/a.rs", "use crate::polarization::Stokes;", "sideways import"),
        ("src/scene/a/b.rs", "fn f() { super::super::super::render::save() }", "uses render (9)"),
        ("src/geometry/mod.rs", "use super::transport::Chunk;", "uses transport (7)"),
        ("src/transport/mis.rs", "use crate::polarization::Stokes;", "never see Stokes values"),
        ("src/film/a.rs", "pub use crate::math::F32s;", "re-exports from another floor: math"),
        ("src/film/a.rs", "pub(crate) use crate::math;", "re-exports from another floor: math"),
    ];
    for (file, text, expected) in cases {
        let found = broken_by(file, text);
        assert!(found.contains(expected), "{file}: {text}: {found:?} lacks {expected:?}");
        assert_eq!(found.lines().count(), 1, "{found}");
    }
}

#[test]
fn crates_out_of_place_are_found() {
    let cases = [
        ("src/film/a.rs", "use hecs::World;"),
        ("src/image/a.rs", "fn f(a: gltf::Gltf) {}"),
        ("src/transport/a.rs", "use obvhs;"),
        ("src/film/a.rs", "use exr::prelude::*;"),
        ("src/cli/a.rs", "use plotters::prelude::*;"),
        ("src/image/a.rs", "#[derive(clap::Parser)] struct A;"),
        ("src/image/a.rs", "use rayon::prelude::*;"),
    ];
    for (file, text) in cases {
        assert!(broken_by(file, text).contains("is known in"), "{file}: {text}");
    }
}

#[test]
fn sizes_and_unfinished_code_are_found() {
    let long_function = format!("fn f() {{\n{}}}", "    g();\n".repeat(70));
    let cases = [
        ("fn f() { todo!() }".to_owned(), "`todo!`"),
        ("fn f() { dbg!(1); }".to_owned(), "`dbg!`"),
        ("#[allow(dead_code)]\nfn f() {}".to_owned(), "without a reason"),
        (format!("// {}", "x".repeat(98)), "101 columns"),
        (long_function, "`f` has 72 lines"),
        ("\n".repeat(600), "602 lines"),
    ];
    for (text, expected) in cases {
        let found = broken_by("tests/a.rs", &text);
        assert!(found.contains(expected), "{found:?} lacks {expected:?}");
    }
    let undocumented = violations("src/film/a.rs", "use std::fs;", &Floors::new());
    assert!(undocumented[0].contains("starts with its"), "{undocumented:?}");
}

#[test]
fn stages_out_of_shape_are_found() {
    let eight = "pub fn a<F: Fn(u8) -> (u8, u8)>(a: &mut [(u8, u8); 2], b: F, c: u8, d: u8, \
                 e: u8, f: u8, g: u8, h: u8) {}";
    assert!(broken_by("src/transport/stages/a.rs", eight).contains("8 parameters"));
    let seven = eight.replace(", h: u8", ",");
    assert_eq!(broken_by("src/transport/stages/a.rs", &seven), "");
    assert!(broken_by("src/transport/stages/b.rs", &seven).contains("no function `b`"));
    let method = "trait T { fn a(&self, a: u8, b: u8, c: u8, d: u8, e: u8, f: u8, g: u8); }";
    assert!(broken_by("src/transport/stages/a.rs", method).contains("8 parameters"));
}

#[test]
fn what_only_looks_wrong_is_not_found() {
    let innocent = [
        "// use crate::cli::run; todo!()",
        "/* use crate::cli; */",
        "const A: &str = \"crate::cli::run \\\" hecs::World\";",
        "const A: &str = r#\"use crate::cli; \"dbg!(1)\"#;",
        "const A: [char; 3] = ['\"', '\\'', '{'];",
        "fn f<'a>(a: &'a str) -> &'a str { a }",
        "use crate::{image, math::F32s};",
        "#[expect(dead_code, reason = \"so\")]\nfn f() {}",
        "mod tests { use super::super::image; }",
        "fn f() { crate::film::exr::write() }",
        "pub use self::accumulator::Film;",
    ];
    for text in innocent {
        assert_eq!(broken_by("src/film/a.rs", text), "", "{text}");
    }
}
