//! Shares of a batch: every task does one, and knows which without asking the others.
//!
//! The pieces, images or parts of them, stand in the order of the jobs, so that those in a row have
//! scenes in common, and are cut into shares that take as many samples.

use std::fmt::{self, Display};
use std::str::FromStr;

use super::order::Order;
use crate::render::{Part, SettingsError};

/// Share `number` of a batch, from 1 on, of so many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: u32,
    of: u32,
}

impl Display for Share {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').map(|(number, of)| (number.parse(), of.parse()));
        match numbers {
            Some((Ok(number), Ok(of))) if (1..=of).contains(&number) => Ok(Self { number, of }),
            Some((Ok(_), Ok(_))) => Err(format!("must be from 1/N to N/N, not {text}")),
            _ => Err(format!("must be K/N, as in 3/20, not {text}")),
        }
    }
}

impl Share {
    /// How many shares there are.
    pub fn of(self) -> u32 {
        self.of
    }

    /// The name of a file that no other share of the jobs has.
    pub fn file_name(self, jobs: &str) -> String {
        format!("{jobs}.{}-of-{}.jsonl", self.number, self.of)
    }

    /// Whether a file is one of those of the jobs, whatever share.
    pub fn is_file_name(name: &str, jobs: &str) -> bool {
        let numbers = name
            .strip_prefix(jobs)
            .and_then(|rest| rest.strip_prefix('.')?.strip_suffix(".jsonl")?.split_once("-of-"));
        numbers.is_some_and(|(number, of)| format!("{number}/{of}").parse::<Self>().is_ok())
    }

    /// Its pieces of the jobs, each of which is an image, or so many parts of one.
    ///
    /// # Errors
    /// When the settings of a job allow of no parts.
    pub fn pieces(self, orders: &[Order], parts: u32) -> Result<Vec<Order>, SettingsError> {
        // In units in which a piece takes what its whole image takes in samples.
        let count = u128::from(parts);
        let total: u128 =
            orders.iter().map(|order| u128::from(order.cost_of_image()) * count).sum();
        let mut pieces = Vec::new();
        let mut before = 0;
        for order in orders {
            let cost = u128::from(order.cost_of_image());
            // The share in which the middle of a piece lies.
            let share_of = |index: u32| {
                let twice = 2 * (before + cost * u128::from(index)) + cost;
                (twice * u128::from(self.of) / (2 * total)) as u32 + 1
            };
            if (share_of(0)..=share_of(parts - 1)).contains(&self.number) {
                let own = (0..parts).filter(|index| share_of(*index) == self.number);
                for index in own {
                    pieces.push(piece_of(order, index, parts)?);
                }
            }
            before += cost * count;
        }
        Ok(pieces)
    }
}

/// All pieces of a job.
///
/// # Errors
/// When its settings allow of no parts.
pub fn pieces_of(order: &Order, parts: u32) -> Result<Vec<Order>, SettingsError> {
    (0..parts).map(|index| piece_of(order, index, parts)).collect()
}

/// One piece of a job, by its place among all from 0.
///
/// # Errors
/// When its settings allow of no parts.
pub fn piece_of(order: &Order, index: u32, parts: u32) -> Result<Order, SettingsError> {
    match parts {
        1 => Ok(order.clone()),
        _ => order.part(Part::new(index + 1, parts)?),
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::batch::values::Values;
    use crate::render::{Options, Settings};
    use crate::scene::View;

    fn order(index: usize, samples: u32) -> Order {
        let options = Options { samples, width: Some(4), height: Some(4), ..Options::default() };
        Order {
            index,
            name: String::new(),
            values: Values::default(),
            scene: PathBuf::new(),
            scene_name: PathBuf::new(),
            view: View::default(),
            edits: Vec::new(),
            asked: None,
            settings: Settings::new(options).unwrap(),
            output: format!("here/{index}.exr").into(),
            output_name: format!("{index}.exr"),
        }
    }

    fn names(share: &str, orders: &[Order], parts: u32) -> Vec<String> {
        let pieces = share.parse::<Share>().unwrap().pieces(orders, parts).unwrap();
        pieces.into_iter().map(|piece| piece.output_name).collect()
    }

    #[test]
    fn shares_are_all_pieces_each_once() {
        let samples = [1, 64, 1, 1, 1000, 7, 8, 8, 8, 300];
        let orders: Vec<_> = (0..).zip(samples).map(|(index, it)| order(index, it)).collect();
        for parts in [1, 3, 8] {
            let all: Vec<String> = orders
                .iter()
                .flat_map(|it| pieces_of(it, parts).unwrap())
                .map(|it| it.output_name)
                .collect();
            for tasks in [1, 2, 5, 10, 80, 1000] {
                let shares =
                    (1..=tasks).map(|number| names(&format!("{number}/{tasks}"), &orders, parts));
                assert_eq!(shares.flatten().collect::<Vec<_>>(), all, "{parts} in {tasks}");
            }
        }
    }

    #[test]
    fn shares_take_as_long() {
        let equal: Vec<_> = (0..10).map(|index| order(index, 16)).collect();
        for number in 1..=10 {
            assert_eq!(names(&format!("{number}/10"), &equal, 1), [format!("{}.exr", number - 1)]);
        }
        assert_eq!(names("2/4", &equal[..2], 2), ["0.exr.2-of-2.part"]);
        let rising: Vec<_> = (0..100).map(|index| order(index, 4 * index as u32 + 4)).collect();
        let costs = (1..=10).map(|number| {
            let pieces =
                format!("{number}/10").parse::<Share>().unwrap().pieces(&rising, 4).unwrap();
            pieces.iter().map(Order::cost).sum::<u64>()
        });
        let (least, most) = costs.fold((u64::MAX, 0), |(a, b), it| (a.min(it), b.max(it)));
        // They differ by less than a piece at either end.
        assert!(most - least < 2 * 16 * 400 / 4, "{least} to {most}");
    }

    #[test]
    fn files_of_shares_are_known_by_their_names() {
        let share: Share = "3/20".parse().unwrap();
        assert_eq!(
            (share.to_string(), share.file_name("a.toml")),
            ("3/20".to_owned(), "a.toml.3-of-20.jsonl".to_owned())
        );
        assert!(Share::is_file_name(&share.file_name("a.toml"), "a.toml"));
        for other in [
            "a.toml.21-of-20.jsonl",
            "a.toml.x-of-2.jsonl",
            "b.a.toml.3-of-20.jsonl",
            "a.toml.jsonl",
        ] {
            assert!(!Share::is_file_name(other, "a.toml"), "{other}");
        }
        for (wrong, words) in
            [("0/3", "from 1/N"), ("4/3", "from 1/N"), ("3", "K/N"), ("a/b", "K/N")]
        {
            assert!(wrong.parse::<Share>().unwrap_err().contains(words), "{wrong}");
        }
    }
}
