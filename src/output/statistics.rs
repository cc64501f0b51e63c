//! Limits that noise seldom exceeds.

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
    let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
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
