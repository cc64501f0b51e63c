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

/// What an accessor must hold.
struct Wanted {
    components: &'static [ComponentType],
    shape: Type,
    text: &'static str,
}

const VECTORS: Wanted = Wanted {
    components: &[ComponentType::F32],
    shape: Type::Vec3,
    text: "VEC3 of FLOAT (componentType 5126)",
};

const INDICES: Wanted = Wanted {
    components: &[ComponentType::U8, ComponentType::U16, ComponentType::U32],
    shape: Type::Scalar,
    text: "SCALAR of an unsigned type (componentType 5121, 5123 or 5125)",
};

/// Floats, or integers that stand for numbers from 0 to 1.
const SHARES: &[ComponentType] = &[ComponentType::F32, ComponentType::U8, ComponentType::U16];

const COORDINATES: Wanted = Wanted {
    components: SHARES,
    shape: Type::Vec2,
    text: "VEC2 of FLOAT, UNSIGNED_BYTE or UNSIGNED_SHORT",
};

const OPAQUE_COLORS: Wanted = Wanted {
    components: SHARES,
    shape: Type::Vec3,
    text: "VEC3 or VEC4 of FLOAT, UNSIGNED_BYTE or UNSIGNED_SHORT",
};

const COLORS: Wanted = Wanted { shape: Type::Vec4, ..OPAQUE_COLORS };

const TANGENTS: Wanted = Wanted {
    components: &[ComponentType::F32],
    shape: Type::Vec4,
    text: "VEC4 of FLOAT (componentType 5126)",
};

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
    let component = |bytes: &[u8], at: usize| {
        f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    };
    let vector = |b: &[u8], _| [component(b, 0), component(b, 4), component(b, 8)];
    elements(document, accessor, place, (&VECTORS, vector))
}

/// Vertex indices; `place` is what errors say uses them.
pub fn indices(document: &Document, accessor: usize, place: &str) -> Result<Vec<u32>, SceneError> {
    elements(document, accessor, place, (&INDICES, index_of))
}

/// Texture coordinates; `place` is what errors say uses them. They may be infinite or NaN.
pub fn coordinates(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<Vec2>, SceneError> {
    let pair = |bytes: &[u8], of| Vec2::from_array([0, 1].map(|at| share(bytes, of, at)));
    elements(document, accessor, place, (&COORDINATES, pair))
}

/// Colors of vertices with alpha, which is 1 where they have none; `place` is what errors say uses
/// them. They may be infinite or NaN.
pub fn colors(document: &Document, accessor: usize, place: &str) -> Result<Vec<Vec4>, SceneError> {
    let of = |bytes: &[u8], of, at| share(bytes, of, at);
    if document.root.accessors[accessor].type_ == Checked::Valid(Type::Vec4) {
        let color = |b: &[u8], c| Vec4::from_array([0, 1, 2, 3].map(|at| of(b, c, at)));
        return elements(document, accessor, place, (&COLORS, color));
    }
    let color = |b: &[u8], c| Vec3::from_array([0, 1, 2].map(|at| of(b, c, at))).extend(1.0);
    elements(document, accessor, place, (&OPAQUE_COLORS, color))
}

/// Tangents; `place` is what errors say uses them. They may be infinite or NaN.
pub fn tangents(
    document: &Document,
    accessor: usize,
    place: &str,
) -> Result<Vec<Vec4>, SceneError> {
    let tangent = |b: &[u8], of| Vec4::from_array([0, 1, 2, 3].map(|at| share(b, of, at)));
    elements(document, accessor, place, (&TANGENTS, tangent))
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
fn elements<T: Clone + Default>(
    document: &Document,
    index: usize,
    place: &str,
    (wanted, decode): (&Wanted, impl Fn(&[u8], ComponentType) -> T),
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
        (None, Some(_)) => vec![T::default(); accessor.count.0 as usize],
        (None, None) => return Err(SceneError::new(&place, "has no bufferView", AGAIN)),
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
