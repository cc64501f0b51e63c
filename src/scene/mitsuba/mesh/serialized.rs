//! Mitsuba's own meshes, of versions 3 and 4: several in a file, each compressed by zlib.

use std::io::Read;

use flate2::read::ZlibDecoder;
use glam::{Vec2, Vec3};

use super::bytes::Bytes;
use super::{ELEMENTS_MAX, Soup};

const MAGIC: u16 = 0x041c;
const HAS_NORMALS: u32 = 0x1;
const HAS_TEXTURE_COORDINATES: u32 = 0x2;
const HAS_COLORS: u32 = 0x8;
const DOUBLE_PRECISION: u32 = 0x2000;
/// Most bytes of a mesh.
const BYTES_MAX: u64 = 1 << 32;

/// Reads the mesh of an index, counted from 0; what is wrong otherwise.
pub fn read(bytes: &[u8], index: usize) -> Result<Soup, String> {
    let mut header = Bytes::new(bytes, false);
    let magic = header.take().map(u16::from_le_bytes);
    let version = header.take().map(u16::from_le_bytes);
    let (Some(MAGIC), Some(version)) = (magic, version) else {
        return Err("is no file of serialized meshes".to_owned());
    };
    if !(3..=4).contains(&version) {
        return Err(format!("is of version {version}, and 3 and 4 are known"));
    }
    let from = start(bytes, index, version)?;
    let packed = bytes.get(from..).and_then(|rest| rest.get(4..)).ok_or("has been cut off")?;
    let mut unpacked = Vec::new();
    // Behind the mesh is the next one: what matters is that this one is whole.
    let decoded = ZlibDecoder::new(packed).take(BYTES_MAX).read_to_end(&mut unpacked);
    let soup = mesh(&unpacked, version);
    match (soup, decoded) {
        (Some(soup), _) => check(soup),
        (None, Err(error)) => Err(format!("cannot be unpacked: {error}")),
        (None, Ok(_)) => Err("ends before its last number".to_owned()),
    }
}

/// Where the mesh of an index begins: at the end of the file is a list.
fn start(bytes: &[u8], index: usize, version: u16) -> Result<usize, String> {
    if index == 0 {
        return Ok(0);
    }
    let from_end =
        |count: usize| Some(Bytes::new(bytes.get(bytes.len().checked_sub(count)?..)?, false));
    let count = from_end(4).and_then(|mut end| end.take()).map(u32::from_le_bytes);
    let count = count.unwrap_or_default() as usize;
    let Some(behind) = count.checked_sub(index).filter(|behind| *behind > 0) else {
        return Err(format!("has no mesh {index}: it has {count}"));
    };
    let width = if version >= 4 { 8 } else { 4 };
    let entry = behind.checked_mul(width).and_then(|size| from_end(size + 4));
    let offset = entry.and_then(|mut entry| match version {
        4.. => entry.take().map(u64::from_le_bytes),
        _ => entry.take().map(|bytes| u32::from_le_bytes(bytes).into()),
    });
    let offset = offset.and_then(|offset| usize::try_from(offset).ok());
    offset.ok_or_else(|| "its list of meshes has been cut off".to_owned())
}

fn mesh(bytes: &[u8], version: u16) -> Option<Soup> {
    let mut bytes = Bytes::new(bytes, false);
    let flags = u32::from_le_bytes(bytes.take()?);
    if version >= 4 {
        // Its name.
        while bytes.take::<1>()? != [0] {}
    }
    let mut count = || usize::try_from(u64::from_le_bytes(bytes.take()?)).ok();
    let (vertices, triangles) = (count()?, count()?);
    if vertices > ELEMENTS_MAX || triangles > ELEMENTS_MAX {
        return None;
    }
    let width = if flags & DOUBLE_PRECISION == 0 { 4 } else { 8 };
    let mut soup = Soup::default();
    soup.geometry.positions = vectors(&mut bytes, vertices, width)?;
    if flags & HAS_NORMALS != 0 {
        soup.geometry.normals = vectors(&mut bytes, vertices, width)?;
    }
    if flags & HAS_TEXTURE_COORDINATES != 0 {
        let pairs = rows::<2>(&mut bytes, vertices, width)?;
        soup.geometry.texture_coordinates = pairs.into_iter().map(Vec2::from).collect();
    }
    if flags & HAS_COLORS != 0 {
        bytes.skip(vertices * 3 * width)?;
    }
    if bytes.left() < triangles * 12 {
        return None;
    }
    let mut corner = || bytes.take().map(u32::from_le_bytes);
    let rows = (0..triangles).map(|_| Some([corner()?, corner()?, corner()?]));
    soup.geometry.triangles = rows.collect::<Option<_>>()?;
    Some(soup)
}

fn vectors(bytes: &mut Bytes, count: usize, width: usize) -> Option<Vec<Vec3>> {
    Some(rows::<3>(bytes, count, width)?.into_iter().map(Vec3::from).collect())
}

fn rows<const K: usize>(bytes: &mut Bytes, count: usize, width: usize) -> Option<Vec<[f32; K]>> {
    if bytes.left() < count * K * width {
        return None;
    }
    let mut number = || match width {
        4 => bytes.take().map(f32::from_le_bytes),
        _ => bytes.take().map(|bytes| f64::from_le_bytes(bytes) as f32),
    };
    let mut row = || {
        let mut row = [0.0; K];
        for value in &mut row {
            *value = number()?;
        }
        Some(row)
    };
    (0..count).map(|_| row()).collect()
}

fn check(soup: Soup) -> Result<Soup, String> {
    let count = soup.geometry.positions.len();
    let mut corners = soup.geometry.triangles.as_flattened().iter();
    match corners.find(|corner| **corner as usize >= count) {
        Some(corner) => Err(format!("{corner} is not one of the {count} vertices")),
        None => Ok(soup),
    }
}
