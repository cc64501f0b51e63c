//! The tables of all models, as materials fill them.

use super::model::Surface;
use super::{Material, SurfaceKind, Surfaces};
use crate::scene::baked;
use crate::scene::painting::Painting;
use crate::scene::world::SurfaceModel;

impl<const N: usize> Surfaces<N> {
    /// The tables of baked materials, as `painting` has them.
    pub fn new(baked: &[baked::Material<N>], painting: Option<&Painting<N>>) -> Self {
        let mut surfaces = Self::default();
        for (index, &baked::Material { ref model, two_sided }) in baked.iter().enumerate() {
            let textures = painting.and_then(|painting| painting.of(index));
            let Added { row, scattered, peak } = surfaces.add(model);
            let stain = textures.map(|textures| &textures.stain).filter(|stain| stain.is_some());
            if let Some((painting, stain)) = painting.zip(stain) {
                surfaces.stain(model, row, painting.mean_stain(stain));
            }
            let kind = SurfaceKind::of(model);
            surfaces.materials.push(Material {
                kind,
                row,
                two_sided,
                survival: scattered.clamp(SURVIVAL_MIN, 1.0),
                peak,
                has_holes: textures.is_some_and(|textures| textures.coverage.is_some()),
                // Of textures, the model has the means: it is open where any place is.
                passes_any_way: kind.passes_any_way() && model.transmits(),
            });
        }
        surfaces
    }

    /// Adds the interface between two indices of refraction; its row in the table of dielectrics,
    /// which are all with dispersion, or all without.
    pub fn add_interface(&mut self, ior: [f32; N], exterior_ior: [f32; N]) -> u32 {
        let model = match self.disperses() {
            true => SurfaceModel::DispersiveDielectric { ior, exterior_ior },
            false => SurfaceModel::Dielectric { ior: ior[0], exterior_ior: exterior_ior[0] },
        };
        self.add(&model).row
    }

    /// The index of refraction behind an interface relative to before it, by its row.
    pub fn ior_of_interface(&self, row: usize) -> [f32; N] {
        match self.disperses() {
            true => self.dispersive_dielectric[row].relative_ior(),
            false => [self.dielectric[row].relative_ior(); N],
        }
    }

    /// Whether light may go on at one wavelength alone.
    pub fn disperses(&self) -> bool {
        !self.dispersive_dielectric.is_empty()
    }

    /// The row that a model becomes in its table.
    pub fn append(&mut self, model: &SurfaceModel<[f32; N]>) -> u32 {
        self.add(model).row
    }

    /// Gives a row of a model, of those that keep it, what is left of light that is reflected and
    /// of what goes through.
    pub fn stain(&mut self, model: &SurfaceModel<[f32; N]>, row: u32, stain: [[f32; N]; 2]) {
        let kind = SurfaceKind::of(model);
        if kind == SurfaceKind::RoughDielectric {
            self.rough_dielectric[row as usize].stain(stain);
        } else if kind == SurfaceKind::RoughConductor {
            self.rough_conductor[row as usize].stain(stain[0]);
        } else if let SurfaceModel::Brushed { of, .. } = model {
            let row = self.brushed[row as usize].row();
            self.stain(of, row, stain);
        }
    }

    /// The materials, in the order of the baked ones.
    #[inline(always)]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }
}

/// The least probability of going on, so that no path gains too much where it is let.
pub const SURVIVAL_MIN: f32 = 0.05;

/// What a material has become.
pub struct Added {
    /// The row in the table of its model.
    pub row: u32,
    /// See [`Surface::scattered`].
    pub scattered: f32,
    /// See [`Surface::peak`].
    pub peak: f32,
}

/// Appends to a table.
pub fn append<M: Surface>(table: &mut Vec<M>, model: M) -> Added {
    let (scattered, peak) = (model.scattered(), model.peak());
    table.push(model);
    Added { row: table.len() as u32 - 1, scattered, peak }
}
