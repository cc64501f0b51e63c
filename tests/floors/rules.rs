//! The rules that one file breaks or keeps by itself.

use std::fmt::Display;

use super::kinds::catch_alls;
use super::sources::{Floors, Module, Source, Tree, heads_of, module_of};
use super::tokens::{Token, closing, text_at};
use super::{
    COLUMNS_MAX, CONFINED, FILE_LINES_MAX, FORBIDDEN, FUNCTION_LINES_MAX, KNOWS_NO_N, UNFINISHED,
};

/// What a file does wrong.
pub struct Broken<'a> {
    pub file: &'a str,
    pub list: Vec<String>,
}

impl Broken<'_> {
    pub fn push(&mut self, line: usize, what: impl Display) {
        self.list.push(format!("{}:{line}: {what}", self.file));
    }
}

pub fn check_file(broken: &mut Broken, source: &Source, tree: &Tree) {
    check_size(broken, &source.text);
    check_functions(broken, source);
    check_attributes(broken, &source.tokens);
    if let Some(module) = module_of(&source.file, &tree.floors) {
        check_imports(broken, &source.tokens, &module, &tree.floors);
        check_reexports(broken, &source.tokens, &module, &tree.floors);
        check_crates(broken, &source.tokens, &module);
        check_head(broken, &source.text, &module, &tree.floors);
    }
    if source.file.starts_with("src/") {
        check_kinds(broken, source, tree);
        check_wavelengths(broken, source);
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

fn check_functions(broken: &mut Broken, source: &Source) {
    for function in &source.functions {
        let lines = function.last_line + 1 - function.first_line;
        if lines > FUNCTION_LINES_MAX {
            let name = &function.name;
            let what = format!("`{name}` has {lines} lines, more than {FUNCTION_LINES_MAX}");
            broken.push(function.first_line, what);
        }
    }
    for pair in source.tokens.windows(2) {
        if pair[1].text == "!" && UNFINISHED.contains(&pair[0].text.as_str()) {
            broken.push(pair[0].line, format!("`{}!` is not finished code", pair[0].text));
        }
    }
}

fn check_attributes(broken: &mut Broken, tokens: &[Token]) {
    for (index, token) in tokens.iter().enumerate() {
        let follows_bracket = text_at(tokens, index.checked_sub(1)) == "[";
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
        let (own, floor) = (floors[&module.top], floors[&target]);
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

/// Modules of the crate that are named after `crate::`, or after enough `super::` to get there.
fn imports_of(tokens: &[Token], module: &Module, floors: &Floors) -> Vec<(usize, String)> {
    let mut imports = Vec::new();
    let mut index = 0;
    while index < tokens.len() {
        let supers = tokens[index..]
            .chunks_exact(2)
            .take_while(|pair| pair[0].text == "super" && pair[1].text == "::")
            .count();
        let is_crate = tokens[index].text == "crate" && text_at(tokens, Some(index + 1)) == "::";
        let start = index + if is_crate { 2 } else { 2 * supers };
        if is_crate || (supers > 0 && supers >= module.depth) {
            let named = heads_of(tokens, start);
            imports.extend(named.into_iter().filter(|(_, name)| floors.contains_key(name)));
        }
        index = start.max(index + 1);
    }
    imports
}

fn check_reexports(broken: &mut Broken, tokens: &[Token], module: &Module, floors: &Floors) {
    let mut start = 0;
    while let Some(found) = tokens[start..].iter().position(|token| token.text == "use") {
        let begin = start + found;
        let length = tokens[begin..].iter().position(|token| token.text == ";");
        let end = length.map_or(tokens.len(), |length| begin + length);
        if matches!(text_at(tokens, begin.checked_sub(1)), "pub" | ")") {
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
        let before = text_at(tokens, index.checked_sub(1));
        let after = text_at(tokens, Some(index + 1));
        let begins_path = before != "::" && (after == "::" || before == "use");
        let Some((name, homes)) = CONFINED.iter().find(|(name, _)| token.text == *name) else {
            continue;
        };
        if begins_path && !homes.contains(&module.top.as_str()) {
            let what = format!("the crate {name} is known in {} only", homes.join(", "));
            broken.push(token.line, what);
        }
    }
}

/// A module that names its floor in its first line names the right one.
fn check_head(broken: &mut Broken, text: &str, module: &Module, floors: &Floors) {
    let Some(rest) = text.strip_prefix("//! Floor ") else { return };
    let named: String = rest.chars().take_while(char::is_ascii_digit).collect();
    let own = floors[&module.top];
    if named != own.to_string() {
        broken.push(1, format!("says floor {named}, and {} is on floor {own}", module.top));
    }
}

fn check_kinds(broken: &mut Broken, source: &Source, tree: &Tree) {
    for (line, kind) in catch_alls(&source.tokens, &tree.enums) {
        broken.push(line, format!("a catch-all in a match on `{kind}`: name its variants"));
    }
}

fn check_wavelengths(broken: &mut Broken, source: &Source) {
    if !KNOWS_NO_N.iter().any(|prefix| source.file.starts_with(prefix)) {
        return;
    }
    for window in source.tokens.windows(4) {
        let texts: Vec<&str> = window.iter().map(|token| token.text.as_str()).collect();
        if texts == ["const", "N", ":", "usize"] {
            broken.push(window[0].line, "knows a number of wavelengths: shapes have none");
        }
    }
}
