//! Reading vertex attributes and indices out of buffers, with every bound checked.

use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::validation::Checked;

use super::document::Document;
use crate::scene::error::SceneError;

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

/// The elements of an accessor as bytes.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
    component: ComponentType,
}

impl Elements<'_> {
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
    let elements = elements(document, accessor, place, &VECTORS)?;
    let component = |bytes: &[u8], at: usize| {
        f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    };
    Ok(elements.iter().map(|b| [component(b, 0), component(b, 4), component(b, 8)]).collect())
}

/// Vertex indices; `place` is what errors say uses them.
pub fn indices(document: &Document, accessor: usize, place: &str) -> Result<Vec<u32>, SceneError> {
    let elements = elements(document, accessor, place, &INDICES)?;
    let index = |bytes: &[u8]| match elements.component {
        ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    };
    Ok(elements.iter().map(index).collect())
}

fn elements<'a>(
    document: &'a Document,
    index: usize,
    place: &str,
    wanted: &Wanted,
) -> Result<Elements<'a>, SceneError> {
    let accessor = &document.root.accessors[index];
    let place = format!("{place}, {}", document.label("accessors", index));
    let refuse = |problem: String, remedy: &str| SceneError::new(&place, problem, remedy);
    let shape_fits = matches!(accessor.type_, Checked::Valid(shape) if shape == wanted.shape);
    let component = match accessor.component_type {
        Checked::Valid(GenericComponentType(component))
            if shape_fits && wanted.components.contains(&component) =>
        {
            component
        }
        _ => return Err(refuse(format!("must be {}", wanted.text), "export it uncompressed")),
    };
    if accessor.sparse.is_some() {
        return Err(refuse("is sparse".to_owned(), "export without sparse accessors"));
    }
    let Some(view) = accessor.buffer_view else {
        return Err(refuse("has no bufferView".to_owned(), "export the scene again"));
    };
    let size = component.size() * wanted.shape.multiplicity();
    let (bytes, stride) = view_bytes(document, view.value(), size)?;
    let offset = accessor.byte_offset.unwrap_or_default().0;
    let count = accessor.count.0;
    let end = count
        .checked_sub(1)
        .and_then(|last| last.checked_mul(stride as u64))
        .and_then(|start| start.checked_add(offset)?.checked_add(size as u64));
    match end {
        Some(end) if end <= bytes.len() as u64 => Ok(Elements {
            bytes: &bytes[offset as usize..],
            stride,
            size,
            count: count as usize,
            component,
        }),
        _ => {
            let have = bytes.len();
            let problem =
                format!("{count} elements do not fit into its bufferView of {have} bytes");
            Err(refuse(problem, "export the scene again"))
        }
    }
}

/// The bytes of a buffer view and the distance of its elements, at least `size`.
fn view_bytes(
    document: &Document,
    index: usize,
    size: usize,
) -> Result<(&[u8], usize), SceneError> {
    let view = &document.root.buffer_views[index];
    let label = || document.label("bufferViews", index);
    let bytes = &document.buffers[view.buffer.value()];
    let start = view.byte_offset.unwrap_or_default().0;
    let end = start.checked_add(view.byte_length.0).filter(|end| *end <= bytes.len() as u64);
    let Some(end) = end else {
        let buffer = document.label("buffers", view.buffer.value());
        let problem = format!("reaches beyond the {} bytes of {buffer}", bytes.len());
        return Err(SceneError::new(label(), problem, "export the scene again"));
    };
    let stride = view.byte_stride.map_or(size, |stride| stride.0);
    if stride < size || stride > 252 {
        let place = format!("{}, byteStride", label());
        let problem = format!("{stride} must be from {size} to 252");
        return Err(SceneError::new(place, problem, "export the scene again"));
    }
    Ok((&bytes[start as usize..end as usize], stride))
}
