//! Words out of files, as they may be shown: a name or a cell that a stranger wrote must neither
//! act on a terminal nor fill it.

/// The text with its control characters escaped, those that turn the direction of writing too.
/// Lines stay lines.
pub fn printable(text: &str) -> String {
    escaped(text.chars(), |c| acts(c) && c != '\n')
}

/// The same as one line, cut to `most` characters.
pub fn excerpt(text: &str, most: usize) -> String {
    let mut cut = escaped(text.chars().take(most), acts);
    if text.chars().nth(most).is_some() {
        cut += "...";
    }
    cut
}

/// The items of a list between commas: the first ten, and how many more there are.
pub fn listed<T: AsRef<str>>(items: impl IntoIterator<Item = T>) -> String {
    const SHOWN: usize = 10;
    let mut items = items.into_iter();
    let mut shown: Vec<String> =
        items.by_ref().take(SHOWN).map(|item| item.as_ref().to_owned()).collect();
    match items.count() {
        0 => {}
        more => shown.push(format!("and {more} more")),
    }
    shown.join(", ")
}

/// A number of things, with the word for one or for several.
pub fn counted(count: usize, [one, several]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// The index that a word as `#3` stands for; zeros before it change nothing.
pub fn number_of(word: &str) -> Option<usize> {
    let digits = word.strip_prefix('#')?;
    let is_number = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
    digits.parse().ok().filter(|_| is_number)
}

fn escaped(text: impl Iterator<Item = char>, is_escaped: impl Fn(char) -> bool) -> String {
    let mut safe = String::new();
    for c in text {
        if is_escaped(c) { safe.extend(c.escape_default()) } else { safe.push(c) }
    }
    safe
}

/// Whether a character does something else on a terminal than to be seen: controls, and marks of
/// the direction of writing.
pub fn acts(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns
}

/// Whether what is said about something goes on with the sentence that its name begins.
pub fn is_predicate(text: &str) -> bool {
    const VERBS: &str = " are brings contradicts covers do does emits falls fill fills go goes has \
                         holds integrates is lacks leads lies means must names needs reaches \
                         reflects says stands takes was ";
    let word = text.split([' ', ',', ':']).next().unwrap_or_default();
    !word.is_empty() && VERBS.contains(&format!(" {word} "))
}

/// What is said about something with a name, as a sentence; without it, if the name is empty.
pub fn sentence(name: &str, said: &str) -> String {
    let separator = match () {
        () if name.is_empty() => "",
        () if is_predicate(said) => " ",
        () => ": ",
    };
    format!("{name}{separator}{said}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_on_a_terminal_is_escaped() {
        assert_eq!(printable("a\x1b[31m\nb\r\u{9b}é"), "a\\u{1b}[31m\nb\\r\\u{9b}é");
        assert_eq!(printable("exe\u{202e}txt"), "exe\\u{202e}txt");
        assert_eq!(excerpt("two\nlines", 100), "two\\nlines");
        assert_eq!(excerpt("étoile", 3), "éto...");
        assert_eq!(excerpt("étoile", 6), "étoile");
    }

    #[test]
    fn sentences_go_on_with_what_is_said() {
        assert_eq!(sentence("material 0", "is missing"), "material 0 is missing");
        assert_eq!(sentence("ior", "1.5 must be less"), "ior: 1.5 must be less");
        assert_eq!(sentence("", "is missing"), "is missing");
    }

    #[test]
    fn lists_end() {
        assert_eq!(listed(["a", "b"]), "a, b");
        let many = (0..12).map(|number| number.to_string());
        assert_eq!(listed(many), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, and 2 more");
        let words = ["triangle", "triangles"];
        assert_eq!(counted(1, words), "1 triangle");
        assert_eq!(counted(0, words), "0 triangles");
    }
}
