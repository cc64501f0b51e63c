//! Chains of events traced elsewhere as electric fields in three dimensions, read from
//! `tests/data/chains/chains.json`, and their translation into kernels of this crate.

use serde::Deserialize;
use sunstone::internals::math::{Real, Vector};
use sunstone::internals::polarization::elements::{polarizer_block, retarder_block};
use sunstone::internals::polarization::mie::MieSphere;
use sunstone::internals::polarization::rayleigh::rayleigh;
use sunstone::internals::polarization::{Block, LightCarrier, Stokes};
use sunstone::internals::polarization::{conductor, dielectric, film_axis, s_axis};

use crate::vertex::Vertex;

/// One chain from a light to a camera.
#[derive(Deserialize)]
pub struct Chain {
    pub id: usize,
    pub dir: [f64; 3],
    pub x_axis: [f64; 3],
    pub stokes_in: [f64; 4],
    pub events: Vec<Step>,
    pub camera_up: [f64; 3],
    pub dir_out: [f64; 3],
    pub camera_x: [f64; 3],
    pub stokes_out: [f64; 4],
}

/// One event, as the file describes it; normals point against the ray.
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Step {
    Reflect { n_i: f64, n_t: f64, k_t: f64, normal: [f64; 3] },
    Transmit { n_i: f64, n_t: f64, normal: [f64; 3] },
    Rayleigh { dir_out: [f64; 3] },
    Mie { n_rel: f64, k_rel: f64, size_parameter: f64, dir_out: [f64; 3] },
    Polarizer { axis: [f64; 3] },
    Retarder { axis: [f64; 3], retardance: f64 },
}

/// A chain as this crate sees it: scalar throughput aside, events from the light on.
pub struct Traced<F> {
    pub beta: F,
    pub light: LightCarrier<F>,
    /// The direction of every segment, one more than there are events.
    pub directions: Vec<Vector<F>>,
    pub events: Vec<Vertex<F>>,
    pub film_x: Vector<F>,
}

pub fn load() -> Vec<Chain> {
    let text = include_str!("../data/chains/chains.json");
    serde_json::from_str(text).expect("the chains are valid JSON")
}

/// A vector rounded to the precision of `F`.
pub fn lift<F: Real>(vector: [f64; 3]) -> Vector<F> {
    Vector::new(F::splat(vector[0]), F::splat(vector[1]), F::splat(vector[2]))
}

/// Directions are found in `f64` and rounded; everything else is computed in `F`.
pub fn trace<F: Real>(chain: &Chain) -> Traced<F> {
    let mut direction = chain.dir;
    let mut beta = F::one();
    let (mut directions, mut events) = (vec![lift(direction)], Vec::new());
    for step in &chain.events {
        let direction_next = step.direction_out(direction);
        let (m00, event) = step.event::<F>(direction, direction_next);
        beta = beta * m00;
        events.push(event);
        directions.push(lift(direction_next));
        direction = direction_next;
    }
    let ray_direction = direction.map(|component| -component);
    Traced {
        beta,
        light: LightCarrier {
            stokes: Stokes(chain.stokes_in.map(F::splat)),
            x: lift(chain.x_axis),
        },
        directions,
        events,
        film_x: film_axis(lift(ray_direction), lift(chain.camera_up)),
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Step {
    fn direction_out(&self, k: [f64; 3]) -> [f64; 3] {
        match *self {
            Step::Reflect { normal, .. } => {
                let along = 2.0 * dot(normal, k);
                std::array::from_fn(|i| k[i] - along * normal[i])
            }
            Step::Transmit { n_i, n_t, normal } => {
                let (cos_i, eta) = (-dot(normal, k), n_t / n_i);
                let cos_t = dielectric(cos_i, eta).cos_t;
                std::array::from_fn(|i| k[i] / eta + (cos_i / eta - cos_t) * normal[i])
            }
            Step::Rayleigh { dir_out } | Step::Mie { dir_out, .. } => dir_out,
            Step::Polarizer { .. } | Step::Retarder { .. } => k,
        }
    }

    /// `M00` and the event.
    fn event<F: Real>(&self, k_in: [f64; 3], k_out: [f64; 3]) -> (F, Vertex<F>) {
        let cos_theta = dot(k_in, k_out);
        let (k_in, k_out) = (lift::<F>(k_in), lift::<F>(k_out));
        let ((m00, kernel), x) = match *self {
            Step::Reflect { n_i, n_t, k_t, normal } => {
                let normal = lift::<F>(normal);
                let (cos_i, eta) = (-normal.dot(k_in), F::splat(n_t / n_i));
                let reflection = if k_t == 0.0 {
                    let interface = dielectric(cos_i, eta);
                    (interface.reflectance, interface.reflection)
                } else {
                    conductor(cos_i, eta, F::splat(k_t / n_i))
                };
                (reflection, s_axis(normal, k_in))
            }
            Step::Transmit { n_i, n_t, normal } => {
                let normal = lift::<F>(normal);
                let interface = dielectric(-normal.dot(k_in), F::splat(n_t / n_i));
                ((interface.transmittance, interface.transmission), s_axis(normal, k_in))
            }
            Step::Rayleigh { .. } => (rayleigh(k_in.dot(k_out)), k_in.cross(k_out).normalize()),
            Step::Mie { n_rel, k_rel, size_parameter, .. } => {
                let sphere = MieSphere::new(n_rel, k_rel, size_parameter);
                (lift_block(sphere.phase(cos_theta).block()), k_in.cross(k_out).normalize())
            }
            Step::Polarizer { axis } => (lift_block(polarizer_block(1.0, 0.0)), lift(axis)),
            Step::Retarder { axis, retardance } => {
                (lift_block((1.0, retarder_block(retardance.to_degrees()))), lift(axis))
            }
        };
        (m00, Vertex { kernel, x, k_in, k_out })
    }
}

/// A kernel that exists in `f64` only, rounded.
fn lift_block<F: Real>((m00, block): (f64, Block<f64>)) -> (F, Block<F>) {
    let Block { a, c, s } = block;
    (F::splat(m00), Block { a: F::splat(a), c: F::splat(c), s: F::splat(s) })
}
