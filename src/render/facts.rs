//! Facts of renders in files, as text: colors and analyzers to read again, and what is shown.

use std::sync::Arc;

use crate::math::text::excerpt;
use crate::polarization::Analyzer;
use crate::spectrum::{Bands, Color, Curves};

/// The fact of what the channels stand for, as [`color_text`] writes it.
pub const COLOR: &str = "image: color";
/// That of what is white to a film: a name, and numbers in brackets.
pub const BALANCE: &str = "image: white balance";
/// Most characters of a fact that is shown: responses have thousands.
const VALUE: usize = 200;

/// What a fact says, in words where its text is for programs: a color, and the balance of one.
pub fn in_words(name: &str, value: &str) -> String {
    let words = match name {
        COLOR => color_of(value).map(|color| color.to_string()),
        BALANCE => value.split_once(" [").map(|(light, _)| light.to_owned()),
        _ => None,
    };
    excerpt(words.as_deref().unwrap_or(value), VALUE)
}

/// The same of two that differ, where the words must, too.
pub fn both_in_words(name: &str, values: [&str; 2]) -> [String; 2] {
    let words = values.map(|value| in_words(name, value));
    if words[0] != words[1] {
        return words;
    }
    let colors = values.map(|value| if name == COLOR { color_of(value) } else { None });
    if let [Some(one), Some(two)] = &colors {
        let what = one.difference(two).unwrap_or("their channels have other names".to_owned());
        return [words[0].clone(), format!("{} too, but {what}", words[1])];
    }
    values.map(|value| excerpt(value, VALUE))
}

/// A color as [`color_of`] reads it.
pub fn color_text(color: &Color) -> String {
    match color {
        Color::Rgb => "rgb".to_owned(),
        Color::Mono { wavelength_nm } => wavelength_nm.to_string(),
        Color::Bands(bands) => bands.to_text(),
        Color::Responses(curves) => curves.to_text(),
    }
}

/// The color of a text; nothing for any other text.
pub fn color_of(text: &str) -> Option<Color> {
    if text == "rgb" {
        return Some(Color::Rgb);
    }
    match text.parse() {
        Ok(wavelength_nm) => Some(Color::Mono { wavelength_nm }),
        Err(_) => {
            let bands = || Some(Color::Bands(Arc::new(Bands::from_text(text)?)));
            bands().or_else(|| Some(Color::Responses(Arc::new(Curves::from_text(text)?))))
        }
    }
}

/// An analyzer as [`analyzer_of`] reads it.
pub fn analyzer_text(analyzer: Option<Analyzer>) -> String {
    match analyzer {
        None => "none".to_owned(),
        Some(Analyzer::Linear { axis_deg }) => format!("linear {axis_deg}"),
        Some(Analyzer::RightCircular) => "right circular".to_owned(),
        Some(Analyzer::LeftCircular) => "left circular".to_owned(),
    }
}

/// The analyzer of a text, which may be none; nothing for any other text.
pub fn analyzer_of(text: &str) -> Option<Option<Analyzer>> {
    match text {
        "none" => Some(None),
        "right circular" => Some(Some(Analyzer::RightCircular)),
        "left circular" => Some(Some(Analyzer::LeftCircular)),
        other => {
            let axis_deg = other.strip_prefix("linear ")?.parse().ok()?;
            Some(Some(Analyzer::Linear { axis_deg }))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_of_parts_are_told_in_words() {
        let bands = |text| color_text(&Color::Bands(Arc::new(Bands::from_list(text).unwrap())));
        let [wide, narrow] = ["450x20,red=650x30", "450x20,650x10"].map(bands);
        let camera = Curves::named("nikon-d5100").unwrap();
        let camera = color_text(&Color::Responses(Arc::new(camera)));
        let words = both_in_words(COLOR, [&wide, &camera]);
        assert_eq!(words[0], "2 bands from 450 to 650 nm");
        assert!(
            words[1].starts_with("the responses of nikon-d5100 (red, green, blue) from"),
            "{words:?}"
        );
        let [one, two] = both_in_words(COLOR, [&wide, &narrow]);
        assert_eq!(one, "2 bands from 450 to 650 nm");
        assert!(two.contains("too, but their bands have other widths: at 650 nm"), "{two}");
        let names = both_in_words(COLOR, [&wide, &bands("450x20,650x30")]);
        assert!(names[1].ends_with("other names"), "{names:?}");
        assert_eq!(both_in_words(COLOR, ["rgb", "550"]), ["RGB", "550 nm"]);
        assert_eq!(both_in_words(BALANCE, ["none", "D50 [1.5, 2]"]), ["none", "D50"]);
        // Of one name, but not the same.
        let lamps = ["lamp.spd [1.5]", "lamp.spd [2.5]"];
        assert_eq!(both_in_words(BALANCE, lamps), lamps);
        assert_eq!(in_words("image: mode", "scalar"), "scalar");
    }
}
