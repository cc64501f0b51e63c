//! PLY: vertices with positions, normals and texture coordinates, and polygons; ASCII or binary of
//! either byte order. What else there is is passed over.

use glam::{Vec2, Vec3};

use super::bytes::Bytes;
use super::{ELEMENTS_MAX, Soup, fan};
use crate::math::text::excerpt;

/// Most characters of a line that an error quotes.
const LINE: usize = 60;

/// Reads a file; what is wrong with it otherwise.
pub fn read(bytes: &[u8]) -> Result<Soup, String> {
    let (header, rest) = Header::read(bytes)?;
    let text = String::from_utf8_lossy(if header.format == Format::Ascii { rest } else { &[] });
    let mut source = match header.format {
        Format::Ascii => Source::Words(text.split_ascii_whitespace()),
        Format::LittleEndian => Source::Bytes(Bytes::new(rest, false)),
        Format::BigEndian => Source::Bytes(Bytes::new(rest, true)),
    };
    let mut soup = Soup::default();
    for element in &header.elements {
        let mut kept = Kept::of(element);
        for _ in 0..element.count {
            kept.row(element, &mut source, &mut soup)?;
        }
    }
    let count = soup.geometry.positions.len();
    let mut corners = soup.geometry.triangles.as_flattened().iter();
    match corners.find(|corner| **corner as usize >= count) {
        Some(corner) => Err(format!("{corner} is not one of the {count} vertices")),
        None => Ok(soup),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Kinds of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

#[derive(Debug)]
struct Property {
    name: String,
    /// What counts the items, of a list.
    count: Option<Scalar>,
    scalar: Scalar,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

#[derive(Debug)]
struct Header {
    format: Format,
    elements: Vec<Element>,
}

impl Header {
    /// The header, and what is behind it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut rest = bytes;
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        for number in 1.. {
            let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
                return Err("its header has no end".to_owned());
            };
            let line = String::from_utf8_lossy(&rest[..end]).trim().to_owned();
            rest = &rest[end + 1..];
            let words: Vec<&str> = line.split_whitespace().collect();
            let wrong = || format!("line {number}: `{}` is not known", excerpt(&line, LINE));
            match words[..] {
                ["ply"] if number == 1 => {}
                _ if number == 1 => return Err("does not begin with `ply`".to_owned()),
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, _] => format = Some(Self::format(name).ok_or_else(wrong)?),
                ["element", name, count] => {
                    let count = count.parse().ok().filter(|count| *count <= ELEMENTS_MAX);
                    let count = count.ok_or_else(wrong)?;
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref words @ ..] => {
                    let property = Self::property(words).ok_or_else(wrong)?;
                    elements.last_mut().ok_or_else(wrong)?.properties.push(property);
                }
                _ => return Err(wrong()),
            }
        }
        let format = format.ok_or("its header has no format")?;
        Ok((Self { format, elements }, rest))
    }

    fn format(name: &str) -> Option<Format> {
        match name {
            "ascii" => Some(Format::Ascii),
            "binary_little_endian" => Some(Format::LittleEndian),
            "binary_big_endian" => Some(Format::BigEndian),
            _ => None,
        }
    }

    fn property(words: &[&str]) -> Option<Property> {
        match *words {
            ["list", count, scalar, name] => Some(Property {
                name: name.to_owned(),
                count: Some(Scalar::of(count)?),
                scalar: Scalar::of(scalar)?,
            }),
            [scalar, name] => {
                Some(Property { name: name.to_owned(), count: None, scalar: Scalar::of(scalar)? })
            }
            _ => None,
        }
    }
}

/// Where numbers come from.
enum Source<'a> {
    Words(std::str::SplitAsciiWhitespace<'a>),
    Bytes(Bytes<'a>),
}

impl Source<'_> {
    fn next(&mut self, scalar: Scalar) -> Option<f64> {
        let bytes = match self {
            Self::Words(words) => return words.next()?.parse().ok(),
            Self::Bytes(bytes) => bytes,
        };
        Some(match scalar {
            Scalar::I8 => i8::from_le_bytes(bytes.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(bytes.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(bytes.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(bytes.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(bytes.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(bytes.take()?).into(),
            Scalar::F32 => f32::from_le_bytes(bytes.take()?).into(),
            Scalar::F64 => f64::from_le_bytes(bytes.take()?),
        })
    }
}

/// What is kept of the rows of an element.
struct Kept {
    is_vertex: bool,
    is_face: bool,
    has_normals: bool,
    has_coordinates: bool,
    corners: Vec<u32>,
}

/// The properties of vertices that are kept.
const OF_VERTICES: [&str; 8] = ["x", "y", "z", "nx", "ny", "nz", "u", "v"];
/// What texture coordinates are called, too.
const COORDINATES: [[&str; 2]; 2] = [["s", "u"], ["t", "v"]];

/// The place of a property among those of vertices.
fn place_of(name: &str) -> Option<usize> {
    let renamed = COORDINATES.iter().find(|[other, _]| *other == name);
    let name = renamed.map_or(name, |[_, own]| own);
    OF_VERTICES.iter().position(|known| *known == name)
}

impl Kept {
    fn of(element: &Element) -> Self {
        let places: Vec<usize> =
            element.properties.iter().filter_map(|it| place_of(&it.name)).collect();
        let has = |mut range: std::ops::Range<usize>| range.all(|place| places.contains(&place));
        Self {
            is_vertex: element.name == "vertex",
            is_face: element.name == "face",
            has_normals: has(3..6),
            has_coordinates: has(6..8),
            corners: Vec::new(),
        }
    }

    fn row(
        &mut self,
        element: &Element,
        source: &mut Source,
        soup: &mut Soup,
    ) -> Result<(), String> {
        let ends = || "ends before its last number, or has something else".to_owned();
        if element.properties.is_empty() {
            return Err(format!("its {} have no properties", excerpt(&element.name, LINE)));
        }
        let mut vertex = [0.0_f32; OF_VERTICES.len()];
        for Property { name, count, scalar } in &element.properties {
            let Some(count) = count else {
                let value = source.next(*scalar).ok_or_else(ends)?;
                if let Some(at) = place_of(name) {
                    vertex[at] = value as f32;
                }
                continue;
            };
            let count = source.next(*count).ok_or_else(ends)?;
            let is_kept = self.is_face && ["vertex_index", "vertex_indices"].contains(&&**name);
            self.corners.clear();
            for _ in 0..count as u64 {
                let value = source.next(*scalar).ok_or_else(ends)?;
                if is_kept {
                    let is_index = (0.0..f64::from(u32::MAX)).contains(&value);
                    self.corners.push(if is_index { value as u32 } else { u32::MAX });
                }
            }
            if is_kept {
                soup.geometry.triangles.extend(fan(&self.corners));
            }
        }
        if self.is_vertex {
            let [x, y, z, nx, ny, nz, u, v] = vertex;
            soup.geometry.positions.push(Vec3::new(x, y, z));
            if self.has_normals {
                soup.geometry.normals.push(Vec3::new(nx, ny, nz));
            }
            if self.has_coordinates {
                soup.geometry.texture_coordinates.push(Vec2::new(u, v));
            }
        }
        match soup.geometry.triangles.len() {
            ..=ELEMENTS_MAX => Ok(()),
            _ => Err("is too large".to_owned()),
        }
    }
}
