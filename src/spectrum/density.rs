//! How densely wavelengths are chosen over the range that a film responds to.

use super::Responses;

/// Share of the wavelengths that are chosen by the responses alone: where little is emitted, some
/// are chosen too.
const BY_RESPONSE: f64 = 0.125;
/// Least distance at which responses and emission are looked at, in nanometers, and the most steps.
const STEP_NM: f64 = 1.0;
const STEPS_MAX: f64 = 4096.0;

/// A density over wavelengths, linear between nodes, that integrates to one.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    segments: Vec<Segment>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    /// Its ends in nanometers.
    ends_nm: [f64; 2],
    /// The density at both, per nanometer.
    values: [f64; 2],
    /// What has been integrated before it, and with it.
    sums: [f64; 2],
}

impl Segment {
    fn width(&self) -> f64 {
        self.ends_nm[1] - self.ends_nm[0]
    }
}

/// The wavelengths in nanometers at which a spectrum of emission is to be known: in order, from the
/// first to the last of `range_nm` that the film responds to, with all at which responses bend and
/// all `knots` of what is emitted. None if it responds to none of them.
pub fn nodes_nm(
    responses: &Responses,
    range_nm: [f32; 2],
    knots: impl Iterator<Item = f32>,
) -> Vec<f64> {
    let [least, most] = range_nm.map(f64::from);
    let is_within = |nm: &f64| (least..=most).contains(nm);
    let steps = ((most - least) / STEP_NM).ceil().clamp(1.0, STEPS_MAX);
    let even = (0..=steps as u32).map(|step| least + (most - least) * f64::from(step) / steps);
    let mut nodes: Vec<f64> =
        (even.chain(responses.nodes_nm())).chain(knots.map(f64::from)).filter(is_within).collect();
    nodes.sort_by(f64::total_cmp);
    nodes.dedup();
    let responds = |pair: &[f64]| is_lit(responses, [pair[0], pair[1]]);
    let first = nodes.windows(2).position(responds);
    let last = nodes.windows(2).rposition(responds);
    match (first, last) {
        (Some(first), Some(last)) => nodes[first..=last + 1].to_vec(),
        _ => Vec::new(),
    }
}

/// Whether a film responds to light between two neighboring nodes.
fn is_lit(responses: &Responses, [from, to]: [f64; 2]) -> bool {
    responses.size_at(from) > 0.0 || responses.size_before(to) > 0.0
}

/// The integral of the size of the responses times a spectrum, of which `values` are those at the
/// `nodes`.
pub fn integral(responses: &Responses, nodes: &[f64], values: &[f64]) -> f64 {
    let pairs = nodes.windows(2).zip(values.windows(2));
    let area = |(ends, values): (&[f64], &[f64])| {
        let [from, to] = [responses.size_at(ends[0]), responses.size_before(ends[1])];
        0.5 * (ends[1] - ends[0]) * (from * values[0] + to * values[1])
    };
    pairs.map(area).sum()
}

impl Density {
    /// In proportion of the size of the responses times what is `emitted` at the nodes, but for a
    /// share that goes by the responses alone. Nodes are those of [`nodes_nm`], two at least.
    pub fn new(responses: &Responses, nodes: &[f64], emitted: &[f64]) -> Self {
        let ones = vec![1.0; nodes.len()];
        let [all, plain] = [emitted, &ones].map(|values| integral(responses, nodes, values));
        let by_emission = if all > 0.0 { (1.0 - BY_RESPONSE) / all } else { 0.0 };
        let by_response = if all > 0.0 { BY_RESPONSE } else { 1.0 } / plain;
        let value = |size: f64, emitted: f64| size * (by_emission * emitted + by_response);
        let mut sum = 0.0;
        let mut segment = |(ends, emitted): (&[f64], &[f64])| {
            let from = value(responses.size_at(ends[0]), emitted[0]);
            let to = value(responses.size_before(ends[1]), emitted[1]);
            let before = sum;
            sum += 0.5 * (ends[1] - ends[0]) * (from + to);
            let (ends_nm, sums) = ([ends[0], ends[1]], [before, sum]);
            Segment { ends_nm, values: [from, to], sums }
        };
        let pairs = nodes.windows(2).zip(emitted.windows(2));
        let mut segments: Vec<Segment> = pairs.map(&mut segment).collect();
        // Rounding alone keeps the sum from one.
        for Segment { values, sums, .. } in &mut segments {
            values.iter_mut().chain(sums).for_each(|number| *number /= sum);
        }
        segments.retain(|segment| segment.sums[1] > segment.sums[0]);
        Self { segments }
    }

    /// The value per nanometer at a wavelength in nanometers: greater than zero where a film
    /// responds, up to the last wavelength and with it, to which others may be rounded.
    pub fn at(&self, nm: f64) -> f64 {
        let last = self.segments.len() - 1;
        let index = self.segments.partition_point(|segment| segment.ends_nm[1] <= nm).min(last);
        let segment = &self.segments[index];
        let share = (nm - segment.ends_nm[0]) / segment.width();
        let [from, to] = segment.values;
        if (0.0..=1.0).contains(&share) { from * (1.0 - share) + to * share } else { 0.0 }
    }

    /// The means of functions of the wavelength, so many of them, over all that is chosen: within a
    /// segment they are taken to be cubic.
    pub fn means(&self, count: usize, values_at: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
        // The rule of Gauss and Legendre with two points.
        let off = 1.0 / 3.0_f64.sqrt();
        let mut means = vec![0.0; count];
        for segment in &self.segments {
            for part in [0.5 - 0.5 * off, 0.5 + 0.5 * off] {
                let [from, to] = segment.values;
                let weight = 0.5 * segment.width() * (from * (1.0 - part) + to * part);
                let values = values_at(segment.ends_nm[0] + segment.width() * part);
                means.iter_mut().zip(values).for_each(|(mean, value)| *mean += weight * value);
            }
        }
        means
    }

    /// The wavelength in nanometers below which a share lies, within [0, 1), of all.
    pub fn inverse(&self, share: f64) -> f64 {
        let last = self.segments.len() - 1;
        let index = self.segments.partition_point(|segment| segment.sums[1] <= share).min(last);
        let segment = &self.segments[index];
        let [from, to] = segment.values;
        // The area up to a part t of the width w is w t (from + (to - from) t / 2).
        let area = (share - segment.sums[0]).max(0.0) / segment.width();
        let root = (from * from + 2.0 * (to - from) * area).max(0.0).sqrt();
        let part = if area > 0.0 { 2.0 * area / (from + root) } else { 0.0 };
        segment.ends_nm[0] + segment.width() * part.min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{Band, Bands, Response};

    fn bands(first: f32, last: f32, count: usize) -> Responses {
        let bands = Bands::evenly(first, last, count).unwrap();
        Responses::of_bands(&bands)
    }

    /// A line of 2 nm on a faint floor, which has nearly all of the emission.
    fn line(nm: f64) -> f64 {
        0.01 + if (588.0..=590.0).contains(&nm) { 50.0 } else { 0.0 }
    }

    #[test]
    fn even_responses_and_emission_are_chosen_evenly() {
        let responses = bands(400.0, 700.0, 31);
        let nodes = nodes_nm(&responses, [380.0, 780.0], std::iter::empty());
        assert!((nodes[0] - 395.0).abs() < 1e-4 && (nodes[nodes.len() - 1] - 705.0).abs() < 1e-4);
        let density = Density::new(&responses, &nodes, &vec![2.0; nodes.len()]);
        for share in [0.0, 0.1, 0.5, 0.99, 1.0 - 1e-12] {
            let nm = density.inverse(share);
            assert!((nm - (395.0 + 310.0 * share)).abs() < 1e-3, "{share}: {nm}");
            assert!((density.at(nm) * 310.0 - 1.0).abs() < 1e-4, "{nm}");
        }
    }

    #[test]
    fn the_inverse_goes_back_through_lines_and_slopes() {
        let slopes = vec![[400.0, 0.0], [500.0, 2.0], [500.0, 0.5], [700.0, -1.0]];
        let responses = Responses::new(vec![Response::new(slopes).unwrap()]);
        let knots = [587.9, 588.0, 590.0, 590.1];
        let nodes = nodes_nm(&responses, [380.0, 780.0], knots.into_iter());
        let emitted: Vec<f64> = nodes.iter().map(|nm| line(*nm)).collect();
        let density = Density::new(&responses, &nodes, &emitted);
        // The integral up to the inverse of a share is that share.
        let (mut integral, mut before) = (0.0, density.inverse(0.0));
        const STEPS: u32 = 20_000;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS + 1);
            let nm = density.inverse(share);
            assert!(nm >= before, "{share}: {nm} after {before}");
            integral += density.at(0.5 * (nm + before)) * (nm - before);
            assert!((integral - share).abs() < 1e-3, "{share}: {integral}");
            before = nm;
        }
        let in_line = (0..1000).filter(|it| line(density.inverse(f64::from(*it) / 1e3)) > 1.0);
        assert!(in_line.count() > 500);
    }

    /// Single precision may round a wavelength to the end of the range, where a band goes on.
    #[test]
    fn the_last_wavelength_has_the_density_before_it() {
        let responses = bands(400.0, 700.0, 31);
        let nodes = nodes_nm(&responses, [400.0, 687.5], std::iter::empty());
        let density = Density::new(&responses, &nodes, &vec![1.0; nodes.len()]);
        let last = nodes[nodes.len() - 1];
        assert_eq!((nodes[0], last), (400.0, 687.5));
        for nm in [400.0, last - 1e-9, last] {
            assert!((density.at(nm) * 287.5 - 1.0).abs() < 1e-9, "{nm}");
        }
        assert_eq!((density.at(399.9), density.at(last + 1e-9)), (0.0, 0.0));
    }

    #[test]
    fn nothing_is_chosen_where_no_channel_responds() {
        let list = [Band::new(450.0, 2.0), Band::new(650.0, 20.0)];
        let bands = Bands::new(list.to_vec()).unwrap();
        let responses = Responses::of_bands(&bands);
        let nodes = nodes_nm(&responses, [380.0, 780.0], std::iter::empty());
        let density = Density::new(&responses, &nodes, &vec![0.0; nodes.len()]);
        assert_eq!(
            (density.at(449.0 - 1e-9), density.at(500.0), density.at(660.0 + 1e-9)),
            (0.0, 0.0, 0.0)
        );
        // As many in the narrow one as in the broad one.
        let narrow = (0..1000).filter(|it| density.inverse(f64::from(*it) / 1e3) < 500.0).count();
        assert!((499..=501).contains(&narrow), "{narrow}");
        assert!(nodes_nm(&responses, [460.0, 500.0], std::iter::empty()).is_empty());
    }
}
