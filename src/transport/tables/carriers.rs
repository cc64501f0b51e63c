//! Polarization as components that rows have or lack: what the carriers of a path table hold, by
//! the classes of [`super::classes`].
//!
//! The tables hold nothing but the carriers of the algebra ([`LightCarrier`], [`SensorEvent`],
//! [`SensorMatrix`], [`SensorRow`]), one per row and wavelength with an axis per row: they load
//! from the columns and store to them, and all that happens to them is theirs.
//!
//! Depolarizers fold what scales the intensity (r0, or T00 and the light side's s0) into the
//! throughput `beta`.

use super::classes::{LightClass, SensorClass};
use super::partition::Part;
use super::states::LightState;
use super::{channels, vectors};
use crate::math::columns::{Channels, Column, take};
use crate::math::lanes::{self, FromColumn};
use crate::math::{F32s, Vector};
use crate::polarization::{
    Arrival, Block, Departure, LightCarrier, Rotation, SensorEvent, SensorMatrix, SensorRow, Stokes,
};

/// What [`CarrierTable::lean`] says of some rows at every wavelength.
// By way of a pointer: stages that scatter are large, and are compiled once for both sides.
pub type Lean<'a, const N: usize> =
    dyn Fn(usize, (Vector<F32s>, Vector<F32s>)) -> [[F32s; 2]; N] + 'a;

/// [`CarrierTable::lean`] at every wavelength.
pub fn lean_of<const N: usize>(
    carriers: &impl CarrierTable,
    part: &Part,
    row: usize,
    frame: (Vector<F32s>, Vector<F32s>),
) -> [[F32s; 2]; N] {
    let mut light = [[F32s::ZERO; 2]; N];
    for (n, light) in light.iter_mut().enumerate() {
        *light = carriers.lean(part, n, row, frame);
    }
    light
}

/// Columns of polarization that travel with the rows of a path table.
pub trait CarrierTable: 'static {
    /// Number of classes.
    const CLASSES: usize;

    /// An empty table for `capacity` rows.
    fn new(capacity: usize) -> Self;

    /// The place of a row's class among the classes.
    fn place_of_class(&self, row: usize) -> usize;

    /// Takes the rows `order[part.rows]` of `from`, all of one class, to `part.rows`: of those that
    /// meet a depolarizer, no more than what it leaves of them.
    fn gather(&mut self, from: &Self, order: &[u32], part: &Part);

    /// Whether the rows of a part may carry, or accept, more light of one polarization.
    fn leans(part: &Part) -> bool;

    /// S0 and S1, about the axis `x` that is perpendicular to the direction `k` of the light, of
    /// what the rows from `row` on of a part that [leans](Self::leans) carry, or accept into the
    /// intensity on the film.
    fn lean(
        &self,
        part: &Part,
        wavelength: usize,
        row: usize,
        frame: (Vector<F32s>, Vector<F32s>),
    ) -> [F32s; 2];
}

/// Scalar mode: no columns at all.
impl CarrierTable for () {
    const CLASSES: usize = 1;
    fn new(_capacity: usize) -> Self {}
    #[inline(always)]
    fn place_of_class(&self, _row: usize) -> usize {
        0
    }
    #[inline(always)]
    fn gather(&mut self, _from: &Self, _order: &[u32], _part: &Part) {}
    #[inline(always)]
    fn leans(_part: &Part) -> bool {
        false
    }
    #[inline(always)]
    fn lean(
        &self,
        _part: &Part,
        _wavelength: usize,
        _row: usize,
        _frame: (Vector<F32s>, Vector<F32s>),
    ) -> [F32s; 2] {
        [F32s::ONE, F32s::ZERO]
    }
}

/// The light side's Stokes vectors, relative to the scalar throughput.
pub struct LightCarriers<const N: usize> {
    /// Class of every row.
    pub class: Vec<LightClass>,
    /// The x axis of the frame, perpendicular to the ray.
    pub axis: [Column; 3],
    /// S0..S3 over what the scalar renderer carries.
    pub stokes: [Channels<N>; 4],
}

/// The sensor side's matrices, relative to the scalar throughput.
pub struct SensorCarriers<const N: usize> {
    /// Class of every row.
    pub class: Vec<SensorClass>,
    /// The x axis of the frame in which light is accepted, perpendicular to the ray.
    pub axis: [Column; 3],
    /// r0..r3.
    pub row: [Channels<N>; 4],
    /// a, c and s of one event.
    pub block: [Channels<N>; 3],
    /// The rotation behind it: cos 2a and sin 2a.
    pub rotation: [Column; 2],
    /// T, `[row][column]`.
    pub matrix: [[Channels<N>; 4]; 4],
}

impl<const N: usize> LightCarriers<N> {
    /// Forgets what earlier paths left: all rows start unpolarized, until it is said otherwise.
    pub fn start_at_emitters(&mut self, rows: usize) {
        self.class[..rows].fill(LightClass::Unpolarized);
    }

    /// Starts a row in a state.
    pub fn start_polarized(&mut self, row: usize, light: &LightState<N>) {
        self.class[row] = LightClass::Polarized;
        for (column, value) in self.axis.iter_mut().zip([light.x.x, light.x.y, light.x.z]) {
            column[row] = value;
        }
        for (n, Stokes(state)) in light.stokes.iter().enumerate() {
            for (columns, value) in self.stokes.iter_mut().zip(state) {
                columns[n][row] = *value;
            }
        }
    }

    /// Reads a wavelength from `row` on, where the axis is `x`.
    #[inline(always)]
    pub fn load<F: FromColumn>(
        &self,
        wavelength: usize,
        row: usize,
        x: Vector<F>,
    ) -> LightCarrier<F> {
        let component = |i: usize| F::load(&self.stokes[i][wavelength], row);
        LightCarrier { stokes: Stokes(elements(component)), x }
    }

    /// Writes a wavelength of the rows from `row` to `end`, at most eight; the axis, which all
    /// wavelengths share, is not written.
    #[inline(always)]
    pub fn store(&mut self, wavelength: usize, row: usize, end: usize, light: &LightCarrier<F32s>) {
        for (columns, value) in self.stokes.iter_mut().zip(&light.stokes.0) {
            lanes::store(&mut columns[wavelength], row, end, *value);
        }
    }
}

impl<const N: usize> SensorCarriers<N> {
    /// Starts all rows at a film of so many Stokes components: 1 or 4.
    pub fn start_at_film(&mut self, rows: usize, components: usize) {
        // A film of intensities is e0 e0^T: it depolarizes.
        let class = if components == 1 { SensorClass::Plain } else { SensorClass::Fresh };
        self.class[..rows].fill(class);
    }

    /// Starts all rows at a film behind an analyzer that passes the light of unit intensity
    /// `state`, given for the film's own axis, which is to be written beside. What they accept is
    /// relative to unpolarized light: twice what passes.
    pub fn start_at_analyzer(&mut self, rows: usize, Stokes(state): Stokes<f64>) {
        self.class[..rows].fill(SensorClass::Row);
        for (columns, value) in self.row.iter_mut().zip(state) {
            columns.iter_mut().for_each(|column| column[..rows].fill(value as f32));
        }
    }

    /// Reads the matrix in a channel from `row` on, where the axis is `x`.
    #[inline(always)]
    pub fn load_matrix<F: FromColumn>(
        &self,
        channel: usize,
        row: usize,
        x: Vector<F>,
    ) -> SensorMatrix<F> {
        let element = |i: usize, j: usize| F::load(&self.matrix[i][j][channel], row);
        let of_row = |i: usize| elements(|j| element(i, j));
        SensorMatrix { matrix: [of_row(0), of_row(1), of_row(2), of_row(3)], x }
    }

    /// Reads the row r of a wavelength from `row` on, where the axis is `x`.
    #[inline(always)]
    pub fn load_row<F: FromColumn>(
        &self,
        wavelength: usize,
        row: usize,
        x: Vector<F>,
    ) -> SensorRow<F> {
        SensorRow { row: elements(|i| F::load(&self.row[i][wavelength], row)), x }
    }

    /// Reads the one event in a channel from `row` on, where the axis is `x`.
    #[inline(always)]
    pub fn load_event<F: FromColumn>(
        &self,
        channel: usize,
        row: usize,
        x: Vector<F>,
    ) -> SensorEvent<F> {
        let [a, c, s] = &self.block;
        let [cos2, sin2] = &self.rotation;
        let rotation = Rotation { cos2: F::load(cos2, row), sin2: F::load(sin2, row) };
        let kernel = Block {
            a: F::load(&a[channel], row),
            c: F::load(&c[channel], row),
            s: F::load(&s[channel], row),
        };
        SensorEvent { kernel, departure: Departure::by(rotation, x) }
    }

    /// Writes the one event in a channel of the rows from `row` to `end`, at most eight, without
    /// the axis and the rotation, which all channels share.
    #[inline(always)]
    pub fn store_event(&mut self, channel: usize, row: usize, end: usize, kernel: Block<F32s>) {
        let [a, c, s] = &mut self.block;
        lanes::store(&mut a[channel], row, end, kernel.a);
        lanes::store(&mut c[channel], row, end, kernel.c);
        lanes::store(&mut s[channel], row, end, kernel.s);
    }

    /// Writes the matrix in a channel of the rows from `row` to `end`, at most eight, without the
    /// axis.
    #[inline(always)]
    pub fn store_matrix(
        &mut self,
        channel: usize,
        row: usize,
        end: usize,
        sensor: &SensorMatrix<F32s>,
    ) {
        for (columns, values) in self.matrix.iter_mut().zip(&sensor.matrix) {
            for (column, value) in columns.iter_mut().zip(values) {
                lanes::store(&mut column[channel], row, end, *value);
            }
        }
    }

    /// Writes the row r of a wavelength of the rows from `row` to `end`, at most eight, without the
    /// axis.
    #[inline(always)]
    pub fn store_row(
        &mut self,
        wavelength: usize,
        row: usize,
        end: usize,
        sensor: &SensorRow<F32s>,
    ) {
        for (column, value) in self.row.iter_mut().zip(&sensor.row) {
            lanes::store(&mut column[wavelength], row, end, *value);
        }
    }
}

/// Four elements. Spelled out, since `array::from_fn` is not always inlined.
#[inline(always)]
fn elements<F>(element: impl Fn(usize) -> F) -> [F; 4] {
    [element(0), element(1), element(2), element(3)]
}

impl<const N: usize> CarrierTable for LightCarriers<N> {
    const CLASSES: usize = LightClass::ALL.len();

    fn new(capacity: usize) -> Self {
        Self {
            class: vec![LightClass::Unpolarized; capacity],
            axis: vectors(capacity),
            stokes: std::array::from_fn(|_| channels(capacity)),
        }
    }

    #[inline(always)]
    fn place_of_class(&self, row: usize) -> usize {
        self.class[row] as usize
    }

    fn gather(&mut self, from: &Self, order: &[u32], part: &Part) {
        let (class, rows) = (LightClass::of(part), part.rows.clone());
        self.class[rows.clone()].fill(class);
        if !class.has_stokes() {
            return;
        }
        let order = &order[rows.clone()];
        if part.is_depolarized() {
            return gather_group(&mut self.stokes[0], &from.stokes[0], order, rows.start);
        }
        gather_group(&mut self.axis, &from.axis, order, rows.start);
        for (to, from) in self.stokes.iter_mut().zip(&from.stokes) {
            gather_group(to, from, order, rows.start);
        }
    }

    fn leans(part: &Part) -> bool {
        LightClass::of(part).has_stokes()
    }

    #[inline(always)]
    fn lean(
        &self,
        _part: &Part,
        wavelength: usize,
        row: usize,
        (axis, k): (Vector<F32s>, Vector<F32s>),
    ) -> [F32s; 2] {
        let x = Vector::load(&self.axis, row);
        let Stokes([s0, s1, ..]) =
            self.load(wavelength, row, x).turned(&Arrival::between(x, axis, k)).stokes;
        [s0, s1]
    }
}

impl<const N: usize> CarrierTable for SensorCarriers<N> {
    const CLASSES: usize = SensorClass::ALL.len();

    fn new(capacity: usize) -> Self {
        Self {
            class: vec![SensorClass::Fresh; capacity],
            axis: vectors(capacity),
            row: std::array::from_fn(|_| channels(capacity)),
            block: std::array::from_fn(|_| channels(capacity)),
            rotation: channels(capacity),
            matrix: std::array::from_fn(|_| std::array::from_fn(|_| channels(capacity))),
        }
    }

    #[inline(always)]
    fn place_of_class(&self, row: usize) -> usize {
        self.class[row] as usize
    }

    fn gather(&mut self, from: &Self, order: &[u32], part: &Part) {
        let (class, rows) = (SensorClass::of(part), part.rows.clone());
        self.class[rows.clone()].fill(class);
        let order = &order[rows.clone()];
        // What is accepted after a depolarizer is intensity.
        let accepted = if part.is_depolarized() { 1 } else { 4 };
        if class.has_axis() && accepted > 1 {
            gather_group(&mut self.axis, &from.axis, order, rows.start);
        }
        if class.has_row() {
            for (to, from) in self.row[..accepted].iter_mut().zip(&from.row) {
                gather_group(to, from, order, rows.start);
            }
        }
        if class.has_event() {
            gather_group(&mut self.rotation, &from.rotation, order, rows.start);
            // Unpolarized light takes but the first column of the kernel.
            let kept = if part.is_depolarized() { 1 } else { 3 };
            for (to, from) in self.block[..kept].iter_mut().zip(&from.block) {
                gather_group(&mut to[..class.wavelengths::<N>()], from, order, rows.start);
            }
        }
        if class.has_matrix() {
            for (to, from) in self.matrix.iter_mut().zip(&from.matrix) {
                for (to, from) in to[..accepted].iter_mut().zip(from) {
                    gather_group(&mut to[..class.wavelengths::<N>()], from, order, rows.start);
                }
            }
        }
    }

    fn leans(part: &Part) -> bool {
        let class = SensorClass::of(part);
        class.has_axis()
    }

    #[inline(always)]
    fn lean(
        &self,
        part: &Part,
        wavelength: usize,
        row: usize,
        (axis, k): (Vector<F32s>, Vector<F32s>),
    ) -> [F32s; 2] {
        let (class, x) = (SensorClass::of(part), Vector::load(&self.axis, row));
        let accepted = match class {
            SensorClass::Full | SensorClass::Common => {
                let channel = class.channel_of(wavelength);
                elements(|j| F32s::load(&self.matrix[0][j][channel], row))
            }
            SensorClass::Once | SensorClass::OnceCommon => {
                self.load_event(class.channel_of(wavelength), row, x).first_row()
            }
            SensorClass::Row => self.load_row(wavelength, row, x).row,
            SensorClass::Fresh | SensorClass::Plain => Stokes::unpolarized().0,
        };
        let [r0, r1, ..] = Rotation::between(axis, x, k).collect_row(accepted);
        [r0, r1]
    }
}

/// S1 over S0; zero where that is nothing.
#[inline(always)]
pub fn ratio([s0, s1]: [F32s; 2]) -> F32s {
    s0.simd_gt(F32s::ZERO) & (s1 / s0)
}

fn gather_group(to: &mut [Column], from: &[Column], order: &[u32], start: usize) {
    for (to, from) in to.iter_mut().zip(from) {
        take(to, from, order, start);
    }
}
