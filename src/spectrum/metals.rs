//! Named metals: complex indices of refraction n - i k.
//!
//! Values are Palik's (Handbook of Optical Constants of Solids) at the wavelengths that stand for
//! blue, green and red; between them interpolation is linear, outside there are none.

use super::Spectrum;

/// The wavelengths of the tables below, in nanometers.
const WAVELENGTHS_NM: [f32; 3] = [450.0, 550.0, 650.0];

/// Name, n and k at [`WAVELENGTHS_NM`].
const METALS: [(&str, [f32; 3], [f32; 3]); 3] = [
    ("Al", [0.617_952_9, 0.958_569, 1.474_77], [5.469_423, 6.686_968, 7.794_109]),
    ("Au", [1.508_458_1, 0.350_408_84, 0.167_789_52], [1.878_849_8, 2.714_063, 3.137_816]),
    ("Cu", [1.165_807_8, 0.958_161_8, 0.216_560_62], [2.393_857, 2.577_064_8, 3.637_741]),
];

/// The names that [`metal`] knows.
pub fn metal_names() -> impl Iterator<Item = &'static str> {
    METALS.iter().map(|(name, ..)| *name)
}

/// Real part n and extinction coefficient k of a metal, by its chemical symbol.
pub fn metal(name: &str) -> Option<(Spectrum, Spectrum)> {
    let (_, n, k) = METALS.iter().find(|(known, ..)| *known == name)?;
    let eta = Spectrum::table(&WAVELENGTHS_NM, n).ok()?;
    Some((eta, Spectrum::table(&WAVELENGTHS_NM, k).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{Color, Role};

    #[test]
    fn every_name_has_its_metal() {
        for name in metal_names() {
            let (eta, k) = metal(name).unwrap();
            assert!(eta.values().iter().chain(k.values()).all(|value| *value > 0.0));
        }
        assert_eq!(metal("Unobtainium"), None);
    }

    #[test]
    fn aluminum_at_550_nm_is_paliks() {
        let (eta, k) = metal("Al").unwrap();
        let green = Color::Mono { wavelength_nm: 550.0 }.into();
        assert_eq!(eta.sample::<1>(green, Role::Index), Ok([0.958_569]));
        assert_eq!(k.sample::<1>(green, Role::Index), Ok([6.686_968]));
    }
}
