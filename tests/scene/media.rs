//! Participating media: what files say about them, what lies on the two sides of a surface, and
//! what is refused.

use std::f64::consts::PI;
use std::time::Instant;

use crate::common::{data_uri, good, load_json};
use serde_json::{Value, json};
use sunstone::internals::polarization::mie::MieSphere;
use sunstone::internals::scene::bake;
use sunstone::internals::scene::baked::{BakedScene, KEEP, NONE, Phase, PhaseTable};
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::spectrum::{Beyond, Carried};

/// The good document with two media; the sphere of glass is number 2 of its nodes.
fn with_media() -> Value {
    let mut document = good();
    document["extras"] = json!({"sunstone": {"media": [
        {"name": "fog", "phase": "hg", "g": [0.5, 0.6, 0.7], "sigma_a": 0.25, "sigma_s": [1, 2, 3]},
        {"phase": "rayleigh", "sigma_a": 0, "sigma_s": 1.5},
    ]}});
    document
}

/// Sets a key of the extension of the sphere's node.
fn side(document: &mut Value, key: &str, value: Value) {
    document["nodes"][2]["extensions"]["SUNSTONE_polarization"][key] = value;
}

/// Replaces the material of the sphere.
fn sphere_of(document: &mut Value, body: Value) {
    document["materials"][1]["extensions"]["SUNSTONE_polarization"] = body;
}

fn medium(document: &mut Value, index: usize) -> &mut Value {
    &mut document["extras"]["sunstone"]["media"][index]
}

#[track_caller]
fn baked(document: &Value) -> BakedScene<3> {
    let world = load_json(document).unwrap_or_else(|error| panic!("{error}"));
    bake(&world, &Carried::RGB).unwrap_or_else(|error| panic!("{error}"))
}

/// Media behind and before the sphere, whose surface is the last.
#[track_caller]
fn sides(document: &Value) -> (u32, u32) {
    let surface = *baked(document).shapes.surfaces.last().unwrap();
    (surface.interior, surface.exterior)
}

/// Media go by their index, and where something else stands the error says which there are.
#[test]
fn what_is_no_medium_is_told_with_those_there_are() {
    let scene = |medium: Value| {
        let mut document = with_media();
        document["scenes"][0]["extras"] = json!({"sunstone": {"medium": medium}});
        document
    };
    let node = |medium: Value| {
        let mut document = with_media();
        side(&mut document, "interior", medium);
        document
    };
    for wrong in [json!("fog"), json!("milk"), json!(2), json!(-1), json!(0.5), json!({})] {
        for (document, key) in [(scene(wrong.clone()), "medium"), (node(wrong.clone()), "interior")]
        {
            let error = load_json(&document).map(drop).unwrap_err();
            let problem = format!("{key}: {wrong} is not an index into the file's 2 media");
            assert!(error.contains(&problem), "{error}");
            assert!(error.contains("give 0 for \"fog\", 1; or null for nothing"), "{error}");
        }
    }
    let mut none = good();
    none["extras"] = json!({"sunstone": {"medium": "milk"}});
    let error = load_json(&none).map(drop).unwrap_err();
    assert!(error.contains("add `media` to the scene, of which the first is 0"), "{error}");
    for nothing in [Value::Null, json!("none")] {
        assert_eq!(baked(&scene(nothing.clone())).shapes.scene_medium, NONE);
        assert_eq!(sides(&node(nothing)).0, NONE);
    }
}

/// Names of tables stand for indices of refraction; elsewhere the error says what does.
#[test]
fn names_where_none_are_known_are_told() {
    let of = |key: &str, value: Value| {
        let mut document = with_media();
        medium(&mut document, 0)[key] = value;
        load_json(&document).map(drop).unwrap_err()
    };
    for key in ["sigma_a", "sigma_s", "g"] {
        let error = of(key, json!("water"));
        assert!(
            error.contains(&format!("{key} is not a spectrum: `water` is a name, and none")),
            "{error}"
        );
        assert!(error.contains("write a number, [red, green, blue] or {\"nm\""), "{error}");
    }
    let mut document = with_media();
    *medium(&mut document, 0) = json!({"phase": "mie", "host": "water", "particles": [
        {"eta": 1.5, "volume_fraction": 1e-3,
            "distribution": {"kind": "monodisperse", "radius_um": 0.1}}]});
    let error = load_json(&document).map(drop).unwrap_err();
    assert!(error.contains("host is not an object"), "{error}");
    assert!(error.contains("write {\"eta\": \"water\"}"), "{error}");
    let mut document = good();
    document["materials"][0]["extensions"]["SUNSTONE_polarization"]["emission"] = json!("D65");
    let error = load_json(&document).map(drop).unwrap_err();
    assert!(error.contains("write {\"illuminant\": \"D65\"}"), "{error}");
}

#[test]
fn media_become_rows_in_their_order() {
    let mut document = with_media();
    document["scenes"][0]["extras"] = json!({"sunstone": {"medium": 1}});
    let scene = baked(&document);
    assert_eq!((scene.optics.media.len(), scene.shapes.scene_medium), (2, 1));
    assert_eq!(
        (scene.optics.media[0].sigma_a, scene.optics.media[0].sigma_s),
        ([0.25; 3], [1.0, 2.0, 3.0])
    );
    assert_eq!(scene.optics.media[0].phase, Phase::HenyeyGreenstein { g: [0.5, 0.6, 0.7] });
    let Phase::Table(table) = &scene.optics.media[1].phase else { panic!("not a table") };
    assert!(table.spheres && table.achromatic);
    let text = load_json(&document).unwrap().describe();
    for expected in ["[0] \"fog\": sigma_a 0.25, sigma_s [1, 2, 3]", "Rayleigh", "fills the scene"]
    {
        assert!(text.contains(expected), "no `{expected}` in: {text}");
    }
    let scene = baked(&good());
    assert_eq!((scene.optics.media.len(), scene.shapes.scene_medium), (0, NONE));
}

#[test]
fn glass_is_clear_and_stands_in_the_scenes_medium() {
    let mut document = with_media();
    assert_eq!(sides(&document), (NONE, NONE));
    side(&mut document, "interior", json!(1));
    assert_eq!(sides(&document), (1, NONE));
    document["extras"]["sunstone"]["medium"] = json!(0);
    assert_eq!(sides(&document), (1, 0));
    side(&mut document, "exterior", json!(1));
    assert_eq!(sides(&document), (1, 1));
    for clear in [json!("none"), Value::Null] {
        side(&mut document, "interior", clear.clone());
        side(&mut document, "exterior", clear.clone());
        assert_eq!(sides(&document), (NONE, NONE));
        document["extras"]["sunstone"]["medium"] = clear;
        assert_eq!(baked(&document).shapes.scene_medium, NONE);
        document["extras"]["sunstone"]["medium"] = json!(0);
    }
}

#[test]
fn sheets_keep_the_medium_unless_told() {
    for body in [
        json!({"bsdf": "polarizer"}),
        json!({"bsdf": "retarder", "retardance_deg": 90}),
        json!({"bsdf": "diffuse"}),
        json!({"bsdf": "conductor", "metal": "Al"}),
        json!({"bsdf": "absorber"}),
    ] {
        let mut document = with_media();
        sphere_of(&mut document, body);
        document["extras"]["sunstone"]["medium"] = json!(0);
        assert_eq!(sides(&document), (KEEP, KEEP));
    }
    let mut document = with_media();
    sphere_of(&mut document, json!({"bsdf": "polarizer"}));
    document["extras"]["sunstone"]["medium"] = json!(0);
    side(&mut document, "interior", json!(1));
    assert_eq!(sides(&document), (1, 0));
}

#[test]
fn null_surfaces_bound_media() {
    let mut document = with_media();
    sphere_of(&mut document, json!({"bsdf": "null"}));
    side(&mut document, "interior", json!(0));
    assert_eq!(sides(&document), (0, NONE));
    assert_eq!(baked(&document).optics.materials.last().unwrap().model, SurfaceModel::Null);
    document["extras"]["sunstone"]["medium"] = json!(1);
    assert_eq!(sides(&document), (0, 1));
    let node = &mut document["nodes"][2]["extensions"]["SUNSTONE_polarization"];
    *node = json!({"shape": 0, "exterior": "none"});
    assert_eq!(sides(&document), (1, NONE));
}

#[test]
fn meshes_have_sides_too() {
    let mut document = with_media();
    document["materials"][0]["extensions"]["SUNSTONE_polarization"] = json!({"bsdf": "dielectric"});
    document["nodes"][1]["extras"] = json!({"sunstone_interior": 0});
    let scene = baked(&document);
    assert_eq!((scene.shapes.surfaces[0].interior, scene.shapes.surfaces[0].exterior), (0, NONE));
}

#[test]
fn boundaries_between_dielectrics() {
    let mut document = good();
    sphere_of(&mut document, json!({"bsdf": "dielectric", "ior": 1.33, "exterior_ior": 1.5}));
    let row = baked(&document).optics.materials.last().unwrap().clone();
    assert_eq!(row.model, SurfaceModel::Dielectric { ior: 1.33, exterior_ior: 1.5 });
    assert!(load_json(&document).unwrap().describe().contains("1.5 before it"));
}

/// What is done to the document with media, and what the error must say.
type Case = (fn(&mut Value), &'static [&'static str]);

#[track_caller]
pub fn refused(cases: &[Case]) {
    for (number, (spoil, expected)) in cases.iter().enumerate() {
        let mut document = with_media();
        spoil(&mut document);
        let error = match load_json(&document) {
            Ok(world) => bake(&world, &Carried::RGB).map(|_| ()).map_err(|e| e.to_string()),
            Err(error) => Err(error),
        };
        let Err(error) = error else { panic!("case {number} ({expected:?}) was accepted") };
        assert!(error.contains("scene.gltf: "), "case {number} names no file: {error}");
        for part in *expected {
            assert!(error.contains(part), "case {number}: no `{part}` in: {error}");
        }
    }
}

/// Replaces the second medium.
fn second(document: &mut Value, body: Value) {
    *medium(document, 1) = body;
}

/// A suspension of monodisperse spheres in water.
fn suspension() -> Value {
    json!({"phase": "mie", "host": {"eta": 1.33, "k": 1e-9}, "particles": [{
        "distribution": {"kind": "monodisperse", "radius_um": 0.5}, "eta": 1.59,
        "volume_fraction": 1e-5}]})
}

fn table(scene: &BakedScene<3>) -> &PhaseTable<3> {
    let Phase::Table(table) = &scene.optics.media[1].phase else { panic!("not a table") };
    table
}

#[test]
fn spheres_bring_their_coefficients() {
    let mut document = with_media();
    second(&mut document, suspension());
    let scene = baked(&document);
    let medium = &scene.optics.media[1];
    // Q_sca 3 f / (4 r), with the efficiency of the single sphere.
    let sphere = MieSphere::new(1.59 / 1.33, 0.0, 2.0 * PI * 1.33 * 0.5 / 0.55);
    let expected = 1e-5 * 0.75 / 0.5e-6 * sphere.q_sca;
    assert!((f64::from(medium.sigma_s[1]) / expected - 1.0).abs() < 1e-6);
    let host = 4.0 * PI * 1e-9 / 550e-9 * (1.0 - 1e-5);
    assert!((f64::from(medium.sigma_a[1]) / host - 1.0).abs() < 1e-4);
    let phase = table(&scene);
    assert!(phase.spheres && !phase.achromatic && phase.m00.len() == 513);
    let at_right_angle = sphere.phase(0.0);
    assert!((f64::from(phase.m00[256][1]) / at_right_angle.m00 - 1.0).abs() < 1e-3);
    let a = at_right_angle.m01 / at_right_angle.m00;
    assert!((f64::from(phase.elements[256][0][1]) - a).abs() < 1e-6);
    assert!(load_json(&document).unwrap().describe().contains("mean radius 0.5000 um"));

    let mut given = suspension();
    given["sigma_s"] = json!(7);
    second(&mut document, given);
    assert_eq!(baked(&document).optics.media[1].sigma_s, [7.0; 3]);
}

#[test]
fn milk_is_a_recipe() {
    let mut document = with_media();
    let milk = json!({"fat_percent": 3.5, "protein_percent": 3.4, "dilution": 0.00025});
    second(&mut document, json!({"phase": "mie", "milk": milk}));
    let start = Instant::now();
    let scene = baked(&document);
    println!("milk in RGB: {:?}", start.elapsed());
    let medium = &scene.optics.media[1];
    for (found, expected) in medium.sigma_s.into_iter().zip([37_483.67, 51_900.22, 74_917.96]) {
        assert!((found / (0.00025 * expected) - 1.0).abs() < 1e-5, "{found}");
    }
    let absorption = 0.00025 * (4.810_21 + 1.318_741_6) + 0.056_502_97;
    assert!((medium.sigma_a[1] / absorption - 1.0).abs() < 1e-5);
    let phase = table(&scene);
    assert!(phase.spheres && !phase.achromatic);
    assert!(phase.m00.iter().flatten().all(|m00| *m00 > 0.0));
    let world = load_json(&document).unwrap();
    assert!(bake(&world, &Carried::at([800.5])).is_err());
    for carried in [Carried::at([380.0]), Carried::at([780.0])] {
        assert!(bake(&world, &carried).is_ok());
    }
    assert!(bake(&world, &Carried::at([900.0]).beyond(Beyond::Held)).is_ok());
}

/// A CSV of Rayleigh's matrix at some angles, as a data URI.
fn rayleigh_csv(head: &str, prefix: &str, scale: f64) -> String {
    let mut text = format!("# dipoles\n{head}\n");
    for step in 0..=360 {
        let theta = 0.5 * f64::from(step);
        let cos = theta.to_radians().cos();
        let unit = scale * 3.0 / (16.0 * PI);
        let (sum, difference, twice) =
            (unit * (1.0 + cos * cos), unit * (1.0 - cos * cos), unit * 2.0 * cos);
        text += &format!("{prefix}{theta},{sum},{difference},{sum},{twice},0,{twice}\n");
    }
    data_uri(text.as_bytes())
}

fn tabulated(table: impl Into<Value>) -> Value {
    let table: Value = table.into();
    json!({"phase": "mueller_table", "sigma_a": 0, "sigma_s": 1, "table": table})
}

const HEAD: &str = "theta_deg,M00,M01,M11,M22,M23,M33";

#[test]
fn tables_are_the_functions_they_tabulate() {
    let mut document = with_media();
    let analytic = table(&baked(&document)).clone();
    second(&mut document, tabulated(rayleigh_csv(HEAD, "", 1.0)));
    assert_eq!(load_json(&document).unwrap().warnings(), [] as [String; 0]);
    let scene = baked(&document);
    let found = table(&scene);
    assert_eq!(found.m00.len(), 721, "a multiple of the file's own angles");
    assert!(found.spheres && found.achromatic);
    for degrees in (0..=180).step_by(45) {
        let (index, other) = (degrees * 4, degrees * 1024 / 180);
        assert!((found.m00[index][0] / analytic.m00[other][0] - 1.0).abs() < 1e-4);
        for (a, b) in found.elements[index].iter().zip(&analytic.elements[other]) {
            assert!((a[2] - b[2]).abs() < 1e-5, "{degrees}: {a:?} {b:?}");
        }
    }
    // The same in the scene, and not normalized.
    second(&mut document, tabulated(rayleigh_csv(HEAD, "", 1.5)));
    let warning = load_json(&document).unwrap().warnings().join("");
    assert!(warning.contains("media[1].table: M00 integrates to 1.5"), "{warning}");
    assert!((table(&baked(&document)).m00[360][0] / found.m00[360][0] - 1.0).abs() < 1e-6);
    let inline = json!({"theta_deg": [0, 90, 180], "m00": [0.08, 0.08, 0.08], "m01": [0, 0.02, 0],
        "m11": [0.04, 0.04, 0.04], "m22": [0.04, 0, -0.04], "m23": [0, 0.01, 0],
        "m33": [0.02, 0, -0.02]});
    second(&mut document, tabulated(inline));
    let scene = baked(&document);
    let found = table(&scene);
    assert!(!found.spheres && found.achromatic && found.m00.len() == 513);
    assert_eq!(found.elements[256].map(|row| row[0]), [0.25, 0.5, 0.0, 0.0, 0.125]);
}

#[test]
fn tables_of_several_wavelengths() {
    let head = "Lambda_nm,theta_deg,M00,M01,M22,M23,note";
    let mut text = format!("{head}\n");
    for (nm, m01) in [(450, 0.0), (650, 0.04)] {
        for theta in [0, 90, 180] {
            text += &format!("{nm},{theta},0.08,{m01},0.01,0,x\n");
        }
    }
    let mut document = with_media();
    second(&mut document, tabulated(data_uri(text.as_bytes())));
    let world = load_json(&document).unwrap();
    assert!(world.warnings().join("").contains("the column note is ignored"));
    let scene = baked(&document);
    let found = table(&scene);
    assert!(found.spheres && !found.achromatic);
    for (value, expected) in found.elements[100][0].into_iter().zip([0.5, 0.25, 0.0]) {
        assert!((value - expected).abs() < 1e-6);
    }
    let error = bake(&world, &Carried::at([700.0])).unwrap_err().to_string();
    assert!(error.contains("media[1]") && error.contains("450 to 650"), "{error}");
}

#[test]
fn bad_tables_are_refused() {
    fn csv(document: &mut Value, text: &str) {
        second(document, tabulated(data_uri(text.as_bytes())));
    }
    refused(&[
        (|d| second(d, tabulated(3)), &["media[1].table", "neither a path nor an object"]),
        (|d| second(d, tabulated("none.csv")), &["media[1].table", "none.csv", "beside"]),
        (|d| second(d, tabulated("/etc/passwd")), &["table", "not a path relative"]),
        (|d| csv(d, ""), &["media[1].table", "no column theta_deg"]),
        (|d| csv(d, "theta_deg,M00,M01,M22\n0,1,0,1\n"), &["no column M23", "columns are"]),
        (|d| csv(d, "theta_deg,M00,M01,M22,M23\n"), &["needs rows"]),
        (|d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1\n"), &["line 2", "2 columns, not 5"]),
        (|d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,x,0\n"), &["line 2", "`x`"]),
        (|d| csv(d, "theta_deg,M00,M00\n0,1,0\n"), &["two columns m00"]),
        (|d| csv(d, "theta_deg,M00,M01,M11,M22,M23\n0,1,0,1,1,0\n"), &["M11 and M33"]),
        (
            |d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,1,0\n90,1,0,0,0\n"),
            &["covers 0 to 90 degrees"],
        ),
        (
            |d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,1,0\n180,-1,0,0,0\n"),
            &["M00 is negative at 180"],
        ),
        (|d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,1,0\n180,NaN,0,0,0\n"), &["not finite"]),
        (
            |d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,1,0\n180,1,0,-2,0\n"),
            &["exceeds M00 at 180"],
        ),
        (
            |d| csv(d, "theta_deg,M00,M01,M22,M23\n0,1,0,1,0\n0,1,0,1,0\n180,1,0,0,0\n"),
            &["increasing angles"],
        ),
        (
            |d| csv(d, "theta_deg,M00,M01,M22,M23\n0,0,0,0,0\n180,0,0,0,0\n"),
            &["M00 integrates to 0"],
        ),
        (
            |d| csv(d, "nm,theta_deg,M00,M01,M22,M23\n9,0,1,0,0,0\n9,180,1,0,0,0\n8,0,1,0,0,0"),
            &["increasing wavelength"],
        ),
        (
            |d| second(d, tabulated(json!({"theta_deg": [0, 180], "m00": [1]}))),
            &["media[1].table", "no column M01"],
        ),
        (
            |d| second(d, tabulated(json!({"theta": []}))),
            &["table.theta", "not a key", "lambda_nm"],
        ),
    ]);
}

#[test]
fn bad_particles_are_refused() {
    fn spoilt(document: &mut Value, spoil: impl Fn(&mut Value)) {
        let mut body = suspension();
        spoil(&mut body);
        second(document, body);
    }
    fn sizes(document: &mut Value, distribution: Value) {
        spoilt(document, |body| body["particles"][0]["distribution"] = distribution.clone());
    }
    refused(&[
        (|d| second(d, json!({"phase": "mie"})), &["media[1]", "either `milk` or both"]),
        (|d| spoilt(d, |b| b["milk"] = json!({})), &["media[1]", "either `milk`"]),
        (|d| spoilt(d, |b| b["particles"] = json!([])), &["media[1].particles", "0 kinds"]),
        (|d| spoilt(d, |b| b["host"] = json!({})), &["media[1].host.eta", "missing"]),
        (|d| spoilt(d, |b| b["host"]["eta"] = json!(0)), &["host.eta", "within [0.05, 20]"]),
        (
            |d| spoilt(d, |b| b["particles"][0]["eta"] = json!(1.33)),
            &["media[1]", "host's own index"],
        ),
        (
            |d| spoilt(d, |b| b["particles"][0]["volume_fraction"] = json!(0)),
            &["particles[0].volume_fraction", "greater than 0"],
        ),
        (|d| sizes(d, json!({})), &["particles[0].distribution.kind", "missing", "log_normal"]),
        (|d| sizes(d, json!({"kind": "fractal"})), &["`fractal`", "monodisperse"]),
        (|d| sizes(d, json!({"kind": "monodisperse"})), &["radius_um", "missing"]),
        (|d| sizes(d, json!({"kind": "monodisperse", "radius_um": 0})), &["radius_um", "within"]),
        (
            |d| sizes(d, json!({"kind": "monodisperse", "radius_um": 1, "of": "number"})),
            &["distribution.of", "means nothing"],
        ),
        (
            |d| sizes(d, json!({"kind": "gamma", "mean_um": 1, "sd_um": 0.2})),
            &["distribution.of", "missing", "\"volume\""],
        ),
        (
            |d| {
                sizes(
                    d,
                    json!({"kind": "log_normal", "mean_um": 1, "sd_um": 0.2, "of": "number",
                    "range_um": [2, 1]}),
                )
            },
            &["range_um", "the lesser first"],
        ),
        (
            |d| sizes(d, json!({"kind": "table", "radii_um": [1], "density": [1], "of": "number"})),
            &["particles[0].distribution", "at least two"],
        ),
        (
            |d| sizes(d, json!({"kind": "monodisperse", "radius_um": 900})),
            &["media[1]", "size parameter", "mueller_table"],
        ),
        (
            |d| second(d, json!({"phase": "mie", "milk": {"fat_percent": 3.5}})),
            &["media[1].milk.protein_percent", "missing"],
        ),
        (
            |d| {
                second(
                    d,
                    json!({"phase": "mie",
                    "milk": {"fat_percent": 0, "protein_percent": 0}}),
                )
            },
            &["media[1].milk", "would fill 0 of the volume"],
        ),
    ]);
}

#[test]
fn bad_media_are_refused() {
    refused(&[
        (|d| d["extras"]["sunstone"]["media"] = json!(3), &["root", "media", "not an array"]),
        (|d| *medium(d, 1) = json!(3), &["media[1]", "not an object"]),
        (|d| *medium(d, 0) = json!({}), &["media[0].", "phase", "missing", "hg, isotropic"]),
        (|d| medium(d, 0)["phase"] = json!("fog"), &["media[0] \"fog\".phase", "`fog`", "use one"]),
        (|d| medium(d, 0)["color"] = json!(1), &["media[0] \"fog\".color", "not a key", "sigma_a"]),
        (|d| medium(d, 0)["sigma_a"] = json!(-1), &["\"fog\".sigma_a", "-1", "not negative"]),
        (|d| medium(d, 0)["sigma_s"] = Value::Null, &["\"fog\".sigma_s", "is missing"]),
        (|d| *medium(d, 1) = json!({"phase": "isotropic"}), &["media[1]", "sigma_a", "missing"]),
        (|d| medium(d, 0)["g"] = json!(1), &["\"fog\".g", "within (-1, 1)"]),
        (|d| medium(d, 1)["g"] = json!(0), &["media[1].g", "means nothing", "depolarization"]),
        (|d| medium(d, 1)["depolarization"] = json!(0.6), &["depolarization", "[0, 0.5]"]),
        (|d| medium(d, 1)["sigma_s"] = json!({"nm": [500, 600], "value": [1, 1]}), &["media[1]"]),
        (
            |d| {
                let fog = medium(d, 1).clone();
                d["extras"]["sunstone"]["media"] = vec![fog; 4097].into();
            },
            &["media", "4097", "more than 4096"],
        ),
        (|d| d["extras"]["sunstone"]["medium"] = json!(2), &["root", "medium", "2 media"]),
        (
            |d| d["scenes"][0]["extras"] = json!({"sunstone_media": []}),
            &["scene 0 \"good\", extras.sunstone_media", "described twice", "root"],
        ),
    ]);
}

#[test]
fn bad_boundaries_are_refused() {
    refused(&[
        (|d| side(d, "interior", json!(2)), &["node 2 \"ball\"", "interior", "2 media"]),
        (|d| side(d, "exterior", json!("air")), &["node 2 \"ball\"", "exterior", "\"air\""]),
        (
            |d| {
                sphere_of(d, json!({"bsdf": "conductor", "metal": "Al"}));
                side(d, "exterior", json!(0));
            },
            &["node 2 \"ball\"", "exterior", "an opaque surface has nothing behind it"],
        ),
        (
            |d| d["nodes"][1]["extras"] = json!({"sunstone_interior": 0}),
            &["node 1 \"panel\", extras.sunstone_interior", "opaque", "null"],
        ),
        (
            |d| d["nodes"][0]["extras"] = json!({"sunstone_interior": 0}),
            &["node 0 \"eye\", extras.sunstone_interior", "belongs to a mesh"],
        ),
        (|d| sphere_of(d, json!({"bsdf": "null"})), &["node 2 \"ball\"", "null", "`interior`"]),
        (|d| sphere_of(d, json!({"bsdf": "null", "ior": 1.5})), &["ior", "means nothing"]),
        (
            |d| sphere_of(d, json!({"bsdf": "dielectric", "exterior_ior": 0})),
            &["exterior_ior", "greater than 0"],
        ),
        (
            |d| sphere_of(d, json!({"bsdf": "dielectric", "ior": 1e30, "exterior_ior": 1e-30})),
            &["material 1 \"glass\", ior over exterior_ior"],
        ),
    ]);
}

#[test]
fn light_from_infinity_needs_a_clear_scene() {
    refused(&[
        (
            |d| {
                d["extras"]["sunstone"]["medium"] = json!(0);
                d["extras"]["sunstone"]["environment"] = json!({"radiance": 1});
            },
            &["media[0] \"fog\"", "fills the scene", "would ever arrive", "null"],
        ),
        (
            |d| {
                d["extras"]["sunstone"]["medium"] = json!(1);
                d["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = json!("directional");
            },
            &["media[1]", "fills the scene"],
        ),
    ]);
    let mut clear = with_media();
    clear["extras"]["sunstone"]["environment"] = json!({"radiance": 1});
    assert_eq!(baked(&clear).shapes.scene_medium, NONE);
    clear["extras"]["sunstone"]["medium"] = json!(1);
    medium(&mut clear, 1)["sigma_s"] = json!(0);
    assert_eq!(baked(&clear).shapes.scene_medium, 1);
}
