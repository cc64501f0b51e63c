//! Reflection by the electric field, in double precision: what Stokes vectors are compared with.

/// A complex number.
#[derive(Clone, Copy)]
struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn times(self, other: Self) -> Self {
        let re = self.re * other.re - self.im * other.im;
        Self { re, im: self.re * other.im + self.im * other.re }
    }

    fn over(self, other: Self) -> Self {
        let norm = other.re * other.re + other.im * other.im;
        let Self { re, im } = self.times(Self { re: other.re, im: -other.im });
        Self { re: re / norm, im: im / norm }
    }

    fn plus(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }

    fn minus(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    /// The root below the real axis, where waves fade inwards.
    fn root(self) -> Self {
        let (length, angle) = (self.re.hypot(self.im), self.im.atan2(self.re));
        let (im, re) = (0.5 * angle).sin_cos();
        let root = Self { re: re * length.sqrt(), im: im * length.sqrt() };
        if root.im > 0.0 { Self { re: -root.re, im: -root.im } } else { root }
    }
}

fn real(re: f64) -> Complex {
    Complex { re, im: 0.0 }
}

/// The Stokes vector of wholly polarized light of intensity 1 after reflection, by its electric
/// field: along s = x, and along p = k cross x (Born and Wolf, 1.5.2, and 14.2; Verdet's sign).
pub fn reflected([s1, s2, s3]: [f64; 3], cos_i: f64, eta: f64, k: f64) -> [f64; 4] {
    let square = Complex { re: eta * eta - k * k, im: -2.0 * eta * k };
    let below = square.minus(real(1.0 - cos_i * cos_i)).root();
    let r_s = real(cos_i).minus(below).over(real(cos_i).plus(below));
    let straight = square.times(real(cos_i));
    let r_p = straight.minus(below).over(straight.plus(below));
    // Ex is real; S2 - i S3 = 2 Ex Ey* = 2 Ex conj(Ey).
    let along = (0.5 * (1.0 + s1)).sqrt();
    let (e_x, e_y) = if along > 1e-9 {
        (real(along), Complex { re: 0.5 * s2 / along, im: 0.5 * s3 / along })
    } else {
        (real(0.0), real(1.0))
    };
    let (e_x, e_y) = (e_x.times(r_s), e_y.times(r_p));
    let [x2, y2] = [e_x, e_y].map(|e| e.re * e.re + e.im * e.im);
    let cross = e_x.times(Complex { re: e_y.re, im: -e_y.im });
    [x2 + y2, x2 - y2, 2.0 * cross.re, -2.0 * cross.im]
}
