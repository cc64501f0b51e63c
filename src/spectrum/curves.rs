//! Films with channels of their own, each of which responds to light by a curve: cameras, sensors,
//! observers.
//!
//! The value of a channel is the integral of radiance times response. Curves are kept as they were
//! given, each with a factor, so that they can be normalized again over another range or to
//! another light.

use std::collections::BTreeSet;
use std::fmt::{self, Display};

use serde::{Deserialize, Serialize};

use super::cie::{VISIBLE_NM, color_matching};
use super::{Response, Responses, WhiteBalance, data, rows};
use crate::math::text::{counted, excerpt, listed};
use crate::math::{Fault, Range};

/// Most channels of a film.
pub const CHANNELS_MAX: usize = 1024;
/// Most characters of the name of a channel.
const NAME_MAX: usize = 64;
/// What wavelengths can be; those in micrometers are not taken for nanometers.
const NANOMETERS: Range =
    Range::new("in nanometers, from 1 to 1000000", |nm| (1.0..=1e6).contains(&nm));
/// What values can be: larger ones times light might be no finite numbers.
const VALUES: Range = Range::new("from -1e12 to 1e12", |value| value.abs() <= 1e12);
/// Least integral of a curve over that of its size, for the curve to be normalized.
const NORMALIZED_MIN: f64 = 1e-2;
/// Most characters of a cell or a name that an error shows.
const CELL: usize = 20;
const REMEDY: &str = "write a line of names, as wavelength_nm,red,green,blue, and then a \
                      wavelength in nanometers with a number for each channel in every line; # \
                      starts comments";

/// The table of cameras: name, channel, first wavelength and step in nanometers, and values.
const CAMERAS: &str = include_str!("data/cameras.csv");
/// The color matching functions of the CIE 1931 observer of 2 degrees.
const XYZ: &str = "xyz";
/// The second of them, the luminous efficiency of the CIE for photopic vision.
const LUMINANCE: &str = "luminance";

/// Response curves, the channels of an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    name: String,
    /// Where all curves are given.
    nm: Vec<f32>,
    channels: Vec<Curve>,
}

/// The curve of a channel: linear between its values, and zero outside of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    name: String,
    /// By what the values are multiplied.
    factor: f32,
    values: Vec<f32>,
}

impl Curves {
    /// Curves at increasing vacuum wavelengths in nanometers, two at least: name and values of each
    /// channel. As they are, without normalization.
    ///
    /// # Errors
    /// When a number is out of its range, there are no channels or more than [`CHANNELS_MAX`], or
    /// two of one name, or a name is not 1 to 64 printable characters of ASCII without `.`, `,` and
    /// `"`.
    pub fn new(
        name: impl Into<String>,
        nm: Vec<f32>,
        channels: Vec<(String, Vec<f32>)>,
    ) -> Result<Self, Fault> {
        let curve = |(name, values)| Curve { name, factor: 1.0, values };
        let curves =
            Self { name: name.into(), nm, channels: channels.into_iter().map(curve).collect() };
        curves.check()?;
        Ok(curves)
    }

    /// Those of a film by name, in capitals or not: the names are [`Curves::names`]. None if there
    /// is none of this name.
    pub fn named(name: &str) -> Option<Self> {
        let name = data::known(Self::names(), name)?;
        let observer = |channels: &[(&str, usize)]| {
            let [first, last] = VISIBLE_NM.map(|nm| nm as u32);
            let values = |index: usize| {
                let value = |nm| color_matching(f64::from(nm))[index] as f32;
                (first..=last).map(value).collect()
            };
            let nm = (first..=last).map(|nm| nm as f32).collect();
            let of = |&(channel, index): &(&str, usize)| (channel.to_owned(), values(index));
            Self::new(name, nm, channels.iter().map(of).collect()).ok()
        };
        match name {
            XYZ => observer(&[("x", 0), ("y", 1), ("z", 2)]),
            LUMINANCE => observer(&[("y", 1)]),
            name => camera(name),
        }
    }

    /// The names that [`Curves::named`] knows.
    pub fn names() -> Vec<&'static str> {
        let mut names = vec![XYZ, LUMINANCE];
        names.extend(data::names(CAMERAS));
        names
    }

    /// How others that do not respond alike differ, in words: by their number, or by the first that
    /// is of another curve. None if all are the same; names do not count.
    pub fn difference(&self, second: &Self) -> Option<String> {
        let counts = [self, second].map(|it| it.channels.len());
        if counts[0] != counts[1] {
            let [first, second] = counts.map(|count| counted(count, ["response", "responses"]));
            return Some(format!("the first has {first} and the second {second}"));
        }
        let mut pairs = self.channels.iter().zip(&second.channels);
        if let Some((first, _)) = pairs
            .clone()
            .find(|(first, other)| self.nm != second.nm || first.values != other.values)
        {
            return Some(format!("their responses are other curves: {} is the first", first.name));
        }
        let scaled = pairs.find(|(first, second)| first.factor != second.factor);
        scaled.map(|(first, _)| {
            format!(
                "their responses are normalized otherwise: {} is the first (see --range, \
                 --white-balance and --raw-response)",
                first.name
            )
        })
    }

    /// Reads a table of comma-separated values: a line of names, the first that of the column of
    /// wavelengths, and lines of increasing vacuum wavelengths in nanometers, each with a number
    /// for every channel. Semicolons and tabs separate, too. What follows after # in a line, and
    /// empty lines, do not count.
    ///
    /// # Errors
    /// With the line, as the field of the fault, that has something else; and with those of
    /// [`Curves::new`].
    pub fn from_csv(name: impl Into<String>, text: &str) -> Result<Self, Fault> {
        let mut rows = rows::rows(text);
        let refuse =
            |line: usize, problem: String| Err(Fault::new(format!("line {line}"), problem, REMEDY));
        let Some((line, header)) = rows.next() else {
            return Err(Fault::new("", "the file has no lines", REMEDY));
        };
        if header[0].parse::<f64>().is_ok() {
            return refuse(line, "has numbers, and no names are before them".to_owned());
        }
        let mut channels: Vec<(String, Vec<f32>)> =
            header[1..].iter().map(|name| ((*name).to_owned(), Vec::new())).collect();
        let mut nm = Vec::new();
        for (line, cells) in rows {
            if cells.len() != header.len() {
                let (found, wanted) = (cells.len(), header.len());
                return refuse(line, format!("has {found} columns, and there are {wanted} names"));
            }
            let mut numbers = cells.iter().map(|cell| rows::finite(cell));
            for place in std::iter::once(&mut nm).chain(channels.iter_mut().map(|it| &mut it.1)) {
                match numbers.next() {
                    Some(Ok(number)) => place.push(number),
                    Some(Err(problem)) => return refuse(line, problem),
                    None => {}
                }
            }
            if let [.., before, last] = nm[..]
                && last <= before
            {
                return refuse(line, format!("{last} nm is not greater than what is before it"));
            }
        }
        Self::new(name, nm, channels).map_err(|fault| Fault { remedy: REMEDY.to_owned(), ..fault })
    }

    fn check(&self) -> Result<(), Fault> {
        let fault = |field: &str, problem: String| Err(Fault::new(field, problem, ""));
        let count = self.channels.len();
        if !(1..=CHANNELS_MAX).contains(&count) {
            return fault(
                "",
                format!("has {count} channels, and there must be 1 to {CHANNELS_MAX}"),
            );
        }
        if self.nm.len() < 2 {
            return fault("", "needs two wavelengths or more".to_owned());
        }
        self.nm.iter().try_for_each(|nm| NANOMETERS.check("wavelength", *nm))?;
        if !self.nm.is_sorted_by(|a, b| a < b) {
            return fault("", "needs wavelengths in increasing order, each once".to_owned());
        }
        let mut names = BTreeSet::new();
        for Curve { name, values, .. } in &self.channels {
            let is_odd = |c: char| !(c.is_ascii_graphic() || c == ' ') || ".,\"".contains(c);
            if name.trim() != name || !(1..=NAME_MAX).contains(&name.len()) || name.contains(is_odd)
            {
                let name = excerpt(name, CELL);
                let rule = "1 to 64 characters of ASCII, without . , and \"";
                return fault("", format!("`{name}` is no name of a channel: it has {rule}"));
            }
            if !names.insert(name) {
                return fault("", format!("has two channels that are called {name}"));
            }
            if values.len() != self.nm.len() {
                return fault(name, "needs as many values as there are wavelengths".to_owned());
            }
            values.iter().try_for_each(|value| VALUES.check(name, *value))?;
        }
        Ok(())
    }

    /// What they are called together: a name, or that of a file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of the channels.
    pub fn channels(&self) -> impl ExactSizeIterator<Item = &str> {
        self.channels.iter().map(|curve| curve.name.as_str())
    }

    /// The first and the last wavelength in nanometers that any channel responds to.
    pub fn ends_nm(&self) -> [f32; 2] {
        let is_lit = |row: &usize| self.channels.iter().any(|curve| curve.values[*row] != 0.0);
        let end = self.nm.len() - 1;
        // It begins to rise at the last zero, and ends at the first.
        let first = (0..=end).find(is_lit).map_or(0, |row| row.saturating_sub(1));
        let last = (0..=end).rev().find(is_lit).map_or(end, |row| (row + 1).min(end));
        [self.nm[first], self.nm[last]]
    }

    /// The mean wavelength of a channel in nanometers, by the size of its response; none where it
    /// does not respond.
    pub fn center_nm(&self, channel: usize) -> Option<f32> {
        let size = self.size(&self.channels[channel]);
        let range = [0.0, f64::INFINITY];
        let all = size.integral(range, &[], |_| 1.0);
        let moment = size.integral(range, &[], |nm| nm);
        (all > 0.0).then(|| (moment / all) as f32)
    }

    /// The response of a channel without its signs.
    fn size(&self, curve: &Curve) -> Response {
        let values = curve.values.iter().map(|value| value.abs()).collect();
        Curve { values, ..curve.clone() }.response(&self.nm)
    }

    /// The responses of the channels.
    pub(crate) fn responses(&self) -> Responses {
        Responses::new(self.channels.iter().map(|curve| curve.response(&self.nm)).collect())
    }

    /// The same curves as they were given: a channel is the integral of radiance times its numbers.
    #[must_use]
    pub fn raw(&self) -> Self {
        let mut raw = self.clone();
        raw.channels.iter_mut().for_each(|curve| curve.factor = 1.0);
        raw
    }

    /// The same curves, each with the factor by which a light gives 1 over a range in nanometers:
    /// one of radiance 1 per nanometer at all wavelengths, or a white.
    ///
    /// # Errors
    /// When that has no integral above zero with a curve, or is not known where a curve is.
    pub fn normalized(
        &self,
        range_nm: [f32; 2],
        white: Option<&WhiteBalance>,
    ) -> Result<Self, Fault> {
        let mut normalized = self.raw();
        let ([first, last], range) = (range_nm, range_nm.map(f64::from));
        let one = |_| 1.0;
        for (index, curve) in normalized.channels.iter_mut().enumerate() {
            let response = curve.response(&self.nm);
            let integral = match white {
                None => response.integral(range, &[], one),
                Some(white) => white.seen_by(&response, range_nm)?,
            };
            let factor = (1.0 / integral) as f32;
            // What its signs leave of it must be more than rounding.
            let least = NORMALIZED_MIN * self.size(&self.channels[index]).integral(range, &[], one);
            let is_known = match white {
                None => integral > least,
                Some(_) => integral > 0.0,
            };
            if !(is_known && factor > 0.0 && factor.is_finite()) {
                let light = white.map_or("a flat spectrum", |white| white.name());
                let channel = &curve.name;
                let problem = format!(
                    "cannot be normalized in the channel {channel}: the integral of {light} with \
                     it from {first} to {last} nm is {}",
                    integral as f32
                );
                return Err(Fault::new("", problem, "take it as it is, by raw_response"));
            }
            curve.factor = factor;
        }
        Ok(normalized)
    }

    /// The first channel that responds to nothing of a range in nanometers, with the range that it
    /// does respond to, if to any.
    pub fn dark_in(&self, range_nm: [f32; 2]) -> Option<(&str, Option<[f32; 2]>)> {
        let range = range_nm.map(f64::from);
        let is_dark = |curve: &&Curve| self.size(curve).integral(range, &[], |_| 1.0) <= 0.0;
        let dark = self.channels.iter().find(is_dark)?;
        let alone = Self { channels: vec![dark.clone()], ..self.clone() };
        let responds = dark.values.iter().any(|value| *value != 0.0);
        Some((&dark.name, responds.then(|| alone.ends_nm())))
    }

    /// All of them as one line of text, which [`Curves::from_text`] reads.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).expect("numbers and names are JSON")
    }

    /// Reads what [`Curves::to_text`] has written.
    pub fn from_text(text: &str) -> Option<Self> {
        let curves: Self = serde_json::from_str(text).ok()?;
        let has_factors =
            curves.channels.iter().all(|curve| curve.factor > 0.0 && curve.factor.is_finite());
        (has_factors && curves.check().is_ok()).then_some(curves)
    }
}

impl Curve {
    fn response(&self, nm: &[f32]) -> Response {
        let factor = f64::from(self.factor);
        let node = |(nm, value): (&f32, &f32)| [f64::from(*nm), factor * f64::from(*value)];
        Response::between_nodes(nm.iter().zip(&self.values).map(node).collect())
    }
}

impl Display for Curves {
    /// Name and channels.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.channels.len();
        let [first, last] = self.ends_nm();
        write!(f, "the response{} of {}", if count == 1 { "" } else { "s" }, self.name)?;
        write!(f, " ({})", listed(self.channels()))?;
        write!(f, " from {first} to {last} nm")
    }
}

/// A camera of the table.
fn camera(name: &str) -> Option<Curves> {
    let mut channels = Vec::new();
    let mut nm = Vec::new();
    for row in data::entries(CAMERAS, name) {
        let (channel, numbers) = row.split_once(',')?;
        let numbers = data::numbers(numbers)?;
        let [first, step, values @ ..] = &numbers[..] else { return None };
        nm = (0..values.len()).map(|row| (first + step * row as f64) as f32).collect();
        channels.push((channel.to_owned(), values.iter().map(|value| *value as f32).collect()));
    }
    Curves::new(name, nm, channels).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::cie::integrals;

    const FILE: &str = "\u{feff}# a sensor\r\nwavelength_nm, vis ;nir\r\n\r\n400,0,0\n\
                        500,2,0 # peak\n600\t0\t0\n700,0,-1\n800,0,3\n900,0,0\n";

    fn flat(curves: &Curves, channel: usize, range: [f64; 2]) -> f64 {
        curves.channels[channel].response(&curves.nm).integral(range, &[], |_| 1.0)
    }

    #[test]
    fn files_are_read_and_normalized() {
        let curves = Curves::from_csv("sensor.csv", FILE).unwrap();
        assert_eq!(curves.channels().collect::<Vec<_>>(), ["vis", "nir"]);
        assert_eq!(curves.ends_nm(), [400.0, 900.0]);
        // Triangles: 200 nm under a peak of 2; one below zero, and one above.
        let all = [0.0, 1000.0];
        assert!([0, 1].iter().all(|it| (flat(&curves, *it, all) - 200.0).abs() < 1e-9));
        let normal = curves.normalized([400.0, 900.0], None).unwrap();
        assert!([0, 1].iter().all(|channel| (flat(&normal, *channel, all) - 1.0).abs() < 1e-7));
        // Cut where the second has had 50 of its 200.
        let half = curves.normalized([300.0, 800.0], None).unwrap();
        assert!((flat(&half, 1, [300.0, 800.0]) - 1.0).abs() < 1e-7);
        assert_eq!(half.raw(), curves);
        assert_eq!(curves.center_nm(0), Some(500.0));
        assert_eq!(Curves::from_text(&half.to_text()), Some(half));
    }

    #[test]
    fn what_cannot_be_normalized_is_told_by_its_channel() {
        let curves = Curves::from_csv("sensor.csv", FILE).unwrap();
        let error = curves.normalized([600.0, 900.0], None).unwrap_err();
        assert!(error.problem.contains("channel vis") && error.problem.contains("is 0"), "{error}");
        let nir = Curves::new(
            "nir",
            curves.nm.clone(),
            vec![("nir".to_owned(), curves.channels[1].values.clone())],
        );
        let error = nir.unwrap().normalized([600.0, 700.0], None).unwrap_err();
        assert!(error.problem.contains("channel nir") && error.problem.contains("is -50"));
        for last in [1.0, 1.001] {
            let text = format!("wavelength_nm,a\n500,-1\n600,{last}\n");
            let even = Curves::from_csv("even.csv", &text).unwrap();
            assert!(even.normalized([500.0, 600.0], None).is_err(), "{last}");
        }
        assert_eq!(curves.dark_in([650.0, 900.0]), Some(("vis", Some([400.0, 600.0]))));
        assert_eq!(curves.dark_in([500.0, 650.0]), None);
    }

    #[test]
    fn what_is_no_table_of_responses_is_refused_by_its_line() {
        for (text, field, problem) in [
            ("", "", "has no lines"),
            ("# nothing\n\n", "", "has no lines"),
            ("400,1,2\n500,1,2", "line 1", "has numbers"),
            ("nm\n400\n500", "", "has 0 channels"),
            ("nm,a\n400,1", "", "two wavelengths"),
            ("nm,a\n400,1\n\n500,1,2", "line 4", "has 3 columns, and there are 2 names"),
            ("nm,a\n400,1\n500", "line 3", "has 1 columns"),
            ("nm,a\n400,1\n500,x", "line 3", "`x` is not a finite number"),
            ("nm,a\n400,1\n500,inf", "line 3", "`inf` is not"),
            ("nm,a\n400,1\n500,1e60", "line 3", "`1e60` is not"),
            ("nm,a\n500,1\n400,1", "line 3", "400 nm is not greater"),
            ("nm,a\n500,1\n500,1", "line 3", "500 nm is not greater"),
            ("um,a\n0.4,1\n0.7,1", "wavelength", "0.4 must be in nanometers"),
            ("nm,a\n400,1\n500,2e12", "a", "2000000000000 must be from -1e12"),
            ("nm,a,a\n400,1,1\n500,1,1", "", "two channels that are called a"),
            ("nm,a,\n400,1,1\n500,1,1", "", "`` is no name"),
            ("nm,a.b\n400,1\n500,1", "", "`a.b` is no name"),
            ("nm,grün\n400,1\n500,1", "", "is no name"),
        ] {
            let fault = Curves::from_csv("x.csv", text).unwrap_err();
            assert_eq!(fault.field, field, "{text:?}");
            assert!(fault.problem.contains(problem), "{text:?}: {}", fault.problem);
            assert!(fault.remedy.contains("wavelength_nm,red"), "{text:?}");
        }
        let many: Vec<String> = (0..=CHANNELS_MAX).map(|channel| format!("c{channel}")).collect();
        let row = |nm: u32| format!("{nm}{}", ",1".repeat(many.len()));
        let text = format!("nm,{}\n{}\n{}", many.join(","), row(400), row(500));
        assert!(Curves::from_csv("x.csv", &text).unwrap_err().problem.contains("1025 channels"));
    }

    #[test]
    fn every_name_is_a_film_that_can_be_normalized() {
        for name in Curves::names() {
            assert_eq!(name, name.to_lowercase(), "two must not differ in capitals alone");
            let curves = Curves::named(name).unwrap();
            let normal = curves.normalized(curves.ends_nm(), None).unwrap();
            for channel in 0..curves.channels.len() {
                assert!((flat(&normal, channel, [0.0, 2000.0]) - 1.0).abs() < 1e-6, "{name}");
            }
            assert_eq!(Curves::from_text(&normal.to_text()), Some(normal), "{name}");
        }
        for unknown in ["", "xy", "xyz ", "nikon"] {
            assert_eq!(Curves::named(unknown), None);
        }
        // In capitals or not, with the name as it is listed.
        assert_eq!(Curves::named("XYZ"), Curves::named("xyz"));
        assert_eq!(Curves::named("Nikon-D5100"), Curves::named("nikon-d5100"));
        // The camera sees its colors where they are.
        let camera = Curves::named("nikon-d5100").unwrap();
        let centers = [0, 1, 2].map(|channel| camera.center_nm(channel).unwrap());
        assert!((580.0..630.0).contains(&centers[0]), "{centers:?}");
        assert!((520.0..550.0).contains(&centers[1]), "{centers:?}");
        assert!((450.0..490.0).contains(&centers[2]), "{centers:?}");
    }

    #[test]
    fn other_responses_differ_in_words() {
        let of = |text: &str| Curves::from_csv("a.csv", text).unwrap();
        let curves = of("nm,red,nir\n400,1,0\n500,1,2");
        let renamed = Curves::from_csv("b.csv", "nm,r,n\n400,1,0\n500,1,2").unwrap();
        assert_eq!(curves.difference(&renamed), None);
        for (other, words) in [
            (of("nm,red\n400,1\n500,1"), "the first has 2 responses and the second 1 response"),
            (of("nm,red,nir\n400,1,0\n500,1,3"), "other curves: nir"),
            (of("nm,red,nir\n400,1,0\n501,1,2"), "other curves: red"),
            (curves.normalized([400.0, 500.0], None).unwrap(), "normalized otherwise: red"),
        ] {
            let difference = curves.difference(&other).unwrap();
            assert!(difference.contains(words), "{difference}");
        }
    }

    #[test]
    fn the_observer_is_that_of_the_cie() {
        let xyz = Curves::named("xyz").unwrap().responses();
        let light = |nm: f64| 1.0 + 0.5 * (nm / 30.0).sin();
        let expected = integrals([360.0, 830.0], light);
        for (response, expected) in xyz.list().iter().zip(expected) {
            let found = response.integral([0.0, 1000.0], &[], light);
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} and not {expected}");
        }
    }

    #[test]
    fn texts_of_others_are_no_curves() {
        for text in [
            "",
            "[]",
            "{}",
            "rgb",
            "550",
            r#"{"name":"a","nm":[1,2],"channels":[]}"#,
            r#"{"name":"a","nm":[2,1],"channels":[{"name":"b","factor":1,"values":[1,1]}]}"#,
            r#"{"name":"a","nm":[1,2],"channels":[{"name":"b","factor":0,"values":[1,1]}]}"#,
            r#"{"name":"a","nm":[1,2],"channels":[{"name":"b","factor":1,"values":[1]}]}"#,
        ] {
            assert_eq!(Curves::from_text(text), None, "{text}");
        }
    }
}
