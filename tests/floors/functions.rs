//! Finds functions in tokens, and what their parameters let them do.

use super::tokens::{Token, closing, closing_angle, is_name, split, text_at};

/// Who can see an item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Visibility {
    Public,
    /// `pub(super)` and the like.
    Restricted,
    Private,
}

/// What a function can do with what it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Access {
    Write,
    Read,
    /// By value: its own.
    Own,
}

#[derive(Clone, Debug)]
pub struct Parameter {
    pub name: String,
    pub access: Access,
}

pub struct Function {
    pub name: String,
    pub visibility: Visibility,
    pub has_self: bool,
    /// `self` is none of them; the parts of tuples are one each.
    pub parameters: Vec<Parameter>,
    pub first_line: usize,
    pub last_line: usize,
    /// Brackets around it.
    pub depth: usize,
}

impl Function {
    /// Values that a caller has to think of, `self` included.
    pub fn parameter_count(&self) -> usize {
        self.parameters.len() + usize::from(self.has_self)
    }

    /// The parameters of one access, in order.
    pub fn names(&self, access: Access) -> Vec<&str> {
        let those = self.parameters.iter().filter(|parameter| parameter.access == access);
        those.map(|parameter| parameter.name.as_str()).collect()
    }
}

pub fn functions_of(tokens: &[Token]) -> Vec<Function> {
    let mut functions = Vec::new();
    let mut depth = 0_usize;
    for index in 0..tokens.len() {
        match tokens[index].text.as_str() {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "fn" if is_name(text_at(tokens, Some(index + 1))) => {
                functions.push(function_at(tokens, index, depth));
            }
            _ => {}
        }
    }
    functions
}

fn function_at(tokens: &[Token], index: usize, depth: usize) -> Function {
    let open = match text_at(tokens, Some(index + 2)) {
        "<" => closing_angle(tokens, index + 2) + 1,
        _ => index + 2,
    };
    let end = closing(tokens, open);
    let body = (end..tokens.len()).find(|&i| matches!(tokens[i].text.as_str(), "{" | ";"));
    let last = body.map_or(end, |body| closing(tokens, body));
    let items = split(tokens.get(open + 1..end).unwrap_or_default(), ",");
    let is_self = |item: &&[Token]| {
        item.iter().take_while(|token| token.text != ":").any(|token| token.text == "self")
    };
    let others = items.iter().filter(|item| !is_self(item));
    Function {
        name: tokens[index + 1].text.clone(),
        visibility: visibility_before(tokens, index),
        has_self: items.first().is_some_and(is_self),
        parameters: others.flat_map(|item| parameters_of(item)).collect(),
        first_line: tokens[index].line,
        last_line: tokens[last.min(tokens.len() - 1)].line,
        depth,
    }
}

/// The visibility of the item whose keyword stands at `index`, with `const`, `unsafe` and the like
/// in between at most.
pub fn visibility_before(tokens: &[Token], index: usize) -> Visibility {
    let mut at = index;
    while let Some(before) = at.checked_sub(1) {
        match tokens[before].text.as_str() {
            "const" | "unsafe" | "async" | "extern" | "\"\"" => at = before,
            "pub" => return Visibility::Public,
            ")" => {
                let open = tokens[..before].iter().rposition(|token| token.text == "(");
                let is_visibility = open
                    .and_then(|open| open.checked_sub(1))
                    .is_some_and(|index| tokens[index].text == "pub");
                return if is_visibility { Visibility::Restricted } else { Visibility::Private };
            }
            _ => return Visibility::Private,
        }
    }
    Visibility::Private
}

/// What one item of a parameter list binds.
fn parameters_of(item: &[Token]) -> Vec<Parameter> {
    let colon = item.iter().position(|token| token.text == ":").unwrap_or(item.len());
    let kind = item.get(colon + 1..).unwrap_or_default();
    bindings(&item[..colon], kind, access_of(kind))
}

/// Pairs the names of a pattern with the parts of its type. `outer` is the access through what
/// stands around both.
fn bindings(pattern: &[Token], kind: &[Token], outer: Access) -> Vec<Parameter> {
    let inside = |tokens: &[Token]| -> Vec<Vec<Token>> {
        let end = tokens.len().saturating_sub(1);
        let parts = split(tokens.get(1..end).unwrap_or_default(), ",");
        parts.into_iter().map(<[Token]>::to_vec).collect()
    };
    let opens = |tokens: &[Token], sign: &str| text_at(tokens, Some(0)) == sign;
    if opens(pattern, "(") || opens(pattern, "[") {
        let names = inside(pattern);
        let kinds = if opens(kind, "(") { inside(kind) } else { Vec::new() };
        let of_part = |(index, name): (usize, &Vec<Token>)| {
            let part = kinds.get(index).map(Vec::as_slice);
            bindings(name, part.unwrap_or_default(), part.map_or(outer, access_of))
        };
        return names.iter().enumerate().flat_map(of_part).collect();
    }
    let is_modifier = |token: &&Token| matches!(token.text.as_str(), "mut" | "ref" | "&");
    let name: String =
        pattern.iter().filter(|t| !is_modifier(t)).map(|token| token.text.as_str()).collect();
    // A tuple with one name is as many values as it has parts.
    let parts = if opens(kind, "(") { inside(kind).len().max(1) } else { 1 };
    vec![Parameter { name, access: outer }; parts]
}

/// `&mut T`, also within a tuple, array or `Option`, lets write; other references and views, which
/// have a lifetime, let read, unless their names end in `Mut`. Closures are values.
fn access_of(kind: &[Token]) -> Access {
    let texts: Vec<&str> = kind.iter().map(|token| token.text.as_str()).collect();
    if matches!(texts.first(), Some(&("impl" | "dyn" | "fn" | "for"))) {
        return Access::Own;
    }
    let follows = |index: usize| {
        let lifetime = texts.get(index + 1) == Some(&"'");
        texts.get(index + if lifetime { 3 } else { 1 }).copied().unwrap_or("")
    };
    let references = || (0..texts.len()).filter(|&index| texts[index] == "&");
    let is_view = texts.contains(&"'") && references().next().is_none();
    let head = texts.iter().take_while(|text| **text != "<").last();
    let is_mutable = references().any(|index| follows(index) == "mut")
        || (is_view && head.is_some_and(|head| head.ends_with("Mut")));
    if is_mutable {
        Access::Write
    } else if is_view || references().next().is_some() {
        Access::Read
    } else {
        Access::Own
    }
}
