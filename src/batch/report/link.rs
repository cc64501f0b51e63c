//! Links from a page to files, as addresses.

use std::fmt::Write;
use std::path::{Component, Path};

/// The address of a file from a folder, both without links and dots; nothing where there is no way
/// from one to the other.
pub fn link(folder: &Path, file: &Path) -> Option<String> {
    let (mut from, mut to) = (folder.components().peekable(), file.components().peekable());
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    let mut parts: Vec<String> = from.map(|_| "..".to_owned()).collect();
    for part in to {
        match part {
            Component::Normal(name) => parts.push(escaped(name.as_encoded_bytes())),
            Component::Prefix(_)
            | Component::RootDir
            | Component::CurDir
            | Component::ParentDir => return None,
        }
    }
    Some(parts.join("/"))
}

/// What a part of an address may not be is escaped by its bytes.
fn escaped(name: &[u8]) -> String {
    let mut text = String::with_capacity(name.len());
    for &byte in name {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            text.push(char::from(byte));
        } else {
            // A string takes whatever is written.
            let _ = write!(text, "%{byte:02X}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn names_are_parts_of_an_address() {
        let link = |folder: &str, file: &str| link(folder.as_ref(), file.as_ref());
        assert_eq!(link("/a/b", "/a/b/c d.exr").unwrap(), "c%20d.exr");
        assert_eq!(link("/a/b", "/a/x/100%#?.exr").unwrap(), "../x/100%25%23%3F.exr");
        assert_eq!(link("/a/b", "/ü/\"<&>.exr").unwrap(), "../../%C3%BC/%22%3C%26%3E.exr");
        assert_eq!(link("/", "/javascript:x").unwrap(), "javascript%3Ax");
    }
}
