//! Sunlight through a slit and a prism: on a screen every wavelength is where Snell's law has it.
//!
//! All is drawn in the plane of x and y, across the edge of the prism. The beam comes along x and
//! meets the first face at the origin; what leaves the second falls on a screen far away.

use sunstone::glam::{DVec2, DVec3, Vec3};
use sunstone::spectra::index;
use sunstone::world::{Bsdf, Geometry, Lens, Material, Punctual, PunctualKind, Transform};
use sunstone::{Band, Error, Integrator, Mode, Options, PlacedWorld, StokesImage, World};

use crate::fresnel::{bk7, n_sf11};
use crate::measured::{images, spectral};

/// Angle between the faces.
const APEX_DEG: f64 = 60.0;
/// How far from the edge of the prism the beam meets the first face; length of the faces; half the
/// length of the prism.
const FROM_EDGE: f64 = 0.15;
const FACE: f64 = 0.4;
const HALF: f64 = 0.15;
/// Half the width and the height of the slit.
const SLIT: [f64; 2] = [0.02, 0.1];
/// How far away the screen is, and half of its picture.
const DISTANCE: f64 = 10.0;
const PICTURE: [f64; 2] = [1.2, 0.15];
const FILM: [u32; 2] = [256, 32];
/// Middles of the bands in nanometers.
const BANDS_NM: [f64; 8] = [410.0, 440.0, 480.0, 520.0, 560.0, 600.0, 650.0, 700.0];
/// Of which the screen has the middle in the middle.
const MIDDLE_NM: f64 = 500.0;

/// A prism of some glass.
struct Prism {
    name: &'static str,
    index_of: fn(f64) -> f64,
    /// Angle of incidence on the first face: light goes through nearly as little turned as it can
    /// be.
    incidence_deg: f64,
}

const PRISMS: [Prism; 2] = [
    Prism { name: "BK7", index_of: bk7, incidence_deg: 50.0 },
    Prism { name: "N-SF11", index_of: n_sf11, incidence_deg: 66.0 },
];

/// The unit vector at an angle to the x axis.
fn at(deg: f64) -> DVec2 {
    DVec2::from_angle(deg.to_radians())
}

impl Prism {
    /// The outward normals of the two faces: the beam meets the first at its angle of incidence.
    fn normals(&self) -> [DVec2; 2] {
        [at(180.0 - self.incidence_deg), at(APEX_DEG - self.incidence_deg)]
    }

    /// The edge of the prism, and the directions in which the faces lead away from it.
    fn faces(&self) -> (DVec2, [DVec2; 2]) {
        let [first, second] = self.normals();
        let along = [first.perp(), -second.perp()];
        (-FROM_EDGE * along[0], along)
    }

    /// Where the middle of the beam leaves the prism at a wavelength in nanometers, and along which
    /// direction.
    fn ray(&self, nm: f64) -> (DVec2, DVec2) {
        let n = (self.index_of)(nm);
        let [first, second] = self.normals();
        let inside = refracted(DVec2::X, first, n);
        let (edge, _) = self.faces();
        let leaves = inside * (edge.dot(second) / inside.dot(second));
        (leaves, refracted(inside, -second, 1.0 / n))
    }

    /// The middle of the screen, and the direction of the light that falls straight on it.
    fn screen(&self) -> (DVec2, DVec2) {
        let (leaves, light) = self.ray(MIDDLE_NM);
        (leaves + DISTANCE * light, light)
    }

    /// Its shape, outwards.
    fn shape(&self) -> Geometry {
        let (edge, [first, second]) = self.faces();
        let corners = [edge, edge + FACE * first, edge + FACE * second];
        let at = |z: f64| corners.map(|it| it.extend(z).as_vec3());
        let positions = [-HALF, HALF].into_iter().flat_map(at);
        let triangles = [[0, 2, 1], [3, 4, 5]].into_iter();
        let sides = (0..3_u32).flat_map(|corner| {
            let next = (corner + 1) % 3;
            [[corner, next, next + 3], [corner, next + 3, corner + 3]]
        });
        Geometry::new(positions.collect(), triangles.chain(sides).collect())
    }
}

/// Snell's law in the plane: unit vectors of the light and of the normal against it, and the index
/// behind over that before.
fn refracted(light: DVec2, normal: DVec2, eta: f64) -> DVec2 {
    let cos_i = -light.dot(normal);
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    light / eta + normal * (cos_i / eta - cos_t)
}

fn world(prism: &Prism) -> PlacedWorld {
    let world = || -> Result<World, Error> {
        let mut world = World::new("prism");
        let (ior, _) = index(prism.name).expect("it is tabulated");
        let glass = Bsdf::DispersiveDielectric { ior, exterior_ior: 1.0.into() };
        let glass = world.add_material("glass", glass)?;
        let white = world.add_material("white", Bsdf::diffuse(0.9))?;
        let black = world.add_material("black", Material::from(Bsdf::Absorber).two_sided())?;
        let here = Transform::IDENTITY;
        world.add_mesh("prism", prism.shape(), glass, here)?;
        let (middle, light) = prism.screen();
        let across = light.perp().extend(0.0).as_vec3();
        let up = Vec3::Z;
        // Its front to the light.
        let wall = Geometry::quad(middle.extend(0.0).as_vec3(), up * 0.5, across * 1.5);
        world.add_mesh("screen", wall, white, here)?;
        for (name, center, half) in blinds() {
            let [center, half] = [center, half].map(DVec3::as_vec3);
            world.add_mesh(
                name,
                Geometry::quad(center, Vec3::Y * half.y, up * half.z),
                black,
                here,
            )?;
        }
        let sun = Punctual { kind: PunctualKind::Directional, intensity: 1.0.into() };
        world.add_light("sun", sun, Transform::looking(DVec3::ZERO, DVec3::X, DVec3::Y))?;
        let eye = (middle - light).extend(0.0);
        let place = Transform::looking(eye, middle.extend(0.0), DVec3::Z);
        let [half_width, half_height] = PICTURE.map(|half| half as f32);
        world.set_camera("eye", Lens::Orthographic { half_width, half_height }, place)?;
        world.set_resolution(FILM)?;
        Ok(world)
    };
    PlacedWorld::new(world().expect("a sound world")).expect("a sound world")
}

/// Middles and half edges of the sheets that leave the slit open.
fn blinds() -> [(&'static str, DVec3, DVec3); 4] {
    const WIDE: f64 = 20.0;
    let [half, high] = SLIT;
    let at = |y: f64, z: f64| DVec3::new(-1.0, y, z);
    let beside = DVec3::new(0.0, WIDE, WIDE);
    let above = DVec3::new(0.0, half, WIDE);
    [
        ("left blind", at(half + WIDE, 0.0), beside),
        ("right blind", at(-half - WIDE, 0.0), beside),
        ("upper blind", at(0.0, high + WIDE), above),
        ("lower blind", at(0.0, -high - WIDE), above),
    ]
}

/// Where the middle of the light is on the film, right of the middle, in units of the scene: of the
/// columns about the brightest, no further away than the light of a band reaches.
fn centroid(images: &[StokesImage], channel: usize) -> f64 {
    let [width, height] = FILM.map(|size| size as usize);
    let column = |x: usize| -> f64 {
        let rows = (0..height).map(|y| y * width + x);
        let pixels = rows.flat_map(|pixel| {
            images.iter().map(move |image| f64::from(image.plane(0, channel)[pixel]))
        });
        pixels.sum()
    };
    let columns: Vec<f64> = (0..width).map(column).collect();
    let place = |x: usize| PICTURE[0] * ((2 * x + 1) as f64 / width as f64 - 1.0);
    let brightest = (0..width).max_by(|a, b| columns[*a].total_cmp(&columns[*b]));
    let brightest = place(brightest.expect("the film has columns"));
    let near = (0..width).filter(|x| (place(*x) - brightest).abs() < 4.0 * SLIT[0]);
    let sums = near.fold([0.0; 2], |sum, x| [sum[0] + columns[x], sum[1] + columns[x] * place(x)]);
    sums[1] / sums[0]
}

fn check(prism: &Prism) {
    let world = world(prism);
    // Narrow enough that the middle of the band is that of its light.
    let bands = BANDS_NM.map(|nm| Band::new(nm as f32, 2.0)).to_vec();
    let options = Options {
        integrator: Some(Integrator::Light),
        mode: Mode::Scalar,
        samples: 32,
        path_length_max: 5,
        ..Options::default()
    };
    let images = images(&world, &spectral(8, bands, options), 2);
    let (middle, light) = prism.screen();
    let (glass, backward) = (prism.name, -light);
    // The camera's right: up cross backward.
    let right = backward.perp();
    let mut places = Vec::new();
    for (channel, nm) in BANDS_NM.into_iter().enumerate() {
        let (leaves, towards) = prism.ray(nm);
        let on_screen = leaves + towards * ((middle - leaves).dot(light) / towards.dot(light));
        let expected = (on_screen - middle).dot(right);
        let found = centroid(&images, channel);
        let length = on_screen.distance(leaves);
        // Across the ray, as seen from where it leaves.
        let off = ((found - expected) * towards.dot(light) / length).atan().to_degrees();
        println!(
            "{glass}, {nm} nm: at {found:+.4}, should be {expected:+.4}: {off:+.4} degrees off"
        );
        assert!(off.abs() < 0.05, "{glass}, {nm} nm: {off} degrees off");
        places.push(expected);
    }
    assert!((places[0] - places[7]).abs() > 0.2, "the colors are apart");
}

#[test]
fn prisms_refract_every_wavelength_by_snells_law() {
    PRISMS.iter().for_each(check);
}
