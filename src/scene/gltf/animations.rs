//! Animations: where nodes are, and how far meshes are morphed, at a moment.
//!
//! All animations are played together, but for those that move what another before them in the file
//! moves: of a walk and a run the first.

use std::collections::BTreeSet;

use glam::{DQuat, DVec4};
use serde_json::Value;

use super::accessors;
use super::document::Document;
use crate::math::text::listed;
use crate::scene::error::SceneError;
use crate::scene::warnings::Warnings;

const AGAIN: &str = "export the scene again";
/// Most names that a warning tells.
const NAMES: usize = 5;

/// What of a node a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Path {
    const ALL: [(Self, &str); 4] = [
        (Self::Translation, "translation"),
        (Self::Rotation, "rotation"),
        (Self::Scale, "scale"),
        (Self::Weights, "weights"),
    ];

    fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// How values follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// A channel of an animation that is played.
struct Channel {
    /// What errors call it.
    label: String,
    node: usize,
    path: Path,
    interpolation: Interpolation,
    /// Accessors of the times and the values.
    input: usize,
    output: usize,
}

/// Whether a file has animations.
pub fn has_any(document: &Document) -> bool {
    document.value["animations"].as_array().is_some_and(|all| !all.is_empty())
}

/// The nodes of a file at a time in seconds, in its JSON: places and weights are stated there as
/// the animations have them.
///
/// # Errors
/// When there are no animations, or one of them is broken.
pub fn moved(document: &Document, time: f64, warnings: &mut Warnings) -> Result<Value, SceneError> {
    if !has_any(document) {
        let remedy = "leave out --time";
        return Err(SceneError::new("animations", "the file has none", remedy));
    }
    let mut value = document.value.clone();
    for channel in channels(document, warnings)? {
        let node = &mut value["nodes"][channel.node];
        if node["matrix"].is_array() && channel.path != Path::Weights {
            let label = document.label("nodes", channel.node);
            let problem = "has a matrix, and an animation moves it";
            return Err(SceneError::new(
                label,
                problem,
                "state its place by translation, rotation",
            ));
        }
        let state = channel.at(document, time)?;
        if state.iter().any(|number| !number.is_finite()) {
            let problem = "is not finite at that time";
            return Err(SceneError::new(channel.label, problem, AGAIN));
        }
        node[channel.path.name()] = state.into();
    }
    Ok(value)
}

/// The channels that are played.
fn channels(document: &Document, warnings: &mut Warnings) -> Result<Vec<Channel>, SceneError> {
    let mut moved: BTreeSet<(usize, Path)> = BTreeSet::new();
    let (mut played, mut silent) = (Vec::new(), Vec::new());
    for (index, animation) in
        document.value["animations"].as_array().into_iter().flatten().enumerate()
    {
        let label = document.label("animations", index);
        let of_it = channels_of(document, animation, &label, warnings)?;
        let moves: BTreeSet<(usize, Path)> = of_it.iter().map(|it| (it.node, it.path)).collect();
        if moves.iter().any(|it| moved.contains(it)) {
            silent.push(label);
            continue;
        }
        moved.extend(moves);
        played.extend(of_it);
    }
    if !silent.is_empty() {
        let more = silent.len().saturating_sub(NAMES);
        silent.truncate(NAMES);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let text =
            format!("not played, as others before them move the same: {}{more}", listed(silent));
        warnings.add_like("silent animations", "animations", &text);
    }
    Ok(played)
}

fn channels_of(
    document: &Document,
    animation: &Value,
    label: &str,
    warnings: &mut Warnings,
) -> Result<Vec<Channel>, SceneError> {
    let mut channels = Vec::new();
    for (index, channel) in animation["channels"].as_array().into_iter().flatten().enumerate() {
        let label = format!("{label}, channel {index}");
        let target = &channel["target"];
        let path = target["path"].as_str().unwrap_or_default();
        let Some((path, _)) = Path::ALL.into_iter().find(|(_, name)| *name == path) else {
            let text = "moves what is no place and no weight of a morph target, and is not played";
            warnings.add(&label, text);
            continue;
        };
        // A channel without a node is for extensions.
        if target["node"].is_null() {
            continue;
        }
        let nodes = document.root.nodes.len();
        let node = index_of(&target["node"], nodes, || format!("{label}, target.node"))?;
        let samplers = animation["samplers"].as_array().map_or(0, Vec::len);
        let sampler = index_of(&channel["sampler"], samplers, || format!("{label}, sampler"))?;
        let sampler = &animation["samplers"][sampler];
        let accessors = document.root.accessors.len();
        let accessor = |key: &str| index_of(&sampler[key], accessors, || format!("{label}, {key}"));
        let interpolation = match sampler["interpolation"].as_str() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(_) => {
                let remedy = "use LINEAR, STEP or CUBICSPLINE";
                let field = format!("{label}, interpolation");
                return Err(SceneError::new(field, "is not known", remedy));
            }
        };
        let (input, output) = (accessor("input")?, accessor("output")?);
        channels.push(Channel { label, node, path, interpolation, input, output });
    }
    Ok(channels)
}

/// An index below `len`.
pub fn index_of(
    value: &Value,
    len: usize,
    field: impl Fn() -> String,
) -> Result<usize, SceneError> {
    match value.as_u64().and_then(|index| usize::try_from(index).ok()) {
        Some(index) if index < len => Ok(index),
        _ => Err(SceneError::new(field(), format!("must be an index below {len}"), AGAIN)),
    }
}

impl Channel {
    /// What the node has at a time.
    fn at(&self, document: &Document, time: f64) -> Result<Vec<f64>, SceneError> {
        let times = accessors::scalars(document, self.input, &format!("{}, input", self.label))?;
        let place = format!("{}, output", self.label);
        let values: Vec<f32> = match self.path {
            Path::Translation | Path::Scale => {
                accessors::vectors(document, self.output, &place)?.into_iter().flatten().collect()
            }
            Path::Rotation => {
                accessors::fours(document, self.output, &place)?.into_iter().flatten().collect()
            }
            Path::Weights => accessors::scalars(document, self.output, &place)?,
        };
        let keys = times.len();
        let of_key = match self.interpolation {
            Interpolation::Step | Interpolation::Linear => 1,
            Interpolation::CubicSpline => 3,
        };
        let fits = keys > 0 && values.len().is_multiple_of(keys * of_key) && !values.is_empty();
        let size = if fits { values.len() / (keys * of_key) } else { 0 };
        let wanted = match self.path {
            Path::Translation | Path::Scale => Some(3),
            Path::Rotation => Some(4),
            Path::Weights => None,
        };
        if !fits || wanted.is_some_and(|wanted| wanted != size) {
            let problem = format!("{} numbers do not go with {keys} times", values.len());
            return Err(SceneError::new(place, problem, AGAIN));
        }
        if !times.is_sorted_by(|a, b| a < b) || !times.iter().all(|time| time.is_finite()) {
            let problem = "times must be finite, each later than the one before";
            return Err(SceneError::new(format!("{}, input", self.label), problem, AGAIN));
        }
        let row = |index: usize| {
            values[index * size..][..size].iter().map(|it| f64::from(*it)).collect::<Vec<f64>>()
        };
        Ok(self.between(&times, time, row))
    }

    /// The value between two keys; `row` has those of a sampler by their number.
    fn between(&self, times: &[f32], time: f64, row: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
        let last = times.len() - 1;
        let after = times.partition_point(|key| f64::from(*key) <= time);
        let (key, next) = (after.saturating_sub(1), after.min(last));
        let [start, end] = [key, next].map(|key| f64::from(times[key]));
        let share = if next > key { ((time - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        let mixed = |a: &[f64], b: &[f64], t: f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect()
        };
        let state = match self.interpolation {
            Interpolation::Step => row(key),
            Interpolation::Linear if self.path == Path::Rotation => {
                let [a, b] = [key, next].map(|key| quaternion(&row(key)));
                a.slerp(b, share).to_array().to_vec()
            }
            Interpolation::Linear => mixed(&row(key), &row(next), share),
            Interpolation::CubicSpline => {
                // Of each key: the tangent before it, itself, the tangent behind it.
                let [value, leaves] = [row(3 * key + 1), row(3 * key + 2)];
                let [enters, goal] = [row(3 * next), row(3 * next + 1)];
                hermite([&value, &leaves, &enters, &goal], share, end - start)
            }
        };
        match self.path {
            Path::Rotation => quaternion(&state).to_array().to_vec(),
            Path::Translation | Path::Scale | Path::Weights => state,
        }
    }
}

/// A rotation of length 1.
fn quaternion(numbers: &[f64]) -> DQuat {
    let of = DVec4::from_slice(numbers);
    DQuat::from_vec4(of.try_normalize().unwrap_or(DVec4::W))
}

/// Between two values with tangents per second, at a share of the time between them (glTF 2.0,
/// appendix C).
fn hermite([value, leaves, enters, goal]: [&[f64]; 4], t: f64, seconds: f64) -> Vec<f64> {
    let (t2, t3) = (t * t, t * t * t);
    let weights = [
        2.0 * t3 - 3.0 * t2 + 1.0,
        seconds * (t3 - 2.0 * t2 + t),
        seconds * (t3 - t2),
        3.0 * t2 - 2.0 * t3,
    ];
    let at = |row: usize| {
        let parts = [value[row], leaves[row], enters[row], goal[row]];
        parts.iter().zip(weights).map(|(part, weight)| part * weight).sum()
    };
    (0..value.len()).map(at).collect()
}
