//! The camera with its film: rays out of it, and connections from points to it.

use std::sync::Arc;

use glam::Vec3;

use crate::film::filter::Profile;
use crate::film::lattice::{Lattice, Shift};
use crate::film::layout::Layout;
use crate::math::elementary::sin_cos;
use crate::math::{F32s, Vector, lanes, warp};
use crate::polarization::Analyzer;
use crate::scene::baked::{Camera, Projection};

/// A camera with a film of a certain size. One pixel is one unit of sensor area, so the
/// importance of a pixel integrates to one and densities are per pixel.
#[derive(Clone, Debug)]
pub struct Sensor {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The film: which of its pixels are rendered, and how they see.
    pub layout: Layout,
    /// The filter of its pixels, if that is not their squares.
    filter: Option<Arc<Profile>>,
    /// That of samples that neighbors share.
    lattice: Option<Arc<Lattice>>,
    position: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the size of the film: tangents (perspective) or scene units (orthographic).
    half_size: [f32; 2],
    perspective: bool,
    aperture_radius: f32,
    focus_distance: f32,
    /// What stands before the film.
    analyzer: Option<Analyzer>,
}

/// How many focus distances away infinity is: beyond the resolution of any film.
const FAR: f32 = 1e5;

/// A connection from a point of the scene to the sensor.
#[derive(Clone, Copy, Debug)]
pub struct SensorConnection {
    /// Where on the film it arrives: pixels from the left and from the top.
    pub film: [f32; 2],
    /// From the point to the sensor, unit length.
    pub direction: Vec3,
    /// The point on the lens, or on the film for parallel projection.
    pub lens: Vec3,
    /// Density of the sensor's ray, per unit of area perpendicular to the ray at the point:
    /// the importance of the pixel there, and also what connecting is weighed against.
    pub pdf_area: f32,
}

/// Points along an edge of the film where the sensor's medium is looked for.
const PLACES: u32 = 16;

impl Sensor {
    /// Puts a film behind a camera; the film's aspect rules, the vertical extent is kept.
    pub fn new(camera: &Camera, layout: Layout) -> Self {
        let [width, height] = layout.cut.film;
        let aspect = width as f32 * layout.pixel_aspect / height as f32;
        let (half_size, perspective, aperture_radius, focus_distance) = match camera.projection {
            Projection::Perspective {
                tan_half_y,
                tan_half_x_min,
                aperture_radius,
                focus_distance,
                ..
            } => {
                let tan_half_y = tan_half_y.max(tan_half_x_min / aspect);
                ([tan_half_y * aspect, tan_half_y], true, aperture_radius, focus_distance)
            }
            Projection::Orthographic { half_height, .. } => {
                ([half_height * aspect, half_height], false, 0.0, 1.0)
            }
        };
        let lattice = if layout.shares { Lattice::new(layout.filter) } else { None };
        assert_eq!(lattice.is_some(), layout.shares, "only what can be shared is");
        Self {
            width,
            height,
            layout,
            filter: Profile::new(layout.filter).map(Arc::new),
            lattice: lattice.map(Arc::new),
            position: camera.position,
            right: camera.right,
            up: camera.up,
            forward: camera.forward,
            half_size,
            perspective,
            aperture_radius,
            focus_distance,
            analyzer: camera.analyzer,
        }
    }

    /// The direction that is up in the image; fixes the film frame of the Stokes vectors.
    pub fn up(&self) -> Vec3 {
        self.up
    }

    /// What stands before the film, in its frame.
    pub fn analyzer(&self) -> Option<Analyzer> {
        self.analyzer
    }

    /// Where samples of the pixels at `column` and `row` lie on the film, by numbers in [0, 1).
    #[inline(always)]
    pub fn points(&self, [column, row]: [F32s; 2], numbers: [F32s; 2]) -> [F32s; 2] {
        let [dx, dy] = numbers;
        match &self.filter {
            None => [dx + column, dy + row],
            Some(filter) => {
                let about = |center: F32s, numbers: F32s| {
                    center + F32s::splat(0.5) + offsets(filter, numbers)
                };
                [about(column, dx), about(row, dy)]
            }
        }
    }

    /// What a sample counts that has been drawn by these numbers, where samples have weights.
    pub fn weights(&self) -> Option<impl Fn([f32; 2]) -> f32> {
        let own = self.filter.as_deref().filter(|_| self.lattice.is_none());
        let filter = own.filter(|filter| filter.is_signed())?;
        Some(|[x, y]: [f32; 2]| filter.draw(x).1 * filter.draw(y).1)
    }

    /// Where the samples of all pixels lie in an iteration, by its numbers in [0, 1), if neighbors
    /// share them.
    pub fn shift(&self, numbers: impl FnOnce() -> [f32; 2]) -> Option<Shift> {
        self.lattice.as_deref().map(|lattice| lattice.shift(numbers()))
    }

    /// The path that starts in a pixel of those that samples are taken in ([`Layout::sampled`]).
    #[inline(always)]
    pub fn path_of(&self, [column, row]: [u32; 2]) -> u32 {
        // Films of the most pixels have more with those beside them.
        row.wrapping_mul(self.width + 2 * self.layout.reach()).wrapping_add(column)
    }

    /// Whether a point of the film counts for one of several pixels ([`Sensor::pixel_of`]).
    pub fn shares_light(&self) -> bool {
        self.filter.is_some()
    }

    /// The pixel that light at a point of the film counts for, by numbers in [0, 1), and how much
    /// of it; by its index among those that are rendered. None if that is another one.
    pub fn pixel_of(
        &self,
        [x, y]: [f32; 2],
        numbers: impl FnOnce() -> [f32; 2],
    ) -> Option<(u32, f32)> {
        let Some(filter) = &self.filter else {
            return Some((self.layout.cut.index_of(x as u32, y as u32)?, 1.0));
        };
        let [of_x, of_y] = numbers();
        let (column, weight) = filter.pixel_of(x, of_x)?;
        let (row, of_row) = filter.pixel_of(y, of_y)?;
        let [column, row] = [u32::try_from(column).ok()?, u32::try_from(row).ok()?];
        Some((self.layout.cut.index_of(column, row)?, weight * of_row))
    }

    /// Whether the first vertex sees the sensor at a finite distance.
    pub fn is_finite(&self) -> bool {
        self.perspective
    }

    /// Whether rays start on a lens of finite size.
    pub fn has_lens(&self) -> bool {
        self.aperture_radius > 0.0
    }

    /// Points all over where its rays start: the pinhole, the lens, or the film.
    pub fn places(&self) -> Vec<Vec3> {
        if self.perspective && !self.has_lens() {
            return vec![self.position];
        }
        let steps = (0..=PLACES).map(|step| step as f32 / PLACES as f32);
        let pairs = steps.clone().flat_map(|u| steps.clone().map(move |v| [u, v]));
        let size = [self.width as f32, self.height as f32];
        let margin = self.margin();
        let place = |of: [f32; 2]| {
            let along = |axis: usize| of[axis] * (size[axis] + 2.0 * margin) - margin;
            let film = [along(0), along(1)].map(F32s::splat);
            let (origin, ..) = self.rays(film, || of.map(F32s::splat));
            Vec3::from(origin.to_rows()[0])
        };
        pairs.map(place).collect()
    }

    /// The rays through the film points `film` (pixels, from the top left) and `lens` (numbers in
    /// [0, 1)), and their density: per steradian, or per area for parallel projection.
    #[inline(always)]
    pub fn rays(
        &self,
        film: [F32s; 2],
        lens: impl FnOnce() -> [F32s; 2],
    ) -> (Vector<F32s>, Vector<F32s>, F32s) {
        let one = F32s::splat(1.0);
        let x =
            (film[0] * F32s::splat(2.0 / self.width as f32) - one) * F32s::splat(self.half_size[0]);
        let y = (one - film[1] * F32s::splat(2.0 / self.height as f32))
            * F32s::splat(self.half_size[1]);
        let [right, up, forward] = [self.right, self.up, self.forward].map(Vector::splat);
        let position = Vector::splat(self.position);
        let pixel_area = F32s::splat(self.pixel_area());
        if !self.perspective {
            let origin = right.mul_add(x, up.mul_add(y, position));
            return (origin, forward, one / pixel_area);
        }
        let through = right.mul_add(x, up.mul_add(y, forward));
        if !self.has_lens() {
            let direction = through.normalize();
            let cosine = direction.dot(forward);
            return (position, direction, one / (pixel_area * cosine * cosine * cosine));
        }
        let [lens_x, lens_y] = warp::disk(lens()).map(|u| u * F32s::splat(self.aperture_radius));
        let on_lens = right.mul_add(lens_x, up * lens_y);
        let direction = (through * F32s::splat(self.focus_distance) - on_lens).normalize();
        let cosine = direction.dot(forward);
        (position + on_lens, direction, one / (pixel_area * cosine * cosine * cosine))
    }

    /// Connects `point` to the point of the lens chosen by `lens` (numbers in [0, 1)), if that
    /// projects onto the film.
    pub fn connect(&self, point: Vec3, lens: [f32; 2]) -> Option<SensorConnection> {
        if !self.perspective {
            return self.connect_parallel(point);
        }
        let radius = self.aperture_radius * lens[0].sqrt();
        let (sine, cosine) = sin_cos(std::f32::consts::TAU * lens[1]);
        let on_lens = self.right * (radius * cosine) + self.up * (radius * sine);
        let from_lens = point - self.position - on_lens;
        let depth = from_lens.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        // Where the ray from the lens meets the plane at focus, as seen from the lens's center.
        let focus = on_lens / self.focus_distance + from_lens / depth;
        let film = self.film_point(focus.dot(self.right), focus.dot(self.up))?;
        let distance2 = from_lens.length_squared();
        let distance = distance2.sqrt();
        let cos = depth / distance;
        Some(SensorConnection {
            film,
            direction: -from_lens / distance,
            lens: self.position + on_lens,
            pdf_area: 1.0 / (self.pixel_area() * cos * cos * cos * distance2),
        })
    }

    /// Connects to something infinitely far away in `direction`, with the density per steradian
    /// in place of the one per area; none for parallel projection, which sees only one direction.
    pub fn connect_infinite(&self, direction: Vec3, lens: [f32; 2]) -> Option<SensorConnection> {
        if !self.perspective {
            return None;
        }
        let far = FAR * (self.focus_distance + self.aperture_radius);
        let connection = self.connect(self.position + direction * far, lens)?;
        Some(SensorConnection { pdf_area: connection.pdf_area * far * far, ..connection })
    }

    fn connect_parallel(&self, point: Vec3) -> Option<SensorConnection> {
        let offset = point - self.position;
        let depth = offset.dot(self.forward);
        let film = self.film_point(offset.dot(self.right), offset.dot(self.up))?;
        if depth <= 0.0 {
            return None;
        }
        Some(SensorConnection {
            film,
            direction: -self.forward,
            lens: point - self.forward * depth,
            pdf_area: 1.0 / self.pixel_area(),
        })
    }

    /// The point of the film at one of the image plane, in the units of `half_size`; none where it
    /// counts for no pixel.
    fn film_point(&self, right: f32, up: f32) -> Option<[f32; 2]> {
        let x = (right / self.half_size[0] + 1.0) * 0.5 * self.width as f32;
        let y = (1.0 - up / self.half_size[1]) * 0.5 * self.height as f32;
        let margin = self.margin();
        let is_within = |at: f32, side: u32| at >= -margin && at < side as f32 + margin;
        (is_within(x, self.width) && is_within(y, self.height)).then_some([x, y])
    }

    /// How far beyond the film light counts for its pixels, in pixels.
    fn margin(&self) -> f32 {
        self.layout.filter.margin().max(0.0)
    }

    fn pixel_area(&self) -> f32 {
        4.0 * self.half_size[0] * self.half_size[1] / (self.width as f32 * self.height as f32)
    }
}

/// Where numbers in [0, 1) put samples, in pixels from the center.
#[inline(never)]
fn offsets(filter: &Profile, numbers: F32s) -> F32s {
    let numbers = numbers.to_array();
    F32s::from(lanes::each(|lane| filter.draw(numbers[lane]).0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::world::Raster;

    fn sensor(projection: Projection) -> Sensor {
        let camera = Camera {
            projection,
            position: Vec3::new(1.0, 2.0, 3.0),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            resolution: None,
            raster: Raster::default(),
            analyzer: None,
        };
        Sensor::new(&camera, Layout::plain([40, 30]))
    }

    /// A ray and the connection from any point on it agree on pixel, direction and density.
    #[test]
    fn connections_reverse_rays() {
        let lens = |radius| Projection::Perspective {
            tan_half_y: 0.7,
            tan_half_x_min: 0.0,
            aspect: None,
            aperture_radius: radius,
            focus_distance: 4.0,
        };
        let parallel = Projection::Orthographic { half_width: 2.0, half_height: 1.5 };
        for projection in [lens(0.0), lens(0.25), parallel] {
            let sensor = sensor(projection);
            let u = [0.3, 0.6];
            let film = [F32s::splat(17.25), F32s::splat(8.5)];
            let (origin, direction, pdf) = sensor.rays(film, || u.map(F32s::splat));
            let row = |v: Vector<F32s>| Vec3::from_array(v.lane(0).into());
            let point = row(origin) + row(direction) * 2.5;
            let connection = sensor.connect(point, u).expect("on the film");
            let on = |axis: usize| (connection.film[axis] - [17.25, 8.5][axis]).abs() < 1e-4;
            assert!(on(0) && on(1), "{:?}", connection.film);
            let pixel = sensor.pixel_of(connection.film, || [0.0; 2]);
            assert_eq!(pixel, Some((8 * 40 + 17, 1.0)));
            assert!((connection.direction + row(direction)).length() < 1e-5);
            let area = if sensor.is_finite() { 2.5 * 2.5 } else { 1.0 };
            let expected = pdf.to_array()[0] / area;
            assert!((connection.pdf_area / expected - 1.0).abs() < 1e-4);
        }
    }
}
