//! Values of a scene's parameters from outside: as `-D` gives them, and as edits by name,
//! `define/NAME`.

use serde_json::Value;

use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::file::{DEFINE, not_edited};
use crate::scene::gltf::Edit;

/// Most characters of a value in errors.
const VALUE: usize = 60;

/// Definitions with those of edits in their places; null takes one away, so that the default holds.
///
/// # Errors
/// When an edit is of anything else, or its value is none that a text could be.
pub fn with_edits(
    definitions: &[(String, String)],
    edits: &[Edit],
) -> Result<Vec<(String, String)>, SceneError> {
    let mut all = definitions.to_vec();
    for Edit { target, value } in edits {
        let name = target.strip_prefix(DEFINE).filter(|name| !name.is_empty());
        let name = name.ok_or_else(|| not_edited(target))?;
        all.retain(|(known, _)| known != name);
        if !value.is_null() {
            let text = text_of(value).ok_or_else(|| {
                let value = excerpt(&value.to_string(), VALUE);
                let remedy = "give a number, a word, true or false, or a list of numbers";
                SceneError::new(target, format!("{value} is no value of a parameter"), remedy)
            })?;
            all.push((name.to_owned(), text));
        }
    }
    Ok(all)
}

/// A value as it stands in an attribute.
fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::Bool(is) => Some(is.to_string()),
        Value::Number(number) => Some(number.to_string()),
        Value::String(text) => Some(text.clone()),
        Value::Array(items) => {
            let number = |item: &Value| item.is_number().then(|| item.to_string());
            Some(items.iter().map(number).collect::<Option<Vec<_>>>()?.join(", "))
        }
        Value::Null | Value::Object(_) => None,
    }
}
