//! A world in its place, ready to be rendered.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::film::filter::{Filter, FilterSamples};
use crate::film::lattice::Lattice;
use crate::film::layout::{Crop, Layout};
use crate::geometry::Accelerator;
use crate::image::cut::Cut;
use crate::image::layers::LayerKind;
use crate::integrators::Integrator;
use crate::math::text::counted;
use crate::scattering::boundaries::{Doubt, settle};
use crate::scattering::emitter::glimpse::pixels_seen;
use crate::scattering::shut_in::Wanderer;
use crate::scattering::{Looks, Scene};
use crate::scene::baked::{Camera, Optics, Shapes};
use crate::scene::warnings::Warnings;
use crate::scene::world::Asked;
use crate::scene::{Plan, SceneError, World, bake_camera, bake_optics, bake_shapes, plan_shapes};
use crate::spectrum::{Beyond, Carried, Responses, White};

use super::RenderError;
use super::immersed::{immersed, names_of_emitters};
use super::layers::{SeenFirst, layers};
use super::memory::{check_tree, check_world};
use super::resolved::{Resolved, Rule, blindness};
use super::sets::{Sets, Spectra};
use super::settings::{Options, Settings, SettingsError, check_film};
use super::spectral::{Columns, Spectral};

/// Film width where neither the scene nor the options name one, in pixels.
const WIDTH: u32 = 512;

/// A world whose shapes have been placed and sorted into a tree. Renders share it: what it does to
/// light is evaluated once for every color and film, of which the latest are kept.
///
/// It is cheap to clone. An edit of the world needs a new one.
#[derive(Clone)]
pub struct PlacedWorld(Arc<Placed>);

struct Placed {
    world: Arc<World>,
    ground: Arc<Ground>,
    camera: Camera,
    rgb: Latest<3>,
    mono: Latest<1>,
    four: Latest<4>,
    eight: Latest<8>,
}

/// The shapes of a world in their tree, with what they were made of.
struct Ground {
    plan: Plan,
    shapes: Arc<Shapes>,
    accelerator: Arc<Accelerator>,
    looks: Arc<Looks>,
}

/// Scenes that are kept for every number of wavelengths.
const KEPT_MAX: usize = 16;

/// A scene of so many columns, with what these are and with its film.
type Kept<const N: usize> = (Key, Layout, Sets<N>);

/// What light is carried at, by which white, what spectra say beyond their ends, and how the film
/// of a spectral render responds.
type Key = (Columns, White, Beyond, Option<Responses>);

/// The latest of them.
type Latest<const N: usize> = Mutex<Vec<Kept<N>>>;

/// Something to be done with a scene, whatever the number of its columns.
pub(super) trait WithScene {
    /// What comes of it.
    type Output;

    /// Does it.
    fn with<const N: usize>(self, sets: Sets<N>) -> Self::Output;
}

impl PlacedWorld {
    /// Places a world.
    ///
    /// # Errors
    /// When the world is not as it should be ([`World::check`]), or does not fit into the numbers
    /// of the renderer or into the memory.
    pub fn new(world: World) -> Result<Self, RenderError> {
        let ground = Arc::new(Ground::new(&world, plan_shapes(&world)?)?);
        Self::on(world, ground)
    }

    /// Places another world, mostly this one after an edit, with the shapes and the tree of this
    /// one where its own would be the same: where materials and lights have other numbers, say, or
    /// the camera stands elsewhere. The images are those of [`PlacedWorld::new`], bit for bit.
    ///
    /// Meshes are the same if they are the same in memory.
    ///
    /// # Errors
    /// Those of [`PlacedWorld::new`].
    pub fn beside(&self, world: World) -> Result<Self, RenderError> {
        let plan = plan_shapes(&world)?;
        let ground = match plan == self.0.ground.plan {
            true => Arc::clone(&self.0.ground),
            false => Arc::new(Ground::new(&world, plan)?),
        };
        Self::on(world, ground)
    }

    /// Whether another world would share the shapes and the tree of this one.
    ///
    /// # Errors
    /// When the world is not as it should be ([`World::check`]).
    pub fn shares_shapes(&self, world: &World) -> Result<bool, RenderError> {
        Ok(plan_shapes(world)? == self.0.ground.plan)
    }

    fn on(world: World, ground: Arc<Ground>) -> Result<Self, RenderError> {
        let camera = bake_camera(&world, &ground.shapes)?;
        Ok(Self(Arc::new(Placed {
            world: Arc::new(world),
            ground,
            camera,
            rgb: Mutex::default(),
            mono: Mutex::default(),
            four: Mutex::default(),
            eight: Mutex::default(),
        })))
    }

    /// What has been placed.
    pub fn world(&self) -> &World {
        &self.0.world
    }

    /// What of the world is not rendered as it was described, one sentence each: what its file asks
    /// for and the renderer ignores, and what its place has made of it.
    pub fn warnings(&self) -> impl Iterator<Item = &str> {
        let Placed { world, ground, .. } = &*self.0;
        world.warnings().iter().chain(&ground.shapes.warnings).map(String::as_str)
    }

    /// How the scene asks to be rendered where nothing else is said.
    pub fn asked(&self) -> &Asked {
        self.0.world.asked()
    }

    /// The radius of a ball about all that has a place, in scene units.
    pub fn radius(&self) -> f32 {
        self.0.ground.shapes.bounds.radius
    }

    /// Width and height of the film: what the options ask for, else what the camera does, else
    /// 512 pixels wide; an edge that is not given follows from the other and the camera's aspect.
    ///
    /// # Errors
    /// When such a film could not be counted or stored.
    pub fn film_size(&self, options: &Options) -> Result<[u32; 2], SettingsError> {
        film_size(options, &self.0.camera)
    }

    /// The film: its size, which of its pixels are rendered, and how they see.
    ///
    /// # Errors
    /// When such a film could not be counted or stored, or the part is none of it.
    pub fn film(&self, options: &Options) -> Result<Layout, SettingsError> {
        film(options, &self.0.camera)
    }

    /// What the camera of a film sees first.
    ///
    /// # Errors
    /// When there is no such film, or the world cannot be seen in RGB, which colors of layers are.
    pub(super) fn seen_first(&self, settings: &Settings) -> Result<SeenFirst, RenderError> {
        if settings.layers.is_empty() {
            return Ok(SeenFirst::default());
        }
        let film = self.film(settings)?;
        let carried = Carried::RGB.beyond(settings.beyond());
        let scene = self.fixed(&self.0.rgb, Columns::Rgb, carried, film)?.scene;
        let layers = layers(&scene, &settings.layers, settings.seed);
        let [materials, objects] = self.0.world.own_names();
        let names = |kind: LayerKind| {
            let names = match kind {
                LayerKind::Material => &materials[..],
                LayerKind::Object => &objects[..],
                LayerKind::Depth
                | LayerKind::Normal
                | LayerKind::Albedo
                | LayerKind::Position
                | LayerKind::Uv => return None,
            };
            let key = kind.names_key()?.to_owned();
            Some((key, serde_json::Value::from(names).to_string()))
        };
        let names = settings.layers.iter().filter_map(|kind| names(*kind)).collect();
        Ok(SeenFirst { layers, names })
    }

    /// In words: what of the world is not rendered as it was described, the coefficients that its
    /// media compute, in RGB, the media that the camera and the emitters are in, and which
    /// integrator suits it.
    ///
    /// # Errors
    /// When the world cannot be seen in RGB.
    pub fn describe(&self) -> Result<String, SceneError> {
        let Placed { world, ground, .. } = &*self.0;
        let warnings = ground.shapes.warnings.iter().map(|warning| format!("warning: {warning}\n"));
        let options = Options { integrator: Some(Integrator::Path), ..Options::default() };
        let film = self.film(&options).unwrap_or(Layout::plain([1, 1]));
        let scene = self.fixed(&self.0.rgb, Columns::Rgb, Carried::RGB, film)?.scene;
        let media = match world.media_names().is_empty() {
            true => String::new(),
            false => immersed(world, &scene),
        };
        let choice = Rule::of(scene.look()).choice_in_words();
        let blind = Integrator::ALL.iter().filter_map(|it| blindness(*it, scene.look()));
        let by_path = Settings::new(options).map(|by_path| Resolved::new(&by_path, &scene)).ok();
        let glimpsed = by_path.and_then(|by_path| glimpsed(world, &scene, &by_path));
        let notes = blind.chain(shut_in(world, &scene)).chain(glimpsed);
        let notes = notes.map(|note| format!("note: {note}\n"));
        let notes: String = notes.collect();
        Ok(format!("{media}  {choice}\n{notes}{}", warnings.collect::<String>()))
    }

    /// What is to be known of a render before it begins, a sentence each: what has been put into
    /// the scene that it does not state ([`World::put_in`]), which integrator was
    /// chosen and why, if none was asked for, what the integrator does not find in this scene, and
    /// lamps from which no light gets to the camera.
    ///
    /// # Errors
    /// As those of [`super::Renderer::new`], but for the memory.
    pub fn notes(&self, settings: &Settings) -> Result<Vec<String>, RenderError> {
        let Foreseen { notes, lacks } = self.foreseen(settings)?;
        Ok(notes.into_iter().chain(lacks).collect())
    }

    /// The same, apart from what the image lacks.
    pub(crate) fn foreseen(&self, settings: &Settings) -> Result<Foreseen, RenderError> {
        let film = self.film(settings)?;
        let foresee = Foresee { world: &self.0.world, settings };
        let mut foreseen = self.with_scene(settings, film, foresee)?;
        let put_in = self.world().put_in().iter().map(|it| it.note.clone());
        foreseen.notes.splice(0..0, put_in);
        Ok(foreseen)
    }

    /// Of these, what the image lacks.
    ///
    /// # Errors
    /// As [`PlacedWorld::notes`].
    pub fn lacks(&self, settings: &Resolved) -> Result<Vec<String>, RenderError> {
        let film = self.film(settings)?;
        self.with_scene(settings, film, Lacks { world: &self.0.world, settings })
    }

    /// Does something with the scene for a film: here the number of columns is chosen.
    pub(super) fn with_scene<W: WithScene>(
        &self,
        settings: &Settings,
        film: Layout,
        work: W,
    ) -> Result<W::Output, RenderError> {
        let Placed { rgb, mono, four, eight, .. } = &*self.0;
        let columns = settings.columns();
        Ok(match columns {
            Columns::Rgb => {
                let carried = Carried::RGB.beyond(settings.beyond());
                work.with(self.fixed(rgb, columns, carried, film)?)
            }
            Columns::Mono(nm) => {
                let carried = Carried::at([nm]).under(settings.white()).beyond(settings.beyond());
                work.with(self.fixed(mono, columns, carried, film)?)
            }
            Columns::Four(of) => work.with(self.spectral(four, (columns, of), settings, film)?),
            Columns::Eight(of) => work.with(self.spectral(eight, (columns, of), settings, film)?),
        })
    }

    /// A scene whose columns are the channels of its film.
    fn fixed<const N: usize>(
        &self,
        latest: &Latest<N>,
        columns: Columns,
        carried: Carried<N>,
        film: Layout,
    ) -> Result<Sets<N>, SceneError> {
        let key = (columns, carried.white(), carried.held_beyond(), None);
        self.latest(latest, key, film, || {
            let Placed { world, ground, .. } = &*self.0;
            let optics = bake_optics(world, &ground.shapes, &carried)?;
            Ok(Sets::fixed(Arc::new(self.scene(optics, film))))
        })
    }

    /// A scene that has other wavelengths in every iteration.
    fn spectral<const N: usize>(
        &self,
        latest: &Latest<N>,
        (columns, spectral): (Columns, Spectral),
        settings: &Settings,
        film: Layout,
    ) -> Result<Sets<N>, RenderError> {
        let by = (settings.white(), settings.beyond());
        let responses = settings.responses().unwrap_or_else(|| Responses::new(Vec::new()));
        self.latest(latest, (columns, by.0, by.1, Some(responses.clone())), film, || {
            let Placed { world, ground, .. } = &*self.0;
            let of = (responses, spectral, by);
            let (spectra, emitters) = Spectra::new(world, &ground.shapes, of)?;
            let scene = spectra.base(emitters, |optics| self.scene(optics, film))?;
            Ok(Sets { scene: Arc::new(scene), spectra: Some(Arc::new(spectra)) })
        })
    }

    fn scene<const N: usize>(&self, optics: Optics<N>, film: Layout) -> Scene<N> {
        let Placed { ground, camera, .. } = &*self.0;
        let Ground { shapes, accelerator, looks, .. } = &**ground;
        let tree = (Arc::clone(shapes), Arc::clone(accelerator));
        Scene::with_tree(tree, *camera, optics, film).sharing(Arc::clone(looks))
    }

    fn latest<const N: usize, E>(
        &self,
        latest: &Latest<N>,
        key: Key,
        film: Layout,
        make: impl FnOnce() -> Result<Sets<N>, E>,
    ) -> Result<Sets<N>, E> {
        let find = |latest: &[Kept<N>]| {
            let kept = latest.iter().find(|(of, on, _)| (of, *on) == (&key, film));
            kept.map(|(.., sets)| sets.clone())
        };
        let lock = || latest.lock().expect("no thread panics while it holds the lock");
        if let Some(sets) = find(&lock()) {
            return Ok(sets);
        }
        // Without the lock: a thread that waits for parts of this work may take up another render
        // of its pool meanwhile, which comes here, too.
        let sets = make()?;
        let mut latest = lock();
        if let Some(sets) = find(&latest) {
            return Ok(sets);
        }
        if latest.len() == KEPT_MAX {
            latest.remove(0);
        }
        latest.push((key.clone(), film, sets.clone()));
        Ok(sets)
    }
}

impl Ground {
    /// Bakes the plan of a world.
    fn new(world: &World, plan: Plan) -> Result<Self, RenderError> {
        check_world(world)?;
        let mut shapes = bake_shapes(&plan)?;
        check_tree(&shapes)?;
        let accelerator = Accelerator::of_shapes(&shapes);
        let doubts = settle(&mut shapes, &accelerator);
        shapes.warnings.extend(sentences(world, &doubts));
        let (shapes, accelerator) = (Arc::new(shapes), Arc::new(accelerator));
        Ok(Self { plan, shapes, accelerator, looks: Arc::default() })
    }
}

/// What is to be known of a render before it begins, a sentence each.
pub(crate) struct Foreseen {
    /// How it goes, and what is seen by chance.
    pub notes: Vec<String>,
    /// What the image lacks.
    pub lacks: Vec<String>,
}

/// Looks what is.
struct Foresee<'a> {
    world: &'a World,
    settings: &'a Settings,
}

impl WithScene for Foresee<'_> {
    type Output = Foreseen;

    fn with<const N: usize>(self, sets: Sets<N>) -> Foreseen {
        let Self { world, settings } = self;
        let resolved = Resolved::new(settings, &sets.scene);
        let glimpsed = glimpsed(world, &sets.scene, &resolved);
        let lacks = lacks(world, &sets.scene, &resolved);
        Foreseen { notes: resolved.choice_in_words().into_iter().chain(glimpsed).collect(), lacks }
    }
}

/// Looks what the image lacks.
struct Lacks<'a> {
    world: &'a World,
    settings: &'a Resolved,
}

impl WithScene for Lacks<'_> {
    type Output = Vec<String>;

    fn with<const N: usize>(self, sets: Sets<N>) -> Vec<String> {
        lacks(self.world, &sets.scene, self.settings)
    }
}

fn lacks<const N: usize>(world: &World, scene: &Scene<N>, settings: &Resolved) -> Vec<String> {
    blindness(settings.integrator, scene.look()).into_iter().chain(shut_in(world, scene)).collect()
}

/// Lamps smaller than a pixel that samples are not likely to hit more often than this are seen by
/// chance.
const HITS_MIN: f32 = 10.0;

/// Lamps in view whose own images are so small that the samples of a render hardly hit them, if
/// nothing else finds these.
fn glimpsed<const N: usize>(
    world: &World,
    scene: &Scene<N>,
    settings: &Resolved,
) -> Option<String> {
    if settings.integrator.splats() || !scene.glimpses.has_any() {
        return None;
    }
    let mut images: BTreeMap<(usize, String), f32> = BTreeMap::new();
    for (row, lamp) in names_of_emitters(world, scene).into_iter().enumerate() {
        if let Some(lamp) = lamp {
            *images.entry(lamp).or_default() += pixels_seen(scene, row);
        }
    }
    let is_chance = |&(_, pixels): &(_, f32)| {
        pixels > 0.0 && pixels < 1.0 && pixels * (settings.samples as f32) < HITS_MIN
    };
    let mut small = images.into_iter().filter(is_chance);
    let ((_, first), pixels) = small.next()?;
    let others = match small.count() {
        0 => String::new(),
        others => format!(", and {} likewise", counted(others, ["other", "others"])),
    };
    let name = settings.integrator.name();
    Some(format!(
        "{first}: is in view, but its own image is only {pixels:.1e} of a pixel, which the samples \
         of `{name}` hardly hit{others}; --integrator bdpt shows it"
    ))
}

/// Most lamps that are looked for from the camera, and most parts of each.
const LAMPS: usize = 256;
const PARTS: usize = 8;

/// The lamps from which no light gets to the camera.
fn shut_in<const N: usize>(world: &World, scene: &Scene<N>) -> Option<String> {
    let mut rows_of_lamps: BTreeMap<(usize, String), Vec<usize>> = BTreeMap::new();
    for (row, lamp) in names_of_emitters(world, scene).into_iter().enumerate() {
        if let Some(lamp) = lamp {
            rows_of_lamps.entry(lamp).or_default().push(row);
        }
    }
    let wanderer = Wanderer::new(scene);
    let is_shut_in = |rows: &[usize]| {
        let step = rows.len().div_ceil(PARTS);
        rows.iter().step_by(step).all(|&row| wanderer.is_shut_in(row))
    };
    let lamps = rows_of_lamps.into_iter().take(LAMPS);
    let mut shut_in = lamps.filter(|(_, rows)| is_shut_in(rows)).map(|((_, name), _)| name);
    let first = shut_in.next()?;
    let others = match shut_in.count() {
        0 => String::new(),
        others => format!(" and {}", counted(others, ["other", "others"])),
    };
    Some(format!("{first}{others}: no light gets from it to the camera, past what is opaque"))
}

/// The film that options ask for, and the camera where they do not say it.
fn film(options: &Options, camera: &Camera) -> Result<Layout, SettingsError> {
    let size = film_size(options, camera)?;
    let of_camera = camera.raster;
    let own = camera.resolution.unwrap_or(size);
    let crop = options.crop.or(of_camera.crop.map(|ends| Crop::Pixels(ends).scaled(own, size)));
    let refuse = |rule| SettingsError { setting: "crop", rule };
    let cut = crop.map_or(Ok(Cut::whole(size)), |crop| crop.on(size).map_err(refuse))?;
    let mut filter = options.filter.map_or(of_camera.filter, Filter::of);
    filter.radius = options.filter_radius.unwrap_or(filter.radius);
    let shares = shares(options, filter)?;
    Ok(Layout { cut, filter, shares, pixel_aspect: pixel_aspect(options, camera) })
}

/// Whether samples count for all pixels whose filters reach them.
fn shares(options: &Options, filter: Filter) -> Result<bool, SettingsError> {
    // Where all light comes by connections, there are no samples of pixels.
    let has_samples = options.integrator.is_none_or(Integrator::measures);
    if !has_samples || options.filter_samples == Some(FilterSamples::Own) {
        return Ok(false);
    }
    let shares = Lattice::new(filter).is_some();
    if !shares && filter.radius > 0.5 && options.filter_samples.is_some() {
        let rule = format!(
            "shared is not possible by this filter, {filter}, whose lobes hardly cancel over \
             pixels: leave it out, or give a greater filter radius"
        );
        return Err(SettingsError { setting: "filter_samples", rule });
    }
    Ok(shares)
}

/// Width of a pixel over its height.
fn pixel_aspect(options: &Options, camera: &Camera) -> f32 {
    options.pixel_aspect.unwrap_or(camera.raster.pixel_aspect)
}

fn film_size(options: &Options, camera: &Camera) -> Result<[u32; 2], SettingsError> {
    // Of the picture; that of the film, counted in pixels, is less where these are wide.
    let aspect = camera.aspect().unwrap_or(1.0) / pixel_aspect(options, camera);
    let edge = |value: f32| (value.round() as u32).max(1);
    let [width, height] = match (options.width, options.height) {
        (Some(width), Some(height)) => [width, height],
        (Some(width), None) => [width, edge(width as f32 / aspect)],
        (None, Some(height)) => [edge(height as f32 * aspect), height],
        (None, None) => camera.resolution.unwrap_or([WIDTH, edge(WIDTH as f32 / aspect)]),
    };
    check_film(width, height)?;
    Ok([width, height])
}

/// What boundaries leave in doubt, in the words of the world.
fn sentences(world: &World, doubts: &[Doubt]) -> Vec<String> {
    if doubts.is_empty() {
        return Vec::new();
    }
    let names = world.surface_names();
    let name = |surface: u32| names[surface as usize].as_str();
    let side = |side: usize| ["behind", "before"][side];
    let mut warnings = Warnings::default();
    for doubt in doubts {
        match *doubt {
            Doubt::Overlap([a, b]) => {
                let text = format!(
                    "overlaps {}: where both are, the medium is that of the higher `priority`, or \
                     else of the smaller one",
                    name(b)
                );
                warnings.add_like("overlap", name(a), &text);
            }
            Doubt::Engulfed([body, around]) => {
                let text = format!(
                    "is in {}, which is not closed: light is refracted as if air were between; \
                     close that, or state `exterior_ior` here",
                    name(around)
                );
                warnings.add_like("engulfed", name(body), &text);
            }
            Doubt::Contradiction { surface, side: of, other } => {
                let text = format!(
                    "the medium {} it is not what {} says: paths in opposite directions may \
                     meet different media; state `interior` and `exterior` alike on both, and \
                     close what they bound",
                    side(of),
                    name(other)
                );
                warnings.add_like("contradiction", name(surface), &text);
            }
            Doubt::Open { surface, side: of } => {
                let text = format!(
                    "the medium {} it is not closed off from that of the scene, and where it ends \
                     cannot be known",
                    side(of)
                );
                warnings.add_like("open", name(surface), &text);
            }
        }
    }
    warnings.sentences()
}
