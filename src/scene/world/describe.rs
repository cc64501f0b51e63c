//! The world in words, for people who want to know what was understood of their file.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use glam::DVec3;
use hecs::Entity;

use super::incandescent::Incandescent;
use super::light::{Luminaire, Projection};
use super::{
    Action, Along, Ball, Boundary, Bsdf, Coat, Component, Delay, Emission, EmittedStokes,
    Environment, Filling, FillsScene, Grain, Grid, Layers, Lens, MadeOf, Medium, Mesh, Name, Phase,
    Punctual, Raster, Resolution, Sides, ThinFilm, Transform, World,
};
use crate::film::filter::Filter;
use crate::film::layout::Crop;
use crate::math::text::{counted, excerpt};
use crate::polarization::Analyzer;
use crate::polarization::milk::Milk;
use crate::spectrum::Spectrum;

/// Most characters of a line, which a file's names are part of.
const LINE: usize = 1000;

impl World {
    /// Meshes, spheres, materials, media, lights, camera and bounds, a line each; names with their
    /// control characters escaped.
    pub fn describe(&self) -> String {
        let mut text = format!("scene `{}`\n", excerpt(self.name(), LINE));
        // Writing to a string cannot fail.
        let _ = write_shapes(self, &mut text)
            .and_then(|()| write_materials(self, &mut text))
            .and_then(|()| write_media(self, &mut text))
            .and_then(|()| write_lights(self, &mut text))
            .and_then(|()| write_camera(self, &mut text));
        for warning in self.warnings() {
            let _ = writeln!(text, "warning: {warning}");
        }
        text
    }
}

fn write_shapes(world: &World, text: &mut String) -> fmt::Result {
    let meshes = world.in_order::<(&Mesh, &Transform), _>(|(mesh, place)| (mesh.clone(), place.0));
    let balls = world.in_order::<(&Ball, &Transform), _>(|(ball, place)| {
        (place.0.translation, ball.radius * place.0.matrix3.x_axis.length())
    });
    let triangles: usize = meshes.iter().map(|(mesh, _)| mesh.0.triangles.len()).sum();
    let triangles = counted(triangles, ["triangle", "triangles"]);
    let parts = counted(meshes.len(), ["mesh part", "mesh parts"]);
    let spheres = counted(balls.len(), ["analytic sphere", "analytic spheres"]);
    writeln!(text, "  {triangles} in {parts}, {spheres}")?;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (mesh, to_world) in &meshes {
        for position in &mesh.0.positions {
            let position = to_world.transform_point3(position.as_dvec3());
            (low, high) = (low.min(position), high.max(position));
        }
    }
    for (center, radius) in &balls {
        (low, high) = (low.min(center - *radius), high.max(center + *radius));
    }
    if low.x <= high.x {
        writeln!(text, "  bounds {} to {}", vector(low), vector(high))?;
    }
    Ok(())
}

fn vector(v: DVec3) -> String {
    format!("({:.4}, {:.4}, {:.4})", v.x, v.y, v.z)
}

fn write_materials(world: &World, text: &mut String) -> fmt::Result {
    type Light<'a> = (Option<&'a Emission>, Option<&'a EmittedStokes>, Option<&'a Incandescent>);
    type Components<'a> = (Entity, &'a Name, &'a Bsdf, &'a Sides, Light<'a>);
    let mut users: BTreeMap<Entity, usize> = BTreeMap::new();
    for of in world.in_order::<&MadeOf, _>(|of| of.0) {
        *users.entry(of).or_default() += 1;
    }
    let materials = world.in_order::<Components, _>(|(entity, name, bsdf, sides, light)| {
        let (emission, stokes, incandescent) = light;
        let by_heat = incandescent.map_or("", |_| ", by its heat");
        let sides = if sides.two_sided { ", two-sided" } else { "" };
        let light = emission.map_or_else(String::new, |emission| {
            format!(", emits radiance {}{by_heat}{}", spectrum(&emission.radiance), state(stokes))
        });
        let count = users.get(&entity).copied().unwrap_or(0);
        let shapes = counted(count, ["shape", "shapes"]);
        format!("  {}: {}{sides}{light}; on {shapes}", name.0, model(bsdf))
    });
    lines(text, &materials)
}

/// What of layers there is.
fn layered(layers: &Layers<Spectrum>) -> String {
    let Layers { base_color, metallic, alpha, ior, specular, specular_color, .. } = layers;
    let mut text = format!(
        "layers, color {}, metallic {metallic}, alpha {alpha}, facets of ior {ior}, share \
         {specular} and color {}",
        spectrum(base_color),
        spectrum(specular_color)
    );
    if layers.transmission > 0.0 {
        text += &format!(", wall of share {}", layers.transmission);
    }
    if layers.diffuse_transmission > 0.0 {
        let color = spectrum(&layers.diffuse_transmission_color);
        text += &format!(", lit through by share {} of {color}", layers.diffuse_transmission);
    }
    if layers.coat > 0.0 {
        text += &format!(", clear coat of share {}, alpha {}", layers.coat, layers.coat_alpha);
    }
    if layers.has_cloth() {
        let color = spectrum(&layers.cloth_color);
        text += &format!(", cloth of {color}, alpha {}", layers.cloth_alpha);
    }
    text
}

/// What errors call a model: its description up to what it is made of.
pub(super) fn kind(bsdf: &Bsdf) -> String {
    let mut text = model(bsdf);
    text.truncate(text.find([',', '(']).unwrap_or(text.len()));
    text.trim_end().to_owned()
}

fn model(bsdf: &Bsdf) -> String {
    match bsdf {
        Bsdf::Absorber => "absorber".to_owned(),
        Bsdf::Diffuse { reflectance } => format!("diffuse, reflectance {}", spectrum(reflectance)),
        Bsdf::Conductor { eta, k } => {
            format!("smooth conductor, eta {}, k {}", spectrum(eta), spectrum(k))
        }
        Bsdf::RoughConductor { eta, k, alpha, distribution, multiple_scattering } => {
            let (eta, k, facets) = (spectrum(eta), spectrum(k), distribution.name());
            let once = if *multiple_scattering { "" } else { ", single reflections alone" };
            format!("rough conductor, eta {eta}, k {k}, {facets} facets of alpha {alpha}{once}")
        }
        Bsdf::RoughDielectric { ior, exterior_ior, alpha, distribution, multiple_scattering } => {
            let (behind, before) = (spectrum(ior), spectrum(exterior_ior));
            let (facets, of) = (distribution.name(), format!("ior {behind} behind and {before}"));
            let once = if *multiple_scattering { "" } else { ", single scattering alone" };
            format!("rough dielectric, {of} before it, {facets} facets of alpha {alpha}{once}")
        }
        Bsdf::MetallicRoughness { base_color, metallic, alpha, ior, specular } => {
            let color = spectrum(base_color);
            let coat = format!("coat of ior {ior} and share {specular}");
            format!("metallic-roughness, color {color}, metallic {metallic}, alpha {alpha}, {coat}")
        }
        Bsdf::Layered { layers } => layered(layers),
        Bsdf::Plastic { reflectance, coat } => {
            format!("plastic, reflectance {}, {}", spectrum(reflectance), plastic_coat(coat))
        }
        Bsdf::Measured { table, places: _ } => {
            let ([first, last], count) = (table.ends_nm(), table.wavelengths());
            format!("measured, {}, {count} wavelengths from {first} to {last} nm", table.name())
        }
        Bsdf::Blend { parts, weight } => blend(parts, *weight),
        Bsdf::Brushed { of, grain } => brushed(of, grain),
        Bsdf::Filmed { of, film } => format!("{}, {}", model(of), thin_film(film)),
        Bsdf::ThinDielectric { ior, exterior_ior: Spectrum::Constant(1.0) } => {
            format!("thin dielectric, ior {}", spectrum(ior))
        }
        Bsdf::ThinDielectric { ior, exterior_ior } => {
            let (pane, around) = (spectrum(ior), spectrum(exterior_ior));
            format!("thin dielectric, ior {pane} between {around}")
        }
        Bsdf::Dielectric { ior, exterior_ior: 1.0 } => format!("smooth dielectric, ior {ior}"),
        Bsdf::Dielectric { ior, exterior_ior } => {
            format!("smooth dielectric, ior {ior} behind and {exterior_ior} before it")
        }
        Bsdf::DispersiveDielectric { ior, exterior_ior } => {
            let (behind, before) = (spectrum(ior), spectrum(exterior_ior));
            format!("smooth dispersive dielectric, ior {behind} behind and {before} before it")
        }
        Bsdf::FilmedConductor { eta, k, film } => {
            let (eta, k) = (spectrum(eta), spectrum(k));
            format!("smooth conductor, eta {eta}, k {k}, {}", thin_film(film))
        }
        Bsdf::FilmedDielectric { ior, exterior_ior, film } => {
            let film = thin_film(film);
            format!("smooth dielectric, ior {ior} behind and {exterior_ior} before it, {film}")
        }
        Bsdf::Null => "boundary between media".to_owned(),
        Bsdf::Polarizer { axis_deg, extinction_ratio } => {
            format!("linear polarizer at {axis_deg} degrees, extinction ratio {extinction_ratio}")
        }
        Bsdf::Retarder { axis_deg, retardance_deg } => {
            format!("linear retarder of {retardance_deg} degrees at {axis_deg} degrees")
        }
        Bsdf::Sheet { axis_deg, action } => format!("{} at {axis_deg} degrees", sheet(action)),
    }
}

fn blend(parts: &[Bsdf; 2], weight: f32) -> String {
    let [first, second] = parts.each_ref().map(model);
    format!("blend of ({first}) and, by weight {weight}, ({second})")
}

fn brushed(of: &Bsdf, grain: &Grain) -> String {
    let along = match grain.along {
        Along::Alpha(alpha) => format!("alpha {alpha}"),
        Along::Strength(strength) => format!("strength {strength}"),
    };
    format!("{}, {along} along a direction at {} degrees", model(of), grain.turn.to_degrees())
}

fn plastic_coat(coat: &Coat) -> String {
    let Coat { ior, exterior_ior, alpha, distribution, specular, internal_reflection } = coat;
    let outside = match exterior_ior {
        1.0 => String::new(),
        ior => format!(" in {ior}"),
    };
    let (facets, within) = (distribution.name(), internal_reflection.name());
    format!(
        "ior {ior}{outside}, {facets} facets of alpha {alpha} and share {specular}, internal \
         reflection {within}"
    )
}

fn thin_film(film: &ThinFilm<Spectrum>) -> String {
    let (eta, k, thickness) = (spectrum(&film.eta), spectrum(&film.k), spectrum(&film.thickness));
    let share = match film.share {
        1.0 => String::new(),
        share => format!(", over a share of {share}"),
    };
    let most = if film.portion < 1.0 { " at most" } else { "" };
    format!("under a film of eta {eta}, k {k}, {thickness} nm thick{most}{share}")
}

fn sheet(action: &Action<Spectrum>) -> String {
    let grid = |Grid { transmittance, blocked }: &Grid<Spectrum>| {
        format!("transmittance {} along and {} across", spectrum(transmittance), spectrum(blocked))
    };
    let delay = |delay: &Delay<Spectrum>| match delay {
        Delay::Degrees(degrees) => format!("of {} degrees", spectrum(degrees)),
        Delay::Crystal { birefringence, thickness } => {
            format!("of birefringence {} over {} nm", spectrum(birefringence), spectrum(thickness))
        }
    };
    match action {
        Action::Polarizer(polarizer) => format!("linear polarizer, {}", grid(polarizer)),
        Action::Retarder(retarder) => format!("linear retarder {}", delay(retarder)),
        Action::Circular { polarizer, retarder, hand } => {
            let (hand, polarizer, retarder) = (hand.name(), grid(polarizer), delay(retarder));
            format!("{hand} circular polarizer, {polarizer}, retarder {retarder}")
        }
        Action::Matrix(elements) => format!("Mueller matrix, M00 {}", spectrum(&elements[0])),
    }
}

fn write_media(world: &World, text: &mut String) -> fmt::Result {
    type Components<'a> = (Entity, &'a Name, &'a Medium, Option<&'a FillsScene>);
    let mut users: BTreeMap<Entity, usize> = BTreeMap::new();
    for boundary in world.in_order::<&Boundary, _>(|boundary| *boundary) {
        for filling in [boundary.interior, boundary.exterior].into_iter().flatten() {
            if let Filling::Medium(entity) = filling {
                *users.entry(entity).or_default() += 1;
            }
        }
    }
    let media = world.in_order::<Components, _>(|(entity, name, medium, fills)| {
        let coefficient = |given: &Option<Spectrum>| {
            given.as_ref().map_or("from its particles".to_owned(), spectrum)
        };
        let (sigma_a, sigma_s) = (coefficient(&medium.sigma_a), coefficient(&medium.sigma_s));
        let scene = if fills.is_some() { ", fills the scene" } else { "" };
        let count = users.get(&entity).copied().unwrap_or(0);
        let phase = phase(&medium.phase);
        let name = &name.0;
        let places = counted(count, ["boundary", "boundaries"]);
        format!("  {name}: sigma_a {sigma_a}, sigma_s {sigma_s}, {phase}{scene}; at {places}")
    });
    lines(text, &media)
}

fn phase(phase: &Phase) -> String {
    match phase {
        Phase::HenyeyGreenstein { g } => format!("Henyey-Greenstein, g {}", spectrum(g)),
        Phase::Rayleigh { depolarization } => format!("Rayleigh, depolarization {depolarization}"),
        Phase::Spheres(spheres) => {
            let component = |component: &Component| {
                let (mean, share) = (component.sizes.mean_radius_um(), component.volume_fraction);
                format!("{share} by volume of mean radius {mean:.4} um")
            };
            let parts: Vec<String> = spheres.components.iter().map(component).collect();
            format!("spheres, {}", parts.join(" and "))
        }
        Phase::Milk(Milk { fat_percent, protein_percent, dilution }) => {
            format!("milk of {fat_percent} % fat, {protein_percent} % protein, diluted {dilution}")
        }
        Phase::Table(matrices) => format!("phase matrix at {} wavelengths", matrices.len()),
    }
}

fn spectrum(spectrum: &Spectrum) -> String {
    match spectrum {
        Spectrum::Constant(value) => format!("{value}"),
        Spectrum::Rgb([red, green, blue]) => format!("[{red}, {green}, {blue}]"),
        Spectrum::Table(_) => format!("table of {} wavelengths", spectrum.knots_nm().len()),
        Spectrum::Formula(formula) => format!("{formula}"),
    }
}

/// How what is emitted is polarized.
fn state(stokes: Option<&EmittedStokes>) -> String {
    let Some(EmittedStokes { stokes }) = stokes else { return String::new() };
    format!(", polarized [{}]", stokes.each_ref().map(spectrum).join(", "))
}

fn write_lights(world: &World, text: &mut String) -> fmt::Result {
    type Pattern<'a> = (Option<&'a Luminaire>, Option<&'a Projection>);
    type Light<'a> = (&'a Name, &'a Punctual, Option<&'a EmittedStokes>, Pattern<'a>);
    let lights = world.in_order::<Light, _>(|(name, light, stokes, (luminaire, projection))| {
        let measured = luminaire.map_or_else(String::new, |it| {
            format!(", measured, {:.3} cd on the average", it.0.mean())
        });
        let thrown = projection.map_or_else(String::new, |Projection(picture)| {
            let [width, height] = picture.texels().size();
            format!(", throws a picture of {width} x {height}")
        });
        let (intensity, state) = (spectrum(&light.intensity), state(stokes));
        format!("  {}: {:?}, intensity {intensity}{measured}{thrown}{state}", name.0, light.kind)
    });
    type Sky<'a> = (&'a Name, &'a Environment, Option<&'a EmittedStokes>);
    let skies = world.in_order::<Sky, _>(|(name, sky, stokes)| {
        let gradient = match sky.gradient.to_array() {
            [0.0, 0.0, 0.0] => String::new(),
            gradient => format!(", gradient {gradient:?}"),
        };
        let picture = sky.backdrop.as_ref().map_or_else(String::new, |backdrop| {
            let [width, height] = backdrop.picture.texels().size();
            let [red, green, blue] = sky.panorama().map_or([0.0; 3], |panorama| panorama.mean());
            format!(" times a picture of {width} x {height}, mean [{red}, {green}, {blue}]")
        });
        let (radiance, state) = (spectrum(&sky.radiance), state(stokes));
        format!("  {}: radiance {radiance}{gradient}{picture}{state}", name.0)
    });
    lines(text, &[lights, skies].concat())
}

fn write_camera(world: &World, text: &mut String) -> fmt::Result {
    type Film<'a> = (Option<&'a Resolution>, Option<&'a Raster>, Option<&'a Analyzer>);
    type Components<'a> = (&'a Name, &'a Transform, &'a Lens, Film<'a>);
    let cameras = world.in_order::<Components, _>(|(name, place, lens, film)| {
        let (resolution, raster, analyzer) = film;
        let lens = match lens {
            Lens::Perspective { yfov, aperture_radius, .. } => {
                let degrees = yfov.to_degrees();
                format!("perspective, {degrees:.2} degrees high, lens radius {aperture_radius}")
            }
            Lens::Orthographic { half_width, half_height } => {
                format!("orthographic, {} wide and {} high", 2.0 * half_width, 2.0 * half_height)
            }
        };
        let pixels = resolution.map_or_else(String::new, |Resolution([width, height])| {
            format!(", {width} x {height} pixels")
        });
        let behind = analyzer.map_or_else(String::new, |it| format!(", behind an analyzer: {it}"));
        let seen = raster.map_or_else(String::new, raster_in_words);
        format!("  {}: {lens}{pixels}{seen}{behind}, at {}", name.0, vector(place.0.translation))
    });
    lines(text, &cameras)
}

/// How the pixels of a film see, where they are unlike others.
fn raster_in_words(Raster { filter, crop, pixel_aspect }: &Raster) -> String {
    let mut text = String::new();
    if *filter != Filter::PIXEL {
        text += &format!(", filter {filter}");
    }
    if let Some(ends) = crop {
        text += &format!(", of which {} are rendered", Crop::Pixels(*ends));
    }
    if *pixel_aspect != 1.0 {
        text += &format!(", {pixel_aspect} times as wide as high each");
    }
    text
}

fn lines(text: &mut String, lines: &[String]) -> fmt::Result {
    lines.iter().try_for_each(|line| writeln!(text, "{}", excerpt(line, LINE)))
}
