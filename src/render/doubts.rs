//! What a user should know of a finished image before trusting it.

use crate::image::rows::{Rows, is_black};
use crate::integrators::Integrator;
use crate::integrators::profile::{Cut, Profile};
use crate::spectrum::Color;
use crate::transport::Sampling;

use super::settings::PATH_LENGTH_MAX;
use super::{PlacedWorld, Renderer, Resolved, Settings};

/// The share of the paths' throughput that may be cut off without a word.
const CUT_MAX: f64 = 0.01;

/// Fewer photons than this an iteration are too few for any kernel.
const PHOTONS_MIN: f64 = 100.0;
/// The radius of the kernel, as a share of that of the scene, from which on it mixes up the light
/// of different places.
const SHARE_MAX: f32 = 0.2;

/// What a render says of itself before it becomes an image.
pub struct Doubts {
    settings: Resolved,
    profile: Profile,
    /// Few photons: mostly as it should be.
    note: Option<String>,
    /// So few that the image is blurred.
    warning: Option<String>,
    /// Channels that no wavelength has fallen into.
    unmeasured: Option<String>,
}

/// What a render of a world says of itself.
pub fn doubts(renderer: &Renderer, world: &PlacedWorld) -> Doubts {
    let (settings, profile, radii) =
        (renderer.settings().clone(), renderer.profile(), renderer.radii());
    let iterations = renderer.samples() / settings.samples_per_iteration();
    let photons = profile.photons as f64 / f64::from(iterations.max(1));
    // Where no photons are merged, paths find what they would have.
    let note = radii.iter().flatten().next().and_then(|_| lack_of_photons(photons));
    let kernel = radii.first().copied().flatten();
    let is_chosen = note.is_none() && settings.photons.radius.is_none();
    let share = kernel.filter(|_| is_chosen).map(|radius| radius / world.radius());
    let warning = share.and_then(blur_of_photons);
    let [unmeasured, if_dispersed] = renderer.unmeasured();
    let unmeasured = lack_of_wavelengths(&settings.color, &unmeasured)
        .or_else(|| lack_of_dispersed(&settings.color, &if_dispersed));
    Doubts { settings, profile, note, warning, unmeasured }
}

impl Doubts {
    /// What light may be missing, of which mostly there is none.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// What there is to doubt about the image of the render, a sentence each.
    pub fn about(self, image: &dyn Rows) -> Vec<String> {
        let Self { settings, profile, warning, unmeasured, .. } = self;
        let doubts = about(image, (&*settings, settings.integrator), &profile);
        let held = of_held(&settings.held);
        doubts.into_iter().chain(warning).chain(unmeasured).chain(held).collect()
    }
}

/// What is to be known of spectra that are held beyond their ends.
fn of_held(held: &[String]) -> Option<String> {
    let (first, others) = held.split_first()?;
    let others = match others.len() {
        0 => String::new(),
        count => format!(", and {count} more, which the image's metadata names"),
    };
    Some(format!("spectra are held at their ends: {first}{others}"))
}

/// What is to be known of an image for which so many photons an iteration were stored. Where no
/// light comes to anything by way of others, that is as it should be.
fn lack_of_photons(photons: f64) -> Option<String> {
    (photons < PHOTONS_MIN).then(|| {
        format!(
            "{photons:.0} photons an iteration were stored: light that comes to diffuse \
             surfaces or media by way of others, if there is any, is missing or in the wrong \
             places; more --photons find it"
        )
    })
}

/// What there is to doubt about an image whose kernel has a radius of so large a share of the
/// scene's.
fn blur_of_photons(share: f32) -> Option<String> {
    (share > SHARE_MAX).then(|| {
        format!(
            "photons are so few that their kernel has a radius of {:.0} % of the scene's: \
             the image is blurred by that, and dark near edges; give more --photons",
            100.0 * share
        )
    })
}

/// What there is to doubt about an image some of whose channels no iteration had a wavelength for.
fn lack_of_wavelengths(color: &Color, unmeasured: &[usize]) -> Option<String> {
    let which = which(color, unmeasured)?;
    Some(format!(
        "no iteration had a wavelength in {which}: that is black; more --spp, or broader bands, \
         find some, if light is emitted there"
    ))
}

/// The same of channels that no iteration had the wavelength for that light goes on at.
fn lack_of_dispersed(color: &Color, unmeasured: &[usize]) -> Option<String> {
    let which = which(color, unmeasured)?;
    Some(format!(
        "light that is refracted goes on at one wavelength an iteration, of which none was in \
         {which}: that lacks this light; more --spp, or broader bands, find some"
    ))
}

fn which(color: &Color, channels: &[usize]) -> Option<String> {
    let (&first, &last) = (channels.first()?, channels.last()?);
    let [first, last] = [first, last].map(|channel| color.channel_name(channel));
    Some(match channels.len() {
        1 => format!("channel {first}"),
        count => format!("{count} of {} channels, from {first} to {last}", color.channels()),
    })
}

/// What there is to doubt about an image, by what its render says.
fn about(
    image: &dyn Rows,
    (settings, integrator): (&Settings, Integrator),
    profile: &Profile,
) -> Vec<String> {
    let cut = profile.cut.iter().map(Cut::share).fold(0.0, f64::max);
    let mut doubts = Vec::new();
    if cut > CUT_MAX {
        doubts.push(format!(
            "paths were cut off after {} segments with {:.0} % of what they carried at \
             first: the image may be too dark; {}",
            settings.path_length_max,
            100.0 * cut,
            if settings.path_length_max < PATH_LENGTH_MAX {
                "give a greater --max-path-length, or none"
            } else {
                "light can hardly leave this scene: let its surfaces and media absorb some, or \
                 say where to end with --max-path-length"
            },
        ));
    }
    if profile.not_finite > 0 {
        doubts.push(format!(
            "{} samples are left out, which are too large or too small to be numbers: \
             the image lacks what they stand for{}",
            profile.not_finite,
            match settings.sampling {
                Sampling::Stokes => "",
                Sampling::Intensity => "; --sampling stokes has none in thick media",
            },
        ));
    }
    if is_black(image) {
        let name = integrator.name();
        doubts.push(format!(
            "the image is black: `{name}` has found no light. The camera may be inside \
             something, face away or see only what nothing lights{}",
            match integrator.shoots_photons() {
                true => "",
                false => {
                    "; small lamps behind glass or in mirrors are found by --integrator ppm"
                }
            }
        ));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::image::StokesImage;
    use crate::render::Options;
    use crate::spectrum::Bands;

    #[test]
    fn few_photons_are_told() {
        assert!(lack_of_photons(31.0).is_some_and(|it| it.contains("31 photons an")));
        assert_eq!(lack_of_photons(1000.0), None);
        assert!(blur_of_photons(0.35).is_some_and(|it| it.contains("35 % of the scene")));
        assert_eq!(blur_of_photons(0.1), None);
    }

    #[test]
    fn channels_without_wavelengths_are_told() {
        let bands = Color::Bands(Arc::new(Bands::evenly(400.0, 700.0, 31).unwrap()));
        assert_eq!(lack_of_wavelengths(&bands, &[]), None);
        let one = lack_of_wavelengths(&bands, &[15]).unwrap();
        assert!(one.contains("in channel 550 nm: that is black"), "{one}");
        let some = lack_of_wavelengths(&bands, &[1, 5, 30]).unwrap();
        assert!(some.contains("in 3 of 31 channels, from 410 nm to 700 nm: that"), "{some}");
        let some = lack_of_dispersed(&bands, &[1, 5, 30]).unwrap();
        assert!(some.contains("3 of 31 channels, from 410 nm to 700 nm: that lacks"), "{some}");
    }

    #[test]
    fn what_is_black_or_cut_is_told() {
        let settings = |path_length_max| {
            Settings::new(Options { path_length_max, ..Options::default() }).unwrap()
        };
        let endless = settings(PATH_LENGTH_MAX);
        let settings = settings(16);
        let mut image = StokesImage::new(2, 2, Color::Rgb, 4);
        let settings = (&settings, Integrator::Path);
        let endless = (&endless, Integrator::Path);
        let of_cut = |cut| Profile { cut: [Cut { started: 1.0, cut }; 2], ..Profile::default() };
        assert_eq!(about(&image, settings, &of_cut(0.0)).len(), 1);
        image.planes[0][3] = 0.5;
        assert!(about(&image, settings, &of_cut(0.001)).is_empty());
        let [cut] = &about(&image, settings, &of_cut(0.285))[..] else { panic!("one doubt") };
        assert!(cut.contains("16 segments with 28 %"), "{cut}");
        assert!(cut.contains("--max-path-length, or none"), "{cut}");
        let [cut] = &about(&image, endless, &of_cut(0.285))[..] else { panic!("one doubt") };
        assert!(cut.contains("light can hardly leave"), "{cut}");
        let not_finite = Profile { not_finite: 3, ..Profile::default() };
        let [lost] = &about(&image, settings, &not_finite)[..] else { panic!("one doubt") };
        assert!(lost.contains("3 samples are left out"), "{lost}");
    }
}
