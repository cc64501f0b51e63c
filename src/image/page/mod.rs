//! What pages have in common, those of one image and those of many: how they are put together,
//! their style, their colors and legends, and small scripts.
//!
//! A page is one HTML file with everything in it, opened from the disk: a template whose places
//! `{{name}}` are filled. What it knows stands in it as JSON, and pixels as deflated bytes in
//! base64.

mod colors;
mod packed;

use std::io::{self, Write};

use serde::Serialize;

pub use colors::Colors;
pub use packed::{push_bytes, push_floats};

/// The style that all pages have.
pub const STYLE: &str = include_str!("base.css");
/// The scripts that all pages have, in the order in which they stand there.
pub const SCRIPTS: [&str; 6] = [
    include_str!("words.js"),
    include_str!("inflate.js"),
    include_str!("stokes.js"),
    include_str!("colors.js"),
    include_str!("legend.js"),
    include_str!("readout.js"),
];

/// Writes a page: a template whose places are filled.
///
/// # Errors
/// What `fill` or the file says.
pub fn push_filled<W: Write>(
    out: &mut W,
    template: &str,
    mut fill: impl FnMut(&mut W, &str) -> io::Result<()>,
) -> io::Result<()> {
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((place, after)) = after.split_once("}}") else { break };
        out.write_all(before.as_bytes())?;
        fill(out, place)?;
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// Writes an element that holds packed bytes, by its id; `push` writes them.
///
/// # Errors
/// What `push` or the file says.
pub fn push_element<W: Write>(
    out: &mut W,
    id: &str,
    push: impl FnOnce(&mut W) -> io::Result<()>,
) -> io::Result<()> {
    write!(out, "<script type=\"application/octet-stream\" id=\"{id}\">")?;
    push(out)?;
    out.write_all(b"</script>\n")
}

/// Text as HTML.
pub fn escaped_text(text: &str) -> String {
    let escaped = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        _ => c.to_string(),
    };
    text.chars().map(escaped).collect()
}

/// JSON as text that may stand in a script element.
pub fn json_text(data: &impl Serialize) -> String {
    let text = serde_json::to_string(data).expect("numbers and words are JSON");
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                safe += &format!("\\u{:04x}", u32::from(c));
            }
            _ => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text() {
        assert_eq!(escaped_text("a\"b <i>&"), "a&quot;b &lt;i&gt;&amp;");
        assert_eq!(json_text(&"</script>"), "\"\\u003c/script\\u003e\"");
    }

    #[test]
    fn places_are_filled() {
        let mut out = Vec::new();
        push_filled(&mut out, "a{{b}}c{{d}}e{{f", |out, place| write!(out, "<{place}>")).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), "a<b>c<d>e{{f");
    }
}
