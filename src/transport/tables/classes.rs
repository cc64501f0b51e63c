//! Classes of rows: which columns of polarization exist for them. All else is known without
//! storage:
//!
//! | side | class | columns | when |
//! |---|---|---|---|
//! | light | [`LightClass::Unpolarized`] | none | emitted unpolarized, or after a depolarizer |
//! | light | [`LightClass::Polarized`] | Stokes, axis | emitted polarized, or after a polarizing |
//! | | | | event |
//! | sensor | [`SensorClass::Fresh`] | none: T = 1 in the film's frame | no event yet |
//! | sensor | [`SensorClass::Plain`] | none: r = e0 | after a depolarizer (a film of intensities |
//! | | | | counts as one) |
//! | sensor | [`SensorClass::Row`] | r, axis | a `Plain` row, polarizing events since; behind an |
//! | | | | analyzer from the film on |
//! | sensor | [`SensorClass::Once`] | a, c, s, a rotation, axis | one polarizing event, of the |
//! | | | | form of a block, no depolarizer yet |
//! | sensor | [`SensorClass::OnceCommon`] | the same once | such an event that told no |
//! | | | | wavelengths apart |
//! | sensor | [`SensorClass::Full`] | T, axis | polarizing events, no depolarizer yet |
//! | sensor | [`SensorClass::Common`] | T once, axis | the same, no event told wavelengths |
//! | | | | apart |
//!
//! After the first depolarizer T D = (T e0)(d e0^T) has rank one for ever: the column T e0 is fixed
//! and belongs to the slot that the row measures for ([`super::measured`]); only the row d e0^T is
//! extended.

use super::partition::Part;
use crate::scattering::event::Form;

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
    /// The product of a rotation and one block.
    Once,
    /// The same with the first wavelength's block for all of them; [`SensorClass::Once`] with one
    /// wavelength.
    OnceCommon,
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
        Self::Once,
        Self::OnceCommon,
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
        match self {
            Self::Row | Self::Once | Self::OnceCommon | Self::Full | Self::Common => true,
            Self::Fresh | Self::Plain => false,
        }
    }

    /// Whether rows have the row r.
    #[inline(always)]
    pub fn has_row(self) -> bool {
        match self {
            Self::Row => true,
            Self::Fresh
            | Self::Plain
            | Self::Once
            | Self::OnceCommon
            | Self::Full
            | Self::Common => false,
        }
    }

    /// Whether rows have one event.
    #[inline(always)]
    pub fn has_event(self) -> bool {
        match self {
            Self::Once | Self::OnceCommon => true,
            Self::Fresh | Self::Plain | Self::Row | Self::Full | Self::Common => false,
        }
    }

    /// Whether rows have the matrix T.
    #[inline(always)]
    pub fn has_matrix(self) -> bool {
        match self {
            Self::Full | Self::Common => true,
            Self::Fresh | Self::Plain | Self::Row | Self::Once | Self::OnceCommon => false,
        }
    }

    /// Whether the columns of the first wavelength are those of all.
    #[inline(always)]
    fn is_common(self) -> bool {
        match self {
            Self::OnceCommon | Self::Common => true,
            Self::Fresh | Self::Plain | Self::Row | Self::Once | Self::Full => false,
        }
    }

    /// How many of `N` wavelengths have columns of their own.
    #[inline(always)]
    pub fn wavelengths<const N: usize>(self) -> usize {
        if self.is_common() { 1 } else { N }
    }

    /// The channel that holds a wavelength's columns.
    #[inline(always)]
    pub fn channel_of(self, wavelength: usize) -> usize {
        if self.is_common() { 0 } else { wavelength }
    }

    /// What rows of `N` wavelengths become at a polarizing event whose kernel has a form, the same
    /// for all wavelengths or not.
    #[inline(always)]
    pub fn extended<const N: usize>(self, form: Form, achromatic: bool) -> Self {
        let is_common = N > 1 && achromatic;
        match self {
            Self::Fresh if form == Form::Block && is_common => Self::OnceCommon,
            Self::Fresh if form == Form::Block => Self::Once,
            Self::Fresh | Self::OnceCommon | Self::Common if is_common => Self::Common,
            Self::Fresh | Self::Once | Self::OnceCommon | Self::Full | Self::Common => Self::Full,
            Self::Plain | Self::Row => Self::Row,
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

    /// What a row is extended by has the columns that this takes.
    #[test]
    fn classes_follow_from_the_columns() {
        for class in SensorClass::ALL {
            for (form, achromatic) in [Form::Block, Form::Spheroid, Form::Dense]
                .into_iter()
                .flat_map(|form| [false, true].map(|achromatic| (form, achromatic)))
            {
                let after = class.extended::<3>(form, achromatic);
                assert!(after.has_axis());
                assert_ne!(after, SensorClass::Fresh);
                let later = after.extended::<3>(form, achromatic);
                assert_eq!(later.extended::<3>(form, achromatic), later);
                assert!(!later.has_event());
                assert_eq!(class.extended::<1>(form, achromatic).wavelengths::<3>(), 3);
            }
        }
    }
}
