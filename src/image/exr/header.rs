//! The header of an OpenEXR file with its attributes in the order of their names. `exr` keeps them
//! in a table of no order, so that the same image would have other bytes every time.

use std::io::Cursor;

use ::exr::error::{Error, Result};
use ::exr::meta::header::Header;

/// Magic number and version.
const START: usize = 8;

/// The bytes with which a file begins, up to its table of blocks.
pub fn sorted(header: Header) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let headers = [header].into_iter().collect();
    match ::exr::block::write(&mut bytes, headers, true, |_, _| Err(Error::Aborted)) {
        Err(Error::Aborted) => {}
        other => return other.map(|()| Vec::new()),
    }
    let bytes = bytes.into_inner();
    let cut = || Error::Invalid("the header ends too early".into());
    let (start, mut rest) = bytes.split_at_checked(START).ok_or_else(cut)?;
    let mut attributes = Vec::new();
    while rest.first().is_some_and(|&byte| byte != 0) {
        let length = length_of_attribute(rest).ok_or_else(cut)?;
        let (attribute, others) = rest.split_at_checked(length).ok_or_else(cut)?;
        attributes.push(attribute);
        rest = others;
    }
    // They begin with their names, and these end with a zero.
    attributes.sort_unstable();
    Ok([&[start], &attributes[..], &[&[0]]].concat().concat())
}

/// Bytes of the attribute that comes first: its name, that of its type, both with a zero behind,
/// the length of its value in four bytes, and the value.
fn length_of_attribute(bytes: &[u8]) -> Option<usize> {
    let text = |from: usize| Some(from + bytes.get(from..)?.iter().position(|&it| it == 0)? + 1);
    let value = text(text(0)?)?;
    let length = bytes.get(value..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))?;
    Some(value + 4 + length as usize)
}
