//! Textures: pictures on surfaces.
//!
//! A picture is read at its full resolution, whichever path asks from however far: its value at a
//! point of a surface is one, from both sides of the transport.

use std::fmt;
use std::sync::{Arc, OnceLock};

use glam::Vec2;

use crate::image::StokesImage;
use crate::image::exr::encode_whole;
use crate::image::texels::{Coding, STOKES_WANTED, Texels, flaw};
use crate::scene::error::SceneError;
use crate::scene::panorama::Directions;
use crate::spectrum::Color;

/// What a picture shows beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Itself, again and again.
    Repeat,
    /// Itself, every other time mirrored.
    Mirror,
    /// What is at its edge.
    Clamp,
}

/// How the value between the middles of texels is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// It is that of the nearest texel.
    Nearest,
    /// By linear interpolation of the four about it.
    Linear,
}

/// A picture, and how it lies on surfaces.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The picture.
    pub picture: Arc<Picture>,
    /// What its values are.
    pub coding: Coding,
    /// What it shows beyond its edges, from left to right and from top to bottom.
    pub wrap: [Wrap; 2],
    /// What it shows between its texels.
    pub filter: Filter,
    /// Which set of a mesh's texture coordinates it goes by: 0 or 1.
    pub set: usize,
    /// Its own coordinates are these rows times (u, v, 1) of the mesh's: (0, 0) is its upper left
    /// corner, and (1, 1) the lower right one.
    pub transform: [[f32; 3]; 2],
}

impl PartialEq for Texture {
    /// Pictures are the same if they are one.
    fn eq(&self, other: &Self) -> bool {
        let Self { picture, coding, wrap, filter, set, transform } = self;
        Arc::ptr_eq(picture, &other.picture)
            && (coding, wrap, filter, set, transform)
                == (&other.coding, &other.wrap, &other.filter, &other.set, &other.transform)
    }
}

/// A picture with what is asked of it as a whole.
pub struct Picture {
    texels: Texels,
    /// What tells it from others: half the BLAKE3 of its file.
    pub checksum: u128,
    /// The mean of all texels, by coding.
    means: [OnceLock<[f32; 4]>; 2],
    least_alpha: OnceLock<f32>,
    /// Texels that are no normals to the front.
    normals_astray: OnceLock<usize>,
    /// How the light of each texel is polarized, if it is.
    states: Option<Vec<States>>,
    /// How directions are drawn, if it shows what is around.
    directions: OnceLock<Directions>,
}

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Picture {:032x} of {:?}", self.checksum, self.texels)
    }
}

impl Picture {
    /// The picture of some texels, whose file had a checksum.
    pub fn new(texels: Texels, checksum: u128) -> Self {
        Self {
            texels,
            checksum,
            states: None,
            means: Default::default(),
            least_alpha: OnceLock::new(),
            normals_astray: OnceLock::new(),
            directions: OnceLock::new(),
        }
    }

    /// That of the bytes of a file: PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR.
    ///
    /// # Errors
    /// When it is none of these, or damaged, or has values that are negative or not finite.
    pub fn read(bytes: &[u8]) -> Result<Self, SceneError> {
        Self::decoded(bytes, "picture")
    }

    /// That of linear red, green and blue, in rows of a width from the top.
    ///
    /// # Errors
    /// When they are no such rows, or some are negative or not finite.
    pub fn of_colors(width: usize, colors: Vec<[f32; 3]>) -> Result<Self, SceneError> {
        let refuse = |problem: String, remedy: &str| SceneError::new("picture", problem, remedy);
        if width == 0 || colors.is_empty() || !colors.len().is_multiple_of(width) {
            let problem = format!("{} colors are no rows of {width}", colors.len());
            return Err(refuse(problem, "give height times width colors"));
        }
        let bytes: Vec<u8> = colors.as_flattened().iter().flat_map(|it| it.to_le_bytes()).collect();
        let texels = Texels::of_colors(width, colors);
        match texels.find_unusable() {
            Some(problem) => Err(refuse(problem, "clean the picture up")),
            None => Ok(Self::new(texels, half_hash(&[&width.to_le_bytes()[..], &bytes].concat()))),
        }
    }

    /// That of a file of a picture, which errors call by a label.
    pub(in crate::scene) fn decoded(bytes: &[u8], label: &str) -> Result<Self, SceneError> {
        let texels = Texels::decode(bytes)
            .map_err(|[problem, remedy]| SceneError::new(label, problem, remedy))?;
        if let Some(problem) = texels.find_unusable() {
            return Err(SceneError::new(label, problem, "clean the picture up"));
        }
        Ok(Self::new(texels, half_hash(bytes)))
    }

    /// The same of what is around a scene, which may be polarized.
    pub(in crate::scene) fn around(bytes: &[u8], label: &str) -> Result<Self, SceneError> {
        let found = Texels::stokes_vectors(bytes)
            .map_err(|[problem, remedy]| SceneError::new(label, problem, remedy))?;
        match found {
            Some(image) => polarized(&image, bytes, label),
            None => Self::decoded(bytes, label),
        }
    }

    /// One of linear red, green and blue, in rows of a width, polarized so. The checksum tells it
    /// from others.
    pub(in crate::scene) fn of_states(
        (width, colors): (usize, Vec<[f32; 3]>),
        states: Vec<States>,
        checksum: u128,
    ) -> Self {
        let states = Some(states);
        Self { states, ..Self::new(Texels::of_colors(width, colors), checksum) }
    }

    /// The same whose values are what these are if they are linear.
    pub(in crate::scene) fn linear(&self) -> Self {
        let [width, height] = self.texels.size();
        let mut colors = Vec::new();
        for row in 0..height {
            colors.extend((0..width).map(|column| {
                let [red, green, blue, _] = self.texels.at(column, row, Coding::Linear);
                [red, green, blue]
            }));
        }
        let checksum = half_hash(&[&self.checksum.to_le_bytes()[..], b"linear"].concat());
        Self::new(Texels::of_colors(width as usize, colors), checksum)
    }

    /// The bytes of a file of it, and what its name ends in. What is read of that has the same
    /// values, but for last bits of how light is polarized.
    pub(in crate::scene) fn encode(&self) -> Result<(Vec<u8>, &'static str), String> {
        let Some(states) = &self.states else { return self.texels.encode() };
        let [width, height] = self.texels.size().map(|side| side as usize);
        let mut planes = vec![Vec::new(); 12];
        for (texel, state) in states.iter().enumerate() {
            let at = [texel % width, texel / width].map(|it| it as u32);
            let color = self.texels.at(at[0], at[1], Coding::Linear);
            for channel in 0..3 {
                planes[channel].push(color[channel]);
                for (component, share) in state[channel].iter().enumerate() {
                    planes[3 * (component + 1) + channel].push(share * color[channel]);
                }
            }
        }
        let image = StokesImage {
            width,
            height,
            color: Color::Rgb,
            components: 4,
            planes,
            variance: None,
            layers: Vec::new(),
            metadata: Vec::new(),
        };
        encode_whole(&image).map(|bytes| (bytes, "exr"))
    }

    /// How the light of a texel is polarized; none if the picture is not.
    #[inline]
    pub fn state_at(&self, column: usize, row: usize) -> Option<&States> {
        self.states.as_ref()?.get(self.texels.size()[0] as usize * row + column)
    }

    /// Whether it says how light is polarized.
    pub fn is_polarized(&self) -> bool {
        self.states.is_some()
    }

    /// The texels.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// The least alpha of all texels.
    pub fn least_alpha(&self) -> f32 {
        *self.least_alpha.get_or_init(|| {
            let [width, height] = self.texels.size();
            if !self.texels.has_alpha() {
                return 1.0;
            }
            let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
            let alphas = places.map(|(column, row)| self.texels.at(column, row, Coding::Linear)[3]);
            alphas.fold(f32::INFINITY, f32::min)
        })
    }

    /// Of the texels of a map of normals, how many have none, or one that points into the surface.
    pub fn normals_astray(&self) -> usize {
        /// Of a length below this, a direction is mostly rounding.
        const LENGTH_MIN: f32 = 0.1;
        *self.normals_astray.get_or_init(|| {
            let [width, height] = self.texels.size();
            let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
            let is_astray = |(column, row): &(u32, u32)| {
                let [x, y, z, _] = self.texels.at(*column, *row, Coding::Linear);
                let normal = 2.0 * glam::Vec3::new(x, y, z) - 1.0;
                normal.z <= 0.0 || normal.length() < LENGTH_MIN
            };
            places.filter(is_astray).count()
        })
    }

    /// How directions are drawn by it where it shows what is around.
    pub fn directions(&self) -> &Directions {
        self.directions.get_or_init(|| Directions::new(self))
    }

    /// The mean of all texels.
    pub(in crate::scene) fn mean(&self, coding: Coding) -> [f32; 4] {
        *self.means[coding as usize].get_or_init(|| {
            let [width, height] = self.texels.size();
            let mut sum = [0.0_f64; 4];
            for row in 0..height {
                for column in 0..width {
                    let texel = self.texels.at(column, row, coding);
                    sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += f64::from(value));
                }
            }
            sum.map(|sum| (sum / (f64::from(width) * f64::from(height))) as f32)
        })
    }
}

/// S1, S2 and S3 over S0 of red, green and blue, in the frame (right, up, k) of a picture that is
/// looked at from its inside: that of films.
pub type States = [[f32; 3]; 3];

/// How much more than 1 a degree of polarization may be out of rounding to 16 bits.
const DEGREE_TOLERANCE: f32 = 1e-2;

/// A picture of Stokes vectors.
fn polarized(image: &StokesImage, bytes: &[u8], label: &str) -> Result<Picture, SceneError> {
    let refuse = |problem: String, remedy: &str| SceneError::new(label, problem, remedy);
    if image.color != Color::Rgb {
        let problem = format!("holds Stokes vectors of {}", image.color);
        return Err(refuse(problem, STOKES_WANTED));
    }
    if let Some(problem) = find_unusable(image) {
        return Err(refuse(problem, "clean the picture up"));
    }
    let count = image.width * image.height;
    let value = |component: usize, channel: usize, texel: usize| {
        image.planes[3 * component + channel][texel]
    };
    let colors: Vec<[f32; 3]> =
        (0..count).map(|texel| [0, 1, 2].map(|channel| value(0, channel, texel))).collect();
    let mut states = Vec::with_capacity(count);
    for texel in 0..count {
        let of_channel = |channel: usize| {
            let s0 = value(0, channel, texel);
            let state = [1, 2, 3].map(|component| value(component, channel, texel));
            shares(s0, state)
        };
        let [red, green, blue] = [0, 1, 2].map(of_channel);
        let (Some(red), Some(green), Some(blue)) = (red, green, blue) else {
            let (column, row) = (texel % image.width, texel / image.width);
            let problem =
                format!("has more than wholly polarized light in column {column}, row {row}");
            return Err(refuse(problem, "clean the picture up: S0 is at least the rest"));
        };
        states.push([red, green, blue]);
    }
    Ok(Picture::of_states((image.width, colors), states, half_hash(bytes)))
}

/// The first value of Stokes vectors that is not finite, or below zero where it is one of S0, in
/// words.
fn find_unusable(image: &StokesImage) -> Option<String> {
    for (plane, values) in image.planes.iter().enumerate() {
        let (component, color) = (plane / 3, ["R", "G", "B"][plane % 3]);
        for (texel, value) in values.iter().enumerate() {
            let size = if component == 0 { *value } else { value.abs() };
            if let Some(what) = flaw(size) {
                let (column, row) = (texel % image.width, texel / image.width);
                let place = format!("S{component}.{color}, column {column}, row {row}");
                return Some(format!("has {what} in {place}"));
            }
        }
    }
    None
}

/// S1, S2 and S3 over S0, all of them finite; none if they are more than that.
fn shares(s0: f32, state: [f32; 3]) -> Option<[f32; 3]> {
    let most = state.into_iter().fold(0.0, |most: f32, value| most.max(value.abs()));
    if most == 0.0 {
        return Some([0.0; 3]);
    }
    let shares = state.map(|value| value / s0);
    let [s1, s2, s3] = shares;
    let degree = (s1 * s1 + s2 * s2 + s3 * s3).sqrt();
    match degree {
        _ if degree <= 1.0 => Some(shares),
        _ if degree <= 1.0 + DEGREE_TOLERANCE => Some(shares.map(|share| share / degree)),
        _ => None,
    }
}

/// Half the BLAKE3 of some bytes.
pub(in crate::scene) fn half_hash(bytes: &[u8]) -> u128 {
    let whole = blake3::hash(bytes);
    whole.as_bytes()[..16].iter().fold(0, |half, &byte| half << 8 | u128::from(byte))
}

/// The four texels about a point, row by row, and how far it is from the first to the right and
/// down, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Linear red, green, blue and alpha.
    pub texels: [[f32; 4]; 4],
    /// The shares of the right ones and of the lower ones.
    pub shares: [f32; 2],
}

impl Taps {
    /// Texels without a texture: white and opaque.
    pub const WHITE: Self = Self { texels: [[1.0; 4]; 4], shares: [0.0; 2] };

    /// What is made of the texels, interpolated: exactly that of one if all are the same.
    #[inline]
    pub fn mixed<const K: usize>(&self, mut of: impl FnMut([f32; 4]) -> [f32; K]) -> [f32; K] {
        let [right, down] = self.shares;
        let first = of(self.texels[0]);
        if self.shares == [0.0; 2] {
            return first;
        }
        let [second, third, fourth] = [1, 2, 3].map(|tap: usize| of(self.texels[tap]));
        std::array::from_fn(|k| {
            let upper = (second[k] - first[k]).mul_add(right, first[k]);
            let lower = (fourth[k] - third[k]).mul_add(right, third[k]);
            (lower - upper).mul_add(down, upper)
        })
    }
}

impl Texture {
    /// The texels about a point of a mesh, by the coordinates of its set there.
    #[inline]
    pub fn taps(&self, at: Vec2) -> Taps {
        let uv = self.place(at).to_array();
        let size = self.picture.texels.size();
        let along = |axis: usize| columns_about(uv[axis], size[axis], self.wrap[axis], self.filter);
        let ([left, right], across) = along(0);
        let ([upper, lower], down) = along(1);
        let texel = |column, row| self.picture.texels.at(column, row, self.coding);
        let first = texel(left, upper);
        let texels = match across == 0.0 && down == 0.0 {
            true => [first; 4],
            false => [first, texel(right, upper), texel(left, lower), texel(right, lower)],
        };
        Taps { texels, shares: [across, down] }
    }

    /// Linear red, green, blue and alpha at a point of a mesh.
    #[inline]
    pub fn at(&self, at: Vec2) -> [f32; 4] {
        self.taps(at).mixed(|texel| texel)
    }

    /// The coordinates in the picture of those of a mesh.
    #[inline]
    pub fn place(&self, Vec2 { x: u, y: v }: Vec2) -> Vec2 {
        let [x, y] = self.transform.map(|[a, b, c]| a.mul_add(u, b.mul_add(v, c)));
        Vec2::new(x, y)
    }

    /// The mean of the whole picture.
    pub fn mean(&self) -> [f32; 4] {
        self.picture.mean(self.coding)
    }
}

/// The two columns about a coordinate in a picture of so many, and the share of the second.
#[inline]
pub(super) fn columns_about(at: f32, count: u32, wrap: Wrap, filter: Filter) -> ([u32; 2], f32) {
    // What is beyond all numbers is as good as anywhere.
    let at = if at.is_finite() { at } else { 0.0 };
    let within = match wrap {
        Wrap::Repeat => at - at.floor(),
        Wrap::Mirror => 1.0 - (1.0 - (at - 2.0 * (0.5 * at).floor())).abs(),
        Wrap::Clamp => at.clamp(0.0, 1.0),
    };
    let last = count - 1;
    match filter {
        Filter::Nearest => ([((within * count as f32) as u32).min(last); 2], 0.0),
        Filter::Linear => {
            let place = within * count as f32 - 0.5;
            let first = place.floor();
            let share = place - first;
            let column = first as i64;
            let one = |column: i64| match wrap {
                Wrap::Repeat => column.rem_euclid(i64::from(count)) as u32,
                Wrap::Mirror | Wrap::Clamp => column.clamp(0, i64::from(last)) as u32,
            };
            ([one(column), one(column + 1)], share)
        }
    }
}

/// What of a picture's texels counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reads {
    /// The color.
    Color,
    /// Red, as a number.
    Red,
    /// Green, as a number.
    Green,
    /// Blue, as a number.
    Blue,
    /// Alpha, as a number.
    Alpha,
    /// The luminance of the color, as a number.
    Luminance,
}

impl Reads {
    /// That of a texel; a number three times.
    #[inline]
    pub fn of(self, [red, green, blue, alpha]: [f32; 4]) -> [f32; 3] {
        /// Of linear sRGB (ITU-R BT.709).
        const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
        match self {
            Self::Color => [red, green, blue],
            Self::Red => [red; 3],
            Self::Green => [green; 3],
            Self::Blue => [blue; 3],
            Self::Alpha => [alpha; 3],
            // Exact where there is no color.
            Self::Luminance if red == green && green == blue => [red; 3],
            Self::Luminance => {
                let [r, g, b] = LUMINANCE;
                [r.mul_add(red, g.mul_add(green, b * blue)); 3]
            }
        }
    }
}

/// A color, or a number, that differs from place to place.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint {
    /// What all that follows is multiplied by: linear red, green and blue.
    pub factor: [f32; 3],
    /// The picture; without, white.
    pub texture: Option<Texture>,
    /// What of its texels counts.
    pub reads: Reads,
    /// Whether the colors of vertices count as well.
    pub by_vertices: bool,
}

impl Paint {
    /// What a texel stands for: linear red, green and blue.
    #[inline]
    pub fn color(&self, texel: [f32; 4]) -> [f32; 3] {
        let [red, green, blue] = self.reads.of(texel);
        [self.factor[0] * red, self.factor[1] * green, self.factor[2] * blue]
    }

    /// About the mean over all of the picture.
    pub fn mean(&self) -> [f32; 3] {
        self.color(self.texture.as_ref().map_or([1.0; 4], Texture::mean))
    }
}

/// How much of a surface is there: the rest lets light straight on.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// The share that is there, times alpha of the picture and of the vertices.
    pub paint: Paint,
    /// The least share that counts as all; what is less counts as nothing. Without, shares are
    /// what they are.
    pub cutoff: Option<f32>,
}

impl Coverage {
    /// The share that is there, if it is the same everywhere.
    #[inline]
    pub fn even(&self) -> Option<f32> {
        let Paint { factor: [factor, ..], texture, by_vertices, .. } = &self.paint;
        (texture.is_none() && !by_vertices).then(|| self.of(*factor))
    }

    /// The share of a surface that is there, from 0 to 1, where its paint has a value.
    #[inline]
    pub fn of(&self, alpha: f32) -> f32 {
        match self.cutoff {
            Some(least) => f32::from(u8::from(alpha >= least)),
            None => alpha.clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A coordinate of a picture by the words of glTF: repeated, mirrored or clamped.
    fn texel_at(column: i64, count: i64, wrap: Wrap) -> u32 {
        let within = match wrap {
            Wrap::Repeat => (column % count + count) % count,
            Wrap::Mirror => {
                let turn = (column % (2 * count) + 2 * count) % (2 * count);
                if turn < count { turn } else { 2 * count - 1 - turn }
            }
            Wrap::Clamp => column.max(0).min(count - 1),
        };
        within as u32
    }

    #[test]
    fn columns_are_those_that_a_loop_over_texels_finds() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for count in [1_u32, 2, 3, 5, 8] {
                // Steps of a 64th fall on no middle and no edge of these texels.
                for step in (-400..400).map(|step| (f64::from(step) + 0.37) / 64.0) {
                    let place = step * f64::from(count);
                    let ([nearest, _], none) =
                        columns_about(step as f32, count, wrap, Filter::Nearest);
                    let expected = texel_at(place.floor() as i64, i64::from(count), wrap);
                    assert_eq!((nearest, none), (expected, 0.0), "{wrap:?} {count} {step}");
                    let (found, share) = columns_about(step as f32, count, wrap, Filter::Linear);
                    let first = (place - 0.5).floor();
                    let pair = [first as i64, first as i64 + 1];
                    let expected = pair.map(|at| texel_at(at, i64::from(count), wrap));
                    let right = (place - 0.5 - first) as f32;
                    // A mirrored picture may be read from the other side.
                    let value =
                        |[a, b]: [u32; 2], share: f32| (1.0 - share) * a as f32 + share * b as f32;
                    let error = value(found, share) - value(expected, right);
                    assert!(error.abs() < 1e-4, "{wrap:?} {count} {step}: {found:?} {share}");
                }
            }
        }
    }

    #[test]
    fn coordinates_beyond_numbers_are_somewhere() {
        for at in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e20, -1e20] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                for filter in [Filter::Nearest, Filter::Linear] {
                    let ([first, second], share) = columns_about(at, 7, wrap, filter);
                    assert!(first < 7 && second < 7 && (0.0..=1.0).contains(&share), "{at}");
                }
            }
        }
    }

    #[test]
    fn equal_texels_mix_to_themselves() {
        let texel = [0.1, 0.2, 0.3, 0.7];
        let taps = Taps { texels: [texel; 4], shares: [0.3, 0.6] };
        assert_eq!(taps.mixed(|texel| texel), texel);
    }
}
