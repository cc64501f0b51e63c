//! Maps of polarization: what the eye does not see, in color.
//!
//! Stokes vector per pixel -> a number -> a color -> a picture with its legend beneath.
//! With P = sqrt(S1^2 + S2^2 + S3^2) and L = sqrt(S1^2 + S2^2), the degree of polarization is
//! P / S0, the linear share L / P, the angle of linear polarization mod(atan2(S2, S1) / 2, pi),
//! counterclockwise from the right of the image as one looks at it.
//!
//! The channels of RGB images are combined by luminance first, each Stokes component as
//! 0.2126 R + 0.7152 G + 0.0722 B, those of bands and responses by their mean, and the formulas
//! applied to the result. The intensity of bands is a picture in color where they tell it
//! ([`crate::spectrum::rgb_of_bands`]). Where there is no light (S0 not above 0, or not a number) a
//! map is black; where a map asks for a direction or a type that weak polarization does not have,
//! it fades to grey ([`View::degree_faded`]).

use std::str::FromStr;

use super::error::OutputError;
use super::legend::{Legend, arrange, with_legend_of};
use super::palette::{self, NEUTRAL, NO_LIGHT, mix, sample};
use super::picture::Picture;
use super::{check_shape, png};
use crate::image::StokesImage;
use crate::math::elementary::{atan2, exp2, hypot, log10};
use crate::spectrum::Color;

/// Title of the picture of S0.
const INTENSITY: &str = "intensity S0";
/// Why an image without polarization shows none.
pub(super) const INTENSITY_ALONE: &str =
    "it holds the intensity alone; render it in the polarized mode";
/// The luminance of linear sRGB: weights of red, green and blue.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// S0 as a picture.
    Intensity,
    /// Degree of polarization, the paper's blue (none) to yellow (full).
    Dop,
    /// Linear against circular, the paper's blue (circular) to yellow (linear).
    LinearCircular,
    /// Angle of linear polarization as a hue of even lightness.
    Aolp,
    /// Angle of linear polarization as HSV hue, degree of linear polarization as value; the dark
    /// version of polanalyser.
    AolpDark,
    /// S3 / S0: left-handed blue, right-handed yellow.
    Chirality,
    /// Ellipticity angle, half of asin(S3 / P): left circular blue, linear dark, right circular
    /// yellow.
    Ellipticity,
    /// The four planes: S0 as a picture and S1 to S3 on one signed scale.
    Stokes,
    /// S1 to S3 relative to S0, each on [-1, 1], beside S0.
    StokesRelative,
    /// Degree of polarization, black to red, in the manner of Wilkie and Weidlich 2010.
    DopRed,
    /// Linear cyan, circular yellow, as bright as polarized, in the manner of the same.
    Type,
    /// Orientation in the manner of the same: red along x, green along y, blue and yellow at 45
    /// and 135 degrees, as bright as linearly polarized.
    Orientation,
}

impl Map {
    /// All maps.
    pub const ALL: [Map; 12] = [
        Map::Intensity,
        Map::Dop,
        Map::LinearCircular,
        Map::Aolp,
        Map::AolpDark,
        Map::Chirality,
        Map::Ellipticity,
        Map::Stokes,
        Map::StokesRelative,
        Map::DopRed,
        Map::Type,
        Map::Orientation,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Map::Intensity => "intensity",
            Map::Dop => "dop",
            Map::LinearCircular => "linear-circular",
            Map::Aolp => "aolp",
            Map::AolpDark => "aolp-dark",
            Map::Chirality => "chirality",
            Map::Ellipticity => "ellipticity",
            Map::Stokes => "stokes",
            Map::StokesRelative => "stokes-relative",
            Map::DopRed => "dop-red",
            Map::Type => "type",
            Map::Orientation => "orientation",
        }
    }
}

/// How a map is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Exposure of intensities: values are multiplied by two to this power.
    pub exposure_ev: f32,
    /// The degree of polarization at which a scale, or a brightness, reaches its end; 1 shows the
    /// whole range and less shows weak polarization.
    pub degree_max: f32,
    /// The degree of polarization from which on a type or a direction has its full color; below,
    /// it fades to grey, for there it would be noise.
    pub degree_faded: f32,
}

impl Default for View {
    fn default() -> Self {
        Self { exposure_ev: 0.0, degree_max: 1.0, degree_faded: 0.01 }
    }
}

impl View {
    /// Where scales may end.
    pub const ENDS: [f32; 10] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];

    /// Scales that end at the first of [`View::ENDS`] that holds 99 percent of what is polarized.
    pub fn fitted(image: &StokesImage) -> Self {
        let polarized = image.components == 4 && check_shape(image).is_ok();
        let pixels = if polarized { image.width * image.height } else { 0 };
        let range = range_of((0..pixels).map(|pixel| dop(stokes_at(image, pixel))));
        let degree_max = Self::ENDS.into_iter().find(|end| range <= *end).unwrap_or(1.0);
        Self { degree_max, ..Self::default() }
    }

    /// A degree or signed share on the scale that ends at `degree_max`.
    fn scaled(&self, degree: f32) -> f32 {
        if self.degree_max > 0.0 { (degree / self.degree_max).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// How much of its color a type or a direction has at a degree.
    fn strength(&self, degree: f32) -> f32 {
        if degree < self.degree_faded { degree / self.degree_faded } else { 1.0 }
    }
}

impl FromStr for Map {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let known = Map::ALL.map(Map::name).join(", ");
        let found = Map::ALL.into_iter().find(|map| map.name() == name);
        found.ok_or_else(|| format!("there is no map {name:?}; known are {known}"))
    }
}

/// Degree of polarization; 0 where there is no light.
pub fn dop(stokes: [f32; 4]) -> f32 {
    ratio(hypot(hypot(stokes[1], stokes[2]), stokes[3]), stokes[0])
}

/// Degree of linear polarization; 0 where there is no light.
pub fn dolp(stokes: [f32; 4]) -> f32 {
    ratio(hypot(stokes[1], stokes[2]), stokes[0])
}

/// Angle of linear polarization in radians, in [0, pi).
pub fn aolp(stokes: [f32; 4]) -> f32 {
    let angle = (0.5 * atan2(stokes[2], stokes[1])).rem_euclid(std::f32::consts::PI);
    // A tiny negative angle rounds up to pi itself.
    if angle < std::f32::consts::PI { angle } else { 0.0 }
}

/// The luminance Stokes vector of a pixel of an image with four components.
pub fn stokes_at(image: &StokesImage, pixel: usize) -> [f32; 4] {
    [0, 1, 2, 3].map(|component| luminance_at(image, component, pixel))
}

/// One Stokes component of a pixel, its channels combined by luminance.
pub(super) fn luminance_at(image: &StokesImage, component: usize, pixel: usize) -> f32 {
    luminance(&image.color, |channel| image.plane(component, channel)[pixel])
}

/// Channels combined by luminance, or bands and responses by their mean.
pub(super) fn luminance(color: &Color, value: impl Fn(usize) -> f32) -> f32 {
    match color {
        Color::Rgb => LUMINANCE[0] * value(0) + LUMINANCE[1] * value(1) + LUMINANCE[2] * value(2),
        Color::Mono { .. } => value(0),
        Color::Bands(_) | Color::Responses(_) => {
            let count = color.channels();
            (0..count).map(value).sum::<f32>() / count as f32
        }
    }
}

/// The map alone, pixel for pixel; the Stokes planes two by two.
pub fn colorize(image: &StokesImage, map: Map, view: &View) -> Result<Picture, OutputError> {
    let views = views(image, map, view)?;
    let mut pictures = views.into_iter().map(|(picture, _)| picture);
    match (map, pictures.next()) {
        (Map::Stokes | Map::StokesRelative, Some(first)) => {
            let (width, height) = (first.width, first.height);
            let mut whole = Picture::new(2 * width, 2 * height, NO_LIGHT);
            for (i, picture) in std::iter::once(first).chain(pictures).enumerate() {
                whole.paste(&picture, i % 2 * width, i / 2 * height);
            }
            Ok(whole)
        }
        (_, first) => Ok(first.unwrap_or_else(|| Picture::new(0, 0, NO_LIGHT))),
    }
}

/// The map with its legend beneath; small images are enlarged.
pub fn visualize(image: &StokesImage, map: Map, view: &View) -> Result<Picture, OutputError> {
    let views = views(image, map, view)?;
    let with_legend = |(picture, legend)| with_legend_of(image, &picture, legend);
    let pictures: Vec<Picture> = views.into_iter().map(with_legend).collect();
    Ok(arrange(&pictures, 2))
}

/// Intensity, degree of polarization and linear-versus-circular side by side, as in the paper's
/// figures 3 and 4.
pub fn panels(image: &StokesImage, view: &View) -> Result<Picture, OutputError> {
    let mut pictures = Vec::new();
    for map in [Map::Intensity, Map::Dop, Map::LinearCircular] {
        pictures.push(visualize(image, map, view)?);
    }
    Ok(arrange(&pictures, 3))
}

fn views(
    image: &StokesImage,
    map: Map,
    view: &View,
) -> Result<Vec<(Picture, Legend)>, OutputError> {
    check_shape(image).map_err(|reason| OutputError::Image { reason })?;
    if map == Map::Intensity {
        return Ok(vec![intensity(image, view.exposure_ev, INTENSITY.to_owned())]);
    }
    if image.components != 4 {
        return Err(OutputError::Image { reason: INTENSITY_ALONE });
    }
    let relative = map == Map::StokesRelative;
    if !relative && map != Map::Stokes {
        let picture = paint(image, |stokes| color_of(map, stokes, view));
        return Ok(vec![(picture, legend_of(map, view))]);
    }
    let range = if relative { view.degree_max } else { signed_range(image) };
    let mut views = vec![intensity(image, view.exposure_ev, INTENSITY.to_owned())];
    for component in 1..4 {
        let picture = paint(image, |stokes| {
            let scale = if relative { range * stokes[0] } else { range };
            signed(0.5 + 0.5 * stokes[component] / scale)
        });
        views.push((picture, plane_legend(component, relative, range)));
    }
    Ok(views)
}

fn paint(image: &StokesImage, color: impl Fn([f32; 4]) -> [u8; 3]) -> Picture {
    let pixels = (0..image.width * image.height)
        .map(|pixel| {
            let stokes = stokes_at(image, pixel);
            let lit = stokes[0] > 0.0 && stokes.iter().all(|value| value.is_finite());
            if lit { color(stokes) } else { NO_LIGHT }
        })
        .collect();
    Picture { width: image.width, height: image.height, pixels }
}

fn ratio(part: f32, whole: f32) -> f32 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// The color of a Stokes vector: that of its place on the map's scale, with the strength it has.
fn color_of(map: Map, stokes: [f32; 4], view: &View) -> [u8; 3] {
    let (place, strength) = place_of(map, stokes, view);
    let color = scale_of(map);
    match weakness_of(map) {
        Weakness::None => color(place),
        Weakness::Grey if strength < 1.0 => mix(NEUTRAL, color(place), strength),
        Weakness::Grey => color(place),
        Weakness::Dark => mix(NO_LIGHT, color(place), strength),
        Weakness::DarkHsv => palette::hsv(place, strength),
    }
}

/// What becomes of colors where the polarization is weak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weakness {
    /// Nothing.
    None,
    /// They fade to [`NEUTRAL`].
    Grey,
    /// They fade to black.
    Dark,
    /// They fade to black as the value of HSV does, in proportion of their codes.
    DarkHsv,
}

/// What becomes of a map's colors where the polarization is weak.
pub(super) fn weakness_of(map: Map) -> Weakness {
    match map {
        Map::LinearCircular | Map::Aolp | Map::Ellipticity => Weakness::Grey,
        Map::Type | Map::Orientation => Weakness::Dark,
        Map::AolpDark => Weakness::DarkHsv,
        Map::Intensity
        | Map::Dop
        | Map::Chirality
        | Map::Stokes
        | Map::StokesRelative
        | Map::DopRed => Weakness::None,
    }
}

/// Where a Stokes vector lies on a map's scale, and how strong its color is there.
fn place_of(map: Map, stokes: [f32; 4], view: &View) -> (f32, f32) {
    let linear = hypot(stokes[1], stokes[2]);
    let polarized = hypot(linear, stokes[3]);
    let turn = || aolp(stokes) / std::f32::consts::PI;
    let degree = || view.scaled(dop(stokes));
    match map {
        Map::Dop | Map::DopRed => (degree(), 1.0),
        Map::LinearCircular => (ratio(linear, polarized), view.strength(dop(stokes))),
        Map::Type => (ratio(linear, polarized), degree()),
        Map::Aolp => (turn(), view.strength(dolp(stokes))),
        Map::AolpDark | Map::Orientation => (turn(), view.scaled(dolp(stokes))),
        Map::Chirality => (0.5 + 0.5 * view.scaled(ratio(stokes[3], stokes[0])), 1.0),
        Map::Ellipticity => {
            (0.5 + atan2(stokes[3], linear) / std::f32::consts::PI, view.strength(dop(stokes)))
        }
        Map::Intensity | Map::Stokes | Map::StokesRelative => (0.0, 1.0),
    }
}

/// The colors of a map over [0, 1], where nothing is weak.
pub(super) fn scale_of(map: Map) -> fn(f32) -> [u8; 3] {
    match map {
        Map::Intensity => grey,
        Map::Dop | Map::LinearCircular => |t| sample(palette::BLUE_YELLOW, t),
        Map::Aolp => palette::wheel,
        Map::AolpDark => |t| palette::hsv(t, 1.0),
        Map::Chirality | Map::Ellipticity => |t| sample(palette::BLUE_DARK_YELLOW, t),
        Map::Stokes | Map::StokesRelative => signed,
        Map::DopRed => |t| sample(palette::BLACK_RED, t),
        Map::Type => |t| sample(palette::YELLOW_CYAN, t),
        Map::Orientation => orientation,
    }
}

fn grey(t: f32) -> [u8; 3] {
    [(255.0 * t).round() as u8; 3]
}

fn signed(t: f32) -> [u8; 3] {
    sample(palette::BLUE_WHITE_RED, t)
}

/// Red at 0, blue at 45, green at 90 and yellow at 135 degrees.
fn orientation(turn: f32) -> [u8; 3] {
    sample(&[[235, 50, 40], [60, 90, 255], [40, 190, 70], [250, 220, 40], [235, 50, 40]], turn)
}

/// What 99 percent of all |S1|, |S2|, |S3| stay below; 1 if there are none.
pub fn signed_range(image: &StokesImage) -> f32 {
    let pixels = 0..image.width * image.height;
    range_of(pixels.flat_map(|pixel| stokes_at(image, pixel).into_iter().skip(1)))
}

/// What the sizes of 99 percent of the values that are not 0 stay below; 1 if there are none.
pub fn range_of(values: impl Iterator<Item = f32>) -> f32 {
    let mut sizes: Vec<f32> =
        values.map(f32::abs).filter(|size| size.is_finite() && *size > 0.0).collect();
    sizes.sort_by(f32::total_cmp);
    sizes.get(sizes.len() * 99 / 100).copied().unwrap_or(1.0)
}

/// S0 as a picture, with its legend of this title.
pub(super) fn intensity(image: &StokesImage, exposure_ev: f32, title: String) -> (Picture, Legend) {
    let legend = Legend { title, ..intensity_legend(exposure_ev) };
    (png::preview(image, exposure_ev), legend)
}

/// The legend of intensities at an exposure. The bar is even in sRGB code, so a linear value
/// stands at its encoded place.
pub(super) fn intensity_legend(exposure_ev: f32) -> Legend {
    let end = exp2(-exposure_ev);
    let tick = |share: f32| (intensity_place(share), number(share * end));
    Legend {
        title: INTENSITY.to_owned(),
        bar: Some(Box::new(grey)),
        ticks: INTENSITY_TICKS.map(tick).to_vec(),
        swatches: Vec::new(),
        disk: false,
    }
}

/// The shares of the largest intensity that its legend names.
pub(super) const INTENSITY_TICKS: [f32; 5] = [0.0, 0.05, 0.2, 0.5, 1.0];

/// Where a share of the largest intensity stands on the bar of its legend.
pub(super) fn intensity_place(share: f32) -> f32 {
    f32::from(palette::encode_srgb(share)) / 255.0
}

/// The legend of one of S1 to S3, whose colors end at plus and minus `range`.
pub(super) fn plane_legend(component: usize, relative: bool, range: f32) -> Legend {
    let quotient = if relative { "/S0" } else { "" };
    let meaning = ["", "0° (+)  90° (-)", "45° (+)  135° (-)", "right (+)  left (-)"];
    signed_legend(format!("S{component}{quotient}  {}", meaning[component]), range, "no light")
}

/// The legend of a signed value whose colors end at plus and minus `range`; black is `black`.
pub(super) fn signed_legend(title: String, range: f32, black: &'static str) -> Legend {
    Legend {
        title,
        bar: Some(Box::new(signed)),
        ticks: [-1.0, 0.0, 1.0].map(|t: f32| (0.5 + 0.5 * t, number(t * range))).to_vec(),
        swatches: vec![(NO_LIGHT, black)],
        disk: false,
    }
}

/// Three significant digits without trailing zeros.
fn number(value: f32) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size == 0.0 { 0.0 } else { (2.0 - log10(size).floor()).max(0.0) };
    let text = format!("{value:.*}", digits as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The legend of a map that has one scale.
pub(super) fn legend_of(map: Map, view: &View) -> Legend {
    let spread = |labels: &[&str]| {
        let last = (labels.len() - 1).max(1) as f32;
        labels.iter().enumerate().map(|(i, label)| (i as f32 / last, (*label).to_owned())).collect()
    };
    let end = view.degree_max;
    let degrees = || [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|t: f32| (t, number(t * end))).to_vec();
    let hands =
        [format!("{} left", number(-end)), "0".to_owned(), format!("right {}", number(end))];
    let share = ["0 circular", "0.5", "1 linear"];
    let angles = ["0°", "45°", "90°", "135°", "180°"];
    let bright = |what: &str, how: &str| match end < 1.0 {
        true => format!("{what}, bright = {how} {}", number(end)),
        false => format!("{what}, bright = {how}"),
    };
    let (title, ticks): (String, _) = match map {
        Map::LinearCircular => ("linear share of polarization".into(), spread(&share)),
        Map::Type => (bright("type", "polarized"), spread(&share)),
        Map::Aolp => ("angle of linear polarization".into(), spread(&angles)),
        Map::AolpDark => (bright("angle", "linear"), spread(&angles)),
        Map::Orientation => (bright("orientation", "linear"), spread(&angles)),
        Map::Chirality => {
            ("circular share S3/S0".into(), spread(&hands.each_ref().map(String::as_str)))
        }
        Map::Ellipticity => {
            ("ellipticity angle".into(), spread(&["-45° left", "0° linear", "right 45°"]))
        }
        Map::Dop | Map::DopRed | Map::Intensity | Map::Stokes | Map::StokesRelative => {
            ("degree of polarization".into(), degrees())
        }
    };
    let unpolarized = match map {
        Map::LinearCircular | Map::Ellipticity => Some((NEUTRAL, "unpolarized")),
        Map::Aolp => Some((NEUTRAL, "not linear")),
        Map::Intensity
        | Map::Dop
        | Map::AolpDark
        | Map::Chirality
        | Map::Stokes
        | Map::StokesRelative
        | Map::DopRed
        | Map::Type
        | Map::Orientation => None,
    };
    Legend {
        title,
        bar: Some(Box::new(scale_of(map))),
        ticks,
        swatches: std::iter::once((NO_LIGHT, "no light")).chain(unpolarized).collect(),
        disk: matches!(map, Map::Aolp | Map::AolpDark | Map::Orientation),
    }
}
