//! The library's texts in the words of Python: options of the command line as keyword arguments.

use sunstone::internals::cli::color::ColorName;
use sunstone::internals::render::settings::AUTO;
use sunstone::{FilterKind, FilterSamples, Integrator, LightChoice, Mode, Sampling, White};

/// Options that Python has too, with what is said of those that take no value there.
const OPTIONS: [(&str, &str); 36] = [
    ("allow-outside", "=True"),
    ("alpha", ""),
    ("bands", ""),
    ("camera", ""),
    ("color", ""),
    ("crop", ""),
    ("filter", ""),
    ("filter-radius", ""),
    ("filter-samples", ""),
    ("height", ""),
    ("hold-spectra", "=True"),
    ("integrator", ""),
    ("iterations", ""),
    ("light", ""),
    ("max-path-length", ""),
    ("mode", ""),
    ("photons", ""),
    ("pixel-aspect", ""),
    ("radius", ""),
    ("range", ""),
    ("raw-response", "=True"),
    ("replicates", ""),
    ("responses", ""),
    ("results", ""),
    ("rgb-white", ""),
    ("roulette-after", ""),
    ("sampling", ""),
    ("samples-per-iteration", ""),
    ("spp", ""),
    ("threads", ""),
    ("time", ""),
    ("variance", "=True"),
    ("wavelength", ""),
    ("wavelengths", ""),
    ("white-balance", ""),
    ("width", ""),
];

/// The same text, with `--integrator ppm` as `integrator="ppm"`.
pub fn in_python(text: &str) -> String {
    let mut told = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, tail) = rest.split_at(at);
        told.push_str(before);
        let begins =
            told.chars().next_back().is_none_or(|c| c.is_whitespace() || "(`'\"".contains(c));
        let end = |text: &str| text.find(|c: char| !c.is_ascii_lowercase() && c != '-');
        let name = &tail[2..];
        let name = &name[..end(name).unwrap_or(name.len())];
        let known = OPTIONS.iter().find(|(known, _)| begins && *known == name);
        let Some((_, flag)) = known else {
            told.push_str("--");
            rest = &tail[2..];
            continue;
        };
        rest = &tail[2 + name.len()..];
        told.push_str(&name.replace('-', "_"));
        told.push_str(flag);
        let value =
            rest.strip_prefix(' ').map_or("", |rest| &rest[..end(rest).unwrap_or(rest.len())]);
        if values(name).any(|known| known == value) {
            told.push_str(&format!("=\"{value}\""));
            rest = &rest[1 + value.len()..];
        }
    }
    told.push_str(rest);
    told.replace(" -D:", " define:").replace(" -D ", " define ")
}

/// The words that an option may take.
fn values(name: &str) -> Box<dyn Iterator<Item = &'static str>> {
    match name {
        "integrator" => Box::new(
            std::iter::once(AUTO).chain(Integrator::ALL.iter().copied().map(Integrator::name)),
        ),
        "mode" => Box::new(Mode::ALL.into_iter().map(Mode::name)),
        "filter" => Box::new(FilterKind::ALL.into_iter().map(FilterKind::name)),
        "filter-samples" => Box::new(FilterSamples::ALL.into_iter().map(FilterSamples::name)),
        "sampling" => Box::new(Sampling::ALL.into_iter().map(Sampling::name)),
        "rgb-white" => Box::new(White::ALL.into_iter().map(White::name)),
        "light" => {
            Box::new([LightChoice::Auto, LightChoice::None].into_iter().map(LightChoice::name))
        }
        "camera" => Box::new(std::iter::once(AUTO)),
        "color" => Box::new(ColorName::ALL.into_iter().map(ColorName::name)),
        _ => Box::new(std::iter::empty()),
    }
}
