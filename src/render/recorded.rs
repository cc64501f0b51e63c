//! Renders in files: what one goes on from, and parts of an image that become one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::film::Developed;
use crate::film::layout::Layout;
use crate::film::record::{self, Fact, Record};
use crate::film::{Film, Gauge, Variances, recorded_values};
use crate::image::rows::Rows;
use crate::image::{OutputError, StokesImage};
use crate::polarization::Analyzer;
use crate::spectrum::{Color, RGB_WAVELENGTHS_NM};

use super::facts::{
    BALANCE, COLOR, analyzer_of, analyzer_text, both_in_words, color_of, color_text, in_words,
};
use super::renderer::metadata;
use super::resolved::components;
use super::run::Steps;
use super::{Mode, PlacedWorld, Resolved, spectral};

/// The program that renders: its sources, their compiler and target.
pub const BUILD: &str = concat!(env!("CARGO_PKG_VERSION"), " ", env!("SUNSTONE_BUILD"));

/// What the names of facts begin with that have to be the same in all parts of an image.
const OF_IMAGE: &str = "image: ";
/// What those of its metadata begin with.
const METADATA: &str = "metadata: ";
/// Facts of the place among the samples: of the first, the next, and that after the last.
const FIRST: &str = "first sample";
const NEXT: &str = "next sample";
const END: &str = "end sample";
/// The part, as K/N; 1/1 for the whole image.
const PART: &str = "part";
/// Facts of the image that are read again.
const WIDTH: &str = "image: width";
const HEIGHT: &str = "image: height";
const MODE: &str = "image: mode";
const ANALYZER: &str = "image: analyzer";
const SAMPLES: &str = "image: samples a pixel";
const VARIANCE: &str = "image: variance";
/// Which wavelengths light is carried at, where these change.
const SPECTRAL: &str = "image: spectral";
const IS_ASKED_FOR: &str = "image: variance is asked for";

/// What is wrong with a file that a render is to go on from, or with parts of an image.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// A file cannot be read or written, or is damaged.
    #[error(transparent)]
    File(#[from] OutputError),
    /// A file is of another render than the one that is to go on from it.
    #[error(
        "{} is of another render: its {what} is {there}, and here it is {here}; render with what \
         it was made with, or remove it to begin anew", path.display()
    )]
    Other {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: String,
        /// What the file says.
        there: String,
        /// What the render says.
        here: String,
    },
    /// Two parts are not of one image.
    #[error(
        "{} and {} are not parts of one image: the {what} of one is {one}, of the other {two}",
        first.display(), second.display()
    )]
    Foreign {
        /// A part.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// What differs.
        what: String,
        /// What the first says.
        one: String,
        /// What the second says.
        two: String,
    },
    /// A part has not been rendered to its end.
    #[error(
        "{} has {done} of the {samples} samples of its part: render it to its end", path.display()
    )]
    Unfinished {
        /// The file.
        path: PathBuf,
        /// Samples per pixel that it has.
        done: u32,
        /// Those of the part.
        samples: u32,
    },
    /// Two parts have the same samples.
    #[error(
        "{} and {} have the same samples (parts {one} and {two}): give one of them",
        first.display(), second.display()
    )]
    Overlap {
        /// A part.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Which part the first is.
        one: String,
        /// Which the second is.
        two: String,
    },
    /// Some samples are in no part.
    #[error("{missing}, and without that there is no image")]
    Missing {
        /// Which are missing, in words.
        missing: String,
    },
    /// A render was stopped as it shot its first photons.
    #[error(
        "nothing goes on from an iteration that has some of its photons: there is no checkpoint"
    )]
    FewPhotons,
    /// No parts at all.
    #[error("there are no parts to merge")]
    Nothing,
}

/// Where a render comes from: what tells it from others.
pub struct Origin {
    world: Option<PlacedWorld>,
    film: Layout,
    /// The digest of the world, as soon as somebody asks for it.
    digest: OnceLock<String>,
}

impl Origin {
    /// That of a world, on a film.
    pub fn of(world: PlacedWorld, film: Layout) -> Self {
        Self { world: Some(world), film, digest: OnceLock::new() }
    }

    /// That of tables which nobody knows the world of.
    pub fn unknown(film: Layout) -> Self {
        Self { world: None, film, digest: OnceLock::new() }
    }

    fn digest(&self) -> &str {
        let of_world = |world: &PlacedWorld| world.world().digest();
        self.digest.get_or_init(|| self.world.as_ref().map_or("unknown".to_owned(), of_world))
    }

    /// What is the same in all parts of an image, and before and after a pause.
    fn facts(&self, settings: &Resolved) -> Vec<Fact> {
        let spectral = settings.spectral.map(|it| (SPECTRAL, spectral::in_words(it)));
        let held = settings.hold_spectra.then(|| ("image: spectra", "held".to_owned()));
        let photons = settings.passes.map(|passes| {
            let radius = settings.photons.radius.map_or("found".to_owned(), |it| it.to_string());
            [
                ("image: photons an iteration", passes.light_paths.to_string()),
                ("image: samples an iteration", passes.samples.to_string()),
                ("image: alpha", settings.photons.alpha.to_string()),
                ("image: radius", radius),
            ]
        });
        let [sensor, light] = settings.roulette_of_sides();
        let facts = [
            (WIDTH, self.film.cut.size[0].to_string()),
            (HEIGHT, self.film.cut.size[1].to_string()),
            ("image: part of the film", self.film.cut.to_string()),
            ("image: filter", self.film.filter.to_string()),
            ("image: samples of filters", self.film.samples().name().to_owned()),
            ("image: pixel aspect", self.film.pixel_aspect.to_string()),
            (MODE, settings.mode.name().to_owned()),
            (ANALYZER, analyzer_text(settings.analyzer)),
            (COLOR, color_text(&settings.color)),
            ("image: rgb white", settings.white().name().to_owned()),
            (BALANCE, balance_text(settings).unwrap_or("none".to_owned())),
            (SAMPLES, settings.samples.to_string()),
            (VARIANCE, variances(settings).to_owned()),
            (IS_ASKED_FOR, settings.variance.to_string()),
            ("image: replicates", settings.replicates.to_string()),
            ("image: integrator", settings.integrator.name().to_owned()),
            ("image: max path length", settings.path_length_max.to_string()),
            ("image: roulette after", format!("{sensor} and {light}")),
            ("image: sampling", settings.sampling.name().to_owned()),
            ("image: seed", settings.seed.to_string()),
        ];
        let last = [
            ("image: scene (digest)", self.digest().to_owned()),
            ("image: build", BUILD.to_owned()),
        ];
        let all =
            facts.into_iter().chain(spectral).chain(held).chain(photons.into_iter().flatten());
        let all = all.chain(last);
        all.map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

/// What the variances of an image come from, in the words of its facts.
fn variances(settings: &Resolved) -> &'static str {
    match (settings.replicates, settings.variance) {
        (2.., _) => "replicates",
        (_, true) => "blocks",
        (_, false) => "none",
    }
}

/// Writes what a render has done so far to a file.
///
/// # Errors
/// See [`super::Renderer::save`].
pub fn save(
    path: &Path,
    origin: &Origin,
    settings: &Resolved,
    steps: &dyn Steps,
) -> Result<(), PartError> {
    let (of_film, columns) = steps.state().ok_or(PartError::FewPhotons)?;
    let part = settings.part.map_or("1/1".to_owned(), |part| part.to_string());
    let place = [
        (PART, part),
        (FIRST, settings.first_sample.to_string()),
        (NEXT, steps.done().to_string()),
        (END, settings.end_sample.to_string()),
    ];
    let of_image = metadata(settings, settings.samples);
    let of_image = of_image.into_iter().map(|(name, value)| (format!("{METADATA}{name}"), value));
    let mut facts = origin.facts(settings);
    facts.extend(place.map(|(name, value)| (name.to_owned(), value)));
    facts.extend(of_film);
    facts.extend(of_image);
    Ok(record::write(path, facts, &columns)?)
}

/// Goes on from a file.
///
/// # Errors
/// See [`super::Renderer::resume`].
pub fn resume(
    path: &Path,
    origin: &Origin,
    settings: &Resolved,
    steps: &mut dyn Steps,
) -> Result<(), PartError> {
    let mut record = Record::open(path)?;
    let part = settings.part.map_or("1/1".to_owned(), |part| part.to_string());
    let mut here = origin.facts(settings);
    here.push((PART.to_owned(), part));
    for (name, here) in here {
        let there = record.fact(&name).ok_or_else(|| record.lacks(&name))?;
        if there != here {
            let path = path.to_owned();
            let [there, here] = both_in_words(&name, [there, &here]);
            return Err(PartError::Other { path, what: plain(&name), there, here });
        }
    }
    let next = record.number(NEXT)?;
    if !(settings.first_sample..=settings.end_sample).contains(&next) {
        return Err(record.is_wrong(format!("sample {next} is none of its part")).into());
    }
    Ok(steps.restore(&mut record, next)?)
}

/// What a fact is called in words.
fn plain(name: &str) -> String {
    name.trim_start_matches(OF_IMAGE).to_owned()
}

/// The image of all of its parts, in any order, as [`super::Renderer::save`] has written them when
/// they were done: bit for bit that of a render of the whole.
///
/// # Errors
/// When a file cannot be read or is damaged, or parts are missing, given twice, not done, or not of
/// one image: with their names.
pub fn merge(paths: &[PathBuf]) -> Result<StokesImage, PartError> {
    merge_as_asked_for(paths).map(|(image, _)| image.whole().into_owned())
}

/// The same image, of which no plane is in memory, and whether variances were asked for, which come
/// with replicates anyway.
pub fn merge_as_asked_for(paths: &[PathBuf]) -> Result<(Developed<'static>, bool), PartError> {
    let mut parts: Vec<Record> =
        paths.iter().map(|path| Record::open(path)).collect::<Result<_, _>>()?;
    let mut ranges: Vec<[u32; 2]> = Vec::new();
    for part in &parts {
        check_alike(&parts[0], part)?;
        ranges.push(samples_of(part)?);
    }
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&index| ranges[index]);
    let first = parts.first().ok_or(PartError::Nothing)?;
    check_whole(&parts, &ranges, &order, first.number(SAMPLES)?)?;
    let (mut film, analyzer, mode) = film_of(first)?;
    let metadata = metadata_of(first);
    let with_variance = first.fact(IS_ASKED_FOR) == Some("true");
    for &index in &order {
        film.take(&mut parts[index])?;
    }
    let mut image = film.into_developed().behind(analyzer, mode.components());
    image.metadata = metadata;
    Ok((image, with_variance))
}

/// Refuses parts of different images.
fn check_alike(first: &Record, other: &Record) -> Result<(), PartError> {
    for (name, one) in first.facts().iter().filter(|(name, _)| name.starts_with(OF_IMAGE)) {
        let two = other.fact(name).ok_or_else(|| other.lacks(name))?;
        if one != two {
            let [one, two] = both_in_words(name, [one, two]);
            return Err(PartError::Foreign {
                first: first.path().to_owned(),
                second: other.path().to_owned(),
                what: plain(name),
                one,
                two,
            });
        }
    }
    Ok(())
}

/// The samples of a part that is done.
fn samples_of(part: &Record) -> Result<[u32; 2], PartError> {
    let [first, next, end] = [FIRST, NEXT, END].map(|name| part.number(name));
    let [first, next, end] = [first?, next?, end?];
    if next == end && first < end {
        return Ok([first, end]);
    }
    let (done, samples) = (next.saturating_sub(first), end.saturating_sub(first));
    Err(PartError::Unfinished { path: part.path().to_owned(), done, samples })
}

/// Refuses parts that have a sample twice, or that lack one.
fn check_whole(
    parts: &[Record],
    ranges: &[[u32; 2]],
    order: &[usize],
    samples: u32,
) -> Result<(), PartError> {
    let mut next = 0;
    let mut gaps = Vec::new();
    for (place, &index) in order.iter().enumerate() {
        let [first, end] = ranges[index];
        if first < next {
            let [before, part] = [&parts[order[place - 1]], &parts[index]];
            let named = |part: &Record| part.fact(PART).unwrap_or("?").to_owned();
            return Err(PartError::Overlap {
                first: before.path().to_owned(),
                second: part.path().to_owned(),
                one: named(before),
                two: named(part),
            });
        }
        if first > next {
            gaps.push([next, first]);
        }
        next = end;
    }
    if next < samples {
        gaps.push([next, samples]);
    }
    match gaps.is_empty() {
        true => Ok(()),
        false => Err(PartError::Missing { missing: missing(parts, &gaps) }),
    }
}

/// What is missing: by the numbers of the parts if all are of as many, else by the samples.
fn missing(parts: &[Record], gaps: &[[u32; 2]]) -> String {
    let numbers: Option<Vec<(u32, u32)>> = (parts.iter())
        .map(|part| {
            let (number, of) = part.fact(PART)?.split_once('/')?;
            Some((number.parse().ok()?, of.parse().ok()?))
        })
        .collect();
    if let Some(numbers) = numbers
        && numbers.iter().all(|(_, of)| *of == numbers[0].1)
    {
        let (there, of): (BTreeSet<u32>, u32) =
            (numbers.iter().map(|(number, _)| *number).collect(), numbers[0].1);
        let missing = (1..=of).filter(|number| !there.contains(number));
        let list: Vec<String> = missing.map(|number| format!("{number}/{of}")).collect();
        return match list.len() {
            1 => format!("part {} is missing", list[0]),
            _ => format!("parts {} are missing", list.join(", ")),
        };
    }
    let list = gaps.iter().map(|[first, end]| format!("{first} to {}", end - 1));
    format!("samples {} are in none of the parts", list.collect::<Vec<_>>().join(" and "))
}

/// Whether a file begins as those that [`super::Renderer::save`] writes, whatever it is called.
pub fn is_part(path: &Path) -> bool {
    Record::is_one(path)
}

/// In words: what is in a file that [`super::Renderer::save`] has written.
///
/// # Errors
/// When it cannot be read or is damaged.
pub fn describe(path: &Path) -> Result<String, PartError> {
    let record = Record::open(path)?;
    let known = |(name, value): &Fact| {
        let is_place = [PART, FIRST, NEXT, END].contains(&name.as_str());
        if !is_place && !name.starts_with(OF_IMAGE) {
            return None;
        }
        Some(format!("  {}: {}\n", plain(name), in_words(name, value)))
    };
    let lines: String = record.facts().iter().filter_map(known).collect();
    Ok(format!("{}: a part of an image, or a render to go on from\n{lines}", path.display()))
}

/// A black film like that of a part, what stands before it, and the mode of its light.
fn film_of(part: &Record) -> Result<(Film, Option<Analyzer>, Mode), PartError> {
    let known = |name: &str| part.fact(name).ok_or_else(|| part.lacks(name));
    let mode = known(MODE)?;
    let mode = Mode::ALL.into_iter().find(|it| it.name() == mode);
    let mode = mode.ok_or_else(|| part.lacks(MODE))?;
    let color = color_of(known(COLOR)?).ok_or_else(|| part.lacks(COLOR))?;
    let variances = match known(VARIANCE)? {
        "replicates" => Variances::Replicates,
        "blocks" => Variances::Blocks,
        "none" => Variances::None,
        _ => return Err(part.lacks(VARIANCE).into()),
    };
    let analyzer = analyzer_of(known(ANALYZER)?).ok_or_else(|| part.lacks(ANALYZER))?;
    let size = [part.number(WIDTH)?, part.number(HEIGHT)?];
    let components = components(mode, analyzer);
    let gauge = if part.fact(SPECTRAL).is_some() { Gauge::Kept } else { Gauge::None };
    check_size(part, size, components * color.channels(), gauge)?;
    let film = Film::new(size, color, components, (variances, gauge), false);
    Ok((film, analyzer, mode))
}

/// Refuses a part whose head claims another film than its columns hold, before there is any.
fn check_size(
    part: &Record,
    size: [u32; 2],
    values_per_pixel: usize,
    gauge: Gauge,
) -> Result<(), OutputError> {
    let held = recorded_values(part)?;
    let [width, height] = size;
    let pixels = u64::from(width) * u64::from(height);
    let pixels = if pixels > 0 { pixels.checked_add(gauge.pixels() as u64) } else { None };
    let claimed = pixels.and_then(|pixels| pixels.checked_mul(values_per_pixel as u64));
    if claimed == Some(held) && held > 0 {
        return Ok(());
    }
    Err(part.is_wrong(format!(
        "its head claims {width} x {height} pixels of {values_per_pixel} values, and its columns \
         hold {held} values: render it again"
    )))
}

/// What tells the white balance of a film of RGB from others: its name, and how the channels
/// respond at three wavelengths, from which all else follows. None if it has none; that of
/// responses is in these.
fn balance_text(settings: &Resolved) -> Option<String> {
    let white = settings.white_balance.as_ref().filter(|_| settings.color == Color::Rgb)?;
    let responses = settings.responses()?;
    let at = |nm: f32| responses.list().iter().map(move |it| it.at(nm.into()));
    let values: Vec<f64> = RGB_WAVELENGTHS_NM.into_iter().flat_map(at).collect();
    Some(format!("{white} {values:?}"))
}

/// The metadata of the image that a part is of.
fn metadata_of(part: &Record) -> Vec<Fact> {
    let of_image = part.facts().iter();
    let of_image = of_image
        .filter_map(|(name, value)| Some((name.strip_prefix(METADATA)?.to_owned(), value.clone())));
    of_image.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::record::Column;

    /// A part of an image of one sample, with 2 x 1 pixels in its columns, whatever its head says.
    fn part(name: &str, width: u32, height: u32, mode: &str) -> PathBuf {
        let path =
            std::env::temp_dir().join(format!("sunstone-{}-{name}.part", std::process::id()));
        let numbers = [(WIDTH, width), (HEIGHT, height), (SAMPLES, 1), (FIRST, 0), (NEXT, 1)];
        let more = [(END, 1), ("finished blocks", 1), ("finished iterations", 1)];
        let words = [(MODE, mode), (COLOR, "550"), (VARIANCE, "none"), (ANALYZER, "none")];
        let numbers = numbers.into_iter().chain(more).map(|(name, it)| (name, it.to_string()));
        let words = words.into_iter().map(|(name, it)| (name, it.to_owned()));
        let facts = numbers.chain(words).map(|(name, it)| (name.to_owned(), it)).collect();
        let column = |name: &str, values| (name.to_owned(), Column::Doubles(values));
        let columns = [column("sums", &[1.0, 2.0]), column("sums (rest)", &[0.0; 2])];
        record::write(&path, facts, &columns).unwrap();
        path
    }

    /// No memory is asked for: of the largest of these no machine has so much.
    #[test]
    fn parts_whose_heads_claim_another_size_are_refused() {
        let most = u32::MAX;
        let claims = [(most, most, "scalar"), (most, 1, "scalar"), (2, 1, "polarized")];
        for (width, height, mode) in claims.into_iter().chain([(0, 0, "scalar"), (1, 1, "scalar")])
        {
            let path = part("claims", width, height, mode);
            let error = merge(std::slice::from_ref(&path)).unwrap_err().to_string();
            let claim = format!("its head claims {width} x {height} pixels of ");
            assert!(error.contains(&claim), "{error}");
            assert!(error.contains(&path.display().to_string()), "{error}");
            std::fs::remove_file(path).unwrap();
        }
        let path = part("honest", 2, 1, "scalar");
        assert_eq!(merge(std::slice::from_ref(&path)).unwrap().planes, [[1.0, 2.0]]);
        std::fs::remove_file(path).unwrap();
    }
}
