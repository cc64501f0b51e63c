//! Bands in EXR files, as Fichet, Pacanowski and Wilkie 2021 lay them out ("An OpenEXR Layout for
//! Spectral Images", JCGT 10(3)): a channel for every Stokes component and center, as
//! `S0.550,000000nm`, and attributes that say what is in them. Widths and names, for which the
//! layout has no place, stand in an attribute of our own.

use std::collections::{BTreeMap, HashMap};

use ::exr::prelude::{AttributeValue, Text};

use crate::spectrum::{Band, Bands};

/// The name of the attribute that holds names and widths.
pub const BANDS: &str = "sunstone.bands";
/// Width of a band of which nothing tells another, in nanometers.
const WIDTH_NM: f32 = 1.0;

/// The names of the channels of one Stokes component.
pub fn names(component: usize, bands: &Bands) -> Vec<String> {
    bands.list().iter().map(|band| name(component, band.center_nm)).collect()
}

fn name(component: usize, center_nm: f32) -> String {
    format!("S{component}.{}nm", format!("{center_nm:.6}").replace('.', ","))
}

/// What the layout says about a file: names and values of attributes.
pub fn attributes(components: usize, bands: &Bands) -> Vec<(&'static str, String)> {
    let text = |name, value: &str| (name, value.to_owned());
    let mut attributes = vec![
        text("spectralLayoutVersion", "1.0"),
        text("emissiveUnits", "W.m^-2.sr^-1"),
        (BANDS, bands.to_text()),
    ];
    if components == 4 {
        attributes.push(text("polarisationHandedness", "right"));
    }
    attributes
}

/// The bands of a file, with its Stokes components and the names of their channels in the order of
/// planes; none if it has no bands.
///
/// # Errors
/// When components differ in their wavelengths, or these are no bands.
pub fn layout<'a>(
    channels: impl Iterator<Item = &'a str>,
    attributes: &HashMap<Text, AttributeValue>,
) -> Result<Option<(Bands, usize, Vec<String>)>, String> {
    let mut found: [BTreeMap<u32, String>; 4] = Default::default();
    for channel in channels {
        if let Some((component, center_nm)) = parsed(channel) {
            found[component].insert(center_nm.to_bits(), channel.to_owned());
        }
    }
    if found[0].is_empty() {
        return Ok(None);
    }
    let components = if found[1..].iter().all(BTreeMap::is_empty) { 1 } else { 4 };
    if found[..components].iter().any(|of| !of.keys().eq(found[0].keys())) {
        return Err("its Stokes components have bands at different wavelengths".to_owned());
    }
    // Bits of numbers above zero are in their order.
    let centers: Vec<f32> = found[0].keys().map(|bits| f32::from_bits(*bits)).collect();
    let bands = match stated(attributes).filter(|bands| goes_with(bands, &centers)) {
        Some(bands) => bands,
        None => Bands::new(side_by_side(&centers)).map_err(|fault| fault.to_string())?,
    };
    let names = found.into_iter().take(components).flat_map(BTreeMap::into_values).collect();
    Ok(Some((bands, components, names)))
}

/// The component and the center in nanometers that a channel is named after.
fn parsed(channel: &str) -> Option<(usize, f32)> {
    let rest = channel.strip_prefix('S')?;
    let component = rest.chars().next()?.to_digit(4)? as usize;
    let number = rest[1..].trim_start_matches('.').strip_suffix("nm")?;
    if !number.starts_with(|first: char| first.is_ascii_digit()) {
        return None;
    }
    let center_nm: f32 = number.replace(',', ".").parse().ok()?;
    (center_nm.is_finite() && center_nm > 0.0).then_some((component, center_nm))
}

fn stated(attributes: &HashMap<Text, AttributeValue>) -> Option<Bands> {
    match attributes.get(BANDS.as_bytes()) {
        Some(AttributeValue::Text(text)) => {
            Bands::from_text(&String::from_utf8_lossy(text.as_slice()))
        }
        _ => None,
    }
}

/// Whether bands have the centers that channels are named after.
fn goes_with(bands: &Bands, centers: &[f32]) -> bool {
    let names = bands.list().iter().map(|band| name(0, band.center_nm));
    names.eq(centers.iter().map(|center_nm| name(0, *center_nm)))
}

/// Bands from halfway to the one neighbor to halfway to the other, as wide on the outside.
fn side_by_side(centers: &[f32]) -> Vec<Band> {
    let gap = |index: usize| Some(centers.get(index + 1)? - centers.get(index)?);
    let width = |index: usize| match (index.checked_sub(1).and_then(gap), gap(index)) {
        (Some(before), Some(behind)) => before.min(behind),
        (Some(gap), None) | (None, Some(gap)) => gap,
        (None, None) => WIDTH_NM,
    };
    (0..).zip(centers).map(|(index, center_nm)| Band::new(*center_nm, width(index))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_named_by_their_wavelengths() {
        let bands = Bands::evenly(400.0, 700.0, 4).unwrap();
        assert_eq!(names(2, &bands)[1], "S2.500,000000nm");
        assert_eq!(parsed("S2.500,000000nm"), Some((2, 500.0)));
        assert_eq!(parsed("S0.5,5e2nm"), Some((0, 550.0)));
        for other in ["S0.R", "S4.500nm", "T.500nm", "S0.nm", "S0.infnm", "S0.-5nm", "S0.500um"] {
            assert_eq!(parsed(other), None, "{other}");
        }
    }

    #[test]
    fn bands_of_others_lie_side_by_side() {
        let of = |channels: &[&str]| layout(channels.iter().copied(), &HashMap::new());
        let (bands, components, names) =
            of(&["S0.510nm", "R", "S0.500nm", "S0.530nm"]).unwrap().expect("bands");
        assert_eq!((components, &*names[0]), (1, "S0.500nm"));
        let widths: Vec<f32> = bands.list().iter().map(|band| band.width_nm).collect();
        assert_eq!(widths, [10.0, 10.0, 20.0]);
        assert_eq!(of(&["S0", "S1"]).unwrap(), None);
        assert!(of(&["S0.500nm", "S1.510nm", "S2.500nm", "S3.500nm"]).is_err());
        assert!(of(&["S0.500nm", "S1.500nm"]).is_err());
    }
}
