//! Spectral renders: how many wavelengths light is carried at together, and from which range.

use super::Options;
use super::settings::{SettingsError, WAVELENGTHS_NM};
use crate::math::Fault;
use crate::math::text::excerpt;
use crate::spectrum::{Band, Bands, Color, Curves, RELATIVE_WIDTH_MIN, Responses};

/// Light at several wavelengths together, others in every iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectral {
    /// Wavelengths that are carried together: 4 or 8.
    pub wavelengths: u32,
    /// The first and the last that light may have, in nanometers in vacuum.
    pub range_nm: [f32; 2],
}

/// What numbers of wavelengths can be carried together.
pub const WAVELENGTHS: [u32; 2] = [4, 8];
/// The range where none is named, in nanometers.
pub const RANGE_NM: [f32; 2] = [380.0, 780.0];
/// Why ranges and bands have a least width.
const WHY: &str = "for wavelengths are numbers of single precision";
/// What else the range can come from, in words.
const BY_DEFAULT: &str = " (if it is not given, it is that of the bands or responses)";
/// What rounding may make of the ends of bands, in nanometers, and at most as a share of their
/// width: half of what single precision tells apart where they are narrowest.
const ROUNDING_NM: f64 = 1e-3;
const ROUNDING_SHARE: f64 = 5e-3;
/// Most characters of a name that an error shows.
const NAME: usize = 40;

impl Default for Spectral {
    /// Eight wavelengths of visible light.
    fn default() -> Self {
        Self { wavelengths: 8, range_nm: RANGE_NM }
    }
}

/// What light is carried at, by the number of columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Columns {
    /// Red, green and blue.
    Rgb,
    /// One wavelength in nanometers.
    Mono(f32),
    /// Four wavelengths.
    Four(Spectral),
    /// Eight wavelengths.
    Eight(Spectral),
}

impl Columns {
    /// How many there are.
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Mono(_) => 1,
            Self::Four(_) => 4,
            Self::Eight(_) => 8,
        }
    }
}

/// What light of a render is carried at.
///
/// # Errors
/// When its color and its wavelengths do not go together.
pub fn columns(options: &Options) -> Result<Columns, SettingsError> {
    let wrong = |setting, rule: String| Err(SettingsError { setting, rule });
    let Some(spectral) = options.spectral else {
        return match &options.color {
            Color::Rgb => Ok(Columns::Rgb),
            Color::Mono { wavelength_nm } => Ok(Columns::Mono(*wavelength_nm)),
            Color::Bands(_) => wrong("bands", "go with color spectral".to_owned()),
            Color::Responses(_) => wrong("responses", "go with color spectral".to_owned()),
        };
    };
    let Spectral { wavelengths, range_nm: [first, last] } = spectral;
    for nm in [first, last] {
        if !WAVELENGTHS_NM.contains(&nm) {
            let (least, most) = (WAVELENGTHS_NM.start(), WAVELENGTHS_NM.end());
            let rule = format!("must be within {least}:{most} nanometers, not {nm}{BY_DEFAULT}");
            return wrong("range", rule);
        }
    }
    if first >= last {
        let rule = format!(
            "must go from a shorter to a longer wavelength, not {first}:{last}{BY_DEFAULT}"
        );
        return wrong("range", rule);
    }
    check_film(&options.color, [first, last])?;
    match wavelengths {
        4 => Ok(Columns::Four(spectral)),
        8 => Ok(Columns::Eight(spectral)),
        other => {
            let [few, many] = WAVELENGTHS;
            wrong("wavelengths", format!("must be {few} or {many}, not {other}"))
        }
    }
}

/// Refuses films that do not measure spectra, or measure what is outside of the range.
fn check_film(color: &Color, range_nm: [f32; 2]) -> Result<(), SettingsError> {
    match color {
        Color::Rgb => check_width(range_nm),
        Color::Mono { .. } => {
            let rule = format!("spectral has no film of {color}: say which bands, as 400:700:31");
            Err(SettingsError { setting: "color", rule })
        }
        Color::Bands(bands) => check_bands(bands, range_nm),
        Color::Responses(curves) => {
            check_width(range_nm)?;
            check_responses(curves, range_nm)
        }
    }
}

/// Refuses a range of which wavelengths are a handful of numbers.
fn check_width([first, last]: [f32; 2]) -> Result<(), SettingsError> {
    let least = f64::from(first) * RELATIVE_WIDTH_MIN;
    // Ends are rounded as they are read.
    let rounding = f64::from(f32::EPSILON * last);
    if f64::from(last) - f64::from(first) >= least - rounding {
        return Ok(());
    }
    let least = least as f32;
    let rule = format!("must be at least {least} nm wide, {WHY}, not {first}:{last}{BY_DEFAULT}");
    Err(SettingsError { setting: "range", rule })
}

fn check_bands(bands: &Bands, range_nm: [f32; 2]) -> Result<(), SettingsError> {
    let is_narrow = |band: &&Band| band.width_nm < band.least_width_nm();
    if let Some(band) = bands.list().iter().find(is_narrow) {
        let Band { name, center_nm, width_nm } = band;
        let (name, least) = (excerpt(name, NAME), band.least_width_nm());
        let rule = format!(
            "must be at least {least} nm wide at {center_nm} nm, {WHY}, and {name} is \
             {width_nm} nm wide: make it wider"
        );
        return Err(SettingsError { setting: "bands", rule });
    }
    let [first, last] = range_nm.map(f64::from);
    let is_outside = |band: &&Band| {
        let rounding = ROUNDING_NM.min(ROUNDING_SHARE * f64::from(band.width_nm));
        let [low, high] = band.ends_nm();
        low < first - rounding || high > last + rounding
    };
    let Some(band) = bands.list().iter().find(is_outside) else { return Ok(()) };
    let [low, high] = band.ends_nm().map(|nm| nm as f32);
    let rule = format!(
        "must be within range {first}:{last}, and {} reaches from {low} to {high} nm",
        excerpt(&band.name, NAME)
    );
    Err(SettingsError { setting: "bands", rule })
}

fn check_responses(curves: &Curves, [first, last]: [f32; 2]) -> Result<(), SettingsError> {
    let Some((channel, ends)) = curves.dark_in([first, last]) else { return Ok(()) };
    let why = match ends {
        Some([from, to]) => format!("it responds from {from} to {to} nm; widen the range"),
        None => "it responds to nothing; leave it out".to_owned(),
    };
    let rule = format!("have no light for the channel {channel} in range {first}:{last}: {why}");
    Err(SettingsError { setting: "responses", rule })
}

/// What the film of a render measures: where it has responses, these as they are asked for.
///
/// # Errors
/// When they cannot be normalized, or there is nothing that could be.
pub fn measured(options: &Options) -> Result<Color, SettingsError> {
    let Options { color, spectral, white_balance, raw_response, .. } = options;
    let wrong = |setting, rule: &str| Err(SettingsError { setting, rule: rule.to_owned() });
    let balanced = white_balance.is_some();
    if *raw_response && !matches!(color, Color::Responses(_)) {
        return wrong("raw_response", "goes with responses");
    }
    let curves = match (color, spectral) {
        (Color::Responses(curves), Some(_)) => curves,
        (Color::Rgb, None) if balanced => {
            return wrong("white_balance", "goes with color spectral: in RGB there are no spectra");
        }
        (Color::Mono { .. }, _) if balanced => {
            return wrong("white_balance", "goes with colors, and one wavelength has none");
        }
        (Color::Bands(_), _) if balanced => {
            let rule = "goes with RGB of spectra and with responses: bands are means of radiance";
            return wrong("white_balance", rule);
        }
        (Color::Rgb | Color::Mono { .. } | Color::Bands(_) | Color::Responses(_), _) => {
            return Ok(color.clone());
        }
    };
    if *raw_response && balanced {
        return wrong("white_balance", "goes without raw_response, which is what the numbers are");
    }
    let range_nm = spectral.unwrap_or_default().range_nm;
    let setting = if balanced { "white_balance" } else { "responses" };
    let curves = match raw_response {
        true => curves.raw(),
        false => curves
            .normalized(range_nm, white_balance.as_ref())
            .map_err(|fault| of_fault(setting, fault))?,
    };
    Ok(Color::Responses(curves.into()))
}

/// How the channels of a spectral render respond to its wavelengths; none if it is not one.
///
/// # Errors
/// When a film of RGB cannot be balanced.
pub fn responses(options: &Options) -> Result<Option<Responses>, SettingsError> {
    let Some(Spectral { range_nm, .. }) = options.spectral else { return Ok(None) };
    Responses::of(&options.color, range_nm, options.white_balance.as_ref())
        .map_err(|fault| of_fault("white_balance", fault))
}

/// What is wrong with a setting.
fn of_fault(setting: &'static str, Fault { field: _, problem, remedy }: Fault) -> SettingsError {
    SettingsError { setting, rule: format!("{problem}; {remedy}") }
}

/// What is measured at which wavelengths, in words.
pub fn in_words(spectral: Spectral) -> String {
    let Spectral { wavelengths, range_nm: [first, last] } = spectral;
    format!("{wavelengths} wavelengths from {first} to {last} nm, others in every iteration")
}

/// What white is to a film that measures spectra as colors, in words; none if it is no such film.
pub fn balance_in_words(options: &Options) -> Option<String> {
    let given = options.white_balance.as_ref().map(|white| white.name().to_owned());
    match (&options.color, options.spectral) {
        (Color::Responses(_), _) if options.raw_response => {
            Some("none: responses as they are given".to_owned())
        }
        (Color::Responses(_), _) => {
            Some(format!("1 for {}", given.as_deref().unwrap_or("a flat spectrum")))
        }
        (Color::Rgb, Some(_)) => given,
        (Color::Rgb | Color::Mono { .. } | Color::Bands(_), _) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::render::Settings;
    use crate::spectrum::Bands;

    fn options(bands: [f32; 2], count: usize, spectral: Option<Spectral>) -> Options {
        let bands = Bands::evenly(bands[0], bands[1], count).unwrap();
        Options { color: Color::Bands(Arc::new(bands)), spectral, ..Options::default() }
    }

    #[test]
    fn settings_that_do_not_go_together_are_refused() {
        let spectral = |wavelengths, range_nm| Some(Spectral { wavelengths, range_nm });
        let refused = |options| Settings::new(options).unwrap_err().to_string();
        let visible = options([400.0, 700.0], 31, Some(Spectral::default()));
        assert!(Settings::new(visible.clone()).is_ok());
        assert!(refused(options([400.0, 700.0], 31, None)).contains("color spectral"));
        for (wavelengths, range_nm, words) in [
            (3, RANGE_NM, "wavelengths must be 4 or 8, not 3"),
            (8, [780.0, 380.0], "not 780:380"),
            (8, [500.0, 500.0], "not 500:500"),
            (8, [f32::NAN, 500.0], "not NaN"),
            (4, [400.0, 700.0], "within range 400:700, and 400 nm reaches from 395 to"),
            (4, [0.0, 700.0], "not 0"),
        ] {
            let error = refused(options([400.0, 700.0], 31, spectral(wavelengths, range_nm)));
            assert!(error.contains(words), "{error}");
        }
        // No more may be missing of a narrow band than rounding leaves out.
        let one = Bands::new(vec![Band::new(550.0, 0.02)]).unwrap();
        let one = Options { color: Color::Bands(Arc::new(one)), ..visible.clone() };
        let spectral = |range_nm| Some(Spectral { wavelengths: 8, range_nm });
        for (range_nm, is_sound) in
            [([549.99, 550.01], true), ([549.9905, 550.01], false), ([549.99, 550.0095], false)]
        {
            let options = Options { spectral: spectral(range_nm), ..one.clone() };
            assert_eq!(Settings::new(options).is_ok(), is_sound, "{range_nm:?}");
        }
        let mono = Color::Mono { wavelength_nm: 550.0 };
        let error = refused(Options { color: mono, ..visible.clone() });
        assert!(error.contains("say which bands"), "{error}");
        assert!(Settings::new(Options { color: Color::Rgb, ..visible }).is_ok());
    }

    /// The limit is that of lines, and those of other programs are images all the same.
    #[test]
    fn what_single_precision_does_not_resolve_is_refused() {
        let of = |center_nm, width_nm| {
            let sound = Band::new(400.0, 10.0);
            let band = Band { name: "sodium".to_owned(), center_nm, width_nm };
            let list = if center_nm > 400.0 { vec![sound, band] } else { vec![band, sound] };
            let bands = Bands::new(list).unwrap();
            let [first, last] = bands.ends_nm().map(|nm| nm as f32);
            let spectral = Some(Spectral { wavelengths: 8, range_nm: [first, last] });
            let color = Color::Bands(Arc::new(bands));
            Settings::new(Options { color, spectral, ..Options::default() })
        };
        for (center_nm, least_nm) in [(250.0, 0.005), (589.0, 0.011_78), (2000.0, 0.04)] {
            assert!(of(center_nm, least_nm).is_ok(), "{center_nm}");
            for width_nm in [least_nm * 0.999, 1e-3, 1e-20] {
                let error = of(center_nm, width_nm).unwrap_err().to_string();
                let least = format!("bands must be at least {least_nm} nm wide at {center_nm}");
                assert!(error.contains(&least) && error.contains("sodium is "), "{error}");
            }
        }
        let of = |range_nm| Some(Spectral { wavelengths: 8, range_nm });
        assert_eq!(check_width([550.0, 550.011]), Ok(()));
        assert_eq!(check_width([550.0, 551.0]), Ok(()));
        let spectral = of([550.0, 550.001]);
        for color in [Color::Rgb, Color::Responses(Arc::new(Curves::named("xyz").unwrap()))] {
            let error = Settings::new(Options { color, spectral, ..Options::default() });
            let error = error.unwrap_err().to_string();
            assert!(error.contains("range must be at least 0.011 nm wide"), "{error}");
        }
    }
}
