//! The rules for stages: what leaves a stage's file, what a stage takes, and that its documentation
//! says the same as its parameters and its neighbors.
//!
//! A stage's documentation ends with two lines of clauses:
//!
//! ```text
//! From: scatter_surfaces, scatter_light. To: trace_closest.
//! Writes: paths (rays), hits. Reads: drawn, surfaces.
//! ```
//!
//! Each clause is a list of names, or `nothing`. `From` and `To` name stages, or what [`OUTSIDE`]
//! lists. `Writes` names the parameters that are `&mut`, `Reads` those that are `&`; what is given
//! by value, or both read and written, may stand among the latter. Parentheses name the groups of
//! columns that are meant.

use std::collections::BTreeMap;

use super::functions::{Access, Function, Visibility, visibility_before};
use super::rules::Broken;
use super::sources::{Source, Tree, heads_of};
use super::tokens::{Token, text_at};
use super::{OUTSIDE, STAGE_PARAMETERS_MAX, STAGES};

/// What a stage's documentation says.
#[derive(Default)]
pub struct Clauses {
    /// Names after `From`, `To`, `Writes`, `Reads`, each with the groups in parentheses.
    lists: BTreeMap<&'static str, Vec<(String, Vec<String>)>>,
}

const MARKS: [&str; 4] = ["From", "To", "Writes", "Reads"];

/// All stages, with where they stand; without clauses where those cannot be read.
type Stages<'a> = BTreeMap<&'a str, (&'a Source, &'a Function, Option<Clauses>)>;

/// Whether a file holds stages; the list of their modules holds none.
pub fn is_stage_file(file: &str) -> bool {
    file.strip_prefix(STAGES).is_some_and(|rest| rest != "mod.rs")
}

fn stem(file: &str) -> &str {
    let path = file.strip_prefix(STAGES).unwrap_or(file);
    path.split(['/', '.']).next().unwrap_or_default()
}

fn is_stage(function: &Function) -> bool {
    function.depth == 0 && function.visibility == Visibility::Public
}

/// Every rule that any stage breaks, alone or with others.
pub fn check_stages(tree: &Tree) -> Vec<String> {
    let files: Vec<&Source> = tree.sources.iter().filter(|s| is_stage_file(&s.file)).collect();
    let entries = files.iter().flat_map(|source| {
        let stages = source.functions.iter().filter(|function| is_stage(function));
        stages.map(|function| (function.name.as_str(), stem(&source.file)))
    });
    // A path to a stage goes through its module, or the list of modules shows its function.
    let peers = files.iter().map(|source| (stem(&source.file), stem(&source.file)));
    let peers: BTreeMap<&str, &str> = entries.chain(peers).collect();
    let mut list = Vec::new();
    let mut stages = Stages::new();
    for source in files {
        let mut broken = Broken { file: &source.file, list: Vec::new() };
        check_exports(&mut broken, source);
        check_peers(&mut broken, source, &peers);
        for function in source.functions.iter().filter(|function| is_stage(function)) {
            check_parameters(&mut broken, function);
            let clauses = clauses_of(source, function);
            match &clauses {
                Ok(clauses) => check_columns(&mut broken, source, function, clauses),
                Err(what) => broken.push(function.first_line, what),
            }
            stages.insert(&function.name, (source, function, clauses.ok()));
        }
        list.extend(broken.list);
    }
    list.extend(check_neighbors(&stages, tree));
    list
}

/// A stage's file has its name, and nothing leaves it but functions.
fn check_exports(broken: &mut Broken, source: &Source) {
    let name = stem(&source.file);
    if !source.functions.iter().any(|function| function.name == name && is_stage(function)) {
        broken.push(1, format!("no `pub fn {name}`: a stage's file has its name"));
    }
    for function in source.functions.iter().filter(|function| function.has_self) {
        if doc_above(&source.text, function.first_line).contains("Writes:") {
            broken.push(function.first_line, format!("`{}` has a `self`", function.name));
        }
    }
    let mut depth = 0_usize;
    for (index, token) in source.tokens.iter().enumerate() {
        match token.text.as_str() {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "struct" | "enum" | "trait" | "type" | "use" | "mod" | "static" | "union" | "fn"
            | "const"
                if depth == 0 =>
            {
                check_item(broken, &source.tokens, index);
            }
            _ => {}
        }
    }
}

fn check_item(broken: &mut Broken, tokens: &[Token], index: usize) {
    let (keyword, next) = (tokens[index].text.as_str(), text_at(tokens, Some(index + 1)));
    if keyword == "const" && matches!(next, "fn" | "unsafe") {
        return;
    }
    let shared = match visibility_before(tokens, index) {
        Visibility::Public => keyword != "fn",
        Visibility::Restricted => true,
        Visibility::Private => false,
    };
    if shared {
        let what = format!("`{keyword} {next}` leaves a stage: what stages share is no stage's");
        broken.push(tokens[index].line, what);
    }
}

/// No stage imports a stage; `peers` are the modules of what leads to one, by name.
fn check_peers(broken: &mut Broken, source: &Source, peers: &BTreeMap<&str, &str>) {
    let own = stem(&source.file);
    for (index, pair) in source.tokens.windows(2).enumerate() {
        let leads_to_stages = matches!(pair[0].text.as_str(), "super" | "stages");
        if !leads_to_stages || pair[1].text != "::" {
            continue;
        }
        for (line, name) in heads_of(&source.tokens, index + 2) {
            if peers.get(name.as_str()).is_some_and(|module| *module != own) {
                broken.push(line, format!("imports the stage {name}: stages are peers"));
            }
        }
    }
}

fn check_parameters(broken: &mut Broken, function: &Function) {
    let (name, count, most) = (&function.name, function.parameter_count(), STAGE_PARAMETERS_MAX);
    if count > most {
        let what = format!("`{name}` has {count} parameters, more than {most}");
        broken.push(function.first_line, what);
    }
    if function.has_self {
        broken.push(function.first_line, format!("`{name}` has a `self`"));
    }
    let first_read = function.parameters.iter().position(|p| p.access == Access::Read);
    let last_write = function.parameters.iter().rposition(|p| p.access == Access::Write);
    if let (Some(read), Some(write)) = (first_read, last_write)
        && read < write
    {
        let what = format!("`{name}` takes an input before an output: `&mut` comes first");
        broken.push(function.first_line, what);
    }
}

/// `Writes` and `Reads` are the parameters; their groups are names that the file knows.
fn check_columns(broken: &mut Broken, source: &Source, function: &Function, clauses: &Clauses) {
    let stage = &function.name;
    let line = function.first_line;
    for (mark, access) in [("Writes", Access::Write), ("Reads", Access::Read)] {
        let parameters = function.names(access);
        let named = &clauses.lists[mark];
        let may_stand = |name: &str| match access {
            Access::Write => parameters.contains(&name),
            Access::Read | Access::Own => function.parameters.iter().any(|p| p.name == name),
        };
        for name in parameters.iter().filter(|name| !named.iter().any(|(n, _)| n == *name)) {
            broken.push(line, format!("`{stage}`: {mark} lacks `{name}`"));
        }
        for (name, groups) in named {
            if !may_stand(name) {
                broken.push(line, format!("`{stage}`: {mark} names `{name}` wrongly"));
            }
            for group in groups.iter().filter(|g| !source.tokens.iter().any(|t| t.text == **g)) {
                broken.push(line, format!("`{stage}`: {mark} `{name}` has no `{group}` here"));
            }
        }
    }
}

/// From and To name each other, and only what there is.
fn check_neighbors(stages: &Stages, tree: &Tree) -> Vec<String> {
    let mut list = Vec::new();
    for (name, (source, function, clauses)) in stages {
        let mut broken = Broken { file: &source.file, list: Vec::new() };
        for (mark, opposite) in [("From", "To"), ("To", "From")] {
            let named = clauses.iter().flat_map(|clauses| &clauses.lists[mark]);
            for (other, _) in named {
                let wrong = match stages.get(other.as_str()) {
                    Some((_, _, theirs)) => theirs
                        .as_ref()
                        .filter(|theirs| !theirs.lists[opposite].iter().any(|(n, _)| n == name))
                        .map(|_| format!("whose {opposite} lacks it")),
                    None if !OUTSIDE.contains(&other.as_str()) => Some("which is no stage".into()),
                    None if other.contains(' ') || tree.has_function(other) => None,
                    None => Some("which is no function".into()),
                };
                let wrong = wrong.map(|wrong| format!("`{name}` is {mark}: {other}, {wrong}"));
                wrong.into_iter().for_each(|wrong| broken.push(function.first_line, wrong));
            }
        }
        list.extend(broken.list);
    }
    list
}

/// The documentation of the item at a line, without its slashes, as one line.
fn doc_above(text: &str, line: usize) -> String {
    let lines: Vec<&str> = text.lines().take(line.saturating_sub(1)).map(str::trim).collect();
    let is_doc = |line: &&&str| line.starts_with("///");
    let ends = |line: &&&str| line.is_empty() || line.ends_with(['}', ';']);
    // Attributes may stand between.
    let behind = lines.iter().rev().take_while(|line| !is_doc(line) && !ends(line)).count();
    let doc = lines[..lines.len() - behind].iter().rev().take_while(is_doc);
    let doc: Vec<&str> = doc.map(|line| line.trim_start_matches('/').trim()).collect();
    doc.into_iter().rev().collect::<Vec<_>>().join(" ")
}

/// The clauses of a stage, or what is wrong with them.
fn clauses_of(source: &Source, function: &Function) -> Result<Clauses, String> {
    let doc = doc_above(&source.text, function.first_line);
    let mut clauses = Clauses::default();
    for mark in MARKS {
        let marked = format!("{mark}: ");
        let begins = |at: &usize| *at == 0 || doc[..*at].ends_with([' ', '.']);
        let at = doc.match_indices(&marked).map(|(at, _)| at).find(begins);
        let rest = at.map(|at| &doc[at + marked.len()..]);
        let Some(list) = rest.and_then(|rest| rest.split('.').next()) else {
            return Err(format!("`{}` says nothing after `{mark}:`", function.name));
        };
        let items = list_of(list).map_err(|what| format!("`{}`: {mark}: {what}", function.name))?;
        clauses.lists.insert(mark, items);
    }
    Ok(clauses)
}

/// The items of a clause: names, each with its groups.
fn list_of(text: &str) -> Result<Vec<(String, Vec<String>)>, String> {
    let mut items = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() && rest != "nothing" {
        let end = rest.find([',', '(']).unwrap_or(rest.len());
        let name = rest[..end].trim();
        let mut groups = Vec::new();
        rest = &rest[end..];
        if let Some(inner) = rest.strip_prefix('(') {
            let close = inner.find(')').ok_or("a parenthesis stays open")?;
            groups.extend(inner[..close].split(',').map(|group| group.trim().to_owned()));
            rest = inner[close + 1..].trim_start();
        }
        let is_word = |word: &str| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if !(is_word(name) || OUTSIDE.contains(&name)) || !groups.iter().all(|g| is_word(g)) {
            return Err(format!("`{text}` is no list of names"));
        }
        items.push((name.to_owned(), groups));
        rest = match rest.strip_prefix(',') {
            Some(next) => next.trim_start(),
            None if rest.is_empty() => rest,
            None => return Err(format!("`{text}` is no list of names")),
        };
    }
    Ok(items)
}
