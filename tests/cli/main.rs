//! The program from outside: the binary is run, its files, words and exit codes are looked at.

mod batch;
mod batch_crash;
mod batch_mitsuba;
mod batch_more;
mod bench;
mod bench_more;
mod bench_record;
mod cache;
mod checkpoints;
mod cropped;
mod errors;
mod farm;
mod films;
mod images;
mod mitsuba;
mod program;
mod readme;
mod render;
mod report;
mod spectra;
mod tev;
mod work;
