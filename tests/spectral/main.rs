//! Spectral renders: bands are what mono renders measure at their wavelengths, by all integrators,
//! in all modes, whole or in parts; and what the laws of optics say of prisms, balls, mirrors and
//! panes.

mod agreement;
mod ball;
mod edges;
mod films;
mod fresnel;
mod fringes;
mod gauge;
mod measured;
mod mirrors;
mod parts;
mod prism;
mod scenes;
