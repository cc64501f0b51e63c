//! How a film is laid out: its pixels, which of them are rendered, and how they see.

use std::fmt;
use std::str::FromStr;

use super::filter::{Filter, FilterSamples};
use super::lattice;
use crate::image::cut::Cut;
use crate::math::{Fault, Range};

/// Widths over heights that pixels may have.
const ASPECTS: Range = Range::new("from 0.01 to 100", |x| (0.01..=100.0).contains(&x));

/// A part of a film, from the first column and topmost row to those behind the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crop {
    /// Left, top, right, bottom in pixels.
    Pixels([u32; 4]),
    /// The same in percent of the film's width and height; pixels that it touches count.
    Percent([f64; 4]),
}

impl Crop {
    /// The pixels that it is of a film.
    ///
    /// # Errors
    /// When it is empty, or reaches beyond the film: the rule that it breaks.
    pub fn on(self, film: [u32; 2]) -> Result<Cut, String> {
        let [width, height] = film;
        let refuse = || {
            format!(
                "must be X0,Y0,X1,Y1 with 0 <= X0 < X1 <= {width} and 0 <= Y0 < Y1 <= {height}, \
                 the film's pixels, or in percent as 25%,25%,75%,75%, not {self}"
            )
        };
        let ends = match self {
            Self::Pixels(ends) => ends,
            Self::Percent(ends) => {
                let [x0, y0, x1, y1] = ends;
                // Also where one is no number.
                let is_one = 0.0 <= x0 && x0 < x1 && x1 <= 100.0 && 0.0 <= y0;
                if !(is_one && y0 < y1 && y1 <= 100.0) {
                    return Err(refuse());
                }
                let of = |percent: f64, side: u32| percent * f64::from(side) / 100.0;
                // A rounding error is no pixel.
                let start = |at: f64| (at + 1e-6).floor() as u32;
                let end = |at: f64, side: u32| ((at - 1e-6).ceil() as u32).clamp(1, side);
                let first = [start(of(x0, width)), start(of(y0, height))];
                let first = [first[0].min(width - 1), first[1].min(height - 1)];
                let last = [end(of(x1, width), width), end(of(y1, height), height)];
                [first[0], first[1], last[0].max(first[0] + 1), last[1].max(first[1] + 1)]
            }
        };
        let [x0, y0, x1, y1] = ends;
        if !(x0 < x1 && x1 <= width && y0 < y1 && y1 <= height) {
            return Err(refuse());
        }
        Ok(Cut { film, start: [x0, y0], size: [x1 - x0, y1 - y0] })
    }

    /// The same part of a film of another size.
    pub fn scaled(self, from: [u32; 2], to: [u32; 2]) -> Self {
        match self {
            Self::Pixels(ends) if from != to => {
                let side = |axis: usize| f64::from(from[axis % 2]);
                Self::Percent([0, 1, 2, 3].map(|axis| 100.0 * f64::from(ends[axis]) / side(axis)))
            }
            Self::Pixels(_) | Self::Percent(_) => self,
        }
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refuse = || {
            format!(
                "must be X0,Y0,X1,Y1 in pixels, as 100,50,300,200, or in percent, as \
                 25%,25%,75%,75%, not {text}"
            )
        };
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let parts: [&str; 4] = parts.try_into().map_err(|_| refuse())?;
        if parts.iter().all(|part| part.ends_with('%')) {
            let number = |part: &str| part.trim_end_matches('%').parse().map_err(|_| refuse());
            let [x0, y0, x1, y1] = parts.map(number);
            return Ok(Self::Percent([x0?, y0?, x1?, y1?]));
        }
        let [x0, y0, x1, y1] = parts.map(|part| part.parse().map_err(|_| refuse()));
        Ok(Self::Pixels([x0?, y0?, x1?, y1?]))
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let words = match self {
            Self::Pixels(ends) => ends.map(|end| end.to_string()),
            Self::Percent(ends) => ends.map(|end| format!("{end}%")),
        };
        formatter.write_str(&words.join(","))
    }
}

/// A film, before anything is on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Its pixels, and those of them that are rendered.
    pub cut: Cut,
    /// How light about a pixel counts for it.
    pub filter: Filter,
    /// Whether samples count for all pixels whose filters reach them.
    pub shares: bool,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
}

impl Layout {
    /// All of a film of square pixels that are means over their squares.
    pub fn plain(film: [u32; 2]) -> Self {
        let (cut, filter) = (Cut::whole(film), Filter::PIXEL);
        Self { cut, filter, shares: false, pixel_aspect: 1.0 }
    }

    /// How far beyond its pixel a sample counts, in pixels.
    pub fn reach(&self) -> u32 {
        if self.shares { lattice::reach(self.filter) } else { 0 }
    }

    /// The pixels that samples are taken in: those that are rendered and those that they share
    /// samples with. Columns and rows count from the first beside the film that has any.
    pub fn sampled(&self) -> Cut {
        let Cut { film, start, size } = self.cut;
        let [film, size] = [film, size].map(|sides| sides.map(|side| side + 2 * self.reach()));
        Cut { film, start, size }
    }

    /// The words of its filter's samples.
    pub fn samples(&self) -> FilterSamples {
        if self.shares { FilterSamples::Shared } else { FilterSamples::Own }
    }
}

/// Refuses pixels that are wider or higher than anybody means.
pub fn check_pixel_aspect(aspect: f32) -> Result<(), Fault> {
    ASPECTS.check("pixel_aspect", aspect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_are_read_and_bounded() {
        let cut = |text: &str| text.parse::<Crop>()?.on([640, 480]);
        let whole = Cut::whole([640, 480]);
        assert_eq!(cut("0,0,640,480"), Ok(whole));
        assert_eq!(cut("0%, 0%, 100%, 100%"), Ok(whole));
        let middle = Cut { film: [640, 480], start: [160, 120], size: [320, 240] };
        assert_eq!(cut("25%,25%,75%,75%"), Ok(middle));
        assert_eq!(cut("160,120,480,360"), Ok(middle));
        // A third of 480 is 160, of 640 it ends within a pixel.
        let third = cut("0%,0%,33.333333333333336%,33.333333333333336%").unwrap();
        assert_eq!(third.size, [214, 160]);
        assert_eq!(cut("0%,0%,1e-9%,1e-9%").unwrap().size, [1, 1]);
        assert_eq!(cut("99.9999999%,0%,100%,1%").unwrap().start, [639, 0]);
        for text in [
            "",
            "1,2,3",
            "1,2,3,4,5",
            "-1,0,5,5",
            "5,0,5,5",
            "6,0,5,5",
            "0,0,641,5",
            "0,0,1,481",
            "0%,0%,101%,5%",
            "NaN%,0%,5%,5%",
            "0%,0%,0%,5%",
            "0,0,5%,5%",
            "0.5,0,3,3",
            "a,b,c,d",
        ] {
            let error = cut(text).unwrap_err();
            assert!(error.starts_with("must be X0,Y0,X1,Y1 "), "{text}: {error}");
        }
    }

    #[test]
    fn crops_keep_their_place_on_other_films() {
        let crop = Crop::Pixels([10, 20, 30, 40]);
        assert_eq!(crop.scaled([100, 200], [100, 200]), crop);
        let twice = crop.scaled([100, 200], [200, 400]).on([200, 400]).unwrap();
        assert_eq!((twice.start, twice.size), ([20, 40], [40, 40]));
    }
}
