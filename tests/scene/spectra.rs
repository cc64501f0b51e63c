//! Spectra in scene files: names of substances and illuminants, formulas, lines, files.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{good, load_json, scratch};
use serde_json::{Value, json};
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{bake, held_spectra, load};
use sunstone::internals::spectrum::{Carried, Spectrum, White, index};

/// A document that is a function of a value.
fn with(pointer: &str, key: &str, value: Value) -> Value {
    let mut document = good();
    document.pointer_mut(pointer).expect("the pointer leads somewhere")[key] = value;
    document
}

#[track_caller]
fn baked(document: &Value, wavelength_nm: f32) -> BakedScene<1> {
    let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
    bake(&world, &Carried::at([wavelength_nm])).unwrap_or_else(|error| panic!("{error}"))
}

const GLOW: &str = "/materials/0/extensions/SUNSTONE_polarization";
const LIGHT: &str = "/extensions/KHR_lights_punctual/lights/0";

fn close(a: f32, b: f64) -> bool {
    (f64::from(a) - b).abs() <= 1e-6 * b.abs()
}

#[test]
fn substances_have_names() {
    let conductor = |body: Value| with("/materials/0/extensions", "SUNSTONE_polarization", body);
    let model = |body, nm| baked(&conductor(body), nm).optics.materials[0].model.clone();
    for nm in [380.0, 550.0, 780.0, 1000.0] {
        let named = model(json!({"bsdf": "conductor", "eta": "Ag", "k": "Ag"}), nm);
        assert_eq!(named, model(json!({"bsdf": "conductor", "metal": "Ag"}), nm));
        let (eta, k) = index("Ag").unwrap();
        let (eta, k) = ([eta.at(nm).unwrap()], [k.at(nm).unwrap()]);
        assert_eq!(named, SurfaceModel::Conductor { eta, k });
    }
    // A mixture: n of one and k of another.
    let mixed = model(json!({"bsdf": "conductor", "eta": "BK7", "k": "water"}), 587.56);
    let SurfaceModel::Conductor { eta: [eta], k: [k] } = mixed else { panic!("{mixed:?}") };
    assert!(close(eta, 1.516_80) || (eta - 1.5168).abs() < 1e-5);
    assert!(k > 0.0 && k < 1e-8);
}

#[test]
fn indices_have_formulas() {
    let conductor = |eta: Value| json!({"bsdf": "conductor", "eta": eta, "k": 1});
    let sellmeier = json!({"sellmeier": {
        "b": [1.03961212, 0.231792344, 1.01046945],
        "c_um2": [0.00600069867, 0.0200179144, 103.560653],
        "range_nm": [300, 2500]}});
    let cauchy = json!({"cauchy": {"a": 1.5046, "b_um2": 0.0042, "range_nm": [350, 900]}});
    let table = json!({"nm": [400, 700], "value": [1.5, 1.4]});
    for (eta, nm, expected) in [
        (sellmeier.clone(), 587.5618, 1.516_80),
        (cauchy.clone(), 500.0, 1.5046 + 0.0042 / 0.25),
        (table, 550.0, 1.45),
    ] {
        let document = with("/materials/0/extensions", "SUNSTONE_polarization", conductor(eta));
        let SurfaceModel::Conductor { eta: [eta], .. } =
            baked(&document, nm).optics.materials[0].model.clone()
        else {
            panic!("no conductor")
        };
        assert!((f64::from(eta) - expected).abs() < 1e-6, "{eta} {expected}");
    }
    // What is outside of the range is refused with the material's name.
    let document = with("/materials/0/extensions", "SUNSTONE_polarization", conductor(cauchy));
    let world = load_json(&document).unwrap();
    let error = bake(&world, &Carried::at([905.0])).unwrap_err().to_string();
    assert!(error.contains("\"glow\"") && error.contains("350 to 900 nm"), "{error}");
}

/// The index of refraction of the one dielectric, once for all columns or for each.
fn iors<const N: usize, const K: usize>(scene: &BakedScene<N>) -> [f32; K] {
    let models = scene.optics.materials.iter().map(|row| row.model.clone());
    let iors = models.filter_map(|model| match model {
        SurfaceModel::Dielectric { ior, .. } => Some(vec![ior]),
        SurfaceModel::DispersiveDielectric { ior, .. } => Some(ior.to_vec()),
        _ => None,
    });
    iors.collect::<Vec<_>>().concat().try_into().expect("as many as columns that differ")
}

/// What KHR_materials_dispersion says: n_F - n_C is (n - 1) times it over 20.
#[test]
fn abbe_numbers_make_glass_disperse() {
    let document =
        with("/materials/1/extensions", "KHR_materials_dispersion", json!({"dispersion": 0.5}));
    let world = load_json(&document).unwrap();
    let [d] = iors(&bake(&world, &Carried::RGB).unwrap());
    let [f, c] = iors(&bake(&world, &Carried::at([486.132_7, 656.272_5])).unwrap());
    assert!(((f - c) / (d - 1.0) - 0.5 / 20.0).abs() < 1e-5, "{d} {f} {c}");
    for wrong in [json!(-1.0), json!("much")] {
        let document = with(
            "/materials/1/extensions",
            "KHR_materials_dispersion",
            json!({"dispersion": wrong}),
        );
        let error = load_json(&document).unwrap_err().to_string();
        assert!(error.contains("KHR_materials_dispersion"), "{error}");
    }
}

#[test]
fn glass_of_a_name_disperses_and_has_its_index_at_the_line_d_in_rgb() {
    let glass = "/materials/1/extensions/SUNSTONE_polarization";
    // At the line d, and at 500 nm.
    for (ior, at_d, at_500) in [
        (json!("BK7"), 1.516_80, 1.521_41),
        (json!("water"), 1.333_40, 1.336_80),
        (json!({"cauchy": {"a": 1.5, "b_um2": 0.0042, "range_nm": [350, 900]}}), 1.512_17, 1.516_8),
        (json!({"nm": [500, 600], "value": [1.6, 1.5]}), 1.512_44, 1.6),
    ] {
        let document = with(glass, "ior", ior);
        let world = load_json(&document).unwrap();
        assert_eq!(world.warnings(), [] as [String; 0]);
        let [rgb] = iors(&bake(&world, &Carried::RGB).unwrap());
        assert!((f64::from(rgb) - at_d).abs() < 1e-5, "{rgb}");
        let [mono] = iors(&bake(&world, &Carried::at([500.0])).unwrap());
        assert!((f64::from(mono) - at_500).abs() < 3e-5, "{mono}");
        let several = bake(&world, &Carried::at([500.0, 587.561_8])).unwrap();
        let [first, second] = iors(&several);
        assert!(first == mono && (f64::from(second) - at_d).abs() < 1e-5, "{first} {second}");
    }
    assert_eq!(load_json(&good()).unwrap().warnings(), [] as [String; 0]);
}

#[test]
fn hosts_and_particles_have_names() {
    let mut document = good();
    let beads = json!({"eta": "polystyrene", "volume_fraction": 1e-4,
        "distribution": {"kind": "monodisperse", "radius_um": 0.1}});
    document["extras"]["sunstone"] = json!({"media": [{"name": "beads", "phase": "mie",
        "particles": [beads], "host": {"eta": "water", "k": "water"}}]});
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"]["interior"] = json!(0);
    let clear = &baked(&document, 550.0).optics;
    let red = &baked(&document, 750.0).optics;
    // Water absorbs 4 pi k / wavelength: 2.6 per meter at 750 nm, and a fiftieth in the green.
    let absorption = |optics: &sunstone::internals::scene::baked::Optics<1>| {
        optics.media.iter().map(|medium| medium.sigma_a[0]).fold(0.0, f32::max)
    };
    assert!((absorption(red) - 2.6).abs() < 0.1, "{}", absorption(red));
    assert!((absorption(clear) / absorption(red)) < 0.03);
}

/// What the lamp of a document shines at a wavelength: the square, the bulb or the sky.
fn shine(document: &Value, emitter: usize, wavelength_nm: f32) -> f32 {
    baked(document, wavelength_nm).optics.radiance_of(emitter)[0]
}

#[test]
fn lamps_have_spectra() {
    let d65 = Spectrum::illuminant("D65").unwrap();
    let hot = Spectrum::blackbody(3000.0).unwrap();
    let of = |spectrum: &Spectrum, nm| f64::from(spectrum.at(nm).unwrap());
    for nm in [400.0, 550.0, 612.5, 780.0] {
        let named = json!({"illuminant": "D65", "scale": 3});
        assert!(close(shine(&with(GLOW, "emission", named.clone()), 0, nm), 3.0 * of(&d65, nm)));
        let small = json!({"illuminant": "d65", "scale": 3});
        assert_eq!(shine(&with(GLOW, "emission", small), 0, nm), {
            shine(&with(GLOW, "emission", named.clone()), 0, nm)
        });
        let bulb = json!({"SUNSTONE_polarization": {"emission": named, "units": "radiometric"}});
        let mut document = with(LIGHT, "extensions", bulb);
        document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(2);
        assert!(close(shine(&document, 2, nm), 6.0 * of(&d65, nm)));
        let sky = json!({"radiance": {"blackbody_k": 3000}});
        let sky = with("/scenes/0", "extras", json!({"sunstone_environment": sky}));
        assert!(close(shine(&sky, 3, nm), of(&hot, nm)));
        let table = json!({"nm": [300, 900], "value": [3, 9], "scale": 0.5});
        assert!(close(shine(&with(GLOW, "emission", table), 0, nm), f64::from(nm) * 0.005));
        for (flat, value) in [(json!(0.25), 0.25), (json!({"illuminant": "E"}), 1.0)] {
            assert!(close(shine(&with(GLOW, "emission", flat), 0, nm), value));
        }
    }
    let laser = json!({"lines": [[532, 3, 2], [589, 1, 1]], "shape": "box", "scale": 2});
    let laser = with(GLOW, "emission", laser);
    assert_eq!([531.5, 589.1].map(|nm| shine(&laser, 0, nm)), [3.0, 2.0]);
    assert_eq!([531.5, 533.5].map(|nm| baked(&laser, nm).optics.emitters.len()), [3, 1]);
    // Colors remain, and the strength of glTF counts for spectra too.
    let rgb = load_json(&with(GLOW, "emission", json!([3, 2, 1]))).unwrap();
    assert_eq!(bake(&rgb, &Carried::RGB).unwrap().optics.radiance_of(0), [3.0, 2.0, 1.0]);
    let mut strong = with(GLOW, "emission", json!({"illuminant": "E"}));
    strong["materials"][0]["extensions"]["KHR_materials_emissive_strength"] =
        json!({"emissiveStrength": 5.0});
    assert_eq!(shine(&strong, 0, 500.0), 5.0);
    // Without a model the material stays what glTF says.
    let alone = json!({"name": "plain", "extras": {"sunstone_emission": {"illuminant": "E"}},
        "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1]}});
    let mut document = good();
    document["materials"][0] = alone;
    let scene = baked(&document, 500.0);
    assert_eq!(scene.optics.radiance_of(0), [1.0]);
    let [a, b] = [&document, &with(GLOW, "emission", json!(0))];
    assert!(baked(a, 500.0).optics.emitters.len() > baked(b, 500.0).optics.emitters.len());
    // Outside of what is tabulated.
    let world = load_json(&with(GLOW, "emission", json!({"illuminant": "F11"}))).unwrap();
    let error = bake(&world, &Carried::at([379.0])).unwrap_err().to_string();
    assert!(error.contains("\"glow\"") && error.contains("380 to 780"), "{error}");
}

#[test]
fn lamps_are_read_from_files() {
    let path = scratch("lamp.gltf");
    let lamp = path.with_extension("spd");
    let name = lamp.file_name().unwrap().to_str().unwrap();
    fs::write(&lamp, "# measured\n400 1\n600 3 # peak\n800,0\n").unwrap();
    let document = with(GLOW, "emission", json!({"spd": name, "scale": 2}));
    fs::write(&path, document.to_string()).unwrap();
    let scene = bake(&load(&path).unwrap(), &Carried::at([500.0])).unwrap();
    assert_eq!(scene.optics.radiance_of(0), [4.0]);
    assert!(load(&path).unwrap().files().iter().any(|file| file.ends_with(name)));
    for (text, words) in [
        ("400 1\n600 x", "emission.spd, line 2: `x` is not a finite number"),
        ("400 1\n300 1", "emission.spd, line 2: 300 nm is not greater"),
        ("# nothing\n", "emission.spd: the file needs"),
        ("400 1 1\n", "emission.spd, line 1 has 3 columns"),
        ("400 -1\n", "emission times emissiveStrength: -2 must be not negative"),
    ] {
        fs::write(&lamp, text).unwrap();
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains(words), "{text:?}: {error}");
    }
    fs::remove_file(&lamp).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("emission.spd") && error.contains("cannot read"), "{error}");
    fs::remove_file(&path).unwrap();
}

#[track_caller]
fn refused<const N: usize>(cases: [(Value, &[&str]); N]) {
    for (document, words) in cases {
        let error = load_json(&document).err().unwrap_or_else(|| panic!("accepted: {words:?}"));
        for word in words {
            assert!(error.contains(word), "no `{word}` in: {error}");
        }
    }
}

#[test]
fn what_is_no_index_is_refused() {
    let conductor = |eta: Value| json!({"bsdf": "conductor", "eta": eta, "k": 1});
    let body = |body: Value| with("/materials/0/extensions", "SUNSTONE_polarization", body);
    let eta = |eta: Value| body(conductor(eta));
    let ior = |ior: Value| with("/materials/1/extensions/SUNSTONE_polarization", "ior", ior);
    let sellmeier = |b: Value, c: Value, range: Value| {
        eta(json!({"sellmeier": {"b": b, "c_um2": c, "range_nm": range}}))
    };
    refused([
        (eta(json!("Xx")), &[".eta: `Xx` is no substance", "Ag, Al", "water"][..]),
        (eta(json!(true)), &[".eta is not a spectrum", "the name of a substance"]),
        (eta(json!([1, 2])), &[".eta is not a spectrum"]),
        (eta(json!({})), &[".eta.nm is missing"]),
        (eta(json!({"nm": [500]})), &[".eta.value is missing"]),
        (eta(json!({"nm": [500], "value": "x"})), &[".eta.value is not an array of numbers"]),
        (eta(json!({"nm": [5, 4], "value": [1, 1]})), &[".eta needs wavelengths in increasing"]),
        (eta(json!({"n": 1})), &[".eta.n is not a key", "keys of an index are cauchy, nm"]),
        (eta(json!({"sellmeier": 3})), &[".eta.sellmeier is not an object"]),
        (eta(json!({"sellmeier": {}})), &[".eta.sellmeier.b is missing", "n^2 = 1"]),
        (eta(json!({"cauchy": {}})), &[".eta.cauchy.a is missing", "n = a"]),
        (eta(json!({"cauchy": {"a": 1.5}})), &[".eta.cauchy.range_nm is missing"]),
        (
            eta(json!({"cauchy": {"a": 1.5, "range_nm": [400, 700]}, "nm": [1], "value": [1]})),
            &[".eta takes one of `sellmeier`"],
        ),
        (sellmeier(json!([1]), json!([1, 2]), json!([400, 700])), &[".eta needs as many b"]),
        (sellmeier(json!([1]), json!([0.25]), json!([400, 700])), &["a resonance"]),
        (sellmeier(json!([1]), json!([0.01]), json!([700, 400])), &["a range_nm of two"]),
        (sellmeier(json!([1]), json!([0.01]), json!([400])), &["range_nm is not two wavel"]),
        (sellmeier(json!([-9]), json!([0.01]), json!([400, 700])), &["greater than zero"]),
        (
            body(json!({"bsdf": "conductor", "eta": 1, "k": {"cauchy": {}}})),
            &[".k.cauchy is not a key"],
        ),
        (body(json!({"bsdf": "conductor", "eta": "BK7"})), &["both `eta` and `k`"]),
        (ior(json!("Ag")), &[".ior: `Ag` is a metal", "conductor"]),
        (ior(json!("ag")), &[".ior: `ag` is no substance"]),
        (ior(json!({"nm": [500, 600], "value": [-1, -1]})), &["ior", "greater than 0"]),
    ]);
}

#[test]
fn what_is_no_lamp_is_refused() {
    let glow = |emission: Value| with(GLOW, "emission", emission);
    refused([
        (glow(json!({})), &[".emission takes one of blackbody_k, illuminant"][..]),
        (glow(json!({"scale": 2})), &[".emission takes one of"]),
        (glow(json!({"illuminant": "D65", "blackbody_k": 1000})), &["say once how it shines"]),
        (glow(json!({"illuminant": "D66"})), &[".illuminant: `D66` is no illuminant", "LED-V2"]),
        (glow(json!({"illuminant": 65})), &[".illuminant is not a string"]),
        (glow(json!({"illuminant": "E", "scale": -1})), &[".scale: -1 must be not negative"]),
        (glow(json!({"illuminant": "E", "scale": 1e39})), &["emission.scale"]),
        (glow(json!({"illuminant": "E", "shape": "box"})), &[".shape means nothing without"]),
        (glow(json!({"illuminant": "E", "value": [1]})), &[".value means nothing without `nm`"]),
        (glow(json!({"blackbody_k": 100})), &[".blackbody_k: 100 must be within [500"]),
        (glow(json!({"blackbody_k": "hot"})), &[".blackbody_k is not a number"]),
        (glow(json!({"lines": []})), &[".lines needs one to 10000 lines"]),
        (glow(json!({"lines": 5})), &[".lines is not three numbers"]),
        (glow(json!({"lines": [[1, 2]]})), &[".lines is not three numbers", "width_nm"]),
        (glow(json!({"lines": [[500, 1, 0]]})), &[".lines[0].width_nm: 0 must be greater"]),
        (glow(json!({"lines": [[500, -1, 1]]})), &[".lines[0].power: -1 must be not negative"]),
        (glow(json!({"lines": [[500, 1, 1]], "shape": "round"})), &["`round` is not the shape"]),
        (glow(json!({"spd": "../lamp.spd"})), &[".emission.spd"]),
        (glow(json!({"spd": 5})), &[".spd is not a string"]),
        (glow(json!({"nm": [500], "value": [-1]})), &["emission times", "-1 must be not negative"]),
        (glow(json!("D65")), &[".emission is not a spectrum", "illuminant"]),
        (
            with(LIGHT, "extensions", json!({"SUNSTONE_polarization": {"emission": -1}})),
            &["intensity times emission", "must be not negative"],
        ),
    ]);
}

/// What comes with the program renders over visible light without a word.
#[test]
fn shipped_scenes_cover_visible_light() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files = ["", "reference"]
        .into_iter()
        .flat_map(|name| fs::read_dir(folder.join(name)).expect("the scenes are there"));
    let paths = files.map(|file| file.expect("a readable entry").path());
    let mut count = 0;
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|it| it == "gltf" || it == "glb");
    for path in paths.filter(is_scene) {
        let world = load(&path).unwrap_or_else(|error| panic!("{error}"));
        for ends in [[380.0, 780.0], [400.0, 700.0]] {
            let carried = Carried::set(ends).under(White::D65);
            assert_eq!(held_spectra(&world, &carried).map_err(|it| it.to_string()), Ok(vec![]));
        }
        count += 1;
    }
    assert!(count > 6);
}
