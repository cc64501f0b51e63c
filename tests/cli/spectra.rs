//! Spectra that do not cover the render: refused by name, or held, which is said.

use std::fs;

use serde_json::{Value, json};

use crate::program::{folder, scene, sunstone};

/// A copy of the Cornell box whose lamp is tabulated from 420 to 680 nm.
fn write_scene(path: &std::path::Path) {
    let text = fs::read_to_string(scene("cornell")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    let materials = file["materials"].as_array_mut().unwrap();
    let is_lamp = |material: &&mut Value| material.get("emissiveFactor").is_some();
    let lamp = materials.iter_mut().find(is_lamp).expect("a lamp");
    lamp["name"] = json!("tabulated lamp");
    lamp["extensions"]["SUNSTONE_polarization"]["emission"] =
        json!({"nm": [420, 680], "value": [1, 2]});
    fs::write(path, file.to_string()).unwrap();
}

#[test]
fn spectra_are_held_if_that_is_asked_for_and_it_is_said() {
    let here = folder("held");
    write_scene(&here.join("lamp.gltf"));
    let render = |name: &str, more: &[&str]| {
        let arguments = ["render", "lamp.gltf", "-o", name, "--spp", "2", "--width", "8"];
        sunstone(&here, &[&arguments[..], more].concat())
    };
    let spectral = ["--color", "spectral"];
    for color in [&spectral[..], &["--color", "mono", "--wavelength", "400"]] {
        let refused = render("a.exr", color);
        assert_ne!(refused.code, 0);
        for words in ["tabulated lamp", "what it emits", "420 to 680 nm", "--hold-spectra"] {
            assert!(refused.stderr.contains(words), "{}", refused.stderr);
        }
        let held = render("a.exr", &[color, &["--hold-spectra"]].concat()).done();
        let words = "spectra are held at their ends: ";
        assert!(held.stderr.contains(words), "{}", held.stderr);
        let said = sunstone(&here, &["inspect", "a.exr"]).done().stdout;
        assert!(said.contains("held spectra") && said.contains("below 420 nm"), "{said}");
    }
    // Where all is covered, nothing is held.
    let inside = ["--color", "mono", "--wavelength", "500", "--hold-spectra"];
    let inside = render("b.exr", &inside).done();
    assert!(!inside.stderr.contains("held"), "{}", inside.stderr);
}
