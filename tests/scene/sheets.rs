//! Sheets and thin films: what their materials mean, and which are refused.

use serde_json::{Value, json};
use sunstone::internals::scene::world::{Action, Delay, Grid, Hand, SurfaceModel, ThinFilm};

use crate::common::{good, load_json};
use crate::meaning::{baked, warnings};

fn model(body: Value) -> SurfaceModel<[f32; 3]> {
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"SUNSTONE_polarization": body}});
    baked(&document).optics.materials[0].model.clone()
}

fn sheet(action: Action<[f32; 3]>) -> SurfaceModel<[f32; 3]> {
    SurfaceModel::Sheet { axis_deg: 20.0, action }
}

#[test]
fn sheets_are_what_their_keys_say() {
    let polarizer = |body: Value| {
        let mut whole = json!({"bsdf": "polarizer", "axis_deg": 20});
        whole.as_object_mut().unwrap().extend(body.as_object().unwrap().clone());
        model(whole)
    };
    let plain = SurfaceModel::Polarizer { axis_deg: 20.0, extinction_ratio: 50.0 };
    assert_eq!(polarizer(json!({"extinction_ratio": 50})), plain);
    let grid = |transmittance, blocked| Grid { transmittance, blocked };
    let real = |transmittance, blocked| sheet(Action::Polarizer(grid(transmittance, blocked)));
    assert_eq!(polarizer(json!({"transmittance": 0.5})), real([0.5; 3], [0.0; 3]));
    assert_eq!(polarizer(json!({"blocked": [0.5, 0.25, 0]})), real([1.0; 3], [0.5, 0.25, 0.0]));
    let both = json!({"transmittance": [0.5, 1, 0.75], "extinction_ratio": 4});
    assert_eq!(polarizer(both), real([0.5, 1.0, 0.75], [0.125, 0.25, 0.1875]));

    let plate = json!({"bsdf": "retarder", "axis_deg": 20, "retardance_deg": 90.25});
    let expected = SurfaceModel::Retarder { axis_deg: 20.0, retardance_deg: 90.25 };
    assert_eq!(model(plate), expected);
    let crystal = json!({"bsdf": "retarder", "axis_deg": 20, "birefringence": 0.5,
        "thickness_um": 0.5});
    let thickness = [605.0, 542.0, 455.0].map(|nm| 500.0 / nm);
    let delay = Delay::Crystal { birefringence: [0.5; 3], thickness };
    assert_eq!(model(crystal), sheet(Action::Retarder(delay)));

    let circular = json!({"bsdf": "circular_polarizer", "axis_deg": 20, "handedness": "left"});
    let (polarizer, retarder) = (grid([1.0; 3], [0.0; 3]), Delay::Degrees([90.0; 3]));
    assert_eq!(model(circular), sheet(Action::Circular { polarizer, retarder, hand: Hand::Left }));
}

#[test]
fn sheets_are_refused_by_name() {
    let cases: [(Value, &[&str]); 13] = [
        (
            json!({"bsdf": "polarizer", "transmittance": 1.5}),
            &["transmittance", "1.5 must be within"],
        ),
        (json!({"bsdf": "polarizer", "blocked": -0.5}), &["blocked: -0.5 must"]),
        (
            json!({"bsdf": "polarizer", "blocked": 0.1, "extinction_ratio": 5}),
            &["either `blocked` or `extinction_ratio`"],
        ),
        (
            json!({"bsdf": "polarizer", "transmittance": 1, "extinction_ratio": 0.5}),
            &["extinction_ratio: 0.5 must be at least 1"],
        ),
        (json!({"bsdf": "polarizer", "retardance_deg": 90}), &["means nothing for a polarizer"]),
        (json!({"bsdf": "retarder"}), &["retardance_deg", "is missing", "birefringence"]),
        (json!({"bsdf": "retarder", "birefringence": 0.1}), &["both `birefringence` and"]),
        (
            json!({"bsdf": "retarder", "birefringence": 0.1, "thickness_um": -2}),
            &["thickness_um", "must be not negative"],
        ),
        (
            json!({"bsdf": "circular_polarizer", "handedness": "up"}),
            &["`up` is no sense of rotation", "right or left"],
        ),
        (json!({"bsdf": "mueller"}), &["matrix", "is missing", "four rows"]),
        (json!({"bsdf": "mueller", "matrix": [[1, 0, 0, 0]]}), &["matrix", "is not a matrix"]),
        (
            json!({"bsdf": "mueller",
                "matrix": [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]}),
            &["matrix", "more light leave than arrives"],
        ),
        (
            json!({"bsdf": "mueller", "matrix": [[0.5, 0, 0, 0], [0, 0.5, 0, 0],
                [0, 0, 0.5, 0], [0, 0, 0, {"nm": [400, 500], "value": [0.5, 0.6]}]]}),
            &["matrix", "at 450 nm", "degree of polarization over 1"],
        ),
    ];
    for (body, expected) in cases {
        let mut document = good();
        document["materials"][0]["extensions"]["SUNSTONE_polarization"] = body;
        let error = load_json(&document).unwrap_err();
        assert!(expected.iter().all(|part| error.contains(part)), "{error}: {expected:?}");
    }
}

fn film(eta: f32, nm: f32) -> ThinFilm<[f32; 3]> {
    let thickness = [605.0, 542.0, 455.0].map(|wave| nm / wave);
    ThinFilm {
        eta: [eta; 3],
        k: [0.0; 3],
        thickness,
        spread: [0.025; 3],
        share: 1.0,
        portion: 1.0,
        portions: [0.0, 1.0],
    }
}

#[test]
fn films_are_those_of_the_extension_and_of_gltf() {
    let stated = json!({"bsdf": "dielectric", "ior": 1.5, "exterior_ior": 1.25,
        "film": {"eta": 1.375, "thickness_nm": 100}});
    let film_of = film(1.375, 100.0);
    let expected = SurfaceModel::FilmedDielectric { ior: 1.5, exterior_ior: 1.25, film: film_of };
    assert_eq!(model(stated), expected);

    let with = |metallic: f64, transmission: f64, iridescence: Value| {
        let mut document = good();
        document["materials"][0] = json!({
            "pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": 0.0,
                "baseColorFactor": [0.5, 0.5, 0.5, 1.0]},
            "extensions": {"KHR_materials_iridescence": iridescence,
                "KHR_materials_volume": {"thicknessFactor": 1.0},
                "KHR_materials_transmission": {"transmissionFactor": transmission}}});
        document
    };
    let whole = json!({"iridescenceFactor": 1.0, "iridescenceThicknessMaximum": 250.0});
    let metal = with(1.0, 0.0, whole.clone());
    assert_eq!(warnings(&metal), "");
    let SurfaceModel::FilmedConductor { film: found, .. } = baked(&metal).optics.materials[0].model
    else {
        panic!("no film")
    };
    assert_eq!(found, film(1.3, 250.0));
    let glass = with(0.0, 1.0, whole.clone());
    let SurfaceModel::FilmedDielectric { film: found, .. } =
        baked(&glass).optics.materials[0].model
    else {
        panic!("no film")
    };
    assert_eq!(found, film(1.3, 250.0));
    let half = with(1.0, 0.0, json!({"iridescenceFactor": 0.5}));
    assert_eq!(warnings(&half), "");
    let SurfaceModel::FilmedConductor { film: found, .. } = baked(&half).optics.materials[0].model
    else {
        panic!("no film")
    };
    assert_eq!(found, ThinFilm { share: 0.5, ..film(1.3, 400.0) });
    let none = with(1.0, 0.0, json!({}));
    assert!(matches!(baked(&none).optics.materials[0].model, SurfaceModel::Conductor { .. }));
}

#[test]
fn films_are_refused_by_name() {
    let metal = |film: Value| json!({"bsdf": "conductor", "metal": "Au", "film": film});
    let cases: [(Value, &[&str]); 8] = [
        (metal(json!({"thickness_nm": 5})), &["film.eta", "is missing"]),
        (metal(json!({"eta": 1.5})), &["film.thickness_nm", "is missing"]),
        (metal(json!({"eta": 0, "thickness_nm": 5})), &["film.eta", "0 must be greater than 0"]),
        (metal(json!({"eta": 1.5, "k": -1, "thickness_nm": 5})), &["film.k", "-1 must be not neg"]),
        (metal(json!({"eta": 1.5, "thickness_nm": 1e6})), &["film.thickness_nm", "100000 nm"]),
        (metal(json!({"eta": 1.5, "thickness_nm": 5, "ior": 2})), &["film.ior", "not a key"]),
        (
            json!({"bsdf": "dielectric", "ior": "BK7", "film": {"eta": 1.5, "thickness_nm": 5}}),
            &["film", "dispersion", "indices that are numbers"],
        ),
        (
            json!({"bsdf": "diffuse", "film": {"eta": 1.5, "thickness_nm": 5}}),
            &["film", "means nothing for a diffuse"],
        ),
    ];
    for (body, expected) in cases {
        let mut document = good();
        document["materials"][0]["extensions"]["SUNSTONE_polarization"] = body;
        let error = load_json(&document).unwrap_err();
        assert!(expected.iter().all(|part| error.contains(part)), "{error}: {expected:?}");
    }
}

/// More across the axis than along it is another axis.
#[test]
fn polarizers_block_no_less_than_they_transmit() {
    use sunstone::internals::scene::World;
    use sunstone::internals::spectrum::Spectrum;
    use sunstone::world::Bsdf;
    let of = |transmittance: Spectrum, blocked: Spectrum| {
        let action = Action::Polarizer(Grid { transmittance, blocked });
        World::new("sheets").add_material("sheet", Bsdf::Sheet { axis_deg: 0.0, action })
    };
    assert!(of(0.4.into(), 0.4.into()).is_ok());
    let error = of(0.4.into(), 0.5.into()).unwrap_err().to_string();
    assert!(error.contains("blocked: 0.5 is more than the transmittance, 0.4"), "{error}");
    let error = of([0.9, 0.9, 0.3].into(), [0.1, 0.1, 0.4].into()).unwrap_err().to_string();
    assert!(error.contains("0.4 is more than the transmittance, 0.3 at"), "{error}");
}
