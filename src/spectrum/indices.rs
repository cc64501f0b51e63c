//! Indices of refraction n - i k by name: metals, and glasses, crystals, liquids and plastics.
//!
//! The tables cite their sources. Metals cover 300 to 1000 nm, or what their source does, linear
//! between the points of the source. Dielectrics have Sellmeier's formula in the range that its
//! source states, and in all of visible light, or a table likewise; k is zero where no source has
//! it. Outside there are none.

use super::{Spectrum, data};

/// Metals: NAME,nk,NM,N,K.
const METALS: &str = include_str!("data/metals.csv");
/// Dielectrics: formulas and tables.
const DIELECTRICS: &str = include_str!("data/dielectrics.csv");

/// The names that [`metal`] knows.
pub fn metal_names() -> Vec<&'static str> {
    data::names(METALS)
}

/// The names that [`index`] knows.
pub fn index_names() -> Vec<&'static str> {
    [data::names(METALS), data::names(DIELECTRICS)].concat()
}

/// Real part n and extinction coefficient k of a metal, by its chemical symbol.
pub fn metal(name: &str) -> Option<(Spectrum, Spectrum)> {
    read(METALS, name)
}

/// Real part n and extinction coefficient k of a metal or a dielectric, by its name.
pub fn index(name: &str) -> Option<(Spectrum, Spectrum)> {
    metal(name).or_else(|| read(DIELECTRICS, name))
}

/// n and k from the lines of a table.
fn read(table: &str, name: &str) -> Option<(Spectrum, Spectrum)> {
    let (mut formula, mut n, mut k) = (None, Points::default(), Points::default());
    for entry in data::entries(table, name) {
        let (kind, rest) = entry.split_once(',')?;
        let numbers = data::numbers(rest)?;
        match (kind, &numbers[..]) {
            ("nk", &[nm, real, extinction]) => {
                n.push(nm, real);
                k.push(nm, extinction);
            }
            ("n", &[nm, real]) => n.push(nm, real),
            ("k", &[nm, extinction]) => k.push(nm, extinction),
            ("sellmeier", [from, to, terms @ ..]) => formula = sellmeier(*from, *to, terms),
            (_, _) => return None,
        }
    }
    let n = formula.or_else(|| n.spectrum())?;
    Some((n, k.spectrum().unwrap_or(Spectrum::Constant(0.0))))
}

fn sellmeier(from_nm: f64, to_nm: f64, terms: &[f64]) -> Option<Spectrum> {
    let (b, c): (Vec<f64>, Vec<f64>) = terms.chunks_exact(2).map(|term| (term[0], term[1])).unzip();
    Spectrum::sellmeier(&b, &c, [from_nm as f32, to_nm as f32]).ok()
}

/// Points of a table.
#[derive(Default)]
struct Points {
    wavelengths_nm: Vec<f32>,
    values: Vec<f32>,
}

impl Points {
    fn push(&mut self, wavelength_nm: f64, value: f64) {
        self.wavelengths_nm.push(wavelength_nm as f32);
        self.values.push(value as f32);
    }

    fn spectrum(&self) -> Option<Spectrum> {
        Spectrum::table(&self.wavelengths_nm, &self.values).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Range;

    fn at(spectrum: &Spectrum, nm: f64) -> f64 {
        f64::from(spectrum.at(nm as f32).unwrap_or_else(|error| panic!("{error}")))
    }

    #[test]
    fn every_name_has_its_index() {
        for name in index_names() {
            let (eta, k) = index(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(eta.check("eta", Range::POSITIVE), Ok(()), "{name}");
            assert_eq!(k.check("k", Range::NOT_NEGATIVE), Ok(()), "{name}");
            for nm in [380.0, 587.56, 656.27, 780.0] {
                assert!(at(&eta, nm) > 0.0 && at(&k, nm) >= 0.0, "{name}");
            }
        }
        for name in metal_names() {
            let (eta, k) = metal(name).unwrap();
            for nm in [380.0, 780.0, 1000.0] {
                assert!(at(&eta, nm) > 0.0 && at(&k, nm) > 0.0, "{name}");
            }
        }
        for unknown in ["", "Unobtainium", "ag", "#", "Ag,nk", "BK7 "] {
            assert_eq!(index(unknown), None, "{unknown}");
        }
        assert_eq!(metal("BK7"), None);
    }

    /// Index at the line d and Abbe number as SCHOTT's data sheets state them.
    #[test]
    fn glasses_have_the_numbers_of_their_data_sheets() {
        for (name, n_d, abbe) in [
            ("BK7", 1.516_80, 64.17),
            ("BaK4", 1.568_83, 55.98),
            ("F2", 1.620_04, 36.37),
            ("LaSF9", 1.850_25, 32.17),
            ("N-SF11", 1.784_72, 25.68),
            ("SF5", 1.672_70, 32.21),
            ("SF10", 1.728_25, 28.41),
            ("SF11", 1.784_72, 25.76),
            ("fused_silica", 1.458_46, 67.82),
        ] {
            let (eta, _) = index(name).unwrap();
            let [d, f, c] = [587.5618, 486.1327, 656.2725].map(|nm| at(&eta, nm));
            assert!((d - n_d).abs() < 1e-5, "{name}: {d}");
            let found = (d - 1.0) / (f - c);
            assert!((found - abbe).abs() < 0.05, "{name}: {found}");
        }
    }

    /// Handbooks' values at the sodium line; water's is that of the IAPWS, relative to vacuum.
    #[test]
    fn others_have_the_numbers_of_handbooks() {
        for (name, n, tolerance) in [
            ("water", 1.333_34, 5e-5),
            ("ice", 1.309, 1e-3),
            ("diamond", 2.417, 1e-3),
            ("quartz_o", 1.544_2, 2e-4),
            ("quartz_e", 1.553_3, 2e-4),
            ("sapphire_o", 1.768, 5e-4),
            ("sapphire_e", 1.760, 5e-4),
            ("acrylic", 1.491, 1e-3),
            ("polycarbonate", 1.585, 1e-3),
            ("polystyrene", 1.591, 1e-3),
        ] {
            let found = at(&index(name).unwrap().0, 589.3);
            assert!((found - n).abs() < tolerance, "{name}: {found}");
        }
        let (_, k) = index("water").unwrap();
        assert!((at(&k, 700.0) - 3.35e-8).abs() < 1e-10);
    }

    /// Where formulas are continued beyond what their sources state, others have measured: Zhang et
    /// al. 2020 the plastics at 400 nm, HIKARI its own SF11 at 388.9 nm, and Phillip and Taft 1964
    /// diamond at 774.9 nm. They differ as much where the sources hold.
    #[test]
    fn continued_formulas_lead_to_what_others_have_measured() {
        for (name, nm, n, tolerance) in [
            ("acrylic", 400.0, 1.508_2, 4e-3),
            ("polycarbonate", 400.0, 1.633_9, 1.2e-2),
            ("polystyrene", 400.0, 1.625_5, 5e-3),
            ("SF11", 388.865, 1.853_7, 2e-3),
            ("diamond", 774.9, 2.406_2, 6e-3),
        ] {
            let found = at(&index(name).unwrap().0, nm);
            assert!((found - n).abs() < tolerance, "{name}: {found}");
        }
    }

    /// Of light that falls straight on, as handbooks have it.
    #[test]
    fn metals_reflect_as_handbooks_say() {
        for (name, nm, reflectance, tolerance) in [
            ("Ag", 550.0, 0.98, 0.01),
            ("Al", 550.0, 0.916, 0.005),
            ("Al", 800.0, 0.868, 0.01),
            ("Au", 500.0, 0.50, 0.03),
            ("Au", 700.0, 0.97, 0.01),
            ("Be", 550.0, 0.53, 0.05),
            ("Cr", 550.0, 0.67, 0.03),
            ("Cu", 500.0, 0.60, 0.03),
            ("Cu", 700.0, 0.96, 0.02),
            ("Fe", 589.0, 0.53, 0.05),
            ("Ir", 550.0, 0.73, 0.03),
            ("Mo", 550.0, 0.58, 0.03),
            ("Ni", 550.0, 0.63, 0.03),
            ("Pb", 589.0, 0.64, 0.04),
            ("Pd", 550.0, 0.69, 0.03),
            ("Pt", 550.0, 0.64, 0.03),
            ("Rh", 550.0, 0.77, 0.02),
            ("Ti", 550.0, 0.56, 0.04),
            ("W", 550.0, 0.50, 0.02),
        ] {
            let (eta, k) = metal(name).unwrap();
            let (n, k) = (at(&eta, nm), at(&k, nm));
            let found = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
            assert!((found - reflectance).abs() < tolerance, "{name} {nm}: {found}");
        }
    }
}
