//! Spectral renders: bands are what mono renders measure at their wavelengths, by all integrators,
//! in all modes, whole or in parts.

mod agreement;
mod films;
mod gauge;
mod parts;
mod scenes;
