//! Floor 11: many renders from one description: a job file is read and unfolded into jobs, which
//! are rendered side by side and leave an account of themselves.
//!
//! | module | holds |
//! |---|---|
//! | [`file`] | `jobs.toml` or `.jsonl`: what is asked for |
//! | [`sweep`], [`values`], [`pattern`] | axes, their values, and names made of them |
//! | [`unique`] | JSON in which nothing is stated twice |
//! | [`order`] | a job that has been checked |
//! | [`check`], [`reals`] | what the job file alone shows to be wrong, and where its files are |
//! | [`prepared`] | from the file to what is left to do, and its results noted |
//! | [`report`] | a page of what has been done |
//! | [`share`] | what one task of many does |
//! | [`results`], [`known`] | `results.jsonl`, and those of tasks: what has been done |
//! | [`scenes`] | scenes, loaded once and shared |
//! | [`gate`] | how much is in work at once |
//! | [`run`] | jobs side by side |
//! | [`crash`] | what becomes of them when the program fails |
//! | [`merging`], [`leftovers`] | images of the parts that tasks have rendered, and their files |
//! | [`farm`] | scripts and templates for engines that run tasks |

pub mod check;
pub mod crash;
pub mod farm;
pub mod file;
mod gate;
pub mod known;
mod leftovers;
pub mod merging;
pub mod order;
mod pattern;
pub mod prepared;
mod reals;
pub mod report;
pub mod results;
pub mod run;
mod scenes;
pub mod share;
mod sweep;
mod unique;
pub mod values;
