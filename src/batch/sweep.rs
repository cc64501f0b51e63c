//! Sweeps: axes of values, of which every combination is a job.

use std::collections::{BTreeSet, HashMap};

use serde_json::{Map, Value};

/// Most values of an axis, and most jobs of a sweep.
pub const VALUES_MAX: usize = 1_000_000;

/// What an axis may say.
const KEYS: [&str; 7] = ["count", "from", "key", "name", "step_with", "to", "values"];

/// An edit or option that takes several values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it is called in names and results.
    pub name: String,
    /// What it sets: an edit, `KIND/NAME/KEY`, or an option.
    pub key: String,
    /// What to.
    pub values: Vec<Value>,
    /// The axis that it walks in step with.
    step_with: Option<String>,
}

impl Axis {
    /// Reads an axis.
    ///
    /// # Errors
    /// In words, all that is wrong with it.
    pub fn parse(table: &Value) -> Result<Self, Vec<String>> {
        let Some(table) = table.as_object() else {
            return Err(vec!["is not a table of name, key and values".to_owned()]);
        };
        let mut wrong: Vec<String> = (table.keys())
            .filter(|key| !KEYS.contains(&key.as_str()))
            .map(|key| format!("`{key}` is not a key of an axis; keys are {}", KEYS.join(", ")))
            .collect();
        let mut word = |key: &str| match table.get(key) {
            Some(Value::String(word)) if !word.is_empty() => Some(word.clone()),
            Some(_) => {
                wrong.push(format!("`{key}` is not a word"));
                None
            }
            None => None,
        };
        let [name, key, step_with] = ["name", "key", "step_with"].map(&mut word);
        for (what, is_there) in
            [("name", table.contains_key("name")), ("key", table.contains_key("key"))]
        {
            if !is_there {
                wrong.push(format!("has no `{what}`"));
            }
        }
        let values = values(table).map_err(|text| wrong.push(text)).unwrap_or_default();
        match (name, key) {
            (Some(name), Some(key)) if wrong.is_empty() => {
                Ok(Self { name, key, values, step_with })
            }
            _ => Err(wrong),
        }
    }

    /// What stands for one of its values in the names of files: itself, or, of tables and of lists
    /// that are long or have lists in them, its place among the values, from 0.
    pub fn in_names(&self, at: usize) -> Value {
        const ITEMS_MAX: usize = 4;
        let is_plain = |value: &Value| !value.is_array() && !value.is_object();
        let value = &self.values[at];
        let is_short = match value {
            Value::Array(items) => items.len() <= ITEMS_MAX && items.iter().all(is_plain),
            other => is_plain(other),
        };
        if is_short { value.clone() } else { at.into() }
    }

    /// The same of all values, with numbers in as few digits as tell what they are: without what
    /// arithmetic has left behind, and six of those that have no end. Values that differ have names
    /// that do.
    pub fn short_names(&self) -> Vec<Value> {
        let whole: Vec<Value> = (0..self.values.len()).map(|at| self.in_names(at)).collect();
        for digits in DIGITS_FEW..DIGITS_MANY {
            let mut short: Vec<Value> = whole.iter().map(|it| shortened(it, digits)).collect();
            if tell_apart(&short, &whole) {
                return short;
            }
            // What has no end may need more digits; what is a double next to a single does not.
            if digits + 1 == DIGITS_MANY {
                lengthen(&mut short, &whole);
                if tell_apart(&short, &whole) {
                    return short;
                }
            }
        }
        whole
    }
}

/// Digits of numbers that have no end, of what is more than the noise of arithmetic, and of all.
const DIGITS_FEW: usize = 6;
const DIGITS_STATED: usize = 12;
const DIGITS_MANY: usize = 17;
/// What arithmetic leaves behind in a number, as a share of it.
const NOISE: f64 = 1e-14;

/// A value with its numbers in as few digits as are needed: `digits` where there is no end.
fn shortened(value: &Value, digits: usize) -> Value {
    match value {
        Value::Array(items) => items.iter().map(|item| shortened(item, digits)).collect(),
        Value::Number(number) if number.is_f64() => {
            number.as_f64().map_or(Value::Null, |number| fewest(number, digits).into())
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Object(_) => {
            value.clone()
        }
    }
}

/// A number in as few digits as are needed: the one that was meant, or `digits` of it.
fn fewest(number: f64, digits: usize) -> f64 {
    let single = number as f32;
    let stated: f64 = match f64::from(single) == number {
        // The double of a single: that has fewer.
        true => single.to_string().parse().unwrap_or(number),
        false => number,
    };
    if significant(stated) <= DIGITS_STATED {
        return stated;
    }
    let of = |digits: usize| -> f64 {
        let text = format!("{stated:.*e}", digits - 1);
        text.parse().unwrap_or(stated)
    };
    let is_it = |short: &f64| (short - stated).abs() <= NOISE * stated.abs();
    (1..=DIGITS_STATED).map(of).find(is_it).unwrap_or_else(|| of(digits))
}

/// The digits of a number that count.
fn significant(number: f64) -> usize {
    let text = format!("{number:e}");
    text.split('e').next().map_or(0, |text| text.chars().filter(char::is_ascii_digit).count())
}

/// Gives values that share a name with others their own.
fn lengthen(names: &mut [Value], values: &[Value]) {
    let mut values_of: HashMap<String, BTreeSet<String>> = HashMap::new();
    for (name, value) in names.iter().zip(values) {
        values_of.entry(name.to_string()).or_default().insert(value.to_string());
    }
    for (name, value) in names.iter_mut().zip(values) {
        if values_of.get(&name.to_string()).is_some_and(|values| values.len() > 1) {
            *name = value.clone();
        }
    }
}

/// Whether values that differ have names that do.
fn tell_apart(names: &[Value], values: &[Value]) -> bool {
    let mut known = HashMap::with_capacity(names.len());
    names
        .iter()
        .zip(values)
        .all(|(name, value)| *known.entry(name.to_string()).or_insert(value) == value)
}

/// The values that an axis lists, or that lie evenly between two.
fn values(table: &Map<String, Value>) -> Result<Vec<Value>, String> {
    let range = ["from", "to", "count"].map(|key| table.get(key));
    match (table.get("values"), range) {
        (Some(Value::Array(values)), [None, None, None]) => match values.len() {
            0 => Err("`values` is empty".to_owned()),
            1..=VALUES_MAX => Ok(values.clone()),
            _ => Err(format!("has more than {VALUES_MAX} values")),
        },
        (Some(_), [None, None, None]) => Err("`values` is not a list".to_owned()),
        (None, [Some(from), Some(to), Some(count)]) => between(from, to, count),
        _ => Err("takes either `values` or `from`, `to` and `count`".to_owned()),
    }
}

/// Whole numbers if both ends and all steps are.
fn between(from: &Value, to: &Value, count: &Value) -> Result<Vec<Value>, String> {
    let count = count.as_u64().filter(|count| (1..=VALUES_MAX as u64).contains(count));
    let count = count.ok_or_else(|| format!("`count` must be from 1 to {VALUES_MAX}"))?;
    let (Some(a), Some(b)) = (from.as_f64(), to.as_f64()) else {
        return Err("`from` and `to` must be numbers".to_owned());
    };
    let steps = (count - 1).max(1);
    if let (Some(a), Some(b)) = (from.as_i64(), to.as_i64())
        && (i128::from(b) - i128::from(a)) % i128::from(steps) == 0
    {
        let step = (i128::from(b) - i128::from(a)) / i128::from(steps);
        let whole = |index: u64| (i128::from(a) + step * i128::from(index)) as i64;
        return Ok((0..count).map(|index| whole(index).into()).collect());
    }
    let value = |index: u64| match index {
        0 => a,
        index if index == steps => b,
        index => rounded(a + (b - a) * index as f64 / steps as f64, a.abs().max(b.abs())),
    };
    Ok((0..count).map(|index| value(index).into()).collect())
}

/// A number without what arithmetic has left behind in it, by the largest of those it is made of:
/// 0.3 in place of 0.30000000000000004, and 0 in place of a small part of the others.
fn rounded(number: f64, largest: f64) -> f64 {
    let near = |short: &f64| (short - number).abs() <= NOISE * largest;
    let text = format!("{largest:e}");
    let leading = text.split_once('e').and_then(|(_, power)| power.parse::<i32>().ok());
    let most = leading.map_or(0, |leading| DIGITS_STATED as i32 - leading);
    let of = |decimals: i32| format!("{number:.*}", decimals as usize).parse::<f64>().ok();
    // None is behind zero.
    (0..=most.max(0)).filter_map(of).find(near).map_or(number, |short| short + 0.0)
}

/// What a sweep unfolds to: for every job, the index of the value of each axis; the last axis is
/// the fastest.
///
/// # Errors
/// In words, when axes do not go together.
pub fn unfold(axes: &[Axis]) -> Result<Vec<Vec<usize>>, String> {
    let leader = |axis: &Axis| match &axis.step_with {
        None => Ok(None),
        Some(other) => {
            let found = axes.iter().position(|axis| axis.name == *other);
            let found = found.filter(|found| axes[*found].step_with.is_none());
            let Some(found) = found else {
                let text = "`step_with` names no axis that goes its own way";
                return Err(format!("axis \"{}\": {text}", axis.name));
            };
            let (own, others) = (axis.values.len(), axes[found].values.len());
            if own != others {
                let name = &axis.name;
                return Err(format!("axis \"{name}\" has {own} values, and \"{other}\" {others}"));
            }
            Ok(Some(found))
        }
    };
    let leaders: Vec<Option<usize>> = axes.iter().map(leader).collect::<Result<_, _>>()?;
    let own = |axis: usize| if leaders[axis].is_none() { axes[axis].values.len() } else { 1 };
    let jobs = (0..axes.len()).try_fold(1_usize, |jobs, axis| {
        jobs.checked_mul(own(axis)).filter(|jobs| *jobs <= VALUES_MAX)
    });
    let Some(jobs) = jobs else { return Err(format!("is of more than {VALUES_MAX} jobs")) };
    let indices = |job: usize| {
        let mut rest = job;
        let mut indices = vec![0; axes.len()];
        for axis in (0..axes.len()).rev() {
            indices[axis] = rest % own(axis);
            rest /= own(axis);
        }
        for (axis, leader) in leaders.iter().enumerate() {
            if let Some(leader) = leader {
                indices[axis] = indices[*leader];
            }
        }
        indices
    };
    Ok((0..jobs).map(indices).collect())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn axis(table: Value) -> Axis {
        Axis::parse(&table).unwrap_or_else(|wrong| panic!("{wrong:?}"))
    }

    #[test]
    fn the_last_axis_is_the_fastest_and_some_walk_in_step() {
        let angle = axis(json!({"name": "a", "key": "materials/m/axis_deg", "values": [0, 45]}));
        let ior = axis(json!({"name": "b", "key": "x/y/z", "from": 1, "to": 2, "count": 3}));
        let with = json!({"name": "c", "key": "spp", "values": [1, 2], "step_with": "a"});
        let axes = [angle, ior, axis(with)];
        assert_eq!(axes[1].values, [json!(1.0), json!(1.5), json!(2.0)]);
        let jobs = unfold(&axes).unwrap();
        let expected = [[0, 0, 0], [0, 1, 0], [0, 2, 0], [1, 0, 1], [1, 1, 1], [1, 2, 1]];
        assert_eq!(jobs, expected);
        assert_eq!(unfold(&[]).unwrap(), [Vec::<usize>::new()]);
    }

    #[test]
    fn tables_have_numbers_in_names() {
        let table = json!({"nm": [400, 700], "value": [0.1, 0.9]});
        let color = json!([0.5, 0.25, 1]);
        let long = json!([1, 2, 3, 4, 5]);
        let values = json!([table, "gold", color, [[1, 2]], long, {}, null, 0.5, [table]]);
        let axis = axis(json!({"name": "a", "key": "k", "values": values}));
        let names: Vec<Value> = (0..9).map(|at| axis.in_names(at)).collect();
        assert_eq!(json!(names), json!([0, "gold", color, 3, 4, 5, null, 0.5, 8]));
    }

    /// No digits of arithmetic, and six of what has no end; more where six tell nothing apart.
    #[test]
    fn names_are_short_and_tell_values_apart() {
        let names = |values: Value| axis(json!({"name": "a", "key": "k", "values": values}));
        let single = f64::from(0.1_f32);
        let noisy = json!([0.1, 0.2, 0.1 + 0.2, 1.0 / 3.0, 2.0 / 3.0, 1e-7, 1.5e300]);
        let few = json!([0.1, 0.2, 0.3, 0.333333, 0.666667, 1e-7, 1.5e300]);
        assert_eq!(json!(names(noisy).short_names()), few);
        let others = json!([single, 3, "x", -0.0, 5.0]);
        assert_eq!(json!(names(others).short_names()), json!([0.1, 3, "x", -0.0, 5.0]));
        // 0.1 and its single are two values.
        let both = json!([0.1, 0.1 + 0.2, single]);
        assert_eq!(json!(names(both).short_names()), json!([0.1, 0.3, single]));
        // Seven digits here, and all of these.
        let close = json!([1.0 / 3.0, 0.33333341234567, 0.5]);
        assert_eq!(json!(names(close).short_names()), json!([0.3333333, 0.3333334, 0.5]));
        let next = f64::from_bits((1.0_f64 / 3.0).to_bits() + 1);
        let neighbors = json!(names(json!([1.0 / 3.0, next])).short_names());
        assert_eq!(neighbors.to_string(), "[0.3333333333333333,0.3333333333333334]");
        // What is stated in some digits keeps them, in lists too.
        let stated = json!([550.12345678, [0.1 + 0.2, 1], 12345678901.5, 0.1]);
        let kept = json!([550.12345678, [0.3, 1], 12345678901.5, 0.1]);
        assert_eq!(json!(names(stated).short_names()), kept);
    }

    #[test]
    fn steps_of_ranges_are_what_was_meant() {
        for (from, to, count, decimals) in [
            (0.1, 0.7, 7, 1),
            (-0.3, 0.3, 7, 1),
            (0.0, 1.0, 1001, 3),
            (1.1, 2.3, 13, 1),
            (1e-7, 9e-7, 9, 7),
            (1000.05, 1000.95, 19, 2),
            (0.7, -0.2, 10, 1),
        ] {
            let range = json!({"name": "a", "key": "k", "from": from, "to": to, "count": count});
            for (index, value) in axis(range).values.iter().enumerate() {
                let exact = from + (to - from) * index as f64 / f64::from(count - 1);
                let meant: f64 = format!("{exact:.decimals$}").parse().unwrap();
                // Zero has no sign.
                assert_eq!(value.as_f64().unwrap().to_bits(), (meant + 0.0).to_bits(), "{value}");
            }
        }
        let thirds = axis(json!({"name": "a", "key": "k", "from": 0, "to": 1, "count": 4})).values;
        assert_eq!(thirds[1..3], [json!(1.0 / 3.0), json!(2.0 / 3.0)]);
        let huge = axis(json!({"name": "a", "key": "k", "from": -1e300, "to": 1e300, "count": 5}));
        assert_eq!(huge.values[1..4], [json!(-5e299), json!(0.0), json!(5e299)]);
    }

    #[test]
    fn ranges_are_whole_where_they_can_be() {
        let range = |from: Value, to: Value, count: u64| {
            axis(json!({"name": "a", "key": "k", "from": from, "to": to, "count": count})).values
        };
        let angles = range(json!(0), json!(175), 36);
        assert_eq!((angles.len(), &angles[1], &angles[35]), (36, &json!(5), &json!(175)));
        assert_eq!(range(json!(0.0), json!(1.0), 3), [json!(0.0), json!(0.5), json!(1.0)]);
        assert_eq!(range(json!(3), json!(9), 1), [json!(3)]);
        assert_eq!(range(json!(2), json!(-2), 3), [json!(2), json!(0), json!(-2)]);
    }

    #[test]
    fn what_is_no_axis_is_said() {
        for (table, words) in [
            (json!({"name": "a", "values": [1]}), "has no `key`"),
            (json!({"name": "a", "key": "k"}), "takes either `values` or"),
            (json!({"name": "a", "key": "k", "values": []}), "`values` is empty"),
            (json!({"name": "a", "key": "k", "values": [1], "by": 2}), "`by` is not a key"),
            (json!({"name": "a", "key": "k", "from": 0, "to": 1, "count": 0}), "`count` must be"),
            (json!({"name": "a", "key": "k", "from": "x", "to": 1, "count": 2}), "must be numbers"),
            (json!(3), "is not a table"),
        ] {
            let wrong = Axis::parse(&table).unwrap_err().join("\n");
            assert!(wrong.contains(words), "{table}: {wrong}");
        }
        let lone = axis(json!({"name": "a", "key": "k", "values": [1], "step_with": "b"}));
        assert!(unfold(&[lone]).unwrap_err().contains("names no axis"));
    }
}
