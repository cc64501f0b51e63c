//! Files of named facts and columns of numbers, with a checksum over all: what a film has summed,
//! on its way to another process.
//!
//! A line that says what it is, the length of the head, the head (JSON: facts, then the columns'
//! names, types and lengths), the columns in its order, little-endian, and the BLAKE3 digest of all
//! before it. A file is written as a whole or not at all, and read only if its digest is right.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::image::{OutputError, atomic};

/// What such files begin with; the number is that of the format.
const MAGIC: &[u8] = b"sunstone part 1\n";
/// How much of it is before the number.
const MAGIC_OF_ALL: usize = MAGIC.len() - 2;
/// What errors call the format.
const FORMAT: &str = "part";
/// Longest head in bytes; no honest one is nearly as long.
const HEAD_MAX: u64 = 1 << 20;
/// Bytes of the digest at the end.
const DIGEST: u64 = blake3::OUT_LEN as u64;
/// Bytes that are read or written at once.
const PIECE: usize = 1 << 20;

/// A name and what is known by it.
pub type Fact = (String, String);

/// A column on its way into a file.
#[derive(Clone, Copy)]
pub enum Column<'a> {
    /// In double precision.
    Doubles(&'a [f64]),
    /// In single precision.
    Singles(&'a [f32]),
}

#[derive(Deserialize, Serialize)]
struct Head {
    facts: Vec<Fact>,
    columns: Vec<Listed>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
struct Listed {
    name: String,
    kind: Kind,
    length: u64,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    F64,
    F32,
}

impl Kind {
    fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
        }
    }
}

impl Column<'_> {
    fn listed(self, name: &str) -> Listed {
        let (kind, length) = match self {
            Self::Doubles(values) => (Kind::F64, values.len()),
            Self::Singles(values) => (Kind::F32, values.len()),
        };
        Listed { name: name.to_owned(), kind, length: length as u64 }
    }

    /// Writes the numbers in little-endian order, whatever the machine's.
    fn write(self, to: &mut impl Write) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(PIECE);
        match self {
            Self::Doubles(values) => values.chunks(PIECE / 8).try_for_each(|values| {
                bytes.clear();
                values.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
                to.write_all(&bytes)
            }),
            Self::Singles(values) => values.chunks(PIECE / 4).try_for_each(|values| {
                bytes.clear();
                values.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
                to.write_all(&bytes)
            }),
        }
    }
}

/// Writes facts and columns to a file, which appears when it is complete and on the disk.
///
/// # Errors
/// What the system says.
pub fn write(
    path: &Path,
    facts: Vec<Fact>,
    columns: &[(String, Column)],
) -> Result<(), OutputError> {
    let listed = columns.iter().map(|(name, column)| column.listed(name)).collect();
    let head = serde_json::to_vec(&Head { facts, columns: listed })
        .map_err(|error| OutputError::unwritable(path, error))?;
    atomic::write_with(path, |file| {
        let mut to = Digesting { to: file, digest: blake3::Hasher::new() };
        to.write_all(MAGIC)?;
        to.write_all(&(head.len() as u64).to_le_bytes())?;
        to.write_all(&head)?;
        columns.iter().try_for_each(|(_, column)| column.write(&mut to))?;
        let Digesting { to, digest } = to;
        to.write_all(digest.finalize().as_bytes())
    })
}

/// Digests what it writes.
struct Digesting<W> {
    to: W,
    digest: blake3::Hasher,
}

impl<W: Write> Write for Digesting<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.to.write(bytes)?;
        self.digest.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// A file that has been found whole; columns are read from it when they are asked for.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    file: File,
    facts: Vec<Fact>,
    columns: Vec<Listed>,
    /// Where the first column begins.
    start: u64,
}

impl Record {
    /// Whether a file begins as one, of whatever version.
    pub fn is_one(path: &Path) -> bool {
        let mut magic = [0; MAGIC_OF_ALL];
        // What is no file may never end, or never begin.
        std::fs::metadata(path).is_ok_and(|found| found.is_file())
            && File::open(path).is_ok_and(|mut file| file.read_exact(&mut magic).is_ok())
            && magic == MAGIC[..MAGIC_OF_ALL]
    }

    /// Opens a file and reads all of it once, for its digest.
    ///
    /// # Errors
    /// When it cannot be read, is none of these or not whole: with what is wrong.
    pub fn open(path: &Path) -> Result<Self, OutputError> {
        let failed = |error| OutputError::read(path, error);
        let damaged = |reason: &str| OutputError::malformed(path, FORMAT, reason);
        if !std::fs::metadata(path).map_err(failed)?.is_file() {
            return Err(damaged("it is not a file"));
        }
        let mut file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut magic = [0; MAGIC.len()];
        let is_part = file.read_exact(&mut magic).is_ok() && magic == *MAGIC;
        if !is_part {
            return Err(damaged(match magic[..MAGIC_OF_ALL] == MAGIC[..MAGIC_OF_ALL] {
                true => "it is of another version of the format: use the program that wrote it",
                false => "it does not begin as what `render --part` and --checkpoint write",
            }));
        }
        if !is_whole(&mut file, length).map_err(failed)? {
            return Err(damaged("it is damaged: its checksum is wrong"));
        }
        let (head, start) = head_of(&mut file).map_err(failed)?;
        let head: Head = serde_json::from_slice(&head).map_err(|error| {
            OutputError::malformed(path, FORMAT, format!("its head is wrong: {error}"))
        })?;
        let bytes = |listed: &Listed| listed.length.checked_mul(listed.kind.bytes());
        let all =
            head.columns.iter().try_fold(start + DIGEST, |sum, it| sum.checked_add(bytes(it)?));
        if all != Some(length) {
            return Err(damaged("its columns are not those that its head lists"));
        }
        let Head { facts, columns } = head;
        Ok(Self { path: path.to_owned(), file, facts, columns, start })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// All facts, in the order in which they were written.
    pub fn facts(&self) -> &[Fact] {
        &self.facts
    }

    /// What is known by a name.
    pub fn fact(&self, name: &str) -> Option<&str> {
        self.facts.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// A number that is known by a name.
    ///
    /// # Errors
    /// When there is none.
    pub fn number(&self, name: &str) -> Result<u32, OutputError> {
        let number = self.fact(name).and_then(|value| value.parse().ok());
        number.ok_or_else(|| self.lacks(name))
    }

    /// Whether there is a column of a name.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// The numbers of a column, which the file is as long as to have.
    ///
    /// # Errors
    /// When there is none.
    pub fn length(&self, name: &str) -> Result<u64, OutputError> {
        let column = self.columns.iter().find(|column| column.name == name);
        column.map(|column| column.length).ok_or_else(|| self.lacks(name))
    }

    /// Reads a column of `count` numbers in double precision.
    ///
    /// # Errors
    /// When there is none, of this type and length, or the system refuses.
    pub fn doubles(&mut self, name: &str, count: usize) -> Result<Vec<f64>, OutputError> {
        self.read(name, Kind::F64, count, |bytes: [u8; 8]| f64::from_le_bytes(bytes))
    }

    /// Reads a column of `count` numbers in single precision.
    ///
    /// # Errors
    /// When there is none, of this type and length, or the system refuses.
    pub fn singles(&mut self, name: &str, count: usize) -> Result<Vec<f32>, OutputError> {
        self.read(name, Kind::F32, count, |bytes: [u8; 4]| f32::from_le_bytes(bytes))
    }

    /// What is wrong with a file that lacks something.
    pub fn lacks(&self, name: &str) -> OutputError {
        self.is_wrong(format!("it lacks `{name}`"))
    }

    /// A file with something wrong in it.
    pub fn is_wrong(&self, what: String) -> OutputError {
        OutputError::malformed(&self.path, FORMAT, what)
    }

    fn read<T, const BYTES: usize>(
        &mut self,
        name: &str,
        kind: Kind,
        count: usize,
        number: impl Fn([u8; BYTES]) -> T,
    ) -> Result<Vec<T>, OutputError> {
        let before = self.columns.iter().take_while(|column| column.name != name);
        let start = before.fold(self.start, |sum, it| sum + it.length * it.kind.bytes());
        let is_it = |it: &&Listed| it.name == name && it.kind == kind && it.length == count as u64;
        if !self.columns.iter().any(|column| is_it(&column)) {
            return Err(self.lacks(name));
        }
        let read = || -> io::Result<Vec<T>> {
            let mut from = BufReader::with_capacity(PIECE, &self.file);
            from.seek(SeekFrom::Start(start))?;
            let next = |_| {
                let mut bytes = [0; BYTES];
                from.read_exact(&mut bytes).map(|()| number(bytes))
            };
            (0..count).map(next).collect()
        };
        read().map_err(|error| OutputError::read(&self.path, error))
    }
}

/// Whether the digest at the end of a file is that of what is before.
fn is_whole(file: &mut File, length: u64) -> io::Result<bool> {
    let Some(digested) = length.checked_sub(DIGEST) else { return Ok(false) };
    file.seek(SeekFrom::Start(0))?;
    let mut from = BufReader::with_capacity(PIECE, &mut *file);
    let mut digest = blake3::Hasher::new();
    digest.update_reader(from.by_ref().take(digested))?;
    let mut stated = [0; blake3::OUT_LEN];
    match from.read_exact(&mut stated) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        read => read.map(|()| digest.finalize() == stated),
    }
}

/// The head of a file that is whole, and where it ends.
fn head_of(file: &mut File) -> io::Result<(Vec<u8>, u64)> {
    file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
    let mut length = [0; 8];
    file.read_exact(&mut length)?;
    let length = u64::from_le_bytes(length).min(HEAD_MAX);
    let mut head = vec![0; length as usize];
    file.read_exact(&mut head)?;
    Ok((head, MAGIC.len() as u64 + 8 + length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(name: &str) -> PathBuf {
        let path =
            std::env::temp_dir().join(format!("sunstone-{}-{name}.part", std::process::id()));
        let facts = vec![("seed".to_owned(), "7".to_owned())];
        let doubles = Column::Doubles(&[1.5, -0.0, f64::MIN_POSITIVE]);
        let singles = Column::Singles(&[0.1, 3.0]);
        write(&path, facts, &[("a".to_owned(), doubles), ("b".to_owned(), singles)]).unwrap();
        path
    }

    #[test]
    fn what_is_written_is_read() {
        let path = written("read");
        let mut record = Record::open(&path).unwrap();
        assert_eq!(record.number("seed").unwrap(), 7);
        assert_eq!(record.singles("b", 2).unwrap(), [0.1, 3.0]);
        let doubles = record.doubles("a", 3).unwrap();
        let bits = doubles.iter().map(|value| value.to_bits());
        assert!(bits.eq([1.5, -0.0, f64::MIN_POSITIVE].map(f64::to_bits)));
        assert!(record.has("a") && !record.has("c"));
        for error in [record.doubles("b", 2).unwrap_err(), record.singles("b", 3).unwrap_err()] {
            assert!(error.to_string().ends_with("it lacks `b`"), "{error}");
        }
        std::fs::remove_file(path).unwrap();
    }

    /// Every byte of it: changed, it is found.
    #[test]
    fn no_damage_is_taken_for_numbers() {
        let path = written("damaged");
        let whole = std::fs::read(&path).unwrap();
        for index in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[index] ^= 1;
            std::fs::write(&path, &damaged).unwrap();
            assert!(Record::open(&path).is_err(), "byte {index}");
            std::fs::write(&path, &whole[..index]).unwrap();
            assert!(Record::open(&path).is_err(), "cut at {index}");
        }
        std::fs::remove_file(path).unwrap();
    }
}
