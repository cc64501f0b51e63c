//! Floor 7: tables of paths and vertices, and the systems that advance them.
//!
//! A stage is a free function that names the columns it writes (`&mut`, first) and reads. The
//! integrators call them in order; nothing else decides what happens next.
//!
//! # Words
//!
//! - **row**: one index into all columns of a table: a subpath, a vertex, a connection, a photon.
//! - **slot**: the place of a path in its chunk. Rows are reordered, slots stay: where a row
//!   measures, and which light path a sensor path connects to.
//! - **lane**: one of the eight rows that a loop works on at a time.
//! - **light, sensor**: the two sides, and the subpaths that start there; the object at the
//!   light's end is an emitter.
//! - **segment**: what lies between two vertices; `path_length` counts them.
//! - **given, drawn**: the directions of a vertex, both away from it: to where its subpath comes
//!   from, and where it goes on, by chance or by connection.
//! - **turn**: what a vertex does to light between the two: value, densities both ways, measure.
//! - **met**: what a segment ends at: a kind of surface, or a particle of a medium.
//! - **event**: what was met with what it does to polarization; rows of one event go through one
//!   loop.
//! - **part**: the rows of one event and one class of carriers, next to each other.
//! - **kernel**: the Mueller matrix of an event relative to its first element, between the frames
//!   of the event.
//! - **depolarizer**: an event after which light is unpolarized whatever arrived.
//! - **beta**: throughput of a row, a number per wavelength: all that scalar renders know.
//! - **carrier**: what polarized renders keep beside it: a Stokes vector (light), or the matrix or
//!   row by which the film measures one (sensor).
//! - **class**: which columns of its carrier a row has.
//! - **state**: polarized light that a vertex or connection keeps: a Stokes vector over its
//!   intensity.
//! - **connect**: to guess a segment between two vertices that a ray then tests.
//! - **take**: to bring rows of columns into a new order. **gather**: to measure the connections
//!   that are open, or the photons about a vertex.
//! - **bounce**: a vertex of a walk: which segment leads to it, on which side.
//! - **splat**: light that a connection to the sensor brings to any pixel.
//! - **merge**: to take vertices of two subpaths for one because they are near.
//! - **clearing**: the part of a kernel in which photons count, which no shape cuts off.
//! - **measure**: to add light to the film's side, through the carrier of a sensor row.
//! - **straight on**: how light goes through polarizers, retarders, thin panes and boundaries of
//!   media: what is there is no vertex.
//! - **crossing**: where a segment goes straight on through a surface; **part** of crossings: those
//!   of surfaces of one kind, one of each segment.
//! - **flight**: a segment on its way through crossings and the media between them.
//! - **inside**: the medium around a vertex.
//! - **reach**: the largest coordinate of a primitive, from which the offset follows at which rays
//!   leave it.
//! - **`pdf_w`, `pdf_a`**: densities per steradian, per area.
//! - **`d_vcm`, `d_vc`**: partial weights of strategies, after Georgiev's technical report.

pub mod bounce;
pub mod chunk;
pub mod clearing;
pub mod collapse;
pub mod crossing;
pub mod emission;
pub mod flight;
pub mod light_model;
pub mod measure;
pub mod mis;
pub mod photon;
pub mod piece;
pub mod sampler;
pub mod scale;
pub mod shift;
pub mod sides;
pub mod splat;
pub mod stages;
pub mod strategy;
pub mod tables;
pub mod vantage;
pub mod vertex;

pub use bounce::{Arrived, Bounce, Sampling};
pub use chunk::Chunk;
pub use light_model::{LightModel, Polarized, Scalar};
pub use strategy::Strategy;
