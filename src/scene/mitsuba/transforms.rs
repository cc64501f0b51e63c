//! Transforms, out of steps that follow one another.

use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::text::{number, numbers};
use super::tree::NAME;
use super::xml::{Attributes, vector};
use crate::math::elementary::sin_cos;
use crate::math::text::excerpt;
use crate::scene::error::SceneError;

/// What steps do one after the other.
pub fn transform(steps: &[(&str, Attributes)]) -> Result<DAffine3, SceneError> {
    let mut whole = DAffine3::IDENTITY;
    for (element, attributes) in steps {
        let step = step(element, attributes).map_err(|problem| {
            let place = attributes.place.clone();
            SceneError::new(place, problem, "")
        })?;
        whole = step * whole;
    }
    match whole.is_finite() {
        true => Ok(whole),
        false => {
            let place = steps.last().map_or("transform", |(_, attributes)| &attributes.place);
            Err(SceneError::new(place, "the transform is not finite", ""))
        }
    }
}

fn step(element: &str, attributes: &Attributes) -> Result<DAffine3, String> {
    let of = |name: &str| attributes.get(name).ok_or_else(|| format!("{name} is missing"));
    match element {
        "translate" => vector(attributes, Some(0.0)).map(DAffine3::from_translation),
        "scale" => vector(attributes, Some(1.0)).map(DAffine3::from_scale),
        "rotate" => rotation(vector(attributes, Some(0.0))?, number(of("angle")?)?),
        "matrix" => matrix(&numbers(of("value")?)?),
        "lookat" | "lookAt" => {
            let point = |text: &str| match numbers(text)?[..] {
                [x, y, z] => Ok(DVec3::new(x, y, z)),
                _ => Err(format!("`{}` is not three numbers", excerpt(text, NAME))),
            };
            let up = attributes.get("up").map(point).transpose()?.unwrap_or(DVec3::ZERO);
            looking(point(of("origin")?)?, point(of("target")?)?, up)
        }
        other => Err(format!("<{}> is no step of a transform", excerpt(other, NAME))),
    }
}

/// About an axis, counter-clockwise for who looks against it, by an angle in degrees. An axis that
/// is not of unit length gives more than a turn, as in Mitsuba: scenes were made to look so.
fn rotation(axis: DVec3, degrees: f64) -> Result<DAffine3, String> {
    if axis == DVec3::ZERO {
        return Err("the axis is zero".to_owned());
    }
    let (sine, cosine) = sin_cos(degrees.to_radians());
    // O. Rodrigues' formula, column by column.
    let turned = |v: DVec3| v * cosine + axis.cross(v) * sine + axis * axis.dot(v) * (1.0 - cosine);
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(turned);
    Ok(DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2])))
}

/// Of nine or sixteen numbers, row by row.
fn matrix(rows: &[f64]) -> Result<DAffine3, String> {
    match *rows {
        [a, b, c, d, e, f, g, h, i] => {
            let columns = [DVec3::new(a, d, g), DVec3::new(b, e, h), DVec3::new(c, f, i)];
            Ok(DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2])))
        }
        ref rows if rows.len() == 16 => {
            let mut values = [0.0; 16];
            values.copy_from_slice(rows);
            let matrix = DMat4::from_cols_array(&values).transpose();
            if matrix.row(3) != DVec4::W {
                return Err("the last row must be 0 0 0 1: parallels stay parallel".to_owned());
            }
            Ok(DAffine3::from_mat4(matrix))
        }
        _ => Err(format!("has {} numbers, not 9 or 16", rows.len())),
    }
}

/// From `origin` to `target`: z goes there, y is up, and x to the left.
pub fn looking(origin: DVec3, target: DVec3, up: DVec3) -> Result<DAffine3, String> {
    let Some(forward) = (target - origin).try_normalize() else {
        return Err("origin and target are one point".to_owned());
    };
    let up = if up == DVec3::ZERO { perpendicular(forward) } else { up };
    let Some(left) = up.cross(forward).try_normalize() else {
        return Err("up is along the line of sight".to_owned());
    };
    let axes = DMat3::from_cols(left, forward.cross(left), forward);
    Ok(DAffine3::from_mat3_translation(axes, origin))
}

/// The direction that Mitsuba takes for one perpendicular to another, of unit length: T. Duff et
/// al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
pub fn perpendicular(z: DVec3) -> DVec3 {
    let sign = 1.0_f64.copysign(z.z);
    let a = -1.0 / (sign + z.z);
    DVec3::new(1.0 + sign * z.x * z.x * a, sign * z.x * z.y * a, -sign * z.x)
}
