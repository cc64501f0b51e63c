//! Limits that noise seldom exceeds, medians, and slopes.

use super::elementary::{exp, ln};
use serde::Serialize;

/// An interval that holds a median with some chance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// The chance, if the values are independent and of one distribution, whichever that is.
    pub coverage: f64,
}

/// The median; of an even number, the mean of the two in the middle. Zero of nothing.
pub fn median(values: &[f64]) -> f64 {
    let sorted = sorted(values);
    match sorted.len() {
        0 => 0.0,
        len => 0.5 * (sorted[(len - 1) / 2] + sorted[len / 2]),
    }
}

/// The interval between two order statistics, as far inwards as the wanted coverage allows, that
/// holds the median of the distribution that the values come from; from the least to the greatest
/// where these are too few for it. None of less than two values.
///
/// The median lies below the value of rank `j` (from 0) if at most `j` of `n` values lie below
/// the median, which is as likely as at most `j` heads of `n` coins.
pub fn median_interval(values: &[f64], coverage: f64) -> Option<Interval> {
    let sorted = sorted(values);
    let count = sorted.len();
    let mut found = None;
    let (mut ln_chance, mut tail) = (-(count as f64) * std::f64::consts::LN_2, 0.0);
    for rank in 0..count / 2 {
        tail += exp(ln_chance);
        ln_chance += ln((count - rank) as f64 / (rank + 1) as f64);
        let (low, high) = (sorted[rank], sorted[count - 1 - rank]);
        let interval = Interval { low, high, coverage: 1.0 - 2.0 * tail };
        if found.is_some() && interval.coverage < coverage {
            break;
        }
        found = Some(interval);
    }
    found
}

/// A line through points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Its slope.
    pub slope: f64,
    /// The standard error of the slope, from what the points are off the line; nothing of two.
    pub standard_error: Option<f64>,
}

/// The line of least squares through the logarithms of points; points that have none are left out.
/// None through less than two different places.
pub fn log_log_fit(points: &[(f64, f64)]) -> Option<Fit> {
    let has_logarithms = |(x, y): &&(f64, f64)| *x > 0.0 && *y > 0.0;
    let logarithms: Vec<(f64, f64)> =
        points.iter().filter(has_logarithms).map(|(x, y)| (ln(*x), ln(*y))).collect();
    if logarithms.windows(2).all(|pair| pair[0].0 == pair[1].0) {
        return None;
    }
    let count = logarithms.len() as f64;
    let sum = |of: &dyn Fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>();
    let (mean_x, mean_y) = (sum(&|p| p.0) / count, sum(&|p| p.1) / count);
    let squares = sum(&|p| (p.0 - mean_x).powi(2));
    let slope = sum(&|p| (p.0 - mean_x) * (p.1 - mean_y)) / squares;
    let residuals = sum(&|p| (p.1 - mean_y - slope * (p.0 - mean_x)).powi(2));
    let standard_error = (count > 2.0).then(|| (residuals / (count - 2.0) / squares).sqrt());
    Some(Fit { slope, standard_error })
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// What the root mean square of `count` independent standard normal numbers exceeds with the given
/// chance: the quantile of chi square after Wilson and Hilferty 1931.
pub fn chi_square_limit(count: usize, chance: f64) -> f64 {
    let ninth = 2.0 / (9.0 * count.max(1) as f64);
    (1.0 - ninth + normal_limit(chance) * ninth.sqrt()).powi(3).sqrt()
}

/// What the largest absolute value of `count` standard normal numbers exceeds with at most the
/// given chance, whether they are independent or not.
pub fn maximum_limit(count: usize, chance: f64) -> f64 {
    normal_limit(chance / (2.0 * count.max(1) as f64))
}

/// What a standard normal number exceeds with the given chance, by bisection.
fn normal_limit(chance: f64) -> f64 {
    let (mut low, mut high) = (0.0_f64, 40.0_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if normal_tail(middle) > chance {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The chance that a standard normal number exceeds `z >= 0`: the continued fraction of Laplace
/// where it converges fast, the series about zero elsewhere.
fn normal_tail(z: f64) -> f64 {
    let density = exp(-0.5 * z * z) / std::f64::consts::TAU.sqrt();
    if z > 3.0 {
        let fraction = (1..=60).rev().fold(z, |below, k| z + f64::from(k) / below);
        return density / fraction;
    }
    let (mut term, mut sum) = (z, z);
    for k in 1..60 {
        term *= z * z / (2.0 * f64::from(k) + 1.0);
        sum += term;
    }
    0.5 - density * sum
}

#[cfg(test)]
mod tests {
    use super::{chi_square_limit, maximum_limit, normal_limit, normal_tail};
    use super::{log_log_fit, median, median_interval};

    /// The coverages are sums of binomial coefficients over powers of two.
    #[test]
    fn medians_lie_between_the_order_statistics_of_the_sign_test() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median_interval(&[1.0], 0.95), None);
        let cases = [(2, 0, 0.5), (5, 0, 0.9375), (8, 0, 0.992_187_5), (9, 1, 0.960_937_5)];
        for (count, rank, coverage) in cases {
            let values: Vec<f64> = (0..count).rev().map(f64::from).collect();
            let interval = median_interval(&values, 0.95).expect("two values or more");
            assert_eq!(
                (interval.low, interval.high),
                (f64::from(rank), f64::from(count - 1 - rank))
            );
            assert!((interval.coverage - coverage).abs() < 1e-12, "{count}: {interval:?}");
        }
        let many: Vec<f64> = (0..4000).map(f64::from).collect();
        let interval = median_interval(&many, 0.95).expect("two values or more");
        assert!((interval.low - 1937.0).abs() < 2.0, "{interval:?}");
        assert!(interval.coverage >= 0.95 && interval.coverage < 0.952, "{interval:?}");
    }

    #[test]
    fn slopes_are_those_of_powers() {
        let power = |x: f64| (x, 3.0 * x.powf(-1.5));
        let fit = log_log_fit(&[1.0, 2.0, 7.0, 100.0].map(power)).expect("four places");
        assert!((fit.slope + 1.5).abs() < 1e-12, "{fit:?}");
        assert!(fit.standard_error.expect("four points") < 1e-12, "{fit:?}");
        // Logarithms 0, 1, 2 and 0, 0, 3: slope 3/2, residuals 1/2, -1, 1/2.
        let [e, e2, e3] = [1, 2, 3].map(|power| std::f64::consts::E.powi(power));
        let fit = log_log_fit(&[(1.0, 1.0), (e, 1.0), (e2, e3)]).expect("three places");
        assert!((fit.slope - 1.5).abs() < 1e-12, "{fit:?}");
        assert!((fit.standard_error.expect("three points") - 0.75_f64.sqrt()).abs() < 1e-12);
        let two = log_log_fit(&[(1.0, 1.0), (2.0, 2.0), (4.0, 0.0)]).expect("two places");
        assert!((two.slope - 1.0).abs() < 1e-12 && two.standard_error.is_none(), "{two:?}");
        assert_eq!(log_log_fit(&[(2.0, 1.0), (2.0, 2.0)]), None);
        assert_eq!(log_log_fit(&[]), None);
    }

    #[test]
    fn normal_tails_are_the_tabulated_ones() {
        let table = [(0.0, 0.5), (1.0, 0.158_655_254), (3.0, 1.349_898e-3), (6.0, 9.865_88e-10)];
        for (z, tail) in table {
            assert!((normal_tail(z) / tail - 1.0).abs() < 1e-6, "{z}");
        }
        assert!((normal_limit(1e-3) - 3.090_232).abs() < 1e-5);
        assert!((maximum_limit(1, 0.05) - 1.959_964).abs() < 1e-5);
        // The 0.999 quantile of chi square with 100 degrees of freedom is 149.449.
        assert!((chi_square_limit(100, 1e-3) - 1.494_49_f64.sqrt()).abs() < 1e-3);
    }
}
