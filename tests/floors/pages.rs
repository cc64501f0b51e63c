//! The pages that say where things are: paths in tables lead to files, and the functions and types
//! that a row names are in the file that it names before them.

use super::tokens::{is_name, tokens_of};

/// Where paths of the package begin.
const FOLDERS: [&str; 5] = ["src/", "tests/", "scenes/", "benches/", "docs/"];

/// What is wrong in the tables of a page: a Markdown file, or the documentation of a source. `read`
/// gives the text of a file of the package, or of a folder nothing but that it is there.
pub fn check_page(page: &str, text: &str, read: &dyn Fn(&str) -> Option<String>) -> Vec<String> {
    let mut list = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim_start_matches("//!").trim();
        if !line.starts_with('|') {
            continue;
        }
        let mut source = None;
        for word in words_of(line) {
            let wrong = if FOLDERS.iter().any(|folder| word.starts_with(folder)) {
                let found = read(&word);
                let wrong = found.is_none().then(|| format!("there is no {word}"));
                source = found.filter(|_| word.ends_with(".rs")).map(|text| (word, text));
                wrong
            } else {
                let missing = source.as_ref().filter(|(_, text)| !declares(text, &word));
                missing.map(|(file, _)| format!("there is no `{word}` in {file}"))
            };
            list.extend(wrong.map(|wrong| format!("{page}:{}: {wrong}", index + 1)));
        }
    }
    list
}

/// What stands between backticks, and the targets of links, in order.
fn words_of(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = line;
    while let Some(at) = rest.find(['`', '(']) {
        let is_link = rest[at..].starts_with('(');
        let is_target = !is_link || rest[..at].ends_with(']');
        let inner = &rest[at + 1..];
        let Some(end) = inner.find(if is_link { ')' } else { '`' }) else { break };
        if is_target {
            words.push(inner[..end].to_owned());
            rest = &inner[end + 1..];
        } else {
            rest = inner;
        }
    }
    words
}

/// Whether a source declares a function, type, trait or constant of a name; before a method stands
/// its type, which the source knows at least. What is no name is not asked for.
fn declares(text: &str, word: &str) -> bool {
    const KEYWORDS: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "const", "mod"];
    let names: Vec<&str> = word.trim_end_matches("()").split("::").collect();
    let plain = |name: &&str| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let is_path = names.iter().all(|name| is_name(name) && plain(name));
    let tokens = tokens_of(text);
    let knows = |name: &&str| tokens.iter().any(|token| token.text == **name);
    let declares = |name: &&str| {
        tokens.windows(2).any(|w| KEYWORDS.contains(&w[0].text.as_str()) && w[1].text == **name)
    };
    !is_path || (names.iter().all(knows) && names.last().is_some_and(declares))
}
