//! Smooth spectra of many colors that have numbers, as the texels of a picture have: each is found
//! when it is first asked for, and kept.
//!
//! A place is of a color and a white alone. Threads may find the spectrum of one color at once, and
//! then write the same: whoever reads a part that nobody has written finds that, too.

use std::fmt;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use bytemuck::Zeroable;
use prefetch_index::prefetch_index;

use super::cie::VISIBLE_NM;
use super::color_space::White;
use super::upsampling::{Sigmoid, Smooth};

/// The three coefficients of a sigmoid and what it is multiplied by, as bits that are none before
/// they are known.
#[derive(Zeroable)]
#[repr(C, align(16))]
struct Place([AtomicU64; 2]);

/// The bits of no coefficient: what is unknown is zero, and takes no memory.
const UNKNOWN: u64 = 0x7fff_ffff_7fff_ffff;

/// The spectra of so many colors.
pub struct Shapes {
    count: usize,
    of_white: [OnceLock<Box<[Place]>>; White::ALL.len()],
}

impl fmt::Debug for Shapes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Shapes of {} colors", self.count)
    }
}

impl Shapes {
    /// Those of so many colors, none of which is known.
    pub fn new(count: usize) -> Self {
        Self { count, of_white: Default::default() }
    }

    /// [`Smooth::coefficient`] of a color under a white at wavelengths in nanometers, within
    /// 2e-5 of the brightest channel; `rgb` says which color that of the number is.
    #[inline]
    pub fn values<const N: usize>(
        &self,
        number: usize,
        (white, wavelengths_nm): (White, &[f32; N]),
        rgb: impl FnOnce() -> [f32; 3],
    ) -> [f32; N] {
        let places = self.places(white);
        let shape = places[number].read().unwrap_or_else(|| {
            let shape = Shape::of(&Smooth::coefficient(rgb(), white));
            places[number].write(&shape);
            shape
        });
        wavelengths_nm.map(|nm| shape.at(nm))
    }
}

impl Shapes {
    #[inline(always)]
    fn places(&self, white: White) -> &[Place] {
        self.of_white[white as usize].get_or_init(|| bytemuck::zeroed_slice_box(self.count))
    }

    /// Asks for the memory of colors of which values are asked soon.
    #[inline(always)]
    pub fn prefetch(&self, white: White, numbers: impl IntoIterator<Item = usize>) {
        let places = self.places(white);
        numbers.into_iter().for_each(|number| prefetch_index(places, number));
    }
}

impl Place {
    #[inline(always)]
    fn read(&self) -> Option<Shape> {
        let [first, second] = [0, 1].map(|word: usize| self.0[word].load(Ordering::Relaxed));
        if first == 0 || second == 0 {
            return None;
        }
        let [c0, c1] = halves(first ^ UNKNOWN);
        let [c2, scale] = halves(second ^ UNKNOWN);
        Some(Shape { c: [c0, c1, c2], scale })
    }

    fn write(&self, &Shape { c: [c0, c1, c2], scale }: &Shape) {
        for (word, values) in self.0.iter().zip([[c0, c1], [c2, scale]]) {
            word.store(whole(values) ^ UNKNOWN, Ordering::Relaxed);
        }
    }
}

#[inline(always)]
fn halves(word: u64) -> [f32; 2] {
    [word as u32, (word >> u32::BITS) as u32].map(f32::from_bits)
}

fn whole([low, high]: [f32; 2]) -> u64 {
    u64::from(low.to_bits()) | u64::from(high.to_bits()) << u32::BITS
}

/// A [`Smooth`] in single precision.
#[derive(Clone, Copy)]
struct Shape {
    c: [f32; 3],
    scale: f32,
}

impl Shape {
    fn of(&Smooth { scale, shape: Sigmoid { c } }: &Smooth) -> Self {
        // Steps are as good as what is steeper: beyond this, squares would be no numbers.
        const MOST: f64 = 1e18;
        Self { c: c.map(|it| it.clamp(-MOST, MOST) as f32), scale: scale as f32 }
    }

    /// As [`Sigmoid::at`].
    #[inline(always)]
    fn at(&self, wavelength_nm: f32) -> f32 {
        let [first, last] = VISIBLE_NM.map(|nm| nm as f32);
        let t = (wavelength_nm.max(first).min(last) - first) / (last - first);
        let [c0, c1, c2] = self.c;
        let x = c0.mul_add(t, c1).mul_add(t, c2);
        let root = x.mul_add(x, 1.0).sqrt();
        let tail = 0.5 / (root * (root + x.abs()));
        self.scale * if x < 0.0 { tail } else { 1.0 - tail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_smooth_spectra_however_often_they_are_asked_for() {
        let nm = [360.0, 401.0, 467.3, 550.0, 589.0, 632.8, 740.0, 830.0];
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let mut colors: Vec<[f32; 3]> = (0..2_000).map(|_| [(); 3].map(|()| random())).collect();
        // Darker and brighter ones, faces and corners of the cube, greys, and black.
        for index in 0..1_000 {
            let scale = [1e-6, 1e-3, 40.0, 1e6][index % 4];
            colors[index] = colors[index].map(|it| it * scale);
            colors[index + 1_000][index % 3] = [0.0, 1.0][index % 2];
        }
        let cube = |it: usize| [it & 1, it >> 1 & 1, it >> 2 & 1].map(|bit| bit as f32);
        colors.extend((0..8).map(cube));
        colors.push([0.3; 3]);
        let shapes = Shapes::new(colors.len());
        for white in White::ALL {
            for _ in 0..2 {
                for (number, &rgb) in colors.iter().enumerate() {
                    let found = shapes.values(number, (white, &nm), || rgb);
                    let exact = Smooth::coefficient(rgb, white).values(&nm);
                    let most = rgb.into_iter().fold(0.0, f32::max);
                    for (found, exact) in found.into_iter().zip(exact) {
                        let off = (found - exact).abs();
                        assert!(off <= 2e-5 * most, "{rgb:?}: {found} is not {exact}");
                    }
                    if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
                        assert_eq!(found, rgb[0..1].repeat(8)[..], "greys are constants");
                    }
                }
            }
        }
    }

    /// What is kept is read, and what is not is asked for.
    #[test]
    fn a_color_is_asked_for_once_for_each_white() {
        let shapes = Shapes::new(3);
        let mut asked = 0;
        for _ in 0..5 {
            for white in White::ALL {
                for number in [0, 2] {
                    let mut ask = || {
                        asked += 1;
                        [0.0, number as f32, 0.5]
                    };
                    shapes.values(number, (white, &[500.0]), &mut ask);
                }
            }
        }
        assert_eq!(asked, 4);
    }
}
