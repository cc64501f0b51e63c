//! Planes as the page holds them: 32-bit floats, least significant byte first, deflated (zlib), in
//! base64.

use std::io::{self, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Values are handed over in pieces of this many.
const PIECE: usize = 1 << 14;

/// Writes a plane.
pub fn push_packed(out: &mut impl Write, plane: &[f32]) -> io::Result<()> {
    // Noise hardly shrinks, whatever the effort.
    let text = EncoderWriter::new(out, &STANDARD);
    let mut encoder = ZlibEncoder::new(text, Compression::fast());
    for piece in plane.chunks(PIECE) {
        let bytes: Vec<u8> = piece.iter().flat_map(|value| value.to_le_bytes()).collect();
        encoder.write_all(&bytes)?;
    }
    encoder.finish()?.finish()?;
    Ok(())
}
