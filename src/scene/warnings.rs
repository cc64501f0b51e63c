//! What is not rendered as it stands in the scene: said once a kind, however many objects it
//! befalls.

use crate::math::text::{counted, excerpt, is_predicate};

/// Most characters of a place and of what is said about it: names are the scene's.
const CHARACTERS_MAX: usize = 400;

/// The warnings about a scene, in the order in which their kinds were met.
#[derive(Default)]
pub struct Warnings(Vec<Kind>);

/// All warnings of a kind.
struct Kind {
    /// What is the same in all of them.
    key: &'static str,
    /// The first place.
    place: String,
    /// What is said about it.
    text: String,
    /// Places after the first.
    others: usize,
    /// What is counted, and how many of it there are in all places.
    sum: Option<([&'static str; 2], usize)>,
}

impl Warnings {
    /// Something about a place.
    pub fn add(&mut self, place: &str, text: &'static str) {
        self.add_like(text, place, text);
    }

    /// Something about a place in words of its own, of a kind that `key` names.
    pub fn add_like(&mut self, key: &'static str, place: &str, text: &str) {
        self.kind(key, place, text);
    }

    /// Some things in a place: one, or several of them, of which `text` is said.
    pub fn add_counted(
        &mut self,
        place: &str,
        count: usize,
        things: [&'static str; 2],
        text: &'static str,
    ) {
        if count > 0 {
            let kind = self.kind(text, place, text);
            let (_, sum) = kind.sum.get_or_insert((things, 0));
            *sum += count;
        }
    }

    fn kind(&mut self, key: &'static str, place: &str, text: &str) -> &mut Kind {
        let at = match self.0.iter().position(|kind| kind.key == key) {
            Some(at) => {
                self.0[at].others += 1;
                at
            }
            None => {
                let [place, text] = [place, text].map(|part| excerpt(part, CHARACTERS_MAX));
                self.0.push(Kind { key, place, text, others: 0, sum: None });
                self.0.len() - 1
            }
        };
        &mut self.0[at]
    }

    /// A sentence for each kind.
    pub fn sentences(self) -> Vec<String> {
        self.0.into_iter().map(Kind::sentence).collect()
    }
}

impl Kind {
    fn sentence(self) -> String {
        let Self { place, text, others, sum, .. } = self;
        let others = counted_others(others);
        if sum.is_none() && is_predicate(&text) && !place.is_empty() {
            let others = if others.is_empty() { others } else { format!(" ({others})") };
            return format!("{place}{others} {text}");
        }
        let others = if others.is_empty() { others } else { format!(" {others}") };
        let colon = if place.is_empty() { "" } else { ": " };
        let things = sum.map_or_else(String::new, |(things, sum)| counted(sum, things) + " ");
        format!("{place}{others}{colon}{things}{text}")
    }
}

/// How many places there are after the first, in words; nothing if there are none.
fn counted_others(others: usize) -> String {
    match others {
        0 => String::new(),
        others => format!("and {}", counted(others, ["other", "others"])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_one_sentence() {
        let mut warnings = Warnings::default();
        warnings.add("", "animations are ignored");
        warnings.add_counted("mesh 0", 2, ["triangle", "triangles"], "without area dropped");
        warnings.add("mesh 0", "vertex colors are ignored");
        warnings.add_counted("mesh 1", 0, ["triangle", "triangles"], "without area dropped");
        for mesh in 2..40_000 {
            let place = format!("mesh {mesh}");
            warnings.add_counted(&place, 1, ["triangle", "triangles"], "without area dropped");
        }
        warnings.add_like("alpha", "material 0 \"\x1b\"", "alpha 0.5 is ignored");
        warnings.add("material 3", "is unlit");
        warnings.add("material 5", "is unlit");
        warnings.add("node 1", "has no name");
        warnings.add("", "is nowhere");
        let expected = [
            "animations are ignored",
            "mesh 0 and 39998 others: 40000 triangles without area dropped",
            "mesh 0: vertex colors are ignored",
            "material 0 \"\\u{1b}\": alpha 0.5 is ignored",
            "material 3 (and 1 other) is unlit",
            "node 1 has no name",
            "is nowhere",
        ];
        assert_eq!(warnings.sentences(), expected);
    }
}
