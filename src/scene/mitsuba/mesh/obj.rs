//! Wavefront OBJ: positions, normals, texture coordinates and polygons; groups, materials and lines
//! are not looked at.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::{ELEMENTS_MAX, Soup, fan};
use crate::math::text::excerpt;

/// Most characters of a line that an error quotes.
const LINE: usize = 60;

/// Reads a file; what is wrong with it, and where, otherwise.
pub fn read(bytes: &[u8]) -> Result<Soup, String> {
    let mut reader = Reader::default();
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        reader.line(&text).map_err(|problem| {
            format!("line {}: {problem}: `{}`", index + 1, excerpt(text.trim(), LINE))
        })?;
    }
    let Reader { mut soup, has_normals, has_coordinates, .. } = reader;
    if !has_coordinates {
        soup.geometry.texture_coordinates = Vec::new();
    }
    if !has_normals {
        soup.geometry.normals = Vec::new();
    }
    Ok(soup)
}

#[derive(Default)]
struct Reader {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    coordinates: Vec<Vec2>,
    /// Vertices by position, texture coordinates and normal, counted from 1; 0 is none of these.
    vertices: HashMap<[usize; 3], u32>,
    soup: Soup,
    has_normals: bool,
    has_coordinates: bool,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.positions.push(Vec3::from(vector(words)?)),
            Some("vn") => self.normals.push(Vec3::from(vector(words)?)),
            // A third number is of pictures in space.
            Some("vt") => self.coordinates.push(Vec2::from(vector(words)?)),
            Some("f") => {
                let corners: Result<Vec<u32>, String> =
                    words.map(|word| self.corner(word)).collect();
                self.soup.geometry.triangles.extend(fan(&corners?));
            }
            Some(_) | None => {}
        }
        match self.positions.len().max(self.soup.geometry.triangles.len()) {
            ..=ELEMENTS_MAX => Ok(()),
            _ => Err("is too large".to_owned()),
        }
    }

    /// The vertex of a corner, as `3`, `3/1`, `3//2` or `3/1/2`; from the last if negative.
    fn corner(&mut self, word: &str) -> Result<u32, String> {
        let mut parts = word.split('/');
        let position = index(parts.next().unwrap_or_default(), self.positions.len())?;
        let mut of = |count: usize| match parts.next() {
            None | Some("") => Ok(0),
            Some(text) => index(text, count),
        };
        let (place, normal) = (of(self.coordinates.len())?, of(self.normals.len())?);
        self.has_normals |= normal > 0;
        self.has_coordinates |= place > 0;
        let soup = &mut self.soup;
        let next = soup.geometry.positions.len() as u32;
        let vertex = *self.vertices.entry([position, place, normal]).or_insert(next);
        if vertex == next {
            soup.geometry.positions.push(self.positions[position - 1]);
            let own = normal.checked_sub(1).map(|normal| self.normals[normal]);
            soup.geometry.normals.push(own.unwrap_or(Vec3::ZERO));
            let own = place.checked_sub(1).map(|place| self.coordinates[place]);
            soup.geometry.texture_coordinates.push(own.unwrap_or(Vec2::ZERO));
            soup.points.push((position - 1) as u32);
        }
        Ok(vertex)
    }
}

/// A number of what there is, counted from 1.
fn index(text: &str, count: usize) -> Result<usize, String> {
    let number: i64 = text.parse().map_err(|_| format!("`{}` is no index", excerpt(text, LINE)))?;
    let index = if number < 0 { count as i64 + 1 + number } else { number };
    let index = usize::try_from(index).ok().filter(|index| (1..=count).contains(index));
    index.ok_or_else(|| format!("there is no {number} of {count}"))
}

fn vector<'a, const K: usize>(
    mut words: impl Iterator<Item = &'a str>,
) -> Result<[f32; K], String> {
    let mut vector = [0.0; K];
    for value in &mut vector {
        let number = words.next().and_then(|word| word.parse::<f32>().ok());
        let number = number.filter(|number| number.is_finite());
        *value = number.ok_or_else(|| format!("needs {K} numbers"))?;
    }
    Ok(vector)
}
