//! What the two kinds of subpath carry besides their scalar throughput.
//!
//! | side | type | verb | meaning |
//! |---|---|---|---|
//! | light | [`LightCarrier`] | `scatter` | `S <- M R S`: the kernel on the left |
//! | sensor | [`SensorMatrix`], [`SensorRow`] | `collect` | `T <- T R M`: the kernel on the right |
//! | both | | `measure` | `T R S` where the subpaths meet |
//!
//! The sides are different types because exchanging them is silent otherwise:
//!
//! ```compile_fail,E0599
//! use sunstone::internals::polarization::{Event, SensorRow};
//! fn wrong(sensor: SensorRow<f32>, event: &Event<f32>) -> SensorRow<f32> {
//!     sensor.scatter(event)
//! }
//! ```
//!
//! ```compile_fail,E0599
//! use sunstone::internals::polarization::{Event, LightCarrier};
//! fn wrong(light: LightCarrier<f32>, event: &Event<f32>) -> LightCarrier<f32> {
//!     light.collect(event)
//! }
//! ```
//!
//! ```
//! use sunstone::internals::polarization::{Event, LightCarrier, SensorRow};
//! fn right(light: LightCarrier<f32>, sensor: SensorRow<f32>, event: &Event<f32>) -> f32 {
//!     sensor.measure(&light.scatter(event), event.k_out)
//! }
//! ```

use super::frame::Rotation;
use super::kernel::{Block, Kernel, dot};
use super::stokes::Stokes;
use crate::math::{Real, Vector};

/// A vertex of a path: a kernel and its two frames. Directions are unit vectors along the light's
/// travel, whichever side samples them; axes are unit vectors perpendicular to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event<F, K = Block<F>> {
    /// The kernel relative to its `M00`.
    pub block: K,
    /// Direction of the light before the event.
    pub k_in: Vector<F>,
    /// Reference axis of the kernel before the event.
    pub x_in: Vector<F>,
    /// Direction of the light after the event.
    pub k_out: Vector<F>,
    /// Reference axis of the kernel after the event.
    pub x_out: Vector<F>,
}

/// Light on its way from an emitter, relative to the scalar throughput of its subpath.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCarrier<F> {
    /// The state in the frame of `x`.
    pub stokes: Stokes<F>,
    /// The reference axis, perpendicular to the current direction.
    pub x: Vector<F>,
}

impl<F: Real> LightCarrier<F> {
    /// Unpolarized light; any `x` perpendicular to its direction will do.
    #[inline(always)]
    pub fn unpolarized(x: Vector<F>) -> Self {
        Self { stokes: Stokes::unpolarized(), x }
    }

    /// The light after the event.
    #[inline(always)]
    pub fn scatter<K: Kernel<F>>(self, event: &Event<F, K>) -> Self {
        let rotation = Rotation::between(self.x, event.x_in, event.k_in);
        Self { stokes: event.block.scatter(rotation.apply(self.stokes)), x: event.x_out }
    }

    /// What a depolarizer leaves: the factor by which polarization changed the intensity.
    #[inline(always)]
    pub fn depolarized(self) -> F {
        self.stokes.0[0]
    }
}

/// A sensor subpath of a Stokes film before its first depolarizer: the product of all its
/// kernels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorMatrix<F> {
    /// `[row][column]`; rows are Stokes components on the film, columns those of light given for
    /// the axis `x`.
    pub matrix: [[F; 4]; 4],
    /// The reference axis, perpendicular to the light's direction at the subpath's end.
    pub x: Vector<F>,
}

impl<F: Real> SensorMatrix<F> {
    /// A subpath without events, with the film's own axis (see [`film_axis`]).
    ///
    /// [`film_axis`]: super::film_axis
    #[inline(always)]
    pub fn identity(x: Vector<F>) -> Self {
        let one_at = |row: usize, column: usize| {
            if row == column { F::one() } else { F::zero() }
        };
        Self { matrix: std::array::from_fn(|i| std::array::from_fn(|j| one_at(i, j))), x }
    }

    /// The subpath, longer by the event at its end.
    #[inline(always)]
    pub fn collect<K: Kernel<F>>(self, event: &Event<F, K>) -> Self {
        let rotation = Rotation::between(event.x_out, self.x, event.k_out);
        let matrix = event.block.collect_columns(rotation.collect_matrix(self.matrix));
        Self { matrix, x: event.x_in }
    }

    /// The film's Stokes vector of light that travels along `k` into the subpath's end.
    #[inline(always)]
    pub fn measure(&self, light: &LightCarrier<F>, k: Vector<F>) -> Stokes<F> {
        let Stokes(stokes) = Rotation::between(light.x, self.x, k).apply(light.stokes);
        Stokes(self.matrix.map(|row| dot(row, stokes)))
    }

    /// What a depolarizer leaves, for `T d e0 e0^T = (T e0)(d e0^T)`: a column that never changes
    /// again. The rest of the subpath is a [`SensorRow`].
    #[inline(always)]
    pub fn depolarized(self) -> SensorColumn<F> {
        SensorColumn(Stokes(self.matrix.map(|row| row[0])))
    }
}

/// The part of a sensor subpath between the film and its first depolarizer: the Stokes vector on
/// the film per unit of light that the rest of the subpath measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorColumn<F>(pub Stokes<F>);

impl<F: Real> SensorColumn<F> {
    /// The film's Stokes vector, from what the [`SensorRow`] of the same subpath measured.
    #[inline(always)]
    pub fn spread(self, measured: F) -> Stokes<F> {
        self.0.scaled(measured)
    }
}

/// A sensor subpath that measures one number: of a film of intensities (perhaps behind an
/// analyzer), or after its first depolarizer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorRow<F> {
    /// The row, for light given for the axis `x`.
    pub row: [F; 4],
    /// The reference axis, perpendicular to the light's direction at the subpath's end.
    pub x: Vector<F>,
}

impl<F: Real> SensorRow<F> {
    /// Measures intensity alone; any `x` perpendicular to the light's direction will do.
    #[inline(always)]
    pub fn intensity(x: Vector<F>) -> Self {
        Self { row: Stokes::unpolarized().0, x }
    }

    /// The subpath, longer by the event at its end.
    #[inline(always)]
    pub fn collect<K: Kernel<F>>(self, event: &Event<F, K>) -> Self {
        let rotation = Rotation::between(event.x_out, self.x, event.k_out);
        Self { row: event.block.collect_row(rotation.collect_row(self.row)), x: event.x_in }
    }

    /// What the film measures of light that travels along `k` into the subpath's end.
    #[inline(always)]
    pub fn measure(&self, light: &LightCarrier<F>, k: Vector<F>) -> F {
        let Stokes(stokes) = Rotation::between(light.x, self.x, k).apply(light.stokes);
        dot(self.row, stokes)
    }

    /// What a depolarizer leaves: the factor for unpolarized light.
    #[inline(always)]
    pub fn depolarized(self) -> F {
        self.row[0]
    }
}
