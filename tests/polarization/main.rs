//! The mathematics of polarization against laws, published tables and fields traced elsewhere.

mod chains;
mod columns;
mod film;
mod fresnel;
mod laws;
mod mie;
mod milk;
mod particles;
mod traced;
mod vertex;
