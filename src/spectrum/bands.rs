//! Bands: ranges of wavelengths, each of which is a channel of an image.

use std::collections::BTreeSet;
use std::fmt::{self, Display};

use super::{RELATIVE_WIDTH_MIN, rows};
use crate::math::text::{counted, excerpt};
use crate::math::{Fault, Range};

/// Most bands of an image.
pub const BANDS_MAX: usize = 1024;

/// How files of bands are written.
const FILE_REMEDY: &str = "write a line of names, as name,center_nm,width_nm (name may be left \
                           out), and a band in every line; # starts comments";
/// How lists of bands are written.
const LIST_REMEDY: &str = "write centers and widths in nanometers, as 450x20,550x10,red=650x30";
/// Most characters of a name that an error shows.
const NAME: usize = 40;

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

    /// The width in nanometers from which on a render measures it: an image of another program may
    /// have narrower ones.
    pub fn least_width_nm(&self) -> f32 {
        (f64::from(self.center_nm) * RELATIVE_WIDTH_MIN) as f32
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

    /// Bands in any order, typed in a line: of each the center and the width in nanometers with an
    /// x between, and before that its name and an equals sign if it is to have one, as in
    /// `450x20,550x10,red=650x30`.
    ///
    /// # Errors
    /// When one is written otherwise, and those of [`Bands::new`].
    pub fn from_list(text: &str) -> Result<Self, Fault> {
        let band = |item: &str| {
            let (name, numbers) = match item.rsplit_once('=') {
                Some((name, numbers)) => (Some(name.trim()), numbers),
                None => (None, item),
            };
            let of = |number: &str| number.trim().parse().ok();
            let band = numbers.split_once('x').and_then(|(center, width)| {
                let band = Band::new(of(center)?, of(width)?);
                Some(Band { name: name.map_or(band.name.clone(), str::to_owned), ..band })
            });
            band.ok_or_else(|| {
                let problem = format!("have `{}`, which is no band", excerpt(item, NAME));
                Fault::new("bands", format!("{problem}; {LIST_REMEDY}"), "")
            })
        };
        Self::sorted(text.split(',').map(band).collect::<Result<_, _>>()?)
    }

    /// Reads a table of comma-separated values: a line of names, which are `center_nm`, `width_nm`
    /// and, if bands have names, `name`, in any order, and a line for each band, in any order too.
    /// What follows after # in a line, and empty lines, do not count.
    ///
    /// # Errors
    /// With the line, as the field of the fault, that has something else, and those of
    /// [`Bands::new`].
    pub fn from_csv(text: &str) -> Result<Self, Fault> {
        let refuse =
            |line: usize, problem: String| Fault::new(format!("line {line}"), problem, FILE_REMEDY);
        let mut rows = rows::rows(text);
        let Some((line, header)) = rows.next() else {
            return Err(Fault::new("", "the file has no lines", FILE_REMEDY));
        };
        let place = |name: &str| header.iter().position(|cell| *cell == name);
        let known = header.iter().all(|cell| ["name", "center_nm", "width_nm"].contains(cell));
        let (Some(center), Some(width), true) = (place("center_nm"), place("width_nm"), known)
        else {
            let found = excerpt(&header.join(","), NAME);
            return Err(refuse(line, format!("is `{found}`, and names of columns go there")));
        };
        let mut list = Vec::new();
        for (line, cells) in rows {
            if cells.len() != header.len() {
                let (found, wanted) = (cells.len(), header.len());
                let problem = format!("has {found} columns, and there are {wanted} names");
                return Err(refuse(line, problem));
            }
            let number = |place: usize| rows::finite(cells[place]);
            let [center, width] = [number(center), number(width)];
            let told = |problem| refuse(line, problem);
            let band = Band::new(center.map_err(told)?, width.map_err(told)?);
            let name = place("name").map(|place| cells[place].to_owned());
            let band = Band { name: name.unwrap_or(band.name.clone()), ..band };
            band.check().map_err(|fault| told(fault.to_string()))?;
            list.push(band);
        }
        Self::sorted(list).map_err(|fault| Fault { remedy: FILE_REMEDY.to_owned(), ..fault })
    }

    /// Bands in the order of their centers.
    fn sorted(mut list: Vec<Band>) -> Result<Self, Fault> {
        list.sort_by(|a, b| a.center_nm.total_cmp(&b.center_nm));
        Self::new(list)
    }

    /// The first and the last wavelength of all in nanometers.
    pub fn ends_nm(&self) -> [f64; 2] {
        let ends = || self.list.iter().map(Band::ends_nm);
        let first = ends().map(|[first, _]| first).fold(f64::INFINITY, f64::min);
        [first, ends().map(|[_, last]| last).fold(0.0, f64::max)]
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

    /// How others that are not of the same light differ, in words: by their number, or by the first
    /// of another center or width. None if all of these are the same; names do not count.
    pub fn difference(&self, second: &Self) -> Option<String> {
        if self.list.len() != second.list.len() {
            let [first, second] =
                [self, second].map(|it| counted(it.list.len(), ["band", "bands"]));
            return Some(format!("the first has {first} and the second {second}"));
        }
        self.list.iter().zip(&second.list).find_map(|(first, second)| {
            let centers = [first, second].map(|band| band.center_nm);
            let widths = [first, second].map(|band| band.width_nm);
            if centers[0] != centers[1] {
                let [first, second] = centers;
                let differ = format!("{first} nm in the first and {second} nm in the second");
                return Some(format!("their bands have other centers: {differ}"));
            }
            let [first, second] = widths;
            let differ = format!("{first} nm in the first and {second} nm in the second");
            let at = format!("their bands have other widths: at {} nm", centers[0]);
            (first != second).then(|| format!("{at} {differ}"))
        })
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
    fn lists_and_files_have_bands_in_any_order() {
        let bands = Bands::from_list("red edge=705x15, 450x20,550 x 10.5").unwrap();
        let expected = [
            Band::new(450.0, 20.0),
            Band::new(550.0, 10.5),
            Band { name: "red edge".to_owned(), center_nm: 705.0, width_nm: 15.0 },
        ];
        assert_eq!(bands.list(), expected);
        let file = "# a satellite\r\nwidth_nm,name,center_nm\r\n15,red edge,705\n\n\
                    20,450 nm,450 # blue\n10.5,\"550 nm\",550\n";
        assert_eq!(Bands::from_csv(file).unwrap(), bands);
        let nameless = Bands::from_csv("center_nm;width_nm\n550;10.5\n450;20").unwrap();
        assert_eq!(nameless.list(), &expected[..2]);
        // The last of the ends is not that of the last center.
        let nested = Bands::from_list("500x400,600x10").unwrap();
        assert_eq!(nested.ends_nm(), [300.0, 700.0]);
    }

    #[test]
    fn what_is_no_list_of_bands_is_told() {
        for (text, problem) in [
            ("", "`` , which"),
            ("450", "`450`, which is no band"),
            ("450x20,", "``, which"),
            ("450x20x3", "`450x20x3`"),
            ("red=", "`red=`"),
            ("=450x20", "is no name"),
            ("450x0", "width"),
            ("450x-3", "width"),
            ("NaNx3", "center"),
            ("450xinf", "width"),
            ("450x20,450x10", "each once"),
            ("a=450x20,a=460x10", "twice"),
            ("10x30", "below 0 nm"),
        ] {
            let problem = problem.replace("` ,", "`,");
            let error = Bands::from_list(text).unwrap_err().to_string();
            assert!(error.contains(&problem), "{text:?}: {error}");
        }
    }

    #[test]
    fn what_is_no_file_of_bands_is_told_by_its_line() {
        for (text, field, problem) in [
            ("", "", "has no lines"),
            ("450,20", "line 1", "is `450,20`, and names"),
            ("center_nm\n450", "line 1", "names of columns"),
            ("center_nm,width_nm,gain\n450,2,1", "line 1", "names of columns"),
            ("center_nm,width_nm", "bands", "are 0"),
            ("center_nm,width_nm\n\n450", "line 3", "has 1 columns, and there are 2 names"),
            ("center_nm,width_nm\n450,x", "line 2", "`x` is not a finite number"),
            ("center_nm,width_nm\n450,0", "line 2", "width"),
            ("center_nm,width_nm\n450,nan", "line 2", "`nan`"),
            ("name,center_nm,width_nm\n,450,3", "line 2", "is no name"),
            ("center_nm,width_nm\n450,3\n450,4", "bands", "each once"),
        ] {
            let fault = Bands::from_csv(text).unwrap_err();
            assert_eq!(fault.field, field, "{text:?}");
            assert!(fault.problem.contains(problem), "{text:?}: {}", fault.problem);
            assert!(fault.remedy.contains("name,center_nm,width_nm"), "{text:?}");
        }
    }

    #[test]
    fn other_bands_differ_in_words() {
        let of = |text| Bands::from_list(text).unwrap();
        let bands = of("450x20,550x10");
        assert_eq!(bands.difference(&of("blue=450x20,green=550x10")), None);
        for (other, words) in [
            ("450x20", "the first has 2 bands and the second 1 band"),
            ("450x20,551x10", "other centers: 550 nm in the first and 551 nm in the second"),
            ("450x20,550x5", "widths: at 550 nm 10 nm in the first and 5 nm in the second"),
        ] {
            let difference = bands.difference(&of(other)).unwrap();
            assert!(difference.contains(words), "{difference}");
        }
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
