//! Where a render is among its samples: which replicate, which block of it. All of it follows from
//! the settings and the number of samples that are done.

use std::fmt::{self, Display};
use std::ops::Range;
use std::str::FromStr;

use super::settings::{AUTO, Options, Settings, SettingsError};
use crate::integrators::Integrator;

/// One of several parts of an image that are rendered apart, by their samples, and then merged to
/// the same bits as if they had been rendered together ([`crate::merge`]).
///
/// ```
/// use sunstone::Part;
/// let part: Part = "3/7".parse()?;
/// assert_eq!((part.number(), part.of()), (3, 7));
/// assert!("8/7".parse::<Part>().is_err());
/// # Ok::<(), sunstone::SettingsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    number: u32,
    of: u32,
}

impl Part {
    /// Part `number`, from 1 on, of so many.
    ///
    /// # Errors
    /// When there is no such part.
    pub fn new(number: u32, of: u32) -> Result<Self, SettingsError> {
        match (1..=of).contains(&number) {
            true => Ok(Self { number, of }),
            false => {
                let rule = format!("must be from 1/N to N/N, not {number}/{of}");
                Err(SettingsError { setting: "part", rule })
            }
        }
    }

    /// Which one, from 1 on.
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many there are.
    pub fn of(self) -> u32 {
        self.of
    }
}

impl Display for Part {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Part {
    type Err = SettingsError;

    fn from_str(text: &str) -> Result<Self, SettingsError> {
        let numbers = text.split_once('/').map(|(number, of)| (number.parse(), of.parse()));
        match numbers {
            Some((Ok(number), Ok(of))) => Self::new(number, of),
            _ => {
                let rule = format!("must be K/N, as in 3/7, not {text}");
                Err(SettingsError { setting: "part", rule })
            }
        }
    }
}

/// Checks that an image has such a part, by whatever integrator a scene decides on.
///
/// # Errors
/// When there are not so many, or the time is limited.
pub fn check_part(settings: &Settings, part: Part) -> Result<(), SettingsError> {
    let settings = Settings::new(Options { part: Some(part), ..settings.options() })?;
    let may_be = |it: &&Integrator| settings.integrator.is_none_or(|chosen| chosen == **it);
    for &integrator in Integrator::ALL.iter().filter(may_be) {
        let unit = settings.samples_per_iteration(integrator);
        let groups = Groups::new(&settings, settings.samples_by(integrator), unit);
        groups.samples_of(part).map_err(|mut error| {
            if settings.integrator.is_none() {
                let name = integrator.name();
                error.rule += &format!(" (by {name}, which {AUTO} may choose: choose yourself)");
            }
            error
        })?;
    }
    Ok(())
}

/// What decides how samples are grouped.
#[derive(Clone, Copy, Debug)]
pub struct Groups {
    /// Samples per pixel in all.
    pub samples: u32,
    /// Samples that come together: those of an iteration of photons, or one.
    pub unit: u32,
    /// Independent randomizations, one after the other.
    pub replicates: u32,
    /// Whether the spread of blocks is to tell the variances.
    pub blocks: bool,
    /// Whether nobody knows how many samples will be done.
    pub is_limited: bool,
}

impl Groups {
    /// Those of settings, by `samples` in all that come in units.
    pub fn new(settings: &Settings, samples: u32, unit: u32) -> Self {
        let replicates = settings.replicates;
        let blocks = settings.variance && replicates == 1;
        Self { samples, unit, replicates, blocks, is_limited: settings.time_limit.is_some() }
    }

    /// The samples of a part, from the first to that after the last.
    ///
    /// # Errors
    /// When there are not so many parts: each has a unit, or a block if there are variances.
    pub fn samples_of(&self, part: Part) -> Result<Range<u32>, SettingsError> {
        let ends = self.ends_of_blocks();
        let (count, what) = match &ends {
            None => (self.samples / self.unit, "iterations"),
            Some(ends) => (ends.len() as u32, "blocks that its variances come from"),
        };
        if part.of > count {
            let rule = format!(
                "{part}: an image of {} samples a pixel has {count} {what}, and no more parts",
                self.samples
            );
            return Err(SettingsError { setting: "part", rule });
        }
        let end_of = |number: u32| {
            let groups = (u64::from(count) * u64::from(number) / u64::from(part.of)) as u32;
            match (&ends, groups.checked_sub(1)) {
                (_, None) => 0,
                (None, Some(_)) => groups * self.unit,
                (Some(ends), Some(last)) => ends[last as usize],
            }
        };
        Ok(end_of(part.number - 1)..end_of(part.number))
    }

    /// Samples until every block or replicate ends, if sums depend on that.
    fn ends_of_blocks(&self) -> Option<Vec<u32>> {
        if self.replicates == 1 && !self.blocks {
            return None;
        }
        let mut place = Place::start(self);
        let mut ends = Vec::new();
        while place.done < self.samples {
            place.advance(place.left_of_block.min(self.samples - place.done));
            ends.push(place.done);
            place.begin_block(self);
        }
        Some(ends)
    }

    /// Samples of a block that begins after so many samples, or of a whole replicate. One replicate
    /// alone goes on for as long as it is asked to.
    ///
    /// Blocks are of powers of two, of which low-discrepancy sequences are made, and are about a
    /// sixteenth of all. They begin small, as nobody knows how far a render will come.
    fn block(&self, replicate: u32, done: u32) -> u32 {
        const BLOCKS: u32 = 16;
        const LEAST: u32 = 4;
        if self.replicates > 1 {
            let [end, start] = [replicate + 1, replicate].map(|replicates| self.share(replicates));
            return end - start;
        }
        if !self.blocks {
            return u32::MAX;
        }
        let power_of_two = |value: u32| 1 << value.max(1).ilog2();
        let planned: u32 = power_of_two(self.samples / self.unit / BLOCKS);
        let least = if self.is_limited { 1 } else { LEAST };
        planned.min(power_of_two(done / self.unit * 2 / BLOCKS).max(least)) * self.unit
    }

    /// Samples per pixel of the first `replicates` replicates: whole units.
    fn share(&self, replicates: u32) -> u32 {
        let units = u64::from(self.samples / self.unit) * u64::from(replicates);
        (units / u64::from(self.replicates)) as u32 * self.unit
    }
}

/// A place among the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Samples per pixel before it, of the whole image.
    pub done: u32,
    /// The replicate it is in.
    pub replicate: u32,
    /// Samples per pixel of that before it.
    pub of_replicate: u32,
    /// Samples per pixel since a replicate or block has ended.
    pub of_block: u32,
    /// Samples per pixel until one ends.
    pub left_of_block: u32,
}

impl Place {
    /// Before the first sample.
    pub fn start(groups: &Groups) -> Self {
        let left_of_block = groups.block(0, 0);
        Self { done: 0, replicate: 0, of_replicate: 0, of_block: 0, left_of_block }
    }

    /// After `samples` samples, for what begins with the one at `first`. Those of a block that has
    /// just ended are still in hand, unless it ended there.
    pub fn after(groups: &Groups, first: u32, samples: u32) -> Self {
        let mut place = Self::start(groups);
        place.go_to(groups, first);
        place.begin_block(groups);
        place.of_block = 0;
        place.go_to(groups, samples);
        place
    }

    fn go_to(&mut self, groups: &Groups, samples: u32) {
        while self.done < samples {
            self.begin_block(groups);
            self.advance(self.left_of_block.min(samples - self.done));
        }
    }

    /// Goes on by so many samples, at most those that are left of the block.
    pub fn advance(&mut self, samples: u32) {
        self.done += samples;
        self.of_replicate += samples;
        self.of_block += samples;
        self.left_of_block -= samples;
    }

    /// Whether a replicate or block has ended here, and another is to come.
    pub fn is_end_of_block(&self, groups: &Groups) -> bool {
        self.left_of_block == 0 && !(groups.replicates > 1 && self.is_in_last(groups))
    }

    /// Goes on to the next replicate or block where one has ended.
    pub fn begin_block(&mut self, groups: &Groups) {
        if !self.is_end_of_block(groups) {
            return;
        }
        self.of_block = 0;
        if !self.is_in_last(groups) {
            self.replicate += 1;
            self.of_replicate = 0;
        }
        self.left_of_block = groups.block(self.replicate, self.done);
    }

    fn is_in_last(&self, groups: &Groups) -> bool {
        self.replicate + 1 == groups.replicates
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups(samples: u32, unit: u32, replicates: u32, blocks: bool) -> Groups {
        Groups { samples, unit, replicates, blocks, is_limited: false }
    }

    /// Whatever the groups and the number of parts, these are all samples, each once, and begin
    /// where blocks do.
    #[test]
    fn parts_are_the_whole() {
        let all = [
            groups(64, 1, 1, false),
            groups(64, 4, 1, false),
            groups(1000, 1, 1, true),
            groups(12, 4, 1, true),
            groups(63, 1, 5, false),
            groups(7, 1, 7, true),
        ];
        for groups in all {
            let count = (1..).take_while(|&of| groups.samples_of(Part { number: 1, of }).is_ok());
            let count = count.last().unwrap();
            for of in 1..=count {
                let part = |number| groups.samples_of(Part { number, of }).unwrap();
                let mut end = 0;
                for number in 1..=of {
                    let samples = part(number);
                    assert_eq!(samples.start, end, "{groups:?} {number}/{of}");
                    assert!(samples.end > end, "{groups:?} {number}/{of}");
                    end = samples.end;
                    let mut place = Place::after(&groups, 0, samples.start);
                    place.begin_block(&groups);
                    let has_blocks = groups.replicates > 1 || groups.blocks;
                    assert!(!has_blocks || place.of_block == 0, "{groups:?} {number}/{of}");
                }
                assert_eq!(end, groups.samples);
            }
            let error = groups.samples_of(Part { number: 1, of: count + 1 }).unwrap_err();
            assert!(error.to_string().starts_with(&format!("part 1/{}: an image of", count + 1)));
        }
    }

    /// A place that is walked to in any steps is the one that is computed.
    #[test]
    fn places_follow_from_the_samples() {
        for groups in [groups(100, 1, 3, false), groups(100, 1, 1, true), groups(96, 4, 1, true)] {
            let mut place = Place::start(&groups);
            while place.done < groups.samples {
                place.begin_block(&groups);
                place.advance(place.left_of_block.min(3).min(groups.samples - place.done));
                assert_eq!(place, Place::after(&groups, 0, place.done));
            }
        }
    }
}
