//! Colors, scales and legends as a page knows them: those of [`super::super::visualize`].

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

use super::super::legend::Legend;
use super::super::palette::{self, NEUTRAL, NO_LIGHT, oklab};
use super::super::visualize::{
    INTENSITY_TICKS, LUMINANCE, Map, View, Weakness, intensity_legend, intensity_place, legend_of,
    plane_legend, scale_of, weakness_of,
};

/// Steps of a scale from 0 to 1, between whose colors the page interpolates codes: no code changes
/// by more than two.
const SCALE_STEPS: usize = 1024;

/// What turns Stokes vectors into colors.
#[derive(Serialize)]
pub struct Colors {
    maps: Vec<MapData>,
    /// Colors of every scale that a map names: red, green and blue, a byte each, in base64.
    scales: Vec<String>,
    palette: PaletteData,
    /// Weights of red, green and blue.
    luminance: [f32; 3],
    /// Where scales may end, and which of these fits the images.
    ends: [f32; View::ENDS.len()],
    end: usize,
    degree_faded: f32,
    /// Shares of the largest intensity that its legend names, by their places on the bar.
    intensity_ticks: Vec<(f32, f32)>,
}

/// A choice in the page's list of maps.
#[derive(Serialize)]
struct MapData {
    id: String,
    group: &'static str,
    title: String,
    /// What of the Stokes vector is shown: a map's name, or `stokes` and `stokes-relative` with a
    /// component.
    quantity: &'static str,
    component: usize,
    /// What the colors of S1 to S3 end at.
    range: f32,
    scale: usize,
    weakness: &'static str,
    /// One for every end of the scales, or one where the map does not depend on it.
    legends: Vec<LegendData>,
}

#[derive(PartialEq, Serialize)]
struct LegendData {
    title: String,
    ticks: Vec<(f32, String)>,
    swatches: Vec<([u8; 3], &'static str)>,
    disk: bool,
}

/// What turns numbers into colors.
#[derive(Serialize)]
struct PaletteData {
    /// The smallest value of every sRGB code from 1 to 255.
    thresholds: Vec<f32>,
    /// The value of every code.
    linear: Vec<f32>,
    cones_of_rgb: [[f32; 3]; 3],
    lab_of_roots: [[f32; 3]; 3],
    roots_of_lab: [[f32; 3]; 3],
    rgb_of_cones: [[f32; 3]; 3],
    neutral: [u8; 3],
    no_light: [u8; 3],
}

impl Colors {
    /// The maps of images: where their degrees end ([`View::fitted`]) and what the colors of S1 to
    /// S3 end at; nothing where they hold intensity alone.
    pub fn new(polarized: Option<(f32, f32)>) -> Self {
        let (degree_max, range) = polarized.unwrap_or((1.0, 1.0));
        let end = View::ENDS.iter().position(|end| *end == degree_max);
        let mut scales = Vec::new();
        let maps = match polarized {
            None => maps_of(Map::Intensity, range, &mut scales),
            Some(_) => ORDER.iter().flat_map(|map| maps_of(*map, range, &mut scales)).collect(),
        };
        Self {
            maps,
            scales,
            palette: PaletteData::new(),
            luminance: LUMINANCE,
            ends: View::ENDS,
            end: end.unwrap_or(View::ENDS.len() - 1),
            degree_faded: View::default().degree_faded,
            intensity_ticks: INTENSITY_TICKS.map(|share| (intensity_place(share), share)).to_vec(),
        }
    }
}

/// The order of the page's list.
const ORDER: [Map; Map::ALL.len()] = [
    Map::Intensity,
    Map::Stokes,
    Map::StokesRelative,
    Map::Dop,
    Map::Aolp,
    Map::Ellipticity,
    Map::LinearCircular,
    Map::Chirality,
    Map::AolpDark,
    Map::DopRed,
    Map::Type,
    Map::Orientation,
];

/// The group and the title in the page's list.
fn words_of(map: Map) -> (&'static str, &'static str) {
    const PLANES: &str = "Stokes vector";
    const POLARIZATION: &str = "Polarization";
    const OTHERS: &str = "Other colors";
    match map {
        Map::Intensity => (PLANES, "Intensity S0"),
        Map::Stokes => (PLANES, ""),
        Map::StokesRelative => ("Relative to S0", ""),
        Map::Dop => (POLARIZATION, "Degree of polarization"),
        Map::Aolp => (POLARIZATION, "Angle of linear polarization"),
        Map::Ellipticity => (POLARIZATION, "Ellipticity"),
        Map::LinearCircular => (POLARIZATION, "Linear share of polarization"),
        Map::Chirality => (POLARIZATION, "Circular share S3/S0"),
        Map::AolpDark => (OTHERS, "Angle, as bright as linear"),
        Map::DopRed => (OTHERS, "Degree, red"),
        Map::Type => (OTHERS, "Type, as bright as polarized"),
        Map::Orientation => (OTHERS, "Orientation, as bright as linear"),
    }
}

/// The choices that a map of `visualize` is on the page.
fn maps_of(map: Map, range: f32, scales: &mut Vec<String>) -> Vec<MapData> {
    let (group, title) = words_of(map);
    let of_end = |end: f32| View { degree_max: end, ..View::default() };
    let whole = MapData {
        id: map.name().to_owned(),
        group,
        title: title.to_owned(),
        quantity: map.name(),
        component: 0,
        range,
        scale: index_of(packed_scale(scale_of(map)), scales),
        weakness: match weakness_of(map) {
            Weakness::None => "none",
            Weakness::Grey => "grey",
            Weakness::Dark => "dark",
            Weakness::DarkHsv => "dark-hsv",
        },
        legends: Vec::new(),
    };
    let plane = |component: usize, legends: Vec<Legend>| MapData {
        id: format!("{}-{component}", map.name()),
        title: if map == Map::Stokes {
            format!("S{component}")
        } else {
            format!("S{component}/S0")
        },
        component,
        legends: legends_of(legends),
        ..whole.clone_without_legends()
    };
    match map {
        Map::Intensity => {
            let legends = legends_of(vec![intensity_legend(0.0)]);
            vec![MapData { legends, ..whole }]
        }
        Map::Stokes => (1..4).map(|i| plane(i, vec![plane_legend(i, false, range)])).collect(),
        Map::StokesRelative => {
            let legends = |i| View::ENDS.map(|end| plane_legend(i, true, end)).into();
            (1..4).map(|i| plane(i, legends(i))).collect()
        }
        Map::Dop
        | Map::LinearCircular
        | Map::Aolp
        | Map::AolpDark
        | Map::Chirality
        | Map::Ellipticity
        | Map::DopRed
        | Map::Type
        | Map::Orientation => {
            let legends = View::ENDS.map(|end| legend_of(map, &of_end(end))).into();
            vec![MapData { legends: legends_of(legends), ..whole }]
        }
    }
}

impl MapData {
    fn clone_without_legends(&self) -> Self {
        Self { id: self.id.clone(), title: self.title.clone(), legends: Vec::new(), ..*self }
    }
}

/// Legends as data, one if all are alike.
fn legends_of(legends: Vec<Legend>) -> Vec<LegendData> {
    let mut list: Vec<LegendData> = legends
        .into_iter()
        .map(|Legend { title, ticks, swatches, disk, bar: _ }| LegendData {
            title,
            ticks,
            swatches,
            disk,
        })
        .collect();
    list.dedup();
    list
}

fn packed_scale(color: fn(f32) -> [u8; 3]) -> String {
    let colors = (0..=SCALE_STEPS).map(|i| color(i as f32 / SCALE_STEPS as f32));
    STANDARD.encode(colors.flatten().collect::<Vec<u8>>())
}

/// Where a scale stands in the list, to which it is added if it is not there.
fn index_of(scale: String, scales: &mut Vec<String>) -> usize {
    if let Some(index) = scales.iter().position(|other| *other == scale) {
        return index;
    }
    scales.push(scale);
    scales.len() - 1
}

impl PaletteData {
    fn new() -> Self {
        Self {
            thresholds: (1..=255).map(threshold).collect(),
            linear: (0..=255).map(palette::decode_srgb).collect(),
            cones_of_rgb: oklab::CONES_OF_RGB,
            lab_of_roots: oklab::LAB_OF_ROOTS,
            roots_of_lab: oklab::ROOTS_OF_LAB,
            rgb_of_cones: oklab::RGB_OF_CONES,
            neutral: NEUTRAL,
            no_light: NO_LIGHT,
        }
    }
}

/// The smallest value whose code is at least `code`, found among the bits of [0, 1].
fn threshold(code: u8) -> f32 {
    let (mut below, mut at_least) = (0, 1.0_f32.to_bits());
    while at_least - below > 1 {
        let middle = below + (at_least - below) / 2;
        if palette::encode_srgb(f32::from_bits(middle)) < code {
            below = middle;
        } else {
            at_least = middle;
        }
    }
    f32::from_bits(at_least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_where_codes_begin() {
        for code in 1..=255 {
            let value = threshold(code);
            assert_eq!(palette::encode_srgb(value), code);
            assert_eq!(palette::encode_srgb(value.next_down()), code - 1);
        }
    }

    /// So that a code between two steps is at most one off.
    #[test]
    fn scales_change_slowly() {
        for map in Map::ALL {
            let color = |i: usize| scale_of(map)(i as f32 / SCALE_STEPS as f32);
            for i in 0..SCALE_STEPS {
                let (here, next) = (color(i), color(i + 1));
                assert!((0..3).all(|c| here[c].abs_diff(next[c]) <= 2), "{map:?} {i}");
            }
        }
    }

    #[test]
    fn the_list_has_every_map_once() {
        for map in Map::ALL {
            assert_eq!(ORDER.iter().filter(|other| **other == map).count(), 1, "{map:?}");
        }
    }
}
