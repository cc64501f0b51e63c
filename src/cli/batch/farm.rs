//! The verb `farm`: what has an engine run the tasks of a batch.

use std::path::{Path, PathBuf};

use crate::batch::farm::Plan;
use crate::batch::prepared::{Asked, Prepared, Work};
use crate::image::{atomic, folder_of};
use crate::render::threads::THREADS_MAX;

use super::super::CliError;
use super::super::files::{print, refuse_overwriting, say};
use super::super::job::within;
use super::args::FarmArguments;
use super::prepared;

/// Writes it, if nothing is wrong with the job file.
pub(in crate::cli) fn farm(arguments: &FarmArguments) -> Result<(), CliError> {
    let FarmArguments { engine, output, .. } = arguments;
    arguments.cpus.map_or(Ok(()), |cpus| within("--cpus", cpus, THREADS_MAX, ""))?;
    let path = &arguments.jobs;
    let prepared = prepared(Asked {
        jobs: path.clone(),
        results: arguments.results.clone(),
        allow_outside: arguments.allow_outside,
        work: Work::Merge(arguments.parts),
    })?;
    let orders = prepared.orders();
    let wanted = arguments.tasks.unwrap_or(prepared.farm().tasks);
    let advice = format!("; {} runs no more of one batch", engine.name);
    within("tasks", wanted, engine.tasks_max, &advice)?;
    let pieces = orders.len() as u64 * u64::from(prepared.parts());
    let tasks = u64::from(wanted).min(pieces) as u32;
    if tasks < wanted {
        say(format_args!("note: {tasks} tasks: there is no work for {wanted}"));
    }
    if let Some(output) = output {
        let scenes = orders.iter().map(|order| order.scene.as_path());
        let needed: Vec<&Path> = scenes.chain([path.as_path(), prepared.results()]).collect();
        refuse_overwriting(output, &needed)?;
    }
    let refuse = |text: String| CliError::Refused(format!("{}: {text}", path.display()));
    let plan = plan(arguments, &prepared, tasks).map_err(refuse)?;
    let text = (engine.write)(&plan).map_err(refuse)?;
    match output {
        Some(output) => Ok(atomic::write(output, text.as_bytes())?),
        None => print(text.trim_end()),
    }
}

fn plan(arguments: &FarmArguments, prepared: &Prepared, tasks: u32) -> Result<Plan, String> {
    let absolute = |path: &Path| {
        let found = path.canonicalize();
        found.map_err(|error| format!("cannot find {}: {error}", path.display()))
    };
    let program = match &arguments.program {
        Some(program) => program.clone(),
        None => std::env::current_exe().map_err(|error| format!("where is sunstone? {error}"))?,
    };
    let mut options = Vec::new();
    // Whatever the job file says by then: tasks and merge have to be of one mind.
    options.extend(["--parts".to_owned(), prepared.parts().to_string()]);
    if let Some(results) = &arguments.results {
        let name = results.file_name().unwrap_or_default();
        let results = absolute(&folder_of(results))?.join(name);
        options.extend(["--results".to_owned(), text_of(&results)?]);
    }
    if arguments.allow_outside {
        options.push("--allow-outside".to_owned());
    }
    let output = match &arguments.output {
        Some(output) => {
            let name = output.file_name().unwrap_or_default();
            Some(absolute(&folder_of(output))?.join(name))
        }
        None => None,
    };
    Ok(Plan {
        program: text_of(&program)?,
        folder: text_of(&absolute(prepared.folder())?)?,
        jobs: text_of(&PathBuf::from(arguments.jobs.file_name().unwrap_or_default()))?,
        tasks,
        cpus: arguments.cpus,
        options,
        output,
    })
}

/// A path as scripts have it.
fn text_of(path: &Path) -> Result<String, String> {
    let text = path.to_str().ok_or_else(|| format!("{} is not UTF-8", path.display()))?;
    if text.contains(char::is_control) {
        return Err(format!("{text:?} holds characters that no script is to hold"));
    }
    Ok(text.to_owned())
}
