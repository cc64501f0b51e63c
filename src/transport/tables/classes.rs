//! Classes of rows: which columns of polarization exist for them. All else is known without
//! storage:
//!
//! | side | class | columns | when |
//! |---|---|---|---|
//! | light | [`LightClass::Unpolarized`] | none | emitted unpolarized, or after a depolarizer |
//! | light | [`LightClass::Polarized`] | Stokes, axis | after a polarizing event |
//! | sensor | [`SensorClass::Fresh`] | none: T = 1 in the film's frame | no event yet |
//! | sensor | [`SensorClass::Plain`] | none: c = r = e0 | after a depolarizer, nothing polarizing |
//! | | | | before (a film of intensities counts as one) |
//! | sensor | [`SensorClass::Row`] | r, axis | a `Plain` row, polarizing events since; behind an |
//! | | | | analyzer from the film on |
//! | sensor | [`SensorClass::Column`] | c | polarizing events, then a depolarizer |
//! | sensor | [`SensorClass::RankOne`] | c, r, axis | a `Column` row, polarizing events since |
//! | sensor | [`SensorClass::Full`] | T, axis | polarizing events, no depolarizer yet |
//! | sensor | [`SensorClass::Common`] | T once, axis | the same, no event told wavelengths |
//! | | | | apart |
//!
//! After the first depolarizer T D = (T e0)(d e0^T) has rank one for ever: the column c is fixed
//! and only the row r is extended.

use super::partition::Part;

/// Classes of light paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LightClass {
    /// No columns.
    Unpolarized,
    /// A Stokes vector per wavelength, and its axis.
    Polarized,
}

impl LightClass {
    /// All of them, in the order of their places.
    pub const ALL: [Self; 2] = [Self::Unpolarized, Self::Polarized];

    /// The class of the rows of a part.
    #[inline(always)]
    pub fn of(part: &Part) -> Self {
        Self::ALL[part.class]
    }

    /// Whether rows have a Stokes vector and its axis.
    #[inline(always)]
    pub fn has_stokes(self) -> bool {
        match self {
            Self::Unpolarized => false,
            Self::Polarized => true,
        }
    }
}

/// Classes of sensor paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum SensorClass {
    /// Identity in the film's frame.
    Fresh,
    /// Intensity in, intensity out.
    Plain,
    /// Intensity out, `row` in.
    Row,
    /// `column` out, intensity in.
    Column,
    /// `column` out, `row` in.
    RankOne,
    /// `matrix`.
    Full,
    /// The first wavelength's `matrix`, for all of them. With one wavelength it is
    /// [`SensorClass::Full`].
    Common,
}

impl SensorClass {
    /// All of them, in the order of their places.
    pub const ALL: [Self; 7] = [
        Self::Fresh,
        Self::Plain,
        Self::Row,
        Self::Column,
        Self::RankOne,
        Self::Full,
        Self::Common,
    ];

    /// The class of the rows of a part.
    #[inline(always)]
    pub fn of(part: &Part) -> Self {
        Self::ALL[part.class]
    }

    /// Whether rows accept light in the frame of an axis of theirs.
    #[inline(always)]
    pub fn has_axis(self) -> bool {
        self.has_row() || self.has_matrix()
    }

    /// Whether rows have the row r.
    #[inline(always)]
    pub fn has_row(self) -> bool {
        match self {
            Self::Row | Self::RankOne => true,
            Self::Fresh | Self::Plain | Self::Column | Self::Full | Self::Common => false,
        }
    }

    /// Whether rows have the column c.
    #[inline(always)]
    pub fn has_column(self) -> bool {
        match self {
            Self::Column | Self::RankOne => true,
            Self::Fresh | Self::Plain | Self::Row | Self::Full | Self::Common => false,
        }
    }

    /// Whether rows have the matrix T.
    #[inline(always)]
    pub fn has_matrix(self) -> bool {
        match self {
            Self::Full | Self::Common => true,
            Self::Fresh | Self::Plain | Self::Row | Self::Column | Self::RankOne => false,
        }
    }

    /// How many of `N` wavelengths have columns of their own.
    #[inline(always)]
    pub fn wavelengths<const N: usize>(self) -> usize {
        if self == Self::Common { 1 } else { N }
    }

    /// The channel that holds a wavelength's columns.
    #[inline(always)]
    pub fn channel_of(self, wavelength: usize) -> usize {
        if self == Self::Common { 0 } else { wavelength }
    }

    /// What rows become at a depolarizer.
    #[inline(always)]
    pub fn depolarized(self) -> Self {
        match self {
            Self::Fresh | Self::Plain | Self::Row => Self::Plain,
            Self::Column | Self::RankOne | Self::Full | Self::Common => Self::Column,
        }
    }

    /// What rows of `N` wavelengths become at a polarizing event, the same for all wavelengths or
    /// not.
    #[inline(always)]
    pub fn extended<const N: usize>(self, achromatic: bool) -> Self {
        match self {
            Self::Fresh | Self::Common if N > 1 && achromatic => Self::Common,
            Self::Fresh | Self::Full | Self::Common => Self::Full,
            Self::Plain | Self::Row => Self::Row,
            Self::Column | Self::RankOne => Self::RankOne,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_list() {
        let light = LightClass::ALL.iter().map(|&class| class as usize);
        let sensor = SensorClass::ALL.iter().map(|&class| class as usize);
        assert!(light.eq(0..LightClass::ALL.len()) && sensor.eq(0..SensorClass::ALL.len()));
    }

    /// What a row is extended by and what is left of it have the columns that this takes.
    #[test]
    fn classes_follow_from_the_columns() {
        for class in SensorClass::ALL {
            for achromatic in [false, true] {
                let after = class.extended::<3>(achromatic);
                assert!(after.has_axis() && after.has_column() == class.has_column());
                assert_eq!(after.extended::<3>(achromatic), after);
                assert_ne!(class.extended::<1>(achromatic), SensorClass::Common);
                assert_eq!(after.depolarized(), after.extended::<3>(true).depolarized());
            }
            let after = class.depolarized();
            assert!(!after.has_axis());
            assert_eq!(after.has_column(), class.has_column() || class.has_matrix());
        }
    }
}
