//! Reads sources without a compiler: tokens, brackets, items between commas, functions.

#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

/// Names, `::` and single signs; comments are left out and literals are `""`.
pub fn tokens_of(text: &str) -> Vec<Token> {
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

/// The text of the token at `index`; empty past either end.
pub fn text_at(tokens: &[Token], index: Option<usize>) -> &str {
    index.and_then(|index| tokens.get(index)).map_or("", |token| &token.text)
}

/// Whether a token can be a name of the source.
pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The index of the bracket that closes the one at `open`; `open` itself if none stands there.
pub fn closing(tokens: &[Token], open: usize) -> usize {
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

/// The index of the `>` that closes the `<` at `open`; the `>` of `->` and `=>` closes nothing.
pub fn closing_angle(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0_i32;
    for index in open..tokens.len() {
        match tokens[index].text.as_str() {
            "<" => depth += 1,
            ">" if !matches!(tokens[index - 1].text.as_str(), "-" | "=") => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return index;
        }
    }
    tokens.len()
}

/// The pieces between the `separator`s that stand in no bracket; empty ones are left out.
pub fn split<'a>(tokens: &'a [Token], separator: &str) -> Vec<&'a [Token]> {
    let mut pieces = Vec::new();
    let (mut depth, mut start) = (0_i32, 0);
    for (index, token) in tokens.iter().enumerate() {
        match token.text.as_str() {
            text if text == separator && depth == 0 => {
                pieces.push(&tokens[start..index]);
                start = index + 1;
            }
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            ">" if index > 0 && !matches!(tokens[index - 1].text.as_str(), "-" | "=") => depth -= 1,
            _ => {}
        }
    }
    pieces.push(&tokens[start..]);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}
