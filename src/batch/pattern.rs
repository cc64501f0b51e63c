//! Names made of values: `out/{name}-{angle:05.1}.exr`.
//!
//! A field is a name and, behind a colon, `[[fill]align][0][width][.precision]` as in Rust and
//! Python; `{{` and `}}` are braces.

use serde_json::Value;

/// A name with fields in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern(Vec<Piece>);

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Field(String, Format),
}

/// How a value is written.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Format {
    fill: char,
    align: Option<Align>,
    zeros: bool,
    width: usize,
    precision: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Align {
    Left,
    Center,
    Right,
}

/// Largest width and precision.
const WIDTH_MAX: usize = 100;

impl Pattern {
    /// Reads a pattern.
    ///
    /// # Errors
    /// In words, what is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut pieces = Vec::new();
        let mut open = String::new();
        let mut rest = text;
        while let Some(at) = rest.find(['{', '}']) {
            let (before, tail) = rest.split_at(at);
            open.push_str(before);
            let brace = &tail[..1];
            if tail[1..].starts_with(brace) {
                open.push_str(brace);
                rest = &tail[2..];
                continue;
            }
            let inner = tail.strip_prefix('{').and_then(|tail| tail.split_once('}'));
            let Some((inner, after)) = inner else {
                return Err(format!("a `{brace}` has no partner; write `{brace}{brace}` for one"));
            };
            let (name, format) = inner.split_once(':').unwrap_or((inner, ""));
            let format = Format::parse(format)
                .ok_or_else(|| format!("`{format}` is no format; write as in {{{name}:05.1}}"))?;
            pieces.push(Piece::Text(std::mem::take(&mut open)));
            pieces.push(Piece::Field(name.to_owned(), format));
            rest = after;
        }
        open.push_str(rest);
        pieces.push(Piece::Text(open));
        Ok(Self(pieces))
    }

    /// The names of its fields.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(|piece| match piece {
            Piece::Field(name, _) => Some(name.as_str()),
            Piece::Text(_) => None,
        })
    }

    /// The name that values make, by field and by whether it is rounded here. What would lead into
    /// other folders becomes `_`.
    pub fn fill<'a>(&self, value_of: impl Fn(&str, bool) -> Option<&'a Value>) -> String {
        let mut name = String::new();
        for piece in &self.0 {
            match piece {
                Piece::Text(text) => name.push_str(text),
                Piece::Field(field, format) => {
                    let value = value_of(field, format.precision.is_some());
                    let text = value.map(|value| format.write(value)).unwrap_or_default();
                    let leads = |c: char| matches!(c, '/' | '\\' | ':') || c.is_control();
                    name.extend(text.chars().map(|c| if leads(c) { '_' } else { c }));
                }
            }
        }
        name
    }
}

impl Format {
    fn parse(text: &str) -> Option<Self> {
        let align = |c: char| match c {
            '<' => Some(Align::Left),
            '^' => Some(Align::Center),
            '>' => Some(Align::Right),
            _ => None,
        };
        let mut format = Self { fill: ' ', align: None, zeros: false, width: 0, precision: None };
        let mut chars = text.chars();
        let mut rest = text;
        match (chars.next(), chars.next()) {
            (Some(fill), Some(second)) if align(second).is_some() => {
                (format.fill, format.align) = (fill, align(second));
                rest = chars.as_str();
            }
            (Some(first), _) if align(first).is_some() => {
                format.align = align(first);
                rest = &text[1..];
            }
            _ => {}
        }
        if let Some(tail) = rest.strip_prefix('0') {
            format.zeros = true;
            rest = tail;
        }
        // Python's types of numbers say nothing new.
        let rest = rest.strip_suffix(['d', 'f', 's']).unwrap_or(rest);
        let (width, precision) = match rest.split_once('.') {
            Some((width, precision)) => (width, Some(number(precision)?)),
            None => (rest, None),
        };
        format.width = if width.is_empty() { 0 } else { number(width)? };
        format.precision = precision;
        Some(format)
    }

    fn write(&self, value: &Value) -> String {
        let precision = self.precision;
        let text = match value {
            Value::Number(number) => match (number.as_f64(), precision) {
                (Some(number), Some(precision)) => format!("{number:.precision$}"),
                _ => number.to_string(),
            },
            Value::String(text) => text.chars().take(precision.unwrap_or(usize::MAX)).collect(),
            Value::Array(list) => {
                let plain = Self { width: 0, zeros: false, ..*self };
                list.iter().map(|item| plain.write(item)).collect::<Vec<_>>().join(",")
            }
            Value::Null | Value::Bool(_) | Value::Object(_) => value.to_string(),
        };
        let missing = self.width.saturating_sub(text.chars().count());
        if self.zeros && value.is_number() {
            let (sign, digits) = match text.strip_prefix('-') {
                Some(digits) => ("-", digits),
                None => ("", text.as_str()),
            };
            return format!("{sign}{}{digits}", "0".repeat(missing));
        }
        let by_kind = if value.is_number() { Align::Right } else { Align::Left };
        let before = match self.align.unwrap_or(by_kind) {
            Align::Left => 0,
            Align::Center => missing / 2,
            Align::Right => missing,
        };
        let fill = |count: usize| self.fill.to_string().repeat(count);
        format!("{}{text}{}", fill(before), fill(missing - before))
    }
}

fn number(text: &str) -> Option<usize> {
    text.parse().ok().filter(|number| *number <= WIDTH_MAX)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn values_are_written_as_rust_and_python_do() {
        for (pattern, value, expected) in [
            ("{v}", json!(30), "30"),
            ("{v}", json!(1.33), "1.33"),
            ("{v:05.1}", json!(5), "005.0"),
            ("{v:05.1f}", json!(-2.25), "-02.2"),
            ("{v:04}", json!(7), "0007"),
            ("{v:04d}", json!(-7), "-007"),
            ("{v:>4}|{v:<4}|{v:*^4}", json!("ab"), "  ab|ab  |*ab*"),
            ("{v:.2}", json!("abc"), "ab"),
            ("{v:6}", json!(1.5), "   1.5"),
            ("{v:.1}", json!([1, 0.25]), "1.0,0.2"),
            ("{{{v}}}", json!(true), "{true}"),
            ("a {v} b", json!("../x:y"), "a .._x_y b"),
        ] {
            let name = Pattern::parse(pattern).unwrap().fill(|_, _| Some(&value));
            assert_eq!(name, expected, "{pattern}");
        }
        for (bad, words) in [
            ("{v", "a `{` has no partner"),
            ("v}", "a `}` has no partner"),
            ("{v:x}", "`x` is no format"),
            ("{v:05.}", "no format"),
            ("{v:999}", "no format"),
        ] {
            let error = Pattern::parse(bad).unwrap_err();
            assert!(error.contains(words), "{bad}: {error}");
        }
    }
}
