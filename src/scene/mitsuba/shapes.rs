//! The types of `<shape>`: what they look like. Flat and round ones are what they are; disks and
//! cylinders are made of many triangles.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec3Swizzles};

use super::Import;
use super::fields::Fields;
use super::mesh::{Soup, obj, ply, serialized};
use super::transforms::perpendicular;
use super::tree::{NAME, Tag};
use crate::math::elementary::{sin, sin_cos};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::{Ball, Geometry};

/// Most bytes of a mesh file.
const BYTES_MAX: u64 = 1 << 33;
/// Corners of disks and cylinders.
const CORNERS: u32 = 256;
/// Most shapes that groups make, and how deep they may be.
const SHAPES_MAX: usize = 1 << 20;

/// What a shape looks like.
#[derive(Clone, Debug)]
pub struct Form {
    pub body: Body,
    /// From its own space to that of the scene or the group.
    pub to_world: DAffine3,
    /// Whether the x axis of its surface is that of the shape everywhere, so that sheets which have
    /// an axis can be made of it.
    pub has_axis: bool,
    /// Whether nothing ever sees its back from outside.
    pub is_closed: bool,
}

#[derive(Clone, Debug)]
pub enum Body {
    Mesh(Arc<Geometry>),
    /// A sphere; inside out, if its normal is to look to its center.
    Ball(Ball, bool),
}

/// What reads a type.
type Read = fn(&mut Import, &Fields) -> Result<Form, SceneError>;

/// The types that have a surface.
const TYPES: [(&str, Read); 8] = [
    ("cube", cube),
    ("cylinder", cylinder),
    ("disk", disk),
    ("obj", |import, fields| from_file(import, fields, |bytes, _| obj::read(bytes))),
    ("ply", |import, fields| from_file(import, fields, |bytes, _| ply::read(bytes))),
    ("rectangle", rectangle),
    ("serialized", |import, fields| from_file(import, fields, serialized::read)),
    ("sphere", sphere),
];
/// The types that have other shapes in them.
const GROUP: &str = "shapegroup";
const INSTANCE: &str = "instance";

impl Import<'_> {
    /// Adds a shape: itself, or those of the group that it is an instance of. Groups are seen in
    /// their instances alone.
    pub fn add_shape(&mut self, object: usize) -> Result<(), SceneError> {
        let fields = Fields::of(self.tree, object);
        match fields.object.plugin.as_str() {
            GROUP => Ok(()),
            INSTANCE => self.add_instance(&fields),
            _ => self.add_form(&fields, DAffine3::IDENTITY),
        }
    }

    fn add_instance(&mut self, fields: &Fields) -> Result<(), SceneError> {
        let to_world = fields.transform("to_world")?;
        let group = fields.only(Tag::Shape)?;
        fields.finish()?;
        let remedy = "refer to a shapegroup in it";
        let group = group.ok_or_else(|| fields.refuse("is an instance of nothing", remedy))?;
        let group = Fields::of(self.tree, group);
        if group.object.plugin != GROUP {
            return Err(group.refuse("is no shapegroup, and has an instance", remedy));
        }
        let shapes = group.objects(Tag::Shape);
        group.finish()?;
        let mut findings = crate::scene::error::Findings::default();
        for (_, shape) in shapes {
            self.shapes += 1;
            if self.shapes > SHAPES_MAX {
                let problem = format!("brings the scene above {SHAPES_MAX} shapes");
                return Err(fields.refuse(problem, "use fewer instances"));
            }
            let shape = Fields::of(self.tree, shape);
            let added = match shape.object.plugin.as_str() {
                GROUP | INSTANCE => Err(shape.refuse("is a group within a group", "move it out")),
                _ => self.add_form(&shape, to_world),
            };
            findings.note(added);
        }
        findings.result()
    }

    /// Adds a shape that has a surface.
    fn add_form(&mut self, fields: &Fields, outer: DAffine3) -> Result<(), SceneError> {
        let plugin = fields.object.plugin.as_str();
        let Some((_, read)) = TYPES.iter().find(|(name, _)| *name == plugin) else {
            let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
            let names = TYPES.iter().map(|(name, _)| *name).chain([GROUP, INSTANCE]);
            let names: Vec<&str> = names.collect();
            return Err(fields.refuse(problem, format!("the types are {}", names.join(", "))));
        };
        // How gradients are found.
        fields.ignore(&["silhouette_sampling_weight"]);
        let form = read(self, fields)?;
        let form = Form { to_world: outer * form.to_world, ..form };
        self.add_surface(fields, form)
    }
}

fn flat(
    fields: &Fields,
    geometry: Geometry,
    has_axis: bool,
    is_closed: bool,
) -> Result<Form, SceneError> {
    let to_world = fields.transform("to_world")?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let soup = Soup { geometry, points: Vec::new() };
    let body = Body::Mesh(Arc::new(soup.finished(true, flip)));
    Ok(Form { body, to_world, has_axis: has_axis && !flip, is_closed: is_closed && !flip })
}

fn rectangle(_: &mut Import, fields: &Fields) -> Result<Form, SceneError> {
    let quad = Geometry::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let texture_coordinates = quad.positions.iter().map(|at| 0.5 * (at.xy() + 1.0)).collect();
    flat(fields, Geometry { texture_coordinates, ..quad }, true, false)
}

fn cube(_: &mut Import, fields: &Fields) -> Result<Form, SceneError> {
    // Its faces are flat whatever is said.
    fields.ignore(&["face_normals"]);
    flat(fields, unwrapped(&Geometry::cuboid(Vec3::NEG_ONE, Vec3::ONE)), false, true)
}

/// A cube about zero with corners of its own for each face, and texture coordinates.
fn unwrapped(cube: &Geometry) -> Geometry {
    let mut unwrapped = Geometry::default();
    for triangle in &cube.triangles {
        let corners = triangle.map(|row| cube.positions[row as usize]);
        let middle = (corners[0] + corners[1] + corners[2]).round();
        let at = |axis: Vec3| move |point: Vec3| 0.5 * (point.dot(axis) + 1.0);
        // Which way coordinates grow on a face, by its normal.
        let [u, v] = match middle.to_array().map(|value| (value / 3.0).trunc() as i32) {
            [0, 0, 1] => [Vec3::Y, Vec3::X],
            [0, 0, _] => [Vec3::NEG_Y, Vec3::X],
            [1, ..] => [Vec3::Y, Vec3::NEG_Z],
            [-1, ..] => [Vec3::Y, Vec3::Z],
            [_, 1, _] => [Vec3::NEG_X, Vec3::NEG_Z],
            [..] => [Vec3::Z, Vec3::X],
        };
        let first = unwrapped.positions.len() as u32;
        unwrapped.positions.extend(corners);
        let pairs = corners.map(|point| Vec2::new(at(u)(point), at(v)(point)));
        unwrapped.texture_coordinates.extend(pairs);
        unwrapped.triangles.push([first, first + 1, first + 2]);
    }
    unwrapped
}

/// The corners of a regular polygon that has the area of the unit disk.
fn ring() -> impl Iterator<Item = DVec3> {
    let step = TAU / f64::from(CORNERS);
    let radius = (PI / (0.5 * f64::from(CORNERS) * sin(step))).sqrt();
    (0..CORNERS).map(move |index| {
        let (sine, cosine) = sin_cos(step * f64::from(index));
        DVec3::new(cosine, sine, 0.0) * radius
    })
}

fn disk(_: &mut Import, fields: &Fields) -> Result<Form, SceneError> {
    // A middle for each triangle, and the first corner once more: u is the radius, v the angle.
    let around: Vec<Vec3> = ring().map(|point| point.as_vec3()).collect();
    let angle = |steps: f32| steps / CORNERS as f32;
    let mut geometry = Geometry::default();
    for index in 0..=CORNERS {
        geometry.positions.push(around[(index % CORNERS) as usize]);
        geometry.texture_coordinates.push(Vec2::new(1.0, angle(index as f32)));
    }
    for index in 0..CORNERS {
        let middle = geometry.positions.len() as u32;
        geometry.positions.push(Vec3::ZERO);
        geometry.texture_coordinates.push(Vec2::new(0.0, angle(index as f32 + 0.5)));
        geometry.triangles.push([middle, index, index + 1]);
    }
    flat(fields, geometry, true, false)
}

fn cylinder(import: &mut Import, fields: &Fields) -> Result<Form, SceneError> {
    let to_world = fields.transform("to_world")?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let radius = fields.number("radius")?.unwrap_or(1.0);
    let from = fields.vector("p0")?.unwrap_or(DVec3::ZERO);
    let to = fields.vector("p1")?.unwrap_or(DVec3::Z);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(fields.wrong("radius", format!("{radius} must be greater than 0"), ""));
    }
    let Some(axis) = (to - from).try_normalize() else {
        return Err(fields.wrong("p1", "is where p0 is", ""));
    };
    let across = perpendicular(axis);
    let scale = DVec3::new(radius, radius, (to - from).length());
    let turn = DMat3::from_cols(across, axis.cross(across), axis);
    let frame = DAffine3::from_mat3_translation(turn, from) * DAffine3::from_scale(scale);
    // The first corner is there once more, with the angle of a whole turn.
    const ROW: u32 = CORNERS + 1;
    let around = || ring().chain(ring().take(1));
    let ends = |z: f64| around().map(move |point| (point + DVec3::Z * z).as_vec3());
    let normal = |point: DVec3| point.normalize().as_vec3();
    let pair = |index: u32, v: f32| Vec2::new(index as f32 / CORNERS as f32, v);
    let geometry = Geometry {
        positions: ends(0.0).chain(ends(1.0)).collect(),
        normals: around().chain(around()).map(normal).collect(),
        texture_coordinates: [0.0, 1.0]
            .into_iter()
            .flat_map(|v| (0..ROW).map(move |index| pair(index, v)))
            .collect(),
        triangles: (0..CORNERS)
            .flat_map(|a| [[a, a + 1, a + 1 + ROW], [a, a + 1 + ROW, a + ROW]])
            .collect(),
        ..Geometry::default()
    };
    let text = "a cylinder is made of flat strips, which polarize a little less evenly than it";
    import.warnings.add(&fields.label(), text);
    let body = Body::Mesh(Arc::new(Soup { geometry, points: Vec::new() }.finished(false, flip)));
    Ok(Form { body, to_world: to_world * frame, has_axis: false, is_closed: false })
}

fn sphere(_: &mut Import, fields: &Fields) -> Result<Form, SceneError> {
    let to_world = fields.transform("to_world")?;
    let center = fields.vector("center")?.unwrap_or(DVec3::ZERO);
    let ball = Ball { radius: fields.number("radius")?.unwrap_or(1.0) };
    ball.check().map_err(|fault| fields.fault(fault, &[]))?;
    let flip = fields.boolean("flip_normals")?.unwrap_or(false);
    let to_world = to_world * DAffine3::from_translation(center);
    Ok(Form { body: Body::Ball(ball, flip), to_world, has_axis: false, is_closed: !flip })
}

/// A mesh of a file, read once for all shapes that want it alike.
fn from_file(
    import: &mut Import,
    fields: &Fields,
    read: impl Fn(&[u8], usize) -> Result<Soup, String>,
) -> Result<Form, SceneError> {
    let to_world = fields.transform("to_world")?;
    let face_normals = fields.boolean("face_normals")?.unwrap_or(false);
    let flip_normals = fields.boolean("flip_normals")?.unwrap_or(false);
    let index = match fields.object.plugin.as_str() {
        "serialized" => fields.count("shape_index")?.unwrap_or(0),
        _ => 0,
    };
    let is_obj = fields.object.plugin == "obj";
    let flip_coordinates = match fields.object.plugin.as_str() {
        "serialized" => false,
        _ => fields.boolean("flip_tex_coords")?.unwrap_or(is_obj),
    };
    let Some(name) = fields.text("filename")? else {
        return Err(fields.wrong("filename", "is missing", "add it"));
    };
    let path = import.paths.of(name, import.files);
    let key = (path.clone(), index, [face_normals, flip_normals, flip_coordinates]);
    let geometry = match import.geometries.get(&key) {
        Some(geometry) => Arc::clone(geometry),
        None => {
            let place = format!("{}, filename", fields.label());
            let bytes = import.files.named(&path, &place, BYTES_MAX)?;
            let mut soup = read(&bytes, index as usize).map_err(|problem| {
                let name = excerpt(name, NAME);
                fields.wrong("filename", format!("{name}: {problem}"), "export the mesh again")
            })?;
            if flip_coordinates {
                let coordinates = &mut soup.geometry.texture_coordinates;
                coordinates.iter_mut().for_each(|pair| pair.y = 1.0 - pair.y);
            }
            let geometry = import.cleaned(fields, soup.finished(face_normals, flip_normals))?;
            import.geometries.insert(key, Arc::clone(&geometry));
            geometry
        }
    };
    Ok(Form { body: Body::Mesh(geometry), to_world, has_axis: false, is_closed: false })
}
