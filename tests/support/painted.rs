//! Small scenes of painted surfaces: colors, lamps, normals and holes by pictures.

use std::io::Cursor;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use image::{ImageBuffer, ImageFormat, Rgba};
use sunstone::Distribution;
use sunstone::internals::image::texels::{Coding, Texels};
use sunstone::internals::scene::World;
use sunstone::world::{
    Bsdf, Coverage, Filter, Geometry, Layers, Lens, Material, Paint, Parameter, Phase, Picture,
    Reads, Relief, ReliefFrame, ReliefOf, Stain, Texture, Textures, Transform, Wrap,
};

use super::random::Random;
use super::scenes::{Named, v};

/// All of them.
pub const PAINTED: [Named; 9] = [
    ("painted metal", painted_metal),
    ("painted room", painted_room),
    ("painted lamp", painted_lamp),
    ("painted globes", globes),
    ("stained glass", stained_glass),
    ("relief", relief),
    ("sheets with holes", holes),
    ("lamp with holes under the sky", shining_holes),
    ("holes in fog", holes_in_fog),
];

/// A picture of so many texels along its edges, by column and row.
pub fn picture(side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Arc<Picture> {
    let image = ImageBuffer::from_fn(side, side, |x, y| Rgba(texel(x, y)));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).expect("memory takes pictures");
    let texels = Texels::decode(bytes.get_ref()).expect("what was just written");
    Arc::new(Picture::new(texels, 0))
}

/// A texture of linear texels by the first set of coordinates.
pub fn texture(picture: Arc<Picture>, filter: Filter) -> Texture {
    Texture {
        picture,
        coding: Coding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter,
        set: 0,
        transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    }
}

/// Random texels, alpha included, with as many dark ones.
pub fn noise(seed: u64, side: u32) -> Arc<Picture> {
    let mut random = Random(seed);
    let texels: Vec<[u8; 4]> = (0..side * side)
        .map(|_| {
            let is_dark = random.next() < 0.5;
            [0; 4].map(|_| (random.next() * if is_dark { 20.0 } else { 255.0 }) as u8)
        })
        .collect();
    picture(side, |x, y| texels[(y * side + x) as usize])
}

/// A paint by a picture.
pub fn paint(factor: [f32; 3], texture: Texture) -> Paint {
    Paint { factor, texture: Some(texture), reads: Reads::Color, by_vertices: false }
}

/// A color by a picture.
pub fn colored(texture: Texture) -> Textures {
    let parameters = vec![(Parameter::Reflectance, paint([0.9, 0.8, 0.7], texture))];
    Textures { parameters, ..Textures::default() }
}

/// A quad as [`Geometry::quad`], whose picture is upright along `u` and `v`.
pub fn quad(center: Vec3, u: Vec3, v: Vec3) -> Geometry {
    let corners = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from_array);
    let colors = [[1.0, 0.2, 0.1, 1.0], [0.3, 1.0, 0.5, 0.5], [0.2, 0.4, 1.0, 0.2], [1.0; 4]];
    Geometry {
        texture_coordinates: corners.to_vec(),
        texture_coordinates_1: corners.map(|corner| 3.0 * corner - 0.7).to_vec(),
        colors: colors.map(Vec4::from_array).to_vec(),
        ..Geometry::quad(center, u, v)
    }
}

/// A floor, a wall and a camera that sees them.
pub fn stage(floor: Textures) -> World {
    let mut world = World::new("painted");
    let add = |world: &mut World, name: &str, bsdf: Bsdf, textures: Textures| {
        let material = world.add_material(name, Material::from(bsdf).two_sided()).expect("sound");
        world.set_textures(material, textures).expect("of this model");
        material
    };
    let painted = add(&mut world, "floor", Bsdf::diffuse(0.7), floor);
    let plain = add(&mut world, "wall", Bsdf::diffuse([0.7, 0.6, 0.5]), Textures::default());
    let floor = quad(v(0.0, -1.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, -1.0));
    world.add_mesh("floor", floor, painted, Transform::IDENTITY).expect("sound");
    let wall = quad(v(0.0, 0.0, -1.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0));
    world.add_mesh("wall", wall, plain, Transform::IDENTITY).expect("sound");
    let place = Transform::looking(DVec3::new(0.2, 0.1, 3.6), DVec3::ZERO, DVec3::Y);
    world.set_camera("eye", Lens::pinhole(0.62), place).expect("sound");
    world
}

pub fn add(world: &mut World, name: &str, of: (Material, Textures), geometry: Geometry) {
    let (material, textures) = of;
    let material = world.add_material(name, material).expect("sound");
    world.set_textures(material, textures).expect("of this model");
    world.add_mesh(name, geometry, material, Transform::IDENTITY).expect("sound");
}

/// A lamp that shines down.
pub fn panel(half: f32) -> Geometry {
    quad(v(0.1, 0.95, 0.0), v(half, 0.0, 0.0), v(0.0, 0.0, half))
}

fn painted_room() -> World {
    let mut floor = texture(noise(1, 4), Filter::Linear);
    floor.transform = [[2.0, 0.5, 0.1], [-0.4, 1.5, 0.3]];
    let mut floor = colored(floor);
    floor.parameters[0].1.by_vertices = true;
    let mut world = stage(floor);
    let mut side = texture(noise(2, 3), Filter::Nearest);
    (side.set, side.wrap) = (1, [Wrap::Mirror, Wrap::Clamp]);
    let wall = quad(v(-1.0, 0.0, 0.0), v(0.0, 0.0, -1.0), v(0.0, 1.0, 0.0));
    add(&mut world, "side", (Bsdf::diffuse(0.5).into(), colored(side)), wall);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.3));
    world
}

/// From polished to rough, from metal to enamel.
fn painted_metal() -> World {
    let mut world = stage(Textures::default());
    let mut random = Random(21);
    let texels: Vec<[u8; 4]> = (0..16)
        .map(|_| {
            [0.0, 0.4, 0.0, 0.0].map(|low| ((low + (1.0 - low) * random.next()) * 255.0) as u8)
        })
        .collect();
    let picture = picture(4, |x, y| texels[(4 * y + x) as usize]);
    let number = |reads| {
        let texture = Some(texture(picture.clone(), Filter::Linear));
        Paint { factor: [1.0; 3], texture, reads, by_vertices: false }
    };
    let color = paint([1.0, 0.9, 0.8], texture(noise(22, 4), Filter::Linear));
    let parameters = vec![
        (Parameter::BaseColor, color),
        (Parameter::Metallic, number(Reads::Blue)),
        (Parameter::Roughness, number(Reads::Green)),
    ];
    let bsdf = Bsdf::MetallicRoughness {
        base_color: [1.0, 0.9, 0.8].into(),
        metallic: 1.0,
        alpha: 1.0,
        ior: 1.5,
        specular: 1.0,
    };
    let textures = Textures { parameters, ..Textures::default() };
    let plate = quad(v(0.0, -0.5, 0.2), v(0.9, 0.0, 0.0), v(0.0, 0.4, -0.6));
    add(&mut world, "plate", (Material::from(bsdf).two_sided(), textures), plate);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.5));
    world
}

fn painted_lamp() -> World {
    let mut world = stage(Textures::default());
    let emission = paint([6.0, 5.0, 4.0], texture(noise(3, 5), Filter::Linear));
    let screen = Textures { emission: Some(emission), ..Textures::default() };
    let material = Material::from(Bsdf::diffuse(0.4)).emitting([6.0, 5.0, 4.0]).two_sided();
    let shape = quad(v(-0.2, 0.1, 0.1), v(0.5, 0.1, 0.2), v(-0.1, 0.6, 0.1));
    add(&mut world, "screen", (material, screen), shape);
    world
}

/// Balls: a colored one, a raised one that is a mirror, and a lamp.
fn globes() -> World {
    let mut world = stage(Textures::default());
    let place = |center: DVec3| {
        let turn = DAffine3::from_rotation_x(1.1) * DAffine3::from_rotation_y(-0.6);
        Transform(DAffine3::from_translation(center) * turn)
    };
    let raised = |scale| {
        let (texture, of) = (texture(noise(31, 6), Filter::Linear), ReliefOf::Heights(Reads::Red));
        Some(Relief { texture, scale, of })
    };
    let glow = paint([9.0, 8.0, 7.0], texture(noise(33, 5), Filter::Linear));
    let metal = Bsdf::metal("Al").expect("it is tabulated");
    let balls = [
        (
            Material::from(Bsdf::diffuse(0.7)),
            Textures { relief: raised(0.05), ..colored(texture(noise(32, 4), Filter::Linear)) },
            (DVec3::new(-0.5, -0.5, 0.0), 0.45),
        ),
        (
            Material::from(metal),
            Textures { relief: raised(0.01), ..Textures::default() },
            (DVec3::new(0.5, -0.6, 0.1), 0.35),
        ),
        (
            Material::emitter([9.0, 8.0, 7.0]),
            Textures { emission: Some(glow), ..Textures::default() },
            (DVec3::new(0.2, 0.5, 0.2), 0.25),
        ),
    ];
    for (material, textures, (center, radius)) in balls {
        let material = world.add_material("", material).expect("sound");
        world.set_textures(material, textures).expect("of this model");
        world.add_sphere("", radius, material, place(center)).expect("sound");
    }
    world
}

/// Glass with pictures of color: a pane with holes, a smooth ball and a rough one.
fn stained_glass() -> World {
    let mut world = stage(Textures::default());
    let stain = |seed| {
        let color = |seed, factor| Some(paint(factor, texture(noise(seed, 3), Filter::Linear)));
        let transmitted = color(seed, [1.0, 0.9, 0.8]);
        Stain { reflected: color(seed + 1, [0.9, 1.0, 1.0]), transmitted }
    };
    let of = |seed| Textures { stain: stain(seed), ..Textures::default() };
    let rough = Bsdf::RoughDielectric {
        ior: 1.5.into(),
        exterior_ior: 1.0.into(),
        alpha: 0.3,
        distribution: Distribution::Ggx,
        multiple_scattering: true,
    };
    for (bsdf, seed, center) in [
        (Bsdf::dielectric(1.5), 51, DVec3::new(-0.5, -0.5, 0.0)),
        (rough, 53, DVec3::new(0.5, -0.5, -0.2)),
    ] {
        let material = world.add_material("", bsdf).expect("sound");
        world.set_textures(material, of(seed)).expect("of this model");
        world.add_sphere("", 0.4, material, center).expect("sound");
    }
    let leaf =
        Layers { diffuse_transmission: 0.5, transmission: 0.3, ..Layers::plain(0.8, 0.0, 0.4) };
    let holes = Textures { coverage: coverage(noise(57, 4), Some(0.4)), ..Textures::default() };
    let shape = quad(v(-0.4, 0.3, 0.2), v(0.4, 0.1, 0.1), v(0.0, 0.3, -0.3));
    add(&mut world, "leaf", (Bsdf::Layered { layers: leaf }.into(), holes), shape);
    let holed = Textures { coverage: coverage(noise(56, 4), None), ..of(55) };
    let pane = quad(v(0.1, 0.4, 0.0), v(0.6, 0.1, 0.0), v(0.0, 0.1, -0.6));
    add(&mut world, "pane", (Bsdf::thin_dielectric(1.5).into(), holed), pane);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.6));
    world
}

fn relief() -> World {
    let texels = noise(4, 4);
    let relief = |scale| {
        Some(Relief {
            texture: texture(texels.clone(), Filter::Linear),
            scale,
            of: ReliefOf::Normals(ReliefFrame::Picture),
        })
    };
    let bent = |scale| Textures { relief: relief(scale), ..Textures::default() };
    let mut world = stage(bent(0.7));
    let mirror = quad(v(-0.95, 0.0, 0.0), v(0.0, 0.0, -1.0), v(0.0, 0.7, 0.0));
    let metal = Bsdf::metal("Al").expect("it is tabulated");
    add(&mut world, "mirror", (metal.into(), bent(0.2)), mirror);
    let pane = quad(v(0.4, -0.4, 0.3), v(0.4, 0.0, 0.1), v(0.0, 0.4, 0.1));
    add(&mut world, "pane", (Bsdf::thin_dielectric(1.5).into(), bent(0.2)), pane);
    add(&mut world, "lamp", (Material::emitter(8.0), Textures::default()), panel(0.6));
    world
}

/// What there is of a sheet, by alpha of a picture.
fn coverage(texels: Arc<Picture>, cutoff: Option<f32>) -> Option<Coverage> {
    let texture = Some(texture(texels, Filter::Linear));
    let paint = Paint { factor: [0.9; 3], texture, reads: Reads::Alpha, by_vertices: false };
    Some(Coverage { paint, cutoff })
}

/// Sheets between a lamp and the floor, one behind the other; a mirror with holes.
fn add_sheets(world: &mut World) {
    for (index, cutoff) in [None, Some(0.3), None].into_iter().enumerate() {
        let height = 0.5 - 0.4 * index as f32;
        let shape = quad(v(0.1, height, 0.0), v(0.7, 0.1, 0.0), v(0.0, 0.1, -0.7));
        let textures = Textures {
            coverage: coverage(noise(5 + index as u64, 4), cutoff),
            ..colored(texture(noise(9, 4), Filter::Linear))
        };
        let material = match index {
            2 => {
                let metal = Bsdf::metal("Cu").expect("it is tabulated");
                let textures = Textures { parameters: Vec::new(), ..textures };
                (Material::from(metal).two_sided(), textures)
            }
            _ => (Material::from(Bsdf::diffuse(0.7)).two_sided(), textures),
        };
        add(world, &format!("sheet {index}"), material, shape);
    }
}

fn holes() -> World {
    let mut world = stage(Textures::default());
    add_sheets(&mut world);
    add(&mut world, "lamp", (Material::emitter(4.0), Textures::default()), panel(0.6));
    world
}

fn shining_holes() -> World {
    let mut world = stage(Textures::default());
    for (index, cutoff) in [None, Some(0.3)].into_iter().enumerate() {
        let emission = paint([2.0, 3.0, 4.0], texture(noise(12, 3), Filter::Linear));
        let textures = Textures {
            emission: Some(emission),
            coverage: coverage(noise(13, 5), cutoff),
            ..Textures::default()
        };
        let material = Material::from(Bsdf::diffuse(0.6)).emitting([2.0, 3.0, 4.0]).two_sided();
        let at = v(0.5 * index as f32 - 0.3, 0.3 * index as f32 - 0.2, 0.2);
        let shape = quad(at, v(0.5, 0.1, 0.2), v(-0.1, 0.6, 0.1));
        add(&mut world, &format!("screen {index}"), (material, textures), shape);
    }
    world.set_environment(0.2).expect("sound");
    world
}

fn holes_in_fog() -> World {
    let mut world = holes();
    let [sigma_a, sigma_s] = [0.05, 0.2].map(|sigma: f32| Some(sigma.into()));
    let fog = sunstone::world::Medium { sigma_a, sigma_s, phase: Phase::isotropic() };
    let fog = world.add_medium("fog", fog).expect("sound");
    world.set_scene_medium(fog).expect("sound");
    world
}
