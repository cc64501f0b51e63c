//! All photons of an iteration: one map for surfaces, one for every medium.

use std::f32::consts::PI;

use crate::scattering::Met;

use super::photon_grid::PhotonGrid;
use super::photons::PhotonClass;

/// The maps of all places: that of surfaces first, then those of the media in their order.
pub struct PhotonMaps<const N: usize>(pub Vec<PhotonMap<N>>);

impl<const N: usize> PhotonMaps<N> {
    /// Empty maps for photons of the classes `classes`, by map.
    pub fn new(classes: &[PhotonClass]) -> Self {
        let dimensions = std::iter::once(2).chain(std::iter::repeat(3));
        Self(classes.iter().zip(dimensions).map(|(&c, d)| PhotonMap::new(c, d)).collect())
    }

    /// Whether vertices that have met this find light by photons. Where they do not, paths go on.
    pub fn merge_at(&self, met: Met) -> bool {
        self.of(met).merges
    }

    /// The map of what a vertex has met.
    pub fn of(&self, met: Met) -> &PhotonMap<N> {
        &self.0[map_of(met)]
    }
}

/// The place of the map of surfaces among the maps.
pub const SURFACES: usize = 0;

/// The place among the maps of what a vertex has met.
pub fn map_of(met: Met) -> usize {
    match met {
        Met::Surface(_) => SURFACES,
        Met::Medium(row) => 1 + row as usize,
    }
}

/// Photons of one kind of place, and how they are gathered.
pub struct PhotonMap<const N: usize> {
    /// The photons, sorted into cells.
    pub grid: PhotonGrid<N>,
    /// Radius of the kernel in this iteration, in scene units.
    pub radius: f32,
    /// Light paths of this iteration.
    pub light_paths: f32,
    /// Whether photons are stored and merged.
    pub merges: bool,
    /// 2 on surfaces, 3 in media.
    pub dimensions: u32,
}

impl<const N: usize> PhotonMap<N> {
    /// An empty map.
    pub fn new(class: PhotonClass, dimensions: u32) -> Self {
        Self {
            grid: PhotonGrid::new(class),
            radius: 1.0,
            light_paths: 1.0,
            merges: true,
            dimensions,
        }
    }

    /// The constant kernel: one over the area of the disk, or the volume of the ball, and over the
    /// number of light paths.
    pub fn per_volume(&self) -> f32 {
        let square = self.radius * self.radius;
        let size = match self.dimensions {
            2 => PI * square,
            _ => 4.0 / 3.0 * PI * square * self.radius,
        };
        1.0 / (size * self.light_paths)
    }
}
