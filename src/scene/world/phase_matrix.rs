//! Tabulated phase matrices.

use std::f64::consts::PI;

use crate::math::Fault;
use crate::math::elementary::sin;

/// Most rows of a table, all wavelengths together.
const ROWS_MAX: usize = 1 << 20;
/// How far the integral of M00 may be from one.
const INTEGRAL_TOLERANCE: f64 = 0.01;
/// How far an element may exceed M00, which rounding to a few digits can do.
const ELEMENT_TOLERANCE: f64 = 1e-3;
/// What a table is to be.
pub(crate) const COLUMNS: &str = "columns are theta_deg, M00, M01, M11, M22, M23, M33 and perhaps \
     lambda_nm; without M11 and M33 they are M00 and M22, as for spheres";

/// A phase matrix of one wavelength at some angles.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedMatrix {
    /// Wavelength in vacuum in nanometers; none if it holds for all.
    pub wavelength_nm: Option<f64>,
    /// Scattering angles in degrees, increasing from 0 to 180.
    pub theta_deg: Vec<f64>,
    /// M00, M01, M11, M22, M23, M33 in 1/sr at each angle: finite, M00 not negative and not less
    /// than any other, its integral over the sphere of directions about one.
    pub elements: Vec<[f64; 6]>,
}

impl TabulatedMatrix {
    /// Divides the elements by the integral of M00 over the sphere of directions, and returns
    /// that; refuses what is no phase matrix.
    pub(crate) fn normalize(&mut self) -> Result<f64, Fault> {
        self.check_elements()?;
        let integral = self.integral();
        if integral < f64::from(f32::MIN_POSITIVE) || !integral.is_finite() {
            return Err(Fault::new("", format!("M00 integrates to {integral}"), COLUMNS));
        }
        self.elements.as_flattened_mut().iter_mut().for_each(|m| *m /= integral);
        Ok(integral)
    }

    /// Whether an integral of M00 is one, up to rounding of the table.
    pub(crate) fn is_unit(integral: f64) -> bool {
        (integral - 1.0).abs() <= INTEGRAL_TOLERANCE
    }

    /// Refuses what is no phase matrix, or not normalized.
    fn check(&self) -> Result<(), Fault> {
        self.check_elements()?;
        let integral = self.integral();
        if Self::is_unit(integral) {
            return Ok(());
        }
        let problem = format!("M00 integrates to {integral}, not to 1");
        Err(Fault::new("", problem, "divide all elements by the integral"))
    }

    fn check_elements(&self) -> Result<(), Fault> {
        let refuse = |problem: String| Err(Fault::new("", problem, COLUMNS));
        let theta = &self.theta_deg;
        if theta.len() != self.elements.len() {
            return refuse("has columns of different lengths".to_owned());
        }
        let finite = theta.iter().chain(self.elements.as_flattened()).all(|x| x.is_finite());
        if !finite {
            return refuse("has values that are not finite".to_owned());
        }
        let covers = |at: Option<&f64>, end: f64| at.is_some_and(|at| (at - end).abs() < 1e-6);
        if !theta.is_sorted_by(|a, b| a < b) || theta.len() < 2 {
            return refuse("needs increasing angles, each once".to_owned());
        }
        if !covers(theta.first(), 0.0) || !covers(theta.last(), 180.0) {
            let (first, last) = (theta[0], theta[theta.len() - 1]);
            return refuse(format!("covers {first} to {last} degrees, not 0 to 180"));
        }
        for (at, [m00, others @ ..]) in theta.iter().zip(&self.elements) {
            if *m00 < 0.0 {
                return refuse(format!("M00 is negative at {at} degrees"));
            }
            if others.iter().any(|m| m.abs() > m00 * (1.0 + ELEMENT_TOLERANCE)) {
                return refuse(format!("an element exceeds M00 at {at} degrees"));
            }
        }
        Ok(())
    }

    /// The integral of M00 over the sphere of directions.
    fn integral(&self) -> f64 {
        let half_sine2 = |at: f64| sin(0.5 * at.to_radians()).powi(2);
        let rings = self.theta_deg.windows(2).zip(self.elements.windows(2));
        rings
            .map(|(at, m)| 2.0 * PI * (half_sine2(at[1]) - half_sine2(at[0])) * (m[0][0] + m[1][0]))
            .sum()
    }
}

/// Refuses wavelengths that are not in order, or more rows than there may be.
pub(crate) fn check_wavelengths(matrices: &[TabulatedMatrix]) -> Result<(), Fault> {
    let refuse = |problem: String| Err(Fault::new("table", problem, COLUMNS));
    let rows: usize = matrices.iter().map(|matrix| matrix.theta_deg.len()).sum();
    if rows > ROWS_MAX {
        return refuse(format!("has {rows} rows, more than {ROWS_MAX}"));
    }
    let nm = |matrix: &TabulatedMatrix| matrix.wavelength_nm.unwrap_or(1.0);
    let increasing = matrices.is_sorted_by(|a, b| nm(a) < nm(b));
    let positive = matrices.iter().all(|matrix| nm(matrix).is_normal() && nm(matrix) > 0.0);
    let alone = matrices.len() == 1;
    let stated = alone || matrices.iter().all(|matrix| matrix.wavelength_nm.is_some());
    if matrices.is_empty() || !increasing || !positive || !stated {
        return refuse("needs rows, sorted by increasing wavelength in nanometers".to_owned());
    }
    Ok(())
}

/// Refuses what is no table of phase matrices.
pub(super) fn check_matrices(matrices: &[TabulatedMatrix]) -> Result<(), Fault> {
    check_wavelengths(matrices)?;
    for (index, matrix) in matrices.iter().enumerate() {
        matrix.check().map_err(|fault| fault.within(&format!("table[{index}]")))?;
    }
    Ok(())
}
