//! Luminaires as files of IES LM-63 have them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::scenes::{CEILING, pinhole, room};

/// A file with these angles and intensities, for all vertical angles of the first horizontal one
/// and so on, which are to be multiplied by 0.5 times 0.8.
pub fn file(vertical: &[f64], horizontal: &[f64], candela: &[f64]) -> String {
    let words = |numbers: &[f64]| {
        numbers.iter().map(|number| format!("{number}")).collect::<Vec<String>>().join(" ")
    };
    let lines = [
        "IESNA:LM-63-2002".to_owned(),
        "[MANUFAC] nobody".to_owned(),
        "TILT=NONE".to_owned(),
        format!("1 1000 0.5 {} {} 1 2 0 0 0", vertical.len(), horizontal.len()),
        "0.8 1 40".to_owned(),
        words(vertical),
        words(horizontal),
        candela.chunks(vertical.len()).map(words).collect::<Vec<String>>().join("\r\n"),
    ];
    lines.join("\r\n") + "\r\n"
}

/// As a data URI.
pub fn uri(file: &str) -> String {
    format!("data:text/plain;base64,{}", STANDARD.encode(file))
}

/// A point light of such a file, at an intensity that makes it so many watts per steradian a
/// candela.
pub fn light(file: &str, intensity: f64) -> Value {
    json!({"type": "point", "intensity": intensity,
        "extensions": {"SUNSTONE_polarization": {"ies": uri(file)}}})
}

/// A narrow beam that is the same all around, and one with four lobes to one side of a plane.
pub fn in_thin_air() -> World {
    let mut scene = room(&[CEILING]);
    let beam = file(&[0.0, 10.0, 15.0, 90.0], &[0.0], &[30.0, 20.0, 1.0, 0.2]);
    scene.light(light(&beam, 1.0), Vec3::new(0.3, 0.7, 0.2), Vec3::new(-0.4, -1.0, -0.2));
    let lobes = file(
        &[0.0, 60.0, 120.0],
        &[0.0, 45.0, 90.0, 180.0],
        &[1.0, 9.0, 0.0, 1.0, 0.5, 1.0, 1.0, 12.0, 2.0, 1.0, 0.0, 0.0],
    );
    scene.light(light(&lobes, 0.5), Vec3::new(-0.4, 0.2, -0.3), Vec3::new(0.3, -0.2, 1.0));
    let air = json!({"phase": "rayleigh", "sigma_a": 0.05, "sigma_s": 0.3});
    let air = scene.medium(air);
    scene.fog(air, |scene, null| scene.cuboid(Vec3::NEG_Y * 0.2, Vec3::splat(0.7), null));
    pinhole(scene).load("luminaires in thin air")
}
