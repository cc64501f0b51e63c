//! What the two kinds of subpath carry besides their scalar throughput.
//!
//! | side | type | verb | meaning |
//! |---|---|---|---|
//! | light | [`LightCarrier`] | `scatter` | `S <- M R S`: the kernel on the left |
//! | sensor | [`SensorMatrix`], [`SensorRow`] | `collect` | `T <- T R M`: the kernel on the right |
//! | both | | `measure` | `T R S` where the subpaths meet |
//!
//! Everything here is of one wavelength. Frames are the same for all of them, and so are the
//! rotations `R` between frames: [`Arrival`] and [`Departure`] are prepared once per vertex and
//! used for every wavelength.
//!
//! The sides are different types because exchanging them is silent otherwise:
//!
//! ```compile_fail,E0599
//! use sunstone::internals::polarization::{Arrival, Block, SensorRow};
//! fn wrong(sensor: SensorRow<f32>, event: &Arrival<f32>, block: Block<f32>) -> SensorRow<f32> {
//!     sensor.scatter(event, block)
//! }
//! ```
//!
//! ```compile_fail,E0599
//! use sunstone::internals::polarization::{Block, Departure, LightCarrier};
//! fn wrong(light: LightCarrier<f32>, event: &Departure<f32>, block: Block<f32>) {
//!     light.collect(event, block);
//! }
//! ```
//!
//! ```compile_fail,E0308
//! use sunstone::internals::polarization::{Arrival, Block, SensorRow};
//! fn wrong(sensor: SensorRow<f32>, event: &Arrival<f32>, block: Block<f32>) -> SensorRow<f32> {
//!     sensor.collect(event, block)
//! }
//! ```
//!
//! ```
//! use sunstone::internals::math::Vector;
//! use sunstone::internals::polarization::{Arrival, Block, Departure, LightCarrier, SensorRow};
//! fn right(light: LightCarrier<f32>, sensor: SensorRow<f32>, block: Block<f32>) -> [f32; 2] {
//!     let (x, k) = (Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 0.0, 1.0));
//!     let scattered = light.scatter(&Arrival::between(light.x, x, k), block);
//!     let collected = sensor.collect(&Departure::between(x, sensor.x, k), block);
//!     let behind = sensor.measure(&scattered, &Arrival::between(scattered.x, sensor.x, k));
//!     let before = collected.measure(&light, &Arrival::between(light.x, collected.x, k));
//!     [behind, before]
//! }
//! let x = Vector::new(0.0, 1.0, 0.0);
//! let block = Block { a: 0.5, c: 0.8, s: 0.1 };
//! let [behind, before] = right(LightCarrier::unpolarized(x), SensorRow::intensity(x), block);
//! assert_eq!(behind, before);
//! ```

use super::frame::Rotation;
use super::kernel::{Block, Kernel, dot};
use super::stokes::Stokes;
use crate::math::{Real, Vector};

/// How light comes into a new frame about its direction: that of the event that it arrives at, of
/// the sensor subpath that measures it, or of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival<F> {
    rotation: Rotation<F>,
    x: Vector<F>,
}

impl<F: Real> Arrival<F> {
    /// From the light's own axis to another, for light along the unit vector `k`. As for
    /// [`Rotation::between`], neither axis need be of unit length or exactly perpendicular.
    #[inline(always)]
    pub fn between(x_light: Vector<F>, x_new: Vector<F>, k: Vector<F>) -> Self {
        Self { rotation: Rotation::between(x_light, x_new, k), x: x_new }
    }
}

/// How light leaves an event into the frame of the sensor subpath that this event extends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure<F> {
    rotation: Rotation<F>,
    /// The event's axis.
    x: Vector<F>,
}

impl<F: Real> Departure<F> {
    /// Of a rotation from the event's axis `x_event`.
    #[inline(always)]
    pub fn by(rotation: Rotation<F>, x_event: Vector<F>) -> Self {
        Self { rotation, x: x_event }
    }

    /// The rotation.
    #[inline(always)]
    pub fn rotation(&self) -> Rotation<F> {
        self.rotation
    }

    /// From the event's axis to the subpath's, for light that leaves the event along the unit
    /// vector `k`.
    #[inline(always)]
    pub fn between(x_event: Vector<F>, x_sensor: Vector<F>, k: Vector<F>) -> Self {
        Self { rotation: Rotation::between(x_event, x_sensor, k), x: x_event }
    }
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

    /// [`LightCarrier::unpolarized`] light after an event whose axis is `x`.
    #[inline(always)]
    pub fn first_event<K: Kernel<F>>(kernel: K, x: Vector<F>) -> Self {
        Self { stokes: kernel.first_stokes(), x }
    }

    /// The same light in another frame.
    #[inline(always)]
    pub fn turned(self, arrival: &Arrival<F>) -> Self {
        Self { stokes: arrival.rotation.apply(self.stokes), x: arrival.x }
    }

    /// The light after an event in whose frame it already is.
    #[inline(always)]
    pub fn pass<K: Kernel<F>>(self, kernel: K) -> Self {
        Self { stokes: kernel.scatter(self.stokes), x: self.x }
    }

    /// The light after the event at which it arrives.
    #[inline(always)]
    pub fn scatter<K: Kernel<F>>(self, arrival: &Arrival<F>, kernel: K) -> Self {
        self.turned(arrival).pass(kernel)
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

    /// The [`SensorMatrix::identity`], longer by its first event.
    #[inline(always)]
    pub fn first_event<K: Kernel<F>>(departure: &Departure<F>, kernel: K) -> Self {
        Self { matrix: kernel.first_event(departure.rotation), x: departure.x }
    }

    /// The subpath, longer by the event at its end.
    #[inline(always)]
    pub fn collect<K: Kernel<F>>(self, departure: &Departure<F>, kernel: K) -> Self {
        let matrix = kernel.collect_columns(departure.rotation.collect_matrix(self.matrix));
        Self { matrix, x: departure.x }
    }

    /// The film's Stokes vector of light that arrives in the frame of the subpath's end.
    #[inline(always)]
    pub fn measure(&self, light: &LightCarrier<F>, arrival: &Arrival<F>) -> Stokes<F> {
        let Stokes(stokes) = light.turned(arrival).stokes;
        let [first, second, third, fourth] = self.matrix;
        let of = |row| dot(row, stokes);
        Stokes([of(first), of(second), of(third), of(fourth)])
    }

    /// What a depolarizer leaves, for `T d e0 e0^T = (T e0)(d e0^T)`: a column that never changes
    /// again. The rest of the subpath is a [`SensorRow`].
    #[inline(always)]
    pub fn depolarized(self) -> SensorColumn<F> {
        let [first, second, third, fourth] = self.matrix;
        SensorColumn(Stokes([first[0], second[0], third[0], fourth[0]]))
    }
}

/// A [`SensorMatrix`] of one event, as the product that it is: `R B` of 7 numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorEvent<F> {
    /// The event.
    pub kernel: Block<F>,
    /// How light leaves it into the film's frame.
    pub departure: Departure<F>,
}

impl<F: Real> SensorEvent<F> {
    /// The same as a matrix.
    #[inline(always)]
    pub fn matrix(&self) -> SensorMatrix<F> {
        SensorMatrix::first_event(&self.departure, self.kernel)
    }

    /// The film's Stokes vector of light that arrives in the frame of the event.
    #[inline(always)]
    pub fn measure(&self, light: &LightCarrier<F>, arrival: &Arrival<F>) -> Stokes<F> {
        self.departure.rotation.apply(light.scatter(arrival, self.kernel).stokes)
    }

    /// What a depolarizer leaves; see [`SensorMatrix::depolarized`].
    #[inline(always)]
    pub fn depolarized(&self) -> SensorColumn<F> {
        SensorColumn(self.departure.rotation.apply(self.kernel.first_stokes()))
    }

    /// The row by which the intensity on the film follows from light in the frame of the event.
    #[inline(always)]
    pub fn first_row(&self) -> [F; 4] {
        self.kernel.first_row()
    }
}

/// The part of a sensor subpath between the film and its first depolarizer: the Stokes vector on
/// the film per unit of light that the rest of the subpath measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorColumn<F>(pub Stokes<F>);

impl<F: Real> SensorColumn<F> {
    /// The intensity on the film, and the column relative to it.
    #[inline(always)]
    pub fn normalized(self) -> (F, Self) {
        let Stokes([c0, c1, c2, c3]) = self.0;
        // Where no light can pass, the direction of nothing is nothing.
        let inverse = F::select(c0.gt(F::zero()), F::one() / c0, F::zero());
        (c0, Self(Stokes([F::one(), c1 * inverse, c2 * inverse, c3 * inverse])))
    }

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

    /// The [`SensorRow::intensity`], longer by a first event whose axis is `x`.
    #[inline(always)]
    pub fn first_event<K: Kernel<F>>(kernel: K, x: Vector<F>) -> Self {
        Self { row: kernel.first_row(), x }
    }

    /// The subpath, longer by the event at its end.
    #[inline(always)]
    pub fn collect<K: Kernel<F>>(self, departure: &Departure<F>, kernel: K) -> Self {
        let row = kernel.collect_row(departure.rotation.collect_row(self.row));
        Self { row, x: departure.x }
    }

    /// What the film measures of light that arrives in the frame of the subpath's end.
    #[inline(always)]
    pub fn measure(&self, light: &LightCarrier<F>, arrival: &Arrival<F>) -> F {
        let Stokes(stokes) = light.turned(arrival).stokes;
        dot(self.row, stokes)
    }

    /// What a depolarizer leaves: the factor for unpolarized light.
    #[inline(always)]
    pub fn depolarized(self) -> F {
        self.row[0]
    }
}
