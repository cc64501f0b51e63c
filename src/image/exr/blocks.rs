//! The blocks of an OpenEXR file: sixteen rows, packed as its ZIP compression does.
//!
//! The rows of all channels -> the even bytes of all numbers, then the odd ones -> differences
//! between neighboring bytes -> zlib (`deflate`). A block that does not shrink is stored as it is.
//!
//! `exr` would do all of it, at a fixed level of a deflate that takes five times as long for the
//! same size.

use std::io::{Seek, Write};
use std::ops::Range;

use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::writer::ChunksWriter;
use ::exr::error::Result;
use ::exr::meta::header::Header;
use ::exr::prelude::Compression;
use rayon::prelude::*;

use super::deflate::Deflater;
use super::header;
use crate::image::rows::Rows;

/// Rows of a block.
const ROWS: usize = Compression::ZIP16.scan_lines_per_block();
/// Bytes of all numbers up to which an image is packed where it is: threads would take longer.
const SMALL: usize = 1 << 20;
/// Bytes of buffers that may be at work whatever the size of the image; of a larger one, a
/// sixteenth of its blocks.
const AT_WORK: usize = 16 << 20;
/// Writes a file: its header, and the blocks of an image in their order. `planes` are the places
/// of the header's channels among the numbers of a row, in planes.
pub fn write<W: Write + Seek>(
    to: &mut W,
    header: Header,
    image: &dyn Rows,
    planes: &[usize],
) -> Result<()> {
    let sorted = header::sorted(header.clone())?;
    let top = header.own_attributes.layer_position.y();
    ::exr::block::write(&mut *to, [header].into_iter().collect(), true, |_, writer| {
        let height = image.frame().height;
        let count = writer.total_chunks_count();
        let bytes_of_block = bytes_of_rows(image, planes, ROWS.min(height));
        let is_small = count * bytes_of_block <= SMALL;
        // A block is there as numbers, as differences and as what becomes of them.
        let at_once = (AT_WORK / (3 * bytes_of_block)).max(count / 16).max(1);
        let rows_of = |block: usize| block * ROWS..height.min((block + 1) * ROWS);
        let mut packer = Packer::new(image, planes);
        for first in (0..count).step_by(at_once) {
            let blocks = first..count.min(first + at_once);
            let packed: Vec<Vec<u8>> = match is_small {
                true => blocks.clone().map(|block| packer.pack(rows_of(block))).collect(),
                false => (blocks.clone().into_par_iter())
                    .map_init(|| Packer::new(image, planes), |it, block| it.pack(rows_of(block)))
                    .collect(),
            };
            for (block, compressed_pixels_le) in blocks.zip(packed) {
                let y_coordinate = top + i32::try_from(rows_of(block).start)?;
                let lines = CompressedScanLineBlock { y_coordinate, compressed_pixels_le };
                let compressed_block = CompressedBlock::ScanLine(lines);
                writer.write_chunk(block, Chunk { layer_index: 0, compressed_block })?;
            }
        }
        Ok(())
    })?;
    // It has the same length.
    to.rewind()?;
    Ok(to.write_all(&sorted)?)
}

fn bytes_of_rows(image: &dyn Rows, planes: &[usize], rows: usize) -> usize {
    rows * planes.len() * image.frame().width * size_of::<f32>()
}

/// Packs one block after the other, in the same memory.
struct Packer<'a> {
    image: &'a dyn Rows,
    planes: &'a [usize],
    deflater: Deflater,
    numbers: Vec<f32>,
    halves: Vec<u8>,
    differences: Vec<u8>,
}

impl<'a> Packer<'a> {
    fn new(image: &'a dyn Rows, planes: &'a [usize]) -> Self {
        let numbers = vec![0.0; image.frame().numbers_of_row()];
        let (halves, differences) = (Vec::new(), Vec::new());
        Self { image, planes, deflater: Deflater::new(), numbers, halves, differences }
    }

    /// The bytes of some rows as they stand in the file.
    fn pack(&mut self, rows: Range<usize>) -> Vec<u8> {
        self.split(rows.clone());
        let Self { deflater, halves, differences, .. } = self;
        differences.clear();
        differences.extend(halves.first());
        let difference = |pair: &[u8]| pair[1].wrapping_sub(pair[0]).wrapping_add(128);
        differences.extend(halves.windows(2).map(difference));
        let strip = size_of::<[u8; 2]>() * self.image.frame().width;
        match deflater.pack(differences, strip, self.planes.len()) {
            // Whoever reads takes a block of full length for one that is not packed.
            Some(packed) if packed.len() < differences.len() => packed.to_vec(),
            Some(_) | None => self.plain(rows),
        }
    }

    /// The even bytes of all numbers, as they follow each other in the file, then the odd ones.
    fn split(&mut self, rows: Range<usize>) {
        let bytes = bytes_of_rows(self.image, self.planes, rows.len());
        self.halves.resize(bytes, 0);
        let (even, odd) = self.halves.split_at_mut(bytes / 2);
        let width = self.image.frame().width;
        let even = even.as_chunks_mut().0.chunks_exact_mut(width);
        let mut places = even.zip(odd.as_chunks_mut().0.chunks_exact_mut(width));
        for y in rows {
            self.image.row(y, &mut self.numbers);
            for (plane, (even, odd)) in self.planes.iter().zip(&mut places) {
                let numbers = &self.numbers[plane * width..][..width];
                for ((even, odd), number) in even.iter_mut().zip(odd).zip(numbers) {
                    // Shifts and masks, which processors do to many numbers at a time.
                    let bits = number.to_bits();
                    *even = ((bits & 0xff | bits >> 8 & 0xff00) as u16).to_le_bytes();
                    *odd = ((bits >> 8 & 0xff | bits >> 16 & 0xff00) as u16).to_le_bytes();
                }
            }
        }
    }

    /// The bytes of all numbers, not packed.
    fn plain(&mut self, rows: Range<usize>) -> Vec<u8> {
        let width = self.image.frame().width;
        let mut bytes = Vec::with_capacity(bytes_of_rows(self.image, self.planes, rows.len()));
        for y in rows {
            self.image.row(y, &mut self.numbers);
            for plane in self.planes {
                let numbers = &self.numbers[plane * width..][..width];
                bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
            }
        }
        bytes
    }
}
