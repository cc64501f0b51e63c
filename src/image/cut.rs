//! What metadata say of the film that an image is of, and which part of it the image shows.

use std::fmt;

/// What the metadata of an image call its part of the film, if that is not all of it.
pub const CROP: &str = "crop";
/// What they call the filter of its pixels.
pub const FILTER: &str = "filter";
/// What they call the width of its pixels over their height, if they are not squares.
pub const PIXEL_ASPECT: &str = "pixel aspect";

/// A rectangle of pixels of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Width and height of the whole film in pixels.
    pub film: [u32; 2],
    /// The first column and the topmost row.
    pub start: [u32; 2],
    /// Width and height in pixels, each at least one; no pixel is outside of the film.
    pub size: [u32; 2],
}

impl Cut {
    /// All of a film.
    pub fn whole(film: [u32; 2]) -> Self {
        Self { film, start: [0, 0], size: film }
    }

    /// Whether it is all of the film.
    pub fn is_whole(&self) -> bool {
        self.size == self.film
    }

    /// The index of a pixel of the film, by column and row, among those of the cut, row by row;
    /// none if it is outside.
    #[inline(always)]
    pub fn index_of(&self, column: u32, row: u32) -> Option<u32> {
        let [x, y] = [column.wrapping_sub(self.start[0]), row.wrapping_sub(self.start[1])];
        (x < self.size[0] && y < self.size[1]).then(|| y * self.size[0] + x)
    }

    /// The cut that metadata name, as [`Cut`] is displayed; nothing for any other text.
    pub fn from_text(text: &str) -> Option<Self> {
        let (ends, film) = text.split_once(" of ")?;
        let ends: Vec<u32> = ends.split(',').map(|it| it.parse().ok()).collect::<Option<_>>()?;
        let (width, height) = film.split_once(" x ")?;
        let film: [u32; 2] = [width.parse().ok()?, height.parse().ok()?];
        let [x0, y0, x1, y1] = ends.try_into().ok()?;
        let is_one = x0 < x1 && x1 <= film[0] && y0 < y1 && y1 <= film[1];
        is_one.then(|| Self { film, start: [x0, y0], size: [x1 - x0, y1 - y0] })
    }
}

/// As `x0,y0,x1,y1 of WIDTH x HEIGHT`; the last column and row are those before x1 and y1.
impl fmt::Display for Cut {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { film: [film_width, film_height], start: [x, y], size: [width, height] } = self;
        let [right, bottom] = [x + width, y + height];
        write!(formatter, "{x},{y},{right},{bottom} of {film_width} x {film_height}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_are_read_as_they_are_written() {
        let cut = Cut { film: [640, 480], start: [10, 20], size: [30, 1] };
        assert_eq!(cut.to_string(), "10,20,40,21 of 640 x 480");
        assert_eq!(Cut::from_text(&cut.to_string()), Some(cut));
        for text in ["", "1,2,3 of 4 x 5", "0,0,9,1 of 8 x 8", "3,0,3,1 of 8 x 8", "0,0,1,1 of 8"] {
            assert_eq!(Cut::from_text(text), None, "{text}");
        }
        let pixels = [(10, 20), (39, 20), (40, 20), (9, 20), (10, 19), (10, 21)];
        let found = pixels.map(|(x, y)| cut.index_of(x, y));
        assert_eq!(found, [Some(0), Some(29), None, None, None, None]);
        assert!(Cut::whole([3, 4]).is_whole() && !cut.is_whole());
    }
}
