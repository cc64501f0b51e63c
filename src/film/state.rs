//! A film to and from the columns of a [`Record`].

use super::record::{Column, Fact, Record};
use super::{Film, Finished};

use crate::image::OutputError;
use crate::math::exact::ExactSums;

/// The columns of the current sums, which are all there is without variances.
const SUMS: [&str; 2] = ["sums", "sums (rest)"];
/// Those of the mean of the finished blocks, and of their deviations from it.
const MEAN: &str = "mean";
const DEVIATIONS: &str = "deviations";
/// Facts: the finished blocks and their iterations.
const BLOCKS: &str = "finished blocks";
const ITERATIONS: &str = "finished iterations";

/// The column of a block that is kept as it is, and the fact of its iterations.
fn block_name(index: usize) -> String {
    format!("block {index}")
}

/// The values, over all pixels, of the film that has been recorded.
///
/// # Errors
/// When the record lacks them.
pub fn recorded_values(record: &Record) -> Result<u64, OutputError> {
    record.length(SUMS[0])
}

impl Film {
    /// Facts and columns from which [`Film::restore`] makes the same film.
    pub fn state(&self) -> (Vec<Fact>, Vec<(String, Column<'_>)>) {
        let mut facts = vec![
            (BLOCKS.to_owned(), self.blocks.to_string()),
            (ITERATIONS.to_owned(), self.iterations.to_string()),
        ];
        let sums = self.sums.columns().map(Column::Doubles);
        let mut columns: Vec<(String, Column)> =
            SUMS.map(String::from).into_iter().zip(sums).collect();
        match &self.finished {
            Finished::Sums => {}
            Finished::Means { mean, deviations, halves } => {
                columns.push((MEAN.to_owned(), Column::Doubles(mean)));
                columns.push((DEVIATIONS.to_owned(), Column::Doubles(deviations)));
                if let Some(halves) = halves {
                    let (more_facts, more_columns) = halves.state();
                    facts.extend(more_facts);
                    columns.extend(more_columns);
                }
            }
            Finished::Blocks(blocks) => {
                for (index, block) in blocks.iter().enumerate() {
                    facts.push((block_name(index), block.iterations.to_string()));
                    columns.push((block_name(index), Column::Doubles(&block.sums)));
                }
            }
        }
        (facts, columns)
    }

    /// Becomes the film whose [`Film::state`] has been recorded, which was made alike.
    ///
    /// # Errors
    /// When the record lacks something, or the system refuses.
    pub fn restore(&mut self, record: &mut Record) -> Result<(), OutputError> {
        let values = self.sums.len();
        self.blocks = record.number(BLOCKS)?;
        self.iterations = u64::from(record.number(ITERATIONS)?);
        self.sums = recorded_sums(record, values)?;
        match &mut self.finished {
            Finished::Sums => {}
            Finished::Means { mean, deviations, halves } => {
                *mean = record.doubles(MEAN, values)?;
                *deviations = record.doubles(DEVIATIONS, values)?;
                if let Some(halves) = halves {
                    halves.restore(record, values)?;
                }
            }
            Finished::Blocks(blocks) => {
                *blocks = recorded_blocks(record, self.blocks, values)?;
            }
        }
        Ok(())
    }

    /// Adds what a film has recorded that goes on from where this one ends; with variances, both
    /// end with a block.
    ///
    /// # Errors
    /// When the record lacks something, or the system refuses.
    pub fn take(&mut self, record: &mut Record) -> Result<(), OutputError> {
        let values = self.sums.len();
        match &self.finished {
            Finished::Sums => {
                let sums = recorded_sums(record, values)?;
                self.sums.add_sums(0, &sums, 0, values);
                self.blocks = self.blocks.saturating_add(record.number(BLOCKS)?);
                self.iterations += u64::from(record.number(ITERATIONS)?);
                Ok(())
            }
            Finished::Means { .. } if record.has(MEAN) => self.restore(record),
            Finished::Means { .. } | Finished::Blocks(_) => {
                for index in 0..record.number(BLOCKS)? as usize {
                    let name = block_name(index);
                    let sums = record.doubles(&name, values)?;
                    self.take_block(&sums, record.number(&name)?);
                }
                Ok(())
            }
        }
    }
}

fn recorded_sums(record: &mut Record, values: usize) -> Result<ExactSums, OutputError> {
    let [high, low] = SUMS.map(|name| record.doubles(name, values));
    Ok(ExactSums::of_columns(high?, low?))
}

fn recorded_blocks(
    record: &mut Record,
    blocks: u32,
    values: usize,
) -> Result<Vec<super::Block>, OutputError> {
    let block = |index| {
        let name = block_name(index);
        let iterations = record.number(&name)?;
        Ok(super::Block { iterations, sums: record.doubles(&name, values)? })
    };
    (0..blocks as usize).map(block).collect()
}
