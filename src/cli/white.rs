//! `--rgb-white`: under which white red, green and blue have the color that they say.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::spectrum::White;

/// A white, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WhiteName(pub White);

impl ValueEnum for WhiteName {
    fn value_variants<'a>() -> &'a [Self] {
        static NAMES: [WhiteName; White::ALL.len()] = {
            let [a, b] = White::ALL;
            [WhiteName(a), WhiteName(b)]
        };
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            White::D65 => "Daylight, CIE D65, white of sRGB",
            White::E => "Equal energy: a grey is its number at every wavelength",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}
