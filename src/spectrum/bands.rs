//! Bands: ranges of wavelengths, each of which is a channel of an image.

use std::collections::BTreeSet;
use std::fmt::{self, Display};

use crate::math::{Fault, Range};

/// Most bands of an image.
pub const BANDS_MAX: usize = 1024;

/// A range of wavelengths over which light is averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// What it is called.
    pub name: String,
    /// Vacuum wavelength of its middle in nanometers.
    pub center_nm: f32,
    /// From its one end to the other in nanometers, greater than zero.
    pub width_nm: f32,
}

/// The bands of an image, in the order of their centers.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    list: Vec<Band>,
}

impl Band {
    /// A band that is called by its center, as `550 nm`.
    pub fn new(center_nm: f32, width_nm: f32) -> Self {
        Self { name: format!("{center_nm} nm"), center_nm, width_nm }
    }

    /// Its two ends in nanometers.
    pub fn ends_nm(&self) -> [f64; 2] {
        let (center, half) = (f64::from(self.center_nm), 0.5 * f64::from(self.width_nm));
        [center - half, center + half]
    }

    fn check(&self) -> Result<(), Fault> {
        Range::POSITIVE.check("center", self.center_nm)?;
        Range::POSITIVE.check("width", self.width_nm)?;
        if self.ends_nm()[0] <= 0.0 {
            let problem = format!("reaches below 0 nm: {} nm wide", self.width_nm);
            return Err(Fault::new("width", format!("{problem}; make it narrower"), ""));
        }
        if self.name.is_empty() || self.name.chars().any(char::is_control) {
            let problem = format!("{:?} is no name", self.name);
            return Err(Fault::new("name", problem, ""));
        }
        Ok(())
    }
}

impl Bands {
    /// Bands in the order of their centers, each of which is there once, as is each name. They may
    /// overlap.
    ///
    /// # Errors
    /// When there are none or more than [`BANDS_MAX`], one has no width or no name, or two are
    /// alike or out of order.
    pub fn new(list: Vec<Band>) -> Result<Self, Fault> {
        if list.is_empty() || list.len() > BANDS_MAX {
            let problem = format!("are {}, and there must be 1 to {BANDS_MAX}", list.len());
            return Err(Fault::new("bands", problem, ""));
        }
        for (index, band) in list.iter().enumerate() {
            band.check().map_err(|fault| fault.within(&format!("bands[{index}]")))?;
        }
        if let Some(pair) = list.windows(2).find(|pair| pair[0].center_nm >= pair[1].center_nm) {
            let [first, second] = [&pair[0], &pair[1]].map(|band| band.center_nm);
            let problem = format!("have their centers at {first} nm and then at {second} nm");
            return Err(Fault::new("bands", format!("{problem}; sort them, each once"), ""));
        }
        let mut names = BTreeSet::new();
        if let Some(band) = list.iter().find(|band| !names.insert(&band.name)) {
            let problem = format!("are called {:?} twice", band.name);
            let problem = format!("{problem}; give each a name of its own");
            return Err(Fault::new("bands", problem, ""));
        }
        Ok(Self { list })
    }

    /// `count` bands whose centers are evenly spaced from the first to the last, in nanometers,
    /// each as wide as their distance.
    ///
    /// # Errors
    /// When that leaves a band without width, or what [`Bands::new`] refuses.
    pub fn evenly(first_nm: f32, last_nm: f32, count: usize) -> Result<Self, Fault> {
        let fault = |problem: String, remedy: &str| {
            Err(Fault::new("bands", format!("{problem}; {remedy}"), ""))
        };
        if !(first_nm.is_finite() && last_nm.is_finite() && first_nm > 0.0) {
            let problem = format!("from {first_nm} to {last_nm} nm are no wavelengths");
            return fault(problem, "use numbers greater than 0");
        }
        if !(2..=BANDS_MAX).contains(&count) {
            let problem = format!(
                "are {count}, and there must be 2 to {BANDS_MAX}: each is as wide \
                                   as their centers are apart"
            );
            return fault(problem, "for one band, take the two ends of a finer set");
        }
        if first_nm > last_nm {
            let problem = format!("go from {first_nm} down to {last_nm} nm");
            return fault(problem, "turn them round");
        }
        let [first, last] = [first_nm, last_nm].map(f64::from);
        let step = (last - first) / (count - 1) as f64;
        let center = |index: usize| (first + step * index as f64) as f32;
        let list: Vec<Band> =
            (0..count).map(|index| Band::new(center(index), step as f32)).collect();
        if list.windows(2).any(|pair| pair[0].center_nm >= pair[1].center_nm) {
            let problem = format!("from {first_nm} to {last_nm} nm have no width");
            return fault(problem, "put their ends farther apart");
        }
        Self::new(list)
    }

    /// All of them.
    pub fn list(&self) -> &[Band] {
        &self.list
    }

    /// The band that has a wavelength in nanometers: of several the one whose center is nearest.
    pub fn index_at(&self, wavelength_nm: f32) -> Option<usize> {
        let at = f64::from(wavelength_nm);
        let has_it = |band: &Band| (band.ends_nm()[0]..=band.ends_nm()[1]).contains(&at);
        let distance = |band: &Band| (band.center_nm - wavelength_nm).abs();
        (self.list.iter().enumerate())
            .filter(|(_, band)| has_it(band))
            .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)))
            .map(|(index, _)| index)
    }

    /// All of them as one line of text, which [`Bands::from_text`] reads.
    pub fn to_text(&self) -> String {
        let rows = self.list.iter().map(|Band { name, center_nm, width_nm }| {
            serde_json::json!([name, center_nm, width_nm])
        });
        serde_json::Value::from(rows.collect::<Vec<_>>()).to_string()
    }

    /// Reads what [`Bands::to_text`] has written.
    pub fn from_text(text: &str) -> Option<Self> {
        let rows: Vec<(String, f32, f32)> = serde_json::from_str(text).ok()?;
        let band = |(name, center_nm, width_nm)| Band { name, center_nm, width_nm };
        Self::new(rows.into_iter().map(band).collect()).ok()
    }
}

impl Display for Bands {
    /// Their number and their centers, in words.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.list[..] {
            [one] => write!(f, "one band at {} nm", one.center_nm),
            [first, .., last] => write!(
                f,
                "{} bands from {} to {} nm",
                self.list.len(),
                first.center_nm,
                last.center_nm
            ),
            [] => write!(f, "no bands"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_bands_touch_each_other() {
        let bands = Bands::evenly(400.0, 700.0, 31).unwrap();
        assert_eq!(bands.list().len(), 31);
        assert_eq!(bands.list()[15], Band::new(550.0, 10.0));
        for pair in bands.list().windows(2) {
            assert!((pair[0].ends_nm()[1] - pair[1].ends_nm()[0]).abs() < 1e-4);
        }
        assert_eq!(bands.index_at(553.0), Some(15));
        assert_eq!((bands.index_at(394.9), bands.index_at(705.1)), (None, None));
        assert_eq!(bands.to_string(), "31 bands from 400 to 700 nm");
        assert_eq!(Bands::from_text(&bands.to_text()), Some(bands));
    }

    #[test]
    fn what_is_no_band_is_refused() {
        let refused =
            |first, last, count| Bands::evenly(first, last, count).unwrap_err().to_string();
        assert!(refused(700.0, 400.0, 31).contains("turn them round"));
        assert!(refused(550.0, 550.0, 3).contains("no width"));
        assert!(refused(400.0, 700.0, 1).contains("2 to 1024"));
        assert!(refused(f32::NAN, 700.0, 3).contains("no wavelengths"));
        assert!(refused(400.0, f32::INFINITY, 3).contains("no wavelengths"));
        assert!(refused(1.0, 700.0, 2).contains("below 0 nm"));
        let of = |list: &[(&str, f32, f32)]| {
            let band = |&(name, center_nm, width_nm): &(&str, f32, f32)| Band {
                name: name.to_owned(),
                center_nm,
                width_nm,
            };
            Bands::new(list.iter().map(band).collect())
        };
        assert!(of(&[]).is_err() && of(&[("a", 500.0, 0.0)]).is_err());
        assert!(of(&[("a", 500.0, 1.0), ("b", 500.0, 2.0)]).is_err());
        assert!(of(&[("a", 500.0, 1.0), ("a", 501.0, 2.0)]).is_err());
        assert!(of(&[("a\n", 500.0, 1.0)]).is_err() && of(&[("", 500.0, 1.0)]).is_err());
        assert!(of(&[("red \"edge\"", 500.0, 30.0), ("b", 501.0, 2.0)]).is_ok());
    }
}
