//! Values as a page holds them: bytes, deflated (zlib), in base64.

use std::io::{self, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Values are handed over in pieces of this many.
const PIECE: usize = 1 << 14;

/// Writes a plane: 32-bit floats, least significant byte first.
pub fn push_floats(out: &mut impl Write, plane: &[f32]) -> io::Result<()> {
    // Noise hardly shrinks, whatever the effort.
    push(out, Compression::fast(), |encoder| {
        for piece in plane.chunks(PIECE) {
            let bytes: Vec<u8> = piece.iter().flat_map(|value| value.to_le_bytes()).collect();
            encoder.write_all(&bytes)?;
        }
        Ok(())
    })
}

/// Writes bytes as they are.
pub fn push_bytes(out: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    push(out, Compression::default(), |encoder| encoder.write_all(bytes))
}

fn push<W: Write>(
    out: W,
    effort: Compression,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut encoder = ZlibEncoder::new(EncoderWriter::new(out, &STANDARD), effort);
    fill(&mut encoder)?;
    encoder.finish()?.finish()?;
    Ok(())
}
