//! glTF documents built in code: world-space shapes, lights and one camera.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Mat3, Quat, Vec3};
use serde_json::{Value, json};
use sunstone::internals::scene::World;

use super::rendering::world;

/// How meshes that are alike are told to the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flock {
    /// As one mesh.
    Instances,
    /// As many meshes.
    Copies,
}

/// A document in the making. Indices that its methods return are those of the file.
#[derive(Default)]
pub struct Document {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    bytes: Vec<u8>,
    lights: Vec<Value>,
    cameras: Vec<Value>,
    media: Vec<Value>,
    filling: Option<usize>,
    environment: Option<Value>,
    up: Option<Vec3>,
}

impl Document {
    /// A material with the given body of `SUNSTONE_polarization`.
    pub fn material(&mut self, body: Value) -> usize {
        self.materials.push(json!({"extensions": {"SUNSTONE_polarization": body}}));
        self.materials.len() - 1
    }

    /// Glass as glTF has it, with the body of `KHR_materials_volume` if there is one.
    pub fn plain_glass(&mut self, volume: Option<Value>) -> usize {
        let mut extensions = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
        if let Some(volume) = volume {
            extensions["KHR_materials_volume"] = volume;
        }
        self.materials.push(json!({"extensions": extensions, "doubleSided": true,
            "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.0}}));
        self.materials.len() - 1
    }

    /// A material as glTF has it: color, share of metal, roughness.
    pub fn metallic_roughness(&mut self, color: [f32; 3], metallic: f32, roughness: f32) -> usize {
        let [red, green, blue] = color;
        self.materials.push(json!({"pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": metallic, "roughnessFactor": roughness}}));
        self.materials.len() - 1
    }

    /// A material as glTF has it, with these extensions.
    pub fn plain(&mut self, pbr: Value, extensions: Value) -> usize {
        self.materials.push(json!({"pbrMetallicRoughness": pbr, "extensions": extensions}));
        self.materials.len() - 1
    }

    /// A gray diffuse material.
    pub fn diffuse(&mut self, reflectance: f32) -> usize {
        self.material(json!({"bsdf": "diffuse", "reflectance": reflectance}))
    }

    /// Makes a material emit.
    pub fn emits(&mut self, material: usize, radiance: f32) -> usize {
        let material_value = &mut self.materials[material];
        material_value["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
        material_value["extensions"]["KHR_materials_emissive_strength"] =
            json!({"emissiveStrength": radiance});
        material
    }

    /// Makes both sides of a material scatter and emit.
    pub fn two_sided(&mut self, material: usize) -> usize {
        self.materials[material]["doubleSided"] = json!(true);
        material
    }

    /// A parallelogram about `center` that faces along `u` cross `v`, its half edges.
    pub fn quad(&mut self, center: Vec3, u: Vec3, v: Vec3, material: usize) {
        self.tilted_quad(center, u, v, Vec3::ZERO, material);
    }

    /// A parallelogram whose shading normals lean by `tilt`, added to the geometric one.
    pub fn tilted_quad(&mut self, center: Vec3, u: Vec3, v: Vec3, tilt: Vec3, material: usize) {
        let positions = [center - u - v, center + u - v, center + u + v, center - u + v];
        let normals = [(u.cross(v).normalize() + tilt).normalize(); 4];
        self.mesh(&positions, &normals, &[0, 1, 2, 0, 2, 3], material);
    }

    /// The five or six walls of a cube of half edge 1 that face inwards, `open` left out:
    /// floor, ceiling, back, left, right, front.
    pub fn room(&mut self, materials: [usize; 6], open: &[usize]) {
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        let walls = [(-y, z, x), (y, x, z), (-z, x, y), (-x, y, z), (x, z, y), (z, y, x)];
        for (wall, (center, u, v)) in walls.into_iter().enumerate() {
            if !open.contains(&wall) {
                self.quad(center, u, v, materials[wall]);
            }
        }
    }

    /// The six faces of a box, outwards.
    pub fn cuboid(&mut self, center: Vec3, half: Vec3, material: usize) {
        let (x, y, z) = (Vec3::X * half.x, Vec3::Y * half.y, Vec3::Z * half.z);
        for (face, u, v) in [(x, y, z), (-x, z, y), (y, z, x), (-y, x, z), (z, x, y), (-z, y, x)] {
            self.quad(center + face, u, v, material);
        }
    }

    /// An analytic sphere.
    pub fn sphere(&mut self, center: Vec3, radius: f32, material: usize) {
        self.nodes.push(json!({
            "translation": center.to_array(),
            "extensions": {
                "SUNSTONE_polarization": {"sphere_radius": radius, "material": material},
            },
        }));
    }

    /// A coarse sphere of triangles with the normals of the sphere, `rings` from pole to pole.
    pub fn ball(&mut self, center: Vec3, radius: f32, rings: u16, material: usize) {
        let columns = 2 * rings;
        let normal = |ring: u16, column: u16| {
            let theta = std::f32::consts::PI * f32::from(ring) / f32::from(rings);
            let phi = std::f32::consts::TAU * f32::from(column) / f32::from(columns);
            Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin())
        };
        let normals: Vec<Vec3> = (0..=rings)
            .flat_map(|ring| (0..=columns).map(move |column| normal(ring, column)))
            .collect();
        let positions: Vec<Vec3> = normals.iter().map(|n| center + *n * radius).collect();
        let mut indices = Vec::new();
        for ring in 0..rings {
            for column in 0..columns {
                let above = ring * (columns + 1) + column;
                let below = above + columns + 1;
                if ring + 1 < rings {
                    indices.extend([above, below, below + 1]);
                }
                if ring > 0 {
                    indices.extend([above, below + 1, above + 1]);
                }
            }
        }
        self.mesh(&positions, &normals, &indices, material);
    }

    /// Balls about the given points, turned and stretched: one mesh in many places, or many
    /// meshes that are alike. Every other one is mirrored.
    pub fn flock(&mut self, centers: &[Vec3], radius: f32, rings: u16, material: usize, of: Flock) {
        for (index, center) in centers.iter().enumerate() {
            let first = self.nodes.len();
            if of == Flock::Copies || index == 0 {
                self.ball(Vec3::ZERO, 1.0, rings, material);
            } else {
                self.nodes.push(json!({"mesh": self.meshes.len() - 1}));
            }
            let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), index as f32);
            let mirror = if index % 2 == 0 { 1.0 } else { -1.0 };
            let scale = Vec3::new(mirror, 1.0, 1.5) * radius;
            self.nodes[first]["translation"] = json!(center.to_array());
            self.nodes[first]["rotation"] = json!(turn.to_array());
            self.nodes[first]["scale"] = json!(scale.to_array());
        }
    }

    /// A mesh with world-space positions.
    pub fn mesh(&mut self, positions: &[Vec3], normals: &[Vec3], indices: &[u16], material: usize) {
        let [position, normal] = [positions, normals].map(|vectors| {
            let bytes = vectors.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes);
            self.accessor(bytes.collect(), "VEC3", 5126, vectors)
        });
        let bytes = indices.iter().copied().flat_map(u16::to_le_bytes).collect();
        let index = self.accessor(bytes, "SCALAR", 5123, &[]);
        self.accessors[index]["count"] = json!(indices.len());
        let attributes = json!({"POSITION": position, "NORMAL": normal});
        self.meshes.push(json!({"primitives": [
            {"attributes": attributes, "indices": index, "material": material}]}));
        self.nodes.push(json!({"mesh": self.meshes.len() - 1}));
    }

    fn accessor(&mut self, bytes: Vec<u8>, kind: &str, component: u32, vectors: &[Vec3]) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.views.push(view);
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut accessor = json!({"bufferView": self.views.len() - 1, "type": kind,
            "componentType": component, "count": vectors.len()});
        if let Some(&first) = vectors.first() {
            let bound = |of: fn(Vec3, Vec3) -> Vec3| vectors.iter().copied().fold(first, of);
            accessor["min"] = json!(bound(Vec3::min).to_array());
            accessor["max"] = json!(bound(Vec3::max).to_array());
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// A light of `KHR_lights_punctual` in watts, that shines along `direction` if it has one.
    pub fn light(&mut self, mut light: Value, position: Vec3, direction: Vec3) {
        light["extensions"]["SUNSTONE_polarization"]["units"] = json!("radiometric");
        self.lights.push(light);
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        self.nodes.push(json!({
            "translation": position.to_array(),
            "rotation": rotation.to_array(),
            "extensions": {"KHR_lights_punctual": {"light": self.lights.len() - 1}},
        }));
    }

    /// A participating medium.
    pub fn medium(&mut self, body: Value) -> usize {
        self.media.push(body);
        self.media.len() - 1
    }

    /// Fills the whole scene with a medium.
    pub fn fill(&mut self, medium: usize) {
        self.filling = Some(medium);
    }

    /// Says what lies behind all shapes that `build` adds, and before them (nothing by default).
    pub fn around(
        &mut self,
        interior: Option<usize>,
        exterior: Option<usize>,
        build: impl FnOnce(&mut Self),
    ) {
        let first = self.nodes.len();
        build(self);
        for node in &mut self.nodes[first..] {
            let body = &mut node["extensions"]["SUNSTONE_polarization"];
            body["interior"] = json!(interior);
            body["exterior"] = json!(exterior);
        }
    }

    /// A medium within boundaries that are not there otherwise: `shape` is given their material.
    pub fn fog(&mut self, medium: usize, shape: impl FnOnce(&mut Self, usize)) {
        let null = self.material(json!({"bsdf": "null"}));
        self.around(Some(medium), None, |scene| shape(scene, null));
    }

    /// Light of equal radiance from everywhere outside.
    pub fn environment(&mut self, radiance: f32) {
        self.sky(json!({"radiance": radiance}));
    }

    /// Light from everywhere outside, with the given body of `environment`.
    pub fn sky(&mut self, body: Value) {
        self.environment = Some(body);
    }

    /// What is up for the cameras to come, instead of y.
    pub fn up(&mut self, up: Vec3) {
        self.up = Some(up);
    }

    /// A pinhole, or a lens with its radius and focus distance.
    pub fn perspective(&mut self, eye: Vec3, target: Vec3, yfov: f32, lens: Option<[f32; 2]>) {
        let mut camera = json!({"type": "perspective",
            "perspective": {"yfov": yfov, "aspectRatio": 1.0, "znear": 0.01}});
        if let Some([radius, distance]) = lens {
            camera["extensions"] = json!({"SUNSTONE_polarization":
                {"aperture_radius": radius, "focus_distance": distance}});
        }
        self.camera(camera, eye, target);
    }

    /// A camera of parallel rays.
    pub fn orthographic(&mut self, eye: Vec3, target: Vec3, half_size: f32) {
        let projection = json!({"xmag": half_size, "ymag": half_size, "znear": 0.01, "zfar": 9.0});
        self.camera(json!({"type": "orthographic", "orthographic": projection}), eye, target);
    }

    fn camera(&mut self, camera: Value, eye: Vec3, target: Vec3) {
        self.cameras.push(camera);
        let backward = (eye - target).normalize();
        let right = self.up.unwrap_or(Vec3::Y).cross(backward).normalize();
        let turn = Mat3::from_cols(right, backward.cross(right), backward);
        self.nodes.push(json!({
            "camera": self.cameras.len() - 1,
            "translation": eye.to_array(),
            "rotation": Quat::from_mat3(&turn).to_array(),
        }));
    }

    /// Writes the document to the scratch folder and loads it.
    pub fn load(self, name: &str) -> World {
        let nodes: Vec<usize> = (0..self.nodes.len()).collect();
        let mut file = json!({
            "asset": {"version": "2.0"},
            "extensionsUsed": ["SUNSTONE_polarization", "KHR_lights_punctual",
                               "KHR_materials_emissive_strength"],
            "scene": 0,
            "scenes": [{"name": name, "nodes": nodes}],
            "nodes": self.nodes,
            "cameras": self.cameras,
        });
        for (key, array) in [
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
        ] {
            if !array.is_empty() {
                file[key] = Value::Array(array);
            }
        }
        if !self.bytes.is_empty() {
            let uri =
                format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
            file["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        if !self.lights.is_empty() {
            file["extensions"]["KHR_lights_punctual"] = json!({"lights": self.lights});
        }
        if !self.media.is_empty() {
            file["extensions"]["SUNSTONE_polarization"] =
                json!({"media": self.media, "medium": self.filling});
        }
        if let Some(sky) = self.environment {
            file["scenes"][0]["extensions"] =
                json!({"SUNSTONE_polarization": {"environment": sky}});
        }
        load_json(&file, name)
    }
}

/// Writes a file where no other test does, loads it, and removes it again.
fn load_json(file: &Value, name: &str) -> World {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(std::process::id().to_string());
    fs::create_dir_all(&folder).expect("the scratch folder can be made");
    let path = folder.join(format!("{number} {name}.gltf"));
    fs::write(&path, file.to_string()).expect("the scratch folder takes files");
    let world = world(&path);
    fs::remove_file(&path).expect("the file is there");
    world
}
