//! Open Job Description: a template of a job with two steps, one of which waits for the other. Its
//! paths and names are parameters, with what is known here as their defaults, so that an engine can
//! move them, and nothing in them is taken for a reference.

use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use super::{Engine, Plan};

/// Templates of the version of September 2023.
pub const ENGINE: Engine = Engine {
    name: "openjd",
    summary: "An Open Job Description template (jobtemplate-2023-09), as `openjd run` and AWS \
              Deadline Cloud take it",
    tasks_max: 1_000_000,
    write,
};

/// Most characters of a word in a template, and of a default.
const CHARACTERS_MAX: usize = 1024;

/// A template, in the order in which it is read.
#[derive(Serialize)]
struct Template {
    #[serde(rename = "specificationVersion")]
    version: &'static str,
    name: String,
    #[serde(rename = "parameterDefinitions")]
    parameters: Value,
    steps: [Value; 2],
}

fn write(plan: &Plan) -> Result<String, String> {
    if let Some(option) = plan.options.iter().find(|option| option.contains("{{")) {
        return Err(format!("`{option}` holds {{{{, which means something else in a template"));
    }
    let arguments = plan.arguments("{{Param.Folder}}/{{Param.JobFile}}");
    let action = |own: &[String]| {
        let threads = plan.cpus.map(|cpus| ["--threads".to_owned(), cpus.to_string()]);
        let own = own.iter().cloned().chain(threads.into_iter().flatten());
        let arguments: Vec<String> = arguments.iter().cloned().chain(own).collect();
        json!({"actions": {"onRun": {"command": "{{Param.Sunstone}}", "args": arguments}}})
    };
    let share = plan.task("{{Task.Param.Task}}");
    let range = if plan.tasks == 1 { "1".to_owned() } else { format!("1-{}", plan.tasks) };
    let task = json!({"name": "Task", "type": "INT", "range": range});
    let mut steps = [
        json!({
            "name": "render",
            "parameterSpace": {"taskParameterDefinitions": [task]},
            "script": action(&share),
        }),
        json!({
            "name": "merge",
            "dependencies": [{"dependsOn": "render"}],
            "script": action(&["--merge".to_owned()]),
        }),
    ];
    if let Some(cpus) = plan.cpus {
        for step in &mut steps {
            step["hostRequirements"] =
                json!({"amounts": [{"name": "amount.worker.vcpu", "min": cpus}]});
        }
    }
    let template = Template {
        version: "jobtemplate-2023-09",
        name: plan.name(),
        parameters: parameters(plan)?,
        steps,
    };
    let text = serde_json::to_string_pretty(&template).map_err(|error| error.to_string())?;
    Ok(text + "\n")
}

/// What may be given other values when the job is handed in.
fn parameters(plan: &Plan) -> Result<Value, String> {
    let folder = folder_from(plan)?;
    for (what, text) in [("folder", &folder), ("program", &plan.program), ("job file", &plan.jobs)]
    {
        if text.chars().count() > CHARACTERS_MAX {
            return Err(format!(
                "the path of the {what} has more than {CHARACTERS_MAX} characters"
            ));
        }
    }
    Ok(json!([
        {
            "name": "Folder",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "INOUT",
            "default": folder,
            "description": "The folder of the job file, its scenes and its outputs, which all \
                            machines share.",
        },
        {
            "name": "JobFile",
            "type": "STRING",
            "default": plan.jobs,
            "description": "The name of the job file in that folder.",
        },
        {
            "name": "Sunstone",
            "type": "STRING",
            "default": plan.program,
            "description": "The program on the machines, of one build on all of them.",
        },
    ]))
}

/// The folder of the job file from that of the template, which must not lie elsewhere.
fn folder_from(plan: &Plan) -> Result<String, String> {
    let folder = Path::new(&plan.folder);
    let Some(template) = plan.output.as_deref().and_then(Path::parent) else {
        return Ok(".".to_owned());
    };
    let inner = folder.strip_prefix(template).map_err(|_| {
        format!(
            "a template finds files from its own folder on: write it into {}, or one above that",
            plan.folder
        )
    })?;
    let parts: Vec<_> = inner.iter().filter_map(|part| part.to_str()).collect();
    Ok(if parts.is_empty() { ".".to_owned() } else { parts.join("/") })
}
