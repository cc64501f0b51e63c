//! Slurm: a script that hands itself in twice, as an array of tasks and as the merge after them.

use super::{Engine, Plan};

/// Slurm's arrays.
pub const ENGINE: Engine = Engine {
    name: "slurm",
    summary: "A script for bash that hands in an array of tasks and a merge that waits for them",
    // What Slurm allows unless it is configured otherwise.
    tasks_max: 1000,
    write,
};

fn write(plan: &Plan) -> Result<String, String> {
    let words = |words: &[String]| {
        let quoted = words.iter().map(|word| quoted(word)).collect::<Result<Vec<_>, _>>();
        quoted.map(|words| words.join(" "))
    };
    // A name that begins with - is no option.
    let arguments = words(&plan.arguments(&format!("./{}", plan.jobs)))?;
    let cpus = plan.cpus.map_or(String::new(), |cpus| format!(" --cpus-per-task={cpus}"));
    let share = plan.task("$SLURM_ARRAY_TASK_ID").join(" ");
    let Plan { tasks, .. } = plan;
    let name = plan.name();
    Ok(format!(
        r##"#!/usr/bin/env bash
# Renders a batch of Sunstone in an array of tasks, 1 to {tasks}, and merges what they make.
# Written by `sunstone farm slurm`. Start it with bash, with any options of sbatch behind it:
#
#     bash THIS_FILE --partition=long --time=4:00:00 --mem=16G
#
# Started again, it does what is left.
set -euo pipefail
sunstone={program}
folder={folder}
arguments=({arguments})
# Slurm tells how many processors a task has.
threads=${{SLURM_CPUS_PER_TASK:-${{SLURM_CPUS_ON_NODE:-1}}}}

case ${{1:-}} in
render)
    cd -- "$folder"
    exec "$sunstone" "${{arguments[@]}}" {share} --threads "$threads"
    ;;
merge)
    cd -- "$folder"
    exec "$sunstone" "${{arguments[@]}}" --merge --threads "$threads"
    ;;
esac

script=$(realpath -- "$0")
cd -- "$folder"
mkdir -p -- {name}.slurm
# A task whose machine is lost begins again elsewhere, and does what it has not done.
options=(--job-name={name} --requeue --open-mode=append{cpus} "$@")
render=$(sbatch --parsable "${{options[@]}}" --array=1-{tasks} \
    --output={name}.slurm/%A_%a.log "$script" render)
render=${{render%%;*}}
merge=$(sbatch --parsable "${{options[@]}}" --dependency=afterok:"$render" \
    --kill-on-invalid-dep=yes --output={name}.slurm/%j_merge.log "$script" merge)
echo "{name}: {tasks} tasks are job $render, the merge after them is job ${{merge%%;*}};" \
    "logs are in $folder/{name}.slurm"
"##,
        program = quoted(&plan.program)?,
        folder = quoted(&plan.folder)?,
    ))
}

/// A word as the shell takes it.
fn quoted(word: &str) -> Result<String, String> {
    let quoted = shlex::try_quote(word).map_err(|_| format!("{word:?} holds a zero byte"))?;
    Ok(quoted.into_owned())
}
