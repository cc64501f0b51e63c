//! Reading vertex attributes and indices out of buffers, with every bound checked.

use glam::{Vec2, Vec3, Vec4};
use gltf::json::Index;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::{Checked, USize64};

use super::document::Document;
use crate::scene::error::SceneError;

/// How to mend a file that contradicts itself.
const AGAIN: &str = "export the scene again";

/// Most elements of an accessor without bytes of its own: those of a mesh that is made of sparse
/// ones alone.
const ZEROS_MAX: u64 = 1 << 24;

/// What an accessor must hold.
struct Wanted {
    components: &'static [ComponentType],
    shape: Type,
    text: &'static str,
}

/// Components that are numbers: floats, and integers as `KHR_mesh_quantization` and animations have
/// them.
const NUMBERS: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];

const VECTORS: Wanted = Wanted {
    components: NUMBERS,
    shape: Type::Vec3,
    text: "VEC3 of FLOAT, BYTE or SHORT (componentType 5126 or 5120 to 5123)",
};

const FOURS: Wanted = Wanted {
    components: NUMBERS,
    shape: Type::Vec4,
    text: "VEC4 of FLOAT, BYTE or SHORT (componentType 5126 or 5120 to 5123)",
};

const SCALARS: Wanted = Wanted {
    components: NUMBERS,
    shape: Type::Scalar,
    text: "SCALAR of FLOAT, BYTE or SHORT (componentType 5126 or 5120 to 5123)",
};

const MATRICES: Wanted = Wanted {
    components: &[ComponentType::F32],
    shape: Type::Mat4,
    text: "MAT4 of FLOAT (componentType 5126)",
};

const INDICES: Wanted = Wanted {
    components: &[ComponentType::U8, ComponentType::U16, ComponentType::U32],
    shape: Type::Scalar,
    text: "SCALAR of an unsigned type (componentType 5121, 5123 or 5125)",
};

/// Floats, or integers that stand for numbers from 0 to 1.
const SHARES: &[ComponentType] = &[ComponentType::F32, ComponentType::U8, ComponentType::U16];

const COORDINATES: Wanted = Wanted {
    components: NUMBERS,
    shape: Type::Vec2,
    text: "VEC2 of FLOAT, BYTE or SHORT (componentType 5126 or 5120 to 5123)",
};

const OPAQUE_COLORS: Wanted = Wanted {
    components: SHARES,
    shape: Type::Vec3,
    text: "VEC3 or VEC4 of FLOAT, UNSIGNED_BYTE or UNSIGNED_SHORT",
};

const COLORS: Wanted = Wanted { shape: Type::Vec4, ..OPAQUE_COLORS };

/// Rows of equal size in a buffer.
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl Rows<'_> {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.count).map(|row| &self.bytes[row * self.stride..row * self.stride + self.size])
    }
}

/// Number of elements that an accessor claims, without reading it.
pub fn count(document: &Document, accessor: usize) -> u64 {
    document.root.accessors[accessor].count.0
}

/// Three-component vectors; `place` is what errors say uses them. They may be infinite or NaN.
pub fn vectors(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<[f32; 3]>, SceneError> {
    numbers(document, accessor, place, &VECTORS)
}

/// Four-component vectors, as [`vectors`].
pub fn fours(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<[f32; 4]>, SceneError> {
    numbers(document, accessor, place, &FOURS)
}

/// Single numbers, as [`vectors`].
pub fn scalars(document: &Document, accessor: usize, place: &str) -> Result<Vec<f32>, SceneError> {
    let rows = numbers::<1>(document, accessor, place, &SCALARS)?;
    Ok(rows.into_iter().flatten().collect())
}

/// Matrices of four by four, column by column, as [`vectors`].
pub fn matrices(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<[f32; 16]>, SceneError> {
    numbers(document, accessor, place, &MATRICES)
}

/// Rows of numbers. Integers are what they are, or shares of the largest if they are normalized.
fn numbers<const C: usize>(
    document: &Document,
    accessor: usize,
    place: &str,
    wanted: &Wanted,
) -> Result<Vec<[f32; C]>, SceneError> {
    let is_normalized = document.root.accessors[accessor].normalized;
    let row = |bytes: &[u8], component: ComponentType| {
        let size = component.size();
        std::array::from_fn(|at| number(&bytes[at * size..], component, is_normalized))
    };
    elements(document, accessor, place, (wanted, [0.0; C], row))
}

fn number(bytes: &[u8], component: ComponentType, is_normalized: bool) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let (value, largest) = match component {
        ComponentType::I8 => (f32::from(i8::from_le_bytes([bytes[0]])), f32::from(i8::MAX)),
        ComponentType::U8 => (f32::from(bytes[0]), f32::from(u8::MAX)),
        ComponentType::I16 => (f32::from(i16::from_le_bytes(two())), f32::from(i16::MAX)),
        ComponentType::U16 => (f32::from(u16::from_le_bytes(two())), f32::from(u16::MAX)),
        ComponentType::U32 | ComponentType::F32 => {
            return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        }
    };
    if is_normalized { (value / largest).max(-1.0) } else { value }
}

/// Vertex indices; `place` is what errors say uses them.
pub fn indices(document: &Document, accessor: usize, place: &str) -> Result<Vec<u32>, SceneError> {
    elements(document, accessor, place, (&INDICES, 0, index_of))
}

/// Texture coordinates; `place` is what errors say uses them. They may be infinite or NaN.
pub fn coordinates(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<Vec2>, SceneError> {
    let pairs = numbers(document, accessor, place, &COORDINATES)?;
    Ok(pairs.into_iter().map(Vec2::from_array).collect())
}

/// Colors of vertices with alpha, which is 1 where they have none; `place` is what errors say uses
/// them. They may be infinite or NaN.
pub fn colors(document: &Document, accessor: usize, place: &str) -> Result<Vec<Vec4>, SceneError> {
    let of = |bytes: &[u8], of, at| share(bytes, of, at);
    if document.root.accessors[accessor].type_ == Checked::Valid(Type::Vec4) {
        let color = |b: &[u8], c| Vec4::from_array([0, 1, 2, 3].map(|at| of(b, c, at)));
        return elements(document, accessor, place, (&COLORS, Vec4::ZERO, color));
    }
    let color = |b: &[u8], c| Vec3::from_array([0, 1, 2].map(|at| of(b, c, at))).extend(1.0);
    elements(document, accessor, place, (&OPAQUE_COLORS, Vec4::W, color))
}

/// Tangents; `place` is what errors say uses them. They may be infinite or NaN.
pub fn tangents(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<Vec4>, SceneError> {
    Ok(fours(document, accessor, place)?.into_iter().map(Vec4::from_array).collect())
}

/// One of the components of an element: a float, or an integer over the greatest of its type.
fn share(bytes: &[u8], of: ComponentType, at: usize) -> f32 {
    let bytes = &bytes[at * of.size()..];
    match of {
        ComponentType::U8 => f32::from(bytes[0]) / 255.0,
        ComponentType::U16 => f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0,
        _ => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

fn index_of(bytes: &[u8], component: ComponentType) -> u32 {
    match component {
        ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// The elements of an accessor: those of its buffer view, or zeros, and what its sparse part puts
/// in their place.
fn elements<T: Clone>(
    document: &Document,
    index: usize,
    place: &str,
    (wanted, zero, decode): (&Wanted, T, impl Fn(&[u8], ComponentType) -> T),
) -> Result<Vec<T>, SceneError> {
    let accessor = &document.root.accessors[index];
    let place = format!("{place}, {}", document.label("accessors", index));
    let shape_fits = matches!(accessor.type_, Checked::Valid(shape) if shape == wanted.shape);
    let component = match accessor.component_type {
        Checked::Valid(GenericComponentType(component))
            if shape_fits && wanted.components.contains(&component) =>
        {
            component
        }
        _ => {
            let problem = format!("must be {}", wanted.text);
            return Err(SceneError::new(&place, problem, "export it uncompressed"));
        }
    };
    let size = component.size() * wanted.shape.multiplicity();
    let decode = |bytes: &[u8]| decode(bytes, component);
    let mut values: Vec<T> = match (accessor.buffer_view, &accessor.sparse) {
        (Some(view), _) => {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let rows = rows(document, (view.value(), offset), size, accessor.count.0);
            rows.map_err(|problem| SceneError::new(&place, problem, AGAIN))?
                .iter()
                .map(decode)
                .collect()
        }
        (None, _) if accessor.count.0 > ZEROS_MAX => {
            let problem = format!("is of more than {ZEROS_MAX} zeros");
            return Err(SceneError::new(&place, problem, "use a smaller mesh"));
        }
        (None, _) => vec![zero; accessor.count.0 as usize],
    };
    if let Some(sparse) = &accessor.sparse {
        let place = format!("{place}, sparse");
        substitute(&mut values, document, (sparse, size), decode)
            .map_err(|problem| SceneError::new(place, problem, AGAIN))?;
    }
    Ok(values)
}

/// Puts the elements of a sparse accessor, of `size` bytes each, in their places.
fn substitute<T>(
    values: &mut [T],
    document: &Document,
    (sparse, size): (&Sparse, usize),
    decode: impl Fn(&[u8]) -> T,
) -> Result<(), String> {
    let component = match sparse.indices.component_type {
        Checked::Valid(IndexComponentType(component)) => component,
        Checked::Invalid => return Err(format!("its indices must be {}", INDICES.text)),
    };
    let (indices, new) = (&sparse.indices, &sparse.values);
    let at = |view: Index<View>, offset: USize64| (view.value(), offset.0);
    let indices = at(indices.buffer_view, indices.byte_offset);
    let indices = rows(document, indices, component.size(), sparse.count.0)?;
    let new = rows(document, at(new.buffer_view, new.byte_offset), size, sparse.count.0)?;
    let count = values.len();
    for (index, bytes) in indices.iter().zip(new.iter()) {
        let index = index_of(index, component);
        let Some(value) = values.get_mut(index as usize) else {
            return Err(format!("{index} is not one of the {count} elements"));
        };
        *value = decode(bytes);
    }
    Ok(())
}

/// `count` rows of `size` bytes, from an offset into a buffer view.
fn rows(
    document: &Document,
    (view, offset): (usize, u64),
    size: usize,
    count: u64,
) -> Result<Rows<'_>, String> {
    let (bytes, stride) = view_bytes(document, view, size)?;
    let end = count
        .checked_sub(1)
        .and_then(|last| last.checked_mul(stride as u64))
        .and_then(|start| start.checked_add(offset)?.checked_add(size as u64));
    match end {
        Some(end) if end <= bytes.len() as u64 => {
            Ok(Rows { bytes: &bytes[offset as usize..], stride, size, count: count as usize })
        }
        _ => {
            let have = bytes.len();
            Err(format!("{count} elements do not fit into its bufferView of {have} bytes"))
        }
    }
}

/// The bytes of a buffer view and the distance of its elements, at least `size`.
fn view_bytes(document: &Document, index: usize, size: usize) -> Result<(&[u8], usize), String> {
    let view = &document.root.buffer_views[index];
    let label = || document.label("bufferViews", index);
    let bytes = &document.buffers[view.buffer.value()];
    let start = view.byte_offset.unwrap_or_default().0;
    let end = start.checked_add(view.byte_length.0).filter(|end| *end <= bytes.len() as u64);
    let Some(end) = end else {
        let buffer = document.label("buffers", view.buffer.value());
        return Err(format!("{} reaches beyond the {} bytes of {buffer}", label(), bytes.len()));
    };
    let stride = view.byte_stride.map_or(size, |stride| stride.0);
    if stride < size || stride > 252 {
        return Err(format!("{}, byteStride: {stride} must be from {size} to 252", label()));
    }
    Ok((&bytes[start as usize..end as usize], stride))
}
