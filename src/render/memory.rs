//! Whether a render fits into memory, asked before the system ends it for that.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::image::cut::Cut;
use crate::math::text::counted;
use crate::scene::World;
use crate::scene::baked::Shapes;
use crate::scene::world::Mesh;

use super::spectral::{Columns, columns};
use super::{Options, Part, system};

/// Something that the memory does not hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{what} needs {} of memory and {} are available: give {remedy}",
    in_words(*needed), in_words(*available)
)]
pub struct MemoryError {
    /// What it is.
    pub what: String,
    /// Bytes that it needs.
    pub needed: u64,
    /// Bytes that there are.
    pub available: u64,
    /// What would need less.
    pub remedy: &'static str,
}

/// Bytes of a triangle in the tables of shapes and in their tree, with what is taken while these
/// are made (measured: 330 to 370).
const BYTES_OF_TRIANGLE: u64 = 340;
/// The part of the tree in that.
const BYTES_OF_TRIANGLE_IN_TREE: u64 = 250;

/// Most blocks of one sequence.
const BLOCKS_MAX: u32 = 32;

/// Refuses a film, and photons, that the memory does not hold; none where the system does not tell.
pub fn check_memory(options: &Options, film: [u32; 2]) -> Result<(), MemoryError> {
    check_memory_of_cut(options, Cut::whole(film))
}

/// The same of a part of a film.
pub fn check_memory_of_cut(options: &Options, cut: Cut) -> Result<(), MemoryError> {
    let Cut { film, size, .. } = cut;
    let light_paths = if options.shoots_photons() { options.photons.light_paths(film) } else { 0 };
    let of_film = bytes_of_film(options, size);
    let of_photons = bytes_of_photons(options, light_paths);
    let [width, height] = size;
    let mut what = format!("a film of {width} x {height} pixels");
    if of_photons > 0 {
        let photons = light_paths as usize;
        what += &format!(" with {} an iteration", counted(photons, ["light path", "light paths"]));
    }
    let remedy = match of_photons > of_film {
        true => "fewer photons",
        false => "a smaller width and height",
    };
    check(what, of_film + of_photons, remedy)
}

/// Refuses a world of which the shapes and their tree do not fit. Meshes are counted once: which
/// will be copied is not known yet.
pub fn check_world(world: &World) -> Result<(), MemoryError> {
    check_triangles(triangles_of(world), BYTES_OF_TRIANGLE)
}

/// The triangles of all meshes, each counted once.
pub fn triangles_of(world: &World) -> usize {
    let mut meshes = BTreeMap::new();
    for mesh in world.entities().query::<&Mesh>().iter() {
        meshes.insert(Arc::as_ptr(&mesh.0).addr(), mesh.0.triangles.len());
    }
    meshes.values().sum()
}

/// Refuses shapes of which the tree does not fit.
pub fn check_tree(shapes: &Shapes) -> Result<(), MemoryError> {
    let of_objects = shapes.instanced.objects().iter().map(|object| object.triangles.len());
    let triangles = shapes.triangles.len() + of_objects.sum::<usize>();
    check_triangles(triangles, BYTES_OF_TRIANGLE_IN_TREE)
}

fn check_triangles(triangles: usize, bytes: u64) -> Result<(), MemoryError> {
    let what = format!("a tree of {}", counted(triangles, ["triangle", "triangles"]));
    check(what, triangles as u64 * bytes, "smaller or fewer meshes")
}

fn check(what: String, needed: u64, remedy: &'static str) -> Result<(), MemoryError> {
    match system::available_memory() {
        Some(available) if needed > available => {
            Err(MemoryError { what, needed, available, remedy })
        }
        _ => Ok(()),
    }
}

/// Counts what every render needs: the sums of the film, two doubles each, what variances need
/// beside them, and the image that is kept for a signal while a wave takes long. An image is
/// written from the film itself, a few rows at a time, when nothing is kept any more. The tables of
/// paths come on top; they are small.
fn bytes_of_film(options: &Options, [width, height]: [u32; 2]) -> u64 {
    const OF_SUM: u64 = 2 * 8;
    const OF_IMAGE: u64 = 4;
    let of_variance = match (options.has_variance(), options.replicates) {
        (false, _) => 0,
        // Blocks are kept as they are, for whoever merges the parts.
        (true, blocks) if options.part.is_some_and(|part| part.number() > 1) => {
            let blocks = blocks.max(BLOCKS_MAX);
            8 * u64::from(blocks.div_ceil(options.part.map_or(1, Part::of)))
        }
        // Means and deviations.
        (true, 2..) => 2 * 8,
        // And two halves of the one replicate.
        (true, _) => 2 * 8 + 2 * 4,
    };
    let values = (options.mode.components() * options.color.channels()) as u64;
    u64::from(width) * u64::from(height) * values * (OF_SUM + of_variance + OF_IMAGE)
}

/// Counts the photons of an iteration, three for two light paths, which closed rooms hardly exceed:
/// in their table, with a column of it that is being sorted, and their order. (Measured: 82 bytes a
/// light path in RGB, in a closed room.)
fn bytes_of_photons(options: &Options, light_paths: u32) -> u64 {
    const BYTES_OF_COLUMN: u64 = 4;
    const BYTES_OF_ORDER: u64 = 24;
    let columns = columns(options).map_or(0, Columns::count);
    let bytes_of_photon = 16 + 4 * columns as u64;
    let bytes = bytes_of_photon + BYTES_OF_COLUMN + BYTES_OF_ORDER;
    u64::from(light_paths) * bytes * 3 / 2
}

fn in_words(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    match mebibytes < 1024.0 {
        true => format!("{mebibytes:.0} MiB"),
        false => format!("{:.1} GiB", mebibytes / 1024.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_counted_with_its_variances_and_the_image_that_is_kept() {
        let options = Options::default();
        assert_eq!(bytes_of_film(&options, [100, 10]), 1000 * 12 * 20);
        assert_eq!(
            bytes_of_film(&Options { replicates: 2, ..options.clone() }, [100, 10]),
            1000 * 12 * 36
        );
        assert_eq!(
            bytes_of_film(&Options { variance: true, ..options.clone() }, [100, 10]),
            1000 * 12 * 44
        );
        assert!(check_memory(&options, [1, 1]).is_ok());
    }

    #[test]
    fn photons_are_counted_where_they_are_shot() {
        let options = Options::default();
        assert_eq!(bytes_of_photons(&options, 0), 0);
        assert_eq!(bytes_of_photons(&options, 1_000_000), 1_000_000 * 84);
        let error = check("a film".to_owned(), u64::MAX, "a smaller one");
        if let Err(error) = error {
            assert!(error.to_string().starts_with("a film needs 17179869184.0 GiB"), "{error}");
            assert_eq!(in_words(600_000_000), "572 MiB");
        }
    }
}
