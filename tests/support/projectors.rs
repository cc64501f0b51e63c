//! Spots that throw pictures.

use std::f64::consts::FRAC_PI_4;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::scenes::{CEILING, pinhole, room};
use super::skies::{noise, openexr};

/// A picture as a data URI.
pub fn uri(file: &[u8]) -> String {
    format!("data:image/x-exr;base64,{}", STANDARD.encode(file))
}

/// Of this half angle from left to right, and this intensity, in radiometric units.
pub fn light(file: &[u8], half_angle: f64, intensity: f64) -> Value {
    let keys = json!({"picture": uri(file), "units": "radiometric"});
    json!({"type": "spot", "intensity": intensity,
        "spot": {"innerConeAngle": 0.0, "outerConeAngle": half_angle},
        "extensions": {"SUNSTONE_polarization": keys}})
}

/// A file of noise, of which a fifth is black.
pub fn file(seed: u64, size: [usize; 2]) -> Vec<u8> {
    let texels = noise(seed, size, 3.0);
    openexr(size, |column, row| texels[size[0] * row + column])
}

/// One that is wide and high up, and a polarized one of a single bright column low beside it.
pub fn in_thin_air() -> World {
    let mut scene = room(&[CEILING]);
    let wide = light(&file(3, [5, 4]), FRAC_PI_4, 2.0);
    scene.light(wide, Vec3::new(0.3, 0.8, 0.2), Vec3::new(-0.2, -1.0, -0.1));
    let column = openexr([7, 3], |column, _| [f32::from(u8::from(column == 2)), 0.5, 0.0]);
    let mut bar = light(&column, 0.3, 3.0);
    bar["extensions"]["SUNSTONE_polarization"]["stokes"] = json!([0.6, 0.0, -0.7]);
    scene.light(bar, Vec3::new(-0.4, 0.2, 0.6), Vec3::new(0.3, -0.2, -1.0));
    let air = json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": 0.3});
    let air = scene.medium(air);
    scene.fog(air, |scene, null| scene.cuboid(Vec3::NEG_Y * 0.2, Vec3::splat(0.7), null));
    pinhole(scene).load("projectors in thin air")
}
