//! A page to look at images in: one HTML file with everything in it, opened from the disk.
//!
//! Images -> their planes, deflated and in base64, beside colors, legends and names as JSON
//! (`data`) -> `page.html` with its style and scripts, and those that all pages have
//! ([`super::page`]). The scripts take every number of a palette or a legend from the data, so that
//! the page has the colors of [`super::visualize`]; what they compute themselves is the picture
//! behind an analyzer, degrees and angles.

mod data;

use std::io::{self, Seek, Write};
use std::path::Path;

use super::error::OutputError;
use super::{StokesImage, atomic, check_shape, page};
use crate::spectrum::Color;

/// What a browser is asked to hold at most: the bytes of all values of a page. Inflated they are
/// one array a plane; beside them the page's text is as large again while it is read.
pub const BYTES_MAX: usize = 2 << 30;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// The scripts behind those of all pages, in the order in which they stand there.
const SCRIPTS: [&str; 5] = [
    include_str!("pixels.js"),
    include_str!("bands.js"),
    include_str!("stage.js"),
    include_str!("controls.js"),
    include_str!("main.js"),
];

/// An image on a page, by the name that stands over it.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// Any text; the page shows it as it is.
    pub name: &'a str,
    /// The image.
    pub image: &'a StokesImage,
}

/// Writes the page of one image, or of two with a divider between them, and returns its bytes.
///
/// # Errors
/// When the images do not have the same size and bands, one is not what it promises, they are
/// larger together than [`BYTES_MAX`], or the file cannot be written.
pub fn write(images: &[Named], path: &Path) -> Result<u64, OutputError> {
    check(images)?;
    check_bytes(images).map_err(|reason| OutputError::unwritable(path, reason))?;
    let mut bytes = 0;
    atomic::write_with(path, |file| {
        push_page(file, images)?;
        bytes = file.stream_position()?;
        Ok(())
    })?;
    Ok(bytes)
}

/// The text of the page.
///
/// # Errors
/// When the images do not have the same size and bands, or one is not what it promises.
pub fn page(images: &[Named]) -> Result<String, OutputError> {
    check(images)?;
    let mut bytes = Vec::new();
    push_page(&mut bytes, images).expect("memory takes what is written");
    Ok(String::from_utf8(bytes).expect("a page is text"))
}

fn check(images: &[Named]) -> Result<(), OutputError> {
    for named in images {
        check_shape(named.image).map_err(|reason| OutputError::Image { reason })?;
        if let Color::Responses(_) = named.image.color {
            let reason = "a page shows RGB, one wavelength or bands, and it has responses; name \
                          one by --channel";
            return Err(OutputError::Image { reason });
        }
    }
    let [first, second, ..] = images else { return Ok(()) };
    let mismatch = |words: fn(&StokesImage) -> String, reason| {
        let words = |Named { name, image }: &Named| format!("{name} ({})", words(image));
        Err(OutputError::Mismatch { first: words(first), second: words(second), reason })
    };
    let size = |named: &Named| (named.image.width, named.image.height);
    if size(first) != size(second) {
        let words = |image: &StokesImage| format!("{} x {}", image.width, image.height);
        let reason = "a page with a divider needs images of one size";
        return mismatch(words, reason.to_owned());
    }
    if let Some(difference) = first.image.color.difference(&second.image.color) {
        let reason = format!(
            "{difference}; a page with a divider needs images of the same bands, or one band of \
             each (--wavelength)"
        );
        return mismatch(|image| image.color.to_string(), reason);
    }
    Ok(())
}

fn has_bands(image: &StokesImage) -> bool {
    matches!(image.color, Color::Bands(_))
}

/// Says why a browser cannot hold the images.
fn check_bytes(images: &[Named]) -> Result<(), String> {
    let bytes: usize = images.iter().map(|named| bytes_of(named.image)).sum();
    if bytes <= BYTES_MAX {
        return Ok(());
    }
    let gibibytes = |bytes: usize| bytes as f64 / f64::from(1 << 30);
    let has_variance = images.iter().any(|named| named.image.variance.is_some());
    let without = if has_variance { ", or leave out variances (--no-variance)" } else { "" };
    let any = images.iter().any(|named| has_bands(named.image));
    let one = if any { ", or one band (--wavelength)" } else { "" };
    Err(format!(
        "a browser would have to hold {:.1} GiB of values, and {:.0} are the most; view smaller \
         images{one}{without}",
        gibibytes(bytes),
        gibibytes(BYTES_MAX)
    ))
}

/// Writes the page: `page.html` with its places filled.
fn push_page(out: &mut impl Write, images: &[Named]) -> io::Result<()> {
    let names: Vec<&str> = images.iter().map(|named| named.name).collect();
    page::push_filled(out, PAGE, |out, place| match place {
        "title" => out.write_all(page::escaped_text(&names.join(" | ")).as_bytes()),
        "style" => write!(out, "{}\n{STYLE}", page::STYLE),
        "data" => out.write_all(data::json(images).as_bytes()),
        "pixels" => push_pixels(out, images),
        "scripts" => {
            let mut scripts = page::SCRIPTS.iter().chain(&SCRIPTS);
            scripts.try_for_each(|text| writeln!(out, "{text}"))
        }
        _ => {
            debug_assert!(false, "page.html has no place for {place}");
            Ok(())
        }
    })
}

/// What the values of an image take in memory, and of bands what the page makes of them: red,
/// green, blue and the mean of each component.
fn bytes_of(image: &StokesImage) -> usize {
    let mixed = if has_bands(image) { 4 * image.components } else { 0 };
    let planes = image.planes.len() + mixed + image.variance.as_ref().map_or(0, Vec::len);
    planes.saturating_mul(image.width).saturating_mul(image.height).saturating_mul(size_of::<f32>())
}

/// An element for every plane, from which the page takes the values.
fn push_pixels(out: &mut impl Write, images: &[Named]) -> io::Result<()> {
    for (index, Named { image, .. }) in images.iter().enumerate() {
        let values = image.planes.iter().map(|plane| ("values", plane)).enumerate();
        let variances = image.variance.iter().flatten().map(|plane| ("variances", plane));
        for (plane_index, (kind, plane)) in values.chain(variances.enumerate()) {
            let id = format!("pixels-{index}-{kind}-{plane_index}");
            page::push_element(out, &id, |out| page::push_floats(out, plane))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::image::compare::compare;
    use crate::spectrum::Bands;

    #[test]
    fn every_place_of_the_page_is_filled_once() {
        for place in ["title", "style", "data", "pixels", "scripts"] {
            assert_eq!(PAGE.matches(&format!("{{{{{place}}}}}")).count(), 1, "{place}");
        }
        assert_eq!(PAGE.matches("{{").count(), 5);
    }

    #[test]
    fn two_images_have_the_same_bands() {
        let of = |color| StokesImage::new(2, 2, color, 1);
        let bands = |last| of(Color::Bands(Arc::new(Bands::evenly(400.0, last, 3).unwrap())));
        let refused = |first: &StokesImage, second: &StokesImage| {
            let named = [("a", first), ("b", second)].map(|(name, image)| Named { name, image });
            page(&named).err().map(|error| error.to_string())
        };
        assert_eq!(refused(&bands(700.0), &bands(700.0)), None);
        let named = "a=400x150,b=550x150,c=700x150";
        let named = of(Color::Bands(Arc::new(Bands::from_list(named).unwrap())));
        assert_eq!(refused(&bands(700.0), &named), None);
        assert!(compare(&bands(700.0), &named).is_ok());
        for other in [bands(650.0), of(Color::Rgb), of(Color::Mono { wavelength_nm: 550.0 })] {
            for (first, second) in [(&bands(700.0), &other), (&other, &bands(700.0))] {
                let words = refused(first, second).expect("they are shown differently");
                assert!(words.contains("3 bands from 400 to 700 nm"), "{words}");
                assert!(words.contains("same bands") && words.contains("--wavelength"), "{words}");
                // Both commands say the same.
                let difference = first.color.difference(&second.color).unwrap();
                let compared = compare(first, second).unwrap_err().to_string();
                assert!(words.contains(&difference) && compared.contains(&difference), "{words}");
            }
        }
    }

    #[test]
    fn what_no_browser_holds_is_refused_in_words() {
        let small = StokesImage::new(1, 1, Color::Rgb, 4);
        // Only the size is looked at.
        let mut image = StokesImage { width: 4096, height: 4096, ..small };
        let words = |images: &[&StokesImage]| {
            let named: Vec<Named> = images.iter().map(|image| Named { name: "a", image }).collect();
            check_bytes(&named).err()
        };
        assert_eq!(words(&[&image]), None);
        assert_eq!(words(&[&image, &image]), None);
        image.variance = Some(image.planes.clone());
        let text = words(&[&image, &image]).expect("3 GiB are too many");
        assert!(text.contains("3.0 GiB") && text.contains("--no-variance"), "{text}");
        image = StokesImage { width: 8192, height: 8192, variance: None, ..image };
        assert!(words(&[&image]).is_some_and(|text| !text.contains("--no-variance")));
        // 31 bands of 1920 x 1080 are 1.1 GiB with their mixes.
        let bands = Color::Bands(Arc::new(Bands::evenly(400.0, 700.0, 31).unwrap()));
        image = StokesImage { width: 1920, height: 1080, ..StokesImage::new(1, 1, bands, 4) };
        assert_eq!(words(&[&image]), None);
        let text = words(&[&image, &image]).expect("2.2 GiB are too many");
        assert!(text.contains("2.2 GiB") && text.contains("--wavelength"), "{text}");
    }
}
