//! Measured polarimetric reflectance, as that of Baek et al. 2020 ("Image-based acquisition and
//! modeling of polarimetric reflectance"): a Mueller matrix per steradian for every direction of
//! light and of view of an isotropic surface, at any number of wavelengths.
//!
//! A file of tensors has the matrices `M`, of the dimensions (phi_d, theta_d, theta_h, wavelength,
//! row, column), and the numbers along the first four: `phi_d`, `theta_d`, `theta_h` in radians,
//! `wvls` in nanometers. The angles are Rusinkiewicz': of the normal to the half vector of the two
//! directions, theta_h; of that to either, theta_d; and phi_d, the turn of the direction to the
//! light about the half vector, from the one that leads away from the normal. The frames of a
//! matrix have x across the plane of the two directions.
//!
//! The table stays as wide as it is in the file, and is there once. It is linear between its
//! angles, and holds beyond their ends; matrices whose M00 is no number were not measured, and
//! those about them count in their place.

use std::f32::consts::TAU;
use std::fmt;
use std::sync::Arc;

use crate::files::tensors::{Field, Tensors};
use crate::math::Fault;
use crate::spectrum::{Spectrum, SpectrumTable};

/// How far a full turn of `phi_d` may be from one, in radians.
const CLOSED: f32 = 1e-3;
/// Least roughness that directions are drawn by.
const ALPHA_MIN: f32 = 0.01;
/// Share of directions that are drawn by the cosine at least, and by facets.
const SHARE_MIN: f32 = 0.1;

/// A table, which clones share. Two are equal if they are one.
#[derive(Clone)]
pub struct MeasuredTable(Arc<Table>);

impl PartialEq for MeasuredTable {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Its name, and the checksum of the file.
impl fmt::Debug for MeasuredTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Table { name, checksum, .. } = &*self.0;
        f.debug_struct("MeasuredTable").field("name", name).field("checksum", checksum).finish()
    }
}

struct Table {
    name: String,
    /// BLAKE3 of the file.
    checksum: String,
    tensors: Tensors,
    matrices: Field,
    phi_d: Vec<f32>,
    theta_d: Vec<f32>,
    theta_h: Vec<f32>,
    wavelengths_nm: Vec<f32>,
    lobe: Lobe,
}

/// By what directions are drawn at a measured surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Roughness of facets (GGX) with a peak as wide.
    pub alpha: f32,
    /// Share of what is reflected that is in the peak, from 0.1 to 0.9.
    pub share: f32,
    /// About what is reflected in all, within [0, 1].
    pub albedo: f32,
}

impl MeasuredTable {
    /// The table in the bytes of the file of a name.
    ///
    /// # Errors
    /// What is wrong with the file, or with which of its fields.
    pub fn new(name: &str, bytes: Vec<u8>) -> Result<Self, Fault> {
        let remedy =
            "give it a file of measured reflectance, as Mitsuba's measured_polarized reads";
        let tensors = Tensors::new(bytes).map_err(|problem| Fault::new("", problem, remedy))?;
        let [phi_d, theta_d, theta_h, wavelengths_nm] =
            ["phi_d", "theta_d", "theta_h", "wvls"].map(|name| axis(&tensors, name));
        let (phi_d, wavelengths_nm) = (phi_d?, wavelengths_nm?);
        let (theta_d, theta_h) = (theta_d?, theta_h?);
        let turn = phi_d[phi_d.len() - 1] - phi_d[0];
        if (turn - TAU).abs() > CLOSED {
            let problem = format!("goes {turn} about the half vector, and not once round");
            return Err(Fault::new("phi_d", problem, "let it lead from -pi to pi"));
        }
        let matrices = field(&tensors, "M")?.clone();
        let counts = [&phi_d, &theta_d, &theta_h, &wavelengths_nm].map(Vec::len);
        let expected = [&counts[..], &[4, 4]].concat();
        if matrices.shape != expected {
            let problem = format!("has the dimensions {:?}, and not {expected:?}", matrices.shape);
            return Err(Fault::new("M", problem, "order them as phi_d, theta_d, theta_h, wvls"));
        }
        let lobe = Lobe { alpha: 1.0, share: SHARE_MIN, albedo: 1.0 };
        let (name, checksum) = (name.to_owned(), blake3::hash(tensors.bytes()).to_string());
        let mut table = Table {
            name,
            checksum,
            tensors,
            matrices,
            phi_d,
            theta_d,
            theta_h,
            wavelengths_nm,
            lobe,
        };
        table.lobe = table.fitted()?;
        Ok(Self(Arc::new(table)))
    }

    /// Where a wavelength is among those of the table, in steps; not known outside of them.
    pub fn places(&self) -> Spectrum {
        let wavelengths_nm = self.0.wavelengths_nm.clone();
        let steps = (0..wavelengths_nm.len()).map(|step| step as f32).collect();
        match SpectrumTable::new(wavelengths_nm, steps) {
            Ok(table) => Spectrum::Table(table),
            Err(problem) => unreachable!("wavelengths are checked: {problem}"),
        }
    }

    /// What its file is called.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// All of its file.
    pub(in crate::scene) fn bytes(&self) -> &[u8] {
        self.0.tensors.bytes()
    }

    /// The first and the last wavelength.
    pub fn ends_nm(&self) -> [f32; 2] {
        let nm = &self.0.wavelengths_nm;
        [nm[0], nm[nm.len() - 1]]
    }

    /// How many wavelengths there are.
    pub fn wavelengths(&self) -> usize {
        self.0.wavelengths_nm.len()
    }

    /// By what directions are drawn.
    pub fn lobe(&self) -> Lobe {
        self.0.lobe
    }

    /// The first `K` elements, row by row, of the Mueller matrices per steradian at some places
    /// among the wavelengths, by phi_d, theta_d and theta_h; zero where nothing was measured.
    pub fn at<const K: usize, const N: usize>(
        &self,
        angles: [f32; 3],
        places: &[f32; N],
    ) -> [[f32; K]; N] {
        let table = &*self.0;
        let [phi_d, theta_d, theta_h] = angles;
        let first = table.phi_d[0];
        let round = first + (phi_d - first).rem_euclid(TAU);
        let sides = [
            sides(&table.phi_d, round),
            sides(&table.theta_d, theta_d),
            sides(&table.theta_h, theta_h),
        ];
        let last = table.wavelengths_nm.len() - 1;
        places.map(|place| {
            let step = (place.max(0.0) as usize).min(last.saturating_sub(1));
            let share = place - step as f32;
            let of = [(step, 1.0 - share), ((step + 1).min(last), share)];
            table.mean(&sides, &of)
        })
    }
}

impl Table {
    /// The mean over the corners of a cell, of those that were measured.
    fn mean<const K: usize>(
        &self,
        sides: &[[(usize, f32); 2]; 3],
        waves: &[(usize, f32); 2],
    ) -> [f32; K] {
        let (mut sums, mut weights) = ([0.0; K], 0.0);
        for corner in 0..16 {
            let of = |axis: usize| sides[axis][corner >> axis & 1];
            let ((phi, a), (d, b), (h, c)) = (of(0), of(1), of(2));
            let (wave, w) = waves[corner >> 3];
            let weight = a * b * c * w;
            if weight <= 0.0 {
                continue;
            }
            let first = self.first_of([phi, d, h, wave]);
            if self.element(first).is_finite() {
                weights += weight;
                for (at, sum) in sums.iter_mut().enumerate() {
                    let element = self.element(first + at);
                    *sum += if element.is_finite() { weight * element } else { 0.0 };
                }
            }
        }
        if weights > 0.0 { sums.map(|sum| sum / weights) } else { sums }
    }

    /// The place of M00 of a matrix.
    fn first_of(&self, [phi_d, theta_d, theta_h, wave]: [usize; 4]) -> usize {
        let row = (phi_d * self.theta_d.len() + theta_d) * self.theta_h.len() + theta_h;
        16 * (row * self.wavelengths_nm.len() + wave)
    }

    fn element(&self, place: usize) -> f32 {
        self.tensors.number(&self.matrices, place) as f32
    }

    /// Facets whose peak falls to a fourth where the measured one does: there GGX has the slope
    /// alpha. What is reflected most evenly counts as a base.
    fn fitted(&self) -> Result<Lobe, Fault> {
        let means: Vec<f32> =
            (0..self.theta_h.len()).map(|theta_h| self.mean_m00(theta_h)).collect();
        let known = || means.iter().copied().filter(|mean| mean.is_finite());
        let (peak, least) = (known().fold(0.0, f32::max), known().fold(f32::INFINITY, f32::min));
        if peak <= 0.0 {
            return Err(Fault::new("M", "reflects nothing", "check the order of its dimensions"));
        }
        let (base, height) = (least.max(0.0), peak - least.max(0.0));
        let falls = |mean: &f32| *mean - base < 0.25 * height;
        let from = means.iter().position(|mean| *mean == peak).unwrap_or(0);
        let until = means[from..].iter().position(falls).map_or(means.len() - 1, |at| from + at);
        let alpha = crate::math::elementary::tan(self.theta_h[until].min(0.78));
        let alpha = alpha.clamp(ALPHA_MIN, 1.0);
        // D = 1 / (pi alpha^2) at the peak, of which 4 cos cos is the reflectance.
        let (of_peak, of_base) =
            (4.0 * std::f32::consts::PI * alpha * alpha * height, std::f32::consts::PI * base);
        let share = (of_peak / (of_peak + of_base)).clamp(SHARE_MIN, 1.0 - SHARE_MIN);
        Ok(Lobe { alpha, share, albedo: (of_peak + of_base).min(1.0) })
    }

    /// The mean of M00 over turns and wavelengths at an angle of the half vector, where the light
    /// is nearest to that.
    fn mean_m00(&self, theta_h: usize) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for phi_d in 0..self.phi_d.len() {
            for wave in 0..self.wavelengths_nm.len() {
                let m00 = self.element(self.first_of([phi_d, 0, theta_h, wave]));
                if m00.is_finite() {
                    (sum, count) = (sum + m00, count + 1.0);
                }
            }
        }
        sum / count
    }
}

/// The two numbers of an axis about a value, with their shares.
fn sides(axis: &[f32], value: f32) -> [(usize, f32); 2] {
    let last = axis.len() - 1;
    let above = axis.partition_point(|at| *at <= value).clamp(1.min(last), last);
    let below = above.saturating_sub(1);
    let step = axis[above] - axis[below];
    let share = if step > 0.0 { ((value - axis[below]) / step).clamp(0.0, 1.0) } else { 0.0 };
    [(below, 1.0 - share), (above, share)]
}

fn field<'a>(tensors: &'a Tensors, name: &str) -> Result<&'a Field, Fault> {
    tensors.field(name).ok_or_else(|| {
        let names: Vec<&str> = tensors.names().collect();
        Fault::new(name, "is missing", format!("the file has {}", names.join(", ")))
    })
}

/// The numbers along a dimension: increasing. Files have them as one row, too.
fn axis(tensors: &Tensors, name: &str) -> Result<Vec<f32>, Fault> {
    let field = field(tensors, name)?;
    let is_row = field.shape.iter().filter(|extent| **extent != 1).count() <= 1;
    let values: Vec<f32> = (0..if is_row { field.count() } else { 0 })
        .map(|at| tensors.number(field, at) as f32)
        .collect();
    let is_sound = !values.is_empty() && values.iter().all(|value| value.is_finite());
    if !is_sound || !values.is_sorted_by(|a, b| a < b) || (name == "wvls" && values[0] <= 0.0) {
        let problem =
            format!("of the dimensions {:?} is no list of increasing numbers", field.shape);
        return Err(Fault::new(name, problem, "angles are in radians, wavelengths in nanometers"));
    }
    Ok(values)
}
