//! Measured reflectance: files of tables, as they are named in a scene.

use std::f32::consts::{FRAC_PI_2, PI};
use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};
use sunstone::internals::scene::baked::BakedScene;
use sunstone::internals::scene::world::SurfaceModel;
use sunstone::internals::scene::{bake, load};
use sunstone::internals::spectrum::Carried;

use crate::common::good;

/// A field: its name, how its numbers are stored, its shape, and its bytes.
type Field = (&'static str, u8, Vec<u64>, Vec<u8>);

fn floats(name: &'static str, shape: &[u64], values: &[f32]) -> Field {
    (name, 10, shape.to_vec(), values.iter().flat_map(|value| value.to_le_bytes()).collect())
}

/// A table of two numbers along each angle, at 500 and 600 nm; half of light is reflected evenly.
fn fields() -> Vec<Field> {
    let mut matrix = [0.0; 16];
    matrix[0] = 0.5 / PI;
    let nm = [500_u16, 600].iter().flat_map(|nm| nm.to_le_bytes()).collect();
    vec![
        floats("phi_d", &[1, 2], &[-PI, PI]),
        floats("theta_d", &[1, 2], &[0.0, FRAC_PI_2]),
        floats("theta_h", &[1, 2], &[0.0, FRAC_PI_2]),
        ("wvls", 3, vec![2], nm),
        floats("M", &[2, 2, 2, 2, 4, 4], &[matrix; 16].concat()),
    ]
}

fn bytes(fields: &[Field]) -> Vec<u8> {
    let mut head = b"tensor_file\0\x01\x00".to_vec();
    head.extend((fields.len() as u32).to_le_bytes());
    let size = |(name, _, shape, _): &Field| 13 + name.len() + 8 * shape.len();
    let mut at = head.len() + fields.iter().map(size).sum::<usize>();
    for (name, stored, shape, bytes) in fields {
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape.len() as u16).to_le_bytes());
        head.push(*stored);
        head.extend((at as u64).to_le_bytes());
        head.extend(shape.iter().flat_map(|extent| extent.to_le_bytes()));
        at += bytes.len();
    }
    head.extend(fields.iter().flat_map(|(_, _, _, bytes)| bytes));
    head
}

/// The table as the bytes of a file.
pub fn even_table() -> Vec<u8> {
    bytes(&fields())
}

/// A folder with the good scene, whose first material is measured, and its table; it is removed in
/// the end.
struct Folder(PathBuf);

impl Folder {
    fn of(name: &str, material: Value, table: &[u8]) -> Self {
        let name = format!("sunstone-measured-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("table.pbsdf"), table).unwrap();
        let mut document = good();
        document["materials"][0]["extensions"]["SUNSTONE_polarization"] = material;
        fs::write(folder.join("scene.gltf"), document.to_string()).unwrap();
        Self(folder)
    }

    fn bake<const N: usize>(&self, carried: &Carried<N>) -> Result<BakedScene<N>, String> {
        let world = load(&self.0.join("scene.gltf")).map_err(|error| error.to_string())?;
        bake(&world, carried).map_err(|error| error.to_string())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn keys() -> Value {
    json!({"bsdf": "measured", "file": "table.pbsdf"})
}

#[test]
fn tables_are_read_and_know_where_wavelengths_are() {
    let folder = Folder::of("read", keys(), &bytes(&fields()));
    let scene = folder.bake(&Carried::at([500.0, 525.0, 600.0])).unwrap();
    let model = &scene.optics.materials[0].model;
    let SurfaceModel::Measured { table, places } = model else { panic!("{model:?}") };
    assert_eq!((*places, table.wavelengths(), table.name()), ([0.0, 0.25, 1.0], 2, "table.pbsdf"));
    let [matrix] = table.at::<16, 1>([0.3, 0.2, 0.1], &[0.25]);
    assert!((matrix[0] - 0.5 / PI).abs() < 1e-7 && matrix[1..] == [0.0; 15]);
    let outside = folder.bake(&Carried::at([450.0])).unwrap_err();
    assert!(outside.contains("wvls") && outside.contains("500 to 600 nm"), "{outside}");
}

#[test]
fn tables_that_are_none() {
    let without = |name: &str| -> Vec<Field> {
        fields().into_iter().filter(|field| field.0 != name).collect()
    };
    let with = |field: Field| [without(field.0), vec![field]].concat();
    let cases: [(Vec<u8>, &[&str]); 9] = [
        (vec![], &["is no file of tensors"]),
        (bytes(&fields())[..300].to_vec(), &["ends within its field"]),
        (bytes(&without("theta_d")), &["theta_d", "is missing", "the file has phi_d"]),
        (bytes(&with(floats("phi_d", &[2], &[0.0, PI]))), &["phi_d", "not once round"]),
        (bytes(&with(floats("theta_h", &[2], &[1.0, 0.5]))), &["theta_h", "increasing"]),
        (bytes(&with(floats("theta_h", &[2], &[0.0, f32::NAN]))), &["theta_h", "increasing"]),
        (bytes(&with(floats("wvls", &[2], &[-5.0, 500.0]))), &["wvls", "nanometers"]),
        (
            bytes(&with(floats("M", &[2, 2, 2, 1, 4, 4], &[0.1; 128]))),
            &["M", "[2, 2, 2, 1, 4, 4], and not [2, 2, 2, 2, 4, 4]"],
        ),
        (bytes(&with(floats("M", &[2, 2, 2, 2, 4, 4], &[0.0; 256]))), &["M", "reflects nothing"]),
    ];
    for (index, (table, texts)) in cases.iter().enumerate() {
        let folder = Folder::of(&format!("none-{index}"), keys(), table);
        let error = folder.bake(&Carried::at([550.0])).unwrap_err();
        let all = ["material 0 \"glow\"", "file"].iter().chain(*texts);
        assert!(all.clone().all(|text| error.contains(text)), "{index}: {error}");
    }
    let missing = Folder::of("missing", json!({"bsdf": "measured"}), &[]);
    let error = missing.bake(&Carried::at([550.0])).unwrap_err();
    assert!(error.contains("file, is missing") || error.contains("file is missing"), "{error}");
    let other = json!({"bsdf": "measured", "file": "other.pbsdf"});
    let error = Folder::of("other", other, &[]).bake(&Carried::at([550.0])).unwrap_err();
    assert!(error.contains("cannot read") && error.contains("other.pbsdf"), "{error}");
    let outside = json!({"bsdf": "measured", "file": "../other.pbsdf"});
    let error = Folder::of("outside", outside, &[]).bake(&Carried::at([550.0])).unwrap_err();
    assert!(error.contains("file"), "{error}");
}
