//! The recursion against brute force: the densities of all strategies that make a path, one by one
//! from its vertices, and their shares of the sum.
//!
//! Paths are made of random densities, cosines and distances; nothing requires that a model has
//! them. Where a specular vertex turns, the densities both ways are the same number: it stands for
//! the same delta, which all strategies have to pass.

use super::*;
use crate::math::hash;

/// Largest difference of two weights, relative to them.
const TOLERANCE: f64 = 1e-10;
/// Paths of each kind of emitter and sensor.
const PATHS: u32 = 400;
/// Most segments of a path.
const SEGMENTS_MAX: usize = 8;
/// Ways to aim a light path: at the whole scene, and at some balls.
const AIMS: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq)]
enum EmitterKind {
    Area,
    Point,
    Spot,
    Directional,
    Environment,
}

const EMITTERS: [EmitterKind; 5] = [
    EmitterKind::Area,
    EmitterKind::Point,
    EmitterKind::Spot,
    EmitterKind::Directional,
    EmitterKind::Environment,
];

impl EmitterKind {
    fn finite(self) -> bool {
        matches!(self, Self::Area | Self::Point | Self::Spot)
    }

    fn delta(self) -> bool {
        matches!(self, Self::Point | Self::Spot | Self::Directional)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum SensorKind {
    Pinhole,
    Lens,
    Parallel,
}

const SENSORS: [SensorKind; 3] = [SensorKind::Pinhole, SensorKind::Lens, SensorKind::Parallel];

#[derive(Clone, Copy, Debug, PartialEq)]
enum VertexKind {
    Surface,
    Medium,
    Specular,
}

/// Between sensor and emitter.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    kind: VertexKind,
    /// Per steradian, of going on towards the emitter when coming from the sensor.
    pdf_to_light: f64,
    /// And the other way.
    pdf_to_sensor: f64,
    /// Cosines of the directions to the emitter and the sensor, or the medium's density.
    measure_to_light: f64,
    measure_to_sensor: f64,
    /// Of choosing the emitter and its point when connecting from here, as emitters are chosen by
    /// what they bring to the vertex.
    direct_pdf: f64,
}

impl Vertex {
    fn random(random: &mut Random) -> Self {
        let kinds = [VertexKind::Surface, VertexKind::Medium, VertexKind::Specular];
        let kind = kinds[(random.up_to(3.0) as usize).min(2)];
        let [pdf_to_light, other_pdf] = [random.density(), random.density()];
        let [measure_to_light, other_measure] = [random.density(), random.density()];
        let (pdf_to_sensor, measure_to_sensor) = match kind {
            VertexKind::Surface => (other_pdf, other_measure),
            VertexKind::Medium => (other_pdf, measure_to_light),
            VertexKind::Specular => (pdf_to_light, other_measure),
        };
        let direct_pdf = random.density();
        Self { kind, pdf_to_light, pdf_to_sensor, measure_to_light, measure_to_sensor, direct_pdf }
    }

    fn connects(&self) -> bool {
        self.kind != VertexKind::Specular
    }

    fn to_light(self) -> TurnDensities<f64> {
        TurnDensities {
            pdf: self.pdf_to_light,
            pdf_reverse: self.pdf_to_sensor,
            measure: self.measure_to_light,
        }
    }

    fn to_sensor(self) -> TurnDensities<f64> {
        TurnDensities {
            pdf: self.pdf_to_sensor,
            pdf_reverse: self.pdf_to_light,
            measure: self.measure_to_sensor,
        }
    }
}

/// Numbers that repeat with the seed.
struct Random(u32);

impl Random {
    fn up_to(&mut self, end: f64) -> f64 {
        self.0 = self.0.wrapping_add(1);
        f64::from(hash::mix(self.0)) / f64::from(u32::MAX) * end
    }

    /// Between 0.1 and 10, evenly by ratio.
    fn density(&mut self) -> f64 {
        10.0_f64.powf(self.up_to(2.0) - 1.0)
    }
}

/// A way to make a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// The sensor path meets the emitter by chance.
    Meet,
    /// The sensor path's last vertex connects to the emitter.
    ConnectEmitter,
    /// The vertex of this index, on the sensor path, connects to the next, on the light path.
    Connect(usize),
    /// The light path's last vertex connects to the sensor.
    ConnectSensor,
    /// Both subpaths reach the vertex of this index.
    Merge(usize),
}

#[derive(Clone, Debug)]
struct Path {
    emitter: EmitterKind,
    sensor: SensorKind,
    /// From the sensor to the emitter, without both; not empty.
    vertices: Vec<Vertex>,
    /// Squared lengths of the segments, that from the sensor first.
    distance2: Vec<f64>,
    /// Probabilities with which paths pass what they cross on the segments.
    chances: Vec<f64>,
    /// Of the sensor's ray: per steradian, or per area where projection is parallel.
    sensor_pdf: f64,
    /// Of the point on the lens, which every strategy draws alike.
    lens_pdf: f64,
    light_paths: f64,
    /// Of starting a light path with it by each of the ways to aim, which start the same one: zero
    /// for those whose balls it does not meet.
    emission_pdfs: [f64; AIMS],
    cos_at_light: f64,
    eta: f64,
}

impl Path {
    fn random(emitter: EmitterKind, sensor: SensorKind, seed: u32) -> Self {
        let random = &mut Random(hash::mix(seed));
        let segments = 2 + random.up_to((SEGMENTS_MAX - 1) as f64) as usize;
        let segments = segments.min(SEGMENTS_MAX);
        Self {
            emitter,
            sensor,
            vertices: (1..segments).map(|_| Vertex::random(random)).collect(),
            distance2: (0..segments).map(|_| random.density()).collect(),
            chances: (0..segments).map(|_| 0.1 + random.up_to(0.9)).collect(),
            sensor_pdf: random.density(),
            lens_pdf: if sensor == SensorKind::Lens { random.density() } else { 1.0 },
            light_paths: random.density(),
            emission_pdfs: std::array::from_fn(|aim| {
                let meets = aim == 0 || random.up_to(1.0) < 0.5;
                if meets { random.density() } else { 0.0 }
            }),
            cos_at_light: if emitter == EmitterKind::Area { random.density() } else { 1.0 },
            eta: random.density(),
        }
    }

    /// Squared length of the segment from the sensor, as far as densities know it.
    fn sensor_distance2(&self) -> f64 {
        match self.sensor {
            SensorKind::Pinhole | SensorKind::Lens => self.distance2[0],
            SensorKind::Parallel => 1.0,
        }
    }

    fn emitter_distance2(&self) -> f64 {
        if self.emitter.finite() { self.distance2[self.vertices.len()] } else { 1.0 }
    }

    // ---- brute force ---------------------------------------------------------------------------

    /// Density of tracing the vertices up to that of index `last` from the sensor, per area or
    /// volume each.
    fn of_sensor_side(&self, last: usize) -> f64 {
        let first = self.vertices[0].measure_to_sensor / self.sensor_distance2();
        let mut density = self.lens_pdf * self.sensor_pdf * first * self.chances[0];
        for index in 1..=last {
            let [from, to] = [self.vertices[index - 1], self.vertices[index]];
            density *= from.pdf_to_light * to.measure_to_sensor / self.distance2[index];
            density *= self.chances[index];
        }
        density
    }

    /// Density of tracing the emitter's point (or direction) and the vertices down to that of
    /// index `last`.
    fn of_emitter_side(&self, last: usize) -> f64 {
        (0..AIMS).map(|aim| self.of_emitter_side_by(aim, last)).sum()
    }

    fn of_emitter_side_by(&self, aim: usize, last: usize) -> f64 {
        let end = self.vertices.len() - 1;
        let measure = self.vertices[end].measure_to_light;
        let mut density = self.emission_pdfs[aim] * measure / self.emitter_distance2();
        density *= self.chances[end + 1];
        for index in (last..end).rev() {
            let [from, to] = [self.vertices[index + 1], self.vertices[index]];
            density *= from.pdf_to_sensor * to.measure_to_light / self.distance2[index + 1];
            density *= self.chances[index + 1];
        }
        density
    }

    /// Density of a way to make the path, times how often an iteration takes it: 0 if it cannot.
    fn density(&self, way: Way) -> f64 {
        let end = self.vertices.len() - 1;
        let connects = |index: usize| self.vertices[index].connects();
        match way {
            Way::Meet if self.emitter.delta() => 0.0,
            Way::Meet => {
                let pdf = self.vertices[end].pdf_to_light;
                let pdf = pdf * self.chances[end + 1];
                self.of_sensor_side(end) * pdf * self.cos_at_light / self.emitter_distance2()
            }
            Way::ConnectEmitter if connects(end) => {
                self.of_sensor_side(end) * self.vertices[end].direct_pdf
            }
            Way::Connect(index) if connects(index) && connects(index + 1) => {
                self.of_sensor_side(index) * self.of_emitter_side(index + 1)
            }
            Way::ConnectSensor if connects(0) => {
                self.light_paths * self.lens_pdf * self.of_emitter_side(0)
            }
            Way::Merge(index) if connects(index) => {
                self.eta * self.of_sensor_side(index) * self.of_emitter_side(index)
            }
            Way::ConnectEmitter | Way::Connect(_) | Way::ConnectSensor | Way::Merge(_) => 0.0,
        }
    }

    fn connecting_ways(&self) -> Vec<Way> {
        let inner = (0..self.vertices.len() - 1).map(Way::Connect);
        [Way::Meet, Way::ConnectEmitter, Way::ConnectSensor].into_iter().chain(inner).collect()
    }

    fn merging_ways(&self) -> Vec<Way> {
        (0..self.vertices.len()).map(Way::Merge).collect()
    }

    // ---- the recursion -------------------------------------------------------------------------

    /// That of the mixture, which is all that the recursion knows.
    fn emission_pdf(&self) -> f64 {
        self.emission_pdfs.iter().sum()
    }

    fn emitter_densities(&self) -> EmitterDensities<f64> {
        let (emission_pdf, cos_at_light) = (self.emission_pdf(), self.cos_at_light);
        let direct_pdf = self.vertices[self.vertices.len() - 1].direct_pdf;
        EmitterDensities { direct_pdf, emission_pdf, cos_at_light }
    }

    /// The emitter as seen from the vertex next to it, its density per steradian there.
    fn emitter_per_steradian(&self) -> EmitterDensities<f64> {
        let emitter = self.emitter_densities();
        let per_area = self.emitter_distance2() / self.cos_at_light;
        EmitterDensities { direct_pdf: emitter.direct_pdf * per_area, ..emitter }
    }

    /// Partial weights on arrival, as the integrators have them that merge nothing.
    fn sensor_weights(&self, last: usize) -> PartialWeights<f64> {
        let start = PartialWeights::from_sensor(self.sensor_pdf, self.light_paths);
        let start = start.pass(self.chances[0]);
        let first = start.arrive(self.sensor_distance2(), self.vertices[0].measure_to_sensor);
        (1..=last).fold(first, |weights, index| {
            let departed = depart(weights, &self.vertices[index - 1], Vertex::to_light);
            let departed = departed.pass(self.chances[index]);
            departed.arrive(self.distance2[index], self.vertices[index].measure_to_sensor)
        })
    }

    fn light_weights(&self, last: usize) -> PartialWeights<f64> {
        let end = self.vertices.len() - 1;
        let delta = self.emitter.delta();
        let start = PartialWeights::from_emitter(self.emission_pdf(), self.cos_at_light, delta);
        let start = start.pass(self.chances[end + 1]);
        let first = start.arrive(self.emitter_distance2(), self.vertices[end].measure_to_light);
        let first = first.beside_choice(self.vertices[end].direct_pdf);
        (last..end).rev().fold(first, |weights, index| {
            let departed = depart(weights, &self.vertices[index + 1], Vertex::to_sensor);
            let departed = departed.pass(self.chances[index + 1]);
            departed.arrive(self.distance2[index + 1], self.vertices[index].measure_to_light)
        })
    }

    /// The same where photons are merged.
    fn sensor_merging(&self, last: usize, factors: MergingFactors<f64>) -> MergingWeights<f64> {
        let start = MergingWeights::from_sensor(self.sensor_pdf, self.light_paths);
        let start = start.pass(self.chances[0]);
        let first = start.arrive(self.sensor_distance2(), self.vertices[0].measure_to_sensor);
        (1..=last).fold(first, |weights, index| {
            let departed =
                depart_merging(weights, &self.vertices[index - 1], Vertex::to_light, factors);
            let departed = departed.pass(self.chances[index]);
            departed.arrive(self.distance2[index], self.vertices[index].measure_to_sensor)
        })
    }

    fn light_merging(&self, last: usize, factors: MergingFactors<f64>) -> MergingWeights<f64> {
        let end = self.vertices.len() - 1;
        let (emission_pdf, cos_at_light) = (self.emission_pdf(), self.cos_at_light);
        let delta = self.emitter.delta();
        let start = MergingWeights::from_emitter(emission_pdf, cos_at_light, delta, factors);
        let start = start.pass(self.chances[end + 1]);
        let first = start.arrive(self.emitter_distance2(), self.vertices[end].measure_to_light);
        let first = first.beside_choice(self.vertices[end].direct_pdf);
        (last..end).rev().fold(first, |weights, index| {
            let departed =
                depart_merging(weights, &self.vertices[index + 1], Vertex::to_sensor, factors);
            let departed = departed.pass(self.chances[index + 1]);
            departed.arrive(self.distance2[index + 1], self.vertices[index].measure_to_light)
        })
    }

    /// Weight of a way by the recursion; with `factors`, photons are merged, too.
    fn weight(&self, way: Way, factors: Option<MergingFactors<f64>>) -> f64 {
        let end = self.vertices.len() - 1;
        let sensor = |index: usize| match factors {
            None => self.sensor_weights(index),
            Some(factors) => self.sensor_merging(index, factors).connecting,
        };
        let light = |index: usize| match factors {
            None => self.light_weights(index),
            Some(factors) => self.light_merging(index, factors).connecting,
        };
        let join = |weights: PartialWeights<f64>, turn| match factors {
            None => End { weights, turn },
            Some(factors) => End { weights: weights.beside_merging(factors.mis_vm), turn },
        };
        let sensor_end = |i: usize| join(sensor(i), self.vertices[i].to_light());
        let light_end = |i: usize| join(light(i), self.vertices[i].to_sensor());
        match way {
            Way::Meet => {
                let vertex = &self.vertices[end];
                let departed = match factors {
                    None => depart(sensor(end), vertex, Vertex::to_light),
                    Some(factors) => {
                        let weights = self.sensor_merging(end, factors);
                        depart_merging(weights, vertex, Vertex::to_light, factors).connecting
                    }
                };
                let distance2 = self.emitter_distance2();
                let departed = departed.pass(self.chances[end + 1]);
                weight_of_emission_met(departed, self.emitter_densities(), distance2)
            }
            Way::ConnectEmitter => {
                let emitter = self.emitter_per_steradian();
                let reachable = if self.emitter.delta() { 0.0 } else { 1.0 };
                let pdf = self.vertices[end].pdf_to_light;
                let chance = chance_over_choice(pdf, reachable, emitter.direct_pdf);
                let weight = weight_of_emitter_connected(sensor_end(end), emitter, chance);
                weight * gain_of_crossing(weight, self.chances[end + 1])
            }
            Way::Connect(index) => {
                let inverse2 = 1.0 / self.distance2[index + 1];
                let ends = (sensor_end(index), light_end(index + 1));
                let weight = weight_of_vertices_connected(ends.0, ends.1, inverse2) / inverse2;
                weight * gain_of_crossing(weight, self.chances[index + 1])
            }
            Way::ConnectSensor => {
                let importance = self.sensor_pdf / self.sensor_distance2() / self.light_paths;
                let weight = weight_of_sensor_connected(light_end(0), importance);
                weight * gain_of_crossing(weight, self.chances[0])
            }
            Way::Merge(index) => {
                let factors = factors.expect("photons are merged");
                let sides =
                    (self.sensor_merging(index, factors), self.light_merging(index, factors));
                let turn = self.vertices[index].to_light();
                weight_of_vertices_merged(sides.0, sides.1, turn, factors)
            }
        }
    }

    /// Compares the weights of all ways that are possible; how many those are.
    fn check(&self, ways: &[Way], factors: Option<MergingFactors<f64>>) -> usize {
        let densities: Vec<f64> = ways.iter().map(|&way| self.density(way)).collect();
        let all: f64 = densities.iter().sum();
        let (mut sum, mut possible) = (0.0, 0);
        for (&way, &density) in ways.iter().zip(&densities).filter(|(_, density)| **density > 0.0) {
            let expected = density / all;
            let found = self.weight(way, factors);
            let error = (found / expected - 1.0).abs();
            assert!(error < TOLERANCE, "{way:?}: {found}, not {expected}, in {self:#?}");
            sum += found;
            possible += 1;
        }
        assert!(possible == 0 || (sum - 1.0_f64).abs() < TOLERANCE, "{sum} in {self:#?}");
        possible
    }
}

fn depart(
    weights: PartialWeights<f64>,
    vertex: &Vertex,
    turn: fn(Vertex) -> TurnDensities<f64>,
) -> PartialWeights<f64> {
    let turn = turn(*vertex);
    match vertex.kind {
        VertexKind::Surface | VertexKind::Medium => weights.depart(turn),
        VertexKind::Specular => weights.depart_specular(turn.measure),
    }
}

fn depart_merging(
    weights: MergingWeights<f64>,
    vertex: &Vertex,
    turn: fn(Vertex) -> TurnDensities<f64>,
    factors: MergingFactors<f64>,
) -> MergingWeights<f64> {
    let turn = turn(*vertex);
    match vertex.kind {
        VertexKind::Surface | VertexKind::Medium => weights.depart(turn, factors),
        VertexKind::Specular => weights.depart_specular(turn.measure),
    }
}

/// Does `work` for many paths of each kind.
fn for_each_path(mut work: impl FnMut(&Path)) {
    let kinds = EMITTERS.into_iter().flat_map(|emitter| SENSORS.map(|sensor| (emitter, sensor)));
    for (kind, (emitter, sensor)) in (0..).zip(kinds) {
        (0..PATHS).for_each(|seed| work(&Path::random(emitter, sensor, kind * PATHS + seed)));
    }
}

/// Compares all weights of many paths; with `factors_of`, photons are merged, too.
fn compare(
    ways_of: impl Fn(&Path) -> Vec<Way>,
    factors_of: impl Fn(&Path) -> Option<MergingFactors<f64>>,
) {
    let (mut ways, mut paths) = (0, 0);
    for_each_path(|path| {
        ways += path.check(&ways_of(path), factors_of(path));
        paths += 1;
    });
    assert!(ways > 2 * paths, "only {ways} ways to make {paths} paths");
}

#[test]
fn connections_weigh_as_all_strategies_one_by_one() {
    compare(Path::connecting_ways, |_| None);
}

#[test]
fn connections_and_merging_weigh_as_all_strategies_one_by_one() {
    let all = |path: &Path| [path.connecting_ways(), path.merging_ways()].concat();
    compare(all, |path| Some(MergingFactors::both(path.eta)));
}

#[test]
fn merging_alone_weighs_as_all_vertices_one_by_one() {
    compare(Path::merging_ways, |_| Some(MergingFactors::merging_only()));
}

#[test]
fn nothing_merged_leaves_the_weights_of_connections() {
    // An eta of zero, whatever merging would be worth.
    let factors = MergingFactors { mis_vc: 3.0, mis_vm: 0.0 };
    compare(Path::connecting_ways, |_| Some(factors));
}

/// Why merging beside connections needs no column for dVM.
#[test]
fn beside_connections_d_vm_is_d_vc_over_eta() {
    for_each_path(|path| {
        let factors = MergingFactors::both(path.eta);
        for index in 0..path.vertices.len() {
            let sides = [path.sensor_merging(index, factors), path.light_merging(index, factors)];
            for MergingWeights { connecting, d_vm } in sides {
                let difference = (d_vm - connecting.d_vc / path.eta).abs();
                assert!(difference <= TOLERANCE * d_vm, "{d_vm} in {path:#?}");
            }
        }
    });
}

/// Two ways only: to meet the emitter, or to connect to it.
#[test]
fn the_power_heuristic_weighs_chance_against_choice() {
    for_each_path(|path| {
        let vertex = path.vertices[path.vertices.len() - 1];
        let [meet, connect] = [Way::Meet, Way::ConnectEmitter].map(|way| path.density(way));
        let pdf_w = if vertex.connects() { vertex.pdf_to_light } else { f64::INFINITY };
        let distance2 = path.emitter_distance2();
        let crossed = path.chances[path.vertices.len()];
        let pdf_w = pdf_w * crossed;
        let met = power_of_emission_met(pdf_w, path.emitter_densities(), distance2);
        let reachable = if path.emitter.delta() { 0.0 } else { 1.0 };
        let direct_pdf_w = path.emitter_per_steradian().direct_pdf;
        let chance = chance_over_choice(vertex.pdf_to_light, reachable, direct_pdf_w);
        let weight = power_of_emitter_connected(chance);
        let connected = weight * gain_of_crossing(weight, crossed * crossed);
        let all = meet * meet + connect * connect;
        let mut sum = 0.0;
        for (density, found) in [(meet, met), (connect, connected)] {
            if density > 0.0 {
                let expected = density * density / all;
                assert!((found / expected - 1.0).abs() < TOLERANCE, "{found} in {path:#?}");
                sum += found;
            }
        }
        assert!(all == 0.0 || (sum - 1.0).abs() < TOLERANCE, "{sum} in {path:#?}");
    });
}

/// Paths of one segment: two ways, where starts of light paths are connected to the sensor.
#[test]
fn starts_connected_weigh_against_emission_met() {
    for_each_path(|path| {
        if path.emitter != EmitterKind::Area {
            return;
        }
        let (start_pdf, distance2) = (path.eta, path.emitter_distance2());
        let sensor_distance2 = if path.sensor == SensorKind::Parallel { 1.0 } else { distance2 };
        let (crossed, cosine) = (path.chances[0], path.cos_at_light);
        let meet = crossed * path.sensor_pdf * cosine / sensor_distance2;
        let connect = path.light_paths * start_pdf;
        let sensor = PartialWeights::from_sensor(path.sensor_pdf, path.light_paths).pass(crossed);
        let densities =
            EmitterDensities { direct_pdf: start_pdf, emission_pdf: 0.0, cos_at_light: cosine };
        let met = weight_of_emission_met(sensor, densities, sensor_distance2);
        let importance = path.sensor_pdf / sensor_distance2 / path.light_paths;
        let weight = weight_of_start_connected(start_pdf, cosine, importance);
        let connected = weight * gain_of_crossing(weight, crossed);
        for (density, found) in [(meet, met), (connect, connected)] {
            let expected = density / (meet + connect);
            assert!((found / expected - 1.0).abs() < TOLERANCE, "{found} in {path:#?}");
        }
    });
}
