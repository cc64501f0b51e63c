//! Files of tensors: arrays of numbers by name, as Mitsuba 3 writes them (`.pbsdf`, `.bsdf`).
//!
//! All is little-endian. Behind `tensor_file` and a zero stand two bytes of the version, 1 and 0,
//! and the number of fields (32 bits); then for every field the length of its name (16 bits) and
//! the name, the number of its dimensions (16 bits), how its numbers are stored (8 bits), where
//! they begin in the file (64 bits), and the extent of every dimension (64 bits), of which the last
//! varies fastest.

use std::fmt;

const MAGIC: &[u8] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stored {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
}

impl Stored {
    /// In the order of their numbers in files, from 1 on.
    const ALL: [Self; 11] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F16,
        Self::F32,
        Self::F64,
    ];

    fn width(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// An array.
#[derive(Clone, Debug)]
pub struct Field {
    /// What it is called.
    pub name: String,
    /// The extents of its dimensions, the fastest last.
    pub shape: Vec<usize>,
    stored: Stored,
    /// Of its first number, in bytes.
    start: usize,
}

impl Field {
    /// How many numbers there are.
    pub fn count(&self) -> usize {
        self.shape.iter().product()
    }
}

/// A file of tensors, as it is.
pub struct Tensors {
    bytes: Vec<u8>,
    fields: Vec<Field>,
}

impl Tensors {
    /// Those in some bytes, which are kept as they are; what is wrong with them otherwise.
    ///
    /// # Errors
    /// With what is wrong, to follow the name of the file.
    pub fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let fields = Self::fields_of(&bytes)?;
        Ok(Self { bytes, fields })
    }

    fn fields_of(bytes: &[u8]) -> Result<Vec<Field>, String> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err("is no file of tensors".to_owned());
        };
        let mut rest = Rest(rest);
        let cut = || "has been cut off".to_owned();
        let version: [u8; 2] = rest.take().ok_or_else(cut)?;
        if version != VERSION {
            let [major, minor] = version;
            return Err(format!("is of version {major}.{minor}, and 1.0 is known"));
        }
        let count = u32::from_le_bytes(rest.take().ok_or_else(cut)?);
        let mut fields = Vec::new();
        for _ in 0..count {
            let field = rest.field().ok_or_else(cut)??;
            let width = field.stored.width();
            let product = |all: usize, extent: &usize| all.checked_mul(*extent);
            let size = field.shape.iter().try_fold(width, product);
            let end = size.and_then(|size| field.start.checked_add(size));
            if end.is_none_or(|end| end > bytes.len()) {
                let (name, shape) = (&field.name, &field.shape);
                return Err(format!("ends within its field `{name}` of {shape:?} numbers"));
            }
            fields.push(field);
        }
        Ok(fields)
    }

    /// All of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The names of the fields.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.name.as_str())
    }

    /// The field of a name.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// A number of a field of this file, counted through all dimensions.
    ///
    /// # Panics
    /// Behind the end of the file.
    #[inline]
    pub fn number(&self, field: &Field, index: usize) -> f64 {
        let bytes = &self.bytes[field.start + index * field.stored.width()..];
        match field.stored {
            Stored::U8 => f64::from(bytes[0]),
            Stored::I8 => f64::from(bytes[0] as i8),
            Stored::U16 => f64::from(u16::from_le_bytes(first(bytes))),
            Stored::I16 => f64::from(i16::from_le_bytes(first(bytes))),
            Stored::U32 => f64::from(u32::from_le_bytes(first(bytes))),
            Stored::I32 => f64::from(i32::from_le_bytes(first(bytes))),
            Stored::U64 => u64::from_le_bytes(first(bytes)) as f64,
            Stored::I64 => i64::from_le_bytes(first(bytes)) as f64,
            Stored::F16 => half(u16::from_le_bytes(first(bytes))),
            Stored::F32 => f64::from(f32::from_le_bytes(first(bytes))),
            Stored::F64 => f64::from_le_bytes(first(bytes)),
        }
    }
}

/// The fields, without their numbers.
impl fmt::Debug for Tensors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tensors").field("fields", &self.fields).finish_non_exhaustive()
    }
}

#[inline]
fn first<const K: usize>(bytes: &[u8]) -> [u8; K] {
    std::array::from_fn(|index| bytes[index])
}

/// A number of IEEE 754's binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    match exponent {
        0 => sign * fraction * 2.0_f64.powi(-14),
        31 if fraction == 0.0 => sign * f64::INFINITY,
        31 => f64::NAN,
        1..=30 => sign * (1.0 + fraction) * 2.0_f64.powi(exponent - 15),
        _ => unreachable!("five bits"),
    }
}

/// What of the head has not been read.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn take<const K: usize>(&mut self) -> Option<[u8; K]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn field(&mut self) -> Option<Result<Field, String>> {
        let length = usize::from(u16::from_le_bytes(self.take()?));
        let (name, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        let name = String::from_utf8_lossy(name).into_owned();
        let dimensions = u16::from_le_bytes(self.take()?);
        let [stored] = self.take()?;
        let start = u64::from_le_bytes(self.take()?) as usize;
        let extent = |_| Some(u64::from_le_bytes(self.take()?) as usize);
        let shape = (0..dimensions).map(extent).collect::<Option<Vec<usize>>>()?;
        let known = usize::from(stored).checked_sub(1).and_then(|at| Stored::ALL.get(at));
        Some(match known {
            Some(&stored) => Ok(Field { name, shape, stored, start }),
            None => Err(format!("has a field `{name}` of unknown numbers ({stored})")),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(fields: &[(&str, u8, &[u64], &[u8])]) -> Vec<u8> {
        let mut head = [MAGIC, &VERSION, &(fields.len() as u32).to_le_bytes()].concat();
        let size: usize =
            fields.iter().map(|(name, _, shape, _)| 13 + name.len() + 8 * shape.len()).sum();
        let mut at = head.len() + size;
        let mut data = Vec::new();
        for (name, stored, shape, bytes) in fields {
            head.extend((name.len() as u16).to_le_bytes());
            head.extend(name.as_bytes());
            head.extend((shape.len() as u16).to_le_bytes());
            head.push(*stored);
            head.extend((at as u64).to_le_bytes());
            head.extend(shape.iter().flat_map(|extent| extent.to_le_bytes()));
            data.extend_from_slice(bytes);
            at += bytes.len();
        }
        [head, data].concat()
    }

    #[test]
    fn numbers_of_all_widths_are_read() {
        let f16 = [0x3c00_u16, 0xc000, 0x0001, 0x7c00, 0x3555].map(u16::to_le_bytes).concat();
        let bytes = file(&[
            ("bytes", 1, &[3], &[0, 7, 255]),
            ("signed", 2, &[1], &[254]),
            ("short", 4, &[1], &(-300_i16).to_le_bytes()),
            ("long", 7, &[1], &(1_u64 << 40).to_le_bytes()),
            ("half", 9, &[5], &f16),
            ("single", 10, &[1, 2], &[0.5_f32, -0.25].map(f32::to_le_bytes).concat()),
            ("double", 11, &[], &0.1_f64.to_le_bytes()),
        ]);
        let tensors = Tensors::new(bytes).unwrap();
        let all = |name: &str| -> Vec<f64> {
            let field = tensors.field(name).unwrap();
            (0..field.count()).map(|index| tensors.number(field, index)).collect()
        };
        assert_eq!(all("bytes"), [0.0, 7.0, 255.0]);
        assert_eq!([all("signed"), all("short")], [[-2.0], [-300.0]]);
        assert_eq!(all("long"), [(1_u64 << 40) as f64]);
        assert_eq!(all("half"), [1.0, -2.0, 2.0_f64.powi(-24), f64::INFINITY, 0.333_251_953_125]);
        assert_eq!((all("single"), all("double")), (vec![0.5, -0.25], vec![0.1]));
        assert_eq!(tensors.field("single").unwrap().shape, [1, 2]);
        assert!(tensors.field("none").is_none());
        assert_eq!(tensors.names().count(), 7);
    }

    #[test]
    fn files_that_are_none_say_what_they_are() {
        let whole = file(&[("M", 10, &[2, 2], &[0; 16])]);
        for length in 0..whole.len() {
            assert!(Tensors::new(whole[..length].to_vec()).is_err(), "{length}");
        }
        assert!(Tensors::new(whole.clone()).is_ok());
        let wrong = |at: usize, byte: u8| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            Tensors::new(bytes).unwrap_err()
        };
        assert!(wrong(0, b'T').contains("no file of tensors"));
        assert!(wrong(12, 2).contains("version 2.0"));
        assert!(wrong(23, 12).contains("unknown numbers (12)"));
        let huge = file(&[("M", 10, &[u64::MAX, u64::MAX], &[0; 16])]);
        assert!(Tensors::new(huge).unwrap_err().contains("ends within its field `M`"));
    }
}
