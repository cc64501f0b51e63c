//! Numbers under flat names, `overhead.mirror.ppm.rgb.ratio` for one: what a record keeps.
//!
//! The last part of a name says what is better: more, if it is or ends with `speedup`,
//! `efficiency` or `per_second`, and less otherwise.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Ends of names whose figures are better if they are greater.
const MORE_IS_BETTER: [&str; 5] =
    ["speedup", "speed_ratio", "efficiency", "per_second", "per_cpu_second"];

/// Figures by name, in the order of the names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Figures(pub BTreeMap<String, f64>);

impl Figures {
    /// Adds a figure whose name has these parts; what is not finite is no figure.
    pub fn add(&mut self, name: &[&str], value: f64) {
        if value.is_finite() {
            self.0.insert(name.join("."), value);
        }
    }
}

/// Words as a part of a name: letters, digits, `-` and `_` stay as they are, all else is `_`.
pub fn part(words: &str) -> String {
    let is_kept = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    words.chars().map(|c| if is_kept(c) { c } else { '_' }).collect()
}

/// Whether a greater value of the figure is a better one.
pub fn more_is_better(name: &str) -> bool {
    // Of races: how much longer the other takes to the same error.
    let is_lead = name.starts_with("peers.") && name.ends_with(".equal_error_ratio");
    is_lead || MORE_IS_BETTER.iter().any(|end| name.ends_with(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_flat_and_values_finite() {
        let mut figures = Figures::default();
        figures.add(&["overhead", &part("my scene.v2"), "ratio"], 1.5);
        figures.add(&["overhead", "nothing"], f64::NAN);
        let expected = r#"{"overhead.my_scene_v2.ratio":1.5}"#;
        assert_eq!(serde_json::to_string(&figures).unwrap(), expected);
        assert!(more_is_better("scaling.threads.speedup") && more_is_better("a.rays_per_second"));
        assert!(!more_is_better("a.speedup.seconds"));
        let of_race = "peers.mitsuba.mirror.mono.equal_error_ratio";
        assert!(more_is_better(of_race) && !more_is_better("error.a.path.rgb.equal_error_ratio"));
    }
}
