//! Emitters of which the camera sees but a glimpse: whose own images are so small that sensor paths
//! meet them straight only by chance. Light paths start on them, and those starts can be connected
//! to the sensor.

use glam::Vec3;

use crate::scattering::look::first_met;
use crate::scattering::{Scene, Sensor};
use crate::scene::baked::Shapes;
use crate::scene::emitter::Emitter;

use super::tree::Outline;
use super::{area, outline, primitive};

/// Images of at most so many pixels are small.
const PIXELS_MAX: f32 = 16.0;

/// The emitters with small images.
#[derive(Clone, Debug, Default)]
pub struct Glimpses {
    /// For every emitter the density per area of starting a light path at a point of it, or zero if
    /// its image is not small; empty if none is.
    start_pdfs: Vec<f32>,
}

impl Glimpses {
    /// Of the emitters in view.
    pub fn new(shapes: &Shapes, emitters: &[Emitter], sensor: &Sensor) -> Self {
        let start_pdf = |emitter: &Emitter| {
            let Some(area) = area(&emitter.model) else { return 0.0 };
            let is_small = image(shapes, emitter, sensor)
                .is_some_and(|(pixels, _)| pixels > 0.0 && pixels <= PIXELS_MAX);
            if is_small { emitter.probability / area } else { 0.0 }
        };
        let start_pdfs: Vec<f32> = emitters.iter().map(start_pdf).collect();
        let has_any = start_pdfs.iter().any(|&pdf| pdf > 0.0);
        Self { start_pdfs: if has_any { start_pdfs } else { Vec::new() } }
    }

    /// Whether there are any.
    pub fn has_any(&self) -> bool {
        !self.start_pdfs.is_empty()
    }

    /// The density per area of starting a light path at a point of an emitter, if its image is
    /// small; else zero.
    pub fn start_pdf(&self, emitter: usize) -> f32 {
        self.start_pdfs.get(emitter).copied().unwrap_or(0.0)
    }
}

/// How many pixels the image of an emitter takes up if nothing is before it, and the point of the
/// lens, or film, that sees the middle of the emitter; none if it is out of view.
fn image(shapes: &Shapes, emitter: &Emitter, sensor: &Sensor) -> Option<(f32, [Vec3; 2])> {
    let Outline { lower, upper, axis, two_sided, even, .. } = outline(&emitter.model, shapes);
    let middle = 0.5 * (lower + upper);
    let connection = sensor.connect(middle, [0.0; 2])?;
    let along = axis.dot(connection.direction);
    let faced = even + if two_sided { along.abs() } else { along.max(0.0) };
    Some((connection.pdf_area * faced, [connection.lens, middle]))
}

/// How many pixels the small image of an emitter takes up that the camera sees, past what light
/// goes straight on through; zero if its image is not small, or hidden.
pub fn pixels_seen<const N: usize>(scene: &Scene<N>, row: usize) -> f32 {
    if scene.glimpses.start_pdf(row) == 0.0 {
        return 0.0;
    }
    let emitter = &scene.optics.emitters[row];
    let Some((pixels, [lens, middle])) = image(&scene.shapes, emitter, &scene.sensor) else {
        return 0.0;
    };
    let own = primitive(&emitter.model);
    let passes = |it: u32| it != own && scene.material_at(it).is_straight_on();
    let met = first_met(scene, lens, middle - lens, passes);
    if met.primitive == own { pixels } else { 0.0 }
}
