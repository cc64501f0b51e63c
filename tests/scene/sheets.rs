//! Sheets: what their materials mean, and which are refused.

use serde_json::{Value, json};
use sunstone::internals::scene::world::{Action, Delay, Grid, Hand, SurfaceModel};

use crate::common::{good, load_json};
use crate::meaning::baked;

fn model(body: Value) -> SurfaceModel<[f32; 3]> {
    let mut document = good();
    document["materials"][0] = json!({"extensions": {"SUNSTONE_polarization": body}});
    baked(&document).optics.materials[0].model
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
