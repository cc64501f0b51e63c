//! Places of keyword arguments: a matrix, a point, or a look from somewhere to somewhere.

use pyo3::prelude::*;
use sunstone::glam::{DAffine3, DMat3, DVec3};
use sunstone::world::Transform;

use crate::keys::Keys;

/// A place: `transform`, or else `position`, or else where the world's axes are.
pub fn place(keys: &Keys) -> PyResult<Transform> {
    match (transform(keys)?, point(keys, "position")?) {
        (None, None) => Ok(Transform::IDENTITY),
        (Some(transform), None) => Ok(transform),
        (None, Some(position)) => Ok(position.into()),
        (Some(_), Some(_)) => Err(twice(keys)),
    }
}

/// The place of something that looks along its -z axis: `transform`, or else `position` with
/// `target` or `direction`, and `up`.
pub fn looking(keys: &Keys) -> PyResult<Transform> {
    let matrix = transform(keys)?;
    let position = point(keys, "position")?;
    let target = point(keys, "target")?;
    let direction = point(keys, "direction")?;
    let up = point(keys, "up")?;
    if let Some(matrix) = matrix {
        let others = [position, target, direction, up];
        return if others.iter().all(Option::is_none) { Ok(matrix) } else { Err(twice(keys)) };
    }
    let eye = position.unwrap_or(DVec3::ZERO);
    let ahead = match (target, direction) {
        (None, None) => DVec3::NEG_Z,
        (Some(target), None) => target - eye,
        (None, Some(direction)) => direction,
        (Some(_), Some(_)) => return Err(twice(keys)),
    };
    // Any axis will do that is not along the line of sight, where nobody asks for one.
    let across = if ahead.normalize_or_zero().y.abs() > 0.999 { DVec3::X } else { DVec3::Y };
    Ok(Transform::looking(eye, eye + ahead, up.unwrap_or(across)))
}

fn twice(keys: &Keys) -> PyErr {
    keys.refuse(
        "",
        "its place is given twice",
        "give `transform`, or `position` with one direction",
    )
}

fn point(keys: &Keys, key: &str) -> PyResult<Option<DVec3>> {
    Ok(keys.take::<[f64; 3]>(key)?.map(DVec3::from_array))
}

fn transform(keys: &Keys) -> PyResult<Option<Transform>> {
    let Some([x, y, z, last]) = keys.take::<[[f64; 4]; 4]>("transform")? else { return Ok(None) };
    if last != [0.0, 0.0, 0.0, 1.0] {
        let problem = "the last row of the matrix must be 0, 0, 0, 1";
        return Err(keys.refuse("transform", problem, "put the translation into the last column"));
    }
    let rows = [x, y, z].map(|[x, y, z, _]| DVec3::new(x, y, z));
    let matrix = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    Ok(Some(DAffine3::from_mat3_translation(matrix, DVec3::new(x[3], y[3], z[3])).into()))
}
