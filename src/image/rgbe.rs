//! The Radiance picture format: three mantissas and one exponent per pixel, run-length encoded.
//!
//! A value is m * 2^(e - 136) with an eight-bit m. Encoding rounds to the nearest and decoding adds
//! nothing (so 0 and 1 are exact, as eq. 14 wants); hence a channel is off by at most 1/255 of the
//! largest channel of its pixel. Negative values and NaN become 0, values from 2^127 on are
//! clipped, values below 2^-126 become 0.

/// A decoded picture.
pub struct RgbePicture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear values, rows from the top.
    pub pixels: Vec<[f32; 3]>,
    /// The header lines as they stand, without the first one and without the resolution.
    pub header: Vec<String>,
}

/// The longest line of a header that is read.
const LINE_BYTES_MAX: usize = 1 << 16;
/// The most lines of a header that are read.
const HEADER_LINES_MAX: usize = 4096;
/// Pixels that a file may hold per byte: new-style runs reach 16.
const PIXELS_PER_BYTE_MAX: usize = 64;
/// Widths that the new run-length encoding can say.
const RLE_WIDTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// The bytes of a picture file. `header` lines must not hold line breaks.
pub fn encode(width: usize, height: usize, pixels: &[[f32; 3]], header: &[String]) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\n".to_vec();
    for line in header {
        bytes.extend_from_slice(line.as_bytes());
        bytes.push(b'\n');
    }
    bytes.extend_from_slice(b"FORMAT=32-bit_rle_rgbe\n\n");
    bytes.extend_from_slice(format!("-Y {height} +X {width}\n").as_bytes());
    for row in pixels.chunks(width.max(1)) {
        let row: Vec<[u8; 4]> = row.iter().map(|&rgb| pack(rgb)).collect();
        if RLE_WIDTHS.contains(&width) {
            bytes.extend_from_slice(&[2, 2, (width >> 8) as u8, (width & 0xff) as u8]);
            for i in 0..4 {
                let plane: Vec<u8> = row.iter().map(|pixel| pixel[i]).collect();
                encode_runs(&mut bytes, &plane);
            }
        } else {
            bytes.extend_from_slice(row.as_flattened());
        }
    }
    bytes
}

/// Reads the bytes of a picture file: plain, old-style or new-style runs.
pub fn decode(bytes: &[u8]) -> Result<RgbePicture, String> {
    let mut reader = Reader { bytes };
    let first = reader.line()?;
    if first != "#?RADIANCE" && first != "#?RGBE" {
        return Err("it does not begin with #?RADIANCE".to_owned());
    }
    let mut header = Vec::new();
    let mut exposure = 1.0_f32;
    loop {
        let line = reader.line()?;
        if line.is_empty() {
            break;
        }
        if line.strip_prefix("FORMAT=").is_some_and(|format| format.trim() != "32-bit_rle_rgbe") {
            return Err(format!("its {line} is not 32-bit_rle_rgbe"));
        }
        if let Some(value) = line.strip_prefix("EXPOSURE=") {
            let usable = |value: &f32| value.is_finite() && *value > 0.0;
            let value = value.trim().parse().ok().filter(usable);
            exposure *= value.ok_or_else(|| format!("{line} is no exposure"))?;
        }
        header.push(line);
        if header.len() > HEADER_LINES_MAX {
            return Err("its header does not end".to_owned());
        }
    }
    let (width, height) = resolution(&reader.line()?)?;
    let pixels_max = reader.bytes.len().saturating_mul(PIXELS_PER_BYTE_MAX);
    if width.saturating_mul(height) > pixels_max {
        return Err("it is too short for its resolution".to_owned());
    }
    let mut pixels = Vec::with_capacity(width * height);
    for _ in 0..height {
        let row = reader.row(width)?;
        pixels.extend(row.into_iter().map(|p| unpack(p).map(|value| value / exposure)));
    }
    Ok(RgbePicture { width, height, pixels, header })
}

fn pack(rgb: [f32; 3]) -> [u8; 4] {
    let clip = |value: f32| if value > 0.0 { value } else { 0.0 };
    let rgb = rgb.map(clip);
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest < f32::MIN_POSITIVE {
        return [0; 4];
    }
    // The exponent e with 2^(e-1) <= largest < 2^e; one more where the mantissa rounds to 256.
    let mut e = (largest.to_bits() >> 23) as i32 - 126;
    if f64::from(largest) * 2_f64.powi(8 - e) >= 255.5 {
        e += 1;
    }
    let e = e.min(127);
    let scale = 2_f64.powi(8 - e);
    let [r, g, b] = rgb.map(|value| (f64::from(value) * scale).round().min(255.0) as u8);
    [r, g, b, (e + 128) as u8]
}

fn unpack([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = 2_f64.powi(i32::from(e) - 136);
    [r, g, b].map(|mantissa| (f64::from(mantissa) * scale) as f32)
}

/// New-style runs: a count above 128 repeats one byte, a count up to 128 precedes plain bytes.
fn encode_runs(bytes: &mut Vec<u8>, plane: &[u8]) {
    let run_at = |start: usize| {
        plane[start..].iter().take(127).take_while(|&&value| value == plane[start]).count()
    };
    let mut start = 0;
    while start < plane.len() {
        let run = run_at(start);
        if run >= 4 {
            bytes.extend_from_slice(&[128 + run as u8, plane[start]]);
            start += run;
            continue;
        }
        let mut end = start;
        while end < plane.len() && end - start < 128 && run_at(end) < 4 {
            end += 1;
        }
        bytes.push((end - start) as u8);
        bytes.extend_from_slice(&plane[start..end]);
        start = end;
    }
}

fn resolution(line: &str) -> Result<(usize, usize), String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let size = match words.as_slice() {
        ["-Y", height, "+X", width] => width.parse::<u16>().ok().zip(height.parse::<u16>().ok()),
        _ => return Err(format!("its resolution line {line:?} is not -Y HEIGHT +X WIDTH")),
    };
    match size {
        Some((width, height)) if width > 0 && height > 0 => Ok((width.into(), height.into())),
        _ => Err(format!("its resolution {line:?} is out of range")),
    }
}

/// What is left to read.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or("it ends too early")?;
        self.bytes = rest;
        Ok(taken)
    }

    fn line(&mut self) -> Result<String, String> {
        let window = &self.bytes[..self.bytes.len().min(LINE_BYTES_MAX)];
        let end = window.iter().position(|&byte| byte == b'\n').ok_or("its header is cut short")?;
        let line = String::from_utf8_lossy(&window[..end]).trim_end_matches('\r').to_owned();
        self.bytes = &self.bytes[end + 1..];
        Ok(line)
    }

    fn pixel(&mut self) -> Result<[u8; 4], String> {
        let bytes = self.take(4)?;
        Ok([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    fn row(&mut self, width: usize) -> Result<Vec<[u8; 4]>, String> {
        let new_style =
            RLE_WIDTHS.contains(&width) && matches!(self.bytes, [2, 2, high, _, ..] if *high < 128);
        if !new_style {
            return self.old_row(width);
        }
        let start = self.pixel()?;
        if usize::from(start[2]) << 8 | usize::from(start[3]) != width {
            return Err("a scan line has another width than the picture".to_owned());
        }
        let mut row = vec![[0_u8; 4]; width];
        for i in 0..4 {
            let plane = self.runs(width)?;
            row.iter_mut().zip(plane).for_each(|(pixel, value)| pixel[i] = value);
        }
        Ok(row)
    }

    fn runs(&mut self, width: usize) -> Result<Vec<u8>, String> {
        let mut plane = Vec::with_capacity(width);
        while plane.len() < width {
            let count = usize::from(self.take(1)?[0]);
            match count {
                0 => return Err("a run has no length".to_owned()),
                1..=128 => plane.extend_from_slice(self.take(count)?),
                _ => {
                    let value = self.take(1)?[0];
                    plane.resize(plane.len() + count - 128, value);
                }
            }
        }
        match plane.len() == width {
            true => Ok(plane),
            false => Err("a run leaves its scan line".to_owned()),
        }
    }

    /// Plain pixels; a pixel (1, 1, 1, n) repeats the one before, and such ones in a row are the
    /// digits of a number to the base 256, the lowest first.
    fn old_row(&mut self, width: usize) -> Result<Vec<[u8; 4]>, String> {
        let mut row: Vec<[u8; 4]> = Vec::with_capacity(width);
        let mut shift = 0;
        while row.len() < width {
            let pixel = self.pixel()?;
            match (pixel, row.last().copied()) {
                ([1, 1, 1, count], Some(last)) => {
                    let count = usize::from(count) << shift;
                    if count > width - row.len() {
                        return Err("a run leaves its scan line".to_owned());
                    }
                    row.resize(row.len() + count, last);
                    shift = (shift + 8).min(24);
                }
                _ => {
                    row.push(pixel);
                    shift = 0;
                }
            }
        }
        Ok(row)
    }
}
