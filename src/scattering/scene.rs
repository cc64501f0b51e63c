//! The scene as the stages see it: the baked tables, the tree, and the look-ups derived from both.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use rayon::prelude::*;

use crate::film::layout::Layout;
use crate::geometry::{
    Accelerator, RayColumns, Rims, SurfaceColumns, medium_met, offset_distance, offset_origin,
};
use crate::math::{LANES, Vector, lanes};
use crate::scene::baked::{BakedScene, Camera, KEEP, NONE, Optics, SOUGHT, Shapes};
use crate::scene::emitter::{Emitter, EmitterModel};

use super::boundaries::settle;
use super::emitter::aim::Aim;
use super::emitter::choice::Choice;
use super::emitter::direct::DirectTable;
use super::emitter::glimpse::Glimpses;
use super::emitter::lamps::Lamps;
use super::emitter::{self, EmissionSample};
use super::event::{END, Event, Met, events};
use super::immersion::{Around, Immersion, STEPS};
use super::medium::Medium;
use super::nesting::{InterfaceLanes, Interfaces, UNKNOWN};
use super::painting::{has_models_by_place, has_painted_lamps, has_relief, has_stains, of_model};
use super::surface::model::LaneRows;
use super::surface::{Crossed, Material, SurfaceKind, Surfaces};
use super::targets::targets;
use super::{Look, Looks, Sensor};

/// Lamps are small whose area is less of that of the ball about the scene, or, if they are
/// infinitely far away, that take up less of all directions.
const SMALL_LAMP: f64 = 1e-3;

/// Everything read-only that a render needs, for `N` wavelengths.
pub struct Scene<const N: usize> {
    /// Where everything is.
    pub shapes: Arc<Shapes>,
    /// The camera without its film.
    pub camera: Camera,
    /// The tree over the primitives.
    pub accelerator: Arc<Accelerator>,
    /// What everything does to light.
    pub optics: Optics<N>,
    /// The camera with its film.
    pub sensor: Sensor,
    /// The materials, and the tables of their models.
    pub surfaces: Surfaces<N>,
    /// For every triangle and sphere, its row in the materials.
    material_of_primitive: Arc<[u32]>,
    /// For every material, what [`of_model`] says.
    pub(super) model_of_material: Vec<u32>,
    /// All kinds of events.
    pub events: Vec<Event>,
    /// Nothing, then for every triangle and sphere, its kind of event.
    event_of_hit: Arc<[u8]>,
    /// The media, and behind them one that is clear.
    media: Vec<Medium<N>>,
    /// Whether there are surfaces that let light straight on.
    pub has_straight_on: bool,
    /// Their kinds.
    pub straight_on_kinds: Vec<Crossed>,
    /// Whether any of those emits.
    pub has_emitting_straight_on: bool,
    /// Whether light can leave vertices that connect polarized.
    pub has_polarizing_vertices: bool,
    /// Whether lamps emit what textures say.
    pub has_painted_lamps: bool,
    /// Whether some glass or metal has a color of its own, or some panes have holes.
    pub has_stains: bool,
    /// Whether photons do not merge about the mirrored direction of some surfaces: not where only
    /// photons find some light.
    pub has_narrow_facets: bool,
    /// Whether light that is connected, or drawn any way, may go through some surfaces.
    pub passes_any_way: bool,
    /// Whether surfaces may have rows in the tables of their models that are of the place.
    pub has_models_by_place: bool,
    /// Whether any shading normal differs from the geometric one.
    pub has_shading_normals: bool,
    /// How far off every emitter rays start and end.
    emitter_offsets: Arc<[f32]>,
    /// The emitters as connections see them.
    pub direct: Arc<DirectTable>,
    /// The medium around the sensor: a row of the media, or [`NONE`].
    pub sensor_medium: Around<u32>,
    /// The media before and behind every emitter.
    emitter_media: Arc<[Around<[u32; 2]>]>,
    /// Which emitter is chosen how often.
    pub choice: Arc<Choice>,
    /// What light paths are aimed at, if not all at the whole scene.
    pub aim: Option<Arc<Aim>>,
    /// Emitters whose own images are small.
    pub glimpses: Arc<Glimpses>,
    /// Lamps that light media straight on, if any do.
    pub lamps: Option<Arc<Lamps>>,
    /// What is refracted where solids overlap or touch, if any do.
    pub interfaces: Option<Interfaces>,
    /// What looks at others of the same shapes have found.
    looks: Arc<Looks>,
    look: OnceLock<Look>,
    rims: Arc<OnceLock<Rims>>,
}

impl<const N: usize> Scene<N> {
    /// Builds the tree and the look-ups for a film of `width` times `height` pixels.
    pub fn new(mut baked: BakedScene<N>, width: u32, height: u32) -> Self {
        let accelerator = Accelerator::of_shapes(&baked.shapes);
        settle(&mut baked.shapes, &accelerator);
        let placed = (Arc::new(baked.shapes), Arc::new(accelerator));
        Self::with_tree(placed, baked.camera, baked.optics, Layout::plain([width, height]))
    }

    /// Builds the look-ups for shapes whose tree there is already: that of other wavelengths, of
    /// another film or camera, or of other materials on the same shapes.
    pub fn with_tree(
        (shapes, accelerator): (Arc<Shapes>, Arc<Accelerator>),
        camera: Camera,
        optics: Optics<N>,
        film: Layout,
    ) -> Self {
        let material_of_primitive = materials_of_primitives(&shapes);
        let mut surfaces = Surfaces::new(&optics.materials, optics.painting.as_deref());
        let interfaces = Interfaces::new(&shapes, &optics, &mut surfaces);
        let materials = surfaces.materials();
        let mut media: Vec<Medium<N>> = optics.media.iter().map(Medium::new).collect();
        let events = events(&media);
        media.push(Medium::clear());
        let has_polarizing_vertices = present(&events, materials).any(|it| it.keeps_polarized());
        let immersion = Immersion::new(&shapes, &accelerator, !optics.media.is_empty());
        let media_of = |emitter: &Emitter| media_about(&immersion, emitter);
        let sensor = Sensor::new(&camera, film);
        let sensor_medium = immersion.about(sensor.places());
        let emitter_media: Arc<[_]> = optics.emitters.par_iter().map(media_of).collect();
        let lamps = Lamps::new((&shapes, &optics), materials, &media, &emitter_media).map(Arc::new);
        let offset_of =
            |emitter: &Emitter| offset_distance(emitter::reach(&emitter.model, &shapes));
        let emitter_offsets = optics.emitters.iter().map(offset_of).collect();
        let straight_on_kinds = straight_on_kinds(materials);
        let passes_any_way = materials.iter().any(|it| it.passes_any_way);
        let has_grain = optics.materials.iter().any(|material| material.model.has_grain());
        let has_models_by_place =
            has_models_by_place(&optics) || has_grain || (passes_any_way && interfaces.is_some());
        let mut emitters = material_of_primitive.iter().zip(&*optics.emitter_of_primitive);
        let has_emitting_straight_on =
            emitters.any(|(&row, &it)| it != NONE && materials[row as usize].is_straight_on());
        let mut scene = Self {
            sensor_medium,
            emitter_media,
            sensor,
            direct: Arc::new(DirectTable::new(&shapes, &optics.emitters)),
            emitter_offsets,
            choice: Arc::new(Choice::new(&shapes, &optics.emitters)),
            aim: None,
            glimpses: Arc::default(),
            lamps,
            interfaces,
            has_polarizing_vertices,
            events,
            has_straight_on: !straight_on_kinds.is_empty(),
            straight_on_kinds,
            has_emitting_straight_on,
            has_painted_lamps: has_painted_lamps(&shapes, &optics),
            has_stains: has_stains(&optics),
            has_shading_normals: shapes.has_shading_normals() || has_relief(&optics),
            has_narrow_facets: false,
            passes_any_way,
            has_models_by_place,
            looks: Arc::default(),
            look: OnceLock::new(),
            rims: Arc::default(),
            media,
            accelerator,
            shapes,
            camera,
            optics,
            model_of_material: surfaces.materials().iter().map(of_model).collect(),
            event_of_hit: events_of_hits(&material_of_primitive, surfaces.materials()),
            material_of_primitive,
            surfaces,
        };
        scene.look_about();
        scene
    }

    /// Finds what follows from all that is there.
    fn look_about(&mut self) {
        // Light that only photons find must not be left out of what they count for.
        let is_narrow = |material: &Material| material.peak > 0.0;
        self.has_narrow_facets =
            self.surfaces.materials().iter().any(is_narrow) && !self.hides_lamps();
        self.aim_light_paths();
        let emitters = &self.optics.emitters;
        self.glimpses = Arc::new(Glimpses::new(&self.shapes, emitters, &self.sensor));
    }

    /// The same scene at other wavelengths: places, trees, choices and what has been learned are
    /// shared. The optics have the emitters of this one, and materials and media of its kinds.
    #[must_use]
    pub fn with_optics(&self, optics: Optics<N>) -> Self {
        let mut surfaces = Surfaces::new(&optics.materials, optics.painting.as_deref());
        let interfaces = Interfaces::new(&self.shapes, &optics, &mut surfaces);
        let mut media: Vec<Medium<N>> = optics.media.iter().map(Medium::new).collect();
        media.push(Medium::clear());
        Self {
            shapes: Arc::clone(&self.shapes),
            camera: self.camera,
            accelerator: Arc::clone(&self.accelerator),
            optics,
            sensor: self.sensor.clone(),
            model_of_material: surfaces.materials().iter().map(of_model).collect(),
            surfaces,
            material_of_primitive: Arc::clone(&self.material_of_primitive),
            events: self.events.clone(),
            event_of_hit: Arc::clone(&self.event_of_hit),
            media,
            has_straight_on: self.has_straight_on,
            straight_on_kinds: self.straight_on_kinds.clone(),
            has_emitting_straight_on: self.has_emitting_straight_on,
            has_polarizing_vertices: self.has_polarizing_vertices,
            has_painted_lamps: self.has_painted_lamps,
            has_stains: self.has_stains,
            has_shading_normals: self.has_shading_normals,
            has_narrow_facets: self.has_narrow_facets,
            passes_any_way: self.passes_any_way,
            has_models_by_place: self.has_models_by_place,
            emitter_offsets: Arc::clone(&self.emitter_offsets),
            direct: Arc::clone(&self.direct),
            sensor_medium: self.sensor_medium,
            emitter_media: Arc::clone(&self.emitter_media),
            choice: Arc::clone(&self.choice),
            aim: self.aim.clone(),
            glimpses: Arc::clone(&self.glimpses),
            lamps: self.lamps.clone(),
            interfaces,
            looks: Arc::clone(&self.looks),
            look: self.look.clone(),
            rims: Arc::clone(&self.rims),
        }
    }

    /// Shares what looks find with other scenes of the same shapes.
    pub fn sharing(self, looks: Arc<Looks>) -> Self {
        Self { looks, ..self }
    }

    /// Looks for what light paths are worth to be aimed at.
    fn aim_light_paths(&mut self) {
        if self.optics.emitters.is_empty() {
            return;
        }
        let targets = targets(self);
        let emitters = Arc::make_mut(&mut self.optics.emitters);
        self.aim = Aim::new(&targets, &self.shapes, emitters).map(Arc::new);
        if self.aim.is_some() {
            let emitters = &self.optics.emitters;
            self.direct = Arc::new(DirectTable::new(&self.shapes, emitters));
            self.choice = Arc::new(Choice::new(&self.shapes, emitters));
        }
    }

    /// The row of a primitive's material.
    #[inline(always)]
    pub fn material_row(&self, primitive: u32) -> usize {
        match self.material_of_primitive.get(primitive as usize) {
            Some(row) => *row as usize,
            None => self.material_of_copy(primitive),
        }
    }

    /// The row of the material of a primitive of an instance.
    #[inline(never)]
    fn material_of_copy(&self, primitive: u32) -> usize {
        let surface = self.shapes.surface_of(primitive);
        self.shapes.surfaces[surface as usize].material as usize
    }

    /// A primitive's material.
    #[inline(always)]
    pub fn material_at(&self, primitive: u32) -> &Material {
        &self.surfaces.materials()[self.material_row(primitive)]
    }

    /// Whether nothing goes through a primitive, but straight on.
    pub fn is_closed(&self, primitive: u32) -> bool {
        self.shapes.surface_of(primitive) == NONE || !self.material_at(primitive).passes_any_way
    }

    /// The events that some surface or medium of the scene is met by.
    pub fn events_present(&self) -> impl Iterator<Item = Event> {
        present(&self.events, self.surfaces.materials())
    }

    /// The place in `events` of what a ray hit, which may be nothing ([`NONE`]) or a medium.
    #[inline(always)]
    pub fn event_hit(&self, primitive: u32) -> usize {
        match medium_met(primitive) {
            Some(medium) => Met::Medium(medium).event(),
            None => match self.event_of_hit.get(primitive.wrapping_add(1) as usize) {
                Some(event) => *event as usize,
                None => self.material_at(primitive).kind.event(),
            },
        }
    }

    /// How far off an emitter's surface rays start and end; zero if it has none.
    #[inline(always)]
    pub fn emitter_offset(&self, emitter: usize) -> f32 {
        self.emitter_offsets[emitter]
    }

    /// Where a ray starts that leaves a point of an emitter along `direction`.
    pub fn off_emitter(&self, sample: &EmissionSample<N>, direction: Vec3) -> Vec3 {
        let [position, normal, direction] = [sample.position, sample.normal, direction]
            .map(|vector| Vector::from(vector.to_array()));
        let offset = self.emitter_offsets[sample.emitter];
        Vec3::from_array(offset_origin(position, normal, direction, offset).into())
    }

    /// The medium into which a point of an emitter sends light along `direction`.
    pub fn medium_at_emitter(&self, sample: &EmissionSample<N>, direction: Vec3) -> u32 {
        let side = usize::from(direction.dot(sample.normal) < 0.0);
        match self.emitter_media[sample.emitter] {
            Around::Same(sides) => sides[side],
            Around::Varies => {
                let primitive = emitter::primitive(&self.optics.emitters[sample.emitter].model);
                self.immersion().of_side(primitive, side, sample.position, sample.normal)
            }
        }
    }

    /// The media before and behind an emitter.
    pub fn media_of_emitter(&self, emitter: usize) -> Around<[u32; 2]> {
        self.emitter_media[emitter]
    }

    /// Whether any light of an emitter enters a medium at once.
    pub fn is_immersed(&self, emitter: usize) -> bool {
        self.emitter_media[emitter] != Around::Same([NONE; 2])
    }

    /// The medium around a point of the sensor.
    pub fn medium_at_sensor(&self, point: Vec3) -> u32 {
        match self.sensor_medium {
            Around::Same(medium) => medium,
            Around::Varies => self.immersion().at(point),
        }
    }

    fn immersion(&self) -> Immersion<'_> {
        Immersion::new(&self.shapes, &self.accelerator, self.has_media())
    }

    /// Whether any medium is another at other wavelengths.
    pub fn has_chromatic_media(&self) -> bool {
        self.media.iter().any(|medium| !medium.is_gray)
    }

    /// Whether paths can be in anything but clear space.
    pub fn has_media(&self) -> bool {
        self.media.len() > 1
    }

    /// Whether what a ray has hit is a surface that lets it straight on.
    #[inline(always)]
    pub fn is_straight_on(&self, primitive: u32) -> bool {
        self.has_straight_on && primitive != NONE && self.material_at(primitive).is_straight_on()
    }

    /// The medium behind the surface that a ray goes straight on through, from the medium
    /// `before`; both are those of a row.
    #[inline(always)]
    pub fn medium_behind(
        &self,
        surfaces: &SurfaceColumns,
        rays: &RayColumns,
        row: usize,
        before: u32,
    ) -> u32 {
        let of = |columns| Vec3::from(lanes::row_of(columns, row));
        let to_front = of(&surfaces.geometric_normal).dot(of(&rays.direction)) > 0.0;
        self.medium_beyond(surfaces, row, to_front, (before, None))
    }

    /// Whether some surfaces leave light a single way, so that light paths cannot connect them to
    /// the sensor.
    pub fn has_specular_surfaces(&self) -> bool {
        let materials = self.surfaces.materials();
        let mut used = self.shapes.surfaces.iter().map(|it| &materials[it.material as usize]);
        used.any(|material| material.kind.is_specular())
    }

    /// Whether some lamps are points, or small against the scene, and some surfaces leave light a
    /// single way: paths from the sensor do not find those lamps behind these.
    pub fn hides_lamps(&self) -> bool {
        let models = || self.optics.emitters.iter().map(|emitter| &emitter.model);
        let finite = models().filter(|model| model.is_finite() && !emitter::is_delta(model));
        let size: f64 = finite.map(|model| model.size(&self.shapes)).sum();
        let whole = (2.0 * PI * f64::from(self.shapes.bounds.radius)).powi(2);
        let is_small = size > 0.0 && size < SMALL_LAMP * whole;
        let is_narrow =
            |model: &EmitterModel| emitter::share_of_sky(model).is_some_and(|it| it < SMALL_LAMP);
        let hides = |model| emitter::is_delta(model) || is_narrow(model);
        self.has_specular_surfaces() && (is_small || models().any(hides))
    }

    /// Where its surfaces end. Found by all threads, when it is first asked for.
    pub fn rims(&self) -> &Rims {
        self.rims.get_or_init(|| Rims::of_shapes(&self.shapes))
    }

    /// What a look at it finds.
    pub fn look(&self) -> &Look {
        self.look.get_or_init(|| self.looks.at(self))
    }

    /// Whether paths can meet some emitters by chance.
    pub fn has_met_emitters(&self) -> bool {
        self.optics.emitters.iter().any(|emitter| !emitter::is_delta(&emitter.model))
    }

    /// A medium; a clear one for [`NONE`].
    #[inline(always)]
    pub fn medium(&self, row: u32) -> &Medium<N> {
        &self.media[(row as usize).min(self.media.len() - 1)]
    }

    /// Where the peak ends of what was met, about the direction straight on in a medium
    /// ([`Medium::peak`]), and about the mirrored one on the surface of a primitive
    /// ([`super::surface::Surface::peak`]).
    #[inline(always)]
    pub fn peak_at(&self, met: Met, primitive: u32) -> f32 {
        match met {
            Met::Surface(_) if self.has_narrow_facets => self.material_at(primitive).peak,
            Met::Surface(_) => 0.0,
            Met::Medium(row) => self.medium(row).peak,
        }
    }

    /// Whether what was met may have a peak.
    pub fn may_peak(&self, met: Met) -> bool {
        match met {
            Met::Surface(_) => self.has_narrow_facets,
            Met::Medium(row) => self.medium(row).peak > 0.0,
        }
    }

    /// Whether some surfaces are there by a share, which light meets or passes.
    #[inline(always)]
    pub fn has_holes(&self) -> bool {
        self.straight_on_kinds.contains(&Crossed::Holes)
    }

    /// Whether some media or surfaces have peaks.
    pub fn has_peaks(&self) -> bool {
        self.has_narrow_facets || self.media.iter().any(|medium| medium.peak > 0.0)
    }

    /// The medium on the side of a surface that is entered, for a path in the medium `before`, and
    /// the `solid` there, if it is known.
    #[inline(always)]
    pub fn medium_beyond(
        &self,
        surfaces: &SurfaceColumns,
        row: usize,
        to_front: bool,
        (before, solid): (u32, Option<u32>),
    ) -> u32 {
        let surface = self.shapes.surface_of(surfaces.primitive[row]);
        let surface = &self.shapes.surfaces[surface as usize];
        match if to_front { surface.exterior } else { surface.interior } {
            KEEP => before,
            SOUGHT => self
                .medium_of_solid(solid)
                .unwrap_or_else(|| self.medium_sought(surfaces, row, to_front)),
            medium => medium,
        }
    }

    /// The medium in a solid, or around all, where it does not have to be sought.
    fn medium_of_solid(&self, solid: Option<u32>) -> Option<u32> {
        let medium = match solid? {
            NONE => self.shapes.around_solids,
            row => self.shapes.solids[row as usize].filling,
        };
        (medium != KEEP).then_some(medium)
    }

    /// The medium next to a point where boundaries contradict each other.
    #[cold]
    fn medium_sought(&self, surfaces: &SurfaceColumns, row: usize, to_front: bool) -> u32 {
        let of = |columns| Vec3::from(lanes::row_of(columns, row));
        let step = STEPS * surfaces.offset[row] * if to_front { 1.0 } else { -1.0 };
        self.immersion().at(of(&surfaces.position) + step * of(&surfaces.geometric_normal))
    }

    /// What paths come to at surfaces that are hit, of which `given` are the rows in the table of
    /// dielectrics: where solids overlap or touch, that is between what is on the two sides there.
    /// `inside` are the numbers of the indices of refraction that the paths are in.
    #[cold]
    pub fn interfaces_at(
        &self,
        interfaces: &Interfaces,
        surfaces: &SurfaceColumns,
        (rays, inside): (&RayColumns, &[u32]),
        hits: [usize; LANES],
        given: &LaneRows,
    ) -> InterfaceLanes {
        let immersion = self.immersion();
        let mut met = InterfaceLanes {
            rows: LaneRows::Same(0),
            inside: hits.map(|hit| [inside[hit]; 2]),
            behind: [None; LANES],
        };
        let mut rows = given.numbers().to_array().map(|row| row as usize);
        for (lane, &hit) in hits.iter().enumerate() {
            let solid = self.shapes.surfaces[surfaces.surface[hit] as usize].solid;
            if solid == NONE {
                continue;
            }
            let of = |columns| Vec3::from(lanes::row_of(columns, hit));
            let (position, normal) = (of(&surfaces.position), of(&surfaces.geometric_normal));
            let to_back = of(&rays.direction).dot(normal) < 0.0;
            let beside = |to_back: bool| {
                let outwards = if to_back { -normal } else { normal };
                immersion.solid_beside(solid, position, outwards, to_back)
            };
            let beyond = beside(to_back);
            met.behind[lane] = Some(beyond);
            let [before, behind] = &mut met.inside[lane];
            if *before == UNKNOWN {
                *before = interfaces.index_of(beside(!to_back));
            }
            *behind = interfaces.index_of(beyond);
            let [front, back] = if to_back { [*before, *behind] } else { [*behind, *before] };
            rows[lane] = interfaces.row([front, back]);
        }
        met.rows = LaneRows::Each(rows);
        met
    }

    /// The emitter of a primitive, or those that a ray may see that hits nothing ([`NONE`]); none
    /// in media.
    #[inline]
    pub fn emitters_seen(&self, primitive: u32) -> Range<u32> {
        if primitive == NONE {
            return self.optics.skies.clone();
        }
        match self.optics.emitter_of_primitive.get(primitive as usize) {
            Some(&row) if row != NONE => row..row + 1,
            Some(_) | None => 0..0,
        }
    }
}

/// For every primitive, the row of its material.
fn materials_of_primitives(shapes: &Shapes) -> Arc<[u32]> {
    let material_of = |&surface: &u32| shapes.surfaces[surface as usize].material;
    shapes.surface_of_primitive.iter().map(material_of).collect()
}

/// What is met by way of hits: nothing, or the event of a primitive's material.
fn events_of_hits(material_of_primitive: &[u32], materials: &[Material]) -> Arc<[u8]> {
    let event_of = |&row: &u32| materials[row as usize].kind.event();
    let events = std::iter::once(END).chain(material_of_primitive.iter().map(event_of));
    events.map(|event| event as u8).collect()
}

/// Those of the events that media and these materials are met by.
fn present(events: &[Event], materials: &[Material]) -> impl Iterator<Item = Event> {
    let is_present = |met: Met| match met {
        Met::Surface(kind) => materials.iter().any(|material| material.kind == kind),
        Met::Medium(_) => true,
    };
    events.iter().filter(move |event| is_present(event.met)).copied()
}

/// The media before and behind an emitter.
fn media_about(immersion: &Immersion, Emitter { model, .. }: &Emitter) -> Around<[u32; 2]> {
    immersion.about_emitter(
        |shapes| emitter::places(model, shapes),
        emitter::primitive(model),
        emitter::is_two_sided(model),
    )
}

/// What light goes straight on through.
fn straight_on_kinds(materials: &[Material]) -> Vec<Crossed> {
    let models = SurfaceKind::STRAIGHT_ON.iter().map(|kind| Crossed::Model(*kind));
    let is_used = |kind: &Crossed| materials.iter().any(|it| it.crossed() == Some(*kind));
    models.chain([Crossed::Holes]).filter(is_used).collect()
}
