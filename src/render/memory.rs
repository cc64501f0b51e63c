//! Whether a render fits into memory, asked before the system ends it for that.

use super::{Options, system};

/// A film that the memory does not hold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a film of {} x {} pixels needs {:.1} GiB of memory and {:.1} GiB are available: give a \
     smaller width and height",
    film[0], film[1], gibibytes(*needed), gibibytes(*available)
)]
pub struct MemoryError {
    /// Width and height in pixels.
    pub film: [u32; 2],
    /// Bytes that the render needs.
    pub needed: u64,
    /// Bytes that there are.
    pub available: u64,
}

/// Refuses a film that the memory does not hold; none where the system does not tell.
pub fn check_memory(options: &Options, film: [u32; 2]) -> Result<(), MemoryError> {
    let available = system::available_memory().unwrap_or(u64::MAX);
    let needed = bytes_of_film(options, film);
    if needed > available { Err(MemoryError { film, needed, available }) } else { Ok(()) }
}

/// Counts what every render needs: the sums of the film in double precision, and the image that
/// is developed from them, with their variances. The tables of paths come on top; they are small.
fn bytes_of_film(options: &Options, [width, height]: [u32; 2]) -> u64 {
    let bytes_of_value = if options.replicates > 1 { 3 * 8 + 2 * 4 } else { 8 + 4 };
    let values = (options.mode.components() * options.color.channels()) as u64;
    u64::from(width) * u64::from(height) * values * bytes_of_value
}

fn gibibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_counted_with_its_image_and_its_variances() {
        let options = Options::default();
        assert_eq!(bytes_of_film(&options, [100, 10]), 1000 * 12 * 12);
        assert_eq!(bytes_of_film(&Options { replicates: 2, ..options }, [100, 10]), 1000 * 12 * 32);
        assert!(check_memory(&options, [1, 1]).is_ok());
    }
}
