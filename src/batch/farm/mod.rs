//! What has an engine run the tasks of a batch, and merge what they leave when all are done.
//!
//! Another engine is a file here and a line in [`ENGINES`].

mod openjd;
mod slurm;

use std::path::PathBuf;

/// What runs tasks.
#[derive(Clone, Debug)]
pub struct Engine {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What is written for it, as help.
    pub summary: &'static str,
    /// Most tasks of one job of it.
    pub tasks_max: u32,
    /// Writes that, or says in words why it cannot.
    pub write: fn(&Plan) -> Result<String, String>,
}

/// All engines.
pub static ENGINES: [Engine; 2] = [slurm::ENGINE, openjd::ENGINE];

/// A batch in tasks. Nothing in it is of an engine.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The program on the machines.
    pub program: String,
    /// The folder of the job file: absolute, without links.
    pub folder: String,
    /// The name of the job file in it.
    pub jobs: String,
    /// How many tasks; at least one.
    pub tasks: u32,
    /// Processors for each, if that is said.
    pub cpus: Option<usize>,
    /// Options of `batch` that are the same for all.
    pub options: Vec<String>,
    /// Where what is written goes: absolute, without links; nothing if that is not known.
    pub output: Option<PathBuf>,
}

impl Plan {
    /// What the batch is called: the name of the job file in letters, digits, `-` and `_`.
    fn name(&self) -> String {
        const CHARACTERS_MAX: usize = 60;
        let stem = self.jobs.rsplit_once('.').map_or(&*self.jobs, |(stem, _)| stem);
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let name: String = stem.chars().take(CHARACTERS_MAX).map(plain).collect();
        if name.is_empty() { "batch".to_owned() } else { name }
    }

    /// The arguments of the program in all tasks, and in the merge; `jobs` are the engine's words
    /// for the job file.
    fn arguments(&self, jobs: &str) -> Vec<String> {
        let own = ["batch", jobs].map(str::to_owned);
        own.into_iter().chain(self.options.iter().cloned()).collect()
    }

    /// What makes one task of that, of which the engine says the number.
    fn task(&self, number: &str) -> [String; 2] {
        ["--task".to_owned(), format!("{number}/{}", self.tasks)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain() {
        let plan = |jobs: &str| Plan {
            program: String::new(),
            folder: String::new(),
            jobs: jobs.to_owned(),
            tasks: 1,
            cpus: None,
            options: Vec::new(),
            output: None,
        };
        for (jobs, name) in
            [("a b.toml", "a_b"), ("x-1.2.jsonl", "x-1_2"), ("Ä.toml", "_"), (".toml", "batch")]
        {
            assert_eq!(plan(jobs).name(), name);
        }
        assert!(plan(&format!("{}.toml", "x".repeat(250))).name().len() == 60);
    }
}
