//! No catch-all on a kind: an arm `_ =>` (or `other =>`) in a `match` that names variants of an
//! enum of this package. Who adds a variant is led to every such place by the compiler.

use std::collections::{BTreeMap, BTreeSet};

use super::tokens::{Token, closing, closing_angle, is_name, text_at};

/// Lines of the catch-alls, each with the enum.
pub fn catch_alls(
    tokens: &[Token],
    enums: &BTreeMap<String, BTreeSet<String>>,
) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for index in 0..tokens.len() {
        if tokens[index].text != "match" {
            continue;
        }
        let Some(open) = body_of(tokens, index) else { continue };
        let arms = arms_of(&tokens[open + 1..closing(tokens, open)]);
        let own = type_around(tokens, index);
        let kind = arms.iter().find_map(|arm| kind_named(arm, own.as_deref(), enums));
        for arm in arms.iter().filter(|arm| catches_all(arm)) {
            found.extend(kind.iter().map(|kind| (arm[0].line, kind.clone())));
        }
    }
    found
}

/// The brace that opens the arms: the first behind what is matched that stands in no bracket.
fn body_of(tokens: &[Token], start: usize) -> Option<usize> {
    let mut at = start + 1;
    while at < tokens.len() {
        match tokens[at].text.as_str() {
            "{" => return Some(at),
            "(" | "[" => at = closing(tokens, at) + 1,
            ";" | "}" => return None,
            _ => at += 1,
        }
    }
    None
}

/// The patterns of the arms, with their guards.
fn arms_of(body: &[Token]) -> Vec<&[Token]> {
    let is_arrow = |at: usize| body[at].text == "=" && text_at(body, Some(at + 1)) == ">";
    let mut arms = Vec::new();
    let mut start = 0;
    while start < body.len() {
        let mut at = start;
        while at < body.len() && !is_arrow(at) {
            at = if opens(&body[at]) { closing(body, at) + 1 } else { at + 1 };
        }
        arms.push(&body[start..at.min(body.len())]);
        start = end_of_arm(body, at + 2);
    }
    arms.retain(|arm| !arm.is_empty());
    arms
}

fn opens(token: &Token) -> bool {
    matches!(token.text.as_str(), "(" | "[" | "{")
}

/// Where the next arm begins; `start` is behind the arrow.
fn end_of_arm(body: &[Token], start: usize) -> usize {
    if text_at(body, Some(start)) == "{" {
        let end = closing(body, start) + 1;
        return if text_at(body, Some(end)) == "," { end + 1 } else { end };
    }
    let mut at = start;
    while at < body.len() {
        let is_turbofish = body[at].text == "::" && text_at(body, Some(at + 1)) == "<";
        at = match body[at].text.as_str() {
            "," => return at + 1,
            _ if is_turbofish => closing_angle(body, at + 1) + 1,
            _ if opens(&body[at]) => closing(body, at) + 1,
            _ => at + 1,
        };
    }
    at
}

/// The enum of which a pattern names a variant. `own` is what `Self` stands for.
fn kind_named(
    arm: &[Token],
    own: Option<&str>,
    enums: &BTreeMap<String, BTreeSet<String>>,
) -> Option<String> {
    let triples = arm.windows(3).filter(|w| w[1].text == "::");
    triples.into_iter().find_map(|w| {
        let name = if w[0].text == "Self" { own? } else { w[0].text.as_str() };
        enums
            .get(name)
            .is_some_and(|variants| variants.contains(&w[2].text))
            .then(|| name.to_owned())
    })
}

/// `_`, a name for whatever it is, and both within brackets, `Some` or `Ok`; a guard makes it
/// something else, for the compiler then asks for the rest.
fn catches_all(arm: &[Token]) -> bool {
    let texts: Vec<&str> = arm.iter().map(|token| token.text.as_str()).collect();
    if texts.contains(&"if") {
        return false;
    }
    let is_lower = |text: &str| is_name(text) && !text.starts_with(char::is_uppercase);
    match texts.as_slice() {
        [name] => is_lower(name) && !matches!(*name, "true" | "false"),
        _ => {
            texts.contains(&"_")
                && texts.iter().all(|text| matches!(*text, "_" | "(" | ")" | "," | "Some" | "Ok"))
        }
    }
}

/// The type of the innermost `impl` around a token.
fn type_around(tokens: &[Token], index: usize) -> Option<String> {
    // Not the `impl` of a parameter or a result.
    let begins = |at: usize| {
        matches!(text_at(tokens, at.checked_sub(1)), "" | "{" | "}" | ";" | "]" | "unsafe")
    };
    let starts = (0..index).rev().filter(|&at| tokens[at].text == "impl" && begins(at));
    starts.into_iter().find_map(|at| {
        let open = body_of(tokens, at)?;
        let around = open < index && closing(tokens, open) > index;
        around.then(|| implemented(&tokens[at + 1..open])).flatten()
    })
}

/// The last name of the type's path in the head of an `impl`.
fn implemented(head: &[Token]) -> Option<String> {
    let generics = text_at(head, Some(0)) == "<";
    let mut at = if generics { closing_angle(head, 0) + 1 } else { 0 };
    let mut name = None;
    while at < head.len() {
        match head[at].text.as_str() {
            "where" => break,
            "for" => name = None,
            "<" => at = closing_angle(head, at),
            text if is_name(text) => name = Some(text.to_owned()),
            _ => {}
        }
        at += 1;
    }
    name
}
