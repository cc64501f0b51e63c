//! The stages that render, against the algebra and so against the 120 chains: light and sensor
//! paths of three wavelengths that run through tables of columns, by every form of kernel, joined
//! at every segment, with and without a depolarizer in between.

use std::ops::Range;

use glam::Vec3;
use sunstone::internals::math::columns::Channels;
use sunstone::internals::math::{Vector, lanes};
use sunstone::internals::polarization::{Arrival, Block, LightCarrier, SensorMatrix, SensorRow};
use sunstone::internals::polarization::{Stokes, kernel::SpheroidBlock};
use sunstone::internals::scattering::Met;
use sunstone::internals::scattering::event::{Event, Form};
use sunstone::internals::transport::measure::{measure_polarized, measure_unpolarized};
use sunstone::internals::transport::stages::collect_sensor::collect_sensor;
use sunstone::internals::transport::stages::depolarize_light::depolarize_light;
use sunstone::internals::transport::stages::depolarize_sensor::depolarize_sensor;
use sunstone::internals::transport::stages::scatter_light::scatter_light;
use sunstone::internals::transport::tables::carriers::{
    CarrierTable, LightCarriers, SensorCarriers,
};
use sunstone::internals::transport::tables::classes::{LightClass, SensorClass};
use sunstone::internals::transport::tables::kernels::KernelColumns;
use sunstone::internals::transport::tables::measured::{Measured, Reading};
use sunstone::internals::transport::tables::partition::{Part, Partition};
use sunstone::internals::transport::tables::paths::IdentityColumns;
use sunstone::internals::transport::tables::states::LightState;
use sunstone::internals::transport::tables::{channels, vectors};

use crate::traced::{self, Chain, Traced, trace};
use crate::vertex::Vertex;

const N: usize = 3;

/// Five kernels and six rotations, each exact to a few roundings of 6e-8 of numbers up to one,
/// most of which average out; throughput included, which is at most one.
const TOLERANCE: f64 = 1e-6;

/// Which loops the chains go through.
#[derive(Clone, Copy)]
struct Case {
    form: Form,
    /// Events from the sensor on that are the same at all wavelengths.
    achromatic: usize,
    /// The event, counted from the sensor, in whose place a depolarizer stands.
    depolarizer: Option<usize>,
}

/// The chains as rows, the longest first, so that those that still have events come first.
struct Rows {
    chains: Vec<Chain>,
    traced: Vec<Traced<f32>>,
    exact: Vec<Traced<f64>>,
    case: Case,
}

impl Rows {
    fn new(case: Case) -> Self {
        let mut chains = traced::load();
        chains.sort_by_key(|chain| std::cmp::Reverse(chain.events.len()));
        let traced = chains.iter().map(trace).collect();
        let exact = chains.iter().map(trace).collect();
        Self { chains, traced, exact, case }
    }

    fn len(&self) -> usize {
        self.chains.len()
    }

    fn events(&self, row: usize) -> usize {
        self.chains[row].events.len()
    }

    /// The rows that have more than so many events.
    fn longer_than(&self, events: usize) -> Range<usize> {
        0..(0..self.len()).filter(|&row| self.events(row) > events).count()
    }

    /// The event of a row at its place from the light, as it stands among the scene's events.
    fn event(&self, row: usize, place: usize) -> Event {
        let from_sensor = self.events(row) - 1 - place;
        let depolarizes = self.case.depolarizer == Some(from_sensor);
        Event {
            met: Met::Medium(0),
            form: if depolarizes { Form::Depolarizer } else { self.case.form },
            achromatic: from_sensor < self.case.achromatic,
        }
    }

    /// What the event of a row is at a wavelength; the first has the chain's own kernels.
    fn exact(&self, row: usize, place: usize, wavelength: usize) -> Vertex<f64> {
        let vertex = self.exact[row].events[place];
        let factor = self.factor(row, place, wavelength);
        let Block { a, c, s } = vertex.kernel;
        Vertex { kernel: Block { a: a * factor, c, s: s * factor }, ..vertex }
    }

    fn factor(&self, row: usize, place: usize, wavelength: usize) -> f64 {
        let achromatic = self.event(row, place).achromatic;
        if achromatic { 1.0 } else { [1.0, 0.5, -0.25][wavelength] }
    }

    /// Rows that meet the same, next to each other.
    fn partition(
        &self,
        rows: Range<usize>,
        event: impl Fn(usize) -> Event,
        class: impl Fn(usize) -> usize,
    ) -> Partition {
        let mut partition = Partition::default();
        for row in rows {
            let (event, class) = (event(row), class(row));
            match partition.parts.last_mut() {
                Some(part) if (part.event, part.class) == (event, class) => part.rows.end = row + 1,
                _ => partition.parts.push(Part { event, class, rows: row..row + 1 }),
            }
        }
        partition
    }

    /// Writes the kernels of the rows; what no stage may read is not a number.
    fn write_kernels(
        &self,
        kernels: &mut KernelColumns<N>,
        rows: Range<usize>,
        place: impl Fn(usize) -> usize,
    ) {
        let unread = f32::NAN;
        for row in rows {
            let (event, at) = (self.event(row, place(row)), place(row));
            let vertex = self.traced[row].events[at];
            for n in 0..N {
                let is_stored = event.form != Form::Depolarizer && (n == 0 || !event.achromatic);
                let Block { a, c, s } = vertex.kernel;
                let factor = self.factor(row, at, n) as f32;
                let full = SpheroidBlock { a: a * factor, b: 1.0, c, d: c, s: s * factor };
                let none = SpheroidBlock { a: unread, b: unread, c: unread, d: unread, s: unread };
                let block = SpheroidBlock { b: unread, d: unread, ..full };
                let SpheroidBlock { a, b, c, d, s } = match event.form {
                    Form::Spheroid if is_stored => full,
                    Form::Block if is_stored => block,
                    Form::Spheroid | Form::Block | Form::Dense | Form::Depolarizer => none,
                };
                (kernels.a[n][row], kernels.b[n][row], kernels.c[n][row]) = (a, b, c);
                (kernels.d[n][row], kernels.s[n][row]) = (d, s);
                kernels.dense[row][n] = match event.form {
                    Form::Dense if is_stored => {
                        let SpheroidBlock { a, b, c, d, s } = full;
                        let rows = [[1.0, a, 0.0, 0.0], [a, b, 0.0, 0.0], [0.0, 0.0, c, s]];
                        let all = [rows[0], rows[1], rows[2], [0.0, 0.0, -s, d]];
                        std::array::from_fn(|index| all[index / 4][index % 4])
                    }
                    Form::Dense | Form::Spheroid | Form::Block | Form::Depolarizer => [unread; 16],
                };
            }
            write_vector(&mut kernels.axis, row, vertex.x.into());
        }
    }

    fn directions(&self, rows: Range<usize>, of: impl Fn(usize) -> [f32; 3]) -> [Vec<f32>; 3] {
        let mut directions = vectors(self.len());
        rows.for_each(|row| write_vector(&mut directions, row, of(row)));
        directions
    }

    fn throughputs(&self) -> Channels<N> {
        let mut beta = channels(self.len());
        for column in &mut beta {
            column.iter_mut().zip(&self.traced).for_each(|(beta, traced)| *beta = traced.beta);
        }
        beta
    }

    fn up(&self, row: usize) -> Vec3 {
        Vec3::from(self.chains[row].camera_up.map(|component| component as f32))
    }
}

fn write_vector(columns: &mut [Vec<f32>; 3], row: usize, vector: [f32; 3]) {
    columns.iter_mut().zip(vector).for_each(|(column, component)| column[row] = component);
}

/// All light paths before every one of their events, and behind the last: states, throughputs.
fn light_side(rows: &Rows) -> Vec<Vec<(LightState<N>, [f32; N])>> {
    let mut carriers = LightCarriers::<N>::new(rows.len());
    let mut kernels = KernelColumns::new(rows.len());
    let mut beta = rows.throughputs();
    for (row, Traced { light, .. }) in rows.traced.iter().enumerate() {
        carriers.class[row] = LightClass::Polarized;
        write_vector(&mut carriers.axis, row, light.x.into());
        for (columns, &value) in carriers.stokes.iter_mut().zip(&light.stokes.0) {
            columns.iter_mut().for_each(|column| column[row] = value);
        }
    }
    let mut kept = vec![Vec::new(); rows.len()];
    for place in 0.. {
        // Behind its last event a row stays as it is.
        let arrived = (0..rows.len()).filter(|&row| rows.events(row) >= place);
        for row in arrived {
            let x = lanes::row_of(&carriers.axis, row).into();
            let polarized = carriers.class[row].has_stokes();
            let light = |n| {
                if polarized { carriers.load(n, row, x) } else { LightCarrier::unpolarized(x) }
            };
            let beta = std::array::from_fn(|n| beta[n][row]);
            kept[row].push((LightState::of_wavelengths(x, light), beta));
        }
        let live = rows.longer_than(place);
        if live.is_empty() {
            return kept;
        }
        rows.write_kernels(&mut kernels, live.clone(), |_| place);
        let class = |row: usize| carriers.class[row] as usize;
        let partition = rows.partition(live.clone(), |row| rows.event(row, place), class);
        let directions =
            rows.directions(live.clone(), |row| rows.traced[row].directions[place].into());
        depolarize_light(&mut carriers, &mut beta, &partition);
        scatter_light(&mut carriers, &kernels, &directions, &partition);
        for part in partition.parts.iter().filter(|part| part.is_depolarized()) {
            // Any axis will do; this one the algebra is compared with.
            for row in part.rows.clone() {
                write_vector(&mut carriers.axis, row, rows.traced[row].events[place].x.into());
            }
        }
    }
    unreachable!("chains end");
}

/// The same of one row and wavelength in double precision: states times throughput.
fn exact_light(rows: &Rows, row: usize, n: usize) -> Vec<LightCarrier<f64>> {
    let traced = &rows.exact[row];
    let start = LightCarrier { stokes: traced.light.stokes.scaled(traced.beta), ..traced.light };
    let mut states = vec![start];
    for place in 0..rows.events(row) {
        let (light, vertex) = (states[place], rows.exact(row, place, n));
        states.push(match rows.event(row, place).form {
            Form::Depolarizer => {
                let stokes = Stokes::unpolarized().scaled(light.depolarized());
                LightCarrier { stokes, x: vertex.x }
            }
            Form::Block | Form::Spheroid | Form::Dense => {
                light.scatter(&vertex.arrival(light.x), vertex.kernel)
            }
        });
    }
    states
}

/// Calls `visit` with the sensor paths before every event from the sensor on, their throughputs,
/// and slots that know of their first depolarizers, and of no light yet.
fn sensor_side(
    rows: &Rows,
    components: usize,
    mut visit: impl FnMut(&SensorCarriers<N>, &Channels<N>, &Measured<N>, usize),
) {
    let mut carriers = SensorCarriers::<N>::new(rows.len());
    let mut measured = Measured::new(rows.len(), components);
    let mut identity = IdentityColumns::new(rows.len());
    for (row, slot) in identity.slot[..rows.len()].iter_mut().enumerate() {
        *slot = row as u32;
    }
    let mut kernels = KernelColumns::new(rows.len());
    let mut beta = rows.throughputs();
    carriers.start_at_film(rows.len(), components);
    for depth in 0.. {
        visit(&carriers, &beta, &measured, depth);
        let live = rows.longer_than(depth);
        if live.is_empty() {
            return;
        }
        let place = |row: usize| rows.events(row) - 1 - depth;
        rows.write_kernels(&mut kernels, live.clone(), place);
        // Rays run against the light that leaves the event.
        let directions = rows
            .directions(live.clone(), |row| (-rows.traced[row].directions[place(row) + 1]).into());
        let class = |carriers: &SensorCarriers<N>, row: usize| carriers.class[row] as usize;
        let event = |row: usize| rows.event(row, place(row));
        let all = rows.partition(live.clone(), event, |row| class(&carriers, row));
        depolarize_sensor(&mut carriers, &mut beta, &mut measured, &identity, &all);
        // Chains have films of their own, which rows ask for until their first event.
        let is_fresh = carriers.class[0] == SensorClass::Fresh;
        let groups: Vec<Range<usize>> =
            if is_fresh { live.map(|row| row..row + 1).collect() } else { vec![live] };
        for group in groups {
            let up = rows.up(group.start);
            let partition = rows.partition(group, event, |row| class(&carriers, row));
            collect_sensor(&mut carriers, &kernels, &directions, up, &partition);
        }
    }
}

/// A sensor path in double precision: everything that it is, for a film of four components.
#[derive(Clone, Copy)]
enum Exact {
    Matrix(SensorMatrix<f64>),
    RankOne(Stokes<f64>, SensorRow<f64>),
}

fn exact_sensor(rows: &Rows, row: usize, n: usize, depth: usize) -> Exact {
    let film_x = rows.exact[row].film_x;
    let mut sensor = Exact::Matrix(SensorMatrix::identity(film_x));
    for place in (0..rows.events(row)).rev().take(depth) {
        let vertex = rows.exact(row, place, n);
        let depolarizes = rows.event(row, place).form == Form::Depolarizer;
        sensor = match sensor {
            Exact::Matrix(matrix) if depolarizes => {
                Exact::RankOne(matrix.depolarized().0, SensorRow::intensity(vertex.x))
            }
            Exact::Matrix(matrix) => {
                Exact::Matrix(matrix.collect(&vertex.departure(matrix.x), vertex.kernel))
            }
            Exact::RankOne(column, row) => {
                Exact::RankOne(column, row.collect(&vertex.departure(row.x), vertex.kernel))
            }
        };
    }
    sensor
}

impl Exact {
    fn measure(&self, light: &LightCarrier<f64>, k: Vector<f64>) -> [f64; 4] {
        let meets = |x| Arrival::between(light.x, x, k);
        match self {
            Self::Matrix(matrix) => matrix.measure(light, &meets(matrix.x)).0,
            Self::RankOne(column, row) => column.scaled(row.measure(light, &meets(row.x))).0,
        }
    }
}

/// The largest error of a component of all films.
struct Worst(f64);

impl Worst {
    fn compare(&mut self, found: f32, expected: f64, place: impl std::fmt::Debug) {
        let error = (f64::from(found) - expected).abs();
        assert!(error <= TOLERANCE, "{place:?}: {found} is not {expected}");
        self.0 = self.0.max(error);
    }
}

/// What a slot has measured, by wavelength.
fn stokes_of(measured: &mut Measured<N>, slot: usize) -> [[f32; 4]; N] {
    let unpolarized = |intensity: &[f32; N]| intensity.map(|value| [value, 0.0, 0.0, 0.0]);
    if measured.components() == 1 {
        let (slots, _) = measured.intensities_mut(slot + 1).as_chunks::<N>();
        return unpolarized(&slots[slot]);
    }
    match measured.reading(slot) {
        Reading::Intensity(intensity) => unpolarized(intensity),
        Reading::Stokes(states) => states.map(|state| state.to_array()),
    }
}

fn check(case: Case, components: usize) -> f64 {
    let rows = Rows::new(case);
    let light = light_side(&rows);
    let mut worst = Worst(0.0);
    sensor_side(&rows, components, |carriers, beta, slots, depth| {
        let mut measured = [slots.clone(), slots.clone()];
        let live = (0..rows.len()).filter(|&row| rows.events(row) >= depth);
        for row in live.clone() {
            let join = rows.events(row) - depth;
            let (state, light_beta) = &light[row][join];
            let along = (rows.traced[row].directions[join], rows.up(row));
            // What depolarizers of either side have left, of which both have the whole chain's.
            let value = |n: usize| beta[n][row] * light_beta[n] / rows.traced[row].beta;
            let (values, place) = (std::array::from_fn(value), (row, row));
            measure_polarized(&mut measured[0], carriers, place, values, state, along);
            let unpolarized = std::array::from_fn(|n| beta[n][row]);
            measure_unpolarized(&mut measured[1], carriers, place, unpolarized);
        }
        for row in live {
            let join = rows.events(row) - depth;
            let k = rows.exact[row].directions[join];
            for n in 0..N {
                let sensor = exact_sensor(&rows, row, n, depth);
                let polarized = exact_light(&rows, row, n)[join];
                let stokes = Stokes::unpolarized().scaled(rows.exact[row].beta);
                let lights = [polarized, LightCarrier { stokes, x: polarized.x }];
                for (measured, light) in measured.iter_mut().zip(lights) {
                    let expected = sensor.measure(&light, k);
                    let found = stokes_of(measured, row);
                    for component in 0..components {
                        let place = (rows.chains[row].id, depth, n, component);
                        worst.compare(found[n][component], expected[component], place);
                    }
                }
            }
        }
    });
    worst.0
}

#[test]
fn columns_measure_what_the_algebra_measures() {
    let mut worst = 0.0_f64;
    for form in [Form::Block, Form::Spheroid, Form::Dense] {
        // All matrices apart, one for all wavelengths, and one that splits.
        for achromatic in [0, 1, 2, 5] {
            for depolarizer in [None, Some(0), Some(1), Some(2), Some(4)] {
                let case = Case { form, achromatic, depolarizer };
                worst = worst.max(check(case, 4)).max(check(case, 1));
            }
        }
    }
    println!("columns: largest error {worst:e}");
}

/// What the columns are compared with is the field itself.
#[test]
fn the_first_wavelength_measures_the_field() {
    let rows = Rows::new(Case { form: Form::Block, achromatic: 2, depolarizer: None });
    for row in 0..rows.len() {
        let k = *rows.exact[row].directions.last().expect("a segment");
        let light = exact_light(&rows, row, 0)[rows.events(row)];
        let found = exact_sensor(&rows, row, 0, 0).measure(&light, k);
        for (found, expected) in found.iter().zip(rows.chains[row].stokes_out) {
            assert!((found - expected).abs() <= 1e-12);
        }
    }
}
