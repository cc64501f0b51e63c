//! What a world is shown by that says nothing of it: a camera that sees all of it, and a sky.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use hecs::Entity;

use super::{
    Ball, Bsdf, Emission, Environment, Geometry, Lens, MadeOf, Mesh, Name, Punctual, Sides,
    Transform, World,
};
use crate::math::elementary::{atan2, log10, sin_cos, tan};
use crate::math::text::excerpt;
use crate::math::{Fault, Range};
use crate::scene::error::SceneError;

/// The angle of view of a camera that is put in, in degrees, were it to see a ball.
const ANGLE_DEG: f64 = 35.0;
/// How much more than all there is the picture shows.
const MARGIN: f64 = 1.08;
/// How far off all there is the camera stays at least, in radii of a ball about it.
const DISTANCE_MIN: f64 = 2.0;
/// Most vertices that a frame is fitted to; of more, to the boxes of meshes.
const POINTS_MAX: usize = 1 << 20;
/// Most triangles that decide on where the camera stands, about.
const FACES_MAX: usize = 1 << 18;
/// Where the camera may stand: degrees from the front (+z) to the right, and upwards. The first is
/// the three-quarter view that people give to things; the others are for what shows nothing there,
/// as a ground, or a picture that hangs the other way.
const SIDES_DEG: [[f64; 2]; 14] = [
    [30.0, 20.0],
    [-30.0, 20.0],
    [30.0, 45.0],
    [60.0, 20.0],
    [-60.0, 20.0],
    [150.0, 20.0],
    [-150.0, 20.0],
    [150.0, 45.0],
    [120.0, 20.0],
    [-120.0, 20.0],
    [30.0, -20.0],
    [30.0, -45.0],
    [150.0, -20.0],
    [0.0, 10.0],
];
/// The first side that shows at least so much of what the best shows is taken.
const GOOD_ENOUGH: f64 = 0.6;
/// Mean radiance of the sky that is put in: a white surface that faces where it is brightest is not
/// clipped in a picture.
pub(in crate::scene) const SKY: f32 = 0.8;
/// It is brighter above, in front (+z) and to the left, so that faces of one color are told apart,
/// mirrors have something to show, and what is seen from the front stands before something darker.
pub(in crate::scene) const SKY_GRADIENT: Vec3 = Vec3::new(-0.4, 0.65, 0.4);

/// How much of what is before the camera has to be in the picture from left to right, whatever the
/// shape of the film: a camera with this sees more than its angle from top to bottom on a film that
/// is high and narrow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Tangent of half the angle, greater than zero.
    pub tan_half_x: f32,
}

impl Window {
    /// Refuses what is no angle.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        Range::POSITIVE.check("tan_half_x", self.tan_half_x)
    }
}

/// Something that the scene does not state, and that has been put in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PutIn {
    /// What it is, as the metadata of images call it.
    pub what: &'static str,
    /// What it is like.
    pub text: String,
    /// Why it was put in, and how to state it.
    pub note: String,
}

impl World {
    /// Puts a camera in, in place of that which was there, that sees all shapes, from the front
    /// (+z) and a little from the right and above; from elsewhere if they show little there. All
    /// of it is in the picture, whatever the shape of the film.
    ///
    /// ```
    /// use sunstone::world::{Bsdf, Geometry, Transform, World};
    /// use sunstone::glam::Vec3;
    ///
    /// let mut world = World::new("a box");
    /// let white = world.add_material("white", Bsdf::diffuse(0.7))?;
    /// let cuboid = Geometry::cuboid(Vec3::splat(-1.0), Vec3::splat(1.0));
    /// world.add_mesh("box", cuboid, white, Transform::IDENTITY)?;
    /// world.frame()?;
    /// world.set_environment(1.0)?;
    /// world.check()?;
    /// # Ok::<(), sunstone::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// When there are no shapes, or they reach too far to be seen.
    pub fn frame(&mut self) -> Result<Entity, SceneError> {
        self.frame_or("set one by World::set_camera")
    }

    /// The same, where notes say `how` to state a camera instead.
    pub(in crate::scene) fn frame_or(&mut self, how: &str) -> Result<Entity, SceneError> {
        let parts = Parts::of(self);
        let points = parts.points();
        let Some([low, high]) = bounds(&points) else {
            let remedy = "add a mesh or a sphere, or choose another scene of the file";
            return Err(SceneError::new("scene", "has nothing that could be seen", remedy));
        };
        let middle = 0.5 * (low + high);
        let radius = 0.5 * (high - low).length();
        if !(radius.is_normal() && middle.is_finite()) {
            let remedy = "scale it up or down, or state a camera";
            return Err(SceneError::new("scene", "is too small or too large to be framed", remedy));
        }
        let towards = parts.side();
        let frame = Frame::about(&points, middle, radius, towards);
        let place = Transform::looking(frame.eye, frame.eye - towards, DVec3::Y);
        let yfov = 2.0 * atan2(frame.tan_half[1], 1.0);
        let camera = self.set_camera("put in", Lens::pinhole(yfov), place)?;
        let window = Window { tan_half_x: frame.tan_half[0] as f32 };
        self.insert(camera, window);
        let at = vector(frame.eye, radius);
        let text = format!(
            "put in at {at}, looking along {}, {:.1} degrees from left to right and {:.1} from top \
             to bottom at least",
            vector(-towards, 1.0),
            (2.0 * atan2(frame.tan_half[0], 1.0)).to_degrees(),
            yfov.to_degrees()
        );
        let note = format!("a camera that sees all of the scene is {text}; to state one, {how}");
        self.put_in.push(PutIn { what: "camera", text, note });
        self.warnings.extend(parts.stray(&points));
        Ok(camera)
    }

    /// Puts in a neutral sky; notes say `how` to state light instead.
    pub(in crate::scene) fn light_up(&mut self, how: &str) -> Result<(), SceneError> {
        self.set_sky(SKY, SKY_GRADIENT)?;
        let gradient = SKY_GRADIENT.to_array();
        let text = format!("put in: a sky of radiance {SKY}, gradient {gradient:?}");
        let note = format!(
            "nothing in the scene emits: a sky is put in, brighter above; to state it, {how}; \
             --light none puts in nothing"
        );
        self.put_in.push(PutIn { what: "light", text, note });
        Ok(())
    }

    /// What the scene does not state and has been put in.
    pub fn put_in(&self) -> &[PutIn] {
        &self.put_in
    }

    /// Whether anything shines but some materials.
    pub(in crate::scene) fn emits(&self, but: &[Entity]) -> bool {
        let of = self.in_order::<&MadeOf, _>(|of| of.0).into_iter();
        let of: Vec<Entity> = of.filter(|material| !but.contains(material)).collect();
        let mut glowing = of.iter().filter_map(|it| self.entities.get::<&Emission>(*it).ok());
        let shines = |values: &[f32]| values.iter().any(|value| *value > 0.0);
        glowing.any(|it| shines(it.radiance.values()))
            || self.in_order::<&Punctual, _>(|it| shines(it.intensity.values())).contains(&true)
            || self.in_order::<&Environment, _>(|it| shines(it.mean().values())).contains(&true)
    }
}

/// A vector in as many digits as tell points apart in a ball of a radius.
fn vector(of: DVec3, radius: f64) -> String {
    const DIGITS: f64 = 3.0;
    let size = of.abs().max_element().max(radius);
    let places = (DIGITS - log10(radius).floor()).clamp(0.0, 12.0) as usize;
    match (1e-6..1e9).contains(&size) {
        true => format!("({:.places$}, {:.places$}, {:.places$})", of.x, of.y, of.z),
        false => format!("({:.4e}, {:.4e}, {:.4e})", of.x, of.y, of.z),
    }
}

fn bounds(points: &[DVec3]) -> Option<[DVec3; 2]> {
    let first = *points.first()?;
    Some(points.iter().fold([first; 2], |[low, high], point| [low.min(*point), high.max(*point)]))
}

/// What the camera has to show of a picture.
struct Frame {
    eye: DVec3,
    /// Tangents of half the angles from left to right and from top to bottom.
    tan_half: [f64; 2],
}

impl Frame {
    /// That of points which are seen from the direction `towards`.
    fn about(points: &[DVec3], middle: DVec3, radius: f64, towards: DVec3) -> Self {
        let axes = Transform::looking(towards, DVec3::ZERO, DVec3::Y).0.matrix3;
        let seen: Vec<DVec3> =
            points.iter().map(|point| axes.transpose() * (*point - middle) / radius).collect();
        let widest = tan(0.5 * ANGLE_DEG.to_radians()) / MARGIN;
        // A point is in the picture if |x| <= t (distance - z): of all these planes the two that
        // are farthest out meet in the eye.
        let of_axis = |axis: usize, t: f64| {
            let reach = |sign: f64| {
                seen.iter().map(|p| sign * p[axis] + t * p.z).fold(f64::NEG_INFINITY, f64::max)
            };
            let [right, left] = [reach(1.0), reach(-1.0)];
            (0.5 * (right - left), 0.5 * (right + left))
        };
        let nearest = seen.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
        let distance = (0..2).map(|axis| of_axis(axis, widest).1 / widest).fold(0.0, f64::max);
        let distance = distance.max(DISTANCE_MIN).max(nearest + 0.5);
        let mut center = [0.0; 2];
        let mut tan_half = [0.0; 2];
        for axis in 0..2 {
            const ROUNDS: usize = 12;
            let mut t = widest;
            for _ in 0..ROUNDS {
                let (middle, half) = of_axis(axis, t);
                center[axis] = middle;
                t = (half / distance).max(1e-3 * widest);
            }
            // The middle and the angle are of the last two rounds: what is missing is looked up.
            let off = |p: &DVec3| (p[axis] - center[axis]).abs() / (distance - p.z);
            let t = seen.iter().map(off).fold(t, f64::max);
            tan_half[axis] = MARGIN * t;
        }
        let eye = middle + radius * (axes * DVec3::new(center[0], center[1], distance));
        Self { eye, tan_half }
    }
}

/// All shapes, in world space.
struct Parts {
    meshes: Vec<Part>,
    balls: Vec<(DVec3, f64)>,
}

/// A part of a mesh in its place.
struct Part {
    name: String,
    geometry: Arc<Geometry>,
    to_world: DAffine3,
    /// Whether it is the same from both sides.
    two_sided: bool,
}

impl Parts {
    fn of(world: &World) -> Self {
        let rows =
            world.in_order::<(&Name, &Mesh, &Transform, &MadeOf), _>(|(name, mesh, place, of)| {
                (name.0.clone(), Arc::clone(&mesh.0), place.0, of.0)
            });
        let two_sided = |material: Entity| {
            let sides = world.entities.get::<&Sides>(material);
            let bsdf = world.entities.get::<&Bsdf>(material);
            sides.is_ok_and(|it| it.two_sided) || bsdf.is_ok_and(|it| it.transmits())
        };
        let meshes = rows.into_iter().map(|(name, geometry, to_world, of)| Part {
            name,
            geometry,
            to_world,
            two_sided: two_sided(of),
        });
        let balls = world.in_order::<(&Ball, &Transform), _>(|(ball, place)| {
            (place.0.translation, ball.radius * place.0.matrix3.x_axis.length())
        });
        Self { meshes: meshes.collect(), balls }
    }

    /// Points within whose hull all of it is, but for little.
    fn points(&self) -> Vec<DVec3> {
        let mut used: HashMap<*const Geometry, Vec<DVec3>> = HashMap::new();
        for part in &self.meshes {
            used.entry(Arc::as_ptr(&part.geometry)).or_insert_with(|| corners(&part.geometry));
        }
        let of = |part: &Part| &used[&Arc::as_ptr(&part.geometry)];
        let count: usize = self.meshes.iter().map(|part| of(part).len()).sum();
        if count > POINTS_MAX {
            for points in used.values_mut() {
                *points = bounds(points).map_or(Vec::new(), |[low, high]| box_corners(low, high));
            }
        }
        let of = |part: &Part| &used[&Arc::as_ptr(&part.geometry)];
        let mut points = Vec::new();
        for part in &self.meshes {
            points.extend(of(part).iter().map(|point| part.to_world.transform_point3(*point)));
        }
        for &(center, radius) in &self.balls {
            points.extend(around().map(|direction| center + radius * direction));
        }
        points
    }

    /// The direction from which to look: the first good one of [`SIDES_DEG`].
    fn side(&self) -> DVec3 {
        let faces = self.faces();
        let sides = SIDES_DEG.map(|side| {
            let [(sin_a, cos_a), (sin_h, cos_h)] =
                side.map(|degrees| sin_cos(degrees.to_radians()));
            DVec3::new(sin_a * cos_h, sin_h, cos_a * cos_h)
        });
        let shown = sides.map(|side| {
            let of_face = |(normal, two_sided): &(DVec3, bool)| match two_sided {
                true => 0.5 * normal.dot(side).abs(),
                false => normal.dot(side).max(0.0),
            };
            faces.iter().map(of_face).sum::<f64>()
        });
        let best = shown.into_iter().fold(0.0, f64::max);
        let good = shown.iter().position(|shown| *shown >= GOOD_ENOUGH * best);
        sides[good.unwrap_or(0)]
    }

    /// Normals of triangles, to their fronts, as long as their areas are large, and whether they
    /// are the same from behind.
    fn faces(&self) -> Vec<(DVec3, bool)> {
        let count: usize = self.meshes.iter().map(|part| part.geometry.triangles.len()).sum();
        let every = count.div_ceil(FACES_MAX).max(1);
        let mut faces = Vec::new();
        for part in &self.meshes {
            let axes: DMat3 = part.to_world.matrix3;
            let front = axes.determinant().signum();
            let at = |row: u32| axes * part.geometry.positions[row as usize].as_dvec3();
            for &[a, b, c] in part.geometry.triangles.iter().step_by(every) {
                let [a, b, c] = [at(a), at(b), at(c)];
                faces.push((front * (b - a).cross(c - a), part.two_sided));
            }
        }
        faces
    }

    /// That some vertices make the box of everything much larger than the others do, if they do.
    fn stray(&self, points: &[DVec3]) -> Option<String> {
        const LARGER: f64 = 8.0;
        const FEW: usize = 200;
        const LEAST: usize = 16;
        if points.len() < LEAST {
            return None;
        }
        let [low, high] = bounds(points)?;
        let cut = (points.len() / FEW).max(1);
        let mut inner = [low, high];
        for axis in 0..3 {
            let mut along: Vec<f64> = points.iter().map(|point| point[axis]).collect();
            let last = along.len() - 1 - cut;
            inner[0][axis] = *along.select_nth_unstable_by(cut, f64::total_cmp).1;
            inner[1][axis] = *along.select_nth_unstable_by(last, f64::total_cmp).1;
        }
        let [size, most] = [high - low, inner[1] - inner[0]].map(DVec3::length);
        if size <= LARGER * most {
            return None;
        }
        let middle = 0.5 * (inner[0] + inner[1]);
        let reach = |part: &Part| {
            let points = corners(&part.geometry).into_iter();
            let far = points.map(|at| part.to_world.transform_point3(at).distance(middle));
            far.fold(0.0, f64::max)
        };
        let farthest = self.meshes.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
        let name = farthest.map_or("a sphere", |part| &part.name);
        Some(format!(
            "{}: reaches so far that most of the scene is small in the picture, which shows all of \
             it; state a camera",
            excerpt(name, 200)
        ))
    }
}

/// The vertices of a mesh that are corners of a triangle.
fn corners(geometry: &Geometry) -> Vec<DVec3> {
    let mut is_used = vec![false; geometry.positions.len()];
    geometry.triangles.as_flattened().iter().for_each(|row| is_used[*row as usize] = true);
    let used = geometry.positions.iter().zip(is_used).filter(|(_, is_used)| *is_used);
    used.map(|(position, _)| position.as_dvec3()).collect()
}

fn box_corners(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let pick =
        |bits: usize, axis: usize| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] };
    (0..8).map(|bits| DVec3::new(pick(bits, 0), pick(bits, 1), pick(bits, 2))).collect()
}

/// Points about the unit sphere, a little outside so that it is within their hull.
fn around() -> impl Iterator<Item = DVec3> {
    const OUTSIDE: f64 = 1.1;
    let steps = || (-1..=1).map(f64::from);
    let all = steps()
        .flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
    all.filter(|at| *at != DVec3::ZERO).map(|at| OUTSIDE * at.normalize())
}
