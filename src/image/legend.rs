//! Legends: the strip beneath a map that says what its colors mean.

use super::StokesImage;
use super::font::{self, draw_text, text_width};
use super::picture::Picture;
use crate::math::elementary::{atan2, hypot};
use crate::math::text::excerpt;

/// What a strip shows.
pub struct Legend {
    /// What is mapped.
    pub title: String,
    /// The colors over [0, 1], if the map has a scale.
    pub bar: Option<Box<dyn Fn(f32) -> [u8; 3]>>,
    /// Labels at places of the bar in [0, 1].
    pub ticks: Vec<(f32, String)>,
    /// Colors outside of the scale, with their names.
    pub swatches: Vec<([u8; 3], &'static str)>,
    /// Whether the bar is also drawn as a disk, on which a color stands at the angle it means. The
    /// bar then covers half a turn.
    pub disk: bool,
}

const PAPER: [u8; 3] = [18, 18, 22];
const INK: [u8; 3] = [232, 232, 226];
const FAINT: [u8; 3] = [150, 150, 152];
/// Space around and between the parts, in font pixels.
const GAP: usize = 5;
const BAR_HEIGHT: usize = 9;
const TICK_HEIGHT: usize = 3;
/// Height of a strip in font pixels: title, bar, ticks, labels, and a line of swatches.
const STRIP_HEIGHT: usize = GAP
    + font::HEIGHT
    + GAP
    + BAR_HEIGHT
    + TICK_HEIGHT
    + 2
    + font::HEIGHT
    + GAP
    + font::HEIGHT
    + GAP;
/// A picture narrower than this is enlarged before it gets a legend.
const WIDTH_MIN: usize = 250;
/// Width of a picture per pixel of its letters' strokes.
const WIDTH_PER_STROKE: usize = 420;

/// The picture with the legend beneath.
fn with_legend(picture: &Picture, legend: &Legend) -> Picture {
    let enlarged = enlarge(picture, WIDTH_MIN.div_ceil(picture.width.max(1)));
    let size = enlarged.width.div_ceil(WIDTH_PER_STROKE);
    let strip = draw_strip(legend, enlarged.width, size);
    let mut whole = Picture::new(enlarged.width, enlarged.height + strip.height, PAPER);
    whole.paste(&enlarged, 0, 0);
    whole.paste(&strip, 0, enlarged.height);
    whole
}

/// The picture of an image, enlarged by a whole number if it is small, with the legend beneath. If
/// it is a channel of another image, its name stands behind the title.
pub fn with_legend_of(image: &StokesImage, picture: &Picture, mut legend: Legend) -> Picture {
    const NAME: usize = 20;
    if let Some(channel) = image.channel() {
        legend.title += &format!(", {}", excerpt(channel, NAME));
    }
    with_legend(picture, &legend)
}

/// Pictures of one size in rows of `columns`, with gaps between.
pub fn arrange(pictures: &[Picture], columns: usize) -> Picture {
    let Some(first) = pictures.first() else {
        return Picture::new(0, 0, PAPER);
    };
    let columns = columns.clamp(1, pictures.len());
    let gap = first.width.div_ceil(WIDTH_PER_STROKE) * GAP;
    let (step_x, step_y) = (first.width + gap, first.height + gap);
    let rows = pictures.len().div_ceil(columns);
    let mut whole = Picture::new(columns * step_x - gap, rows * step_y - gap, PAPER);
    for (i, picture) in pictures.iter().enumerate() {
        whole.paste(picture, i % columns * step_x, i / columns * step_y);
    }
    whole
}

fn enlarge(picture: &Picture, factor: usize) -> Picture {
    let mut large = Picture::new(picture.width * factor, picture.height * factor, PAPER);
    for y in 0..large.height {
        for x in 0..large.width {
            large.set(x, y, picture.pixels[y / factor * picture.width + x / factor]);
        }
    }
    large
}

fn draw_strip(legend: &Legend, width: usize, size: usize) -> Picture {
    let mut strip = Picture::new(width, STRIP_HEIGHT * size, PAPER);
    let gap = GAP * size;
    let mut left = gap;
    if let (true, Some(bar)) = (legend.disk, &legend.bar) {
        let radius = (STRIP_HEIGHT * size - 2 * gap) / 2;
        draw_disk(&mut strip, bar, (gap + radius, gap + radius), radius);
        left += 2 * radius + 2 * gap;
    }
    draw_text(&mut strip, (left, gap), size, INK, &legend.title);
    let top = gap + (font::HEIGHT + GAP) * size;
    let length = width.saturating_sub(left + gap);
    if let Some(bar) = &legend.bar {
        draw_bar(&mut strip, bar, (left, top), length, size);
        draw_ticks(&mut strip, &legend.ticks, (left, top + BAR_HEIGHT * size), length, size);
    }
    let mut x = left;
    let y = strip.height - gap - font::HEIGHT * size;
    for (color, name) in &legend.swatches {
        let side = font::HEIGHT * size;
        strip.fill(x, y, side, side, FAINT);
        strip.fill(x + size, y + size, side - 2 * size, side - 2 * size, *color);
        x += side + 3 * size;
        draw_text(&mut strip, (x, y), size, FAINT, name);
        x += text_width(name, size) + 2 * gap;
    }
    strip
}

fn draw_bar(
    strip: &mut Picture,
    bar: &dyn Fn(f32) -> [u8; 3],
    (left, top): (usize, usize),
    length: usize,
    size: usize,
) {
    for x in 0..length {
        let t = x as f32 / (length - 1).max(1) as f32;
        strip.fill(left + x, top, 1, BAR_HEIGHT * size, bar(t));
    }
}

/// A mark under the bar and a label under the mark, moved inward where it would leave the strip.
fn draw_ticks(
    strip: &mut Picture,
    ticks: &[(f32, String)],
    (left, top): (usize, usize),
    length: usize,
    size: usize,
) {
    for (t, label) in ticks {
        let x = left + (t * length.saturating_sub(size) as f32).round() as usize;
        strip.fill(x, top + size, size, TICK_HEIGHT * size - size, INK);
        let label_width = text_width(label, size);
        let right = (left + length).saturating_sub(label_width);
        let label_x = (x + size / 2).saturating_sub(label_width / 2).clamp(left, right.max(left));
        draw_text(strip, (label_x, top + (TICK_HEIGHT + 2) * size), size, INK, label);
    }
}

/// Every point of the disk has the color of its direction, counterclockwise from the right, so
/// that a stroke of light and its color can be laid over each other.
fn draw_disk(
    strip: &mut Picture,
    bar: &dyn Fn(f32) -> [u8; 3],
    (center_x, center_y): (usize, usize),
    radius: usize,
) {
    for y in 0..=2 * radius {
        for x in 0..=2 * radius {
            let (dx, dy) = (x as f32 - radius as f32, radius as f32 - y as f32);
            let distance = hypot(dx, dy) / radius as f32;
            if (0.3..=1.0).contains(&distance) {
                let turn = (atan2(dy, dx) / std::f32::consts::PI).rem_euclid(1.0);
                strip.set(center_x + x - radius, center_y + y - radius, bar(turn));
            }
        }
    }
}
